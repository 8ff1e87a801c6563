//! Cholesky factors of a principal block `A[alpha, alpha]` in memory that is used again, right-looking in panels
//! of eight rows.
//!
//! For the orders of pivoting methods (10 to 500) the libraries spend more on packing and allocation than on the
//! arithmetic; see `benches/record/backend.md`. Larger blocks are theirs, see [`backend`](super::backend).

use super::kernels::LANES;
use super::update::{Window, add_products};
use crate::square::Square;
use multiversion::multiversion;

/// Rows of a panel.
const PANEL: usize = LANES;
/// Rows of a block of panels.
const BLOCK: usize = 16;
/// Rows of the trailing part updated together, from their diagonal on.
const STRIP: usize = 16;

/// Numbers that begin at a multiple of a vector register's size, so that no vector of a row lies in two cache lines.
#[derive(Debug, Default)]
struct Aligned {
    numbers: Vec<f64>,
    start: usize,
}

impl Aligned {
    /// Makes room for `len` numbers.
    fn grow(&mut self, len: usize) {
        if self.numbers.len() < len + LANES {
            self.numbers.resize(len + LANES, 0.0);
            // On the stack machine of an interpreter this may be `usize::MAX`.
            self.start = self.numbers.as_ptr().align_offset(64).min(LANES);
        }
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.grow(self.len());
        copy.copy_from_slice(self);
        copy
    }
}

impl std::ops::Deref for Aligned {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.numbers[self.start..]
    }
}

impl std::ops::DerefMut for Aligned {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[self.start..]
    }
}

/// A factored principal block. Grows to the largest it has held.
#[derive(Clone, Debug, Default)]
pub struct BlockFactor {
    m: usize,
    stride: usize,
    /// Row-major; R in the upper triangle.
    rows: Aligned,
    /// The panel's factors with their sign changed, term by term.
    panel: Aligned,
    /// Least pivots.
    floors: Vec<f64>,
}

impl BlockFactor {
    /// `A[alpha, alpha] + shift I = R'R`, reading the upper triangle. O(|alpha|^3). `false` when a pivot is not above
    /// `floor` times its diagonal entry.
    pub fn cholesky(&mut self, a: Square<'_>, alpha: &[usize], shift: f64, floor: f64) -> bool {
        self.load_upper(a, alpha, shift, floor);
        self.factor_upper()
    }

    /// `A + diag(d) = R'R` for row-major symmetric A of order `d.len()`. O(n^3), and no allocation after the first call of
    /// the order. `false` when a pivot is not positive.
    pub fn cholesky_shifted(&mut self, a: &[f64], d: &[f64]) -> bool {
        let n = d.len();
        self.start_upper(n);
        self.floors.resize(n, 0.0);
        let stride = self.stride;
        for (r, d) in d.iter().enumerate() {
            let row = &mut self.rows[r * stride + r..r * stride + n];
            row.copy_from_slice(&a[r * n + r..(r + 1) * n]);
            row[0] += d;
        }
        self.factor_upper()
    }

    /// `R'R = A[alpha, alpha]` with rows only for independent columns, for symmetric positive semidefinite A, pivoting on the
    /// largest `weights_i^2` times what is left of the diagonal; `alpha` is reordered so that the independent indices come
    /// first. What is left of a diagonal entry counts as zero up to `floor` times that entry. Their number, the rank, for which
    /// [`solve`](Self::solve) then solves; `None` when A is not semidefinite. O(|alpha|^2 rank).
    pub fn cholesky_pivoted(
        &mut self,
        a: Square<'_>,
        alpha: &mut [usize],
        weights: &[f64],
        floor: f64,
    ) -> Option<usize> {
        self.load_upper(a, alpha, 0.0, floor);
        let (m, stride) = (self.m, self.stride);
        let mut weights: Vec<f64> = alpha.iter().map(|&i| weights[i] * weights[i]).collect();
        let mut diagonal: Vec<f64> = (0..m).map(|i| self.rows[i * stride + i]).collect();
        let mut rank = m;
        'blocks: for start in (0..m).step_by(BLOCK) {
            let end = (start + BLOCK).min(m);
            for k in start..end {
                let Some(p) = next_pivot(&diagonal, &self.floors, &weights, k) else {
                    rank = k;
                    break 'blocks;
                };
                self.exchange_symmetrically(k, p);
                alpha.swap(k, p);
                weights.swap(k, p);
                diagonal.swap(k, p);
                self.floors.swap(k, p);
                pivoted_row(&mut self.rows, stride, m, (start, k), &mut diagonal);
            }
            self.negate_rows(start, (start, end));
            self.update_rows((start, end), 0, (end, m));
            (end..m).for_each(|i| diagonal[i] = self.rows[i * stride + i]);
        }
        self.m = rank;
        (rank..m).all(|i| diagonal[i] >= -self.floors[i]).then_some(rank)
    }

    /// Row k of R, its columns in the order of the factorisation; left of the diagonal stands nothing of meaning.
    #[must_use]
    pub fn row(&self, k: usize) -> &[f64] {
        &self.rows[k * self.stride..(k + 1) * self.stride]
    }

    /// Exchanges rows and columns `k < p` of what is left in the upper triangle, and the columns of R.
    fn exchange_symmetrically(&mut self, k: usize, p: usize) {
        let (m, stride) = (self.m, self.stride);
        if k == p {
            return;
        }
        for l in 0..k {
            self.rows.swap(l * stride + k, l * stride + p);
        }
        self.rows.swap(k * stride + k, p * stride + p);
        for j in k + 1..p {
            self.rows.swap(k * stride + j, j * stride + p);
        }
        let (above, below) = self.rows.split_at_mut(p * stride);
        above[k * stride + p + 1..k * stride + m].swap_with_slice(&mut below[p + 1..m]);
    }

    fn start_upper(&mut self, m: usize) {
        self.resize(m);
        self.floors.clear();
    }

    fn load_upper(&mut self, a: Square<'_>, alpha: &[usize], shift: f64, floor: f64) {
        self.start_upper(alpha.len());
        self.floors.extend(alpha.iter().map(|&i| floor * a.row(i)[i]));
        let stride = self.stride;
        for (r, &i) in alpha.iter().enumerate() {
            let source = a.row(i);
            let row = &mut self.rows[r * stride..(r + 1) * stride];
            for (x, &j) in row[r..].iter_mut().zip(&alpha[r..]) {
                *x = source[j];
            }
            row[r] += shift;
        }
    }

    /// Factors what was loaded. The panels of a block of rows update the rest of the block; the rest of the matrix waits for
    /// the whole block.
    fn factor_upper(&mut self) -> bool {
        let m = self.m;
        for start in (0..m).step_by(BLOCK) {
            let block_end = (start + BLOCK).min(m);
            for k in (start..block_end).step_by(PANEL) {
                let end = (k + PANEL).min(block_end);
                if !cholesky_rows(&mut self.rows, self.stride, m, (k, end), &self.floors) {
                    return false;
                }
                self.negate_rows(start, (k, end));
                self.update_rows((k, end), k - start, (end, block_end));
            }
            self.update_rows((start, block_end), 0, (block_end, m));
        }
        true
    }

    /// Copies the rows `k..end`, with their sign changed, into the panel, whose first row is row `start`.
    fn negate_rows(&mut self, start: usize, (k, end): (usize, usize)) {
        let (m, stride) = (self.m, self.stride);
        for i in k..end {
            let row = &self.rows[i * stride..][..m];
            let copy = &mut self.panel[(i - start) * stride..][..m];
            copy[end..].iter_mut().zip(&row[end..]).for_each(|(p, x)| *p = -x);
        }
    }

    /// Subtracts the products of the finished rows `k..end`, which stand in the panel from row `at` on, from the rows `first..last`.
    fn update_rows(&mut self, (k, end): (usize, usize), at: usize, (first, last): (usize, usize)) {
        let (m, stride) = (self.m, self.stride);
        let (above, below) = self.rows.split_at_mut(first * stride);
        for i in (first..last).step_by(STRIP) {
            let left = Window { numbers: &self.panel[at * stride + i..], stride };
            let right = Window { numbers: &above[k * stride + i..], stride };
            let size = (STRIP.min(last - i), m - i, end - k);
            add_products(&mut below[(i - first) * stride + i..], stride, size, left, right);
        }
    }

    fn resize(&mut self, m: usize) {
        self.m = m;
        // Rows a power of two apart would share the same few sets of the cache.
        let lanes = m.div_ceil(LANES).max(1);
        self.stride = LANES * if lanes.is_multiple_of(64) { lanes + 1 } else { lanes };
        self.rows.grow(m * self.stride);
        self.panel.grow(BLOCK * self.stride);
    }

    /// Replaces `b` by the solution. O(m^2).
    pub fn solve(&self, b: &mut [f64]) {
        debug_assert!(b.len() == self.m);
        solve_transposed(&self.rows, self.stride, b);
        solve_upper(&self.rows, self.stride, b);
    }
}

/// The rows `k..end` of R, given the rows above; columns from their diagonals on, and whatever stands left of them in the
/// same vector.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
fn cholesky_rows(rows: &mut [f64], stride: usize, m: usize, (start, end): (usize, usize), floors: &[f64]) -> bool {
    for k in start..end {
        let (row, below) = rows[k * stride..].split_at_mut(stride);
        let pivot = row[k];
        if !(pivot > floors[k] && pivot < f64::INFINITY) {
            return false;
        }
        let inverse = 1.0 / pivot.sqrt();
        row[k - k % LANES..m].iter_mut().for_each(|x| *x *= inverse);
        for i in k + 1..end {
            let f = row[i];
            let from = i - i % LANES;
            let target = &mut below[(i - k - 1) * stride + from..(i - k - 1) * stride + m];
            for (y, x) in target.iter_mut().zip(&row[from..m]) {
                *y -= f * x;
            }
        }
    }
    true
}

/// Where `weights_i diagonal_i` is largest, from k on, among the diagonal entries above their floors.
fn next_pivot(diagonal: &[f64], floors: &[f64], weights: &[f64], k: usize) -> Option<usize> {
    let mut largest = (None, -1.0);
    for i in k..diagonal.len() {
        let weighted = weights[i] * diagonal[i];
        if diagonal[i] > floors[i] && weighted > largest.1 {
            largest = (Some(i), weighted);
        }
    }
    largest.0
}

/// Row k of R, from row k of a matrix to which the rows of R before `start` have been applied; takes its squares off the
/// `diagonal`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
fn pivoted_row(rows: &mut [f64], stride: usize, m: usize, (start, k): (usize, usize), diagonal: &mut [f64]) {
    let (above, rest) = rows.split_at_mut(k * stride);
    let row = &mut rest[..m];
    let from = k - k % LANES;
    for l in start..k {
        let finished = &above[l * stride..l * stride + m];
        let f = finished[k];
        for (y, x) in row[from..].iter_mut().zip(&finished[from..]) {
            *y -= f * x;
        }
    }
    row[k] = diagonal[k].sqrt();
    let inverse = 1.0 / row[k];
    for (x, d) in row[k + 1..].iter_mut().zip(&mut diagonal[k + 1..]) {
        *x *= inverse;
        *d -= *x * *x;
    }
}

/// `R' y = b` in place, row by row of R.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
fn solve_transposed(rows: &[f64], stride: usize, b: &mut [f64]) {
    let m = b.len();
    for k in 0..m {
        let row = &rows[k * stride..k * stride + m];
        let (solved, rest) = b.split_at_mut(k + 1);
        solved[k] /= row[k];
        let f = solved[k];
        for (y, x) in rest.iter_mut().zip(&row[k + 1..]) {
            *y -= f * x;
        }
    }
}

/// `R x = b` in place.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
fn solve_upper(rows: &[f64], stride: usize, b: &mut [f64]) {
    let m = b.len();
    for k in (0..m).rev() {
        let row = &rows[k * stride..k * stride + m];
        let (rest, solved) = b.split_at_mut(k + 1);
        let mut sums = [0.0; LANES];
        let (row8, x8) = (row[k + 1..].chunks_exact(LANES), solved.chunks_exact(LANES));
        let tail: f64 = row8.remainder().iter().zip(x8.remainder()).map(|(a, x)| a * x).sum();
        for (a, x) in row8.zip(x8) {
            for l in 0..LANES {
                sums[l] += a[l] * x[l];
            }
        }
        rest[k] = (rest[k] - (sums.iter().sum::<f64>() + tail)) / row[k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Symmetric and diagonally dominant.
    fn problem(n: usize) -> Vec<f64> {
        let number = |i: usize, j: usize| (((i * 31 + j * 17) * 7919 % 101) as f64) / 50.0 - 1.0;
        let entry = |i: usize, j: usize| number(i.min(j), i.max(j));
        (0..n * n).map(|k| entry(k / n, k % n) + if k % (n + 1) == 0 { n as f64 } else { 0.0 }).collect()
    }

    #[test]
    fn factors_solve_at_every_order_with_the_memory_of_the_last() {
        let mut factor = BlockFactor::default();
        for n in [70, 1, 2, 7, 8, 9, 16, 24, 33, 61, 0] {
            let entries = problem(n + 3);
            let a = Square { n: n + 3, entries: &entries };
            let alpha: Vec<usize> = (0..n).map(|i| if i % 2 == 0 { i } else { i + 2 }).take(n).collect();
            let x: Vec<f64> = (0..n).map(|i| 1.0 + i as f64 / 7.0).collect();
            let image = |r: usize| alpha.iter().zip(&x).map(|(&j, x)| a.row(alpha[r])[j] * x).sum::<f64>();
            let mut b: Vec<f64> = (0..n).map(image).collect();
            assert!(factor.cholesky(a, &alpha, 0.0, 1e-13));
            factor.solve(&mut b);
            let error = b.iter().zip(&x).map(|(b, x)| (b - x).abs()).fold(0.0, f64::max);
            assert!(error < 1e-12, "{n}: {error}");
        }
    }

    /// `B B'` of the given rank, by small integers; column 3 k + 2 is the sum of the two before it.
    fn semidefinite(n: usize, rank: usize) -> Vec<f64> {
        let number = |i: usize, k: usize| ((i * 31 + k * 17) * 7919 % 11) as f64 - 5.0;
        let b = |i: usize, k: usize| if i % 3 == 2 { number(i - 1, k) + number(i - 2, k) } else { number(i, k) };
        let entry = |i: usize, j: usize| (0..rank).map(|k| b(i, k) * b(j, k)).sum::<f64>();
        (0..n * n).map(|ij| entry(ij / n, ij % n)).collect()
    }

    #[test]
    fn pivoting_puts_independent_columns_first() {
        let mut factor = BlockFactor::default();
        for (n, rank) in [(6, 6), (30, 30), (60, 7), (61, 33), (5, 0)] {
            let entries = semidefinite(n, rank);
            let a = Square { n, entries: &entries };
            let mut alpha: Vec<usize> = (0..n).collect();
            let weights: Vec<f64> = (0..n).map(|i| 1.0 + (i % 5) as f64).collect();
            let found = factor.cholesky_pivoted(a, &mut alpha, &weights, 1e-10).expect("semidefinite");
            assert!(found <= rank.min(n - n / 3), "{n} {rank}: {found}");
            // R'R in the new order, whatever was left out.
            let size = (0..n).fold(1.0_f64, |m, i| m.max(a.row(i)[i]));
            for i in 0..n {
                for j in i..n {
                    let product: f64 = (0..found.min(i + 1)).map(|k| factor.row(k)[i] * factor.row(k)[j]).sum();
                    assert!((product - a.row(alpha[i])[alpha[j]]).abs() < 1e-10 * size, "{n} {rank}: {i} {j}");
                }
            }
            // A consistent right-hand side is met in every row.
            let image = |x: &[f64], i: usize| alpha.iter().zip(x).map(|(&j, x)| a.row(alpha[i])[j] * x).sum::<f64>();
            let x: Vec<f64> = (0..n).map(|i| 1.0 + i as f64 / 7.0).collect();
            let b: Vec<f64> = (0..n).map(|i| image(&x, i)).collect();
            let mut solution = b[..found].to_vec();
            factor.solve(&mut solution);
            let size = b.iter().fold(1.0_f64, |m, b| m.max(b.abs()));
            assert!((0..n).all(|i| (image(&solution, i) - b[i]).abs() < 1e-9 * size), "{n} {rank}");
        }
    }

    #[test]
    fn singular_and_indefinite_are_refused() {
        let mut factor = BlockFactor::default();
        let a = Square { n: 3, entries: &[1.0; 9] };
        assert!(!factor.cholesky(a, &[0, 2], 0.0, 1e-12));
        assert!(factor.cholesky(a, &[0, 2], 1e-6, 1e-12));
        let a = Square { n: 2, entries: &[1.0, 2.0, 2.0, 1.0] };
        assert!(!factor.cholesky(a, &[0, 1], 0.0, 1e-12));
        assert!(factor.cholesky_pivoted(a, &mut [0, 1], &[1.0; 2], 1e-12).is_none());
        let d = [3.0, 1.0];
        assert!(factor.cholesky_shifted(a.entries, &d));
        let mut b = [4.0 * 1.0 + 2.0 * 5.0, 2.0 * 1.0 + 2.0 * 5.0];
        factor.solve(&mut b);
        assert!((b[0] - 1.0).abs() < 1e-14 && (b[1] - 5.0).abs() < 1e-14);
    }
}
