//! Least squares with the stacked matrix `C = [I; B]`: Cholesky of `C'C`, or QR of `C` itself.

use super::lu::is_pivot;
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::solvers::{ColPivQr, Solve, SolveLstsq};
use faer::linalg::triangular_solve;
use faer::prelude::Reborrow;
use faer::{Accum, Mat, MatRef, Par, Side};

/// Cholesky factor of `I + B'B`.
pub struct GramCholesky {
    factor: faer::linalg::solvers::Llt<f64>,
}

impl GramCholesky {
    /// Forms and factors `I + B'B` for a row-major `B` of order `n`. O(n^3). `None` if it is not positive definite in
    /// floating point or overflows.
    #[must_use]
    pub fn new(n: usize, b: &[f64]) -> Option<Self> {
        let b = MatRef::from_row_major_slice(b, n, n);
        let mut s = Mat::<f64>::identity(n, n);
        matmul(
            s.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Add,
            b.transpose(),
            BlockStructure::Rectangular,
            b,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        let factor = faer::linalg::solvers::Llt::new(s.as_ref(), Side::Lower).ok()?;
        (0..n).all(|i| is_pivot(factor.L()[(i, i)])).then_some(Self { factor })
    }

    /// `(I + B'B)^-1 g`. O(n^2).
    #[must_use]
    pub fn solve(&self, g: &[f64]) -> Vec<f64> {
        let mut x = column(g);
        self.factor.solve_in_place(&mut x);
        entries(&x)
    }
}

/// `C P = Q R` of the stacked `C = [I; B]`, rows sorted by size and columns pivoted, which keeps the relative accuracy
/// of every row however different their sizes. [CoxH98]
pub struct StackedQr {
    n: usize,
    /// Position in `C` of each row of the sorted matrix.
    order: Vec<usize>,
    factor: ColPivQr<f64>,
}

impl StackedQr {
    /// Factors `[I; B]` for a row-major `B` of order `n`. O(n^3).
    #[must_use]
    pub fn new(n: usize, b: &[f64]) -> Self {
        let size = |i: usize| if i < n { 1.0 } else { super::max_abs(&b[(i - n) * n..(i - n + 1) * n]) };
        let sizes: Vec<f64> = (0..2 * n).map(size).collect();
        let mut order: Vec<usize> = (0..2 * n).collect();
        order.sort_by(|&i, &j| sizes[j].total_cmp(&sizes[i]));
        let entry = |i: usize, j: usize| match order[i] {
            i if i < n => f64::from(u8::from(i == j)),
            i => b[(i - n) * n + j],
        };
        let stacked = Mat::from_fn(2 * n, n, entry);
        Self { n, order, factor: ColPivQr::new(stacked.as_ref()) }
    }

    /// `argmin || C u - f ||` for `f` of length `2 n`. O(n^2).
    #[must_use]
    pub fn least_squares(&self, f: &[f64]) -> Vec<f64> {
        let mut x = Mat::from_fn(2 * self.n, 1, |i, _| f[self.order[i]]);
        self.factor.solve_lstsq_in_place(&mut x);
        (0..self.n).map(|i| x[(i, 0)]).collect()
    }

    /// `(C'C)^-1 g = P R^-1 R^-T P' g`. O(n^2).
    #[must_use]
    pub fn solve(&self, g: &[f64]) -> Vec<f64> {
        let mut x = column(g);
        let permutation = self.factor.P();
        let r = self.factor.thin_R();
        // `C P = Q R`: column j of `C P` is column `forward[j]` of C.
        let (forward, _) = permutation.arrays();
        let mut y = Mat::from_fn(self.n, 1, |i, _| x[(forward[i], 0)]);
        triangular_solve::solve_lower_triangular_in_place(r.transpose(), y.as_mut(), Par::Seq);
        triangular_solve::solve_upper_triangular_in_place(r.rb(), y.as_mut(), Par::Seq);
        for (i, &j) in forward.iter().enumerate() {
            x[(j, 0)] = y[(i, 0)];
        }
        entries(&x)
    }
}

fn column(v: &[f64]) -> Mat<f64> {
    Mat::from_fn(v.len(), 1, |i, _| v[i])
}

fn entries(x: &Mat<f64>) -> Vec<f64> {
    (0..x.nrows()).map(|i| x[(i, 0)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_factors_invert_the_gram_matrix() {
        let n = 6;
        let b: Vec<f64> = (0..n * n).map(|k| ((k * 37 % 19) as f64 - 9.0) * if k < 12 { 30.0 } else { 1.0 }).collect();
        let x: Vec<f64> = (0..n).map(|i| 1.0 - i as f64).collect();
        let bx: Vec<f64> = (0..n).map(|i| (0..n).map(|j| b[i * n + j] * x[j]).sum()).collect();
        let g: Vec<f64> = (0..n).map(|j| x[j] + (0..n).map(|i| b[i * n + j] * bx[i]).sum::<f64>()).collect();
        let f: Vec<f64> = x.iter().chain(&bx).copied().collect();
        let qr = StackedQr::new(n, &b);
        for found in [GramCholesky::new(n, &b).expect("definite").solve(&g), qr.solve(&g), qr.least_squares(&f)] {
            for i in 0..n {
                assert!((found[i] - x[i]).abs() < 1e-8, "{found:?}");
            }
        }
    }
}
