//! Lemke's method, one problem per lane: the covering vector and rules of [`lemke`](crate::small::lemke), every lane
//! with its own pivot row and driving variable. [CPS92, sec. 4.4]
//!
//! A condensed tableau, `basic_i = rhs_i + sum_j t_ij nonbasic_j` with n rows and n + 1 columns, exchanged in place:
//! with pivot (r, s), `c` the column of the driving variable and `p` the new row r, every entry becomes
//! `t_ij + c_i p_j`, where row r and column s are cleared first, `c_r = 1` and `p_s = 1 / t_rs`. So lanes that pivot
//! elsewhere share one formula, and those that have finished get `p = 0`.
//!
//! Labels are signed numbers: `j + 1` for w_j, `-(j + 1)` for z_j, 0 for z_0; minus a label is its complement.

use super::newton::{Tile, multiply};
use crate::pivots::SPREAD;
use crate::small::covering::spread;
use crate::small::lane::{Lane, Mask};
use crate::small::lemke::{CANCELLED, ROUNDING};
use crate::small::ratio::TIE;
use crate::small::tableau::NOISE;

/// Memory for [`Pivots::solve`].
pub struct Pivots<X: Lane> {
    /// Row i, column j at `i (n + 1) + j`.
    t: Vec<X>,
    rhs: Vec<X>,
    /// Labels of the rows.
    basic: Vec<X>,
    /// Column of the nonbasic member of each pair.
    place: Vec<X>,
    /// Of the driving variable.
    column: Vec<X>,
    /// The new pivot row.
    row: Vec<X>,
    /// `|q_a|` by column.
    terms: Vec<X>,
    /// Where a lane's driving variable does not stand in column j.
    elsewhere: Vec<X::Mask>,
    /// Value by label: that of label k at `k + n`, -1 for the nonbasic ones.
    values: Vec<X>,
}

/// Where each lane stands.
struct State<X: Lane> {
    active: X::Mask,
    /// Pivot row; -1 for none.
    row: X,
    /// Row of z_0.
    artificial: X,
    /// Label of the driving variable.
    driving: X,
    /// Its column.
    slot: X,
}

/// The ratio `over / under` of a row.
#[derive(Clone, Copy)]
struct Ratio<X> {
    over: X,
    under: X,
}

impl<X: Lane> Ratio<X> {
    /// The smaller one, lane by lane; a ratio `over / 0` is never the smaller one.
    #[inline(always)]
    fn or(self, x: Self) -> Self {
        let smaller = x.over.mul(self.under).lt(self.over.mul(x.under));
        Self { over: x.over.or_else(smaller, self.over), under: x.under.or_else(smaller, self.under) }
    }
}

impl<X: Lane> Pivots<X> {
    /// Memory for problems of order `n`.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zeros = |length| vec![X::splat(0.0); length];
        Self {
            t: zeros(n * (n + 1)),
            rhs: zeros(n),
            basic: zeros(n),
            place: zeros(n),
            column: zeros(n),
            row: zeros(n + 1),
            terms: zeros(n + 1),
            elsewhere: vec![X::Mask::NONE; n + 1],
            values: zeros(2 * n + 1),
        }
    }

    /// Solves the problems of `tile`; z, w and alpha are set for the lanes returned, which ended with a complementary
    /// basis within `limit` pivots; `pivots` counts them. O(n^2) a pivot.
    #[inline(always)]
    pub fn solve<const N: usize>(
        &mut self,
        n: usize,
        tile: &mut Tile<X>,
        lanes: X::Mask,
        limit: usize,
        pivots: &mut [u8; 16],
    ) -> X::Mask {
        let n = if N == 0 { n } else { N };
        let (zero, one) = (X::splat(0.0), X::splat(1.0));
        let mut state = self.start::<N>(n, tile, lanes);
        let mut finished = lanes.and(state.active.not());
        let mut count = zero;
        for _ in 0..limit {
            if !state.active.any() {
                break;
            }
            count = count.add(one.only(state.active));
            let left = self.exchange::<N>(n, &state);
            let done = state.active.and(left.eq(zero));
            finished = finished.or(done);
            state.active = state.active.and(done.not());
            self.drive::<N>(n, &mut state, left.neg());
            self.block::<N>(n, &mut state);
        }
        for l in 0..X::LANES {
            pivots[l] = count.get(l) as u8;
        }
        self.harvest::<N>(n, tile);
        finished
    }

    /// `w = q + A z + d z_0`, z_0 driving, blocked by the row that becomes nonnegative last.
    #[inline(always)]
    fn start<const N: usize>(&mut self, n: usize, tile: &Tile<X>, lanes: X::Mask) -> State<X> {
        let n = if N == 0 { n } else { N };
        let s = n + 1;
        let zero = X::splat(0.0);
        let (mut largest, mut row) = (zero, X::splat(-1.0));
        for i in 0..n {
            self.t[i * s..i * s + n].copy_from_slice(&tile.a[i * n..(i + 1) * n]);
            self.t[i * s + n] = zero;
            self.column[i] = X::splat(spread(i));
            self.rhs[i] = tile.q[i];
            self.basic[i] = X::splat((i + 1) as f64);
            self.place[i] = X::splat(i as f64);
            let needed = tile.q[i].neg().mul(X::splat(1.0 / spread(i)));
            let larger = largest.lt(needed);
            largest = needed.or_else(larger, largest);
            row = X::splat(i as f64).or_else(larger, row);
        }
        let active = lanes.and(zero.lt(largest));
        row = row.or_else(active, X::splat(-1.0));
        State { active, row, artificial: row, driving: zero, slot: X::splat(n as f64) }
    }

    /// The driving variables and the basic ones of the pivot rows change places; returns the labels of the latter.
    #[inline(always)]
    fn exchange<const N: usize>(&mut self, n: usize, state: &State<X>) -> X {
        let n = if N == 0 { n } else { N };
        let s = n + 1;
        let (t, column, row) = (&mut self.t[..n * s], &mut self.column[..n], &mut self.row[..s]);
        let (rhs, basic, elsewhere) = (&mut self.rhs[..n], &mut self.basic[..n], &mut self.elsewhere[..s]);
        let at = state.row.index(n, 1);
        let left = X::pick(basic, at);
        let reciprocal = X::splat(1.0).div(X::pick(column, at)).only(state.active);
        let minus = reciprocal.neg();
        let value = X::pick(rhs, at).mul(minus);
        let at = state.row.index(n, s);
        for j in 0..s {
            let here = state.slot.eq(X::splat(j as f64));
            let p = X::pick(&t[j..], at).mul(minus);
            row[j] = reciprocal.or_else(here, p);
            elsewhere[j] = here.and(state.active).not();
        }
        let noise = X::splat(NOISE);
        for i in 0..n {
            let here = state.row.eq(X::splat(i as f64));
            column[i] = X::splat(1.0).or_else(here, column[i]);
            let r = rhs[i].only(here.not());
            let sum = r.add_product(column[i], value);
            rhs[i] = sum.only(r.abs().mul(noise).lt(sum.abs()));
            basic[i] = state.driving.or_else(here, basic[i]);
        }
        let (mut rows, mut i) = (t.chunks_exact_mut(2 * s), 0);
        for rows in rows.by_ref() {
            let (c, d) = (column[i], column[i + 1]);
            let (keep, hold) = (state.row.eq(X::splat(i as f64)).not(), state.row.eq(X::splat((i + 1) as f64)).not());
            let (first, second) = rows.split_at_mut(s);
            for ((a, b), (p, stays)) in first.iter_mut().zip(second).zip(row.iter().zip(&*elsewhere)) {
                let (p, stays) = (*p, *stays);
                *a = a.only(keep.and(stays)).add_product(c, p);
                *b = b.only(hold.and(stays)).add_product(d, p);
            }
            i += 2;
        }
        for last in rows.into_remainder().chunks_exact_mut(s) {
            let (c, keep) = (column[i], state.row.eq(X::splat(i as f64)).not());
            for (a, (p, stays)) in last.iter_mut().zip(row.iter().zip(&*elsewhere)) {
                *a = a.only(keep.and(*stays)).add_product(c, *p);
            }
            i += 1;
        }
        left
    }

    /// The variables labelled `driving` drive next: those of `left` take their columns.
    #[inline(always)]
    fn drive<const N: usize>(&mut self, n: usize, state: &mut State<X>, driving: X) {
        let n = if N == 0 { n } else { N };
        let s = n + 1;
        let place = &mut self.place[..n];
        let pair = driving.abs().sub(X::splat(1.0)).or_else(state.active, X::splat(-1.0));
        let slot = X::pick(place, pair.index(n, 1)).or_else(state.active, state.slot);
        for j in 0..n {
            place[j] = state.slot.or_else(pair.eq(X::splat(j as f64)), place[j]);
        }
        let at = slot.index(s, 1);
        for i in 0..n {
            self.column[i] = X::pick(&self.t[i * s..(i + 1) * s], at);
        }
        state.slot = slot;
        state.driving = driving;
    }

    /// The first rows to reach zero as the driving variables grow; lanes without one are no longer active.
    #[inline(always)]
    fn block<const N: usize>(&self, n: usize, state: &mut State<X>) {
        let n = if N == 0 { n } else { N };
        let (column, rhs) = (&self.column[..n], &self.rhs[..n]);
        let (zero, none) = (X::splat(0.0), X::splat(-1.0));
        let mut largest = [zero; 4];
        for (i, c) in column.iter().enumerate() {
            largest[i % 4] = c.abs().max(largest[i % 4]);
        }
        let largest = largest[0].max(largest[1]).max(largest[2].max(largest[3]));
        let tolerance = largest.mul(X::splat(SPREAD));
        // Least ratios as fractions, infinity at first, compared without dividing; four searches side by side.
        let mut least = [Ratio { over: X::splat(1.0), under: zero }; 4];
        for i in 0..n {
            let (over, d) = (rhs[i].max(zero), column[i].neg());
            least[i % 4] = least[i % 4].or(Ratio { over, under: d.only(tolerance.lt(d)) });
        }
        let Ratio { over, under } = least[0].or(least[1]).or(least[2].or(least[3]));
        let over = over.mul(X::splat(TIE));
        // The largest pivot of the rows that are tied.
        let mut best = [(zero, none); 4];
        for i in 0..n {
            let (r, d) = (rhs[i].max(zero), column[i].neg());
            let (pivot, row) = best[i % 4];
            let better = pivot.max(tolerance).lt(d).and(r.mul(under).le(over.mul(d)));
            best[i % 4] = (d.or_else(better, pivot), X::splat(i as f64).or_else(better, row));
        }
        let (mut pivot, mut row) = best[0];
        for (d, i) in &best[1..] {
            let better = pivot.lt(*d);
            (pivot, row) = (d.or_else(better, pivot), i.or_else(better, row));
        }
        state.active = state.active.and(zero.le(row));
        let at = state.artificial.index(n, 1);
        let (r, d) = (X::pick(rhs, at).max(zero), X::pick(column, at).neg());
        let tied = tolerance.lt(d).and(r.mul(under).le(over.mul(d)));
        state.row = state.artificial.or_else(tied, row).or_else(state.active, none);
    }

    /// Puts the basic z's in place, rounding below zero set to zero, and computes w.
    #[inline(always)]
    fn harvest<const N: usize>(&mut self, n: usize, tile: &mut Tile<X>) {
        let n = if N == 0 { n } else { N };
        let values = &mut self.values[..2 * n + 1];
        values.fill(X::splat(-1.0));
        let zero = X::splat(0.0);
        for i in 0..n {
            let value = self.rhs[i].max(zero);
            for l in 0..X::LANES {
                let label = self.basic[i].get(l) as isize + n as isize;
                values[label as usize].set_from(l, &value);
            }
        }
        for j in 0..n {
            let value = values[n - 1 - j];
            tile.z[j] = value.max(zero);
            tile.alpha[j] = zero.le(value);
        }
        multiply::<X, N>(n, tile);
    }

    /// `z_a -= A_aa^-1 w_a` for the lanes of `which`, the inverse read off the final tableau, then w again. What cancels
    /// was rounding error, and so is what is small beside the terms of `A_aa^-1 q_a`.
    #[inline(always)]
    pub fn refine<const N: usize>(&mut self, n: usize, tile: &mut Tile<X>, which: X::Mask) {
        let n = if N == 0 { n } else { N };
        let (s, zero) = (n + 1, X::splat(0.0));
        let (w_a, q_a) = (&mut self.row, &mut self.terms);
        w_a.fill(zero);
        q_a.fill(zero);
        for k in 0..n {
            let (w, q) = (tile.w[k].only(tile.alpha[k]), tile.q[k].abs().only(tile.alpha[k]));
            for l in 0..X::LANES {
                let column = self.place[k].get(l) as usize;
                w_a[column].set_from(l, &w);
                q_a[column].set_from(l, &q);
            }
        }
        for i in 0..n {
            let (mut step, mut size) = (zero, zero);
            for (t, (w, q)) in self.t[i * s..(i + 1) * s].iter().zip(w_a.iter().zip(&*q_a)) {
                step = step.add_product(*t, *w);
                size = size.add_product(t.abs(), *q);
            }
            let value = self.rhs[i].max(zero);
            let better = value.sub(step);
            let least = value.mul(X::splat(CANCELLED)).max(size.mul(X::splat(ROUNDING)));
            let better = better.only(least.lt(better));
            self.rhs[i] = better.or_else(which, self.rhs[i]);
        }
        self.harvest::<N>(n, tile);
    }
}
