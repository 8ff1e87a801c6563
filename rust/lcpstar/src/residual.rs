//! How far `z` is from solving LCP(q, A): `w` in twice the working precision, and the natural residual.

use crate::linalg::compensated::affine_compensated;
use crate::linalg::kernels::max_abs;
use crate::problem::Lcp;

/// `w = A z + q` (Dot2 of [ORO05]) and its rounding scale `|A||z| + |q|`, row by row. O(n^2).
#[must_use]
pub fn slack(lcp: &Lcp, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
    affine_compensated(lcp.q(), lcp.a(), z)
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
