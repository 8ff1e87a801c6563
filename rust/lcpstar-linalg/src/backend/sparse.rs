//! Sparse factorisations of `A + diag(d)`: Cholesky of a symmetric A, LU otherwise; the ordering is found once.

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, Lu, SymbolicLlt, SymbolicLu};
use faer::sparse::{SparseColMat, Triplet};

enum Symbolic {
    Llt(SymbolicLlt<usize>),
    Lu(SymbolicLu<usize>),
}

enum Numeric {
    Llt(Llt<usize, f64>),
    Lu(Box<Lu<usize, f64>>),
}

/// A sparse matrix whose diagonal changes.
pub struct SparseFactor {
    matrix: SparseColMat<usize, f64>,
    /// Position and value in A of each diagonal entry.
    diagonal: Vec<(usize, f64)>,
    symbolic: Symbolic,
    numeric: Option<Numeric>,
}

impl SparseFactor {
    /// Analyses the pattern of A, given by its entries `(row, column, value)`, and of the diagonal. `None` when the
    /// matrix is too large to index.
    #[must_use]
    pub fn new(n: usize, entries: &[(usize, usize, f64)], symmetric: bool) -> Option<Self> {
        let mut triplets: Vec<Triplet<usize, usize, f64>> =
            entries.iter().map(|&(i, j, a)| Triplet::new(i, j, a)).collect();
        triplets.extend((0..n).map(|i| Triplet::new(i, i, 0.0)));
        let matrix = SparseColMat::try_new_from_triplets(n, n, &triplets).ok()?;
        let (starts, rows, values) = (matrix.col_ptr(), matrix.row_idx(), matrix.val());
        let mut diagonal = Vec::with_capacity(n);
        for j in 0..n {
            let k = (starts[j]..starts[j + 1]).find(|&k| rows[k] == j)?;
            diagonal.push((k, values[k]));
        }
        let symbolic = if symmetric {
            Symbolic::Llt(SymbolicLlt::try_new(matrix.symbolic(), Side::Lower).ok()?)
        } else {
            Symbolic::Lu(SymbolicLu::try_new(matrix.symbolic()).ok()?)
        };
        Some(Self { matrix, diagonal, symbolic, numeric: None })
    }

    /// Factors `A + diag(d)`; `false` when it cannot.
    pub fn factor(&mut self, d: &[f64]) -> bool {
        for (&(k, a), d) in self.diagonal.iter().zip(d) {
            self.matrix.val_mut()[k] = a + d;
        }
        self.numeric = match &self.symbolic {
            Symbolic::Llt(symbolic) => {
                Llt::try_new_with_symbolic(symbolic.clone(), self.matrix.as_ref(), Side::Lower).ok().map(Numeric::Llt)
            }
            Symbolic::Lu(symbolic) => Lu::try_new_with_symbolic(symbolic.clone(), self.matrix.as_ref())
                .ok()
                .map(|factor| Numeric::Lu(Box::new(factor))),
        };
        self.numeric.is_some()
    }

    /// Replaces `x` by `(A + D)^-1 x`; by NaN without a factorisation.
    pub fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        let mut rhs = faer::Mat::from_fn(n, 1, |i, _| x[i]);
        match &self.numeric {
            Some(Numeric::Llt(factor)) => factor.solve_in_place(&mut rhs),
            Some(Numeric::Lu(factor)) => factor.solve_in_place(&mut rhs),
            None => rhs.fill(f64::NAN),
        }
        for (i, x) in x.iter_mut().enumerate() {
            *x = rhs[(i, 0)];
        }
    }
}
