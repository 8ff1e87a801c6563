//! From a complementary basis to its point: a fresh factorisation of the original numbers.

use crate::linalg::backend::{DenseLu, least_squares};
use crate::problem::Lcp;

/// `A[alpha, alpha]`, row-major.
#[must_use]
pub fn principal_block(lcp: &Lcp, alpha: &[usize]) -> Vec<f64> {
    let mut block = Vec::with_capacity(alpha.len() * alpha.len());
    for &i in alpha {
        let row = lcp.row(i);
        block.extend(alpha.iter().map(|&j| row[j]));
    }
    block
}

/// `z` with `A[alpha, alpha] z_alpha = -q_alpha` and zero elsewhere, refined to rounding level row by row.
/// O(|alpha|^3). `None` when the block is singular.
#[must_use]
pub fn basic_point(lcp: &Lcp, alpha: &[usize]) -> Option<Vec<f64>> {
    let block = principal_block(lcp, alpha);
    let rhs: Vec<f64> = alpha.iter().map(|&i| -lcp.q()[i]).collect();
    let z_alpha = DenseLu::new(alpha.len(), &block)?.solve_refined(&rhs, &block);
    let mut z = vec![0.0; lcp.n()];
    for (&i, x) in alpha.iter().zip(z_alpha) {
        z[i] = x;
    }
    Some(z)
}

/// The multipliers `y` with `y'w = ` the row of pair `k` in the dictionary of the basis `alpha`: where that row is
/// nonpositive with a negative value, a Farkas vector. O(|alpha|^3). `None` when the block is singular.
#[must_use]
pub fn row_multiplier(lcp: &Lcp, alpha: &[usize], k: usize) -> Option<Vec<f64>> {
    let transposed: Vec<f64> = alpha.iter().flat_map(|&j| alpha.iter().map(move |&i| lcp.row(i)[j])).collect();
    let basic_w = !alpha.contains(&k);
    let unit = |i: usize| if i == k { -1.0 } else { 0.0 };
    let rhs: Vec<f64> = alpha.iter().map(|&i| if basic_w { -lcp.row(k)[i] } else { unit(i) }).collect();
    let part = DenseLu::new(alpha.len(), &transposed)?.solve_refined(&rhs, &transposed);
    let mut y = vec![0.0; lcp.n()];
    if basic_w {
        y[k] = 1.0;
    }
    for (&i, x) in alpha.iter().zip(part) {
        y[i] = x;
    }
    Some(y)
}

/// `z` with `z_alpha` the least-squares solution of `A[tight, alpha] z_alpha = -q_tight`, zero elsewhere: the point of a
/// degenerate solution whose block `A[alpha, alpha]` is singular, fixed by further rows with `w_i = 0`.
/// O(|tight| |alpha|^2). `None` when there are fewer rows than unknowns.
#[must_use]
pub fn tight_point(lcp: &Lcp, alpha: &[usize], tight: &[usize]) -> Option<Vec<f64>> {
    if tight.len() < alpha.len() || alpha.is_empty() {
        return None;
    }
    let rows: Vec<f64> = tight.iter().flat_map(|&i| alpha.iter().map(move |&j| lcp.row(i)[j])).collect();
    let rhs: Vec<f64> = tight.iter().map(|&i| -lcp.q()[i]).collect();
    let mut z = vec![0.0; lcp.n()];
    for (&i, x) in alpha.iter().zip(least_squares(alpha.len(), &rows, &rhs)) {
        z[i] = x.max(0.0);
    }
    z.iter().all(|x| x.is_finite()).then_some(z)
}
