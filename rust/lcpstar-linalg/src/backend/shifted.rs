//! `A + diag(d)` factored again and again for the same dense A and changing `d > 0`, without allocating.

use super::lu::InPlaceLu;
use crate::blocked::BlockFactor;
use crate::cutovers::SHIFTED_LIBRARY_FROM;
use crate::kernels;
use faer::diag::DiagRef;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::{self, factor::LdltRegularization};
use faer::linalg::cholesky::llt::{self, factor::LltRegularization};
use faer::{MatMut, Par, Spec};

/// What the factorisation can use of A.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Structure {
    /// A = A': Cholesky.
    Symmetric,
    /// `J A` is symmetric for the signs `J` on the diagonal, as in the optimality conditions of a quadratic program
    /// `[[H, -R'], [R, 0]]`: `J (A + D)` is quasi-definite when A is PSD, and LDL' exists in any order. [Van95]
    SignSymmetric(Vec<i8>),
    /// LU with partial pivoting.
    General,
}

impl Structure {
    /// Compares A with A' tile by tile, then finds the signs by walking the graph of A. O(n^2).
    #[must_use]
    pub fn of(n: usize, a: &[f64]) -> Self {
        if kernels::is_symmetric(n, a) {
            return Self::Symmetric;
        }
        const TILE: usize = 16;
        let mut sign_symmetric = true;
        for top in (0..n).step_by(TILE) {
            for left in (0..=top).step_by(TILE) {
                for i in top..(top + TILE).min(n) {
                    for j in left..(left + TILE).min(n) {
                        let (x, y) = (a[i * n + j], a[j * n + i]);
                        sign_symmetric &= x.abs() == y.abs();
                    }
                }
            }
            if !sign_symmetric {
                return Self::General;
            }
        }
        Self::by_signs(n, a)
    }

    /// As [`of`](Self::of), for `|A| = |A'|`.
    fn by_signs(n: usize, a: &[f64]) -> Self {
        let mut signs = vec![0i8; n];
        let mut stack = Vec::new();
        for root in 0..n {
            if signs[root] != 0 {
                continue;
            }
            signs[root] = 1;
            stack.push(root);
            while let Some(i) = stack.pop() {
                for j in (0..n).filter(|&j| j != i) {
                    let (x, y) = (a[i * n + j], a[j * n + i]);
                    if x == 0.0 && y == 0.0 {
                        continue;
                    }
                    let relation = if x == y { 1 } else { -1 };
                    if x != y && x != -y {
                        return Self::General;
                    }
                    match signs[j] {
                        0 => {
                            signs[j] = relation * signs[i];
                            stack.push(j);
                        }
                        s if s != relation * signs[i] => return Self::General,
                        _ => {}
                    }
                }
            }
        }
        Self::SignSymmetric(signs)
    }
}

/// The factorisation of `A + D`, or by a library of `S (A + D) S`, `S = diag(1 + d)^-1/2`, and its workspace.
pub struct ShiftedFactor {
    n: usize,
    structure: Structure,
    /// Whether the last factorisation is LU.
    pivoted: bool,
    /// Cholesky below the order [`SHIFTED_LIBRARY_FROM`].
    own: BlockFactor,
    /// The factors, of LU or not.
    lu: InPlaceLu,
    scale: Vec<f64>,
    memory: MemBuffer,
}

/// A pivot of the scaled matrix below this, or of the wrong sign, ends LDL'.
const REGULARISATION: f64 = 1e-14;

impl ShiftedFactor {
    /// Allocates everything for the order `n`.
    #[must_use]
    pub fn new(n: usize, structure: Structure) -> Self {
        let scratch = llt::factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Spec::default())
            .or(ldlt::factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Spec::default()))
            .or(InPlaceLu::scratch(n, 1));
        let mut lu = InPlaceLu::default();
        lu.rows(n);
        Self {
            n,
            structure,
            pivoted: false,
            own: BlockFactor::default(),
            lu,
            scale: vec![0.0; n],
            memory: MemBuffer::new(scratch),
        }
    }

    /// The structure of A.
    #[must_use]
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// Factors `A + diag(d)` for row-major A by what its structure allows, or, when that meets a pivot of the wrong sign,
    /// by LU. O(n^3), no allocation. `false` when neither works.
    pub fn factor(&mut self, a: &[f64], d: &[f64]) -> bool {
        (self.structure != Structure::General && self.factor_unpivoted(a, d)) || self.factor_pivoted(a, d)
    }

    /// `true` after a factorisation without pivoting, whose answers may need more than refinement.
    #[must_use]
    pub fn can_pivot(&self) -> bool {
        !self.pivoted
    }

    fn is_own(&self) -> bool {
        !self.pivoted && self.structure == Structure::Symmetric && self.n < SHIFTED_LIBRARY_FROM
    }

    fn factor_unpivoted(&mut self, a: &[f64], d: &[f64]) -> bool {
        self.pivoted = false;
        if self.is_own() {
            return self.own.cholesky_shifted(a, d);
        }
        self.load(a, d);
        let n = self.n;
        let matrix = MatMut::from_column_major_slice_mut(self.lu.rows(n), n, n);
        let stack = MemStack::new(&mut self.memory);
        match &self.structure {
            Structure::Symmetric => {
                let plain = LltRegularization::default();
                llt::factor::cholesky_in_place(matrix, plain, Par::Seq, stack, Spec::default()).is_ok()
            }
            Structure::SignSymmetric(signs) => {
                let regularization = LdltRegularization {
                    dynamic_regularization_signs: Some(signs),
                    dynamic_regularization_delta: REGULARISATION,
                    dynamic_regularization_epsilon: REGULARISATION,
                };
                ldlt::factor::cholesky_in_place(matrix, regularization, Par::Seq, stack, Spec::default())
                    .is_ok_and(|info| info.dynamic_regularization_count == 0)
            }
            Structure::General => false,
        }
    }

    /// LU of `A + diag(d)` with partial pivoting. O(n^3), no allocation.
    pub fn factor_pivoted(&mut self, a: &[f64], d: &[f64]) -> bool {
        self.pivoted = true;
        self.load(a, d);
        self.lu.factor(MemStack::new(&mut self.memory))
    }

    /// `S (A + D) S`, with rows times their signs for LDL'. Row i of A becomes column i: the transpose for LU.
    fn load(&mut self, a: &[f64], d: &[f64]) {
        let n = self.n;
        for (s, d) in self.scale.iter_mut().zip(d) {
            *s = 1.0 / (1.0 + d).sqrt();
        }
        let factor = self.lu.rows(n);
        let lower_only = !self.pivoted && self.structure == Structure::Symmetric;
        for i in 0..n {
            let mut s = self.scale[i];
            if let (false, Structure::SignSymmetric(signs)) = (self.pivoted, &self.structure) {
                s *= f64::from(signs[i]);
            }
            let first = if lower_only { i } else { 0 };
            let (row, column) = (&a[i * n + first..(i + 1) * n], &mut factor[i * n + first..(i + 1) * n]);
            for ((c, x), t) in column.iter_mut().zip(row).zip(&self.scale[first..]) {
                *c = s * x * t;
            }
            column[i - first] += s * d[i] * self.scale[i];
        }
    }

    /// Replaces `x` by `(A + D)^-1 x`. O(n^2), no allocation.
    pub fn solve(&mut self, x: &mut [f64]) {
        if self.is_own() {
            return self.own.solve(x);
        }
        let n = self.n;
        for (x, s) in x.iter_mut().zip(&self.scale) {
            *x *= s;
        }
        let stack = MemStack::new(&mut self.memory);
        match &self.structure {
            _ if self.pivoted => self.lu.solve(MatMut::from_column_major_slice_mut(&mut *x, n, 1), stack),
            Structure::Symmetric => {
                let rhs = MatMut::from_column_major_slice_mut(&mut *x, n, 1);
                llt::solve::solve_in_place(self.lu.factors(), rhs, Par::Seq, stack);
            }
            Structure::SignSymmetric(signs) => {
                for (x, &s) in x.iter_mut().zip(signs) {
                    *x *= f64::from(s);
                }
                let rhs = MatMut::from_column_major_slice_mut(&mut *x, n, 1);
                let diagonal: DiagRef<'_, f64> = self.lu.factors().diagonal();
                ldlt::solve::solve_in_place(self.lu.factors(), diagonal, rhs, Par::Seq, stack);
            }
            Structure::General => {}
        }
        for (x, s) in x.iter_mut().zip(&self.scale) {
            *x *= s;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(n: usize, a: &[f64], expected: &Structure) {
        let structure = Structure::of(n, a);
        assert_eq!(&structure, expected);
        let d: Vec<f64> = (0..n).map(|i| 10f64.powi(i as i32 - 3)).collect();
        let x: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
        let mut b: Vec<f64> = (0..n).map(|i| d[i] * x[i] + (0..n).map(|j| a[i * n + j] * x[j]).sum::<f64>()).collect();
        let mut factor = ShiftedFactor::new(n, structure);
        for _ in 0..2 {
            assert!(factor.factor(a, &d));
        }
        factor.solve(&mut b);
        for (b, x) in b.iter().zip(&x) {
            assert!((b - x).abs() < 1e-10 * x, "{b} {x}");
        }
    }

    #[test]
    fn each_structure_is_found_and_solved() {
        check(3, &[2.0, 1.0, 0.0, 1.0, 3.0, 1.0, 0.0, 1.0, 1.0], &Structure::Symmetric);
        check(3, &[2.0, 1.0, -1.0, 1.0, 2.0, 2.0, 1.0, -2.0, 0.0], &Structure::SignSymmetric(vec![1, 1, -1]));
        check(3, &[2.0, 1.0, -1.0, 0.5, 2.0, 2.0, 1.0, -2.0, 0.0], &Structure::General);
        check(3, &[0.0, 1.0, -1.0, -1.0, 0.0, 1.0, 1.0, -1.0, 0.0], &Structure::General);
    }
}
