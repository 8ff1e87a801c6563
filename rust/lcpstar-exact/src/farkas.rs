//! Farkas vectors: proofs that FEA(q, A) is empty.

use super::dyadic::{RationalVec, linear_form};
use super::padic::Unsolved;
use super::proof::spread;
use super::rows::{GUESSES, Rows};
use crate::problem::Problem;
use num_traits::Signed;

/// Whether the rational `y` is a Farkas vector: `y >= 0`, `A'y <= 0`, `q'y < 0`. Then FEA(q, A) is empty.
#[must_use]
pub fn check_farkas(lcp: Problem<'_>, y: &RationalVec) -> bool {
    let n = lcp.n();
    let support = y.support();
    y.len() == n
        && !y.numerators.iter().any(Signed::is_negative)
        && linear_form(support.iter().map(|&i| (lcp.q()[i], &y.numerators[i]))).value.is_negative()
        && (0..n).all(|j| !linear_form(support.iter().map(|&i| (lcp.row(i)[j], &y.numerators[i]))).value.is_positive())
}

/// [`check_farkas`] for doubles, read as the binary numbers they are.
#[must_use]
pub fn prove_farkas(lcp: Problem<'_>, y: &[f64]) -> bool {
    check_farkas(lcp, &RationalVec::from_f64(y))
}

/// An exact Farkas vector next to the approximate `y`: small entries and nearly vanishing columns are guessed to be
/// zero, the equations are solved exactly with `q'y = q'y` of the doubles, and the result is checked.
#[must_use]
pub fn repair_farkas(lcp: Problem<'_>, y: &[f64], stop: &dyn Fn() -> bool) -> Option<RationalVec> {
    let n = lcp.n();
    let largest = y.iter().fold(0.0, |m: f64, x| m.max(*x));
    if largest <= 0.0 || !largest.is_finite() {
        return None;
    }
    for tolerance in GUESSES {
        let support: Vec<usize> = (0..n).filter(|&i| y[i] > tolerance * largest).collect();
        let clamped: Vec<f64> = (0..n).map(|i| if y[i] > tolerance * largest { y[i] } else { 0.0 }).collect();
        if prove_farkas(lcp, &clamped) {
            return Some(RationalVec::from_f64(&clamped));
        }
        let tight: Vec<usize> = (0..n)
            .filter(|&j| {
                let terms = support.iter().map(|&i| lcp.row(i)[j] * y[i]);
                let (sum, size) = terms.fold((0.0, 0.0), |(s, m): (f64, f64), t| (s + t, m + t.abs()));
                size > 0.0 && sum.abs() <= tolerance.max(1e-13) * size
            })
            .collect();
        let normal: f64 = support.iter().map(|&i| lcp.q()[i] * y[i]).sum();
        if normal >= 0.0 || !normal.is_finite() {
            continue;
        }
        // The first row is the normalisation.
        let entry = |r: usize, j: usize| match r {
            0 => lcp.q()[support[j]],
            r => lcp.row(support[j])[tight[r - 1]],
        };
        let rows = Rows { count: tight.len() + 1, entry: &entry, rhs: &|r| if r == 0 { normal } else { 0.0 } };
        let values: Vec<f64> = support.iter().map(|&i| y[i]).collect();
        match rows.point_near(&values, stop) {
            Ok((part, _)) => {
                let exact = spread(n, &support, part);
                if check_farkas(lcp, &exact) {
                    return Some(exact);
                }
            }
            Err(Unsolved::Interrupted) => return None,
            Err(Unsolved::Singular) => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn never() -> bool {
        false
    }

    #[test]
    fn each_statement_about_a_farkas_vector_is_checked() {
        let check = |a: f64, q: f64, y: &[f64]| check_farkas(Problem::new(&[a], &[q]), &RationalVec::from_f64(y));
        assert!(check(-1.0, -1.0, &[1.0]));
        assert!(!check(1.0, -1.0, &[1.0]), "A'y > 0");
        assert!(!check(1.0, 1.0, &[-1.0]), "y < 0");
        assert!(!check(-1.0, 0.0, &[1.0]), "q'y = 0");
        assert!(!check(-1.0, -1.0, &[1.0, 0.0]), "two entries");
    }

    #[test]
    fn a_farkas_vector_is_checked_and_repaired() {
        let p = Problem::new(&[0.0, -0.1, -0.3, 0.0], &[1.0, -1.0]);
        assert!(prove_farkas(p, &[0.0, 1.0]));
        assert!(!prove_farkas(p, &[1.0, 0.0]));
        let skew = Problem::new(&[0.0, 0.7, -0.7, 0.0], &[0.0, -1.0]);
        assert!(repair_farkas(skew, &[1e-17, 1.0], &never).is_some());
    }
}
