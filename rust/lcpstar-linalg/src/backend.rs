//! Factorisations by nalgebra and faer, which are named here and in the files below alone.
//!
//! Dense square systems: nalgebra below [`FAER_FROM`], where a factorisation costs less than faer's dispatch, faer from
//! there on, where blocking pays. The cut-over was measured by `cargo bench -p lcpstar --bench backend`
//! (record in `benches/record/backend.md`).

mod gram;
mod lu;
mod row_space;
mod shifted;
mod sparse;

use crate::cutovers::FAER_FROM;
pub use gram::{GramCholesky, StackedQr};
pub use row_space::RowSpace;
pub use shifted::{ShiftedFactor, Structure};
pub use sparse::SparseFactor;

use super::kernels::{dot_compensated, max_abs};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::solvers::{Solve, SolveLstsq};
use lu::InPlaceLu;
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// `P B = L U` of a dense square matrix, by partial pivoting; another one is factored in the same memory.
#[derive(Default)]
pub struct DenseLu {
    large: InPlaceLu,
    /// Instead of `large`.
    small: Option<LU<f64, Dyn, Dyn>>,
}

impl DenseLu {
    /// Factors the row-major matrix `b` of order `n`. O(n^3). `None` if a pivot is zero or not finite.
    #[must_use]
    pub fn new(n: usize, b: &[f64]) -> Option<Self> {
        if n < FAER_FROM { Self::small(n, b) } else { Self::large(n, b) }
    }

    /// As [`DenseLu::new`], by nalgebra whatever n is.
    #[must_use]
    pub fn small(n: usize, b: &[f64]) -> Option<Self> {
        let mut lu = Self::default();
        lu.rows(n).copy_from_slice(b);
        lu.factor_small(n).then_some(lu)
    }

    /// As [`DenseLu::new`], by faer whatever n is.
    #[must_use]
    pub fn large(n: usize, b: &[f64]) -> Option<Self> {
        let mut lu = Self::default();
        lu.rows(n).copy_from_slice(b);
        lu.factor_large(n).then_some(lu)
    }

    /// The rows of a matrix of order `n`, to be filled and then to be factored.
    pub fn rows(&mut self, n: usize) -> &mut [f64] {
        self.large.rows(n)
    }

    /// Factors what was filled in, of order `n`. O(n^3). `false` if a pivot is zero or not finite.
    pub fn factor(&mut self, n: usize) -> bool {
        if n < FAER_FROM { self.factor_small(n) } else { self.factor_large(n) }
    }

    fn factor_small(&mut self, n: usize) -> bool {
        let lu = self.small.insert(LU::new(DMatrix::from_row_slice(n, n, self.large.rows(n))));
        let u = lu.lu_internal();
        (0..n).all(|i| lu::is_pivot(u[(i, i)]))
    }

    fn factor_large(&mut self, n: usize) -> bool {
        self.small = None;
        self.large.factor(MemStack::new(&mut MemBuffer::new(InPlaceLu::scratch(n, 0))))
    }

    /// `B^-1 b`. O(n^2).
    #[must_use]
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        self.solve_many(b, 1)
    }

    /// `B^-1 C` for a row-major `n x m` matrix `C`. O(n^2 m).
    #[must_use]
    pub fn solve_many(&self, c: &[f64], m: usize) -> Vec<f64> {
        if c.is_empty() {
            return Vec::new();
        }
        let n = c.len() / m;
        if let Some(lu) = &self.small {
            let mut x = DMatrix::from_row_slice(n, m, c);
            let solved = lu.solve_mut(&mut x);
            debug_assert!(solved, "invariant: no pivot is zero");
            return x.transpose().as_slice().to_vec();
        }
        let mut x = c.to_vec();
        let mut memory = MemBuffer::new(InPlaceLu::scratch(n, m));
        self.large.solve(faer::MatMut::from_row_major_slice_mut(&mut x, n, m), MemStack::new(&mut memory));
        x
    }

    /// `B^-1 b`, refined; `rows` is the matrix that was factored. See [`refine`].
    #[must_use]
    pub fn solve_refined(&self, b: &[f64], rows: &[f64]) -> Vec<f64> {
        refine(|r| self.solve(r), b, rows)
    }
}

/// `B = L L'` of a symmetric positive definite matrix; only the lower triangle is read.
pub struct DenseCholesky {
    n: usize,
    factor: CholeskyFactor,
}

enum CholeskyFactor {
    Small(nalgebra::Cholesky<f64, Dyn>),
    Large(faer::linalg::solvers::Llt<f64>),
}

impl DenseCholesky {
    /// Factors the row-major matrix `b`. O(n^3). `None` if it is not positive definite to rounding.
    #[must_use]
    pub fn new(n: usize, b: &[f64]) -> Option<Self> {
        debug_assert!(b.len() == n * n);
        let factor = if n < FAER_FROM {
            // Symmetric: the column-major copy of a row-major matrix is the matrix itself.
            CholeskyFactor::Small(nalgebra::Cholesky::new(DMatrix::from_column_slice(n, n, b))?)
        } else {
            let b = faer::MatRef::from_row_major_slice(b, n, n);
            CholeskyFactor::Large(faer::linalg::solvers::Llt::new(b, faer::Side::Lower).ok()?)
        };
        Some(Self { n, factor })
    }

    /// `B^-1 b`. O(n^2).
    #[must_use]
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        debug_assert!(b.len() == self.n);
        if b.is_empty() {
            return Vec::new();
        }
        match &self.factor {
            CholeskyFactor::Small(factor) => {
                let mut x = DVector::from_column_slice(b);
                factor.solve_mut(&mut x);
                x.as_slice().to_vec()
            }
            CholeskyFactor::Large(factor) => {
                let mut x = faer::Mat::from_fn(self.n, 1, |i, _| b[i]);
                factor.solve_in_place(&mut x);
                (0..self.n).map(|i| x[(i, 0)]).collect()
            }
        }
    }
}

/// A solution of `B x = b` from a `solve` that factored the row-major `rows` of B, with iterative refinement on residuals
/// in twice the working precision: the backward error ends at rounding level row by row unless B is numerically
/// singular. [Hig02, ch. 12]
pub fn refine(solve: impl Fn(&[f64]) -> Vec<f64>, b: &[f64], rows: &[f64]) -> Vec<f64> {
    let n = b.len();
    let mut x = solve(b);
    let mut last = f64::INFINITY;
    for _ in 0..REFINEMENTS {
        let (residual, magnitude): (Vec<f64>, Vec<f64>) =
            (0..n).map(|i| negated_residual(&rows[i * n..(i + 1) * n], b[i], &x)).unzip();
        let backward = residual.iter().zip(&magnitude).map(|(r, m)| ratio(*r, *m)).fold(0.0, f64::max);
        // NaN fails the comparison and stops, too.
        if backward.is_nan() || backward <= f64::EPSILON || backward > 0.5 * last {
            break;
        }
        last = backward;
        let step = solve(&residual);
        if !max_abs(&step).is_finite() {
            break;
        }
        for (x, s) in x.iter_mut().zip(&step) {
            *x += s;
        }
    }
    x
}

/// Refinement steps at most: each gains the digits that the factorisation has, so three reach rounding level.
const REFINEMENTS: usize = 4;

/// `b - row x` and `|b| + |row||x|`.
fn negated_residual(row: &[f64], b: f64, x: &[f64]) -> (f64, f64) {
    let (r, m) = dot_compensated(-b, row, x);
    (-r, m)
}

/// `|r| / m`, zero for `0 / 0`.
fn ratio(r: f64, m: f64) -> f64 {
    if r == 0.0 { 0.0 } else { r.abs() / m }
}

/// `argmin |C x - b|` for a row-major `m x n` matrix C of full column rank, `m >= n`; column-pivoted QR. O(m n^2).
#[must_use]
pub fn least_squares(n: usize, c: &[f64], b: &[f64]) -> Vec<f64> {
    let m = b.len();
    debug_assert!(c.len() == m * n && m >= n);
    let qr = faer::linalg::solvers::ColPivQr::new(faer::MatRef::from_row_major_slice(c, m, n));
    let x = qr.solve_lstsq(faer::Mat::from_fn(m, 1, |i, _| b[i]));
    (0..n).map(|j| x[(j, 0)]).collect()
}

/// The numerical rank of a row-major matrix of order `n`: complete pivoting, pivots above `n EPS` of the largest.
/// O(n^3); meant for equilibrated blocks.
#[must_use]
pub fn rank(n: usize, b: &[f64]) -> usize {
    if n == 0 {
        return 0;
    }
    let lu = faer::linalg::solvers::FullPivLu::new(faer::MatRef::from_row_major_slice(b, n, n));
    let u = lu.U();
    let pivots: Vec<f64> = (0..n).map(|i| u[(i, i)].abs()).collect();
    let threshold = n as f64 * f64::EPSILON * max_abs(&pivots);
    pivots.iter().filter(|&&p| p > threshold).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reproducible full matrix, diagonally shifted.
    fn matrix(n: usize) -> Vec<f64> {
        (0..n * n).map(|k| ((k * 7919 % 101) as f64) / 50.0 - 1.0 + if k % (n + 1) == 0 { 3.0 } else { 0.0 }).collect()
    }

    #[test]
    fn both_sides_of_the_cut_over_solve() {
        for n in [1, 2, 5, FAER_FROM - 1, FAER_FROM, 50] {
            let b = matrix(n);
            let x: Vec<f64> = (0..n).map(|i| i as f64 - 2.0).collect();
            let rhs: Vec<f64> = (0..n).map(|i| (0..n).map(|j| b[i * n + j] * x[j]).sum()).collect();
            let lu = DenseLu::new(n, &b).expect("nonsingular");
            let found = lu.solve_refined(&rhs, &b);
            let many = lu.solve_many(&rhs.iter().flat_map(|&r| [r, 2.0 * r]).collect::<Vec<_>>(), 2);
            for i in 0..n {
                assert!((found[i] - x[i]).abs() < 1e-12, "{n} {i}");
                assert!((many[2 * i + 1] - 2.0 * x[i]).abs() < 1e-10, "{n} {i}");
            }
        }
    }

    #[test]
    fn singular_is_none() {
        assert!(DenseLu::new(2, &[1.0, 2.0, 2.0, 4.0]).is_none());
        assert!(DenseLu::new(40, &vec![0.0; 1600]).is_none());
        assert!(DenseLu::new(0, &[]).is_some());
    }
}
