//! Equilibration by powers of two: `A' = D_r A D_c`, `q' = s D_r q`, `z = D_c z' / s`, `w = D_r^-1 w' / s`.
//!
//! Positive diagonals keep signs, supports and complementarity; powers of two keep every digit, so solutions,
//! rays and Farkas vectors of the scaled problem are those of the caller's. Only exponents are stored.

use crate::linalg::kernels;
use crate::problem::Lcp;
use crate::sparse::SparseLcp;

/// Binary exponents of the diagonals `D_r`, `D_c` and of the factor `s`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scaling {
    /// `D_r = diag(2^rows)`.
    pub rows: Vec<i32>,
    /// `D_c = diag(2^columns)`.
    pub columns: Vec<i32>,
    /// `s = 2^q`.
    pub q: i32,
}

/// A problem beside its equilibrated copy.
#[derive(Clone, Debug)]
pub struct Equilibrated<'a> {
    /// The caller's problem.
    pub original: &'a Lcp,
    /// The equilibrated problem: every nonzero row and column of A has its largest entry in [1/4, 2), `max|q| < 1`.
    pub lcp: Lcp,
    /// How the one became the other.
    pub scaling: Scaling,
    /// Whether every number of both is in [`ORDINARY`], or zero in both: then no product or sum of a few overflows or loses
    /// digits.
    pub is_ordinary: bool,
}

/// Sizes whose products stay far from both ends of the range of doubles.
pub const ORDINARY: std::ops::Range<f64> = 1e-150..1e150;

/// Whether each is zero or in [`ORDINARY`], whatever its sign.
#[must_use]
pub fn are_ordinary(x: &[f64]) -> bool {
    kernels::all_zero_or_within(x, ORDINARY.start, ORDINARY.end)
}

/// Whether a number became zero by underflow.
fn vanishes(original: &[f64], scaled: &[f64]) -> bool {
    original.iter().zip(scaled).fold(false, |found, (&x, &y)| found | ((x != 0.0) & (y == 0.0)))
}

/// `x 2^e`, exact unless the result leaves the range of doubles.
#[must_use]
pub fn times_power_of_two(x: f64, e: i32) -> f64 {
    if (-1021..=1023).contains(&e) {
        return x * power_of_two(e);
    }
    // Two or three exact steps; the last one alone may round (underflow) or overflow.
    let step = e.clamp(-1021, 1023);
    times_power_of_two(x * power_of_two(step), (e - step).clamp(-2200, 2200))
}

/// `2^e` for a normal exponent.
fn power_of_two(e: i32) -> f64 {
    f64::from_bits(u64::from((e + 1023).unsigned_abs()) << 52)
}

/// The exponent `e` with `2^(e-1) <= |x| < 2^e`; `ZERO` for zero.
#[must_use]
pub fn exponent(x: f64) -> i32 {
    let biased = ((x.to_bits() >> 52) & 0x7ff) as i32;
    match biased {
        0 if x == 0.0 => ZERO,
        0 => exponent(x * power_of_two(64)) - 64, // subnormal
        _ => biased - 1022,
    }
}

/// The exponent given to zero: smaller than any real one, whatever is added to it.
const ZERO: i32 = -1_000_000;

/// Sweeps of Ruiz's iteration at most; each halves every row's and column's distance from 1 in exponent.
const SWEEPS: usize = 12;

impl Scaling {
    /// Ruiz equilibration in the max norm, rounded to powers of two. [Rui01]  O(n^2).
    ///
    /// Rows and columns are updated together, so a symmetric matrix gets `D_r = D_c` and stays symmetric.
    #[must_use]
    pub fn new(lcp: &Lcp) -> Self {
        let n = lcp.n();
        let (rows, columns) = if is_equilibrated(lcp) { (vec![0; n], vec![0; n]) } else { Self::sweeps(lcp) };
        let q = exponent_of_q(lcp.q(), &rows);
        Self { rows, columns, q }
    }

    /// The congruent scaling `D A D` of a sparse matrix. O(nnz).
    #[must_use]
    pub fn of_sparse(lcp: &SparseLcp) -> Self {
        let n = lcp.n();
        let mut d = vec![0; n];
        let mut largest = vec![ZERO; n];
        for _ in 0..SWEEPS {
            largest.fill(ZERO);
            for i in 0..n {
                for (&j, &a) in lcp.row(i).0.iter().zip(lcp.row(i).1) {
                    let e = exponent(a);
                    largest[i] = largest[i].max(e + d[j]);
                    largest[j] = largest[j].max(e + d[i]);
                }
            }
            let mut changed = false;
            for (d, &m) in d.iter_mut().zip(&largest) {
                changed |= halve(d, m);
            }
            if !changed {
                break;
            }
        }
        Self { q: exponent_of_q(lcp.q(), &d), columns: d.clone(), rows: d }
    }

    /// The exponents of `D_r` and `D_c`.
    fn sweeps(lcp: &Lcp) -> (Vec<i32>, Vec<i32>) {
        let n = lcp.n();
        let (mut rows, mut columns) = (vec![0; n], vec![0; n]);
        let (mut row_max, mut column_max) = (vec![ZERO; n], vec![ZERO; n]);
        for _ in 0..SWEEPS {
            column_max.fill(ZERO);
            for i in 0..n {
                let (row, r) = (lcp.row(i), rows[i]);
                row_max[i] = kernels::max_exponents(row, ZERO, &columns, r, &mut column_max).unwrap_or_else(|| {
                    row.iter().zip(&mut column_max).for_each(|(&x, m)| *m = (*m).max(exponent(x) + r));
                    row.iter().zip(&columns).map(|(&x, c)| exponent(x) + c).max().unwrap_or(ZERO)
                });
            }
            let mut changed = false;
            for i in 0..n {
                changed |= halve(&mut rows[i], row_max[i]);
                changed |= halve(&mut columns[i], column_max[i]);
            }
            if !changed {
                break;
            }
        }
        (rows, columns)
    }

    /// Whether every factor, and every product of one of `D_r` and one of `D_c`, is a normal number.
    #[must_use]
    pub fn is_moderate(&self) -> bool {
        self.rows.iter().chain(&self.columns).all(|e| e.abs() <= MODERATE)
    }

    /// The scaling `D A D` nearest to `D_r A D_c`: congruent to A, so that PSD stays PSD.
    #[must_use]
    pub fn congruent(&self, lcp: &Lcp) -> Self {
        let rows: Vec<i32> = self.rows.iter().zip(&self.columns).map(|(r, c)| (r + c).div_euclid(2)).collect();
        Self { q: exponent_of_q(lcp.q(), &rows), columns: rows.clone(), rows }
    }

    /// The largest factor by which a residual can grow on the way from this scaling to `other`.
    #[must_use]
    pub fn distance(&self, other: &Self) -> f64 {
        let rows = self.rows.iter().zip(&other.rows).map(|(a, b)| b - a + other.q - self.q);
        let columns = self.columns.iter().zip(&other.columns).map(|(a, b)| a - b + other.q - self.q);
        times_power_of_two(1.0, rows.chain(columns).max().unwrap_or(0))
    }

    /// `z` of the caller from `z'` of the equilibrated problem.
    #[must_use]
    pub fn z_to_caller(&self, z: &[f64]) -> Vec<f64> {
        z.iter().zip(&self.columns).map(|(&z, c)| times_power_of_two(z, c - self.q)).collect()
    }

    /// `z'` of the equilibrated problem from the caller's `z`.
    #[must_use]
    pub fn z_from_caller(&self, z: &[f64]) -> Vec<f64> {
        z.iter().zip(&self.columns).map(|(&z, c)| times_power_of_two(z, self.q - c)).collect()
    }

    /// `w` of the caller from `w'` of the equilibrated problem.
    #[must_use]
    pub fn w_to_caller(&self, w: &[f64]) -> Vec<f64> {
        w.iter().zip(&self.rows).map(|(&w, r)| times_power_of_two(w, -r - self.q)).collect()
    }

    /// A vector in w-space (a slack, a covering vector) from the caller's: `d' = s D_r d`.
    #[must_use]
    pub fn w_from_caller(&self, w: &[f64]) -> Vec<f64> {
        w.iter().zip(&self.rows).map(|(&w, r)| times_power_of_two(w, r + self.q)).collect()
    }

    /// A direction in z-space (a ray): as `z`, without the factor `s` that belongs to q.
    #[must_use]
    pub fn direction_to_caller(&self, z: &[f64]) -> Vec<f64> {
        z.iter().zip(&self.columns).map(|(&z, &c)| times_power_of_two(z, c)).collect()
    }

    /// A multiplier of the rows (a Farkas vector): `A'y' <= 0` gives `A' (D_r y') <= 0`.
    #[must_use]
    pub fn multiplier_to_caller(&self, y: &[f64]) -> Vec<f64> {
        y.iter().zip(&self.rows).map(|(&y, &r)| times_power_of_two(y, r)).collect()
    }

    /// The inverse of [`multiplier_to_caller`](Self::multiplier_to_caller).
    #[must_use]
    pub fn multiplier_from_caller(&self, y: &[f64]) -> Vec<f64> {
        y.iter().zip(&self.rows).map(|(&y, &r)| times_power_of_two(y, -r)).collect()
    }
}

/// The `e` with `max|2^e D_r q|` in [1/2, 1).
fn exponent_of_q(q: &[f64], rows: &[i32]) -> i32 {
    let largest = q.iter().zip(rows).map(|(&x, r)| exponent(x) + r).max().unwrap_or(ZERO);
    if largest < ZERO / 2 { 0 } else { -largest }
}

/// Whether every row and column has its largest entry in [1/4, 2) already: one pass, no exponents.
fn is_equilibrated(lcp: &Lcp) -> bool {
    let n = lcp.n();
    let mut columns = vec![0.0; n];
    let near_one = |m: f64| (0.25..2.0).contains(&m);
    for i in 0..n {
        if !near_one(kernels::max_into(lcp.row(i), &mut columns)) {
            return false;
        }
    }
    columns.into_iter().all(near_one)
}

/// Moves `exponent` half the way that brings the largest entry, `2^largest`, to 1; `false` when it is there.
fn halve(exponent: &mut i32, largest: i32) -> bool {
    let current = largest + *exponent;
    if largest < ZERO / 2 || (-1..=1).contains(&current) {
        return false;
    }
    *exponent -= current / 2;
    true
}

/// `D_r A D_c`.
fn scaled_matrix(lcp: &Lcp, scaling: &Scaling) -> Vec<f64> {
    let n = lcp.n();
    if scaling.is_moderate() {
        let mut a = vec![0.0; n * n];
        let factors: Vec<f64> = scaling.columns.iter().map(|&c| power_of_two(c)).collect();
        for (i, out) in a.chunks_exact_mut(n).enumerate() {
            kernels::scale_row(lcp.row(i), power_of_two(scaling.rows[i]), &factors, out);
        }
        return a;
    }
    let mut a = Vec::with_capacity(n * n);
    for (i, r) in scaling.rows.iter().enumerate() {
        a.extend(lcp.row(i).iter().zip(&scaling.columns).map(|(&x, c)| times_power_of_two(x, r + c)));
    }
    a
}

/// Two exponents up to this size have a sum in the normal range.
const MODERATE: i32 = 500;

impl<'a> Equilibrated<'a> {
    /// Equilibrates `original`. O(n^2).
    #[must_use]
    pub fn new(original: &'a Lcp) -> Self {
        Self::with(original, Scaling::new(original))
    }

    /// Scales `original` as told. O(n^2).
    #[must_use]
    pub fn with(original: &'a Lcp, scaling: Scaling) -> Self {
        let q: Vec<f64> =
            original.q().iter().zip(&scaling.rows).map(|(&x, r)| times_power_of_two(x, r + scaling.q)).collect();
        let mut is_ordinary =
            [original.a(), original.q(), &q].into_iter().all(are_ordinary) && !vanishes(original.q(), &q);
        let lcp = if scaling.rows.iter().chain(&scaling.columns).all(|&e| e == 0) {
            original.with_q(q)
        } else {
            let a = scaled_matrix(original, &scaling);
            is_ordinary &= are_ordinary(&a) && !vanishes(original.a(), &a);
            Lcp::trusted(original.n(), a, q)
        };
        Self { original, lcp, scaling, is_ordinary }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn largest(x: &[f64]) -> f64 {
        x.iter().fold(0.0, |m, x| m.max(x.abs()))
    }

    #[test]
    fn rows_and_columns_reach_one_within_a_factor_of_four() {
        let a = vec![1e-10, 3e-300, 5.0, 1e8, 0.0, 2e200, 7e-9, 1.0, 0.0];
        let lcp = Lcp::new(3, a, vec![1e300, -5e-324, 0.0]).expect("finite");
        let e = Equilibrated::new(&lcp);
        for i in 0..3 {
            let column: Vec<f64> = (0..3).map(|k| e.lcp.row(k)[i]).collect();
            for m in [largest(e.lcp.row(i)), largest(&column)] {
                assert!((0.25..2.0).contains(&m), "{m}");
            }
        }
        assert!((0.5..1.0).contains(&largest(e.lcp.q())));
    }

    #[test]
    fn symmetric_stays_symmetric_and_z_round_trips() {
        let a = vec![4.0, 1e5, 0.0, 1e5, 1e12, 3.0, 0.0, 3.0, 1e-6];
        let lcp = Lcp::new(3, a, vec![-1.0, 2.0, 1e-3]).expect("finite");
        let e = Equilibrated::new(&lcp);
        assert_eq!(e.scaling.rows, e.scaling.columns);
        let z = vec![1.5, -3e-5, 1e9];
        assert_eq!(e.scaling.z_to_caller(&e.scaling.z_from_caller(&z)), z);
    }

    #[test]
    fn powers_of_two_beyond_the_normal_range() {
        assert_eq!(times_power_of_two(1.5, -1074), 1e-323);
        assert_eq!(times_power_of_two(5e-324, 1074), 1.0);
        assert_eq!(times_power_of_two(5e-324, 2000), 2f64.powi(926));
        assert_eq!(times_power_of_two(1.0, -3000), 0.0);
        assert_eq!(times_power_of_two(1.0, 3000), f64::INFINITY);
        assert_eq!((exponent(1.0), exponent(0.75), exponent(-2.0), exponent(5e-324)), (1, 0, 2, -1073));
    }
}
