//! How far `z` is from solving LCP(q, A), and the rule by which a point is called a solution.

use crate::linalg::compensated::affine_compensated;
use crate::linalg::kernels::max_abs;
use crate::problem::Lcp;

/// `w = A z + q` (Dot2 of [ORO05]) and its rounding scale `|A||z| + |q|`, row by row. O(n^2).
#[must_use]
pub fn slack(lcp: &Lcp, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
    affine_compensated(lcp.q(), lcp.a(), z)
}

/// What a computed `w_i` may be off by beyond its own rounding, for a row of n terms of sum `m`. [ORO05]
#[must_use]
pub fn slack_error(n: usize, m: f64) -> f64 {
    (n as f64 * f64::EPSILON).powi(2) * m
}

/// The natural residual `max_i |min(z_i, w_i)|`; NaN if any entry is. [CPS92, sec. 5.10]
#[must_use]
pub fn natural_residual(z: &[f64], w: &[f64]) -> f64 {
    z.iter().zip(w).map(|(&z, &w)| minimum(z, w).abs()).fold(0.0, maximum)
}

/// The scale-free residual of the contract, for a point of the *equilibrated* problem:
/// `max_i |min(z'_i, w'_i)| / max(1, max|z'|)`.
#[must_use]
pub fn equilibrated_residual(z: &[f64], w: &[f64]) -> f64 {
    natural_residual(z, w) / max_abs(z).max(1.0)
}

/// How far `w_i` is from what `z_i` asks for: zero where `z_i > 0`, nonnegative elsewhere.
///
/// Divided by `m_i = (|A||z| + |q|)_i` it does not depend on the units of any row or column, and its largest quotient is the
/// least omega such that z solves exactly some LCP(q + e, A + E) with `|E| <= omega |A|`, `|e| <= omega |q|` entry by entry:
/// w_i is a sum of terms each of which may change by that part of itself. [Hig02, sec. 7.2]
#[must_use]
pub fn off_by(z: f64, w: f64) -> f64 {
    if z > 0.0 || w.is_nan() { w.abs() } else { (-w).max(0.0) }
}

/// On the equilibrated problem, where `max|q'| < 1`, `max|min(z', w')|` itself must be below `max(tol, ABSOLUTE)`: the other
/// tests allow rounding in proportion to z, and a z of 1e16 from a nearly singular block would pass them with any error.
/// Beyond 1e22 or so not even [`slack`] sees q: what it may be off by counts, too.
pub const ABSOLUTE: f64 = 1e-6;

/// One row of a point, in the units in which each test of the [`Rule`] is said.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// `z'_i` and `w'_i` of the equilibrated problem.
    pub equilibrated: [f64; 2],
    /// `z_i`, `w_i` and `m_i = (|A||z| + |q|)_i` on the caller's numbers, in the unit of the rule's `max|q|`.
    pub caller: [f64; 3],
    /// [`off_by`] as a part of `m_i`: the same in any units.
    pub part: f64,
    /// Whether an error of this row is the rounding of a tail: see [`tails`](crate::tails).
    pub is_tail: bool,
}

/// When a point `z >= 0` is called a solution. Each test has a point that it alone refuses (`every_test_counts`):
///
/// 1. `residual <= tol` on the equilibrated problem;
/// 2. `|min(z, w)|_i <= 10 tol max|q| + 8 eps m_i` in the caller's units: a wrong row that scaling would hide;
/// 3. `max|min(z', w')| <= max(tol, ABSOLUTE)`: a z so large that it hides q;
/// 4. the error of every row is at most the part `sqrt(tol)` of its own numbers, or it is a tail: a row that is wholly wrong,
///    however small its numbers.
#[derive(Clone, Debug)]
pub struct Rule {
    tol: f64,
    /// `10 tol max|q|`.
    allowed: f64,
    violation: f64,
    largest_z: f64,
    rows_hold: bool,
}

/// That a point passed the [`Rule`]; nothing else makes one.
#[derive(Clone, Copy, Debug)]
pub struct Passed(());

impl Rule {
    /// No row yet; `max_q` is the largest `|q_i|` of the caller, in the unit of [`Row::caller`].
    #[must_use]
    pub fn new(tol: f64, max_q: f64) -> Self {
        Self { tol, allowed: 10.0 * tol * max_q, violation: 0.0, largest_z: 1.0, rows_hold: true }
    }

    /// Takes a row into account. Not a number is never small.
    pub fn add(&mut self, row: Row) {
        let ([z, w], [caller_z, caller_w, m]) = (row.equilibrated, row.caller);
        self.violation = maximum(self.violation, minimum(z, w).abs());
        self.largest_z = self.largest_z.max(z);
        let in_units = minimum(caller_z, caller_w).abs() <= self.allowed + 8.0 * f64::EPSILON * m;
        self.rows_hold &= z >= 0.0 && in_units && (row.part <= self.tol.sqrt() || row.is_tail);
    }

    /// `max|min(z', w')| / max(1, max|z'|)`.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.violation / self.largest_z
    }

    /// The verdict on the rows, each `w'_i` off by `error` at most.
    #[must_use]
    pub fn passed(&self, error: f64) -> Option<Passed> {
        let is_small = self.violation + error <= self.tol.max(ABSOLUTE);
        (self.rows_hold && is_small && self.residual() <= self.tol).then_some(Passed(()))
    }
}

/// `min(a, b)` that keeps NaN.
fn minimum(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

/// `max(a, b)` that keeps NaN.
fn maximum(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_is_never_small() {
        assert!(natural_residual(&[1.0, f64::NAN], &[0.0, 1.0]).is_nan());
        assert!(natural_residual(&[f64::NAN, 1.0], &[1.0, 0.0]).is_nan());
        assert!(natural_residual(&[0.0, 1.0], &[f64::NAN, 0.0]).is_nan());
    }

    #[test]
    fn residual_counts_each_violation() {
        assert_eq!(natural_residual(&[1.0, 0.0], &[0.0, 2.0]), 0.0);
        assert_eq!(natural_residual(&[1.0, -3.0], &[0.5, 2.0]), 3.0);
        assert_eq!(natural_residual(&[1.0, 0.0], &[0.0, -2.0]), 2.0);
        assert_eq!(natural_residual(&[], &[]), 0.0);
    }

    #[test]
    fn every_test_counts() {
        let good = Row { equilibrated: [1.0, 1e-12], caller: [1.0, 1e-12, 2.0], part: 1e-12, is_tail: false };
        let passes = |max_q: f64, row: Row| {
            let mut rule = Rule::new(1e-9, max_q);
            rule.add(row);
            rule.passed(0.0).is_some()
        };
        assert!(passes(1.0, good));
        assert!(!passes(1.0, Row { equilibrated: [1.0, 1e-8], ..good }));
        let off = Row { caller: [1.0, 1e-6, 2.0], ..good };
        assert!(!passes(1.0, off) && passes(1e3, off));
        let huge = |w| Row { equilibrated: [1e6, w], ..good };
        assert!(!passes(1.0, huge(1e-5)) && passes(1.0, huge(1e-7)));
        let wrong = Row { part: 1e-3, ..good };
        assert!(!passes(1.0, wrong) && passes(1.0, Row { is_tail: true, ..wrong }));
    }
}
