//! How far `z` is from solving LCP(q, A): `w` in twice the working precision, and the natural residual.

use crate::linalg::compensated::affine_compensated;
use crate::linalg::kernels::max_abs;
use crate::problem::Lcp;
use crate::sparse::SparseLcp;

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

/// Whether a row of the equilibrated problem holds to its own numbers, with `m = (|A||z| + |q|)_i`: its error is a small
/// part of them, or at most `floor`. The part is `sqrt(tol)`, so that it tells a row that is wholly wrong, however small its
/// numbers, from one that is only as accurate as `tol` asks.
#[must_use]
pub fn holds_alone(z: f64, w: f64, m: f64, tol: f64, floor: f64) -> bool {
    let off = off_by(z, w);
    off <= tol.sqrt() * m || off <= floor
}

/// The floors of [`holds_alone`] in the rows of a sparse A: rounding beside the largest `|q'|` of the part of the problem that row i
/// belongs to. The solution of a discretised equation may decay to nothing, and no double holds its tail; rows that do not
/// hang together have no tail in each other.
#[derive(Clone, Debug)]
pub struct Floors {
    q: Vec<f64>,
    rounding: Vec<f64>,
}

impl Floors {
    /// The floors of an equilibrated problem. O(nnz).
    #[must_use]
    pub fn new(scaled: &SparseLcp) -> Self {
        let (q, parts) = (scaled.q(), scaled.parts());
        let mut largest = vec![0.0_f64; q.len()];
        for (q, &part) in q.iter().zip(&parts) {
            largest[part] = largest[part].max(q.abs());
        }
        Self { q: q.to_vec(), rounding: parts.iter().map(|&part| 32.0 * f64::EPSILON * largest[part]).collect() }
    }

    /// That of row i, with `m = (|A||z| + |q|)_i`. In a row of which q_i is the greater part nothing decays, and the floor is 0,
    /// as it is for a dense A.
    #[must_use]
    pub fn of(&self, i: usize, m: f64) -> f64 {
        if 2.0 * self.q[i].abs() < m { self.rounding[i] } else { 0.0 }
    }
}

/// On the equilibrated problem, where `max|q'| < 1`, `max|min(z', w')|` itself must be below `max(tol, ABSOLUTE)`: both other
/// tests allow rounding in proportion to z, and a z of 1e16 from a nearly singular block would pass them with any error.
/// Beyond 1e22 or so not even [`slack`] sees q: what it may be off by counts, too.
pub const ABSOLUTE: f64 = 1e-6;

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
}
