//! Lemke's method, one problem per lane: the tableau, covering vector and rules of [`lemke`](super::lemke), every
//! lane with its own pivot row and driving variable. [CPS92, sec. 4.4]
//!
//! Slots are stored column by column, so that the lanes whose driving variable comes from a slot are one mask for the
//! whole column. Lanes that have finished compute on without being looked at.

use super::newton::Tile;
use crate::small::lane::{Lane, Mask};
use crate::small::lemke::{NOISE, PIVOT_TOLERANCE, TIE, spread};

/// z_0 in a row.
const ARTIFICIAL: u8 = u8::MAX;

/// Memory for [`Pivots::solve`].
pub struct Pivots<X: Lane> {
    /// Slot j, row i at `j n + i`.
    t: Vec<X>,
    column: Vec<X>,
    partner: Vec<X>,
    rhs: Vec<X>,
    /// Column of the variable that leaves.
    leaving: Vec<X>,
    /// The new pivot row.
    row: Vec<X>,
    /// Who sits in row i, lane by lane: j for w_j, n + j for z_j, or `ARTIFICIAL`.
    basic: Vec<[u8; 16]>,
}

impl<X: Lane<Number = f64>> Pivots<X> {
    /// Memory for problems of order `n`.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let vector = vec![X::splat(0.0); n];
        Self {
            t: vec![X::splat(0.0); n * n],
            column: vector.clone(),
            partner: vector.clone(),
            rhs: vector.clone(),
            leaving: vector.clone(),
            row: vector,
            basic: vec![[0; 16]; n],
        }
    }

    /// Solves the problems of `tile`; z and alpha are set for the lanes returned, which ended with a complementary
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
        for i in 0..n {
            for j in 0..n {
                self.t[j * n + i] = tile.a[i * n + j];
            }
            self.rhs[i] = tile.q[i];
            self.column[i] = X::splat(spread(i));
            self.basic[i] = [i as u8; 16];
            tile.z[i] = X::splat(0.0);
            tile.alpha[i] = X::Mask::NONE;
        }
        let (mut rows, mut finished) = ([0; 16], X::Mask::NONE);
        let mut active = self.first_rows::<N>(n, lanes, &mut rows);
        for l in 0..X::LANES {
            finished.set(l, lanes.get(l) && !active.get(l));
        }
        let artificial = rows;
        let mut driving = [ARTIFICIAL; 16];
        *pivots = [0; 16];
        for _ in 0..limit {
            if !active.any() {
                break;
            }
            let mut pair = X::splat(-1.0);
            let mut done = X::Mask::NONE;
            for l in (0..X::LANES).filter(|&l| active.get(l)) {
                let left = std::mem::replace(&mut self.basic[rows[l]][l], driving[l]);
                pivots[l] += 1;
                if left == ARTIFICIAL {
                    done.set(l, true);
                } else {
                    let left = usize::from(left);
                    let j = if left < n { left } else { left - n };
                    driving[l] = (if left < n { left + n } else { j }) as u8;
                    pair.set(l, j as f64);
                }
            }
            self.exchange::<N>(n, &rows, pair);
            if done.any() {
                self.harvest::<N>(n, tile, done);
                finished = finished.or(done);
                active = active.and(done.not());
            }
            active = active.and(self.blocking_rows::<N>(n, &artificial, &mut rows));
        }
        finished
    }

    /// The rows that z_0 enters; lanes with `q >= 0` are left out of the mask.
    #[inline(always)]
    fn first_rows<const N: usize>(&self, n: usize, lanes: X::Mask, rows: &mut [usize; 16]) -> X::Mask {
        let n = if N == 0 { n } else { N };
        let (mut largest, mut row) = (X::splat(0.0), X::splat(0.0));
        for i in 0..n {
            let needed = self.rhs[i].neg().mul(X::splat(1.0 / spread(i)));
            let larger = largest.lt(needed);
            largest = needed.or_else(larger, largest);
            row = X::splat(i as f64).or_else(larger, row);
        }
        for l in 0..X::LANES {
            rows[l] = row.get(l) as usize;
        }
        lanes.and(X::splat(0.0).lt(largest))
    }

    /// The driving variables and the basic ones of `rows` change places; see
    /// [`Tableau::exchange`](crate::small::lemke::Tableau). `pair` names the slot that drives next, -1 for none.
    #[inline(always)]
    fn exchange<const N: usize>(&mut self, n: usize, rows: &[usize; 16], pair: X) {
        let n = if N == 0 { n } else { N };
        let (t, column, partner) = (&mut self.t[..n * n], &mut self.column[..n], &mut self.partner[..n]);
        let (rhs, leaving, row) = (&mut self.rhs[..n], &mut self.leaving[..n], &mut self.row[..n]);
        let (mut pivot, mut value) = (X::splat(0.0), X::splat(0.0));
        for l in 0..X::LANES {
            let r = rows[l].min(n - 1);
            pivot.set(l, column[r].get(l));
            value.set(l, rhs[r].get(l));
            column[r].set(l, 1.0);
            rhs[r].set(l, 0.0);
            for j in 0..n {
                let x = &mut t[j * n + r];
                row[j].set(l, x.get(l));
                x.set(l, 0.0);
            }
        }
        let reciprocal = X::splat(1.0).div(pivot);
        let minus = reciprocal.neg();
        let value = value.mul(minus);
        let noise = X::splat(NOISE);
        for i in 0..n {
            let (r, c) = (rhs[i], column[i]);
            let sum = r.add_product(c, value);
            rhs[i] = sum.only(r.abs().mul(noise).lt(sum.abs()));
            leaving[i] = c.mul(reciprocal);
        }
        for j in 0..n {
            let p = row[j].mul(minus);
            let slot = &mut t[j * n..(j + 1) * n];
            let mine = pair.eq(X::splat(j as f64));
            if mine.any() {
                for i in 0..n {
                    let sum = slot[i].add_product(column[i], p);
                    partner[i] = sum.or_else(mine, partner[i]);
                    slot[i] = leaving[i].or_else(mine, sum);
                }
            } else {
                for i in 0..n {
                    slot[i] = slot[i].add_product(column[i], p);
                }
            }
        }
        column.copy_from_slice(partner);
    }

    /// The first rows to reach zero as the driving variables grow; lanes without one are left out of the mask.
    #[inline(always)]
    fn blocking_rows<const N: usize>(&self, n: usize, artificial: &[usize; 16], rows: &mut [usize; 16]) -> X::Mask {
        let n = if N == 0 { n } else { N };
        let (column, rhs) = (&self.column[..n], &self.rhs[..n]);
        let zero = X::splat(0.0);
        let mut largest = zero;
        for c in column {
            largest = c.abs().max(largest);
        }
        let tolerance = largest.mul(X::splat(PIVOT_TOLERANCE));
        // The least ratio as a fraction, infinity at first: ratios are compared without dividing.
        let (mut over, mut under, mut row) = (X::splat(1.0), zero, X::splat(-1.0));
        for i in 0..n {
            let (r, d) = (rhs[i].max(zero), column[i].neg());
            let smaller = tolerance.lt(d).and(r.mul(under).lt(over.mul(d)));
            over = r.or_else(smaller, over);
            under = d.or_else(smaller, under);
            row = X::splat(i as f64).or_else(smaller, row);
        }
        let blocked = zero.le(row);
        for l in 0..X::LANES {
            if blocked.get(l) {
                let z0 = artificial[l];
                let (r, d) = (rhs[z0].get(l).max(0.0), -column[z0].get(l));
                let tied = d > tolerance.get(l) && r * under.get(l) <= over.get(l) * d * TIE;
                rows[l] = if tied { z0 } else { row.get(l) as usize };
            }
        }
        blocked
    }

    /// Copies the basic z's of the lanes that are done.
    #[inline(always)]
    fn harvest<const N: usize>(&self, n: usize, tile: &mut Tile<X>, done: X::Mask) {
        let n = if N == 0 { n } else { N };
        for l in (0..X::LANES).filter(|&l| done.get(l)) {
            for i in 0..n {
                let j = usize::from(self.basic[i][l]);
                if (n..2 * n).contains(&j) {
                    tile.z[j - n].set(l, self.rhs[i].get(l).max(0.0));
                    tile.alpha[j - n].set(l, true);
                }
            }
        }
    }
}
