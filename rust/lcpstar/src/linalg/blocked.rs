//! Cholesky and LU factors of a principal block `A[alpha, alpha]` in memory that is used again, right-looking in panels
//! of eight rows.
//!
//! For the orders of pivoting methods (10 to 500) the libraries spend more on packing and allocation than on the
//! arithmetic; see `benches/record/backend.md`. Larger blocks are theirs, see [`backend`](super::backend).

use super::kernels::{LANES, dot};
use super::update::{Window, add_products};
use crate::problem::Lcp;
use multiversion::multiversion;

/// Rows of a panel.
const PANEL: usize = LANES;
/// Rows of the trailing part updated together, from their diagonal on.
const STRIP: usize = 16;

/// A factored principal block. Grows to the largest it has held.
#[derive(Clone, Debug, Default)]
pub struct BlockFactor {
    m: usize,
    stride: usize,
    /// Row-major; R in the upper triangle, or L and U.
    rows: Vec<f64>,
    /// The panel's factors with their sign changed, term by term.
    panel: Vec<f64>,
    /// Least pivots of a Cholesky factorisation.
    floors: Vec<f64>,
    /// Row that was exchanged with row k; empty for Cholesky.
    exchanged: Vec<usize>,
}

impl BlockFactor {
    /// `A[alpha, alpha] + shift I = R'R`, reading the upper triangle. O(|alpha|^3). `false` when a pivot is not above
    /// `floor` times its diagonal entry.
    pub fn cholesky(&mut self, lcp: &Lcp, alpha: &[usize], shift: f64, floor: f64) -> bool {
        self.resize(alpha.len());
        self.exchanged.clear();
        self.floors.clear();
        self.floors.extend(alpha.iter().map(|&i| floor * lcp.row(i)[i]));
        let (m, stride) = (self.m, self.stride);
        for (r, &i) in alpha.iter().enumerate() {
            let source = lcp.row(i);
            let row = &mut self.rows[r * stride..(r + 1) * stride];
            for (x, &j) in row[r..].iter_mut().zip(&alpha[r..]) {
                *x = source[j];
            }
            row[r] += shift;
        }
        let mut k = 0;
        while k < m {
            let end = (k + PANEL).min(m);
            if !cholesky_rows(&mut self.rows, stride, m, (k, end), &self.floors) {
                return false;
            }
            let (above, below) = self.rows.split_at_mut(end * stride);
            for (p, row) in self.panel.chunks_exact_mut(stride).zip(above[k * stride..].chunks_exact(stride)) {
                p[end..m].iter_mut().zip(&row[end..m]).for_each(|(p, x)| *p = -x);
            }
            let mut i = end;
            while i < m {
                let left = Window { numbers: &self.panel[i..], stride };
                let right = Window { numbers: &above[k * stride + i..], stride };
                let size = (STRIP.min(m - i), m - i, end - k);
                add_products(&mut below[(i - end) * stride + i..], stride, size, left, right);
                i += STRIP;
            }
            k = end;
        }
        true
    }

    /// `P A[alpha, alpha] = L U` by partial pivoting. O(|alpha|^3). `false` when a pivot is zero or not finite.
    pub fn lu(&mut self, lcp: &Lcp, alpha: &[usize]) -> bool {
        self.resize(alpha.len());
        let (m, stride) = (self.m, self.stride);
        for (r, &i) in alpha.iter().enumerate() {
            let source = lcp.row(i);
            let row = &mut self.rows[r * stride..(r + 1) * stride];
            for (x, &j) in row.iter_mut().zip(alpha) {
                *x = source[j];
            }
        }
        self.exchanged.clear();
        let mut k = 0;
        while k < m {
            let end = (k + PANEL).min(m);
            if !lu_panel(&mut self.rows, stride, m, (k, end), &mut self.exchanged) {
                return false;
            }
            let (above, below) = self.rows.split_at_mut(end * stride);
            for (i, row) in below.chunks_exact(stride).take(m - end).enumerate() {
                for (p, x) in row[k..end].iter().enumerate() {
                    self.panel[p * stride + i] = -x;
                }
            }
            if end < m {
                let left = Window { numbers: &self.panel, stride };
                let right = Window { numbers: &above[k * stride + end..], stride };
                add_products(&mut below[end..], stride, (m - end, m - end, end - k), left, right);
            }
            k = end;
        }
        true
    }

    fn resize(&mut self, m: usize) {
        self.m = m;
        self.stride = m.next_multiple_of(LANES).max(LANES);
        self.rows.resize((m * self.stride).max(self.rows.len()), 0.0);
        self.panel.resize((PANEL * self.stride).max(self.panel.len()), 0.0);
    }

    /// Replaces `b` by the solution. O(m^2).
    pub fn solve(&self, b: &mut [f64]) {
        debug_assert!(b.len() == self.m);
        let (m, stride) = (self.m, self.stride);
        let row = |k: usize| &self.rows[k * stride..k * stride + m];
        if self.exchanged.is_empty() {
            solve_transposed(&self.rows, stride, b);
        } else {
            for (k, &i) in self.exchanged.iter().enumerate() {
                b.swap(k, i);
            }
            for k in 1..m {
                let (solved, rest) = b.split_at_mut(k);
                rest[0] -= dot(&row(k)[..k], solved);
            }
        }
        for k in (0..m).rev() {
            let (rest, solved) = b.split_at_mut(k + 1);
            rest[k] = (rest[k] - dot(&row(k)[k + 1..], solved)) / row(k)[k];
        }
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

/// Columns `k..end` of L, and the rows `k..end` of U.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
fn lu_panel(
    rows: &mut [f64],
    stride: usize,
    m: usize,
    (start, end): (usize, usize),
    exchanged: &mut Vec<usize>,
) -> bool {
    for k in start..end {
        let (mut pivot_row, mut largest) = (k, 0.0);
        for i in k..m {
            let size = rows[i * stride + k].abs();
            if size > largest {
                (pivot_row, largest) = (i, size);
            }
        }
        if !(largest > 0.0 && largest < f64::INFINITY) {
            return false;
        }
        exchanged.push(pivot_row);
        if pivot_row != k {
            let (a, b) = rows.split_at_mut(pivot_row * stride);
            a[k * stride..(k + 1) * stride].swap_with_slice(&mut b[..stride]);
        }
        // The panel's part of row k right of the diagonal, as one vector.
        let mut u = [0.0; PANEL];
        u[k + 1 - start..end - start].copy_from_slice(&rows[k * stride + k + 1..k * stride + end]);
        let inverse = 1.0 / rows[k * stride + k];
        for row in rows[(k + 1) * stride..m * stride].chunks_exact_mut(stride) {
            let factor = row[k] * inverse;
            let part = &mut row[start..start + PANEL];
            for l in 0..PANEL {
                part[l] -= factor * u[l];
            }
            row[k] = factor;
        }
    }
    for k in start..end {
        let (row, below) = rows[k * stride..].split_at_mut(stride);
        for i in k + 1..end {
            let target = &mut below[(i - k - 1) * stride..][..m];
            let f = target[k];
            for (y, x) in target[end..].iter_mut().zip(&row[end..m]) {
                *y -= f * x;
            }
        }
    }
    true
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Diagonally dominant; symmetric where asked.
    fn problem(n: usize, symmetric: bool) -> Lcp {
        let number = |i: usize, j: usize| (((i * 31 + j * 17) * 7919 % 101) as f64) / 50.0 - 1.0;
        let entry = |i: usize, j: usize| if symmetric { number(i.min(j), i.max(j)) } else { number(i, j) };
        let a = (0..n * n).map(|k| entry(k / n, k % n) + if k % (n + 1) == 0 { n as f64 } else { 0.0 }).collect();
        Lcp::new(n, a, (0..n).map(|i| i as f64 - 2.5).collect()).expect("valid")
    }

    #[test]
    fn both_factors_solve_at_every_order_with_the_memory_of_the_last() {
        let mut factor = BlockFactor::default();
        for n in [70, 1, 2, 7, 8, 9, 16, 24, 33, 61, 0] {
            for symmetric in [true, false] {
                let lcp = problem(n + 3, symmetric);
                let alpha: Vec<usize> = (0..n).map(|i| if i % 2 == 0 { i } else { i + 2 }).take(n).collect();
                let x: Vec<f64> = (0..n).map(|i| 1.0 + i as f64 / 7.0).collect();
                let image = |r: usize| alpha.iter().zip(&x).map(|(&j, x)| lcp.row(alpha[r])[j] * x).sum::<f64>();
                for cholesky in [true, false] {
                    let mut b: Vec<f64> = (0..n).map(image).collect();
                    if cholesky && !symmetric {
                        continue;
                    }
                    assert!(if cholesky { factor.cholesky(&lcp, &alpha, 0.0, 1e-13) } else { factor.lu(&lcp, &alpha) });
                    factor.solve(&mut b);
                    let error = b.iter().zip(&x).map(|(b, x)| (b - x).abs()).fold(0.0, f64::max);
                    assert!(error < 1e-12, "{n} {symmetric} {cholesky}: {error}");
                }
            }
        }
    }

    #[test]
    fn singular_and_indefinite_are_refused() {
        let mut factor = BlockFactor::default();
        let lcp = Lcp::new(3, vec![1.0; 9], vec![0.0; 3]).expect("valid");
        assert!(!factor.cholesky(&lcp, &[0, 2], 0.0, 1e-12));
        assert!(factor.cholesky(&lcp, &[0, 2], 1e-6, 1e-12));
        assert!(!factor.lu(&lcp, &[0, 2]));
        let lcp = Lcp::new(2, vec![1.0, 2.0, 2.0, 1.0], vec![0.0; 2]).expect("valid");
        assert!(!factor.cholesky(&lcp, &[0, 1], 0.0, 1e-12));
        assert!(factor.lu(&lcp, &[0, 1]));
    }
}
