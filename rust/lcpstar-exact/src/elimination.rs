//! Fraction-free elimination: determinants, solutions and null spaces over the integers [Bar68].

use super::imatrix::IMatrix;
use super::int::{Int, make_primitive};
use std::convert::Infallible;

/// A matrix brought to `d` times its reduced row echelon form, with integers only.
#[derive(Clone, Debug)]
pub struct Reduced {
    matrix: IMatrix,
    pivots: Vec<usize>,
    d: Int,
    swaps: usize,
}

/// Fraction-free Gauss-Jordan elimination, looking for pivots in the first `pivot_columns` columns. O(rows * columns * rank).
#[must_use]
pub fn reduce(matrix: IMatrix, pivot_columns: usize) -> Reduced {
    let Ok(reduced) = reduce_unless::<Infallible>(matrix, pivot_columns, || Ok(()));
    reduced
}

/// As [`reduce`], with a question before each row that is changed, which may take a while where the integers are long.
///
/// # Errors
/// What `stopped` says.
pub fn reduce_unless<E>(
    mut matrix: IMatrix,
    pivot_columns: usize,
    stopped: impl Fn() -> Result<(), E>,
) -> Result<Reduced, E> {
    let (rows, columns) = (matrix.rows(), matrix.columns());
    let mut d = Int::ONE;
    let mut pivots = Vec::new();
    let mut swaps = 0;
    for column in 0..pivot_columns {
        let r = pivots.len();
        if r == rows {
            break;
        }
        let Some(found) = (r..rows).find(|&i| !matrix.at(i, column).is_zero()) else {
            continue;
        };
        if found != r {
            matrix.swap_rows(found, r);
            swaps += 1;
        }
        let pivot = matrix.at(r, column).clone();
        for i in (0..rows).filter(|&i| i != r) {
            stopped()?;
            let factor = matrix.at(i, column).clone();
            for j in 0..columns {
                if j != column {
                    let x = Int::cross(&pivot, matrix.at(i, j), &factor, matrix.at(r, j), &d);
                    matrix.set(i, j, x);
                }
            }
            matrix.set(i, column, Int::ZERO);
        }
        // Earlier pivot columns now hold the new pivot on their diagonal: one common denominator.
        d = pivot;
        pivots.push(column);
    }
    Ok(Reduced { matrix, pivots, d, swaps })
}

impl Reduced {
    /// Number of pivots.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.pivots.len()
    }

    /// The pivot columns.
    #[must_use]
    pub fn pivots(&self) -> &[usize] {
        &self.pivots
    }

    /// A basis of `{x : first columns * x = 0}` for the first `columns` columns, primitive integer vectors.
    #[must_use]
    pub fn null_space(&self, columns: usize) -> Vec<Vec<Int>> {
        let negative = self.d.sign() < 0;
        (0..columns)
            .filter(|c| !self.pivots.contains(c))
            .map(|free| {
                let mut x = vec![Int::ZERO; columns];
                x[free] = self.d.abs();
                for (row, &column) in self.pivots.iter().enumerate() {
                    let entry = self.matrix.at(row, free);
                    x[column] = if negative { entry.clone() } else { -entry };
                }
                make_primitive(&mut x);
                x
            })
            .collect()
    }

    /// `(x, t)` with `t > 0` and `first columns * x = t * column c`, free variables zero; `None` if there is none.
    #[must_use]
    pub fn particular(&self, columns: usize, c: usize) -> Option<(Vec<Int>, Int)> {
        if (self.rank()..self.matrix.rows()).any(|row| !self.matrix.at(row, c).is_zero()) {
            return None;
        }
        let negative = self.d.sign() < 0;
        let mut x = vec![Int::ZERO; columns];
        for (row, &column) in self.pivots.iter().enumerate() {
            let entry = self.matrix.at(row, c);
            x[column] = if negative { -entry } else { entry.clone() };
        }
        Some((x, self.d.abs()))
    }

    /// The determinant, when the first columns were square and the elimination looked at all of them.
    #[must_use]
    pub fn determinant(&self) -> Int {
        if self.rank() < self.matrix.rows() {
            Int::ZERO
        } else if self.swaps % 2 == 1 {
            -&self.d
        } else {
            self.d.clone()
        }
    }
}

/// `det A`. O(n^3).
#[must_use]
pub fn determinant(a: &IMatrix) -> Int {
    let Ok(determinant) = determinant_unless::<Infallible>(a, || Ok(()));
    determinant
}

/// As [`determinant`], with the question of [`reduce_unless`].
///
/// # Errors
/// What `stopped` says.
pub fn determinant_unless<E>(a: &IMatrix, stopped: impl Fn() -> Result<(), E>) -> Result<Int, E> {
    let n = a.rows();
    let mut m = a.clone();
    let mut previous = Int::ONE;
    let mut negative = false;
    for k in 0..n {
        let Some(found) = (k..n).find(|&i| !m.at(i, k).is_zero()) else {
            return Ok(Int::ZERO);
        };
        if found != k {
            m.swap_rows(found, k);
            negative = !negative;
        }
        for i in k + 1..n {
            stopped()?;
            for j in k + 1..n {
                let x = Int::cross(m.at(k, k), m.at(i, j), m.at(i, k), m.at(k, j), &previous);
                m.set(i, j, x);
            }
        }
        previous = m.at(k, k).clone();
    }
    Ok(if negative { -&previous } else { previous })
}

/// The rank of a matrix.
#[must_use]
pub fn rank(a: &IMatrix) -> usize {
    reduce(a.clone(), a.columns()).rank()
}

/// `(t M, t)` for the principal pivot transform M of A on `alpha`, `t = |det A[alpha, alpha]|`; `None` if it is singular. O(n^3).
#[must_use]
pub fn principal_pivot_transform(a: &IMatrix, alpha: &[usize]) -> Option<(IMatrix, Int)> {
    let n = a.rows();
    let inside: Vec<bool> = (0..n).map(|i| alpha.contains(&i)).collect();
    // Unknowns: z off alpha and w on alpha are given, solve  [A_aa 0; A_ba -I] (z_a, w_b) = [I -A_ab; 0 -A_bb] (w_a, z_b).
    let system = IMatrix::from_fn(n, 2 * n, |i, j| {
        if j < n {
            match (inside[j], i == j) {
                (true, _) => a.at(i, j).clone(),
                (false, true) => Int::from(-1),
                (false, false) => Int::ZERO,
            }
        } else {
            let j = j - n;
            match (inside[j], i == j) {
                (true, true) => Int::ONE,
                (true, false) => Int::ZERO,
                (false, _) => -a.at(i, j),
            }
        }
    });
    let reduced = reduce(system, n);
    if reduced.rank() < n {
        return None;
    }
    let negative = reduced.d.sign() < 0;
    let transform = IMatrix::from_fn(n, n, |i, j| {
        let x = reduced.matrix.at(i, n + j);
        if negative { -x } else { x.clone() }
    });
    Some((transform, reduced.d.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn determinant_and_null_space() {
        let a = IMatrix::from_rows(&[[0, 1, 1], [2, 0, 2], [-4, -5, 0]]);
        assert_eq!(determinant(&a), Int::from(-18));
        assert_eq!(reduce(a.clone(), 3).determinant(), Int::from(-18));
        let b = IMatrix::from_rows(&[[1, 2, 3], [2, 4, 6], [1, 0, 1]]);
        let reduced = reduce(b.clone(), 3);
        assert_eq!(reduced.rank(), 2);
        let basis = reduced.null_space(3);
        assert_eq!(basis.len(), 1);
        assert!(b.times(&basis[0]).iter().all(Int::is_zero));
        assert_eq!(determinant(&b), Int::ZERO);
    }

    #[test]
    fn solves_with_a_positive_denominator() {
        let a = IMatrix::from_rows(&[[0, 1, 3], [-2, 1, 5]]);
        let (x, t) = reduce(a, 2).particular(2, 2).expect("nonsingular");
        assert_eq!((x, t), (vec![Int::from(-2), Int::from(6)], Int::from(2)));
    }

    #[test]
    fn ppt_of_the_papers_example_4() {
        let a = IMatrix::from_rows(&[[0, 1, 1], [2, 0, 1], [-1, -1, 0]]);
        let (inverse, t) = principal_pivot_transform(&a, &[0, 1, 2]).expect("det = -3");
        assert_eq!(t, Int::from(3));
        assert_eq!(inverse, IMatrix::from_rows(&[[-1, 1, -1], [1, -1, -2], [2, 1, 2]]));
        assert!(principal_pivot_transform(&a, &[0]).is_none());
        let (m, _) = principal_pivot_transform(&a, &[0, 1]).expect("det = -2");
        assert_eq!(m, IMatrix::from_rows(&[[0, 1, -1], [2, 0, -2], [-2, -1, 3]]));
    }
}
