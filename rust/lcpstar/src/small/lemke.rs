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

use super::lane::{Lane, Mask};
use super::verify::{Judged, is_small_when_equilibrated, verify_one};
use crate::scaling::{Scaling, times_power_of_two};

/// Numbers per row are padded to a multiple of this.
const WIDTH: usize = 8;

/// Who sits in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Basic {
    W(usize),
    Z(usize),
    Z0,
}

/// How the method stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    /// z_0 left: the basis is complementary.
    Basis,
    /// No blocking row.
    Ray,
    /// Too many pivots.
    Limit,
}

/// Refinement steps at most.
const REFINEMENTS: usize = 2;

/// Pivots per row of the problem after which the method gives up.
pub(crate) const PIVOTS_PER_ROW: usize = 10;

/// Smallest pivot relative to the largest entry of the driving column.
pub(crate) const PIVOT_TOLERANCE: f64 = 1e-10;

/// Ratios within this factor of the least one are tied.
pub(crate) const TIE: f64 = 1.0 + 1e-11;

/// A value that cancels to less than this part of itself is rounding error, and zero.
pub(crate) const NOISE: f64 = 1e-14;

/// A correction that leaves less than this part of a value shows that the value was rounding error.
pub(crate) const CANCELLED: f64 = 1e-8;

/// The tableau and what belongs to it; grows to the largest problem it has seen.
pub struct Tableau<X> {
    n: usize,
    /// Vectors per row.
    width: usize,
    /// `A` as given, for the verification.
    a: Vec<X>,
    t: Vec<X>,
    column: Vec<X>,
    rhs: Vec<X>,
    /// The new pivot row.
    row: Vec<X>,
    ratio: Vec<X>,
    z: Vec<X>,
    /// The diagonals of `D_r A D_c`, on which the pivots work, when the problem comes with a scaling.
    row_factors: Vec<f64>,
    column_factors: Vec<X>,
    sums: Vec<[X; 2]>,
    basic: Vec<Basic>,
    /// Whether slot j holds z_j rather than w_j.
    holds_z: Vec<bool>,
    /// Whether the last run ended with a complementary basis.
    pub found_basis: bool,
    /// Pivots of the last run.
    pub pivots: usize,
}

/// Number `i` of a padded vector.
#[inline(always)]
fn at<X: Lane<Number = f64>>(v: &[X], i: usize) -> f64 {
    v[i / WIDTH].get(i % WIDTH)
}

#[inline(always)]
fn put<X: Lane<Number = f64>>(v: &mut [X], i: usize, x: f64) {
    v[i / WIDTH].set(i % WIDTH, x);
}

impl<X> Default for Tableau<X> {
    fn default() -> Self {
        Self {
            n: 0,
            width: 0,
            a: Vec::new(),
            t: Vec::new(),
            column: Vec::new(),
            rhs: Vec::new(),
            row: Vec::new(),
            ratio: Vec::new(),
            z: Vec::new(),
            row_factors: Vec::new(),
            column_factors: Vec::new(),
            sums: Vec::new(),
            basic: Vec::new(),
            holds_z: Vec::new(),
            found_basis: false,
            pivots: 0,
        }
    }
}

impl<X: Lane<Number = f64>> Tableau<X> {
    /// Runs the method and refines the answer until it is verified; `None` if that fails. `w = A z + q` as computed.
    #[inline(always)]
    pub fn solve_and_verify(
        &mut self,
        n: usize,
        a: &[f64],
        q: &[f64],
        scaling: Option<&Scaling>,
        w: &mut [f64],
        tol: f64,
    ) -> Option<Judged> {
        self.load(n, a, q, scaling);
        self.found_basis = self.solve(PIVOTS_PER_ROW * n) == Stop::Basis;
        if !self.found_basis {
            return None;
        }
        let judged = self.verified(q, w, tol);
        self.settled(judged, n, a, q, w, tol)
    }

    /// Judges a point that was found elsewhere; `w = A z + q` as computed. O(n^2).
    #[inline(always)]
    pub fn verify_point(
        &mut self,
        n: usize,
        a: &[f64],
        q: &[f64],
        z: &[f64],
        w: &mut [f64],
        tol: f64,
    ) -> Option<Judged> {
        self.resize(n);
        for i in 0..n {
            self.load_row(i, &a[i * n..(i + 1) * n]);
        }
        for (x, z) in self.z.iter_mut().zip(z.chunks(WIDTH)) {
            *x = X::from_slice(z);
        }
        let judged = self.judge(q, w, tol);
        self.settled(judged, n, a, q, w, tol)
    }

    /// The verdict, if it is that the point solves the problem.
    #[inline(always)]
    fn settled(&self, mut judged: Judged, n: usize, a: &[f64], q: &[f64], w: &[f64], tol: f64) -> Option<Judged> {
        if judged.unsettled {
            let z: Vec<f64> = (0..n).map(|j| self.z(j)).collect();
            judged.solved = is_small_when_equilibrated(n, a, q, &z, w, tol);
        }
        judged.solved.then_some(judged)
    }

    /// Runs the method on the loaded problem, at most `limit` pivots. O(n^2) a pivot.
    #[inline(always)]
    fn solve(&mut self, limit: usize) -> Stop {
        let Some(mut row) = self.first_row() else {
            return Stop::Basis;
        };
        let mut driving = Basic::Z0;
        loop {
            let left = std::mem::replace(&mut self.basic[row], driving);
            self.pivots += 1;
            driving = match left {
                Basic::Z0 => {
                    self.exchange(row, None);
                    return Stop::Basis;
                }
                Basic::W(i) => {
                    self.holds_z[i] = false;
                    self.exchange(row, Some(i));
                    Basic::Z(i)
                }
                Basic::Z(i) => {
                    self.holds_z[i] = true;
                    self.exchange(row, Some(i));
                    Basic::W(i)
                }
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

    /// `w = q + A z + d z_0`, with z_0's column ready to drive; A and q scaled by `D_r` and `D_c` if there is a scaling, of
    /// moderate exponents.
    #[inline(always)]
    fn load(&mut self, n: usize, a: &[f64], q: &[f64], scaling: Option<&Scaling>) {
        self.resize(n);
        self.pivots = 0;
        self.row_factors.clear();
        self.column_factors.clear();
        if let Some(scaling) = scaling {
            self.row_factors.extend(scaling.rows.iter().map(|&r| times_power_of_two(1.0, r)));
            let factors = scaling.columns.chunks(WIDTH).map(|columns| {
                let mut factors = X::splat(0.0);
                columns.iter().enumerate().for_each(|(l, &c)| factors.set(l, times_power_of_two(1.0, c)));
                factors
            });
            self.column_factors.extend(factors);
        }
        for i in 0..n {
            self.load_row(i, &a[i * n..(i + 1) * n]);
            let padded = i * self.width..(i + 1) * self.width;
            self.t[padded.clone()].copy_from_slice(&self.a[padded.clone()]);
            let row_factor = self.row_factors.get(i).copied().unwrap_or(1.0);
            let f = X::splat(row_factor);
            for (t, factor) in self.t[padded].iter_mut().zip(&self.column_factors) {
                *t = t.mul(factor.mul(f));
            }
            put(&mut self.rhs, i, q[i] * row_factor);
            put(&mut self.column, i, spread(i));
            self.basic[i] = Basic::W(i);
            self.holds_z[i] = true;
        }
    }

    #[inline(always)]
    fn load_row(&mut self, i: usize, entries: &[f64]) {
        let row = &mut self.a[i * self.width..(i + 1) * self.width];
        for (a, entries) in row.iter_mut().zip(entries.chunks(WIDTH)) {
            *a = X::from_slice(entries);
        }
    }

    #[inline(always)]
    fn resize(&mut self, n: usize) {
        let (width, zero) = (n.div_ceil(WIDTH), X::splat(0.0));
        if n != self.n {
            self.n = n;
            self.width = width;
            self.a.resize(n * width, zero);
            self.t.resize(n * width, zero);
            self.sums.resize(n, [zero; 2]);
            for v in [&mut self.column, &mut self.rhs, &mut self.row, &mut self.ratio, &mut self.z] {
                v.resize(width, zero);
            }
            self.basic.resize(n, Basic::Z0);
            self.holds_z.resize(n, true);
            for v in [&mut self.column, &mut self.rhs] {
                v.fill(zero);
            }
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

    /// The driving variable and the basic one of `row` change places. The latter's column goes to the slot of its pair
    /// and its partner's column, found there, becomes the driving one.
    #[inline(always)]
    fn exchange(&mut self, row: usize, pair: Option<usize>) {
        match self.width {
            1 => self.exchange_wide::<1>(row, pair),
            2 => self.exchange_wide::<2>(row, pair),
            3 => self.exchange_wide::<3>(row, pair),
            4 => self.exchange_wide::<4>(row, pair),
            5 => self.exchange_wide::<5>(row, pair),
            6 => self.exchange_wide::<6>(row, pair),
            7 => self.exchange_wide::<7>(row, pair),
            8 => self.exchange_wide::<8>(row, pair),
            _ => self.exchange_wide::<0>(row, pair),
        }
    }

    /// [`Self::exchange`] for rows of `W` vectors, `W = 0` for any.
    #[inline(always)]
    fn exchange_wide<const W: usize>(&mut self, row: usize, pair: Option<usize>) {
        let width = if W == 0 { self.width } else { W };
        let reciprocal = 1.0 / at(&self.column, row);
        let minus = X::splat(-reciprocal);
        let new = &mut self.row[..width];
        for (p, t) in new.iter_mut().zip(&mut self.t[row * width..(row + 1) * width]) {
            *p = t.mul(minus);
            *t = X::splat(0.0);
        }
        let value = X::splat(-at(&self.rhs, row) * reciprocal);
        // Adding 1 times the new row to the zeroed old one writes it without a branch.
        put(&mut self.rhs, row, 0.0);
        put(&mut self.column, row, 1.0);
        let noise = X::splat(NOISE);
        for (r, c) in self.rhs.iter_mut().zip(&self.column) {
            let sum = r.add_product(*c, value);
            *r = sum.only(r.abs().mul(noise).lt(sum.abs()));
        }
        let mut held = [X::splat(0.0); 8];
        if W != 0 {
            held[..W].copy_from_slice(&new[..W]);
        }
        let (block, lane) = pair.map_or((0, 0), |j| (j / WIDTH, j % WIDTH));
        let mut rows = self.t[..self.n * width].chunks_exact_mut(width);
        for column in &mut self.column {
            let factors = *column;
            for (l, t) in rows.by_ref().take(WIDTH).enumerate() {
                let f = factors.get(l);
                if f != 0.0 {
                    let factor = X::splat(f);
                    if W == 0 {
                        for (t, p) in t.iter_mut().zip(&*new) {
                            *t = t.add_product(factor, *p);
                        }
                    } else {
                        for j in 0..W {
                            t[j] = t[j].add_product(factor, held[j]);
                        }
                    }
                }
                if pair.is_some() {
                    column.set(l, t[block].get(lane));
                    t[block].set(lane, f * reciprocal);
                }
            }
        }
    }

    /// The first row to reach zero as the driving variable grows.
    #[inline(always)]
    fn blocking_row(&mut self) -> Option<usize> {
        let (zero, infinity) = (X::splat(0.0), X::splat(f64::INFINITY));
        let largest = self.column.iter().fold(zero, |m, c| m.max(c.abs())).largest();
        let tolerance = X::splat(-PIVOT_TOLERANCE * largest);
        let mut least = infinity;
        for ((ratio, r), c) in self.ratio.iter_mut().zip(&self.rhs).zip(&self.column) {
            *ratio = r.max(zero).div(c.neg()).or_else(c.lt(tolerance), infinity);
            least = ratio.min(least);
        }
        let least = least.smallest();
        if least == f64::INFINITY {
            return None;
        }
        let bound = X::splat(least * TIE);
        let (mut row, mut pivot) = (None, 0.0);
        for (block, ratio) in self.ratio.iter().enumerate() {
            let mut tied = ratio.le(bound).bits();
            while tied != 0 {
                let i = block * WIDTH + tied.trailing_zeros() as usize;
                tied &= tied - 1;
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

    /// Puts the basic z's in place, negative rounding set to zero, and judges them; `w = A z + q` as computed.
    #[inline(always)]
    fn verified(&mut self, q: &[f64], w: &mut [f64], tol: f64) -> Judged {
        for x in &mut self.z {
            *x = X::splat(0.0);
        }
        for i in 0..self.n {
            if let Basic::Z(j) = self.basic[i] {
                put(&mut self.z, j, at(&self.rhs, i).max(0.0));
            }
        }
        for (z, factors) in self.z.iter_mut().zip(&self.column_factors) {
            *z = z.mul(*factors);
        }
        let mut judged = self.judge(q, w, tol);
        for _ in 0..REFINEMENTS {
            if judged.solved || judged.unsettled {
                break;
            }
            self.refine(w);
            judged = self.judge(q, w, tol);
        }
        judged
    }

    #[inline(always)]
    fn judge(&mut self, q: &[f64], w: &mut [f64], tol: f64) -> Judged {
        verify_one(self.n, self.width, &self.a, q, &self.z, w, &mut self.sums, tol)
    }

    /// z_j.
    #[inline(always)]
    pub fn z(&self, j: usize) -> f64 {
        at(&self.z, j)
    }

    /// Whether z_j is basic.
    #[inline(always)]
    pub fn is_basic(&self, j: usize) -> bool {
        !self.holds_z[j]
    }

    /// `z_a -= A_aa^-1 w_a`, the inverse read off the final tableau.
    #[inline(always)]
    fn refine(&mut self, w: &[f64]) {
        for i in 0..self.n {
            if let Basic::Z(j) = self.basic[i] {
                let row = &self.t[i * self.width..(i + 1) * self.width];
                let mut step = 0.0;
                for (k, w) in w.iter().enumerate() {
                    if self.is_basic(k) {
                        step += at(row, k) * w * self.row_factors.get(k).unwrap_or(&1.0);
                    }
                }
                if !self.column_factors.is_empty() {
                    step *= at(&self.column_factors, j);
                }
                let (old, new) = (at(&self.z, j), at(&self.z, j) - step);
                put(&mut self.z, j, if new > CANCELLED * old { new } else { 0.0 });
            }
        }
    }
}

/// Entry i of the covering vector: 1 plus the fractional part of `(i + 1)` times the golden ratio.
#[inline(always)]
pub(crate) fn spread(i: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    1.0 + ((i + 1) as f64 * GOLDEN).fract()
}
