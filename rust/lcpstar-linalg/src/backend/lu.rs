//! `P B = L U` by faer, in memory that is used again.

use faer::dyn_stack::{MemStack, StackReq};
use faer::linalg::lu::partial_pivoting as lu;
use faer::perm::PermRef;
use faer::{Conj, MatMut, MatRef, Par, Spec};

/// Factors by partial pivoting. Grows to the largest order it has held.
#[derive(Clone, Debug, Default)]
pub(super) struct InPlaceLu {
    n: usize,
    /// Rows of B, which are the columns of what faer factors.
    factor: Vec<f64>,
    forward: Vec<usize>,
    backward: Vec<usize>,
}

impl InPlaceLu {
    /// Workspace of a factorisation, and of a solution for `m` right-hand sides.
    pub fn scratch(n: usize, m: usize) -> StackReq {
        lu::factor::lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Spec::default())
            .or(lu::solve::solve_transpose_in_place_scratch::<usize, f64>(n, m, Par::Seq))
    }

    /// The rows of a matrix of order `n`, to be filled.
    pub fn rows(&mut self, n: usize) -> &mut [f64] {
        self.n = n;
        if self.factor.len() < n * n {
            self.factor.resize(n * n, 0.0);
        }
        &mut self.factor[..n * n]
    }

    /// The same, as they are.
    pub fn factors(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.factor[..self.n * self.n], self.n, self.n)
    }

    /// Factors the rows. O(n^3). `false` if a pivot is zero or not finite.
    pub fn factor(&mut self, stack: &mut MemStack) -> bool {
        let n = self.n;
        self.forward.resize(n, 0);
        self.backward.resize(n, 0);
        let matrix = MatMut::from_column_major_slice_mut(&mut self.factor[..n * n], n, n);
        lu::factor::lu_in_place(matrix, &mut self.forward, &mut self.backward, Par::Seq, stack, Spec::default());
        (0..n).all(|i| is_pivot(self.factor[i * n + i]))
    }

    /// Replaces `x` by `B^-1 x`. O(n^2) a column.
    pub fn solve(&self, x: MatMut<'_, f64>, stack: &mut MemStack) {
        let permutation = PermRef::new_checked(&self.forward, &self.backward, self.n);
        let factor = self.factors();
        lu::solve::solve_transpose_in_place_with_conj(factor, factor, permutation, Conj::No, x, Par::Seq, stack);
    }
}

/// Neither zero nor overflown.
pub(super) fn is_pivot(x: f64) -> bool {
    x != 0.0 && x.is_finite()
}
