//! The same checks where a product or a scaled entry may have left the range of doubles: every sum in integers, on the
//! caller's numbers and on the point as the caller gets it. Slow, and rarely needed.

use super::{ABSOLUTE, Judged};
use crate::exact::dyadic::{RationalVec, Scaled, linear_form};
use crate::linalg::kernels::max_abs;
use crate::problem::Lcp;
use crate::scaling::{Equilibrated, exponent, times_power_of_two};
use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};
use std::iter::once;

/// `x 2^shift` in doubles.
fn to_f64(x: &Scaled, shift: i64) -> f64 {
    let excess = x.value.bits().saturating_sub(64);
    let top = (&x.value >> excess).to_f64().unwrap_or(0.0);
    let e = x.exponent + i64::try_from(excess).unwrap_or(i64::MAX / 2) + shift;
    times_power_of_two(top, e.clamp(-4000, 4000) as i32)
}

/// Exact `w = A z + q` and `m = |A||z| + |q|`.
fn rows(lcp: &Lcp, z: &[f64]) -> Vec<(Scaled, Scaled)> {
    let z = RationalVec::from_f64(z); // the denominator is a power of two
    let log_denominator = z.denominator.bits() as i64 - 1;
    let form = |terms: &mut dyn Iterator<Item = (f64, &BigInt)>| {
        let terms: Vec<(f64, &BigInt)> = terms.collect();
        let sum = linear_form(terms.into_iter());
        Scaled { exponent: sum.exponent - log_denominator, ..sum }
    };
    let row = |i: usize| {
        let (a, q) = (lcp.row(i), lcp.q()[i]);
        let w = form(&mut a.iter().copied().zip(&z.numerators).chain(once((q, &z.denominator))));
        let sizes = a.iter().map(|a| a.abs()).zip(&z.numerators).chain(once((q.abs(), &z.denominator)));
        (w, form(&mut sizes.into_iter()))
    };
    (0..lcp.n()).map(row).collect()
}

/// Judges a point of the caller's; where z or w overflows, z = 0 takes its place.
pub(super) fn judge(problem: &Equilibrated<'_>, z: Vec<f64>, tol: f64) -> Judged {
    let measured = measure(problem, z, tol);
    if measured.z.iter().chain(&measured.w).all(|x| x.is_finite()) && measured.natural_residual.is_finite() {
        return measured;
    }
    measure(problem, vec![0.0; problem.lcp.n()], tol)
}

fn measure(problem: &Equilibrated<'_>, mut z: Vec<f64>, tol: f64) -> Judged {
    if !z.iter().all(|z| z.is_finite()) {
        z.fill(0.0);
    }
    let (lcp, scaling) = (problem.original, &problem.scaling);
    let rows = rows(lcp, &z);
    // In units of max|q|, which may be subnormal itself.
    let largest_q = max_abs(lcp.q());
    let unit = if largest_q > 0.0 { exponent(largest_q) } else { 0 };
    let largest_q = times_power_of_two(largest_q, -unit);
    let (mut violation, mut largest_z, mut rows_hold) = (0.0_f64, 1.0_f64, true);
    for (i, (w, m)) in rows.iter().enumerate() {
        let scaled_z = times_power_of_two(z[i], scaling.q - scaling.columns[i]);
        let scaled_w = to_f64(w, i64::from(scaling.q + scaling.rows[i]));
        violation = violation.max(scaled_z.min(scaled_w).abs());
        largest_z = largest_z.max(scaled_z);
        let size = to_f64(m, -i64::from(unit));
        let least = times_power_of_two(z[i], -unit).min(to_f64(w, -i64::from(unit)));
        rows_hold &= least.abs() <= 10.0 * tol * largest_q + 8.0 * f64::EPSILON * size;
        let off = if z[i] > 0.0 || w.value.is_negative() { w.value.abs() } else { BigInt::zero() };
        let off = Scaled { value: off, exponent: w.exponent };
        rows_hold &= off.value.is_zero() || ratio(&off, m) <= tol.sqrt();
    }
    let residual = (violation / largest_z).min(f64::MAX);
    let w: Vec<f64> = rows.iter().map(|(w, _)| to_f64(w, 0)).collect();
    let finite = w.iter().all(|w| w.is_finite());
    Judged {
        solves: finite && rows_hold && residual <= tol && violation <= tol.max(ABSOLUTE),
        residual,
        natural_residual: crate::residual::natural_residual(&z, &w),
        z,
        w,
    }
}

/// `x / y` for `y > 0`.
fn ratio(x: &Scaled, y: &Scaled) -> f64 {
    let shift = -(y.exponent + y.value.bits() as i64);
    to_f64(x, shift) / to_f64(y, shift)
}

/// `y'` in the caller's units, largest entry near 1, if it proves there that no z >= 0 has A z + q >= 0: `q'y < 0` and
/// `(A'y)_j <= 64 eps (|A|'y)_j`, the sums exact.
pub(super) fn farkas(problem: &Equilibrated<'_>, y: &[f64]) -> Option<Vec<f64>> {
    let (lcp, rows) = (problem.original, &problem.scaling.rows);
    let top = y.iter().zip(rows).filter(|(y, _)| **y > 0.0).map(|(&y, r)| exponent(y) + r).max()?;
    let y: Vec<f64> = y.iter().zip(rows).map(|(&y, r)| times_power_of_two(y, r - top)).collect();
    let exact = RationalVec::from_f64(&y);
    let sum = |terms: Vec<f64>| linear_form(terms.into_iter().zip(&exact.numerators));
    let column = |j: usize, size: bool| {
        let entry = |i: usize| lcp.row(i)[j];
        sum((0..y.len()).map(|i| if size { entry(i).abs() } else { entry(i) }).collect())
    };
    let rounding = |j: usize| {
        let s = column(j, false);
        !s.value.is_positive() || ratio(&s, &column(j, true)) <= 64.0 * f64::EPSILON
    };
    let proves = sum(lcp.q().to_vec()).value.is_negative() && (0..y.len()).all(rounding);
    proves.then_some(y)
}
