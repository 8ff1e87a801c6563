//! The condensed dictionary of a complementary pivoting method: a pivot costs its column and its row, and the rest is brought
//! up to date once in several pivots, by one product of matrices at the speed of the processor instead of that of the memory.
//!
//! Between updates the dictionary is `base + sum_k u_k v_k'`. The exchange of row r and column s with pivot t clears that
//! row and that column, in the base and in what is pending, and adds one term: `v = -T_r. / t` with `v_s = 1/t`, the new
//! row; `u = T_.s` with `u_r = 1`.

mod ratio;
mod restart;

use super::Var;
use super::real::Real;
use crate::linalg::kernels::LANES;
use crate::linalg::update::Window;
use crate::problem::Lcp;
pub use ratio::Entering;

/// `x_B = q_bar + T x_N` for any number of basic and nonbasic variables.
///
/// The columns of the basis inverse, which the lexicographic order needs, are there already: `B^-1 e_j` is `-T` in the
/// column of a nonbasic `w_j`, and a unit vector while `w_j` is basic.
#[derive(Clone, Debug)]
pub struct Dictionary<T> {
    /// Pivots between two updates of the base.
    delay: usize,
    /// Numbers in a column, padded; pending columns begin at multiples of it.
    height: usize,
    /// Numbers in a row, padded.
    width: usize,
    base: Vec<T>,
    /// `u_k`, one after the other.
    left: Vec<T>,
    /// `v_k`, one after the other.
    right: Vec<T>,
    pending: usize,
    /// `q_bar`, always up to date.
    values: Vec<T>,
    /// The column last asked for, up to date.
    column: Vec<T>,
    loaded: Option<usize>,
    /// Scratch: the key of a tie.
    key: Vec<T>,
    /// Scratch: the ratios of the rows that decrease, infinity elsewhere.
    ratios: Vec<T>,
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

impl<T: Real> Dictionary<T> {
    /// `w = q + A z + d z_0`, updated at every pivot: for methods that look at many coefficients. O(n^2).
    #[must_use]
    pub fn new(lcp: &Lcp, d: &[f64]) -> Self {
        Self::of(lcp, d, 1)
    }

    /// `w = q + A z + d z_0`, for a path, which looks at one column a pivot. O(n^2).
    #[must_use]
    pub fn delayed(lcp: &Lcp, d: &[f64]) -> Self {
        Self::of(lcp, d, T::DELAY)
    }

    fn of(lcp: &Lcp, d: &[f64], delay: usize) -> Self {
        let n = lcp.n();
        let basic = (0..n).map(|i| (Var::W(i), lcp.q()[i])).collect();
        let nonbasic = (0..n).map(Var::Z).chain([Var::Z0]).collect();
        let mut dictionary = Self::empty(n, basic, nonbasic, delay);
        for (i, row) in dictionary.base.chunks_exact_mut(dictionary.width).take(n).enumerate() {
            row.iter_mut().zip(lcp.row(i).iter().chain([&d[i]])).for_each(|(x, &a)| *x = T::from(a));
        }
        dictionary
    }

    /// Basic variables with their values, nonbasic ones, and the coefficients by rows, for a path; `n` bounds the indices.
    #[must_use]
    pub fn with_rows(n: usize, basic: Vec<(Var, f64)>, nonbasic: Vec<Var>, t: impl Fn(usize, usize) -> f64) -> Self {
        let columns = nonbasic.len();
        let mut dictionary = Self::empty(n, basic, nonbasic, T::DELAY);
        let rows = dictionary.base.chunks_exact_mut(dictionary.width.max(1)).take(dictionary.basic.len());
        for (r, row) in rows.enumerate() {
            row[..columns].iter_mut().enumerate().for_each(|(c, x)| *x = T::from(t(r, c)));
        }
        dictionary
    }

    fn empty(n: usize, basic: Vec<(Var, f64)>, nonbasic: Vec<Var>, delay: usize) -> Self {
        const { assert!(T::DELAY <= MOST) };
        let (rows, zero) = (basic.len(), T::from(0.0));
        let (height, width) = (rows.next_multiple_of(LANES), nonbasic.len().next_multiple_of(LANES));
        let mut values: Vec<T> = basic.iter().map(|&(_, value)| T::from(value)).collect();
        values.resize(height, zero);
        let mut dictionary = Self {
            delay,
            height,
            width,
            base: vec![zero; height * width],
            left: vec![zero; delay * height],
            right: vec![zero; delay * width],
            pending: 0,
            values,
            column: vec![zero; height],
            loaded: None,
            key: vec![zero; height],
            ratios: vec![zero; height],
            tied: Vec::with_capacity(rows),
            basic: basic.into_iter().map(|(var, _)| var).collect(),
            nonbasic,
            places: [vec![Place::Elsewhere; n], vec![Place::Elsewhere; n], vec![Place::Elsewhere]],
        };
        for r in 0..rows {
            *dictionary.place(dictionary.basic[r]) = Place::Row(r);
        }
        for c in 0..dictionary.nonbasic.len() {
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

    /// The basic variable of row `r`.
    #[must_use]
    pub fn basic(&self, r: usize) -> Var {
        self.basic[r]
    }

    /// The value of the basic variable of row `r`.
    #[must_use]
    pub fn value(&self, r: usize) -> T {
        self.values[r]
    }

    /// The coefficient of nonbasic column `c` in row `r`. O(1), and O(1) for each pending pivot.
    #[must_use]
    pub fn coefficient(&self, r: usize, c: usize) -> T {
        let pending = (0..self.pending).map(|k| self.left[k * self.height + r] * self.right[k * self.width + c]);
        let base = self.base[r * self.width + c];
        pending.reduce(|sum, term| sum + term).map_or(base, |sum| base + sum)
    }

    /// The column of a nonbasic variable.
    #[must_use]
    pub fn column_of(&self, var: Var) -> Option<usize> {
        let place = match var {
            Var::W(j) => self.places[0][j],
            Var::Z(j) => self.places[1][j],
            Var::Z0 => self.places[2][0],
        };
        if let Place::Column(c) = place { Some(c) } else { None }
    }

    /// The nonbasic variable of column `c`.
    #[must_use]
    pub fn nonbasic(&self, c: usize) -> Var {
        self.nonbasic[c]
    }

    /// `w` of the basic solution.
    #[must_use]
    pub fn slacks(&self) -> Vec<f64> {
        let value = |place: &Place| if let Place::Row(r) = *place { self.values[r].to_f64() } else { 0.0 };
        self.places[0].iter().map(value).collect()
    }

    /// The derivative of `sum cost(x) x` along each column. O(n^2) less the rows without cost.
    pub fn reduced_costs(&self, cost: impl Fn(Var) -> f64, reduced: &mut [f64]) {
        debug_assert!(self.pending == 0, "invariant: updated at every pivot");
        for (reduced, &var) in reduced.iter_mut().zip(&self.nonbasic) {
            *reduced = cost(var);
        }
        for (row, &var) in self.base.chunks_exact(self.width).zip(&self.basic) {
            let c = cost(var);
            if c != 0.0 {
                reduced.iter_mut().zip(row).for_each(|(reduced, t)| *reduced += c * t.to_f64());
            }
        }
    }

    /// Indices `i` with `z_i` basic, increasing.
    #[must_use]
    pub fn basic_z(&self) -> Vec<usize> {
        let is_basic = |place: &Place| matches!(place, Place::Row(_));
        (0..self.places[1].len()).filter(|&i| is_basic(&self.places[1][i])).collect()
    }

    /// `(z, z_0)` of the basic solution.
    #[must_use]
    pub fn point(&self) -> (Vec<f64>, f64) {
        self.scatter(|r| self.values[r].to_f64())
    }

    /// `(z, z_0)` of the direction in which column `s` increases; what is rounding error beside the column is zero.
    #[must_use]
    pub fn direction(&self, s: usize) -> (Vec<f64>, f64) {
        let rate = |r: usize| self.coefficient(r, s).to_f64();
        // The driving variable's own entry in (z, z_0).
        let own = if let Var::W(_) = self.nonbasic[s] { 0.0 } else { 1.0 };
        let largest = (0..self.basic.len()).map(|r| rate(r).abs()).fold(own, f64::max);
        let noise = tie_tolerance::<T>(self.basic.len()) * largest;
        let (mut z_hat, mut z0_hat) = self.scatter(|r| if rate(r) > noise { rate(r) } else { 0.0 });
        match self.nonbasic[s] {
            Var::Z(i) => z_hat[i] = 1.0,
            Var::Z0 => z0_hat = 1.0,
            Var::W(_) => {}
        }
        (z_hat, z0_hat)
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

    /// Brings column `c` up to date. O(n) and O(n) for each pending pivot.
    fn load(&self, c: usize, column: &mut [T]) {
        for (x, row) in column.iter_mut().zip(self.base.chunks_exact(self.width)) {
            *x = row[c];
        }
        if self.pending > 0 {
            let mut factors = [T::from(0.0); MOST];
            for (k, f) in factors[..self.pending].iter_mut().enumerate() {
                *f = self.right[k * self.width + c];
            }
            T::add_combination(column, &factors[..self.pending], &self.left);
        }
    }

    /// Exchanges the basic variable of row `r` with the nonbasic variable of column `s`; returns the one that left.
    /// O(n) for each pending pivot, and O(n^2) for each of those together at an update; no allocation.
    pub fn exchange(&mut self, r: usize, s: usize) -> Var {
        if self.loaded != Some(s) {
            let mut column = std::mem::take(&mut self.column);
            self.load(s, &mut column);
            self.column = column;
        }
        self.loaded = None;
        let (height, width, pending, zero) = (self.height, self.width, self.pending, T::from(0.0));
        let inverse = T::from(1.0) / self.column[r];

        let mut factors = [zero; MOST];
        for (k, f) in factors[..pending].iter_mut().enumerate() {
            *f = std::mem::replace(&mut self.left[k * height + r], zero);
        }
        let (terms, row) = self.right.split_at_mut(pending * width);
        let row = &mut row[..width];
        let base = &mut self.base[r * width..(r + 1) * width];
        row.copy_from_slice(base);
        base.fill(zero);
        T::add_combination(row, &factors[..pending], terms);
        row.iter_mut().for_each(|x| *x = -(*x * inverse));
        row[s] = inverse;

        self.base.chunks_exact_mut(width).for_each(|row| row[s] = zero);
        (0..pending).for_each(|k| self.right[k * width + s] = zero);

        let value = -(self.values[r] * inverse);
        self.column[r] = T::from(1.0);
        self.values[r] = zero;
        self.values.iter_mut().zip(&self.column).for_each(|(x, c)| *x = *x + value * *c);
        self.left[pending * height..][..height].copy_from_slice(&self.column);
        self.pending += 1;
        if self.pending == self.delay {
            self.update();
        }

        let (left, entered) = (self.basic[r], self.nonbasic[s]);
        self.basic[r] = entered;
        self.nonbasic[s] = left;
        *self.place(entered) = Place::Row(r);
        *self.place(left) = Place::Column(s);
        left
    }

    /// `base += sum_k u_k v_k'`.
    fn update(&mut self) {
        let left = Window { numbers: &self.left, stride: self.height };
        let right = Window { numbers: &self.right, stride: self.width };
        T::add_products(&mut self.base, self.width, (self.basic.len(), self.width, self.pending), left, right);
        self.pending = 0;
    }
}

/// Most pivots between two updates.
const MOST: usize = 16;

/// Numbers `x_r` tie when they differ by less than `64 sqrt(n) EPS max|x|`: what n pivots leave of equality.
fn tie_tolerance<T: Real>(n: usize) -> f64 {
    64.0 * (n as f64).sqrt() * T::EPSILON
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same pivots, updated one by one and together: the same values, columns and blocking rows.
    #[test]
    fn delayed_updates_change_nothing() {
        for n in [1, 3, 8, 21, 40] {
            let entry =
                |k: usize| ((k * 7919 % 101) as f64) / 50.0 - 1.0 + if k.is_multiple_of(n + 1) { 4.0 } else { 0.0 };
            let a = (0..n * n).map(entry).collect();
            let q = (0..n).map(|i| ((i * 37 % 11) as f64) - 5.0).collect();
            let lcp = Lcp::new(n, a, q).expect("valid");
            let d: Vec<f64> = (0..n).map(|i| 1.0 + i as f64 / n as f64).collect();
            let mut plain = Dictionary::<f64>::new(&lcp, &d);
            let mut delayed = Dictionary::<f64>::delayed(&lcp, &d);
            for k in 0..2 * n {
                let s = (k * 5 + 1) % (n + 1);
                let entering = if k % 3 == 0 { Entering::Descending } else { Entering::Increasing };
                let (r, again) = (plain.blocking_row(s, entering), delayed.blocking_row(s, entering));
                assert_eq!(r, again, "{n} {k}");
                let Some(r) = r else { continue };
                assert_eq!(plain.exchange(r, s), delayed.exchange(r, s));
                let size = (0..n).map(|i| plain.value(i).abs()).fold(1.0, f64::max);
                for i in 0..n {
                    assert!((plain.value(i) - delayed.value(i)).abs() < 1e-8 * size, "{n} {k} {i}");
                    let (x, y) = (plain.coefficient(i, s), delayed.coefficient(i, s));
                    assert!((x - y).abs() < 1e-8 * x.abs().max(1.0), "{n} {k} {i}");
                }
            }
            assert_eq!(plain.basic_z(), delayed.basic_z());
        }
    }
}
