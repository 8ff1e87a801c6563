//! Equilibration by powers of two: `A' = D_r A D_c`, `q' = s D_r q`, `z = D_c z' / s`, `w = D_r^-1 w' / s`.
//!
//! Positive diagonals keep signs, supports and complementarity; powers of two keep every digit, so solutions,
//! rays and Farkas vectors of the scaled problem are those of the caller's. Only exponents are stored.

use crate::linalg::kernels;

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

/// Sizes whose products stay far from both ends of the range of doubles.
pub const ORDINARY: std::ops::Range<f64> = 1e-150..1e150;

/// Whether each is zero or in [`ORDINARY`], whatever its sign.
#[must_use]
pub fn are_ordinary(x: &[f64]) -> bool {
    kernels::all_zero_or_within(x, ORDINARY.start, ORDINARY.end)
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
#[must_use]
pub fn power_of_two(e: i32) -> f64 {
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
pub const ZERO: i32 = -1_000_000;

/// Sweeps of Ruiz's iteration at most; each halves every row's and column's distance from 1 in exponent.
const SWEEPS: usize = 12;

impl Scaling {
    /// Ruiz equilibration in the max norm, rounded to powers of two. [Rui01]  `sweep` is given the exponents of rows and columns and
    /// returns the largest exponent of each row and of each column of `D_r A D_c`, [`ZERO`] where all entries are 0.
    ///
    /// Rows and columns are updated together, so a symmetric matrix gets `D_r = D_c` and stays symmetric.
    #[must_use]
    pub fn ruiz(q: &[f64], mut sweep: impl FnMut(&[i32], &[i32], &mut [i32], &mut [i32])) -> Self {
        let n = q.len();
        let (mut rows, mut columns) = (vec![0; n], vec![0; n]);
        let (mut row_max, mut column_max) = (vec![ZERO; n], vec![ZERO; n]);
        for _ in 0..SWEEPS {
            row_max.fill(ZERO);
            column_max.fill(ZERO);
            sweep(&rows, &columns, &mut row_max, &mut column_max);
            let mut changed = false;
            for i in 0..n {
                changed |= halve(&mut rows[i], row_max[i]);
                changed |= halve(&mut columns[i], column_max[i]);
            }
            if !changed {
                break;
            }
        }
        Self::of_exponents(rows, columns, q)
    }

    /// These rows and columns, and the factor that brings `max|q'|` into [1/2, 1).
    #[must_use]
    pub fn of_exponents(rows: Vec<i32>, columns: Vec<i32>, q: &[f64]) -> Self {
        let q = exponent_of_q(q, &rows);
        Self { rows, columns, q }
    }

    /// The same but for another q.
    #[must_use]
    pub fn for_q(self, q: &[f64]) -> Self {
        Self::of_exponents(self.rows, self.columns, q)
    }

    /// Whether every factor, and every product of one of `D_r` and one of `D_c`, is a normal number.
    #[must_use]
    pub fn is_moderate(&self) -> bool {
        self.rows.iter().chain(&self.columns).all(|e| e.abs() <= MODERATE)
    }

    /// The scaling `D A D` nearest to `D_r A D_c`: congruent to A, so that PSD stays PSD.
    #[must_use]
    pub fn congruent(&self, q: &[f64]) -> Self {
        let rows: Vec<i32> = self.rows.iter().zip(&self.columns).map(|(r, c)| (r + c).div_euclid(2)).collect();
        Self::of_exponents(rows.clone(), rows, q)
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

/// Moves `exponent` half the way that brings the largest entry, `2^largest`, to 1; `false` when it is there.
fn halve(exponent: &mut i32, largest: i32) -> bool {
    let current = largest + *exponent;
    if largest < ZERO / 2 || (-1..=1).contains(&current) {
        return false;
    }
    *exponent -= current / 2;
    true
}

/// Two exponents up to this size have a sum in the normal range.
const MODERATE: i32 = 500;

#[cfg(test)]
mod tests {
    use super::*;

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
