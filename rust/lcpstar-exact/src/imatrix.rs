//! Integer matrices and index sets.

use super::int::{Int, dot, make_primitive};

/// A dense row-major integer matrix.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct IMatrix {
    rows: usize,
    columns: usize,
    entries: Vec<Int>,
}

impl IMatrix {
    /// From row-major entries; `entries.len() == rows * columns`.
    #[must_use]
    pub fn new(rows: usize, columns: usize, entries: Vec<Int>) -> Self {
        debug_assert_eq!(entries.len(), rows * columns);
        Self { rows, columns, entries }
    }

    /// From a formula for the entry `(i, j)`.
    pub fn from_fn(rows: usize, columns: usize, mut entry: impl FnMut(usize, usize) -> Int) -> Self {
        let mut entries = Vec::with_capacity(rows * columns);
        for i in 0..rows {
            for j in 0..columns {
                entries.push(entry(i, j));
            }
        }
        Self { rows, columns, entries }
    }

    /// From small integers, square.
    #[must_use]
    pub fn from_rows<const N: usize>(rows: &[[i64; N]]) -> Self {
        Self::from_fn(rows.len(), N, |i, j| Int::from(rows[i][j]))
    }

    /// Number of rows: the order `n` of a square matrix.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The entry `(i, j)`.
    #[must_use]
    #[inline]
    pub fn at(&self, i: usize, j: usize) -> &Int {
        &self.entries[i * self.columns + j]
    }

    /// Sets the entry `(i, j)`.
    #[inline]
    pub fn set(&mut self, i: usize, j: usize, x: Int) {
        self.entries[i * self.columns + j] = x;
    }

    /// Row `i`.
    #[must_use]
    pub fn row(&self, i: usize) -> &[Int] {
        &self.entries[i * self.columns..(i + 1) * self.columns]
    }

    /// All entries, row-major.
    #[must_use]
    pub fn entries(&self) -> &[Int] {
        &self.entries
    }

    /// Exchanges two rows.
    pub fn swap_rows(&mut self, i: usize, k: usize) {
        if i != k {
            for j in 0..self.columns {
                self.entries.swap(i * self.columns + j, k * self.columns + j);
            }
        }
    }

    /// The transpose.
    #[must_use]
    pub fn transpose(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |i, j| self.at(j, i).clone())
    }

    /// The rows and columns of two lists of indices.
    #[must_use]
    pub fn block(&self, rows: &[usize], columns: &[usize]) -> Self {
        Self::from_fn(rows.len(), columns.len(), |i, j| self.at(rows[i], columns[j]).clone())
    }

    /// The principal submatrix `A[alpha, alpha]`.
    #[must_use]
    pub fn principal(&self, alpha: &[usize]) -> Self {
        self.block(alpha, alpha)
    }

    /// `A + A'`, whose quadratic form is twice that of `A`.
    #[must_use]
    pub fn symmetric_part(&self) -> Self {
        Self::from_fn(self.rows, self.rows, |i, j| self.at(i, j) + self.at(j, i))
    }

    /// `A x`.
    #[must_use]
    pub fn times(&self, x: &[Int]) -> Vec<Int> {
        (0..self.rows).map(|i| dot(self.row(i), x)).collect()
    }

    /// `A'x`.
    #[must_use]
    pub fn transpose_times(&self, x: &[Int]) -> Vec<Int> {
        let mut y = vec![Int::ZERO; self.columns];
        for i in 0..self.rows {
            if !x[i].is_zero() {
                for j in 0..self.columns {
                    y[j] = &y[j] + &(self.at(i, j) * &x[i]);
                }
            }
        }
        y
    }

    /// `x'A y`.
    #[must_use]
    pub fn form(&self, x: &[Int], y: &[Int]) -> Int {
        dot(x, &self.times(y))
    }

    /// Whether every entry is zero.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.entries.iter().all(Int::is_zero)
    }

    /// The positive multiple whose entries have no common divisor: every class of this crate keeps its verdict.
    #[must_use]
    pub fn primitive(mut self) -> Self {
        make_primitive(&mut self.entries);
        self
    }
}

/// The indices in the bit mask `alpha`.
#[must_use]
pub fn indices(alpha: u64) -> Vec<usize> {
    let mut rest = alpha;
    let mut list = Vec::with_capacity(alpha.count_ones() as usize);
    while rest != 0 {
        list.push(rest.trailing_zeros() as usize);
        rest &= rest - 1;
    }
    list
}

/// The complement of `alpha` in `0..n`.
#[must_use]
pub fn complement(alpha: u64, n: usize) -> u64 {
    !alpha & full(n)
}

/// The mask of `0..n`.
#[must_use]
pub fn full(n: usize) -> u64 {
    if n >= 64 { u64::MAX } else { (1 << n) - 1 }
}

/// All nonempty subsets of `0..n`, smaller ones first: the first hit is a witness of least order.
pub fn by_size(n: usize) -> impl Iterator<Item = u64> {
    (1..=n).flat_map(move |size| of_size(n, size))
}

/// All subsets of `0..n` with `size` elements, in increasing order of their masks (Gosper's step).
pub fn of_size(n: usize, size: usize) -> impl Iterator<Item = u64> {
    let first = if size > n || size == 0 { None } else { Some(full(size)) };
    std::iter::successors(first, move |&mask| {
        let low = mask & mask.wrapping_neg();
        let ripple = mask.checked_add(low)?;
        let next = ripple | (((mask ^ ripple) >> 2) / low);
        (next <= full(n)).then_some(next)
    })
}

/// `x` on `alpha`, zero elsewhere.
#[must_use]
pub fn embed(x: &[Int], alpha: &[usize], n: usize) -> Vec<Int> {
    let mut full = vec![Int::ZERO; n];
    for (value, &i) in x.iter().zip(alpha) {
        full[i] = value.clone();
    }
    full
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subsets_come_by_size_and_all_of_them() {
        let all: Vec<u64> = by_size(4).collect();
        assert_eq!(all.len(), 15);
        assert!(all.windows(2).all(|w| w[0].count_ones() <= w[1].count_ones() && w[0] != w[1]));
        assert_eq!(of_size(3, 4).count() + of_size(3, 0).count() + by_size(0).count(), 0);
    }
}
