//! Secondary rays of Lemke's method, proved.

use super::dyadic::{RationalVec, linear_form, ratio_to_f64};
use super::proof::spread;
use super::rows::{GUESSES, Rows};
use crate::problem::Problem;
use num_bigint::BigInt;
use num_traits::{Signed, Zero};

/// A secondary ray of Lemke's method: `z >= 0`, `z != 0`, `z0 >= 0`, `w = A z + d z0 >= 0`, `z'w = 0`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExactRay {
    /// Direction of `z`.
    pub z: RationalVec,
    /// Direction of `z_0`: numerator over `z.denominator`.
    pub z0: BigInt,
}

/// Whether `ray` is a ray for the covering vector `d`.
#[must_use]
pub fn check_ray(lcp: Problem<'_>, d: &[f64], ray: &ExactRay) -> bool {
    ray.z.numerators.iter().all(|x| !x.is_negative())
        && ray.z.numerators.iter().any(|x| !x.is_zero())
        && !ray.z0.is_negative()
        && (0..lcp.n()).all(|i| {
            let terms = lcp.row(i).iter().copied().zip(&ray.z.numerators);
            let w = linear_form(terms.chain(std::iter::once((d[i], &ray.z0)))).value;
            w.is_zero() || (w.is_positive() && ray.z.numerators[i].is_zero())
        })
}

/// An exact secondary ray next to the approximate `(z, z0)`.
#[must_use]
pub fn prove_ray(lcp: Problem<'_>, d: &[f64], z: &[f64], z0: f64, stop: &dyn Fn() -> bool) -> Option<ExactRay> {
    let n = lcp.n();
    let largest = z.iter().fold(0.0, |m: f64, x| m.max(*x));
    if largest <= 0.0 || !largest.is_finite() {
        return None;
    }
    for tolerance in GUESSES {
        let support: Vec<usize> = (0..n).filter(|&i| z[i] > tolerance * largest).collect();
        let with_z0 = z0 > tolerance * largest;
        let mut values: Vec<f64> = support.iter().map(|&i| z[i]).collect();
        if with_z0 {
            values.push(z0);
        }
        let column = |i: usize, j: usize| if j < support.len() { lcp.row(i)[support[j]] } else { d[i] };
        let is_tight = |i: usize| {
            let terms = values.iter().enumerate().map(|(j, v)| column(i, j) * v);
            let (sum, size) = terms.fold((0.0, 0.0), |(s, m): (f64, f64), t| (s + t, m + t.abs()));
            size > 0.0 && sum.abs() <= tolerance.max(1e-13) * size
        };
        let tight: Vec<usize> = (0..n).filter(|&i| z[i] > tolerance * largest || is_tight(i)).collect();
        // The first row keeps the sum of z.
        let total: f64 = support.iter().map(|&i| z[i]).sum();
        let entry = |r: usize, j: usize| match r {
            0 => f64::from(u8::from(j < support.len())),
            r => column(tight[r - 1], j),
        };
        let rows = Rows { count: tight.len() + 1, entry: &entry, rhs: &|r| if r == 0 { total } else { 0.0 } };
        let Ok((part, _)) = rows.point_near(&values, stop) else {
            continue;
        };
        let z0 = if with_z0 { part.numerators[support.len()].clone() } else { BigInt::zero() };
        let ray = ExactRay { z: spread(n, &support, part), z0 };
        if check_ray(lcp, d, &ray) {
            return Some(ray);
        }
    }
    None
}

/// `z0` of an exact ray, rounded.
#[must_use]
pub fn ray_z0(ray: &ExactRay) -> f64 {
    ratio_to_f64(&ray.z0, &ray.z.denominator)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn never() -> bool {
        false
    }

    #[test]
    fn each_statement_about_a_ray_is_checked() {
        let check = |a: &[f64], z: &[f64], z0: i64| {
            let n = z.len();
            let ray = ExactRay { z: RationalVec::from_f64(z), z0: BigInt::from(z0) };
            check_ray(Problem::new(a, &vec![-1.0; n]), &vec![1.0; n], &ray)
        };
        assert!(check(&[0.0], &[1.0], 0) && check(&[-1.0], &[1.0], 1));
        assert!(!check(&[0.0], &[-1.0], 0), "z < 0");
        assert!(!check(&[0.0], &[0.0], 0), "z = 0");
        assert!(!check(&[1.0], &[1.0], -1), "z_0 < 0");
        assert!(!check(&[1.0], &[1.0], 0), "z w > 0");
        assert!(!check(&[0.0, 0.0, -1.0, 0.0], &[1.0, 0.0], 0), "w < 0");
    }

    #[test]
    fn a_ray_is_made_exact() {
        // Feasible direction of a skew matrix.
        let p = Problem::new(&[0.0, -1.0 / 3.0, 1.0 / 3.0, 0.0], &[-1.0, -1.0]);
        let ray = prove_ray(p, &[1.0, 1.0], &[1.0, 1e-18], 0.0, &never).expect("ray");
        assert!(check_ray(p, &[1.0, 1.0], &ray));
        assert!(prove_ray(p, &[1.0, 1.0], &[0.0, 1.0], 0.0, &never).is_none());
    }
}
