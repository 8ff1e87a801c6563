//! The iteration's linear algebra for a sparse A.

use super::system::{NewtonSystem, Problem};
use crate::control::Control;
use crate::cutovers::DENSE_UP_TO;
use crate::linalg::backend::SparseFactor;
use crate::linalg::dd::{two_prod, two_sum};
use crate::linalg::kernels::dot_compensated;
use crate::pivoting::finish::{self, Finished};
use crate::problem::Lcp;
use crate::sparse::SparseLcp;

/// A sparse problem and its factorisations, which allocate what their fill needs.
pub struct Sparse<'a> {
    lcp: &'a SparseLcp,
    /// The same problem dense, where it was given so: for its finish.
    dense: Option<&'a Lcp>,
    factor: SparseFactor,
    symmetric: bool,
    control: Control<'a>,
}

impl<'a> Sparse<'a> {
    /// Finds the ordering; `dense` is the same problem, if there is one. `None` when the matrix is too large to index.
    ///
    /// `control` is asked before each ordering and each factorisation of the library, which it cannot stop.
    #[must_use]
    pub fn new(lcp: &'a SparseLcp, dense: Option<&'a Lcp>, control: Control<'a>) -> Option<Self> {
        let entries = block(lcp, &(0..lcp.n()).collect::<Vec<_>>());
        let symmetric = dense.map_or_else(|| is_symmetric(lcp), Lcp::is_symmetric);
        if control.expired().is_some() {
            return None;
        }
        let factor = SparseFactor::new(lcp.n(), &entries, symmetric)?;
        Some(Self { lcp, dense, factor, symmetric, control })
    }
}

/// The entries of `A[alpha, alpha]`.
fn block(lcp: &SparseLcp, alpha: &[usize]) -> Vec<(usize, usize, f64)> {
    let mut place = vec![usize::MAX; lcp.n()];
    alpha.iter().enumerate().for_each(|(k, &i)| place[i] = k);
    let mut entries = Vec::new();
    for (k, &i) in alpha.iter().enumerate() {
        let (columns, values) = lcp.row(i);
        let inside = columns.iter().zip(values).filter(|&(&j, _)| place[j] != usize::MAX);
        entries.extend(inside.map(|(&j, &a)| (k, place[j], a)));
    }
    entries
}

/// O(nnz log(longest row)).
fn is_symmetric(lcp: &SparseLcp) -> bool {
    let entry = |i: usize, j: usize| {
        let (columns, values) = lcp.row(i);
        columns.binary_search(&j).map_or(0.0, |k| values[k])
    };
    let mirrored = |i: usize| lcp.row(i).0.iter().zip(lcp.row(i).1).all(|(&j, &a)| entry(j, i) == a);
    (0..lcp.n()).all(mirrored)
}

impl NewtonSystem for Sparse<'_> {
    fn n(&self) -> usize {
        self.lcp.n()
    }

    fn q(&self) -> &[f64] {
        self.lcp.q()
    }

    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        for (i, y) in y.iter_mut().enumerate() {
            let (columns, values) = self.lcp.row(i);
            *y = columns.iter().zip(values).map(|(&j, a)| a * x[j]).sum();
        }
    }

    fn multiply_transposed(&self, x: &[f64], y: &mut [f64]) {
        if self.symmetric {
            return self.multiply(x, y);
        }
        y.fill(0.0);
        for (i, &x) in x.iter().enumerate() {
            let (columns, values) = self.lcp.row(i);
            for (&j, a) in columns.iter().zip(values) {
                y[j] += a * x;
            }
        }
    }

    fn is_symmetric(&self) -> bool {
        self.symmetric
    }

    fn residual(&self, d: &[f64], x: &[f64], b: &[f64], y: &mut [f64]) {
        let mut gathered = Vec::new();
        for i in 0..y.len() {
            let (p, e) = two_prod(d[i], x[i]);
            let (start, f) = two_sum(p, -b[i]);
            y[i] = -(self.lcp.row_dot(i, start, x, &mut gathered).0 + (e + f));
        }
    }

    fn factor(&mut self, d: &[f64]) -> bool {
        self.factor.factor(d)
    }

    fn factor_again(&mut self, _d: &[f64]) -> bool {
        false
    }

    fn back_solve(&mut self, x: &mut [f64]) {
        self.factor.solve(x);
    }
}

impl Problem for Sparse<'_> {
    fn slack(&self, z: &[f64]) -> Vec<f64> {
        self.lcp.slack(z).0
    }

    fn finish(&self, z: &[f64], w: &[f64]) -> Option<Finished> {
        if let Some(lcp) = self.dense {
            return finish::finish(lcp, z, w, self.symmetric);
        }
        let alpha: Vec<usize> = (0..self.lcp.n()).filter(|&i| z[i] > w[i]).collect();
        let entries = block(self.lcp, &alpha);
        let stopped = || self.control.expired().is_some();
        if stopped() {
            return None;
        }
        let mut factor = SparseFactor::new(alpha.len(), &entries, false)?;
        if stopped() || !factor.factor(&vec![0.0; alpha.len()]) {
            return None;
        }
        let mut point = vec![0.0; self.lcp.n()];
        let mut gathered = Vec::new();
        for _ in 0..3 {
            let mut step: Vec<f64> =
                alpha.iter().map(|&i| -self.lcp.row_dot(i, self.lcp.q()[i], &point, &mut gathered).0).collect();
            factor.solve(&mut step);
            alpha.iter().zip(step).for_each(|(&i, s)| point[i] += s);
        }
        point.iter_mut().for_each(|x| *x = x.max(0.0));
        let (w, magnitude) = self.lcp.slack(&point);
        let residual = finish::residual(self.lcp.q(), &point, &w, &magnitude);
        Some(Finished { z: point, alpha, is_basis: true, residual })
    }

    fn finish_quickly(&self, z: &[f64], w: &[f64]) -> Option<Finished> {
        finish::finish_quickly(self.dense?, z, w, self.symmetric)
    }

    /// Polished on the dense matrix up to the order where that is affordable; beyond it the iterate itself is checked.
    fn farkas_vector(&self, z: &[f64], w: &[f64]) -> Option<Vec<f64>> {
        if let Some(lcp) = self.dense {
            return super::infeasible::farkas_vector(lcp, z, w);
        }
        if self.lcp.n() <= DENSE_UP_TO {
            return super::infeasible::farkas_vector(&self.lcp.to_dense(), z, w);
        }
        let y: Vec<f64> = z.iter().zip(w).map(|(&z, &w)| if z > w { z } else { 0.0 }).collect();
        let mut products = vec![0.0; y.len()];
        self.multiply_transposed(&y, &mut products);
        let worst = products.iter().fold(0.0, |m: f64, &x| m.max(x));
        let qy = dot_compensated(0.0, self.lcp.q(), &y).0;
        (qy < 0.0 && worst * 1e11 <= -qy).then_some(y)
    }
}
