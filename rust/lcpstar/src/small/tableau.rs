//! Lemke's method on the whole condensed tableau, for one small problem: rows that depend on others keep doing so to the last
//! bit, because all of them see the same row operations. The smaller [`Basis`](super::lemke::Basis) computes its columns from an
//! inverse, whose errors show in such rows as small pivots where, as with mass ratios of 10^6, it has large entries.
//! [CPS92, sec. 4.4]
//!
//! `basic_i = rhs_i + sum_j t_ij nonbasic_j`, n rows and n + 1 columns, exchanged in place. Labels are signed: `j + 1` for w_j,
//! `-(j + 1)` for z_j, 0 for z_0; minus a label is its complement.

use super::lane::Lane;
use super::lemke::{PIVOTS_PER_ROW, WIDTH, at, first_to_reach_zero, grow, put, spread};

/// The tableau, in memory that is used again. Vectors of numbers are padded.
pub struct Tableau<X> {
    /// Row i at `i width`.
    t: Vec<X>,
    /// Vectors per row of t.
    width: usize,
    rhs: Vec<X>,
    basic: Vec<i32>,
    nonbasic: Vec<i32>,
    /// Of the driving variable.
    column: Vec<X>,
    ratio: Vec<X>,
    /// The new pivot row.
    row: Vec<X>,
    /// Pivots of the last run.
    pub pivots: usize,
}

impl<X> Default for Tableau<X> {
    fn default() -> Self {
        Self {
            t: Vec::new(),
            width: 0,
            rhs: Vec::new(),
            basic: Vec::new(),
            nonbasic: Vec::new(),
            column: Vec::new(),
            ratio: Vec::new(),
            row: Vec::new(),
            pivots: 0,
        }
    }
}

impl<X: Lane<Number = f64>> Tableau<X> {
    /// Runs the method; `true` if it ended with a complementary basis. O(n^2) a pivot.
    #[inline(always)]
    pub fn solve(&mut self, n: usize, a: &[f64], q: &[f64]) -> bool {
        self.pivots = 0;
        let Some(mut row) = self.start(n, a, q) else {
            return true;
        };
        let (mut artificial, mut slot) = (row, n);
        loop {
            self.gather(slot);
            if self.pivots > 0 {
                let Some(blocking) = first_to_reach_zero(&self.column, &self.rhs, &mut self.ratio, artificial) else {
                    return false;
                };
                row = blocking;
            }
            let left = self.exchange(row, slot);
            self.pivots += 1;
            if left == 0 {
                return true;
            }
            if self.pivots >= PIVOTS_PER_ROW * n {
                return false;
            }
            if self.pivots == 1 {
                artificial = row;
            }
            let Some(next) = self.nonbasic.iter().position(|&label| label == -left) else {
                return false;
            };
            slot = next;
        }
    }

    /// Bit j: z_j is basic at the end.
    #[inline(always)]
    pub fn alpha(&self) -> u128 {
        self.basic.iter().filter(|&&label| label < 0).fold(0, |mask, label| mask | 1 << (-label - 1))
    }

    /// `w = q + A z + d z_0`, and the row that becomes nonnegative last. `None` if `q >= 0`.
    #[inline(always)]
    fn start(&mut self, n: usize, a: &[f64], q: &[f64]) -> Option<usize> {
        let (width, rows, zero) = ((n + 1).div_ceil(WIDTH), n.div_ceil(WIDTH), X::splat(0.0));
        self.width = width;
        self.t.resize(n * width, zero);
        for v in [&mut self.rhs, &mut self.column, &mut self.ratio] {
            v.clear();
            v.resize(rows, zero);
        }
        self.row.resize(width, zero);
        self.basic.clear();
        self.nonbasic.clear();
        self.nonbasic.extend((0..n as i32).map(|j| -(j + 1)));
        self.nonbasic.push(0);
        let (mut last, mut largest) = (None, 0.0);
        for (i, (numbers, &q)) in a.chunks_exact(n).zip(q).enumerate() {
            let row = &mut self.t[i * width..(i + 1) * width];
            row[width - 1] = zero;
            for (x, numbers) in row.iter_mut().zip(numbers.chunks(WIDTH)) {
                *x = X::from_slice(numbers);
            }
            put(row, n, spread(i));
            put(&mut self.rhs, i, q);
            self.basic.push(i as i32 + 1);
            if -q / spread(i) > largest {
                (last, largest) = (Some(i), -q / spread(i));
            }
        }
        last
    }

    #[inline(always)]
    fn gather(&mut self, slot: usize) {
        for i in 0..self.basic.len() {
            let x = at(&self.t[i * self.width..(i + 1) * self.width], slot);
            put(&mut self.column, i, x);
        }
    }

    /// The variables of a row and of a column change places; the label of the one that leaves the basis.
    ///
    /// With c the column and p the new pivot row, `t_ij + c_i p_j`, but `c_i p_s` in the column itself.
    #[inline(always)]
    fn exchange(&mut self, r: usize, slot: usize) -> i32 {
        let width = self.width;
        let reciprocal = 1.0 / at(&self.column, r);
        let minus = X::splat(-reciprocal);
        for (p, t) in self.row.iter_mut().zip(&self.t[r * width..(r + 1) * width]) {
            *p = t.mul(minus);
        }
        for (i, t) in self.t.chunks_exact_mut(width).enumerate() {
            let entry = at(&self.column, i);
            if entry == 0.0 || i == r {
                continue;
            }
            let c = X::splat(entry);
            for (t, p) in t.iter_mut().zip(&self.row) {
                *t = t.add_product(c, *p);
            }
            // Last: a vector that was just written to in part is slow to read.
            put(t, slot, entry * reciprocal);
        }
        let row = &mut self.t[r * width..(r + 1) * width];
        row.copy_from_slice(&self.row);
        put(row, slot, reciprocal);
        let value = -at(&self.rhs, r) * reciprocal;
        grow(&mut self.rhs, &self.column, value);
        put(&mut self.rhs, r, value);
        std::mem::swap(&mut self.basic[r], &mut self.nonbasic[slot]);
        self.nonbasic[slot]
    }
}

#[cfg(test)]
mod tests {
    use super::super::{basis_by_tableau, solve_one};

    /// On problems with one solution, that of `P`-matrices, the support is the one that the other kernel verifies.
    #[test]
    fn ends_on_the_basis_of_the_solution() {
        // Reproducible, between -1/2 and 1/2.
        let noise = |k: usize| (k * 7919 % 101) as f64 / 101.0 - 0.5;
        for n in [1, 2, 3, 7, 8, 9, 16, 31, 64, 128] {
            let a: Vec<f64> = (0..n * n).map(|e| noise(e) + if e / n == e % n { n as f64 } else { 0.0 }).collect();
            let q: Vec<f64> = (0..n).map(|i| noise(3 * i + 1) - 0.2).collect();
            let solution = solve_one(n, &a, &q, 1e-9).expect("diagonally dominant");
            let (alpha, pivots) = basis_by_tableau(n, &a, &q).expect("a P-matrix");
            assert_eq!(alpha, solution.alpha, "n = {n}");
            assert!(pivots <= 2 * n, "n = {n}: {pivots} pivots");
        }
    }

    #[test]
    fn a_ray_and_a_trivial_problem() {
        assert_eq!(basis_by_tableau(1, &[-1.0], &[-1.0]), None);
        assert_eq!(basis_by_tableau(2, &[0.0; 4], &[1.0, 0.0]), Some((0, 0)));
    }
}
