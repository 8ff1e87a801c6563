//! `certify="exact"`: an answer found in floating point is proved in rational arithmetic, repaired, or left unproved.

use crate::certify::certify;
use crate::control::Control;
use crate::exact::dyadic::RationalVec;
use crate::exact::proof::{ExactSolution, ProofOutcome, prove_near, prove_ray, prove_solution, repair_farkas};
use crate::exact::repair::{self, Feasibility, Repaired};
use crate::methods::feasibility;
use crate::problem::Lcp;
use crate::scaling::Equilibrated;
use crate::solution::{Candidate, Certificate, Solution};
use crate::status::{Status, Termination};

/// Proves `solution` on the given binary numbers.
///
/// A solved problem: the support is solved exactly and every sign checked; if the basis was wrong, exact pivoting from
/// it finds the right one. An infeasible one: an exact Farkas vector. Anything else: exact feasibility, then Lemke's
/// method in exact arithmetic. `certificate.exact` says whether it succeeded within the limits of `control`.
pub(super) fn prove(problem: &Equilibrated<'_>, mut solution: Solution, tol: f64, control: &Control<'_>) -> Solution {
    let lcp = problem.original;
    let stop = || control.expired().is_some();
    match solution.status {
        Status::Solved => {
            if let Some(exact) = solution_near(lcp, &solution, &stop) {
                return proved(problem, &solution, exact, tol);
            }
            if let Feasibility::Infeasible(_) = exact_feasibility(problem, control) {
                solution
                    .message
                    .push_str("; not proved: on these binary numbers FEA(q, A) is empty, by less than rounding");
                return solution;
            }
        }
        Status::Infeasible => {
            if let Some(Certificate::Infeasible { y, .. }) = &solution.certificate
                && let Some(exact) = repair_farkas(lcp, y, &stop)
            {
                return infeasible(solution, exact);
            }
            match exact_feasibility(problem, control) {
                Feasibility::Infeasible(exact) => return infeasible(solution, exact),
                Feasibility::Feasible(_) => {
                    // Feasible by less than rounding: the floating-point verdict was wrong.
                    solution.status = Status::NumericalBreakdown;
                    solution.certificate = None;
                    solution.message = "feasible by less than rounding, and no solution was proved".to_owned();
                    return by_exact_path(problem, solution, tol, &stop);
                }
                Feasibility::Interrupted => {}
            }
        }
        Status::SecondaryRay | Status::MaxIterations | Status::NumericalBreakdown => {
            if let Feasibility::Infeasible(exact) = exact_feasibility(problem, control) {
                return infeasible(solution, exact);
            }
            return by_exact_path(problem, solution, tol, &stop);
        }
        Status::TimeLimit => {}
    }
    solution.message.push_str("; not proved: the limits were reached, or the exact path from this basis ends on a ray");
    solution
}

/// The exact solution at the basis of `solution`, or the one that exact pivoting from it reaches.
fn solution_near(lcp: &Lcp, solution: &Solution, stop: &dyn Fn() -> bool) -> Option<ExactSolution> {
    if let ProofOutcome::Proved(exact) = prove_solution(lcp, &solution.alpha, stop) {
        return Some(exact);
    }
    if let ProofOutcome::Proved(exact) = prove_near(lcp, &solution.z, stop) {
        return Some(exact);
    }
    match repair::repair(lcp, &solution.alpha, stop) {
        Repaired::Solved(exact, _) => Some(exact),
        Repaired::Ray(_) | Repaired::Interrupted => None,
    }
}

/// Lemke's method in exact arithmetic from the best basis; its ray is proved when that is how it ends.
fn by_exact_path(problem: &Equilibrated<'_>, mut solution: Solution, tol: f64, stop: &dyn Fn() -> bool) -> Solution {
    let lcp = problem.original;
    if let Repaired::Solved(exact, pivots) = repair::repair(lcp, &solution.alpha, stop) {
        solution.iterations += pivots;
        solution.method = "exact_lemke";
        return proved(problem, &solution, exact, tol);
    }
    if let Some(ray) = &solution.ray
        && let Some(exact) = prove_ray(lcp, &ray.d, &ray.z_hat, ray.z0_hat, stop)
    {
        solution.certificate = Some(Certificate::Ray { z_hat: exact.z });
    }
    solution
}

/// The verdict on the exact solution, rounded to doubles, with the exact numbers as certificate.
fn proved(problem: &Equilibrated<'_>, found: &Solution, exact: ExactSolution, tol: f64) -> Solution {
    let z = problem.scaling.z_from_caller(&exact.z.to_f64());
    let candidate = Candidate {
        alpha: Some(exact.alpha.clone()),
        ..Candidate::point(z, Termination::ComplementaryBasis, found.iterations)
    };
    let mut solution = certify(problem, candidate, found.method, tol);
    let how = if solution.status == Status::Solved {
        "; proved in exact arithmetic"
    } else {
        "; the exact solution in the certificate is proved, but its rounding to doubles exceeds tol"
    };
    solution.message.push_str(how);
    solution.certificate = Some(Certificate::Solution { alpha: exact.alpha, exact: Some(exact.z) });
    solution
}

fn infeasible(mut solution: Solution, exact: RationalVec) -> Solution {
    solution.status = Status::Infeasible;
    solution.message = "infeasible, proved in exact arithmetic: y >= 0, A'y <= 0, q'y < 0".to_owned();
    solution.certificate = Some(Certificate::Infeasible { y: exact.direction_to_f64(), exact: Some(exact) });
    solution
}

/// The simplex method in doubles proposes a basis, exact pivoting decides from it.
fn exact_feasibility(problem: &Equilibrated<'_>, control: &Control<'_>) -> Feasibility {
    let control = control.with_max_iterations(None);
    let found = feasibility::feasibility(&problem.lcp, &control);
    repair::feasibility(problem.original, &found.rho, &found.beta, &|| control.expired().is_some())
}
