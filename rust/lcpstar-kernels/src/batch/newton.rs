//! Newton's method on `min(z, w) = 0`, one problem per lane: guess the support `alpha` by a few Gauss-Seidel sweeps, solve
//! `A_aa z_a = -q_a`, correct the guess by the signs of z and w, until it stays. [CPS92, sec. 5.8], [HIK03]
//!
//! For P-matrices this is block principal pivoting; it ends after a few factorisations on almost every problem with a
//! positive (semi)definite matrix and may cycle on others. Lanes that do not end here go on to Lemke's method.
//! A pivot that rounding made smaller than [`FLOOR`](factors::FLOOR) times its diagonal entry is raised to that, which regularises
//! singular blocks; the error it leaves is removed by refinement, and `verify` has the last word.

mod factors;

use crate::cutovers::MASKED_ORDER;
use crate::small::lane::{Lane, MOST_LANES, Mask};
use crate::small::lemke::CANCELLED;
use crate::small::prefetch::Prefetch;
use factors::{Factors, NOISE};

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
    pub prefetch: Prefetch,
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
    factors: Factors<X>,
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
            prefetch: Prefetch::default(),
            block: Block {
                size: 0,
                a: vec![zero; n * n],
                q: vector.clone(),
                inside: vec![X::Mask::NONE; n],
                places: vec![zero; n + 1],
                factors: Factors::new(n),
                x: vector,
                z: vec![zero; n + 1],
            },
        }
    }

    /// Sets the guess to the supports in `masks`: bit i of mask l says whether z_i of lane l is in.
    #[inline(always)]
    pub fn guess(&mut self, n: usize, masks: &[u64]) {
        for i in 0..n {
            let mut bits = 0;
            for (l, mask) in masks[..X::LANES].iter().enumerate() {
                bits |= (mask >> i & 1) << l;
            }
            self.alpha[i] = X::Mask::from_bits(bits as u32);
        }
    }

    /// The guess as masks.
    #[inline(always)]
    pub fn masks(&self, n: usize) -> [u64; MOST_LANES] {
        let mut masks = [0; MOST_LANES];
        for (i, alpha) in self.alpha[..n].iter().enumerate() {
            let bits = alpha.bits();
            for (l, mask) in masks[..X::LANES].iter_mut().enumerate() {
                *mask |= u64::from(bits >> l & 1) << i;
            }
        }
        masks
    }
}

/// Sweeps that guess a support: each costs a small part of a factorisation, the smaller the larger n.
fn sweeps(n: usize) -> usize {
    (1 + n / 4).clamp(3, 6)
}

/// Where an iteration leads.
pub struct Step<X: Lane> {
    /// Lanes whose guess stays: the point is the method's answer.
    pub settled: X::Mask,
    /// Lanes with a better guess in `tile.alpha`.
    pub unsettled: X::Mask,
}

/// One iteration: from the supports in `masks`, bit i for z_i, or from sweeps. O(n^3).
///
/// `N` is the order when it is known at compile time, else 0.
#[inline(always)]
pub fn newton<X: Lane, const N: usize>(
    n: usize,
    tile: &mut Tile<X>,
    masks: Option<&[u64]>,
    symmetric: bool,
) -> Step<X> {
    let n = if N == 0 { n } else { N };
    match masks {
        Some(masks) => tile.guess(n, masks),
        None => sweep::<X, N>(n, tile),
    }
    let regular = solve::<X, N>(n, tile, symmetric, false);
    multiply::<X, N>(n, tile);
    let changed = improve_guess::<X, N>(n, tile);
    // The larger a singular block, the longer the way from it: Lemke's method is faster.
    let worth = if is_masked::<N>(n) { X::Mask::ALL } else { regular };
    Step { settled: changed.not().and(worth), unsettled: changed.and(worth) }
}

/// The point of the guess in `tile.alpha`, which may have degenerate rows: they come out as zero or a rounding error below, and
/// what counts is what is verified. O(n^3).
#[inline(always)]
pub fn solve_guess<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>, symmetric: bool) {
    solve::<X, N>(n, tile, symmetric, true);
    for z in &mut tile.z {
        *z = z.max(X::splat(0.0));
    }
    multiply::<X, N>(n, tile);
}

/// Guesses the support in `tile.alpha` by Gauss-Seidel sweeps projected on `z >= 0`, for lanes with a positive diagonal. O(n^2)
/// a sweep. [CPS92, sec. 5.2]
#[inline(always)]
fn sweep<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>) {
    let n = if N == 0 { n } else { N };
    let (a, q, z, alpha) = (&tile.a[..n * n], &tile.q[..n], &mut tile.z[..n], &mut tile.alpha[..n]);
    // In memory of the factorisation to come.
    let (zero, minus_inverse) = (X::splat(0.0), &mut tile.block.factors.inverse[..n]);
    for i in 0..n {
        minus_inverse[i] = X::splat(-1.0).div(a[i * n + i]);
    }
    for k in 0..sweeps(n) {
        for i in 0..n {
            tile.prefetch.step();
            let row = &a[i * n..(i + 1) * n];
            let mut sum = q[i];
            // What is new comes last, so that the rest need not wait for it. At first, z is zero from i on.
            if k > 0 {
                for (a, z) in row[i + 1..].iter().zip(&z[i + 1..]) {
                    sum = sum.add_product(*a, *z);
                }
            }
            for (a, z) in row[..i].iter().zip(&z[..i]) {
                sum = sum.add_product(*a, *z);
            }
            z[i] = sum.mul(minus_inverse[i]).max(zero);
        }
    }
    for (alpha, z) in alpha.iter_mut().zip(&*z) {
        *alpha = zero.lt(*z);
    }
}

/// The next guess: `z_i > 0` stays in, `w_i < 0` comes in, except for `NOISE`. Returns the lanes that changed.
#[inline(always)]
pub fn improve_guess<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>) -> X::Mask {
    let n = if N == 0 { n } else { N };
    let zero = X::splat(0.0);
    let (alpha, z, w) = (&mut tile.alpha[..n], &tile.z[..n], &tile.w[..n]);
    let mut largest_q = zero;
    for q in &tile.q[..n] {
        largest_q = q.abs().max(largest_q);
    }
    let negative = largest_q.mul(X::splat(-NOISE * f64::EPSILON));
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
    let Tile { a, q, z, alpha, prefetch, block, .. } = tile;
    if is_masked::<N>(n) {
        let factors = &mut block.factors;
        let regular = factors.compute::<N>(n, a, q, alpha, symmetric, prefetch);
        factors.substitute_back::<N>(n, z);
        if cleaned {
            factors.clean::<N>(n, q, alpha, z);
        }
        return regular;
    }
    block.gather(n, a, q, alpha);
    let size = block.size;
    let Block { a, q, inside, factors, x, .. } = block;
    let regular = factors.compute::<0>(size, a, q, inside, symmetric, prefetch);
    factors.substitute_back::<0>(size, x);
    if cleaned {
        factors.clean::<0>(size, q, inside, x);
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
    for i in 0..m {
        block.x[i] = if masked {
            tile.w[i].only(tile.alpha[i])
        } else {
            X::pick(&tile.w, block.places[i].index(n, 1)).only(block.inside[i])
        };
    }
    let Block { factors, x, .. } = block;
    factors.solve_lower::<N>(m, &mut x[..m]);
    factors.solve_upper::<N>(m, &mut x[..m]);
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
