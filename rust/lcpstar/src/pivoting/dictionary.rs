//! The condensed dictionary of a complementary pivoting method, and the one ratio test.

mod restart;

use super::Var;
use super::path::Tableau;
use super::real::Real;
use crate::linalg::kernels;
use crate::problem::Lcp;

/// `x_B = q_bar + T x_N`: row `r` holds `(q_bar_r | T_r0 .. T_rn)` and padding; n basic, n + 1 nonbasic variables.
///
/// It starts as `w = q + A z + d z_0`. The columns of the basis inverse, which the lexicographic order needs, are there
/// already: `B^-1 e_j` is `-T` in the column of a nonbasic `w_j`, and a unit vector while `w_j` is basic.
#[derive(Clone, Debug)]
pub struct Dictionary<T> {
    n: usize,
    width: usize,
    rows: Vec<T>,
    basic: Vec<Var>,
    nonbasic: Vec<Var>,
    /// Where `w_j` is.
    slack: Vec<Place>,
    /// Scratch: the new pivot row.
    pivot_row: Vec<T>,
    /// Scratch: rows that tie in the ratio test.
    tied: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    Row(usize),
    Column(usize),
}

/// How the driving variable moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entering {
    /// Up from zero: every pivot but the first.
    Increasing,
    /// Down from plus infinity: `z_0` in Lemke's first pivot, stopped by the last row to become negative.
    Descending,
}

impl<T: Real> Dictionary<T> {
    /// `w = q + A z + d z_0`. O(n^2); the only place that allocates.
    #[must_use]
    pub fn new(lcp: &Lcp, d: &[f64]) -> Self {
        let n = lcp.n();
        debug_assert!(d.len() == n);
        let width = (n + 2).next_multiple_of(kernels::LANES);
        let mut rows = Vec::with_capacity(n * width);
        for i in 0..n {
            rows.push(T::from(lcp.q()[i]));
            rows.extend(lcp.row(i).iter().map(|&a| T::from(a)));
            rows.push(T::from(d[i]));
            rows.resize((i + 1) * width, T::from(0.0));
        }
        Self {
            n,
            width,
            rows,
            basic: (0..n).map(Var::W).collect(),
            nonbasic: (0..n).map(Var::Z).chain([Var::Z0]).collect(),
            slack: (0..n).map(Place::Row).collect(),
            pivot_row: vec![T::from(0.0); width],
            tied: Vec::with_capacity(n),
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
        self.rows[r * self.width]
    }

    /// The coefficient of nonbasic column `s` in row `r`.
    #[must_use]
    pub fn coefficient(&self, r: usize, s: usize) -> T {
        self.rows[r * self.width + 1 + s]
    }

    /// The column of a nonbasic variable.
    #[must_use]
    pub fn column_of(&self, var: Var) -> Option<usize> {
        self.nonbasic.iter().position(|&v| v == var)
    }

    /// The nonbasic variable of column `s`.
    #[must_use]
    pub fn nonbasic(&self, s: usize) -> Var {
        self.nonbasic[s]
    }

    /// `w` of the basic solution.
    #[must_use]
    pub fn slacks(&self) -> Vec<f64> {
        let value = |place: &Place| match *place {
            Place::Row(r) => self.value(r).to_f64(),
            Place::Column(_) => 0.0,
        };
        self.slack.iter().map(value).collect()
    }

    /// The derivative of `sum cost(x) x` along each column. O(n^2) less the rows without cost.
    pub fn reduced_costs(&self, cost: impl Fn(Var) -> f64, reduced: &mut [f64]) {
        for (reduced, &var) in reduced.iter_mut().zip(&self.nonbasic) {
            *reduced = cost(var);
        }
        for (r, &var) in self.basic.iter().enumerate() {
            let c = cost(var);
            if c != 0.0 {
                let row = &self.rows[r * self.width + 1..][..=self.n];
                reduced.iter_mut().zip(row).for_each(|(reduced, t)| *reduced += c * t.to_f64());
            }
        }
    }

    /// Indices `i` with `z_i` basic, increasing.
    #[must_use]
    pub fn basic_z(&self) -> Vec<usize> {
        let mut alpha: Vec<usize> =
            self.basic.iter().filter_map(|v| if let Var::Z(i) = v { Some(*i) } else { None }).collect();
        alpha.sort_unstable();
        alpha
    }

    /// `(z, z_0)` of the basic solution.
    #[must_use]
    pub fn point(&self) -> (Vec<f64>, f64) {
        self.scatter(|r| self.value(r).to_f64())
    }

    /// `(z, z_0)` of the direction in which column `s` increases; what is rounding error beside the column is zero.
    #[must_use]
    pub fn direction(&self, s: usize) -> (Vec<f64>, f64) {
        let rate = |r: usize| self.coefficient(r, s).to_f64();
        let largest = (0..self.n).map(|r| rate(r).abs()).fold(unit(self.nonbasic[s]), f64::max);
        let noise = tie_tolerance::<T>(self.n) * largest;
        let (mut z_hat, mut z0_hat) = self.scatter(|r| if rate(r) > noise { rate(r) } else { 0.0 });
        match self.nonbasic[s] {
            Var::Z(i) => z_hat[i] = 1.0,
            Var::Z0 => z0_hat = 1.0,
            Var::W(_) => {}
        }
        (z_hat, z0_hat)
    }

    fn scatter(&self, value: impl Fn(usize) -> f64) -> (Vec<f64>, f64) {
        let (mut z, mut z0) = (vec![0.0; self.n], 0.0);
        for (r, var) in self.basic.iter().enumerate() {
            match var {
                Var::Z(i) => z[*i] = value(r),
                Var::Z0 => z0 = value(r),
                Var::W(_) => {}
            }
        }
        (z, z0)
    }

    /// The row that blocks column `s`: the lexicographic minimum of `(q_bar_r, (B^-1)_r) / -T_rs` over the rows that
    /// decrease; among rows that tie in the first component, the one holding `z_0` wins. `None`: a ray. [CPS92, 4.9]
    ///
    /// Rounding is kept out of both decisions: a coefficient below `tol_pivot = PIVOT max|T_s|` does not decrease, and
    /// numbers that agree to [`tie_tolerance`] tie. O(n), plus O(n) for each component needed to break a tie.
    pub fn blocking_row(&mut self, s: usize, entering: Entering) -> Option<usize> {
        let mut tied = std::mem::take(&mut self.tied);
        let blocking = self.lexicographic_minimum(s, entering, &mut tied);
        self.tied = tied;
        blocking
    }

    fn lexicographic_minimum(&self, s: usize, entering: Entering, tied: &mut Vec<usize>) -> Option<usize> {
        let sign = if entering == Entering::Increasing { -1.0 } else { 1.0 };
        let rate = |r: usize| self.coefficient(r, s) * T::from(sign);
        let mut largest = 0.0_f64;
        for r in 0..self.n {
            largest = largest.max(rate(r).to_f64().abs());
        }
        let tol_pivot = PIVOT * (T::EPSILON / f64::EPSILON) * largest;
        tied.clear();
        tied.extend((0..self.n).filter(|&r| rate(r).to_f64() > tol_pivot));
        self.keep_minima(tied, |r| self.value(r), rate);
        if let Some(r) = tied.iter().copied().find(|&r| self.basic[r] == Var::Z0) {
            return Some(r);
        }
        self.break_tie(tied, rate)
    }

    /// Compares the tied rows of the basis inverse, component by component.
    fn break_tie(&self, tied: &mut Vec<usize>, rate: impl Fn(usize) -> T + Copy) -> Option<usize> {
        for j in 0..self.n {
            if tied.len() <= 1 {
                break;
            }
            match self.slack[j] {
                Place::Column(c) => self.keep_minima(tied, |r| -self.coefficient(r, c), rate),
                // A unit vector: the row of w_j itself is the larger one.
                Place::Row(k) => tied.retain(|&r| r != k),
            }
        }
        tied.first().copied()
    }

    /// Keeps the rows whose `key / rate` is minimal, to rounding.
    fn keep_minima(&self, rows: &mut Vec<usize>, key: impl Fn(usize) -> T, rate: impl Fn(usize) -> T) {
        let ratios = rows.iter().map(|&r| key(r) / rate(r));
        let Some(minimum) = ratios.reduce(|m, ratio| if ratio < m { ratio } else { m }) else { return };
        // The noise of a column comes from its largest entries, whether or not they are candidates.
        let scale = (0..self.n).map(|r| key(r).to_f64().abs()).fold(0.0, f64::max);
        let tol = tie_tolerance::<T>(self.n) * scale;
        rows.retain(|&r| (key(r) - minimum * rate(r)).to_f64() <= tol);
    }

    /// Exchanges the basic variable of row `r` with the nonbasic variable of column `s`; returns the one that left.
    /// O(n^2), no allocation.
    pub fn exchange(&mut self, r: usize, s: usize) -> Var {
        let (width, c) = (self.width, s + 1);
        let mut pivot_row = std::mem::take(&mut self.pivot_row);
        let pivot = self.rows[r * width + c];
        let inverse = T::from(1.0) / pivot;
        for (new, &old) in pivot_row.iter_mut().zip(&self.rows[r * width..(r + 1) * width]) {
            *new = -(old * inverse);
        }
        pivot_row[c] = inverse;
        T::pivot(&mut self.rows, width, r, c, &pivot_row);
        self.pivot_row = pivot_row;
        let (left, entered) = (self.basic[r], self.nonbasic[s]);
        self.basic[r] = entered;
        self.nonbasic[s] = left;
        if let Var::W(j) = left {
            self.slack[j] = Place::Column(s);
        }
        if let Var::W(j) = entered {
            self.slack[j] = Place::Row(r);
        }
        left
    }
}

impl<T: Real> Tableau for Dictionary<T> {
    fn of(lcp: &Lcp, d: &[f64]) -> Self {
        Self::new(lcp, d)
    }

    fn column_of(&self, var: Var) -> Option<usize> {
        self.column_of(var)
    }

    fn blocking_row(&mut self, s: usize, entering: Entering) -> Option<usize> {
        self.blocking_row(s, entering)
    }

    fn exchange(&mut self, r: usize, s: usize) -> Var {
        self.exchange(r, s)
    }

    fn basic_z(&self) -> Vec<usize> {
        self.basic_z()
    }

    fn point(&self) -> (Vec<f64>, f64) {
        self.point()
    }

    fn direction(&self, s: usize) -> (Vec<f64>, f64) {
        self.direction(s)
    }
}

/// `tol_pivot = PIVOT max|column|`, in doubles; scaled by the ratio of the rounding errors in other arithmetic.
pub(super) const PIVOT: f64 = 1e-11;

/// The driving variable's own entry of a ray in (z, z_0): what is rounding error beside it is no entry.
pub(super) fn unit(driving: Var) -> f64 {
    match driving {
        Var::Z(_) | Var::Z0 => 1.0,
        Var::W(_) => 0.0,
    }
}

/// Numbers `x_r` tie when they differ by less than `64 sqrt(n) EPS max|x|`: what n pivots leave of equality.
pub(super) fn tie_tolerance<T: Real>(n: usize) -> f64 {
    64.0 * (n as f64).sqrt() * T::EPSILON
}
