//! The matrix as an iteration sees it, dense or sparse: `A z + q`, one column at a time, and factorisations.

use super::factors::{DenseFactors, Factors, SparseFactors};
use crate::equilibrate::Rows;
use crate::linalg::kernels::{affine, axpy};
use crate::problem::Lcp;
use crate::residual;
use crate::sparse::SparseLcp;

/// LCP(q, A) for an iteration. Only [`factors`](Matrix::factors) and [`slack`](Matrix::slack) allocate.
pub trait Matrix {
    /// Order.
    fn n(&self) -> usize;
    /// `q`.
    fn q(&self) -> &[f64];
    /// Whether `A = A'`, bit for bit.
    fn is_symmetric(&self) -> bool;
    /// `a_ii`.
    fn diagonal(&self, i: usize) -> f64;
    /// `w = A z + q`. O(n^2), O(nnz).
    fn affine(&self, z: &[f64], w: &mut [f64]);
    /// `w += f A e_j`. O(n), O(nnz of the column).
    fn add_column(&self, j: usize, f: f64, w: &mut [f64]);
    /// `A z + q` in twice the working precision, and `|A||z| + |q|`.
    fn slack(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>);
    /// Factorisations of this matrix.
    fn factors(&self) -> Box<dyn Factors + '_>;

    /// `y = A x`.
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        self.affine(x, y);
        y.iter_mut().zip(self.q()).for_each(|(y, q)| *y -= q);
    }
}

/// A dense A by rows, and by columns when it is not symmetric.
pub struct Dense<'a> {
    lcp: &'a Lcp,
    /// `A'` row-major; `None` when `A = A'`.
    transposed: Option<Vec<f64>>,
    zero: Vec<f64>,
}

impl<'a> Dense<'a> {
    /// Looks for symmetry, or copies the columns. O(n^2).
    #[must_use]
    pub fn new(lcp: &'a Lcp) -> Self {
        let symmetric = lcp.is_symmetric();
        Self { lcp, transposed: (!symmetric).then(|| transposed(lcp)), zero: vec![0.0; lcp.n()] }
    }
}

fn transposed(lcp: &Lcp) -> Vec<f64> {
    let n = lcp.n();
    let mut t = vec![0.0; n * n];
    for top in (0..n).step_by(TILE) {
        for left in (0..n).step_by(TILE) {
            for i in top..(top + TILE).min(n) {
                for j in left..(left + TILE).min(n) {
                    t[j * n + i] = lcp.row(i)[j];
                }
            }
        }
    }
    t
}

const TILE: usize = 16;

impl Matrix for Dense<'_> {
    fn n(&self) -> usize {
        self.lcp.n()
    }

    fn q(&self) -> &[f64] {
        self.lcp.q()
    }

    fn is_symmetric(&self) -> bool {
        self.transposed.is_none()
    }

    fn diagonal(&self, i: usize) -> f64 {
        self.lcp.row(i)[i]
    }

    fn affine(&self, z: &[f64], w: &mut [f64]) {
        affine(self.lcp.q(), self.lcp.a(), z, w);
    }

    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        affine(&self.zero, self.lcp.a(), x, y);
    }

    fn add_column(&self, j: usize, f: f64, w: &mut [f64]) {
        let n = self.lcp.n();
        match &self.transposed {
            Some(columns) => axpy(f, &columns[j * n..(j + 1) * n], w),
            None => axpy(f, self.lcp.row(j), w),
        }
    }

    fn slack(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        residual::slack(self.lcp, z)
    }

    fn factors(&self) -> Box<dyn Factors + '_> {
        Box::new(DenseFactors::new(self.lcp, self.is_symmetric()))
    }
}

/// A sparse A by rows and by columns.
pub struct Sparse<'a> {
    lcp: &'a SparseLcp,
    columns: Columns,
    diagonal: Vec<f64>,
    symmetric: bool,
}

/// Compressed columns.
struct Columns {
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl Columns {
    fn of(lcp: &SparseLcp) -> Self {
        let n = lcp.n();
        let mut starts = vec![0; n + 1];
        (0..n).flat_map(|i| lcp.row(i).0).for_each(|&j| starts[j + 1] += 1);
        for j in 0..n {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let (mut rows, mut values) = (vec![0; starts[n]], vec![0.0; starts[n]]);
        for i in 0..n {
            let (columns, entries) = lcp.row(i);
            for (&j, &a) in columns.iter().zip(entries) {
                rows[next[j]] = i;
                values[next[j]] = a;
                next[j] += 1;
            }
        }
        Self { starts, rows, values }
    }

    fn column(&self, j: usize) -> (&[usize], &[f64]) {
        let range = self.starts[j]..self.starts[j + 1];
        (&self.rows[range.clone()], &self.values[range])
    }
}

impl<'a> Sparse<'a> {
    /// Copies the columns. O(nnz).
    #[must_use]
    pub fn new(lcp: &'a SparseLcp) -> Self {
        let columns = Columns::of(lcp);
        let symmetric = (0..lcp.n()).all(|i| lcp.row(i) == columns.column(i));
        let mut diagonal = vec![0.0; lcp.n()];
        for (i, d) in diagonal.iter_mut().enumerate() {
            *d = lcp.entry(i, i);
        }
        Self { lcp, columns, diagonal, symmetric }
    }
}

impl Matrix for Sparse<'_> {
    fn n(&self) -> usize {
        self.lcp.n()
    }

    fn q(&self) -> &[f64] {
        self.lcp.q()
    }

    fn is_symmetric(&self) -> bool {
        self.symmetric
    }

    fn diagonal(&self, i: usize) -> f64 {
        self.diagonal[i]
    }

    fn affine(&self, z: &[f64], w: &mut [f64]) {
        for (i, w) in w.iter_mut().enumerate() {
            let (columns, values) = self.lcp.row(i);
            *w = self.lcp.q()[i] + columns.iter().zip(values).map(|(&j, a)| a * z[j]).sum::<f64>();
        }
    }

    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        for (i, y) in y.iter_mut().enumerate() {
            let (columns, values) = self.lcp.row(i);
            *y = columns.iter().zip(values).map(|(&j, a)| a * x[j]).sum();
        }
    }

    fn add_column(&self, j: usize, f: f64, w: &mut [f64]) {
        let (rows, values) = self.columns.column(j);
        rows.iter().zip(values).for_each(|(&i, a)| w[i] += f * a);
    }

    fn slack(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        self.lcp.slack(z)
    }

    fn factors(&self) -> Box<dyn Factors + '_> {
        Box::new(SparseFactors::new(self.lcp, self.symmetric))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The sparse copy of a dense problem: zeros are not stored.
    pub(crate) fn sparse(lcp: &Lcp) -> SparseLcp {
        let n = lcp.n();
        let (mut starts, mut columns, mut values) = (vec![0], vec![], vec![]);
        for i in 0..n {
            for (j, &a) in lcp.row(i).iter().enumerate().filter(|(_, a)| **a != 0.0) {
                columns.push(j);
                values.push(a);
            }
            starts.push(columns.len());
        }
        SparseLcp::new(starts, columns, values, lcp.q().to_vec()).expect("valid")
    }

    #[test]
    fn rows_and_columns_agree_with_a_loop() {
        for n in [1, 3, 16, 17, 40] {
            for symmetric in [false, true] {
                let entry = |i: usize, j: usize| ((i * 31 + j * 18) % 7) as f64 - 2.0;
                let full = |i: usize, j: usize| if symmetric { entry(i, j) + entry(j, i) } else { entry(i, j) };
                let a = (0..n * n).map(|k| full(k / n, k % n)).collect();
                let q: Vec<f64> = (0..n).map(|i| i as f64 - 1.0).collect();
                let lcp = Lcp::new(n, a, q.clone()).expect("valid");
                let copy = sparse(&lcp);
                let x: Vec<f64> = (0..n).map(|i| (i % 3) as f64).collect();
                let expected: Vec<f64> =
                    (0..n).map(|i| q[i] + (0..n).map(|j| full(i, j) * x[j]).sum::<f64>()).collect();
                check(&Dense::new(&lcp), &x, &expected, symmetric || n == 1);
                check(&Sparse::new(&copy), &x, &expected, symmetric || n == 1);
            }
        }
    }

    fn check(matrix: &impl Matrix, x: &[f64], expected: &[f64], symmetric: bool) {
        assert_eq!(matrix.is_symmetric(), symmetric);
        let mut w = vec![0.0; x.len()];
        matrix.affine(x, &mut w);
        assert_eq!(w, expected);
        assert_eq!(matrix.slack(x).0, expected);
        let mut by_columns = matrix.q().to_vec();
        (0..x.len()).for_each(|j| matrix.add_column(j, x[j], &mut by_columns));
        assert_eq!(by_columns, expected);
        matrix.multiply(x, &mut w);
        assert!(w.iter().zip(expected).zip(matrix.q()).all(|((y, e), q)| *y == e - q));
    }
}
