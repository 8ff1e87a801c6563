//! The condensed dictionary in doubles with delayed updates: a pivot costs its column and its row, and the rest of the
//! dictionary is brought up to date once in [`BLOCK`] pivots, by one product of matrices at the speed of the processor
//! instead of that of the memory.
//!
//! Between updates the dictionary is `base + sum_k u_k v_k'`. The exchange of row r and column s with pivot t clears that
//! row and that column, in the base and in what is pending, and adds one term: `v = -T_r. / t` with `v_s = 1/t`, the new
//! row; `u = T_.s` with `u_r = 1`.

use super::Var;
use super::dictionary::{Entering, PIVOT, tie_tolerance, unit};
use super::path::Tableau;
use crate::linalg::kernels::{self, LANES};
use crate::linalg::update::{Window, add_products};
use crate::problem::Lcp;

/// An entry larger than this, relative to 1 and to the entries that tie, is taken for growth and not for the column's scale.
const LARGEST: f64 = 1e6;

/// Pivots between two updates of the base.
const BLOCK: usize = 16;

/// `x_B = q_bar + T x_N` for any number of basic and nonbasic variables.
#[derive(Clone, Debug)]
pub struct DelayedDictionary {
    /// Numbers in a column, padded; pending columns begin at multiples of it.
    height: usize,
    /// Numbers in a row, padded.
    width: usize,
    base: Vec<f64>,
    /// `u_k`, one after the other.
    left: Vec<f64>,
    /// `v_k`, one after the other.
    right: Vec<f64>,
    pending: usize,
    /// `q_bar`, always up to date.
    values: Vec<f64>,
    /// The column last asked for, up to date.
    column: Vec<f64>,
    loaded: Option<usize>,
    /// Scratch: the key of a tie.
    key: Vec<f64>,
    /// Scratch: the ratios of the rows that decrease, infinity elsewhere.
    ratios: Vec<f64>,
    /// Scratch: rows that tie in the ratio test.
    tied: Vec<usize>,
    basic: Vec<Var>,
    nonbasic: Vec<Var>,
    /// Where `w_j`, `z_j` and `z_0` are.
    places: [Vec<Place>; 3],
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Row(usize),
    Column(usize),
    /// Not in this dictionary.
    Elsewhere,
}

impl DelayedDictionary {
    /// Basic variables with their values, nonbasic ones, and the coefficients by rows; `n` bounds the indices.
    #[must_use]
    pub fn new(n: usize, basic: Vec<(Var, f64)>, nonbasic: Vec<Var>, t: impl Fn(usize, usize) -> f64) -> Self {
        let (rows, columns) = (basic.len(), nonbasic.len());
        let (height, width) = (rows.next_multiple_of(LANES), columns.next_multiple_of(LANES));
        let mut base = vec![0.0; height * width];
        for (r, row) in base.chunks_exact_mut(width.max(1)).take(rows).enumerate() {
            row[..columns].iter_mut().enumerate().for_each(|(c, x)| *x = t(r, c));
        }
        let mut values: Vec<f64> = basic.iter().map(|(_, value)| *value).collect();
        values.resize(height, 0.0);
        let mut dictionary = Self {
            height,
            width,
            base,
            left: vec![0.0; BLOCK * height],
            right: vec![0.0; BLOCK * width],
            pending: 0,
            values,
            column: vec![0.0; height],
            loaded: None,
            key: vec![0.0; height],
            ratios: vec![0.0; height],
            tied: Vec::with_capacity(rows),
            basic: basic.into_iter().map(|(var, _)| var).collect(),
            nonbasic,
            places: [vec![Place::Elsewhere; n], vec![Place::Elsewhere; n], vec![Place::Elsewhere]],
        };
        for r in 0..rows {
            *dictionary.place(dictionary.basic[r]) = Place::Row(r);
        }
        for c in 0..columns {
            *dictionary.place(dictionary.nonbasic[c]) = Place::Column(c);
        }
        dictionary
    }

    fn place(&mut self, var: Var) -> &mut Place {
        match var {
            Var::W(j) => &mut self.places[0][j],
            Var::Z(j) => &mut self.places[1][j],
            Var::Z0 => &mut self.places[2][0],
        }
    }

    /// Brings column `c` up to date. O(n) and O(n) for each pending pivot.
    fn load(&self, c: usize, column: &mut [f64]) {
        for (x, row) in column.iter_mut().zip(self.base.chunks_exact(self.width)) {
            *x = row[c];
        }
        let mut factors = [0.0; BLOCK];
        for (k, f) in factors[..self.pending].iter_mut().enumerate() {
            *f = self.right[k * self.width + c];
        }
        kernels::add_combination(column, &factors[..self.pending], &self.left);
    }

    /// As [`Dictionary::blocking_row`](super::Dictionary::blocking_row), whose tolerances it shares.
    fn lexicographic_minimum(
        &self,
        sign: f64,
        key: &mut [f64],
        ratios: &mut [f64],
        tied: &mut Vec<usize>,
    ) -> Option<usize> {
        let (column, values) = (&self.column, &self.values);
        let tol_pivot = PIVOT * kernels::largest(column);
        let scale = kernels::largest(values);
        let minimum = kernels::ratios(values, column, sign, tol_pivot, ratios);
        if minimum == f64::INFINITY {
            return None;
        }
        let tol = tie_tolerance::<f64>(self.basic.len()) * scale;
        tied.clear();
        for (r, &ratio) in ratios[..self.basic.len()].iter().enumerate() {
            if ratio < f64::INFINITY && values[r] - minimum * (sign * column[r]) <= tol {
                tied.push(r);
            }
        }
        if let Some(r) = tied.iter().copied().find(|&r| self.basic[r] == Var::Z0) {
            return Some(r);
        }
        self.break_tie(sign, key, tied)
    }

    /// Compares the tied rows of the basis inverse, component by component.
    fn break_tie(&self, sign: f64, key: &mut [f64], tied: &mut Vec<usize>) -> Option<usize> {
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
    fn keep_minima(&self, c: usize, sign: f64, key: &mut [f64], tied: &mut Vec<usize>) {
        let rate = |r: usize| sign * self.column[r];
        let (mut minimum, mut size) = (f64::INFINITY, 0.0_f64);
        for &r in &*tied {
            key[r] = -self.coefficient(r, c);
            minimum = minimum.min(key[r] / rate(r));
            size = size.max(key[r].abs());
        }
        let excess = |key: &[f64], r: usize| key[r] - minimum * rate(r);
        let tol = tie_tolerance::<f64>(self.basic.len());
        let (surely_tied, surely_not) = (tol * size, tol * LARGEST * size.max(1.0));
        let unclear = |r: usize| excess(key, r) > surely_tied && excess(key, r) <= surely_not;
        if !tied.iter().any(|&r| unclear(r)) {
            tied.retain(|&r| excess(key, r) <= surely_tied);
            return;
        }
        self.load(c, key);
        let tol = tol * kernels::largest(key);
        tied.retain(|&r| -key[r] - minimum * rate(r) <= tol);
    }

    /// One number up to date.
    fn coefficient(&self, r: usize, c: usize) -> f64 {
        let pending = (0..self.pending).map(|k| self.left[k * self.height + r] * self.right[k * self.width + c]);
        self.base[r * self.width + c] + pending.sum::<f64>()
    }

    fn scatter(&self, value: impl Fn(usize) -> f64) -> (Vec<f64>, f64) {
        let (mut z, mut z0) = (vec![0.0; self.places[1].len()], 0.0);
        for (r, var) in self.basic.iter().enumerate() {
            match var {
                Var::Z(i) => z[*i] = value(r),
                Var::Z0 => z0 = value(r),
                Var::W(_) => {}
            }
        }
        (z, z0)
    }

    /// `base += sum_k u_k v_k'`.
    fn update(&mut self) {
        let left = Window { numbers: &self.left, stride: self.height };
        let right = Window { numbers: &self.right, stride: self.width };
        add_products(&mut self.base, self.width, (self.basic.len(), self.width, self.pending), left, right);
        self.pending = 0;
    }
}

impl Tableau for DelayedDictionary {
    fn of(lcp: &Lcp, d: &[f64]) -> Self {
        let n = lcp.n();
        let basic = (0..n).map(|i| (Var::W(i), lcp.q()[i])).collect();
        let nonbasic = (0..n).map(Var::Z).chain([Var::Z0]).collect();
        let mut dictionary = Self::new(n, basic, nonbasic, |_, _| 0.0);
        for (i, row) in dictionary.base.chunks_exact_mut(dictionary.width).take(n).enumerate() {
            row[..n].copy_from_slice(lcp.row(i));
            row[n] = d[i];
        }
        dictionary
    }

    fn column_of(&self, var: Var) -> Option<usize> {
        let place = match var {
            Var::W(j) => self.places[0][j],
            Var::Z(j) => self.places[1][j],
            Var::Z0 => self.places[2][0],
        };
        if let Place::Column(c) = place { Some(c) } else { None }
    }

    fn blocking_row(&mut self, s: usize, entering: Entering) -> Option<usize> {
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

    fn exchange(&mut self, r: usize, s: usize) -> Var {
        if self.loaded != Some(s) {
            let mut column = std::mem::take(&mut self.column);
            self.load(s, &mut column);
            self.column = column;
        }
        self.loaded = None;
        if self.pending == BLOCK {
            self.update();
        }
        let (height, width, pending) = (self.height, self.width, self.pending);
        let inverse = 1.0 / self.column[r];

        let mut factors = [0.0; BLOCK];
        for (k, f) in factors[..pending].iter_mut().enumerate() {
            *f = std::mem::replace(&mut self.left[k * height + r], 0.0);
        }
        let (terms, row) = self.right.split_at_mut(pending * width);
        let row = &mut row[..width];
        let base = &mut self.base[r * width..(r + 1) * width];
        row.copy_from_slice(base);
        base.fill(0.0);
        kernels::add_combination(row, &factors[..pending], terms);
        row.iter_mut().for_each(|x| *x *= -inverse);
        row[s] = inverse;

        self.base.chunks_exact_mut(width).for_each(|row| row[s] = 0.0);
        (0..pending).for_each(|k| self.right[k * width + s] = 0.0);

        let value = -(self.values[r] * inverse);
        self.column[r] = 1.0;
        self.values[r] = 0.0;
        kernels::axpy(value, &self.column, &mut self.values);
        self.left[pending * height..][..height].copy_from_slice(&self.column);
        self.pending += 1;

        let (left, entered) = (self.basic[r], self.nonbasic[s]);
        self.basic[r] = entered;
        self.nonbasic[s] = left;
        *self.place(entered) = Place::Row(r);
        *self.place(left) = Place::Column(s);
        left
    }

    fn basic_z(&self) -> Vec<usize> {
        let is_basic = |place: &Place| matches!(place, Place::Row(_));
        (0..self.places[1].len()).filter(|&i| is_basic(&self.places[1][i])).collect()
    }

    fn point(&self) -> (Vec<f64>, f64) {
        self.scatter(|r| self.values[r])
    }

    fn direction(&self, s: usize) -> (Vec<f64>, f64) {
        let rate = |r: usize| self.coefficient(r, s);
        let largest = (0..self.basic.len()).map(|r| rate(r).abs()).fold(unit(self.nonbasic[s]), f64::max);
        let noise = tie_tolerance::<f64>(self.basic.len()) * largest;
        let (mut z_hat, mut z0_hat) = self.scatter(|r| if rate(r) > noise { rate(r) } else { 0.0 });
        match self.nonbasic[s] {
            Var::Z(i) => z_hat[i] = 1.0,
            Var::Z0 => z0_hat = 1.0,
            Var::W(_) => {}
        }
        (z_hat, z0_hat)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Dictionary;
    use super::*;

    /// The same pivots in both dictionaries, over several updates: the same values, columns and blocking rows.
    #[test]
    fn agrees_with_the_plain_dictionary() {
        for n in [1, 3, 8, 21, 40] {
            let entry =
                |k: usize| ((k * 7919 % 101) as f64) / 50.0 - 1.0 + if k.is_multiple_of(n + 1) { 4.0 } else { 0.0 };
            let a = (0..n * n).map(entry).collect();
            let q = (0..n).map(|i| ((i * 37 % 11) as f64) - 5.0).collect();
            let lcp = Lcp::new(n, a, q).expect("valid");
            let d: Vec<f64> = (0..n).map(|i| 1.0 + i as f64 / n as f64).collect();
            let mut plain = Dictionary::<f64>::new(&lcp, &d);
            let mut delayed = DelayedDictionary::of(&lcp, &d);
            for k in 0..2 * n {
                let s = (k * 5 + 1) % (n + 1);
                let entering = if k % 3 == 0 { Entering::Descending } else { Entering::Increasing };
                let (r, again) = (plain.blocking_row(s, entering), delayed.blocking_row(s, entering));
                assert_eq!(r, again, "{n} {k}");
                let Some(r) = r else { continue };
                assert_eq!(plain.exchange(r, s), delayed.exchange(r, s));
                let size = (0..n).map(|i| plain.value(i).abs()).fold(1.0, f64::max);
                for i in 0..n {
                    assert!((plain.value(i) - delayed.values[i]).abs() < 1e-8 * size, "{n} {k} {i}");
                }
            }
            assert_eq!(plain.basic_z(), delayed.basic_z());
        }
    }
}
