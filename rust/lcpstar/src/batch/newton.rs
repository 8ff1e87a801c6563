//! Newton's method on `min(z, w) = 0`, one problem per lane: guess the support `alpha`, solve
//! `A_aa z_a = -q_a`, correct the guess by the signs of z and w, until it stays. [CPS92, sec. 5.8], [HIK03]
//!
//! For P-matrices this is block principal pivoting; it ends after a few factorisations on almost every problem with a
//! positive (semi)definite matrix and may cycle on others. Lanes that do not end here go on to Lemke's method.
//! A pivot that rounding made smaller than `FLOOR` times its diagonal entry is raised to that, which regularises
//! singular blocks; the error it leaves is removed by refinement, and `verify` has the last word.

use crate::small::lane::{Lane, Mask};

/// Smallest pivot, relative to the diagonal entry it started from.
const FLOOR: f64 = 1e-9;

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
    /// `L` (lower triangle), unit `U` (upper triangle) and the right-hand side (last column) of the masked block.
    factors: Vec<X>,
    /// `1 / L_jj`.
    inverse: Vec<X>,
    /// A right-hand side.
    scratch: Vec<X>,
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
            factors: vec![zero; n * (n + 1)],
            inverse: vector.clone(),
            scratch: vector,
        }
    }
}

/// Iterates from the guess in `tile.alpha` until no lane of `lanes` changes its mind, at most `limit` times, and
/// returns the factorisations, lane by lane. O(n^3) each.
///
/// `N` is the order when it is known at compile time, else 0.
#[inline(always)]
pub fn newton<X: Lane, const N: usize>(
    n: usize,
    tile: &mut Tile<X>,
    lanes: X::Mask,
    symmetric: bool,
    limit: usize,
) -> [u8; 16] {
    let n = if N == 0 { n } else { N };
    let mut iterations = [0; 16];
    let mut unsettled = lanes;
    for _ in 0..limit {
        factor::<X, N>(n, tile, symmetric);
        substitute_back::<X, N>(n, tile);
        multiply::<X, N>(n, tile);
        for l in 0..X::LANES {
            iterations[l] += u8::from(unsettled.get(l));
        }
        unsettled = improve_guess::<X, N>(n, tile).and(lanes);
        if !unsettled.any() {
            break;
        }
    }
    iterations
}

/// The next guess: `z_i > 0` stays in, `w_i < 0` comes in. Returns the lanes that changed.
#[inline(always)]
fn improve_guess<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>) -> X::Mask {
    let n = if N == 0 { n } else { N };
    let zero = X::splat(0.0);
    let (alpha, z, w) = (&mut tile.alpha[..n], &tile.z[..n], &tile.w[..n]);
    let mut changed = X::Mask::NONE;
    for i in 0..n {
        let next = alpha[i].choose(zero.lt(z[i]), w[i].lt(zero));
        changed = changed.or(next.xor(alpha[i]));
        alpha[i] = next;
    }
    changed
}

/// Crout's `L U` of the block `A_aa`, in place among the identity on the other rows and columns, with the
/// right-hand side `-q_a` carried along as column n.
#[inline(always)]
fn factor<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>, symmetric: bool) {
    let n = if N == 0 { n } else { N };
    let s = n + 1;
    let (a, q, alpha) = (&tile.a[..n * n], &tile.q[..n], &tile.alpha[..n]);
    let (f, inverse) = (&mut tile.factors[..n * s], &mut tile.inverse[..n]);
    let (one, floor) = (X::splat(1.0), X::splat(FLOOR));
    for j in 0..n {
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
}

/// `z = U^-1 y` with `y` in the last column of the factors.
#[inline(always)]
fn substitute_back<X: Lane, const N: usize>(n: usize, tile: &mut Tile<X>) {
    let n = if N == 0 { n } else { N };
    let s = n + 1;
    let (f, z) = (&tile.factors[..n * s], &mut tile.z[..n]);
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
    let s = n + 1;
    {
        let (f, inverse, y) = (&tile.factors[..n * s], &tile.inverse[..n], &mut tile.scratch[..n]);
        for i in 0..n {
            y[i] = tile.w[i].only(tile.alpha[i]);
        }
        for k in 0..n {
            let x = y[k].mul(inverse[k]);
            y[k] = x;
            for i in k + 1..n {
                y[i] = y[i].sub_product(f[i * s + k], x);
            }
        }
        for i in (0..n).rev() {
            let x = y[i];
            for k in 0..i {
                y[k] = y[k].sub_product(f[k * s + i], x);
            }
            tile.z[i] = tile.z[i].sub(x).max(X::splat(0.0)).or_else(which, tile.z[i]);
        }
    }
    multiply::<X, N>(n, tile);
}
