//! From a complementary basis to its point: a fresh factorisation of the original numbers.

use crate::cutovers::LIBRARY_CHOLESKY_FROM;
use crate::linalg::backend::{DenseCholesky, DenseLu, least_squares};
use crate::linalg::blocked::BlockFactor;
use crate::linalg::compensated::rows_compensated;
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

/// A factorisation of `A[alpha, alpha]`, in memory that is used again.
#[derive(Default)]
pub struct Block {
    alpha: Vec<usize>,
    cholesky: BlockFactor,
    lu: DenseLu,
    held: Held,
    /// Scratch.
    step: Vec<f64>,
}

/// Where the factors are.
#[derive(Default)]
enum Held {
    #[default]
    Cholesky,
    Lu,
    Library(DenseCholesky),
}

/// A Cholesky pivot below `FLOOR |alpha|` of its diagonal entry is rounding error: the block is not positive definite.
const FLOOR: f64 = 4.0 * f64::EPSILON;
/// Refinement steps at most: each gains the digits that the factorisation has.
const REFINEMENTS: usize = 4;

/// A backward error that one step brings to rounding level for certain.
const ACCURATE: f64 = 1e-12;

impl Block {
    /// Factors the block of `alpha` by LU. O(|alpha|^3). `false` when it is singular.
    pub fn factor(&mut self, lcp: &Lcp, alpha: &[usize]) -> bool {
        self.hold(alpha, Held::Lu);
        let m = alpha.len();
        for (target, &i) in self.lu.rows(m).chunks_exact_mut(m.max(1)).zip(alpha) {
            let row = lcp.row(i);
            target.iter_mut().zip(alpha).for_each(|(x, &j)| *x = row[j]);
        }
        self.lu.factor(m)
    }

    /// Factors `A[alpha, alpha] + shift I` by Cholesky, for symmetric A. O(|alpha|^3). `false` when it is not positive
    /// definite to rounding.
    pub fn factor_symmetric(&mut self, lcp: &Lcp, alpha: &[usize], shift: f64) -> bool {
        self.hold(alpha, Held::Cholesky);
        let m = alpha.len();
        if m < LIBRARY_CHOLESKY_FROM {
            return self.cholesky.cholesky(lcp.square(), alpha, shift, FLOOR * m as f64);
        }
        let mut block = principal_block(lcp, alpha);
        block.iter_mut().step_by(m + 1).for_each(|x| *x += shift);
        let Some(factor) = DenseCholesky::new(m, &block) else { return false };
        self.held = Held::Library(factor);
        true
    }

    /// Factors the block of the independent indices of `alpha`, for symmetric positive semidefinite A, and puts them first, as
    /// [`BlockFactor::cholesky_pivoted`] does; their number. O(|alpha|^3).
    pub fn factor_semidefinite(
        &mut self,
        lcp: &Lcp,
        alpha: &mut [usize],
        weights: &[f64],
        floor: f64,
    ) -> Option<usize> {
        let rank = self.cholesky.cholesky_pivoted(lcp.square(), alpha, weights, floor)?;
        self.hold(&alpha[..rank], Held::Cholesky);
        Some(rank)
    }

    /// What [`factor_semidefinite`](Self::factor_semidefinite) left.
    #[must_use]
    pub fn factors(&self) -> &BlockFactor {
        &self.cholesky
    }

    fn hold(&mut self, alpha: &[usize], held: Held) {
        self.alpha.clear();
        self.alpha.extend_from_slice(alpha);
        self.step.resize(alpha.len(), 0.0);
        self.held = held;
    }

    fn solve_step(&mut self) {
        match &self.held {
            Held::Cholesky => self.cholesky.solve(&mut self.step),
            Held::Lu => self.step = self.lu.solve(&self.step),
            Held::Library(factor) => self.step = factor.solve(&self.step),
        }
    }

    /// `z_alpha = -B^-1 q_alpha` with the factored B, zero elsewhere. O(|alpha|^2).
    pub fn point(&mut self, q: &[f64], z: &mut [f64]) {
        z.fill(0.0);
        for (b, &i) in self.step.iter_mut().zip(&self.alpha) {
            *b = -q[i];
        }
        self.solve_step();
        for (&x, &i) in self.step.iter().zip(&self.alpha) {
            z[i] = x;
        }
    }

    /// Refines the point on residuals in twice the working precision: the backward error ends at rounding level row by
    /// row unless the block is numerically singular [Hig02, ch. 12]. O(n |alpha|) a step.
    pub fn refine(&mut self, lcp: &Lcp, z: &mut [f64]) {
        let mut last = f64::INFINITY;
        for _ in 0..REFINEMENTS {
            let mut backward = 0.0_f64;
            let (residuals, magnitudes) = rows_compensated(lcp.q(), lcp.a(), z, &self.alpha);
            for ((r, residual), magnitude) in self.step.iter_mut().zip(residuals).zip(magnitudes) {
                *r = -residual;
                let ratio = if residual == 0.0 { 0.0 } else { residual.abs() / magnitude };
                backward = if ratio > backward || ratio.is_nan() { ratio } else { backward };
            }
            if backward.is_nan() || backward <= f64::EPSILON || backward > 0.5 * last {
                break;
            }
            last = backward;
            self.solve_step();
            if self.step.iter().any(|x| !x.is_finite()) {
                break;
            }
            for (s, &i) in self.step.iter().zip(&self.alpha) {
                z[i] += s;
            }
            if backward <= ACCURATE {
                break;
            }
        }
    }
}

/// `z` with `A[alpha, alpha] z_alpha = -q_alpha` and zero elsewhere, refined to rounding level row by row.
/// O(|alpha|^3). `None` when the block is singular.
#[must_use]
pub fn basic_point(lcp: &Lcp, alpha: &[usize]) -> Option<Vec<f64>> {
    let mut block = Block::default();
    if !block.factor(lcp, alpha) {
        return None;
    }
    let mut z = vec![0.0; lcp.n()];
    block.point(lcp.q(), &mut z);
    block.refine(lcp, &mut z);
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
