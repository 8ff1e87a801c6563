//! What can be said about a point: residuals, backward error, and a rigorous bound on its distance from the solution.
//!
//! The bound holds for the given binary numbers, rounding errors of its own computation included.

mod bound;

use crate::equilibrate::Equilibrated;
use crate::error::{LcpError, Result};
use crate::linalg::backend::SparseFactor;
use crate::problem::{Lcp, check_finite};
use crate::residual::{equilibrated_residual, natural_residual, slack};
use crate::sparse::SparseLcp;
use bound::Bound;

/// How accurate a point is.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// `max|min(z, w)|` on the given numbers.
    pub natural_residual: f64,
    /// The scale-free residual on the equilibrated problem.
    pub residual: f64,
    /// The least `omega` such that z solves a problem whose entries differ from the given ones by the fraction omega at most:
    /// `|w_i| / (|A||z| + |q|)_i` where `z_i > 0`, `max(0, -w_i) / (|A||z| + |q|)_i` where `z_i = 0`. Infinite for a negative
    /// z. At most 1 otherwise.
    pub backward_error: f64,
    /// A bound on `max|z - z*|` for the one solution `z*`, where there is a proof.
    pub error_bound: Option<f64>,
    /// The theorem behind the bound, or why there is none.
    pub bound_reason: &'static str,
}

/// Measures a point of a dense problem. O(n^3): one or two factorisations for the bound.
///
/// # Errors
/// `WrongLength` or `NotFinite` for `z`.
pub fn accuracy(lcp: &Lcp, z: &[f64]) -> Result<Accuracy> {
    check(lcp.n(), z)?;
    let (w, magnitude) = slack(lcp, z);
    let problem = Equilibrated::new(lcp);
    let scaled_z = problem.scaling.z_from_caller(z);
    let residual = equilibrated_residual(&scaled_z, &slack(&problem.lcp, &scaled_z).0);
    let bounds = [bound::comparison(&problem, z), bound::definite(lcp, &problem.scaling, z)];
    Ok(report(z, &w, &magnitude, residual, &bounds))
}

/// As [`accuracy`] for a sparse problem; the bound is that of H+-matrices alone. One sparse factorisation.
///
/// # Errors
/// `WrongLength` or `NotFinite` for `z`.
pub fn accuracy_sparse(lcp: &SparseLcp, z: &[f64]) -> Result<Accuracy> {
    check(lcp.n(), z)?;
    let (w, magnitude) = lcp.slack(z);
    let Equilibrated { lcp: scaled, scaling, .. } = Equilibrated::new(lcp);
    let scaled_z = scaling.z_from_caller(z);
    let residual = equilibrated_residual(&scaled_z, &scaled.slack(&scaled_z).0);
    let bounds = [bound::comparison_sparse(lcp, &scaled, &scaling, z)];
    Ok(report(z, &w, &magnitude, residual, &bounds))
}

fn check(n: usize, z: &[f64]) -> Result<()> {
    if z.len() != n {
        return Err(LcpError::WrongLength { name: "z", expected: n, found: z.len() });
    }
    check_finite("z", z)
}

fn report(z: &[f64], w: &[f64], magnitude: &[f64], residual: f64, bounds: &[Bound]) -> Accuracy {
    let best = bounds.iter().filter(|b| b.value.is_some()).min_by(|a, b| {
        let value = |b: &Bound| b.value.unwrap_or(f64::INFINITY);
        value(a).total_cmp(&value(b))
    });
    let chosen = best.or(bounds.first());
    Accuracy {
        natural_residual: natural_residual(z, w),
        residual,
        backward_error: backward_error(z, w, magnitude),
        error_bound: chosen.and_then(|b| b.value),
        bound_reason: if best.is_some() { chosen.map_or("", |b| b.reason) } else { bound::NONE },
    }
}

fn backward_error(z: &[f64], w: &[f64], magnitude: &[f64]) -> f64 {
    let of_row = |i: usize| {
        let wrong = if z[i] > 0.0 { w[i].abs() } else { (-w[i]).max(0.0) };
        match () {
            () if z[i] < 0.0 => f64::INFINITY,
            () if wrong == 0.0 => 0.0,
            () => wrong / magnitude[i],
        }
    };
    (0..z.len()).map(of_row).fold(0.0, f64::max)
}

/// The solution of `M v = b` for a sparse M given by entries. `None` without a factorisation.
fn sparse_solve(n: usize, entries: &[(usize, usize, f64)], b: &[f64]) -> Option<Vec<f64>> {
    let mut factor = SparseFactor::new(n, entries, false)?;
    let mut v = b.to_vec();
    factor.factor(&vec![0.0; n]).then(|| factor.solve(&mut v))?;
    Some(v)
}

#[cfg(test)]
mod tests;
