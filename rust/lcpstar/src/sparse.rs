//! LCP(q, A) with a sparse A, by rows.

use crate::error::{LcpError, Result};
use crate::linalg::kernels::dot_compensated;
use crate::problem::{Lcp, check_finite};

/// LCP(q, A): row i of A has the entries `values[starts[i]..starts[i + 1]]` in the columns `columns[..]` of that range.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseLcp {
    starts: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
    q: Vec<f64>,
}

impl SparseLcp {
    /// Takes ownership of compressed rows; columns ascending in each row. O(nnz).
    ///
    /// # Errors
    /// `WrongLength`, `BadIndex` (out of range, repeated or not ascending) or `NotFinite`.
    pub fn new(starts: Vec<usize>, columns: Vec<usize>, values: Vec<f64>, q: Vec<f64>) -> Result<Self> {
        let n = q.len();
        if starts.len() != n + 1 {
            return Err(LcpError::WrongLength { name: "A.indptr", expected: n + 1, found: starts.len() });
        }
        if columns.len() != values.len() || starts[n] != values.len() || starts[0] != 0 {
            return Err(LcpError::WrongLength { name: "A.indices", expected: starts[n], found: columns.len() });
        }
        if let Some(i) = (0..n).find(|&i| starts[i] > starts[i + 1] || starts[i + 1] > values.len()) {
            return Err(LcpError::WrongLength { name: "A.indptr", expected: starts[i], found: starts[i + 1] });
        }
        for i in 0..n {
            let row = &columns[starts[i]..starts[i + 1]];
            let repeated = row.windows(2).find(|pair| pair[0] >= pair[1]).map(|pair| pair[1]);
            let outside = row.iter().copied().find(|&j| j >= n);
            if let Some(j) = outside.or(repeated) {
                let index = i64::try_from(j).unwrap_or(i64::MAX);
                return Err(LcpError::BadIndex { name: "A.indices", index, n, repeated: outside.is_none() });
            }
        }
        check_finite("A.data", &values)?;
        check_finite("q", &q)?;
        Ok(Self { starts, columns, values, q })
    }

    /// Order of the problem.
    #[must_use]
    pub fn n(&self) -> usize {
        self.q.len()
    }

    /// `q`.
    #[must_use]
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Columns and values of row i.
    #[must_use]
    pub fn row(&self, i: usize) -> (&[usize], &[f64]) {
        let range = self.starts[i]..self.starts[i + 1];
        (&self.columns[range.clone()], &self.values[range])
    }

    /// The entries of a dense A that are not zero. O(n^2).
    #[must_use]
    pub fn from_dense(lcp: &Lcp) -> Self {
        let n = lcp.n();
        let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        for i in 0..n {
            for (j, &a) in lcp.row(i).iter().enumerate().filter(|&(_, &a)| a != 0.0) {
                columns.push(j);
                values.push(a);
            }
            starts.push(columns.len());
        }
        Self { starts, columns, values, q: lcp.q().to_vec() }
    }

    /// The same problem with a dense A. O(n^2).
    #[must_use]
    pub fn to_dense(&self) -> Lcp {
        let n = self.n();
        let mut a = vec![0.0; n * n];
        for i in 0..n {
            let (columns, values) = self.row(i);
            for (&j, &x) in columns.iter().zip(values) {
                a[i * n + j] = x;
            }
        }
        Lcp::trusted(n, a, self.q.clone())
    }

    /// The entries that are stored, row by row.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The same pattern with other numbers, as trusted as these: `f(i, j, a_ij)`, and q.
    pub(crate) fn mapped(&self, f: impl Fn(usize, usize, f64) -> f64, q: Vec<f64>) -> Self {
        let mut values = self.values.clone();
        for i in 0..self.n() {
            for k in self.starts[i]..self.starts[i + 1] {
                values[k] = f(i, self.columns[k], self.values[k]);
            }
        }
        Self { starts: self.starts.clone(), columns: self.columns.clone(), values, q }
    }

    /// A number per index, itself an index, that is the same for i and j where `a_ij` or `a_ji` is not 0, or a chain of such pairs
    /// joins them: union-find with path halving, O(nnz log n) at most. [TL84]
    #[must_use]
    pub fn parts(&self) -> Vec<usize> {
        let mut parent: Vec<usize> = (0..self.n()).collect();
        let root = |parent: &mut [usize], mut i: usize| {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        };
        for i in 0..self.n() {
            let (columns, values) = self.row(i);
            for (&j, _) in columns.iter().zip(values).filter(|(_, a)| **a != 0.0) {
                let (a, b) = (root(&mut parent, i), root(&mut parent, j));
                parent[a.max(b)] = a.min(b);
            }
        }
        (0..self.n()).map(|i| root(&mut parent, i)).collect()
    }

    /// `w = A z + q` in twice the working precision, and its rounding scale `|A||z| + |q|`. O(nnz).
    #[must_use]
    pub fn slack(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut gathered = Vec::new();
        (0..self.n()).map(|i| self.row_dot(i, self.q[i], z, &mut gathered)).unzip()
    }

    /// `start + A_i z` in twice the working precision, and the sum of magnitudes.
    pub(crate) fn row_dot(&self, i: usize, start: f64, z: &[f64], gathered: &mut Vec<f64>) -> (f64, f64) {
        let (columns, values) = self.row(i);
        gathered.clear();
        gathered.extend(columns.iter().map(|&j| z[j]));
        dot_compensated(start, values, gathered)
    }
}
