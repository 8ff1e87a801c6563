//! Lemke's method for one small problem in memory that is used again: the survivor of singular, copositive and
//! unsymmetric problems behind the lane kernel. [CPS92, sec. 4.4]
//!
//! A condensed tableau: row r reads `basic_r = rhs_r + sum_j t_rj nonbasic_j + column_r driving`. Slot j of the
//! columns holds the nonbasic member of the pair `(w_j, z_j)`; the driving variable has a column of its own, so that
//! the ratio test and the update run over contiguous memory and a pivot moves one column.
//!
//! The covering vector is not `e` but spread over [1, 2): the line `q + z_0 d` then meets degenerate bases only by
//! accident, which is what a lexicographic rule is for otherwise. Among tied rows the one holding z_0 wins, then the
//! largest pivot.

use super::lane::{F64x8, Lane};

/// Numbers per row are padded to a multiple of this.
const WIDTH: usize = F64x8::<true>::LANES;

/// Who sits in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Basic {
    W(usize),
    Z(usize),
    Z0,
}

/// How the method stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// z_0 left: the basis is complementary.
    Basis,
    /// No blocking row.
    Ray,
    /// Too many pivots.
    Limit,
}

/// Smallest pivot relative to the largest entry of the driving column.
const PIVOT_TOLERANCE: f64 = 1e-10;

/// Ratios within this factor of the least one are tied.
const TIE: f64 = 1.0 + 1e-11;

/// A value that cancels to less than this part of itself is rounding error, and zero.
const NOISE: f64 = 1e-14;

/// A correction that leaves less than this part of a value shows that the value was rounding error.
const CANCELLED: f64 = 1e-8;

/// The tableau and what belongs to it; grows to the largest problem it has seen.
#[derive(Debug, Default)]
pub struct Tableau<const FUSED: bool> {
    n: usize,
    /// Vectors per row.
    width: usize,
    t: Vec<F64x8<FUSED>>,
    column: Vec<F64x8<FUSED>>,
    rhs: Vec<F64x8<FUSED>>,
    /// The new pivot row.
    row: Vec<F64x8<FUSED>>,
    ratio: Vec<F64x8<FUSED>>,
    basic: Vec<Basic>,
    /// Whether slot j holds z_j rather than w_j.
    holds_z: Vec<bool>,
    /// Pivots of the last run.
    pub pivots: usize,
}

/// Number `i` of a padded vector.
#[inline(always)]
fn at<const FUSED: bool>(v: &[F64x8<FUSED>], i: usize) -> f64 {
    v[i / WIDTH].get(i % WIDTH)
}

#[inline(always)]
fn put<const FUSED: bool>(v: &mut [F64x8<FUSED>], i: usize, x: f64) {
    v[i / WIDTH].set(i % WIDTH, x);
}

impl<const FUSED: bool> Tableau<FUSED> {
    /// Runs the method on the row-major `a` and `q`, at most `limit` pivots. O(n^2) a pivot.
    #[inline(always)]
    pub fn solve(&mut self, n: usize, a: &[f64], q: &[f64], limit: usize) -> Stop {
        self.load(n, a, q);
        let Some(mut row) = self.first_row() else {
            return Stop::Basis;
        };
        let mut driving = Basic::Z0;
        loop {
            let left = std::mem::replace(&mut self.basic[row], driving);
            self.exchange(row);
            self.pivots += 1;
            driving = match left {
                Basic::Z0 => return Stop::Basis,
                Basic::W(i) => self.drive(i, true),
                Basic::Z(i) => self.drive(i, false),
            };
            if self.pivots >= limit {
                return Stop::Limit;
            }
            match self.blocking_row() {
                Some(blocking) => row = blocking,
                None => return Stop::Ray,
            }
        }
    }

    /// `w = q + A z + d z_0`, with z_0's column ready to drive.
    #[inline(always)]
    fn load(&mut self, n: usize, a: &[f64], q: &[f64]) {
        let (width, zero) = (n.div_ceil(WIDTH), F64x8::splat(0.0));
        if n != self.n {
            self.n = n;
            self.width = width;
            self.t.resize(n * width, zero);
            for v in [&mut self.column, &mut self.rhs, &mut self.row, &mut self.ratio] {
                v.resize(width, zero);
            }
            self.basic.resize(n, Basic::Z0);
            self.holds_z.resize(n, true);
            for v in [&mut self.column, &mut self.rhs] {
                v.fill(zero);
            }
        }
        self.pivots = 0;
        for i in 0..n {
            for (target, source) in
                self.t[i * width..(i + 1) * width].iter_mut().zip(a[i * n..(i + 1) * n].chunks(WIDTH))
            {
                *target = F64x8::from_slice(source);
            }
            put(&mut self.rhs, i, q[i]);
            put(&mut self.column, i, spread(i));
            self.basic[i] = Basic::W(i);
            self.holds_z[i] = true;
        }
    }

    /// The row that z_0 enters: the last to become nonnegative. `None` if `q >= 0`.
    #[inline(always)]
    fn first_row(&self) -> Option<usize> {
        let (mut row, mut largest) = (None, 0.0);
        for i in 0..self.n {
            let needed = -at(&self.rhs, i) / at(&self.column, i);
            if needed > largest {
                (row, largest) = (Some(i), needed);
            }
        }
        row
    }

    /// The driving variable and the basic one of `row` change places; the latter's column is left in `column`.
    #[inline(always)]
    fn exchange(&mut self, row: usize) {
        let (n, width) = (self.n, self.width);
        let reciprocal = 1.0 / at(&self.column, row);
        let minus = F64x8::splat(-reciprocal);
        let new = &mut self.row[..width];
        for (p, t) in new.iter_mut().zip(&mut self.t[row * width..(row + 1) * width]) {
            *p = t.mul(minus);
            *t = F64x8::splat(0.0);
        }
        let value = F64x8::splat(-at(&self.rhs, row) * reciprocal);
        // Adding 1 times the new row to the zeroed old one writes it without a branch.
        put(&mut self.rhs, row, 0.0);
        put(&mut self.column, row, 1.0);
        for i in 0..n {
            let f = F64x8::splat(at(&self.column, i));
            for (t, p) in self.t[i * width..(i + 1) * width].iter_mut().zip(&*new) {
                *t = t.add_product(f, *p);
            }
        }
        let (noise, reciprocal) = (F64x8::splat(NOISE), F64x8::splat(reciprocal));
        for (r, c) in self.rhs.iter_mut().zip(&mut self.column) {
            let sum = r.add_product(*c, value);
            *r = sum.only(r.abs().mul(noise).lt(sum.abs()));
            *c = c.mul(reciprocal);
        }
    }

    /// The partner of the variable that has just left drives next: their columns change places.
    #[inline(always)]
    fn drive(&mut self, pair: usize, w_left: bool) -> Basic {
        let (block, lane) = (pair / WIDTH, pair % WIDTH);
        for i in 0..self.n {
            let t = &mut self.t[i * self.width + block];
            let partner = t.get(lane);
            t.set(lane, at(&self.column, i));
            put(&mut self.column, i, partner);
        }
        self.holds_z[pair] = !w_left;
        if w_left { Basic::Z(pair) } else { Basic::W(pair) }
    }

    /// The first row to reach zero as the driving variable grows.
    #[inline(always)]
    fn blocking_row(&mut self) -> Option<usize> {
        let (zero, infinity) = (F64x8::splat(0.0), F64x8::splat(f64::INFINITY));
        let largest = self.column.iter().fold(zero, |m, c| m.max(c.abs())).fold_max();
        let tolerance = F64x8::splat(-PIVOT_TOLERANCE * largest);
        let mut least = infinity;
        for ((ratio, r), c) in self.ratio.iter_mut().zip(&self.rhs).zip(&self.column) {
            *ratio = r.max(zero).div(c.neg()).or_else(c.lt(tolerance), infinity);
            least = ratio.min(least);
        }
        let least = least.fold_min();
        if least == f64::INFINITY {
            return None;
        }
        let bound = least * TIE;
        let (mut row, mut pivot) = (None, 0.0);
        for i in 0..self.n {
            if at(&self.ratio, i) <= bound {
                if self.basic[i] == Basic::Z0 {
                    return Some(i);
                }
                let x = at(&self.column, i).abs();
                if x > pivot {
                    (row, pivot) = (Some(i), x);
                }
            }
        }
        row
    }

    /// Writes the basic z's, negative rounding set to zero.
    #[inline(always)]
    pub fn solution(&self, z: &mut [f64]) {
        z.fill(0.0);
        for i in 0..self.n {
            if let Basic::Z(j) = self.basic[i] {
                let x = at(&self.rhs, i);
                z[j] = if x > 0.0 { x } else { 0.0 };
            }
        }
    }

    /// Whether z_j is basic.
    #[inline(always)]
    pub fn is_basic(&self, j: usize) -> bool {
        !self.holds_z[j]
    }

    /// `z_a -= A_aa^-1 w_a`, the inverse read off the final tableau.
    #[inline(always)]
    pub fn refine(&self, z: &mut [f64], w: &[f64]) {
        for i in 0..self.n {
            if let Basic::Z(j) = self.basic[i] {
                let row = &self.t[i * self.width..(i + 1) * self.width];
                let mut step = 0.0;
                for (k, w) in w.iter().enumerate() {
                    if self.is_basic(k) {
                        step += at(row, k) * w;
                    }
                }
                let x = z[j] - step;
                z[j] = if x > CANCELLED * z[j] { x } else { 0.0 };
            }
        }
    }
}

/// Entry i of the covering vector: 1 plus the fractional part of `(i + 1)` times the golden ratio.
#[inline(always)]
fn spread(i: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    1.0 + ((i + 1) as f64 * GOLDEN).fract()
}
