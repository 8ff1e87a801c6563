//! The one judge: what a method found is recomputed from the caller's data, and only then claimed.
//!
//! A kernel judges by a rule of its own that is stricter (`small::verify` has the proof), exact arithmetic by its proofs; all of
//! them end in [`Verdict::of`].

mod extreme;
mod judged;
mod rays;

use crate::equilibrate::{Equilibrated, Rows};
use crate::exact::proof::ExactSolution;
use crate::exact::sufficiency::{self, NotSufficient};
use crate::linalg::kernels::max_abs;
use crate::member::Member;
use crate::refute::{Refutation, refute};
use crate::residual::{ABSOLUTE, Passed, Row, Rule, natural_residual, off_by, slack_error};
use crate::scaling::are_ordinary;
use crate::solution::{Candidate, Solution};
use crate::status::{Status, Termination};
use crate::tails::Tails;
use crate::verdict::{Aside, Certificate, Evidence, Verdict};
use judged::Judged;

/// Turns what a method found on the equilibrated problem into a verified [`Solution`] of the caller's. A few passes over A; an exact
/// repair where a Farkas vector needs it.
///
/// "Solved" needs the [`Rule`]. A point that fails is looked at again without what may be rounding error in it.
#[must_use]
pub fn judge<P: Rows>(problem: &Equilibrated<'_, P>, mut candidate: Candidate, method: Member, tol: f64) -> Solution {
    let z = problem.scaling.z_to_caller(&std::mem::take(&mut candidate.z));
    judge_callers(problem, z, candidate, method, tol)
}

/// As [`judge`], for a point in the caller's units.
#[must_use]
pub fn judge_callers<P: Rows>(
    problem: &Equilibrated<'_, P>,
    z: Vec<f64>,
    mut candidate: Candidate,
    method: Member,
    tol: f64,
) -> Solution {
    let ray = candidate.ray.as_ref().and_then(|ray| rays::to_caller(&problem.scaling, ray));
    if ray.is_none() && candidate.termination == Termination::SecondaryRay {
        candidate.termination = Termination::Breakdown("doubles do not hold the secondary ray");
    }
    let (judged, passed, as_given) = best_nearby(problem, z, tol);
    let (alpha, evidence) = match passed {
        Some(passed) => {
            // The basis belongs to the point as it was given, its negative entries but for rounding.
            let of_point = |alpha: &Vec<usize>| as_given && vanish(problem, &judged, alpha, tol);
            let alpha = candidate.alpha.take().filter(of_point).unwrap_or_else(|| support(&judged.z));
            (alpha.clone(), Evidence::Passed(passed, alpha))
        }
        None => (support(&judged.z), against(problem, &mut candidate)),
    };
    let verdict = Verdict::of(evidence);
    let is_ray = verdict.status() == Status::SecondaryRay;
    Solution {
        message: explain(problem.original, &verdict, candidate.termination, judged.residual, tol),
        z: judged.z,
        w: judged.w,
        verdict,
        method,
        iterations: candidate.iterations,
        residual: judged.residual,
        natural_residual: judged.natural_residual,
        alpha,
        ray: ray.filter(|_| is_ray),
        pieces: vec![],
    }
}

/// The verdict on an exact solution, the point its rounding to doubles. `found` says who led to it and how. Where the rounding does not
/// pass the rule, it is called solved only where a proof was `asked` for: the answer is then the exact one.
#[must_use]
pub(crate) fn proved<P: Rows>(
    problem: &Equilibrated<'_, P>,
    exact: ExactSolution,
    found: &Solution,
    tol: f64,
    asked: bool,
) -> Solution {
    let rounded = exact.z.to_f64();
    let point = rounded.iter().all(|z| z.is_finite()).then(|| measure(problem, rounded, tol, None));
    let point = point.filter(Judged::is_finite);
    let is_held = point.is_some();
    let judged = point.unwrap_or_else(|| measure(problem, vec![0.0; problem.original.n()], tol, None));
    let residual = judged.residual;
    let alpha = exact.alpha.clone();
    let unheld = |why| Evidence::Stopped(Termination::Breakdown(why), Some(Aside::Solution(exact.clone())));
    let (message, evidence) = match judged.passed {
        Some(_) => (
            format!("solved: residual {residual:.2e} <= tol {tol:.0e}; proved in exact arithmetic"),
            Evidence::Proved(exact),
        ),
        None if !is_held => (
            "no double holds the solution: certificate.z has it, proved in exact arithmetic".to_owned(),
            unheld("no double holds it"),
        ),
        None if asked => (
            format!(
                "solved, proved in exact arithmetic: the solution is certificate.z; its rounding to doubles has residual \
                 {residual:.2e} for tol {tol:.0e}, or an error that is a large part of some row"
            ),
            Evidence::Proved(exact),
        ),
        None => (
            format!(
                "the solution is certificate.z, proved in exact arithmetic, but its rounding to doubles misses tol: residual \
                 {residual:.2e}, tol {tol:.0e}, or a large part of some row; certify=\"exact\" calls it solved"
            ),
            unheld("its rounding misses tol"),
        ),
    };
    Solution {
        message,
        z: judged.z,
        w: judged.w,
        alpha,
        verdict: Verdict::of(evidence),
        method: found.method,
        iterations: found.iterations,
        residual: judged.residual,
        natural_residual: judged.natural_residual,
        ray: None,
        pieces: found.pieces.clone(),
    }
}

/// The point, or the point without what may be rounding error in it if only that passes; 0 where a number is none. Whether it passed,
/// and whether it is the point as given.
fn best_nearby<P: Rows>(problem: &Equilibrated<'_, P>, mut z: Vec<f64>, tol: f64) -> (Judged, Option<Passed>, bool) {
    for x in &mut z {
        if *x <= 0.0 {
            *x = 0.0; // also turns -0 into 0
        }
    }
    if !z.iter().all(|x| x.is_finite()) {
        z.fill(0.0); // no iterate worth keeping
    }
    let first = measure(problem, z, tol, None);
    if let Some(passed) = first.passed {
        return (first, Some(passed), true);
    }
    let mut tried = first.z.clone();
    for z in without_noise(problem, &first) {
        if z != tried {
            let judged = measure(problem, z, tol, None);
            if let Some(passed) = judged.passed {
                return (judged, Some(passed), false);
            }
            tried = judged.z;
        }
    }
    if first.is_finite() {
        return (first, None, true);
    }
    let zero = measure(problem, vec![0.0; tried.len()], tol, None);
    let passed = zero.passed;
    (zero, passed, false)
}

/// An entry of z below this part of the largest one may be rounding error, of one solve; after refinement, below its square.
const NOISE: f64 = 1e-13;

/// The point without the smaller member of each pair, and then without what is rounding error beside the largest entry: a
/// degenerate z_i that should be zero, in a row that holds nothing else.
fn without_noise<P: Rows>(problem: &Equilibrated<'_, P>, point: &Judged) -> [Vec<f64>; 3] {
    let scaling = &problem.scaling;
    let (z, w) = (scaling.z_from_caller(&point.z), scaling.w_from_caller(&point.w));
    let largest = max_abs(&z);
    let pairs: Vec<f64> = (0..z.len()).map(|i| if z[i] < w[i] { 0.0 } else { point.z[i] }).collect();
    let above = |part: f64| (0..z.len()).map(|i| if z[i] > part * largest { pairs[i] } else { 0.0 }).collect();
    let (once, twice) = (above(NOISE), above(NOISE * NOISE));
    [pairs, once, twice]
}

/// A point `z >= 0` of the caller's: `w`, both residuals and the rule, which forgives `tails` where they are given.
fn measure<P: Rows>(problem: &Equilibrated<'_, P>, z: Vec<f64>, tol: f64, tails: Option<&Tails>) -> Judged {
    if !(problem.is_ordinary && are_ordinary(&z)) {
        return extreme::measure(problem, z, tol);
    }
    let scaling = &problem.scaling;
    let scaled_z = scaling.z_from_caller(&z);
    let (scaled_w, magnitude) = problem.lcp.slack(&scaled_z);
    let (w, m) = (scaling.w_to_caller(&scaled_w), scaling.w_to_caller(&magnitude));
    let mut rule = Rule::new(tol, max_abs(problem.original.q()));
    for i in 0..z.len() {
        let off = off_by(scaled_z[i], scaled_w[i]);
        rule.add(Row {
            equilibrated: [scaled_z[i], scaled_w[i]],
            caller: [z[i], w[i], m[i]],
            part: if off == 0.0 { 0.0 } else { off / magnitude[i] },
            is_tail: tails.is_some_and(|tails| tails.forgive(i, off, magnitude[i])),
        });
    }
    let passed = rule.passed(slack_error(z.len(), max_abs(&magnitude))).filter(|_| w.iter().all(|w| w.is_finite()));
    Judged { natural_residual: natural_residual(&z, &w), residual: rule.residual(), passed, z, w }
}

/// The end of the road for a point that only misses the ends of its tails: solved, where those are forgiven. O(nnz log n).
#[must_use]
pub(crate) fn without_tails<P: Rows>(problem: &Equilibrated<'_, P>, solution: Solution, tol: f64) -> Solution {
    if solution.is_solved() || solution.residual > tol {
        return solution;
    }
    let Some(tails) = Tails::new(problem.original, &problem.lcp) else { return solution };
    let judged = measure(problem, solution.z.clone(), tol, Some(&tails));
    let Some(passed) = judged.passed else { return solution };
    let alpha = support(&judged.z);
    Solution {
        verdict: Verdict::of(Evidence::Passed(passed, alpha.clone())),
        message: format!("solved: residual {:.2e} <= tol {tol:.0e}, tails below rounding cut off", judged.residual),
        alpha,
        z: judged.z,
        w: judged.w,
        ..solution
    }
}

/// Indices of the positive entries.
fn support(z: &[f64]) -> Vec<usize> {
    (0..z.len()).filter(|&i| z[i] > 0.0).collect()
}

/// What speaks against a solution: a Farkas vector among the candidates, a proof that A is not sufficient; else how the method
/// stopped.
fn against<P: Rows>(problem: &Equilibrated<'_, P>, candidate: &mut Candidate) -> Evidence {
    let ray = candidate.ray.as_ref().map(|ray| ray.z_hat.as_slice());
    let mut nearly = None;
    for y in [candidate.farkas.as_deref(), ray].into_iter().flatten() {
        match refute(problem, y, &|| false) {
            Some(exact @ Refutation::Exact(_)) => return Evidence::Refuted(exact),
            found => nearly = nearly.or(found),
        }
    }
    if let Some(nearly) = nearly {
        return Evidence::Refuted(nearly);
    }
    let proof = candidate.not_sufficient.take().and_then(|proof| insufficiency(problem, &proof));
    Evidence::Stopped(candidate.termination, proof.map(Aside::NotSufficient))
}

/// Whether `w'_i` is zero to rounding wherever `z_i` is, on a basis.
fn vanish<P: Rows>(problem: &Equilibrated<'_, P>, judged: &Judged, alpha: &[usize], tol: f64) -> bool {
    if alpha.iter().all(|&i| judged.z[i] > 0.0) {
        return true;
    }
    let (z, w) = (problem.scaling.z_from_caller(&judged.z), problem.scaling.w_from_caller(&judged.w));
    let room = tol.max(ABSOLUTE) * max_abs(&z).max(1.0);
    alpha.iter().all(|&i| z[i] > 0.0 || w[i].abs() <= room)
}

/// The proof in the caller's units, `x = D_c x'` (`D_r x'` for A'), checked on the caller's numbers: the scaling changes
/// no sign of `x_i (A x)_i`.
fn insufficiency<P: Rows>(problem: &Equilibrated<'_, P>, found: &NotSufficient) -> Option<NotSufficient> {
    let exponents = if found.transposed { &problem.scaling.rows } else { &problem.scaling.columns };
    let found = NotSufficient { x: found.x.times_powers_of_two(exponents), transposed: found.transposed };
    sufficiency::check(problem.original.dense()?.as_ref().view(), &found).then_some(found)
}

/// One sentence: what happened and what to try next.
fn explain<P: Rows>(problem: &P, verdict: &Verdict, termination: Termination, residual: f64, tol: f64) -> String {
    let why = if residual <= tol {
        format!("residual {residual:.2e}, and a row whose error is too large in the caller's units")
    } else {
        format!("residual {residual:.2e} > tol {tol:.0e}")
    };
    match (verdict.status(), termination) {
        (Status::Solved, _) => format!("solved: residual {residual:.2e} <= tol {tol:.0e}"),
        (Status::Infeasible, _) => {
            "infeasible: the certificate's y >= 0 has A'y <= 0 and q'y < 0 exactly, so no z >= 0 has A z + q >= 0".to_owned()
        }
        (Status::NearlyInfeasible, _) => match verdict.certificate() {
            Some(Certificate::NearlyInfeasible { bound, .. }) => format!(
                "nearly infeasible: no z >= 0 with sum(z) < {bound:.3e} has A z + q >= 0; certify=\"exact\" decides what is beyond"
            ),
            _ => "nearly infeasible".to_owned(),
        },
        (Status::SecondaryRay, _) => "Lemke's method ended on a secondary ray, from which nothing follows for this \
             matrix; try another covering vector d, another method, or lcpstar.solutions"
            .to_owned(),
        (Status::MaxIterations, _) => format!("iteration limit reached with {why}; raise max_iterations"),
        (Status::TimeLimit, Termination::Interrupted) => format!("interrupted with residual {residual:.2e}"),
        (Status::TimeLimit, _) => format!("time limit reached with {why}; raise time_limit or tol"),
        (_, Termination::NotZ { row, column }) => {
            format!("A is not a Z-matrix: A[{row}, {column}] = {} is positive", problem.entry(row, column))
        }
        (_, Termination::NotSufficient) => {
            "A is not sufficient: the certificate's x has x_i (A x)_i <= 0 for all i and < 0 for some i (A' where it is y)"
                .to_owned()
        }
        (_, Termination::Breakdown(reason)) => {
            format!("{reason} (residual {residual:.2e}, tol {tol:.0e}); try a larger tol or certify=\"exact\"")
        }
        (_, _) => format!(
            "the method finished, but its point has {why} on the caller's data; try a larger tol or certify=\"exact\""
        ),
    }
}

#[cfg(test)]
mod kernel_is_stricter;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Lcp;
    use crate::sparse::SparseLcp;

    fn verdict(a: &[f64], q: &[f64], z: &[f64], tol: f64) -> Solution {
        let lcp = Lcp::new(q.len(), a.to_vec(), q.to_vec()).expect("valid");
        let problem = Equilibrated::new(&lcp);
        let z = problem.scaling.z_from_caller(z);
        judge(&problem, Candidate::point(z, Termination::Converged, 0), Member::Auto, tol)
    }

    #[test]
    fn a_claim_without_substance_is_not_believed() {
        assert_eq!(verdict(&[2.0], &[-1.0], &[0.5], 1e-9).status(), Status::Solved);
        assert_eq!(verdict(&[2.0], &[-1.0], &[0.5 + 1e-6], 1e-9).status(), Status::NumericalBreakdown);
        assert_eq!(verdict(&[2.0], &[-1.0], &[0.0], 1e-9).status(), Status::NumericalBreakdown);
        let nan = verdict(&[2.0], &[-1.0], &[f64::NAN], 1e-9);
        assert_eq!((nan.status(), nan.z[0]), (Status::NumericalBreakdown, 0.0));
    }

    /// Each view of a point refuses one that all others accept.
    #[test]
    fn every_view_counts() {
        let solved = |a: &[f64], q: &[f64], z: &[f64]| verdict(a, q, z, 1e-9).status() == Status::Solved;
        let unit = [1.0, 0.0, 0.0, 1.0];
        assert!(solved(&[1.0], &[-1.0], &[1.0 + 1e-9]));
        assert!(!solved(&[1.0], &[-1.0], &[1.0 + 5e-9]), "residual 2.5e-9, within 10 tol max|q|");
        let graded = [1.0, 0.0, 0.0, 1e6];
        assert!(solved(&graded, &[-1.0, -1.0], &[1.0, 1e-6 * (1.0 + 1e-9)]));
        assert!(!solved(&graded, &[-1.0, -1.0], &[1.0, 1e-6 * (1.0 + 1e-7)]), "w_2 = 1e-7 in the caller's units");
        assert!(solved(&unit, &[-1.0, -1e-12], &[1.0, 1e-12 * (1.0 + 1e-6)]));
        assert!(!solved(&unit, &[-1.0, -1e-12], &[1.0, 0.0]), "w_2 = q_2 < 0");
        assert!(!solved(&unit, &[-1.0, -1e-12], &[1.0, 2e-12]), "w_2 = -q_2, z_2 > 0");
    }

    /// `(status of the dense problem, of the sparse one)` for the equilibrated matrix a and a candidate y.
    fn refuted(a: &[f64], q: &[f64], y: &[f64]) -> (bool, bool) {
        let n = q.len();
        let lcp = Lcp::new(n, a.to_vec(), q.to_vec()).expect("valid");
        let problem = Equilibrated::new(&lcp);
        assert!(problem.scaling.rows.iter().chain(&problem.scaling.columns).all(|&e| e == 0));
        let mut candidate = Candidate::point(vec![0.0; n], Termination::Infeasible, 0);
        candidate.farkas = Some(y.to_vec());
        let sparse = SparseLcp::from_dense(&lcp);
        let found = judge(&Equilibrated::new(&sparse), candidate.clone(), Member::Auto, 1e-9);
        let is = |solution: Solution| solution.status() == Status::Infeasible;
        (is(judge(&problem, candidate, Member::Auto, 1e-9)), is(found))
    }

    #[test]
    fn every_statement_about_a_farkas_vector_counts() {
        let square = [1.0, -1.0, -1.0, 1.0];
        assert_eq!(refuted(&square, &[-1.0, -1.0], &[1.0, 1.0]), (true, true));
        assert_eq!(refuted(&square, &[-1.0, 1.0], &[1.0, 1.0]), (false, false), "q'y = 0");
        assert_eq!(refuted(&square, &[-1.0, 1.0], &[1.0, 1.0 + 1e-15]), (false, false), "q'y > 0");
        assert_eq!(refuted(&[1.0], &[1.0], &[-1.0]), (false, false), "y < 0");
        assert_eq!(refuted(&square, &[-1.0, -1.0], &[1.0, 1.0 + 1e-8]), (false, false), "z of size 1e8 is feasible");
        // A'y = 1e-12 in column 2 is all there is in it, and no rounding.
        assert_eq!(refuted(&[-1.0, 0.0, 0.0, 1.0], &[-1.0, -1.0], &[1.0, 1e-12]), (false, false));
    }

    #[test]
    fn a_proof_that_a_is_not_sufficient_is_checked() {
        let lcp = Lcp::new(2, vec![1.0, 2.0, 2.0, 1.0], vec![-1.0, -1.0]).expect("valid");
        let problem = Equilibrated::new(&lcp);
        for (x, holds) in [([1.0, -1.0], true), ([1.0, 1.0], false), ([0.0, 0.0], false)] {
            let mut candidate = Candidate::point(vec![0.0; 2], Termination::NotSufficient, 0);
            let x = crate::exact::dyadic::RationalVec::from_f64(&x);
            candidate.not_sufficient = Some(NotSufficient { x, transposed: false });
            assert_eq!(judge(&problem, candidate, Member::Auto, 1e-9).certificate().is_some(), holds);
        }
    }

    #[test]
    fn a_tail_is_forgiven_where_a_solution_exists_whatever_the_form_of_a() {
        let solved = |a: [f64; 4], q: [f64; 2], z: [f64; 2]| {
            let lcp = Lcp::new(2, a.to_vec(), q.to_vec()).expect("valid");
            let sparse = SparseLcp::from_dense(&lcp);
            let (dense, sparse) = (Equilibrated::new(&lcp), Equilibrated::new(&sparse));
            let candidate = Candidate::point(dense.scaling.z_from_caller(&z), Termination::Converged, 0);
            let found = judge(&dense, candidate.clone(), Member::Auto, 1e-9);
            assert!(!found.is_solved());
            let again = judge(&sparse, candidate, Member::Auto, 1e-9);
            let found = without_tails(&dense, found, 1e-9).is_solved();
            assert_eq!(without_tails(&sparse, again, 1e-9).is_solved(), found);
            found
        };
        let dominant = [1.0, -0.5, -1e-17, 1.0];
        // z_2 of 1e-17 beside 1 may be cut off where its row says so; not where q_2 does, nor where A need not have a solution.
        assert!(solved(dominant, [-1.0, 0.0], [1.0, 0.0]));
        assert!(!solved(dominant, [1.0, -1e-16], [0.0, 0.0]));
        assert!(!solved([1.0, 0.0, -1e-17, 0.0], [-1.0, 0.0], [1.0, 0.0]));
    }

    #[test]
    fn a_badly_scaled_row_cannot_hide() {
        // Row 2 is a million times smaller: its error of 100 % must still be seen.
        let (a, q) = ([1.0, 0.0, 0.0, 1e-6], [-1.0, -1e-6]);
        assert_eq!(verdict(&a, &q, &[1.0, 1.0], 1e-9).status(), Status::Solved);
        assert_ne!(verdict(&a, &q, &[1.0, 0.0], 1e-6).status(), Status::Solved);
    }

    #[test]
    fn a_message_never_says_that_a_small_residual_is_above_tol() {
        // w_2 = 1e16 - 1 beside z_2 = 1, in a row of a point of size 1e16.
        let found = verdict(&[0.0, 1.0, 1.0, 0.0], &[-1.0, -1.0], &[1e16, 1.0], 1e-9);
        assert_eq!(found.status(), Status::NumericalBreakdown);
        assert!(found.residual <= 1e-9 && !found.message.contains(" > tol"), "{}", found.message);
    }

    #[test]
    fn a_z_beside_which_nobody_sees_q_solves_nothing() {
        // w = A z + q = q exactly, but for what rounding adds.
        let a = [1.0, -1.0, 1.0, -1.0];
        for size in [1e12, 1e25, 1e100] {
            let found = verdict(&a, &[-1.0, -1.0], &[size, size], 1e-9);
            assert_ne!(found.status(), Status::Solved, "{size}");
        }
    }

    #[test]
    fn a_farkas_vector_is_checked() {
        let lcp = Lcp::new(2, vec![1.0, -1.0, -1.0, 1.0], vec![-1.0, -1.0]).expect("valid");
        let problem = Equilibrated::new(&lcp);
        let mut candidate = Candidate::point(vec![0.0; 2], Termination::Infeasible, 0);
        candidate.farkas = Some(vec![1.0, 1.0]);
        assert_eq!(judge(&problem, candidate.clone(), Member::Auto, 1e-9).status(), Status::Infeasible);
        candidate.farkas = Some(vec![1.0, 0.999]);
        assert_eq!(judge(&problem, candidate, Member::Auto, 1e-9).status(), Status::NumericalBreakdown);
    }
}
