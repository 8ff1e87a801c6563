//! Newton's method on `min(z, w) = 0`, one problem per lane: guess the support `alpha`, solve
//! `A_aa z_a = -q_a`, correct the guess by the signs of z and w, until it stays. [CPS92, sec. 5.8], [HIK03]
//!
//! For P-matrices this is block principal pivoting; it ends after a few factorisations on almost every problem with a
//! positive (semi)definite matrix and may cycle on others. Lanes that do not end here go on to Lemke's method.
//! A pivot that rounding made smaller than `FLOOR` times its diagonal entry is raised to that, which regularises
//! singular blocks; the error it leaves is removed by refinement, and `verify` has the last word.

use super::ahead::Ahead;
use crate::small::lane::{Lane, Mask};
use crate::small::lemke::CANCELLED;

/// Smallest pivot, relative to the diagonal entry it started from.
pub const FLOOR: f64 = 1e-9;

/// Largest order at which masking the rows outside the support is cheaper than leaving them out.
const MASKED_ORDER: usize = 16;

/// A negative w_i smaller than this many spacings of `max|q|` is left alone: rounding, in a degenerate row.
const NOISE: f64 = 64.0;

/// The numbers of several problems of order n, lane by lane, and the memory that solving them takes.
pub struct Tile<X: Lane> {
    /// `A`, row-major.
    pub a: Vec<X>,
    /// `q`.
    pub q: Vec<X>,
    /// `z`.
    pub z: Vec<X>,
    /// `w = A z + q`.
    pub w: Vec<X>,
    /// Rows with `w_i = 0` in the guess.
    pub alpha: Vec<X::Mask>,
    /// What is needed next.
    pub ahead: Ahead,
    block: Block<X>,
}

/// The system `A_aa z_a = -q_a`, of the order of the largest support among the lanes, identity beyond a lane's own.
struct Block<X: Lane> {
    size: usize,
    a: Vec<X>,
    q: Vec<X>,
    inside: Vec<X::Mask>,
    /// The place in the problem of each row, n beyond the support.
    places: Vec<X>,
    /// `L` (lower triangle), unit `U` (upper triangle) and the right-hand side (last column).
    factors: Vec<X>,
    /// `1 / L_jj`.
    inverse: Vec<X>,
    /// A right-hand side or a solution.
    x: Vec<X>,
    /// z, and room for what is nobody's.
    z: Vec<X>,
}

impl<X: Lane> Tile<X> {
    /// Memory for problems of order `n`.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let (vector, zero) = (vec![X::splat(0.0); n], X::splat(0.0));
        Self {
            a: vec![zero; n * n],
            q: vector.clone(),
            z: vector.clone(),
            w: vector.clone(),
            alpha: vec![X::Mask::NONE; n],
            ahead: Ahead::default(),
            block: Block {
                size: 0,
                a: vec![zero; n * n],
                q: vector.clone(),
                inside: vec![X::Mask::NONE; n],
                places: vec![zero; n + 1],
                factors: vec![zero; n * (n + 1)],
                inverse: vector.clone(),
                x: vector,
                z: vec![zero; n + 1],
            },
        }
    }
}

/// Iterates from the guess in `tile.alpha` until no lane of `lanes` changes its mind, at most `limit` times, and
/// returns the factorisations, lane by lane, and the lanes whose answer is worth verifying. O(n^3) each.
///
/// `N` is the order when it is known at compile time, else 0.
#[inline(always)]
pub fn newton<X: Lane, const N: usize>(
    n: usize,
    tile: &mut Tile<X>,
    mut lanes: X::Mask,
    symmetric: bool,
    limit: usize,
) -> ([u8; 16], X::Mask) {
    let n = if N == 0 { n } else { N };
    let mut iterations = [0; 16];
    let mut unsettled = lanes;
    for _ in 0..limit {
        let regular = solve::<X, N>(n, tile, symmetric, limit == 1);
        multiply::<X, N>(n, tile);
        for l in 0..X::LANES {
            iterations[l] += u8::from(unsettled.get(l));
        }
        unsettled = improve_guess::<X, N>(n, tile).and(lanes);
        if limit > 1 && !is_masked::<N>(n) {
            // The larger a singular block, the longer the way from it: Lemke's method is faster. What such lanes find
            // later is not looked at: when they stop is their neighbours' affair.
            lanes = lanes.and(regular);
            unsettled = unsettled.and(regular);
        }
        if !unsettled.any() {
            break;
        }
    }
    (iterations, lanes)
}

/// The next guess: `z_i > 0` stays in, `w_i < 0` comes in, except for `NOISE`. Returns the lanes that changed.
#[inline(always)]
fn improve_guess<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>) -> X::Mask {
    let n = if N == 0 { n } else { N };
    let zero = X::splat(0.0);
    let (alpha, z, w) = (&mut tile.alpha[..n], &tile.z[..n], &tile.w[..n]);
    let mut largest_q = zero;
    for q in &tile.q[..n] {
        largest_q = q.abs().max(largest_q);
    }
    let negative = largest_q.mul(X::splat(-NOISE * X::EPS));
    let mut changed = X::Mask::NONE;
    for i in 0..n {
        let next = alpha[i].choose(zero.lt(z[i]), w[i].lt(negative));
        changed = changed.or(next.xor(alpha[i]));
        alpha[i] = next;
    }
    changed
}

/// `z_a = -A_aa^-1 q_a`, 0 elsewhere and, if `cleaned`, where it is rounding error. Returns the lanes in which no pivot
/// was raised.
#[inline(always)]
fn solve<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>, symmetric: bool, cleaned: bool) -> X::Mask {
    let n = if N == 0 { n } else { N };
    let Tile { a, q, z, alpha, ahead, block, .. } = tile;
    if is_masked::<N>(n) {
        let Block { factors, inverse, .. } = block;
        let regular = factor::<X, N>(n, a, q, alpha, factors, inverse, symmetric, ahead);
        substitute_back::<X, N>(n, factors, z);
        if cleaned {
            clean::<X, N>(n, q, alpha, factors, inverse, z);
        }
        return regular;
    }
    block.gather(n, a, q, alpha);
    let size = block.size;
    let Block { a, q, inside, factors, inverse, x, .. } = block;
    let regular = factor::<X, 0>(size, a, q, inside, factors, inverse, symmetric, ahead);
    substitute_back::<X, 0>(size, factors, x);
    if cleaned {
        clean::<X, 0>(size, q, inside, factors, inverse, x);
    }
    block.scatter();
    z[..n].copy_from_slice(&block.z[..n]);
    regular
}

/// Whether the whole matrix is factored, rows outside the support masked.
#[inline(always)]
fn is_masked<const N: usize>(n: usize) -> bool {
    N > 0 || n <= MASKED_ORDER
}

impl<X: Lane> Block<X> {
    /// Takes the rows and columns of each lane's support.
    #[inline(always)]
    fn gather(&mut self, n: usize, a: &[X], q: &[X], alpha: &[X::Mask]) {
        let mut size = 0;
        for l in 0..X::LANES {
            let mut m = 0;
            for i in 0..n {
                self.places[m].set_from(l, &X::splat(i as f64));
                m += usize::from(alpha[i].get(l));
            }
            size = m.max(size);
            for place in &mut self.places[m..n] {
                place.set_from(l, &X::splat(n as f64));
            }
        }
        self.size = size;
        let order = X::splat(n as f64);
        for i in 0..size {
            self.inside[i] = self.places[i].lt(order);
            self.q[i] = X::pick(q, self.places[i].index(n, 1));
        }
        for i in 0..size {
            let row = self.places[i].mul(order);
            for j in 0..size {
                self.a[i * size + j] = X::pick(a, row.add(self.places[j]).index(n * n, 1));
            }
        }
    }

    /// Puts x in its places in z.
    #[inline(always)]
    fn scatter(&mut self) {
        self.z.fill(X::splat(0.0));
        for i in 0..self.size {
            // Rows beyond a lane's support may have changed the sign of a zero: there is only one zero after this.
            let x = self.x[i].add(X::splat(0.0));
            for l in 0..X::LANES {
                self.z[self.places[i].get(l) as usize].set_from(l, &x);
            }
        }
    }
}

/// Crout's `L U` of the block `A_aa`, in place among the identity on the other rows and columns, with the
/// right-hand side `-q_a` carried along as column n. Returns the lanes in which no pivot was raised.
#[inline(always)]
fn factor<X: Lane, const N: usize>(
    n: usize,
    a: &[X],
    q: &[X],
    alpha: &[X::Mask],
    factors: &mut [X],
    inverse: &mut [X],
    symmetric: bool,
    ahead: &mut Ahead,
) -> X::Mask {
    let n = if N == 0 { n } else { N };
    let s = n + 1;
    let (a, q, alpha) = (&a[..n * n], &q[..n], &alpha[..n]);
    let (f, inverse) = (&mut factors[..n * s], &mut inverse[..n]);
    let (one, floor) = (X::splat(1.0), X::splat(FLOOR));
    let mut regular = X::Mask::ALL;
    for j in 0..n {
        ahead.step();
        let inside = alpha[j];
        // Column j of L, from the diagonal down.
        let mut i = j;
        while i + 4 <= n {
            let mut sum = [X::splat(0.0); 4];
            for r in 0..4 {
                sum[r] = a[(i + r) * n + j].only(inside.and(alpha[i + r]));
            }
            for k in 0..j {
                let u = f[k * s + j];
                for r in 0..4 {
                    sum[r] = sum[r].sub_product(f[(i + r) * s + k], u);
                }
            }
            for r in 0..4 {
                f[(i + r) * s + j] = sum[r];
            }
            i += 4;
        }
        while i < n {
            let mut sum = a[i * n + j].only(inside.and(alpha[i]));
            for k in 0..j {
                sum = sum.sub_product(f[i * s + k], f[k * s + j]);
            }
            f[i * s + j] = sum;
            i += 1;
        }
        let least = a[j * n + j].abs().mul(floor);
        regular = regular.and(least.le(f[j * s + j]).or(inside.not()));
        let pivot = f[j * s + j].max(least).or_else(inside, one);
        let reciprocal = one.div(pivot);
        f[j * s + j] = pivot;
        inverse[j] = reciprocal;
        // Row j of U, right of the diagonal.
        if symmetric {
            for i in j + 1..n {
                f[j * s + i] = f[i * s + j].mul(reciprocal);
            }
        } else {
            let mut i = j + 1;
            while i + 4 <= n {
                let mut sum = [X::splat(0.0); 4];
                for r in 0..4 {
                    sum[r] = a[j * n + i + r].only(inside.and(alpha[i + r]));
                }
                for k in 0..j {
                    let l = f[j * s + k];
                    for r in 0..4 {
                        sum[r] = sum[r].sub_product(l, f[k * s + i + r]);
                    }
                }
                for r in 0..4 {
                    f[j * s + i + r] = sum[r].mul(reciprocal);
                }
                i += 4;
            }
            while i < n {
                let mut sum = a[j * n + i].only(inside.and(alpha[i]));
                for k in 0..j {
                    sum = sum.sub_product(f[j * s + k], f[k * s + i]);
                }
                f[j * s + i] = sum.mul(reciprocal);
                i += 1;
            }
        }
        let mut sum = q[j].neg().only(inside);
        for k in 0..j {
            sum = sum.sub_product(f[j * s + k], f[k * s + n]);
        }
        f[j * s + n] = sum.mul(reciprocal);
    }
    regular
}

/// `z = U^-1 y` with `y` in the last column of the factors.
#[inline(always)]
fn substitute_back<X: Lane, const N: usize>(n: usize, factors: &[X], z: &mut [X]) {
    let n = if N == 0 { n } else { N };
    let s = n + 1;
    let (f, z) = (&factors[..n * s], &mut z[..n]);
    for i in 0..n {
        z[i] = f[i * s + n];
    }
    for i in (1..n).rev() {
        let x = z[i];
        for k in 0..i {
            z[k] = z[k].sub_product(f[k * s + i], x);
        }
    }
}

/// Sets to zero what is not larger than the rounding errors of the two substitutions it came from: degenerate rows of a
/// guessed support, in which anything else is a wrong w. O(n^2).
#[inline(always)]
fn clean<X: Lane, const N: usize>(n: usize, q: &[X], alpha: &[X::Mask], factors: &[X], inverse: &[X], z: &mut [X]) {
    let n = if N == 0 { n } else { N };
    let s = n + 1;
    let (f, z) = (&factors[..n * s], &mut z[..n]);
    let rounding = X::splat(NOISE * X::EPS);
    for i in 0..n {
        let mut size = q[i].abs().only(alpha[i]);
        for k in 0..i {
            size = size.add_product(f[i * s + k].abs(), f[k * s + n].abs());
        }
        size = size.mul(inverse[i].abs());
        for k in i + 1..n {
            size = size.add_product(f[i * s + k].abs(), z[k].abs());
        }
        z[i] = z[i].only(size.mul(rounding).lt(z[i].abs()));
    }
}

/// `w = A z + q`.
#[inline(always)]
pub fn multiply<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>) {
    let n = if N == 0 { n } else { N };
    let (a, q, z, w) = (&tile.a[..n * n], &tile.q[..n], &tile.z[..n], &mut tile.w[..n]);
    let mut i = 0;
    while i + 4 <= n {
        let mut sum = [q[i], q[i + 1], q[i + 2], q[i + 3]];
        for j in 0..n {
            for r in 0..4 {
                sum[r] = sum[r].add_product(a[(i + r) * n + j], z[j]);
            }
        }
        w[i..i + 4].copy_from_slice(&sum);
        i += 4;
    }
    while i < n {
        let mut sum = q[i];
        for j in 0..n {
            sum = sum.add_product(a[i * n + j], z[j]);
        }
        w[i] = sum;
        i += 1;
    }
}

/// One step of iterative refinement for the lanes of `which`: `z_a -= (L U)^-1 w_a`, then w again. O(n^2).
#[inline(always)]
pub fn refine<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>, which: X::Mask) {
    let n = if N == 0 { n } else { N };
    let block = &mut tile.block;
    let masked = is_masked::<N>(n);
    let m = if masked { n } else { block.size };
    let s = m + 1;
    for i in 0..m {
        block.x[i] = if masked {
            tile.w[i].only(tile.alpha[i])
        } else {
            X::pick(&tile.w, block.places[i].index(n, 1)).only(block.inside[i])
        };
    }
    let (f, inverse, y) = (&block.factors[..m * s], &block.inverse[..m], &mut block.x[..m]);
    for k in 0..m {
        let x = y[k].mul(inverse[k]);
        y[k] = x;
        for i in k + 1..m {
            y[i] = y[i].sub_product(f[i * s + k], x);
        }
    }
    for i in (1..m).rev() {
        let x = y[i];
        for k in 0..i {
            y[k] = y[k].sub_product(f[k * s + i], x);
        }
    }
    if !masked {
        block.scatter();
    }
    for i in 0..n {
        let step = if masked { block.x[i] } else { block.z[i] };
        // What cancels was rounding error, and what was zero stays zero.
        let (old, better) = (tile.z[i], tile.z[i].sub(step));
        let kept = old.mul(X::splat(CANCELLED)).lt(better).and(X::splat(0.0).lt(old));
        tile.z[i] = better.only(kept).or_else(which, old);
    }
    multiply::<X, N>(n, tile);
}
