//! What can be said about a point: residuals, backward error, and a rigorous bound on its distance from the solution.
//!
//! The bound holds for the given binary numbers, rounding errors of its own computation included.

mod bound;
mod row;

use crate::control::Control;
use crate::equilibrate::Equilibrated;
use crate::error::{LcpError, Result};
use crate::problem::{Lcp, check_finite};
use crate::scaling::Scaling;
use crate::sparse::SparseLcp;
use bound::Bound;
use row::{Row, Wide};

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

/// Measures a point of a dense problem. O(n^3): one or two factorisations for the bound, after each of which `control` may stop.
///
/// # Errors
/// `WrongLength` or `NotFinite` for `z`.
pub fn accuracy(lcp: &Lcp, z: &[f64], control: &Control<'_>) -> Result<Accuracy> {
    check(lcp.n(), z)?;
    let point = point(lcp, z);
    let problem = Equilibrated::new(lcp);
    let scaling = &problem.scaling;
    let bounds = [bound::comparison(&problem, &point, control), bound::definite(lcp, scaling, &point, control)];
    Ok(report(&point, scaling, &bounds))
}

/// As [`accuracy`] for a sparse problem; the bound is that of H+-matrices alone. One sparse factorisation.
///
/// # Errors
/// `WrongLength` or `NotFinite` for `z`.
pub fn accuracy_sparse(lcp: &SparseLcp, z: &[f64], control: &Control<'_>) -> Result<Accuracy> {
    check(lcp.n(), z)?;
    let of_row = |i: usize| {
        let (columns, values) = lcp.row(i);
        Row::new(z[i], lcp.q()[i], values, |k| z[columns[k]])
    };
    let point: Vec<Row> = (0..lcp.n()).map(of_row).collect();
    let Equilibrated { lcp: scaled, scaling, .. } = Equilibrated::new(lcp);
    let bounds = [bound::comparison_sparse(lcp, &scaled, &scaling, &point, control)];
    Ok(report(&point, &scaling, &bounds))
}

fn point(lcp: &Lcp, z: &[f64]) -> Vec<Row> {
    (0..lcp.n()).map(|i| Row::new(z[i], lcp.q()[i], lcp.row(i), |k| z[k])).collect()
}

fn check(n: usize, z: &[f64]) -> Result<()> {
    if z.len() != n {
        return Err(LcpError::WrongLength { name: "z", expected: n, found: z.len() });
    }
    check_finite("z", z)
}

fn report(point: &[Row], scaling: &Scaling, bounds: &[Bound]) -> Accuracy {
    let largest = |of: &dyn Fn(usize, &Row) -> Wide| {
        point.iter().enumerate().map(|(i, row)| of(i, row)).fold(Wide::ZERO, Wide::max)
    };
    let size = largest(&|i, row| row.scaled(scaling, i).0.abs());
    let scaled = largest(&|i, row| {
        let (z, w) = row.scaled(scaling, i);
        z.min(w).abs()
    });
    let proved = bounds.iter().filter_map(|b| b.value.map(|value| (value, b.reason)));
    let best = proved.min_by(|(a, _), (b, _)| a.total_cmp(b));
    Accuracy {
        natural_residual: largest(&|_, row| row.z.min(row.w).abs()).to_f64(),
        residual: scaled.over(size.max(Wide::new(1.0))).to_f64(),
        backward_error: largest(&|_, row| row.backward_error()).to_f64(),
        error_bound: best.map(|(value, _)| value),
        bound_reason: best.map_or(bounds.last().map_or("", |b| b.reason), |(_, reason)| reason),
    }
}

#[cfg(test)]
mod tests;
