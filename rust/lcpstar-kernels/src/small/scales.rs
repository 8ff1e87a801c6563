//! The equilibration of the contract in the arithmetic of the lanes: Ruiz sweeps on powers of two, the same factors, bit for bit, as
//! the general solver computes with integers. [Rui01]

use super::lane::{BLOCK, Lane, Mask};

/// Sweeps at most.
const SWEEPS: usize = 12;

/// Largest entries whose products with the factors stay far from both ends of the range of doubles.
const LEAST: f64 = 1e-280;
const MOST: f64 = 1e150;

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
                for j in 0..n {
                    let size = row[j].abs();
                    largest = size.mul(columns[j]).max(largest);
                    column_max[j] = size.mul(r).max(column_max[j]);
                }
                row_max[i] = largest.mul(r);
            }
            if self.step(n, sweep) {
                break;
            }
        }
        let mut largest = X::splat(0.0);
        for (q, r) in q[..n].iter().zip(&self.rows) {
            largest = q.abs().mul(*r).max(largest);
        }
        self.finish(largest);
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
            if self.step(width, sweep) {
                break;
            }
        }
        let mut largest = X::splat(0.0);
        for (q, r) in q.chunks(BLOCK).zip(&self.rows) {
            largest = X::from_slice(q).abs().mul(*r).max(largest);
        }
        self.finish(X::splat(largest.largest()));
    }

    #[inline(always)]
    fn start(&mut self, length: usize) {
        let one = X::splat(1.0);
        self.rows[..length].fill(one);
        self.columns[..length].fill(one);
        self.inverse[..length].fill(one);
        // Lanes beyond the last row have no entries.
        self.row_max[..length].fill(X::splat(0.0));
        self.trusted = X::Mask::ALL;
    }

    /// Moves every largest entry half the way to 1 in exponent; whether all are there.
    #[inline(always)]
    fn step(&mut self, length: usize, sweep: usize) -> bool {
        let zero = X::splat(0.0);
        let (least, most) = (X::splat(if sweep == 0 { 1.0 / MOST } else { LEAST }), X::splat(MOST));
        let mut settled = X::Mask::ALL;
        for i in 0..length {
            let (row, column) = (self.row_max[i], self.column_max[i].mul(self.columns[i]));
            for x in [row, column] {
                self.trusted = self.trusted.and(x.lt(most)).and(least.le(x).or(x.eq(zero)));
            }
            let (r, c) = (half(row), half(column));
            settled = settled.and(r.eq(zero)).and(c.eq(zero));
            self.rows[i] = self.rows[i].mul(r.neg().two_to());
            self.columns[i] = self.columns[i].mul(c.neg().two_to());
            self.inverse[i] = self.inverse[i].mul(c.two_to());
        }
        !settled.not().any()
    }

    /// The factor that brings the largest `|R q|` into [1/2, 1).
    #[inline(always)]
    fn finish(&mut self, largest: X) {
        let (zero, most) = (X::splat(0.0), X::splat(MOST));
        self.trusted = self.trusted.and(largest.lt(most)).and(X::splat(1.0 / MOST).le(largest).or(largest.eq(zero)));
        self.q = largest.exponent().only(zero.lt(largest)).neg().two_to();
        self.is_known = true;
    }
}

/// Half the exponent e of a largest entry, `2^(e-1) <= x < 2^e`, rounded towards 0; 0 for no entry.
#[inline(always)]
fn half<X: Lane>(x: X) -> X {
    x.exponent().only(X::splat(0.0).lt(x)).mul(X::splat(0.5)).truncated()
}
