//! All supports of problems of order at most 3, by minors: no branch, no pivot, any matrix. [Mur88, sec. 1.5]

use super::newton::Tile;
use crate::small::lane::{Lane, Mask};

/// A w_i above minus this many spacings of `max|q|` counts as nonnegative; what is found is verified later.
const NOISE: f64 = 64.0;

/// Puts the first complementary point of each lane into z and alpha, supports in the order of their bit masks, and
/// returns the lanes that have one and its place. Finds the solution of every problem that has one with `A_aa` regular
/// and all of its z_i clear of rounding error.
#[inline(always)]
pub fn enumerate<X: Lane>(n: usize, tile: &mut Tile<X>) -> (X::Mask, [u8; 16]) {
    let (zero, one) = (X::splat(0.0), X::splat(1.0));
    let (mut a, mut q) = ([[zero; 3]; 3], [zero; 3]);
    let mut largest_q = zero;
    for i in 0..n {
        q[i] = tile.q[i];
        largest_q = q[i].abs().max(largest_q);
        for j in 0..n {
            a[i][j] = tile.a[i * n + j];
        }
    }
    let least = largest_q.mul(X::splat(-NOISE * f64::EPSILON));
    let (mut found, mut place) = (X::Mask::NONE, zero);
    let (mut best, mut alpha) = ([zero; 3], [X::Mask::NONE; 3]);
    for support in 0..1_usize << n {
        let inside = [support & 1 != 0, support & 2 != 0, support & 4 != 0];
        let z = minors(&a, &q, inside);
        let mut fits = found.not();
        for i in 0..n {
            let w = q[i].add_product(a[i][0], z[0]).add_product(a[i][1], z[1]).add_product(a[i][2], z[2]);
            fits = fits.and(if inside[i] { zero.le(z[i]) } else { least.le(w) });
        }
        for i in 0..n {
            best[i] = z[i].or_else(fits, best[i]);
            alpha[i] = fits.choose(if inside[i] { X::Mask::ALL } else { X::Mask::NONE }, alpha[i]);
        }
        place = X::splat(support as f64).add(one).or_else(fits, place);
        found = found.or(fits);
    }
    let mut iterations = [0; 16];
    for (l, count) in iterations.iter_mut().enumerate().take(X::LANES) {
        *count = place.get(l) as u8;
    }
    tile.z[..n].copy_from_slice(&best[..n]);
    tile.alpha[..n].copy_from_slice(&alpha[..n]);
    (found, iterations)
}

/// `z_a = -A_aa^-1 q_a` by Cramer's rule, 0 outside `inside`; infinite or NaN where `A_aa` is singular.
#[inline(always)]
fn minors<X: Lane>(a: &[[X; 3]; 3], q: &[X; 3], inside: [bool; 3]) -> [X; 3] {
    let (zero, one) = (X::splat(0.0), X::splat(1.0));
    // The identity outside the support.
    let (mut b, mut r) = ([[zero; 3]; 3], [zero; 3]);
    for i in 0..3 {
        b[i][i] = one;
        for j in 0..3 {
            if inside[i] && inside[j] {
                b[i][j] = a[i][j];
            }
        }
        if inside[i] {
            r[i] = q[i].neg();
        }
    }
    let mut z = [zero; 3];
    let mut determinant = zero;
    for j in 0..3 {
        let (k, l) = ((j + 1) % 3, (j + 2) % 3);
        // Cofactors of row j: the j-th column of the inverse, times the determinant.
        for i in 0..3 {
            let (s, t) = ((i + 1) % 3, (i + 2) % 3);
            let minor = b[k][s].mul(b[l][t]).sub_product(b[k][t], b[l][s]);
            z[i] = z[i].add_product(minor, r[j]);
            if j == 0 {
                determinant = determinant.add_product(minor, b[0][i]);
            }
        }
    }
    let reciprocal = one.div(determinant);
    for i in 0..3 {
        z[i] = if inside[i] { z[i].mul(reciprocal) } else { zero };
    }
    z
}
