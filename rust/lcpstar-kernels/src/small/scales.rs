//! The equilibration of the contract in the arithmetic of the lanes: Ruiz sweeps on powers of two, the same factors, bit for bit, as
//! the general solver computes with integers. [Rui01]

use super::lane::{BLOCK, Lane, Mask};

/// Sweeps at most.
const SWEEPS: usize = 12;

/// Rows and columns with their largest entries in this range, its inverse the least, keep all factors, and all products with them, far
/// from both ends of the range of doubles: no sweep widens the range of the largest entries.
const MOST: f64 = 1e90;

/// `R`, `1 / C` and `S`: `A' = R A C`, `q' = S R q`, so that `z' = S C^-1 z` and `w' = S R w`; and the memory to find them. A vector
/// holds one row of several problems, or a block of rows of one.
pub struct Scales<X: Lane> {
    is_known: bool,
    rows: Vec<X>,
    columns: Vec<X>,
    inverse: Vec<X>,
    q: X,
    /// Where the factors can be trusted.
    pub trusted: X::Mask,
    row_max: Vec<X>,
    column_max: Vec<X>,
    /// Room for a number per row: `b_i` of the verdict.
    pub bounds: Vec<X>,
}

impl<X: Lane> Default for Scales<X> {
    fn default() -> Self {
        let none = Vec::new;
        Self {
            is_known: false,
            rows: none(),
            columns: none(),
            inverse: none(),
            q: X::splat(1.0),
            trusted: X::Mask::ALL,
            row_max: none(),
            column_max: none(),
            bounds: none(),
        }
    }
}

impl<X: Lane> Scales<X> {
    /// Memory for so many vectors of rows.
    #[inline(always)]
    pub fn resize(&mut self, length: usize) {
        let zero = X::splat(0.0);
        for v in [
            &mut self.rows,
            &mut self.columns,
            &mut self.inverse,
            &mut self.row_max,
            &mut self.column_max,
            &mut self.bounds,
        ] {
            v.resize(length, zero);
        }
        self.is_known = false;
    }

    /// Another problem is looked at.
    #[inline(always)]
    pub fn forget(&mut self) {
        self.is_known = false;
    }

    /// The factors of w and z in rows i: `R_i`, `1 / C_i`, `S`.
    #[inline(always)]
    pub fn of(&self, i: usize) -> [X; 3] {
        [self.rows[i], self.inverse[i], self.q]
    }

    /// Finds the scales of the problem in each lane, unless they are known. O(n^2) a sweep, two or three as a rule.
    #[inline(always)]
    pub fn find_in_lanes<const N: usize>(&mut self, n: usize, a: &[X], q: &[X]) {
        let n = if N == 0 { n } else { N };
        if self.is_known {
            return;
        }
        self.start(n);
        for sweep in 0..SWEEPS {
            self.column_max[..n].fill(X::splat(0.0));
            let (rows, columns) = (&self.rows[..n], &self.columns[..n]);
            let (row_max, column_max) = (&mut self.row_max[..n], &mut self.column_max[..n]);
            for i in 0..n {
                let (r, row) = (rows[i], &a[i * n..(i + 1) * n]);
                let mut largest = X::splat(0.0);
                if sweep == 0 {
                    for j in 0..n {
                        let size = row[j].abs();
                        largest = size.max(largest);
                        column_max[j] = size.max(column_max[j]);
                    }
                } else {
                    for j in 0..n {
                        let size = row[j].abs();
                        largest = size.mul(columns[j]).max(largest);
                        column_max[j] = size.mul(r).max(column_max[j]);
                    }
                }
                row_max[i] = largest.mul(r);
            }
            if self.is_settled(n, sweep) {
                break;
            }
            self.step(n);
        }
        let mut largest = X::splat(0.0);
        for (q, r) in q[..n].iter().zip(&self.rows) {
            largest = q.abs().mul(*r).max(largest);
        }
        self.finish(n, largest);
    }

    /// Finds the scales of one problem in blocks of `BLOCK` rows, unless they are known. O(n^2) a sweep.
    #[inline(always)]
    pub fn find_for_one(&mut self, a: &[f64], q: &[f64]) {
        let (n, width) = (q.len(), q.len().div_ceil(BLOCK));
        if self.is_known {
            return;
        }
        self.start(width);
        for sweep in 0..SWEEPS {
            self.column_max[..width].fill(X::splat(0.0));
            let (rows, columns) = (&self.rows[..width], &self.columns[..width]);
            let (row_max, column_max) = (&mut self.row_max[..width], &mut self.column_max[..width]);
            for (i, row) in a.chunks_exact(n).enumerate() {
                let r = rows[i / BLOCK].get(i % BLOCK);
                let (wide, mut largest) = (X::splat(r), X::splat(0.0));
                for (k, numbers) in row.chunks(BLOCK).enumerate() {
                    let size = X::from_slice(numbers).abs();
                    largest = size.mul(columns[k]).max(largest);
                    column_max[k] = size.mul(wide).max(column_max[k]);
                }
                row_max[i / BLOCK].set(i % BLOCK, largest.largest() * r);
            }
            if self.is_settled(width, sweep) {
                break;
            }
            self.step(width);
        }
        let mut largest = X::splat(0.0);
        for (q, r) in q.chunks(BLOCK).zip(&self.rows) {
            largest = X::from_slice(q).abs().mul(*r).max(largest);
        }
        self.finish(width, X::splat(largest.largest()));
    }

    #[inline(always)]
    fn start(&mut self, length: usize) {
        let one = X::splat(1.0);
        self.rows[..length].fill(one);
        self.columns[..length].fill(one);
        // Lanes beyond the last row have no entries.
        self.row_max[..length].fill(X::splat(0.0));
        self.trusted = X::Mask::ALL;
    }

    /// Whether every row and column has its largest entry in [1/4, 2), or none; the largest of columns become those of `R A C`.
    #[inline(always)]
    fn is_settled(&mut self, length: usize, sweep: usize) -> bool {
        let (zero, quarter, two) = (X::splat(0.0), X::splat(0.25), X::splat(2.0));
        let (mut least, mut most) = (quarter, quarter);
        for i in 0..length {
            self.column_max[i] = self.column_max[i].mul(self.columns[i]);
            for x in [self.row_max[i], self.column_max[i]] {
                most = x.max(most);
                least = x.or_else(zero.lt(x), quarter).min(least);
            }
        }
        if sweep == 0 {
            self.trusted = most.lt(X::splat(MOST)).and(X::splat(1.0 / MOST).le(least));
        }
        !quarter.le(least).and(most.lt(two)).not().any()
    }

    /// Moves every largest entry half the way to 1 in exponent.
    #[inline(always)]
    fn step(&mut self, length: usize) {
        for i in 0..length {
            self.rows[i] = self.rows[i].mul(halfway(self.row_max[i]));
            self.columns[i] = self.columns[i].mul(halfway(self.column_max[i]));
        }
    }

    /// The inverse factors of columns, and the factor that brings the largest `|R q|` into [1/2, 1).
    #[inline(always)]
    fn finish(&mut self, length: usize, largest: X) {
        let (zero, one, most) = (X::splat(0.0), X::splat(1.0), X::splat(MOST));
        for (inverse, c) in self.inverse[..length].iter_mut().zip(&self.columns) {
            *inverse = one.sub(c.exponent()).two_to();
        }
        self.trusted = self.trusted.and(largest.lt(most)).and(X::splat(1.0 / MOST).le(largest).or(largest.eq(zero)));
        self.q = largest.exponent().only(zero.lt(largest)).neg().two_to();
        self.is_known = true;
    }
}

/// `2^-(e / 2)`, half the exponent e of a largest entry rounded towards 0, `2^(e-1) <= x < 2^e`; 1 for no entry.
#[inline(always)]
fn halfway<X: Lane>(x: X) -> X {
    x.exponent().only(X::splat(0.0).lt(x)).mul(X::splat(-0.5)).truncated().two_to()
}
