//! Block principal pivoting. [JP94], [KP11]
//!
//! Guess `alpha`, solve `A[alpha, alpha] z_alpha = -q_alpha`, and exchange every index whose sign is wrong; when the
//! number of wrong signs stops falling, exchange only the largest such index (Murty's rule [Mur74], finite for P).
//! For a P-matrix it ends at the unique solution, typically after 2 to 8 factorisations, whatever n.

use crate::control::Control;
use crate::linalg::backend::{DenseCholesky, DenseLu, refine};
use crate::linalg::kernels;
use crate::pivoting::basis::principal_block;
use crate::problem::Lcp;
use crate::solution::Candidate;
use crate::status::Termination;

/// Options of block principal pivoting.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Block exchanges that may fail to reduce the number of wrong signs before Murty's rule takes over.
    pub patience: usize,
    /// First guess of the index set with `z_i > 0`; `None`: `{i : q_i < 0}`.
    pub alpha: Option<Vec<usize>>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { patience: 5, alpha: None }
    }
}

/// Factorisations allowed when the caller gives no limit.
#[must_use]
pub fn default_limit(n: usize) -> usize {
    30 + n
}

/// Solves LCP(q, A) for a P-matrix A. O(|alpha|^3 + n^2) an iteration.
///
/// Iterations run in plain doubles; the last basis is solved again with refinement.
#[must_use]
pub fn block_pivoting(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    let mut in_alpha = vec![false; n];
    match &settings.alpha {
        Some(alpha) => alpha.iter().for_each(|&i| in_alpha[i] = true),
        None => in_alpha.iter_mut().zip(lcp.q()).for_each(|(a, &q)| *a = q < 0.0),
    }
    let symmetric = is_symmetric(lcp);
    let (mut z, mut w) = (vec![0.0; n], vec![0.0; n]);
    let mut wrong = Vec::with_capacity(n);
    let (mut fewest, mut patience) = (n + 1, settings.patience);
    let mut iterations = 0;
    let mut alpha = None;
    let termination = loop {
        if let Some(reason) = control.stop(iterations, default_limit(n)) {
            break reason;
        }
        let Some(block) = Block::new(lcp, members(&in_alpha), symmetric) else {
            break Termination::Breakdown("A[alpha, alpha] became singular: A is not a P-matrix");
        };
        block.point(&mut z);
        kernels::affine(lcp.q(), lcp.a(), &z, &mut w);
        iterations += 1;
        wrong_signs(&in_alpha, &z, &w, &mut wrong);
        let Some(&last) = wrong.last() else {
            block.refined_point(&mut z);
            alpha = Some(block.alpha);
            break Termination::ComplementaryBasis;
        };
        if wrong.len() < fewest {
            fewest = wrong.len();
            patience = settings.patience;
        } else {
            patience = patience.saturating_sub(1);
        }
        let exchanged = if patience > 0 { wrong.as_slice() } else { &[last] };
        exchanged.iter().for_each(|&i| in_alpha[i] = !in_alpha[i]);
    };
    Candidate { alpha, ..Candidate::point(z, termination, iterations) }
}

/// The basic block `A[alpha, alpha]` and its factorisation.
struct Block {
    alpha: Vec<usize>,
    rows: Vec<f64>,
    rhs: Vec<f64>,
    factor: Factor,
}

enum Factor {
    Cholesky(DenseCholesky),
    Lu(DenseLu),
}

impl Block {
    /// `None` when the block is singular. Cholesky when A is symmetric and the block positive definite, LU otherwise.
    fn new(lcp: &Lcp, alpha: Vec<usize>, symmetric: bool) -> Option<Self> {
        let rows = principal_block(lcp, &alpha);
        let rhs = alpha.iter().map(|&i| -lcp.q()[i]).collect();
        let cholesky = if symmetric { DenseCholesky::new(alpha.len(), &rows).map(Factor::Cholesky) } else { None };
        let factor = cholesky.or_else(|| DenseLu::new(alpha.len(), &rows).map(Factor::Lu))?;
        Some(Self { alpha, rows, rhs, factor })
    }

    fn solve(&self, b: &[f64]) -> Vec<f64> {
        match &self.factor {
            Factor::Cholesky(factor) => factor.solve(b),
            Factor::Lu(factor) => factor.solve(b),
        }
    }

    /// `z_alpha = -A[alpha, alpha]^-1 q_alpha`, zero elsewhere.
    fn point(&self, z: &mut [f64]) {
        self.scatter(self.solve(&self.rhs), z);
    }

    /// As [`Block::point`], refined to rounding level.
    fn refined_point(&self, z: &mut [f64]) {
        self.scatter(refine(|b| self.solve(b), &self.rhs, &self.rows), z);
    }

    fn scatter(&self, z_alpha: Vec<f64>, z: &mut [f64]) {
        z.fill(0.0);
        for (&i, x) in self.alpha.iter().zip(z_alpha) {
            z[i] = x;
        }
    }
}

/// Indices with `z_i < 0` in alpha or `w_i < 0` outside, beyond rounding.
fn wrong_signs(in_alpha: &[bool], z: &[f64], w: &[f64], wrong: &mut Vec<usize>) {
    let noise = SIGN * kernels::max_abs(z).max(1.0);
    wrong.clear();
    wrong.extend((0..z.len()).filter(|&i| if in_alpha[i] { z[i] < -noise } else { w[i] < -noise }));
}

/// A sign is wrong below `-SIGN max(1, max|z|)`: rounding must not exchange an index for ever.
const SIGN: f64 = 1e-13;

fn is_symmetric(lcp: &Lcp) -> bool {
    let n = lcp.n();
    (0..n).all(|i| (0..i).all(|j| lcp.row(i)[j] == lcp.row(j)[i]))
}

fn members(in_alpha: &[bool]) -> Vec<usize> {
    (0..in_alpha.len()).filter(|&i| in_alpha[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reproducible symmetric positive definite problem with a planted solution.
    #[test]
    fn positive_definite_in_few_factorisations() {
        let n = 40;
        let b: Vec<f64> = (0..n * n).map(|k| ((k * 7919 % 101) as f64) / 50.0 - 1.0).collect();
        let dot = |i: usize, j: usize| (0..n).map(|k| b[i * n + k] * b[j * n + k]).sum::<f64>();
        let a: Vec<f64> = (0..n * n).map(|k| dot(k / n, k % n) + if k / n == k % n { 1.0 } else { 0.0 }).collect();
        let z: Vec<f64> = (0..n).map(|i| ((i * 37 % 11) as f64 - 5.0).max(0.0)).collect();
        let q = (0..n).map(|i| if z[i] > 0.0 { 0.0 } else { 1.0 } - (0..n).map(|j| a[i * n + j] * z[j]).sum::<f64>());
        let lcp = Lcp::new(n, a.clone(), q.collect()).expect("valid");
        let found = block_pivoting(&lcp, &Settings::default(), &Control::default());
        assert_eq!(found.termination, Termination::ComplementaryBasis);
        assert!(found.iterations <= 8, "{}", found.iterations);
        assert!(found.z.iter().zip(&z).all(|(x, y)| (x - y).abs() < 1e-9));
    }

    #[test]
    fn singular_block_is_a_breakdown() {
        let lcp = Lcp::new(2, vec![1.0, 1.0, 1.0, 1.0], vec![-1.0, -2.0]).expect("valid");
        let found = block_pivoting(&lcp, &Settings::default(), &Control::default());
        assert!(matches!(found.termination, Termination::Breakdown(_)));
    }
}
