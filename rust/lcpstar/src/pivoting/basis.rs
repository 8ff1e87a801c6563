//! From a complementary basis to its point: a fresh factorisation of the original numbers.

use crate::linalg::backend::DenseLu;
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
