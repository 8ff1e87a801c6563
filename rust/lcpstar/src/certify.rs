//! Where "solved" and "infeasible" are said: every claim is recomputed from the caller's data. Beside it, `small::verify`
//! accepts the answers of the kernels for small problems by a stricter rule, and `driver::prove` those of exact arithmetic.

mod extreme;

use crate::exact::sufficiency::{self, NotSufficient};
use crate::linalg::kernels::max_abs;
use crate::residual::{ABSOLUTE, Floors, equilibrated_residual, holds_alone, natural_residual, slack, slack_error};
use crate::scaling::{Equilibrated, Scaling, are_ordinary};
use crate::solution::{Candidate, Certificate, Ray, Solution};
use crate::sparse::SparseLcp;
use crate::status::{Status, Termination};

/// A point of the equilibrated problem, judged.
struct Judged {
    z: Vec<f64>,
    w: Vec<f64>,
    residual: f64,
    natural_residual: f64,
    solves: bool,
}

/// Turns what `method` found on the equilibrated problem into a verified [`Solution`] of the caller's. O(n^2).
///
/// "Solved" needs every view: the scale-free residual within `tol`; in the caller's own units
/// `|min(z, w)|_i <= 10 tol max|q| + 8 eps (|A||z| + |q|)_i` in every row; and every row holds to its own numbers, see
/// [`holds_alone`]. So neither a badly scaled row nor a badly chosen unit can hide an error; nor can a huge z, see `ABSOLUTE`.
#[must_use]
pub fn certify(problem: &Equilibrated<'_>, mut candidate: Candidate, method: &'static str, tol: f64) -> Solution {
    let judged = judge(problem, std::mem::take(&mut candidate.z), tol);
    conclude_dense(problem, judged, candidate, method, tol)
}

/// As [`certify`], for a point in the caller's units, which may have no place among doubles in those of the equilibrated problem.
#[must_use]
pub fn certify_callers(
    problem: &Equilibrated<'_>,
    z: Vec<f64>,
    candidate: Candidate,
    method: &'static str,
    tol: f64,
) -> Solution {
    let judged = if problem.is_ordinary && are_ordinary(&z) {
        judge(problem, problem.scaling.z_from_caller(&z), tol)
    } else {
        extreme::judge(problem, z, tol)
    };
    conclude_dense(problem, judged, candidate, method, tol)
}

fn conclude_dense(
    problem: &Equilibrated<'_>,
    judged: Judged,
    mut candidate: Candidate,
    method: &'static str,
    tol: f64,
) -> Solution {
    let ray = candidate.ray.as_ref().map(|ray| ray_to_caller(problem, ray));
    let certificate = if judged.solves {
        None
    } else if let Some(y) = farkas_vector(problem, candidate.farkas.as_deref(), candidate.ray.as_ref()) {
        Some(Certificate::Infeasible { y, exact: None })
    } else {
        let proof = candidate.not_sufficient.take().and_then(|proof| insufficiency(problem, &proof));
        proof.map(Certificate::NotSufficient)
    };
    let solution = conclude(judged, candidate, certificate, method, tol, |i, j| problem.original.row(i)[j]);
    Solution { ray, ..solution }
}

/// The solution from the judgement on its point and the proof, if any, of what else it claims.
fn conclude(
    judged: Judged,
    candidate: Candidate,
    certificate: Option<Certificate>,
    method: &'static str,
    tol: f64,
    entry: impl Fn(usize, usize) -> f64,
) -> Solution {
    let status = match certificate {
        _ if judged.solves => Status::Solved,
        Some(Certificate::Infeasible { .. }) => Status::Infeasible,
        _ => unsolved(candidate.termination),
    };
    let alpha = match candidate.alpha {
        Some(alpha) if judged.solves => alpha,
        _ => (0..judged.z.len()).filter(|&i| judged.z[i] > 0.0).collect(),
    };
    let certificate =
        if judged.solves { Some(Certificate::Solution { alpha: alpha.clone(), exact: None }) } else { certificate };
    Solution {
        message: explain(entry, status, candidate.termination, judged.residual, tol),
        z: judged.z,
        w: judged.w,
        status,
        method,
        iterations: candidate.iterations,
        residual: judged.residual,
        natural_residual: judged.natural_residual,
        alpha,
        certificate,
        ray: None,
        pieces: vec![],
    }
}

/// Recomputes `w`, both residuals and the row tests. Negative entries of `z` are set to zero first.
fn judge(problem: &Equilibrated<'_>, z: Vec<f64>, tol: f64) -> Judged {
    let judged = judge_point(&problem.scaling, max_abs(problem.original.q()), z, tol, None, |z| slack(&problem.lcp, z));
    if problem.is_ordinary && are_ordinary(&judged.z) {
        return judged;
    }
    extreme::judge(problem, judged.z, tol)
}

/// As [`judge`], for any way to compute `w'` and its rounding scale; with floors where A is sparse.
///
/// A point that fails is looked at again without the smaller member of each pair, and then without what is rounding error
/// beside the largest entry, of one solve or after refinement: a degenerate z_i that should be zero, in a row that holds
/// nothing else.
fn judge_point(
    scaling: &Scaling,
    max_q: f64,
    mut z: Vec<f64>,
    tol: f64,
    floors: Option<&Floors>,
    slack: impl Fn(&[f64]) -> (Vec<f64>, Vec<f64>),
) -> Judged {
    for x in &mut z {
        if !x.is_finite() {
            *x = f64::NAN;
        } else if *x <= 0.0 {
            *x = 0.0; // also turns -0 into 0
        }
    }
    if z.iter().any(|x| x.is_nan()) {
        z.fill(0.0); // no iterate worth keeping
    }
    let (w, magnitude) = slack(&z);
    let largest = max_abs(&z);
    let pairs: Vec<f64> = z.iter().zip(&w).map(|(&z, &w)| if z < w { 0.0 } else { z }).collect();
    let without = |noise: f64| pairs.iter().map(|&z| if z <= noise * largest { 0.0 } else { z }).collect();
    let (without_noise, without_dust): (Vec<f64>, Vec<f64>) = (without(NOISE), without(NOISE * NOISE));
    let first = measure(scaling, max_q, z, w, magnitude, tol, floors);
    if first.solves {
        return first;
    }
    let mut seen = scaling.z_from_caller(&first.z);
    for z in [pairs, without_noise, without_dust] {
        if z != seen {
            let (w, magnitude) = slack(&z);
            seen.clone_from(&z);
            let judged = measure(scaling, max_q, z, w, magnitude, tol, floors);
            if judged.solves {
                return judged;
            }
        }
    }
    if first.w.iter().chain(&first.z).all(|x| x.is_finite()) && first.residual.is_finite() {
        return first;
    }
    let z = vec![0.0; first.z.len()];
    let (w, magnitude) = slack(&z);
    measure(scaling, max_q, z, w, magnitude, tol, floors)
}

/// An entry of z below this part of the largest one may be rounding error.
const NOISE: f64 = 1e-13;

/// One point with its `w'` and `m' = |A'||z'| + |q'|`.
fn measure(
    scaling: &Scaling,
    max_q: f64,
    z: Vec<f64>,
    w: Vec<f64>,
    magnitude: Vec<f64>,
    tol: f64,
    floors: Option<&Floors>,
) -> Judged {
    let residual = equilibrated_residual(&z, &w);
    let violation = natural_residual(&z, &w) + slack_error(z.len(), max_abs(&magnitude));
    let floor = |i: usize| floors.map_or(0.0, |floors| floors.of(i, magnitude[i]));
    let rows_hold = (0..z.len()).all(|i| holds_alone(z[i], w[i], magnitude[i], tol, floor(i)));
    let caller_z = scaling.z_to_caller(&z);
    let caller_w = scaling.w_to_caller(&w);
    let magnitude = scaling.w_to_caller(&magnitude);
    let allowed = 10.0 * tol * max_q;
    let rows_agree = caller_z
        .iter()
        .zip(&caller_w)
        .zip(&magnitude)
        .all(|((&z, &w), &m)| z.is_finite() && w.is_finite() && z.min(w).abs() <= allowed + 8.0 * f64::EPSILON * m);
    Judged {
        solves: residual <= tol && violation <= tol.max(ABSOLUTE) && rows_agree && rows_hold,
        residual,
        natural_residual: natural_residual(&caller_z, &caller_w),
        z: caller_z,
        w: caller_w,
    }
}

/// As [`certify`], for a sparse problem and its scaled copy. O(nnz).
#[must_use]
pub fn certify_sparse(
    original: &SparseLcp,
    scaled: &SparseLcp,
    scaling: &Scaling,
    mut candidate: Candidate,
    method: &'static str,
    tol: f64,
) -> Solution {
    let z = std::mem::take(&mut candidate.z);
    let floors = Floors::new(scaled);
    let judged = judge_point(scaling, max_abs(original.q()), z, tol, Some(&floors), |z| scaled.slack(z));
    let farkas = candidate.farkas.as_deref().and_then(normalised).filter(|y| is_sparse_farkas(scaled, y));
    let certificate = farkas.map(|y| Certificate::Infeasible { y: scaling.multiplier_to_caller(&y), exact: None });
    conclude(judged, candidate, certificate, method, tol, |i, j| original.entry(i, j))
}

/// [`is_farkas`] by rows: plain sums, whose rounding is charged to `A'y`.
fn is_sparse_farkas(lcp: &SparseLcp, y: &[f64]) -> bool {
    let n = lcp.n();
    let (mut sums, mut magnitudes) = (vec![0.0; n], vec![0.0; n]);
    for (i, &y) in y.iter().enumerate() {
        let (columns, values) = lcp.row(i);
        for (&j, a) in columns.iter().zip(values) {
            sums[j] += a * y;
            magnitudes[j] += (a * y).abs();
        }
    }
    let rounding = sums.iter().zip(&magnitudes).all(|(&s, m)| s <= 64.0 * f64::EPSILON * m);
    let delta = sums.iter().fold(0.0, |m: f64, &s| m.max(s));
    let (qy, magnitude) = crate::linalg::kernels::dot_compensated(0.0, lcp.q(), y);
    rounding && qy < -64.0 * f64::EPSILON * magnitude && delta * 1e10 <= -qy
}

/// The first candidate that passes [`is_farkas`], in the caller's units.
fn farkas_vector(problem: &Equilibrated<'_>, farkas: Option<&[f64]>, ray: Option<&Ray>) -> Option<Vec<f64>> {
    let ray = ray.map(|ray| ray.z_hat.as_slice());
    let y = [farkas, ray].into_iter().flatten().find_map(|y| normalised(y).filter(|y| is_farkas(problem, y)))?;
    if problem.is_ordinary {
        return Some(problem.scaling.multiplier_to_caller(&y));
    }
    extreme::farkas(problem, &y)
}

/// `y` with negative entries set to zero and `max|y| = 1`.
fn normalised(y: &[f64]) -> Option<Vec<f64>> {
    let largest = max_abs(y);
    (largest.is_finite() && largest > 0.0).then(|| y.iter().map(|y| (y / largest).max(0.0)).collect())
}

/// Whether `y >= 0` proves that no `z >= 0` has `A z + q >= 0`.
///
/// Exactly, `A'y <= 0` and `q'y < 0` are a proof: `0 <= y'(A z + q) <= q'y < 0`. In floating point
/// `(A'y)_j` may exceed 0 by rounding, `delta` say; then every feasible `z` has `sum z >= -q'y / delta`.
/// We ask `delta` to be rounding of its own sum and that bound to exceed 10^10 in equilibrated units.
fn is_farkas(problem: &Equilibrated<'_>, y: &[f64]) -> bool {
    let lcp = &problem.lcp;
    let n = lcp.n();
    let mut column = vec![0.0; n];
    let delta = (0..n)
        .map(|j| {
            for (i, c) in column.iter_mut().enumerate() {
                *c = lcp.a()[i * n + j];
            }
            let (sum, magnitude) = crate::linalg::kernels::dot_compensated(0.0, &column, y);
            if sum <= 64.0 * f64::EPSILON * magnitude { sum.max(0.0) } else { f64::INFINITY }
        })
        .fold(0.0, f64::max);
    let (qy, magnitude) = crate::linalg::kernels::dot_compensated(0.0, lcp.q(), y);
    qy < -64.0 * f64::EPSILON * magnitude && delta * 1e10 <= -qy
}

/// The proof in the caller's units, `x = D_c x'` (`D_r x'` for A'), checked on the caller's numbers: the scaling changes
/// no sign of `x_i (A x)_i`.
fn insufficiency(problem: &Equilibrated<'_>, found: &NotSufficient) -> Option<NotSufficient> {
    let exponents = if found.transposed { &problem.scaling.rows } else { &problem.scaling.columns };
    let found = NotSufficient { x: found.x.times_powers_of_two(exponents), transposed: found.transposed };
    sufficiency::check(problem.original, &found).then_some(found)
}

/// The status of a point that neither solves the problem nor comes with a proof that nothing does.
fn unsolved(termination: Termination) -> Status {
    match termination {
        Termination::SecondaryRay => Status::SecondaryRay,
        Termination::IterationLimit => Status::MaxIterations,
        Termination::TimeLimit | Termination::Interrupted => Status::TimeLimit,
        Termination::ComplementaryBasis
        | Termination::Converged
        | Termination::Infeasible
        | Termination::NotZ { .. }
        | Termination::NotSufficient
        | Termination::Breakdown(_) => Status::NumericalBreakdown,
    }
}

fn ray_to_caller(problem: &Equilibrated<'_>, ray: &Ray) -> Ray {
    let scaling = &problem.scaling;
    let s = |x: f64, e: i32| crate::scaling::times_power_of_two(x, e);
    Ray {
        z: scaling.z_to_caller(&ray.z),
        z0: s(ray.z0, -scaling.q),
        z_hat: scaling.direction_to_caller(&ray.z_hat),
        z0_hat: ray.z0_hat,
        w_hat: ray.w_hat.iter().zip(&scaling.rows).map(|(&w, &r)| s(w, -r)).collect(),
        d: ray.d.iter().zip(&scaling.rows).map(|(&d, &r)| s(d, -r)).collect(),
    }
}

fn explain(
    entry: impl Fn(usize, usize) -> f64,
    status: Status,
    termination: Termination,
    residual: f64,
    tol: f64,
) -> String {
    let why = if residual <= tol {
        format!("residual {residual:.2e}, and a row whose error is too large in the caller's units")
    } else {
        format!("residual {residual:.2e} > tol {tol:.0e}")
    };
    match (status, termination) {
        (Status::Solved, _) => format!("solved: residual {residual:.2e} <= tol {tol:.0e}"),
        (Status::Infeasible, _) => {
            "infeasible: the certificate's y >= 0 has A'y <= 0 and q'y < 0, so no z >= 0 has A z + q >= 0".to_owned()
        }
        (Status::SecondaryRay, _) => "Lemke's method ended on a secondary ray, from which nothing follows for this \
             matrix; try method=\"auto\", another covering vector d, or lcpstar.solutions"
            .to_owned(),
        (Status::MaxIterations, _) => {
            format!("iteration limit reached with {why}; raise max_iterations or try method=\"auto\"")
        }
        (Status::TimeLimit, Termination::Interrupted) => format!("interrupted with residual {residual:.2e}"),
        (Status::TimeLimit, _) => {
            format!("time limit reached with {why}; raise time_limit or tol")
        }
        (_, Termination::NotZ { row, column }) => {
            format!("A is not a Z-matrix: A[{row}, {column}] = {} is positive; try method=\"auto\"", entry(row, column))
        }
        (_, Termination::NotSufficient) => {
            "A is not sufficient: the certificate's x has x_i (A x)_i <= 0 for all i and \
             < 0 for some i (A' where it is y); try method=\"auto\""
                .to_owned()
        }
        (Status::NumericalBreakdown, Termination::Breakdown(reason)) => {
            format!("{reason} (residual {residual:.2e}, tol {tol:.0e}); try method=\"auto\" or certify=\"exact\"")
        }
        (Status::NumericalBreakdown, _) => format!(
            "the method finished, but its point has {why} on the caller's data; \
             try method=\"auto\", a larger tol, or certify=\"exact\""
        ),
    }
}

#[cfg(test)]
mod fast_verdicts;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Lcp;

    fn verdict(a: &[f64], q: &[f64], z: &[f64], tol: f64) -> Solution {
        let lcp = Lcp::new(q.len(), a.to_vec(), q.to_vec()).expect("valid");
        let problem = Equilibrated::new(&lcp);
        let z = problem.scaling.z_from_caller(z);
        certify(&problem, Candidate::point(z, Termination::Converged, 0), "test", tol)
    }

    #[test]
    fn a_claim_without_substance_is_not_believed() {
        assert_eq!(verdict(&[2.0], &[-1.0], &[0.5], 1e-9).status, Status::Solved);
        assert_eq!(verdict(&[2.0], &[-1.0], &[0.5 + 1e-6], 1e-9).status, Status::NumericalBreakdown);
        assert_eq!(verdict(&[2.0], &[-1.0], &[0.0], 1e-9).status, Status::NumericalBreakdown);
        let nan = verdict(&[2.0], &[-1.0], &[f64::NAN], 1e-9);
        assert_eq!((nan.status, nan.z[0]), (Status::NumericalBreakdown, 0.0));
    }

    /// Each view of a point refuses one that all others accept.
    #[test]
    fn every_view_counts() {
        let solved = |a: &[f64], q: &[f64], z: &[f64]| verdict(a, q, z, 1e-9).status == Status::Solved;
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
        let columns = (0..n).flat_map(|_| 0..n).collect();
        let sparse = SparseLcp::new((0..=n).map(|i| i * n).collect(), columns, a.to_vec(), q.to_vec()).expect("valid");
        let scaling = Scaling::of_sparse(&sparse);
        let scaled = sparse.scaled(&scaling);
        let found = certify_sparse(&sparse, &scaled, &scaling, candidate.clone(), "test", 1e-9);
        let is = |solution: Solution| solution.status == Status::Infeasible;
        (is(certify(&problem, candidate, "test", 1e-9)), is(found))
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
            assert_eq!(certify(&problem, candidate, "test", 1e-9).certificate.is_some(), holds);
        }
    }

    #[test]
    fn a_row_of_a_sparse_matrix_that_q_fills_is_no_tail() {
        let certified = |q: [f64; 2], z: [f64; 2]| {
            let lcp =
                SparseLcp::new(vec![0, 2, 4], vec![0, 1, 0, 1], vec![1.0, -0.5, -0.5, 1.0], q.to_vec()).expect("valid");
            let scaling = Scaling::of_sparse(&lcp);
            let candidate = Candidate::point(scaling.z_from_caller(&z), Termination::Converged, 0);
            certify_sparse(&lcp, &lcp.scaled(&scaling), &scaling, candidate, "test", 1e-9).status == Status::Solved
        };
        // z_2 of 1e-16 beside 1 may be cut off where its row says so; not where q_2 does.
        assert!(certified([-1.0, 0.5 - 1e-16], [1.0, 0.0]));
        assert!(!certified([1.0, -1e-16], [0.0, 0.0]));
    }

    #[test]
    fn a_badly_scaled_row_cannot_hide() {
        // Row 2 is a million times smaller: its error of 100 % must still be seen.
        let (a, q) = ([1.0, 0.0, 0.0, 1e-6], [-1.0, -1e-6]);
        assert_eq!(verdict(&a, &q, &[1.0, 1.0], 1e-9).status, Status::Solved);
        assert_ne!(verdict(&a, &q, &[1.0, 0.0], 1e-6).status, Status::Solved);
    }

    #[test]
    fn a_message_never_says_that_a_small_residual_is_above_tol() {
        // w_2 = 1e16 - 1 beside z_2 = 1, in a row of a point of size 1e16.
        let found = verdict(&[0.0, 1.0, 1.0, 0.0], &[-1.0, -1.0], &[1e16, 1.0], 1e-9);
        assert_eq!(found.status, Status::NumericalBreakdown);
        assert!(found.residual <= 1e-9 && !found.message.contains(" > tol"), "{}", found.message);
    }

    #[test]
    fn a_z_beside_which_nobody_sees_q_solves_nothing() {
        // w = A z + q = q exactly, but for what rounding adds.
        let a = [1.0, -1.0, 1.0, -1.0];
        for size in [1e12, 1e25, 1e100] {
            let found = verdict(&a, &[-1.0, -1.0], &[size, size], 1e-9);
            assert_ne!(found.status, Status::Solved, "{size}");
        }
    }

    #[test]
    fn a_farkas_vector_is_checked() {
        let lcp = Lcp::new(2, vec![1.0, -1.0, -1.0, 1.0], vec![-1.0, -1.0]).expect("valid");
        let problem = Equilibrated::new(&lcp);
        let mut candidate = Candidate::point(vec![0.0; 2], Termination::Infeasible, 0);
        candidate.farkas = Some(vec![1.0, 1.0]);
        assert_eq!(certify(&problem, candidate.clone(), "test", 1e-9).status, Status::Infeasible);
        candidate.farkas = Some(vec![1.0, 0.999]);
        assert_eq!(certify(&problem, candidate, "test", 1e-9).status, Status::NumericalBreakdown);
    }
}
