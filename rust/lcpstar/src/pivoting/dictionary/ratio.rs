//! The ratio test, and what it takes for zero and for equal.

use super::{Dictionary, Place, tie_tolerance};
use crate::pivoting::Var;
use crate::pivoting::real::Real;
use lcpstar_kernels::pivots::ORDERED;

/// How the driving variable moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entering {
    /// Up from zero: every pivot but the first.
    Increasing,
    /// Down from plus infinity: `z_0` in Lemke's first pivot, stopped by the last row to become negative.
    Descending,
}

/// An entry larger than this, relative to 1 and to the entries that tie, is taken for growth and not for the column's scale.
const LARGEST: f64 = 1e6;

impl<T: Real> Dictionary<T> {
    /// The row that blocks column `s`: the lexicographic minimum of `(q_bar_r, (B^-1)_r) / -T_rs` over the rows that
    /// decrease; among rows that tie in the first component, the one holding `z_0` wins. `None`: a ray. [CPS92, 4.9]
    ///
    /// Rounding is kept out of both decisions: a coefficient below [`ORDERED`] `max|T_s|` does not decrease, and numbers that agree to
    /// [`tie_tolerance`] tie. O(n), plus O(n) for each component needed to break a tie.
    pub fn blocking_row(&mut self, s: usize, entering: Entering) -> Option<usize> {
        let mut column = std::mem::take(&mut self.column);
        self.load(s, &mut column);
        self.column = column;
        self.loaded = Some(s);
        let sign = if entering == Entering::Increasing { -1.0 } else { 1.0 };
        let (mut key, mut ratios) = (std::mem::take(&mut self.key), std::mem::take(&mut self.ratios));
        let mut tied = std::mem::take(&mut self.tied);
        let blocking = self.lexicographic_minimum(sign, &mut key, &mut ratios, &mut tied);
        (self.key, self.ratios, self.tied) = (key, ratios, tied);
        blocking
    }

    /// What row `r` loses as the driving variable moves by one.
    fn rate(&self, sign: f64, r: usize) -> T {
        self.column[r] * T::from(sign)
    }

    fn lexicographic_minimum(
        &self,
        sign: f64,
        key: &mut [T],
        ratios: &mut [T],
        tied: &mut Vec<usize>,
    ) -> Option<usize> {
        let (column, values, n) = (&self.column, &self.values, self.basic.len());
        let tol_pivot = ORDERED * (T::EPSILON / f64::EPSILON) * T::largest(column);
        let minimum = T::ratios(values, column, sign, tol_pivot, ratios);
        if minimum.to_f64() == f64::INFINITY {
            return None;
        }
        let tol = tie_tolerance::<T>(n) * T::largest(values);
        tied.clear();
        tied.extend((0..n).filter(|&r| {
            ratios[r].to_f64() < f64::INFINITY && (values[r] - minimum * self.rate(sign, r)).to_f64() <= tol
        }));
        if let Some(r) = tied.iter().copied().find(|&r| self.basic[r] == Var::Z0) {
            return Some(r);
        }
        self.break_tie(sign, key, tied)
    }

    /// Compares the tied rows of the basis inverse, component by component.
    fn break_tie(&self, sign: f64, key: &mut [T], tied: &mut Vec<usize>) -> Option<usize> {
        for place in &self.places[0] {
            if tied.len() <= 1 {
                break;
            }
            match *place {
                Place::Column(c) => self.keep_minima(c, sign, key, tied),
                // A unit vector: the row of w_j itself is the larger one.
                Place::Row(k) => tied.retain(|&r| r != k),
                Place::Elsewhere => {}
            }
        }
        tied.first().copied()
    }

    /// Keeps the rows in which `-T_rc / rate_r` is minimal, to rounding of the largest entry of the column. That entry is
    /// looked for only when the decision depends on it.
    fn keep_minima(&self, c: usize, sign: f64, key: &mut [T], tied: &mut Vec<usize>) {
        let (mut minimum, mut size) = (T::from(f64::INFINITY), 0.0_f64);
        for &r in &*tied {
            key[r] = -self.coefficient(r, c);
            let ratio = key[r] / self.rate(sign, r);
            minimum = if ratio < minimum { ratio } else { minimum };
            size = size.max(key[r].to_f64().abs());
        }
        let excess = |key: &[T], r: usize| (key[r] - minimum * self.rate(sign, r)).to_f64();
        let tol = tie_tolerance::<T>(self.basic.len());
        let (surely_tied, surely_not) = (tol * size, tol * LARGEST * size.max(1.0));
        let unclear = |r: usize| excess(key, r) > surely_tied && excess(key, r) <= surely_not;
        if !tied.iter().any(|&r| unclear(r)) {
            tied.retain(|&r| excess(key, r) <= surely_tied);
            return;
        }
        self.load(c, key);
        let tol = tol * T::largest(key);
        key.iter_mut().for_each(|x| *x = -*x);
        tied.retain(|&r| excess(key, r) <= tol);
    }
}
