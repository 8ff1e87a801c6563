//! The linear algebra of one iteration: products with A and solves with `A + diag(d)`.

use crate::linalg::backend::{ShiftedFactor, Structure};
use crate::linalg::dd::{two_prod, two_sum};
use crate::linalg::kernels::{axpy, dot, dot_compensated};
use crate::pivoting::finish::{Finished, finish, finish_quickly};
use crate::problem::Lcp;
use crate::residual::slack;

/// What the interior point iteration asks of a matrix, dense or sparse.
pub trait NewtonSystem {
    /// Order.
    fn n(&self) -> usize;
    /// `q`.
    fn q(&self) -> &[f64];
    /// `y = A x`.
    fn multiply(&self, x: &[f64], y: &mut [f64]);
    /// `y = A' x`.
    fn multiply_transposed(&self, x: &[f64], y: &mut [f64]);
    /// Whether A = A'.
    fn is_symmetric(&self) -> bool;
    /// `y = b - (A + diag(d)) x` in twice the working precision.
    fn residual(&self, d: &[f64], x: &[f64], b: &[f64], y: &mut [f64]);
    /// Factors `A + diag(d)`, `d > 0`; `false` when that fails.
    fn factor(&mut self, d: &[f64]) -> bool;
    /// Factors it again with more pivoting, if there is more; `false` when there is not or it fails.
    fn factor_again(&mut self, d: &[f64]) -> bool;
    /// Replaces `x` by `(A + diag(d))^-1 x` with the last factorisation.
    fn back_solve(&mut self, x: &mut [f64]);
}

/// A problem as the loop around the iteration sees it.
pub trait Problem: NewtonSystem {
    /// `A z + q` in twice the working precision.
    fn slack(&self, z: &[f64]) -> Vec<f64>;
    /// The exact finish.
    fn finish(&self, z: &[f64], w: &[f64]) -> Option<Finished>;
    /// Its cheap half.
    fn finish_quickly(&self, z: &[f64], w: &[f64]) -> Option<Finished>;
    /// A Farkas vector from a point with `tau -> 0`.
    fn farkas_vector(&self, z: &[f64], w: &[f64]) -> Option<Vec<f64>>;
}

impl Problem for Dense<'_> {
    fn slack(&self, z: &[f64]) -> Vec<f64> {
        slack(self.lcp, z).0
    }

    fn finish(&self, z: &[f64], w: &[f64]) -> Option<Finished> {
        finish(self.lcp, z, w, self.is_symmetric())
    }

    fn finish_quickly(&self, z: &[f64], w: &[f64]) -> Option<Finished> {
        finish_quickly(self.lcp, z, w, self.is_symmetric())
    }

    fn farkas_vector(&self, z: &[f64], w: &[f64]) -> Option<Vec<f64>> {
        super::infeasible::farkas_vector(self.lcp, z, w)
    }
}

/// A dense matrix. No method allocates.
pub struct Dense<'a> {
    lcp: &'a Lcp,
    factor: ShiftedFactor,
}

impl<'a> Dense<'a> {
    /// Finds the structure of A and allocates the factorisation. O(n^2).
    #[must_use]
    pub fn new(lcp: &'a Lcp) -> Self {
        Self { lcp, factor: ShiftedFactor::new(lcp.n(), Structure::of(lcp.n(), lcp.a())) }
    }
}

impl NewtonSystem for Dense<'_> {
    fn n(&self) -> usize {
        self.lcp.n()
    }

    fn q(&self) -> &[f64] {
        self.lcp.q()
    }

    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        for (i, y) in y.iter_mut().enumerate() {
            *y = dot(self.lcp.row(i), x);
        }
    }

    fn multiply_transposed(&self, x: &[f64], y: &mut [f64]) {
        if self.is_symmetric() {
            return self.multiply(x, y);
        }
        y.fill(0.0);
        for (i, &x) in x.iter().enumerate() {
            axpy(x, self.lcp.row(i), y);
        }
    }

    fn is_symmetric(&self) -> bool {
        *self.factor.structure() == Structure::Symmetric
    }

    fn residual(&self, d: &[f64], x: &[f64], b: &[f64], y: &mut [f64]) {
        for i in 0..y.len() {
            let (p, e) = two_prod(d[i], x[i]);
            let (start, f) = two_sum(p, -b[i]);
            y[i] = -(dot_compensated(start, self.lcp.row(i), x).0 + (e + f));
        }
    }

    fn factor(&mut self, d: &[f64]) -> bool {
        self.factor.factor(self.lcp.a(), d)
    }

    fn factor_again(&mut self, d: &[f64]) -> bool {
        self.factor.can_pivot() && self.factor.factor_pivoted(self.lcp.a(), d)
    }

    fn back_solve(&mut self, x: &mut [f64]) {
        self.factor.solve(x);
    }
}
