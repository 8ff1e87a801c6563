//! Solutions that are not the basic point of a nonsingular block: degenerate ones, and those on a face of SOL(q, A).
//!
//! The support is guessed; the point is what the rows with `w_i = 0` leave of it, or any point of the face.

use super::dyadic::RationalVec;
use super::int::Int;
use super::lp::{self, Feasibility};
use super::proof::{ExactSolution, check_solution, spread};
use super::rows::Rows;
use crate::problem::Problem;
use num_bigint::BigInt;
use num_traits::Zero;

/// Proves a solution with `z_i = 0` off `support` and `w_i = 0` in the rows `tight`, next to the doubles `z`.
///
/// Rows of a degenerate solution that hold as equalities fix what a singular `A[support, support]` leaves open; where
/// they leave something open, too, those entries keep their values of `z`. One p-adic solve of order `|support|`.
#[must_use]
pub fn prove_tight(
    lcp: Problem<'_>,
    z: &[f64],
    support: &[usize],
    tight: &[usize],
    stop: &dyn Fn() -> bool,
) -> Option<ExactSolution> {
    let values: Vec<f64> = support.iter().map(|&j| z[j]).collect();
    let rows = Rows { count: tight.len(), entry: &|i, j| lcp.row(tight[i])[support[j]], rhs: &|i| -lcp.q()[tight[i]] };
    let (part, _) = rows.point_near(&values, stop).ok()?;
    checked(lcp, support, spread(lcp.n(), support, part))
}

/// Any solution with `z_i = 0` off `alpha` and `w_alpha = 0`, by one exact linear programme: for small n.
#[must_use]
pub fn prove_by_programme(lcp: Problem<'_>, alpha: &[usize]) -> Option<ExactSolution> {
    let n = lcp.n();
    // Row i times a power of two is in integers, which changes only the unit of its slack.
    let rows: Vec<Vec<Int>> = (0..n)
        .map(|i| {
            let entries = alpha.iter().map(|&j| lcp.row(i)[j]).chain([-lcp.q()[i]]);
            RationalVec::from_f64(&entries.collect::<Vec<f64>>()).numerators.into_iter().map(Int::from).collect()
        })
        .collect();
    let mut columns: Vec<Vec<Int>> =
        (0..=alpha.len()).map(|j| rows.iter().map(|row| row[j].clone()).collect()).collect();
    let rhs = columns.pop()?;
    let slack = |k: usize| (0..n).map(|i| Int::from(-i64::from(i == k))).collect();
    columns.extend((0..n).filter(|k| !alpha.contains(k)).map(slack));
    let Feasibility::Point(x, denominator) = lp::feasible(&columns, &rhs) else { return None };
    let mut numerators = vec![BigInt::zero(); n];
    for (&j, x) in alpha.iter().zip(&x) {
        numerators[j] = x.to_big();
    }
    checked(lcp, alpha, RationalVec { numerators, denominator: denominator.to_big() })
}

fn checked(lcp: Problem<'_>, alpha: &[usize], z: RationalVec) -> Option<ExactSolution> {
    check_solution(lcp, &z).then(|| ExactSolution { alpha: alpha.to_vec(), z })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `z_1 = 1/3` is fixed by row 2 alone: `A[{1}, {1}] = 0`.
    #[test]
    fn a_tight_row_outside_the_support_fixes_the_point() {
        let p = Problem::new(&[0.0, 1.0, 3.0, 1.0], &[0.0, -1.0]);
        let third = [1.0 / 3.0, 0.0];
        let proved = prove_tight(p, &third, &[0], &[0, 1], &|| false).expect("w = 0 in both rows");
        assert_eq!(proved.z.denominator, BigInt::from(3));
        assert!(prove_tight(p, &third, &[0], &[0], &|| false).is_none(), "fl(1/3) is below 1/3");
    }

    #[test]
    fn entries_that_the_rows_leave_open_keep_their_values() {
        let p = Problem::new(&[1.0, 1.0, 1.0, 1.0], &[-1.0, -1.0]);
        let proved = prove_tight(p, &[0.25, 0.75], &[0, 1], &[0, 1], &|| false).expect("a point of the face");
        assert_eq!(proved.z.to_f64(), [0.25, 0.75]);
    }

    #[test]
    fn a_programme_finds_a_point_of_the_face_or_says_no() {
        let p = Problem::new(&[0.0, 0.0, 1.0, 3.0, -1.0, 0.0, -2.0, 3.0, 1.0], &[0.0, 1.0, 1.0]);
        assert!(prove_by_programme(p, &[0]).is_some());
        let none = Problem::new(&[0.0, 0.0, -1.0, 0.0], &[-1.0, 0.0]);
        assert!(prove_by_programme(none, &[0]).is_none());
    }
}
