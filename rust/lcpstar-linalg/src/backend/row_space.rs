//! The row space and the null space of a rectangular matrix `C`, from one pivoted QR of `C'`.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::householder;
use faer::linalg::solvers::ColPivQr;
use faer::linalg::triangular_solve;
use faer::{Conj, Mat, MatRef, Par};

/// `C' P = Q R` with the numerical rank of `C`.
pub struct RowSpace {
    m: usize,
    n: usize,
    rank: usize,
    factor: ColPivQr<f64>,
}

impl RowSpace {
    /// Factors a row-major `m x n` matrix; `R_kk <= tolerance |R_00|` counts as zero. O(m n min(m, n)).
    #[must_use]
    pub fn new(m: usize, n: usize, c: &[f64], tolerance: f64) -> Self {
        // A row-major C is a column-major C'.
        let factor = ColPivQr::new(MatRef::from_column_major_slice(c, n, m));
        let size = m.min(n);
        let r = factor.thin_R();
        let threshold = if size > 0 { tolerance * r[(0, 0)].abs() } else { 0.0 };
        let rank = (0..size).take_while(|&k| r[(k, k)].abs() > threshold).count();
        Self { m, n, rank, factor }
    }

    /// Numerical rank.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// The shortest `x` with `C x = b` in the rows that span the row space. O(m n).
    #[must_use]
    pub fn shortest_solution(&self, b: &[f64]) -> Vec<f64> {
        debug_assert!(b.len() == self.m);
        let k = self.rank;
        let r = self.factor.thin_R();
        let (forward, _) = self.factor.P().arrays();
        // (C' P)' x = R' Q' x = P' b: the first k equations of R' y = P' b, then x = Q y.
        let mut y = Mat::from_fn(self.n, 1, |i, _| if i < k { b[forward[i]] } else { 0.0 });
        let triangle = r.get(..k, ..k).transpose();
        triangular_solve::solve_lower_triangular_in_place(triangle, y.as_mut().subrows_mut(0, k), Par::Seq);
        self.apply_q(&mut y);
        (0..self.n).map(|i| y[(i, 0)]).collect()
    }

    /// A basis of the null space of `C`, one vector after the other, `n - rank` of them, orthonormal. O(n^2 (n - rank)).
    #[must_use]
    pub fn null_space(&self) -> Vec<Vec<f64>> {
        let k = self.rank;
        let mut basis = Mat::from_fn(self.n, self.n - k, |i, j| f64::from(u8::from(i == k + j)));
        self.apply_q(&mut basis);
        (0..self.n - k).map(|j| (0..self.n).map(|i| basis[(i, j)]).collect()).collect()
    }

    /// Indices of `rank` rows of C that span its row space, in the order of the pivots.
    #[must_use]
    pub fn spanning_rows(&self) -> &[usize] {
        &self.factor.P().arrays().0[..self.rank]
    }

    /// `y := H_1 .. H_rank y`: the reflectors beyond the rank are rounding, or undefined where nothing was left.
    fn apply_q(&self, y: &mut Mat<f64>) {
        if self.rank == 0 {
            return;
        }
        let basis = self.factor.Q_basis().get(.., ..self.rank);
        let coefficients = self.factor.Q_coeff().get(.., ..self.rank);
        let scratch = householder::apply_block_householder_sequence_on_the_left_in_place_scratch::<f64>(
            self.n,
            coefficients.nrows(),
            y.ncols(),
        );
        householder::apply_block_householder_sequence_on_the_left_in_place_with_conj(
            basis,
            coefficients,
            Conj::No,
            y.as_mut(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rank_solution_and_null_space_of_a_deficient_matrix() {
        // Row 2 = row 0 + row 1.
        let c = [1.0, 2.0, 0.0, 1.0, 0.0, 1.0, 3.0, -1.0, 1.0, 3.0, 3.0, 0.0];
        let space = RowSpace::new(3, 4, &c, 1e-12);
        assert_eq!((space.rank(), space.spanning_rows().len()), (2, 2));
        let times = |x: &[f64]| -> Vec<f64> { (0..3).map(|i| (0..4).map(|j| c[4 * i + j] * x[j]).sum()).collect() };
        for (found, expected) in times(&space.shortest_solution(&[1.0, 2.0, 3.0])).iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - expected).abs() < 1e-14);
        }
        let null = space.null_space();
        assert_eq!(null.len(), 2);
        assert!(null.iter().all(|v| times(v).iter().all(|x| x.abs() < 1e-14)));
        let zero = RowSpace::new(2, 3, &[0.0; 6], 1e-12);
        assert_eq!((zero.rank(), zero.shortest_solution(&[1.0, 1.0])), (0, vec![0.0; 3]));
    }
}
