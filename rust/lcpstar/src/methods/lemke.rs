//! Lemke's method. [Lem65], [CPS92, sec. 4.4]
//!
//! Start from `w = q + A z + d z_0` with `z_0` just large enough, then follow the path of almost complementary bases
//! until `z_0` leaves (a solution) or nothing blocks (a secondary ray).
//!
//! Every q is solved when A is strictly semimonotone (E: P, strictly copositive, ...) or E0 and R0. For A in L
//! (PSD, copositive plus, row sufficient, the paper's tilde class), P0 and Q0, or Z, a ray means FEA(q, A) is empty.

use crate::control::Control;
use crate::pivoting::path_limit;
use crate::pivoting::{Dictionary, Entering, Real, Var, basis};
use crate::problem::Lcp;
use crate::solution::{Candidate, Ray};
use crate::status::Termination;

/// Options of Lemke's method.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Covering vector, strictly positive; `None`: all ones.
    pub d: Option<Vec<f64>>,
}

/// Solves LCP(q, A) with a dictionary in the arithmetic `T`. O(n^2) a pivot.
///
/// The path decides the basis; the numbers come from a fresh factorisation of `A[alpha, alpha]`.
pub fn lemke<T: Real>(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    if lcp.q().iter().all(|&q| q >= 0.0) {
        return Candidate { alpha: Some(vec![]), ..Candidate::point(vec![0.0; n], Termination::ComplementaryBasis, 0) };
    }
    let ones = vec![1.0; n];
    let d = settings.d.as_deref().unwrap_or(&ones);
    let mut dictionary = Dictionary::<T>::delayed(lcp, d);
    let (termination, iterations, driving) = follow_path(&mut dictionary, control, path_limit(n));
    let (z, z0) = dictionary.point();
    let alpha = dictionary.basic_z();
    match termination {
        Termination::ComplementaryBasis => {
            let z = basis::basic_point(lcp, &alpha).unwrap_or(z);
            Candidate { alpha: Some(alpha), ..Candidate::point(z, termination, iterations) }
        }
        Termination::SecondaryRay => {
            let (z_hat, z0_hat) = driving.map_or((vec![0.0; n], 0.0), |s| dictionary.direction(s));
            let w_hat = (0..n).map(|i| crate::linalg::kernels::dot(lcp.row(i), &z_hat) + d[i] * z0_hat).collect();
            let ray = Ray { z: z.clone(), z0, z_hat, z0_hat, w_hat, d: d.to_vec() };
            Candidate { ray: Some(ray), ..Candidate::point(z, termination, iterations) }
        }
        _ => Candidate::point(z, termination, iterations),
    }
}

/// Lemke's method on the principal transform at `alpha`, with a covering vector chosen there: no pivot when `alpha` solves the
/// problem, few when it is nearly right. `iterations` counts the pivots of the path, not those of the transform.
///
/// A singular `A[alpha, alpha]` is used as far as it is nonsingular. A ray says nothing about LCP(q, A), so none is handed
/// over. O(n^2) for each index of `alpha` and each pivot. [CPS92, sec. 2.3, 4.4]
pub fn lemke_from<T: Real>(lcp: &Lcp, alpha: &[usize], control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    let mut dictionary = Dictionary::<T>::new(lcp, &vec![0.0; n]);
    let start = match dictionary.pivot_to(alpha, control) {
        Ok(start) => start,
        Err(reason) => return Candidate::point(vec![0.0; n], reason, 0),
    };
    dictionary.restart(|_| 1.0);
    let solved = (0..n).all(|r| dictionary.value(r).to_f64() >= 0.0);
    let (termination, iterations, _) = if solved {
        (Termination::ComplementaryBasis, 0, None)
    } else {
        follow_path(&mut dictionary, control, path_limit(n))
    };
    // In the transform the pairs of `start` have traded places.
    let mut inside = vec![false; n];
    start.iter().chain(&dictionary.basic_z()).for_each(|&i| inside[i] = !inside[i]);
    let alpha: Vec<usize> = (0..n).filter(|&i| inside[i]).collect();
    let (mut z, w) = (dictionary.point().0, dictionary.slacks());
    start.iter().for_each(|&i| z[i] = w[i]);
    match termination {
        Termination::ComplementaryBasis => {}
        Termination::SecondaryRay => {
            let reason = Termination::Breakdown("the path from the guess ended on a ray, from which nothing follows");
            return Candidate::point(z, reason, iterations);
        }
        _ => return Candidate::point(z, termination, iterations),
    }
    let z = basis::basic_point(lcp, &alpha).unwrap_or(z);
    Candidate { alpha: Some(alpha), ..Candidate::point(z, termination, iterations) }
}

/// The path from the first pivot to its end. Returns how it ended, the pivots, and the driving column of a ray.
fn follow_path<T: Real>(
    dictionary: &mut Dictionary<T>,
    control: &Control<'_>,
    default_limit: usize,
) -> (Termination, usize, Option<usize>) {
    let mut iterations = 0;
    let mut driving = Var::Z0;
    let mut entering = Entering::Descending;
    let mut ray = None;
    let termination = loop {
        if let Some(reason) = control.stop(iterations, default_limit) {
            break reason;
        }
        let Some(s) = dictionary.column_of(driving) else {
            break Termination::Breakdown("the driving variable is not nonbasic");
        };
        let Some(row) = dictionary.blocking_row(s, entering) else {
            ray = Some(s);
            break Termination::SecondaryRay;
        };
        let left = dictionary.exchange(row, s);
        iterations += 1;
        entering = Entering::Increasing;
        match left.complement() {
            Some(complement) => driving = complement,
            None => break Termination::ComplementaryBasis,
        }
    };
    (termination, iterations, ray)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dd::Dd;

    fn run<T: Real>(a: &[f64], q: &[f64], d: Option<&[f64]>) -> Candidate {
        let lcp = Lcp::new(q.len(), a.to_vec(), q.to_vec()).expect("valid");
        lemke::<T>(&lcp, &Settings { d: d.map(<[f64]>::to_vec) }, &Control::default())
    }

    /// [Mur88, ex. 2.8 and 2.9 style]: two ways out, in two arithmetics.
    #[test]
    fn basis_or_ray() {
        for found in [
            run::<f64>(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0], None),
            run::<Dd>(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0], None),
        ] {
            assert_eq!(found.termination, Termination::ComplementaryBasis);
            assert!((found.z[0] - 4.0 / 3.0).abs() < 1e-15 && (found.z[1] - 7.0 / 3.0).abs() < 1e-15);
        }
        let found = run::<f64>(&[1.0, -1.0, -1.0, 1.0], &[-1.0, -1.0], None);
        assert_eq!(found.termination, Termination::SecondaryRay);
        assert_eq!(found.ray.expect("a ray").z_hat, [1.0, 1.0]);
    }

    /// The paper's example ends at (0, 2, 7/2) with d = e.
    #[test]
    fn example_of_section_7() {
        let found = run::<f64>(&[0.0, 1.0, 1.0, 2.0, 0.0, 2.0, -2.0, -5.0, 0.0], &[-4.0, -7.0, 10.0], None);
        assert_eq!(found.z, [0.0, 2.0, 3.5]);
    }

    /// Murty's example 2.11 ends on a ray for d = (5, 16) and is solved for d = (1, 1). [Mur88]
    #[test]
    fn the_covering_vector_matters() {
        let (a, q) = ([1.0, 2.0, 2.0, 1.0], [-1.0, -1.0]);
        assert_eq!(run::<f64>(&a, &q, None).termination, Termination::ComplementaryBasis);
        let pivots = run::<f64>(&a, &q, Some(&[5.0, 16.0])).iterations;
        assert!(pivots >= 2);
    }
}
