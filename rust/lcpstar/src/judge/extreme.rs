//! The same checks where a product or a scaled entry may have left the range of doubles: every sum in integers, on the
//! caller's numbers and on the point as the caller gets it. Slow, and rarely needed.

use super::judged::Judged;
use crate::equilibrate::{Equilibrated, Rows};
use crate::exact::dyadic::{RationalVec, Scaled, linear_form};
use crate::linalg::kernels::max_abs;
use crate::residual::{Row, Rule};
use crate::scaling::{exponent, times_power_of_two};
use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};

/// `x 2^shift` in doubles.
fn to_f64(x: &Scaled, shift: i64) -> f64 {
    let excess = x.value.bits().saturating_sub(64);
    let top = (&x.value >> excess).to_f64().unwrap_or(0.0);
    let e = x.exponent + i64::try_from(excess).unwrap_or(i64::MAX / 2) + shift;
    times_power_of_two(top, e.clamp(-4000, 4000) as i32)
}

/// Exact `w = A z + q` and `m = |A||z| + |q|`.
fn rows<P: Rows>(lcp: &P, z: &[f64]) -> Vec<(Scaled, Scaled)> {
    let z = RationalVec::from_f64(z); // the denominator is a power of two
    let log_denominator = z.denominator.bits() as i64 - 1;
    let form = |terms: &[(f64, &BigInt)]| {
        let sum = linear_form(terms.iter().copied());
        Scaled { exponent: sum.exponent - log_denominator, ..sum }
    };
    let row = |i: usize| {
        let mut terms = vec![(lcp.q()[i], &z.denominator)];
        lcp.for_each(i, |j, a| terms.push((a, &z.numerators[j])));
        let w = form(&terms);
        terms.iter_mut().for_each(|(a, _)| *a = a.abs());
        (w, form(&terms))
    };
    (0..lcp.n()).map(row).collect()
}

/// A point `z >= 0` of the caller's, finite.
pub(super) fn measure<P: Rows>(problem: &Equilibrated<'_, P>, z: Vec<f64>, tol: f64) -> Judged {
    let (lcp, scaling) = (problem.original, &problem.scaling);
    let rows = rows(lcp, &z);
    // In units of max|q|, which may be subnormal itself.
    let largest_q = max_abs(lcp.q());
    let unit = if largest_q > 0.0 { exponent(largest_q) } else { 0 };
    let mut rule = Rule::new(tol, times_power_of_two(largest_q, -unit));
    for (i, (w, m)) in rows.iter().enumerate() {
        let in_unit = |x: &Scaled| to_f64(x, -i64::from(unit));
        let is_off = z[i] > 0.0 || w.value.is_negative();
        rule.add(Row {
            equilibrated: [
                times_power_of_two(z[i], scaling.q - scaling.columns[i]),
                to_f64(w, i64::from(scaling.q + scaling.rows[i])),
            ],
            caller: [times_power_of_two(z[i], -unit), in_unit(w), in_unit(m)],
            part: if is_off && !w.value.is_zero() { ratio(w, m).abs() } else { 0.0 },
            is_tail: false,
        });
    }
    let w: Vec<f64> = rows.iter().map(|(w, _)| to_f64(w, 0)).collect();
    let passed = rule.passed(0.0).filter(|_| w.iter().all(|w| w.is_finite()));
    let natural_residual = crate::residual::natural_residual(&z, &w);
    Judged { natural_residual, residual: rule.residual().min(f64::MAX), passed, z, w }
}

/// `x / y` for `y > 0`.
fn ratio(x: &Scaled, y: &Scaled) -> f64 {
    let shift = -(y.exponent + y.value.bits() as i64);
    to_f64(x, shift) / to_f64(y, shift)
}
