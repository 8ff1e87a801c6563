//! `certify="exact"`: an answer found in floating point is proved in rational arithmetic, repaired, or left unproved.
//!
//! The exact methods are exact by construction. What they find is put into the caller's problem all the same before it is
//! said ([`check_farkas`], [`check_solution`]): one look at the numbers, whatever became of them on the way. Only the equations
//! of a basis that [`prove_solution`] accepts are not: the p-adic solve has proved them.

use crate::certify::certify_callers;
use crate::control::Control;
use crate::exact::dyadic::RationalVec;
use crate::exact::face::{prove_by_programme, prove_tight};
use crate::exact::farkas::{check_farkas, repair_farkas};
use crate::exact::feasibility::Feasibility;
use crate::exact::proof::{ExactSolution, ProofOutcome, check_solution, prove_solution};
use crate::exact::ray::prove_ray;
use crate::exact::repair::{self, Repaired};
use crate::linalg::dd::Dd;
use crate::linalg::kernels::max_abs;
use crate::methods::{feasibility, lemke};
use crate::residual::slack;
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
            if let Some(exact) = solution_near(problem, &solution, control, &stop) {
                return proved(problem, &solution, exact, tol);
            }
            if let Feasibility::Infeasible(exact) = exact_feasibility(problem, control)
                && check_farkas(lcp, &exact)
            {
                let residual = solution.residual;
                let mut solution = infeasible(solution, exact);
                solution.message.push_str(&format!("; z solves it only up to a residual of {residual:.2e}"));
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
                Feasibility::Infeasible(exact) if check_farkas(lcp, &exact) => return infeasible(solution, exact),
                Feasibility::Feasible(_) => {
                    // Feasible by less than rounding: the floating-point verdict was wrong.
                    solution.status = Status::NumericalBreakdown;
                    solution.certificate = None;
                    solution.message = "feasible by less than rounding, and no solution was proved".to_owned();
                    return by_exact_path(problem, solution, tol, &stop);
                }
                Feasibility::Infeasible(_) | Feasibility::Interrupted => {}
            }
        }
        Status::SecondaryRay | Status::MaxIterations | Status::NumericalBreakdown => {
            if let Feasibility::Infeasible(exact) = exact_feasibility(problem, control)
                && check_farkas(lcp, &exact)
            {
                return infeasible(solution, exact);
            }
            return by_exact_path(problem, solution, tol, &stop);
        }
        Status::TimeLimit => {}
    }
    solution.message.push_str("; not proved: the limits were reached, or the exact path from this basis ends on a ray");
    solution
}

/// A proof that the problem has a solution near `solution` or none at all; failing both, `solution` is not called one.
pub(super) fn or_withdrawn(
    problem: &Equilibrated<'_>,
    solution: Solution,
    tol: f64,
    control: &Control<'_>,
) -> Solution {
    let residual = solution.residual;
    let mut solution = prove(problem, solution, tol, control);
    let unproved = !matches!(
        solution.certificate,
        Some(Certificate::Solution { exact: Some(_), .. } | Certificate::Infeasible { exact: Some(_), .. })
    );
    if unproved {
        solution.status = Status::NumericalBreakdown;
        solution.certificate = None;
        solution.message = format!(
            "only rounding decides whether this is a solution: residual {residual:.2e}, and no exact solution was found \
             near it; try lcpstar.solutions"
        );
    }
    solution
}

/// An exact solution next to `solution`: at its basis; on its support with the rows that are tight; at the basis that
/// Lemke's method in double-doubles reaches from there; on its face; or where exact pivoting ends. Each is checked exactly.
fn solution_near(
    problem: &Equilibrated<'_>,
    solution: &Solution,
    control: &Control<'_>,
    stop: &dyn Fn() -> bool,
) -> Option<ExactSolution> {
    let lcp = problem.original;
    if let ProofOutcome::Proved(exact) = prove_solution(lcp, &solution.alpha, stop) {
        return Some(exact);
    }
    let near = Near::new(problem, solution);
    let found =
        near.tight_rows(stop).or_else(|| near.double_double_path(control, stop)).or_else(|| near.programmes()).or_else(
            || match repair::repair(lcp, &solution.alpha, stop) {
                Repaired::Solved(exact, _) => Some(exact),
                Repaired::Ray(_) | Repaired::Interrupted => None,
            },
        );
    found.filter(|exact| check_solution(lcp, &exact.z))
}

/// A point that solves the problem to rounding, and where an exact solution is looked for.
struct Near<'a> {
    problem: &'a Equilibrated<'a>,
    solution: &'a Solution,
    /// On the equilibrated problem.
    z: Vec<f64>,
    w: Vec<f64>,
}

/// What counts as zero on the equilibrated problem, one guess after the other, times `max(1, max|z|)`.
const ZEROS: [f64; 3] = [1e-14, 1e-11, 1e-8];
/// Largest order for exact linear programmes, and the number of index sets tried.
const PROGRAMMES_UP_TO: usize = 16;
const PROGRAMMES: u32 = 64;

impl<'a> Near<'a> {
    fn new(problem: &'a Equilibrated<'a>, solution: &'a Solution) -> Self {
        let z = problem.scaling.z_from_caller(&solution.z);
        let w = slack(&problem.lcp, &z).0;
        Self { problem, solution, z, w }
    }

    /// `(support, tight rows)` for each guess of what is zero.
    fn guesses(&self) -> impl Iterator<Item = (Vec<usize>, Vec<usize>)> {
        let size = max_abs(&self.z).max(1.0);
        let below = |v: &[f64], zero: f64| (0..v.len()).filter(|&i| v[i].abs() <= zero * size).collect();
        let mut guesses: Vec<(Vec<usize>, Vec<usize>)> = ZEROS
            .iter()
            .map(|&zero| ((0..self.z.len()).filter(|&i| self.z[i] > zero * size).collect(), below(&self.w, zero)))
            .collect();
        guesses.dedup();
        guesses.into_iter()
    }

    fn tight_rows(&self, stop: &dyn Fn() -> bool) -> Option<ExactSolution> {
        self.guesses()
            .find_map(|(support, tight)| prove_tight(self.problem.original, &self.solution.z, &support, &tight, stop))
    }

    /// Differences that doubles cannot see decide the basis of a degenerate solution: q is exact data, and its last bits
    /// say which of the pairs that vanish to rounding are basic.
    fn double_double_path(&self, control: &Control<'_>, stop: &dyn Fn() -> bool) -> Option<ExactSolution> {
        let control = control.with_max_iterations(None);
        let found = lemke::lemke_from::<Dd>(&self.problem.lcp, &self.solution.alpha, &control);
        match prove_solution(self.problem.original, &found.alpha?, stop) {
            ProofOutcome::Proved(exact) => Some(exact),
            _ => None,
        }
    }

    /// Every way to choose w or z for the pairs that vanish, a linear programme for each: only for small problems.
    fn programmes(&self) -> Option<ExactSolution> {
        if self.z.len() > PROGRAMMES_UP_TO {
            return None;
        }
        self.guesses().find_map(|(support, tight)| {
            let open: Vec<usize> = tight.into_iter().filter(|i| !support.contains(i)).collect();
            let sets = 1u32.checked_shl(open.len() as u32).unwrap_or(u32::MAX).min(PROGRAMMES);
            (0..sets).find_map(|set| {
                let chosen = open.iter().enumerate().filter(|(t, _)| set >> t & 1 == 1).map(|(_, &i)| i);
                let alpha: Vec<usize> = support.iter().copied().chain(chosen).collect();
                prove_by_programme(self.problem.original, &alpha)
            })
        })
    }
}

/// Lemke's method in exact arithmetic from the best basis; its ray is proved when that is how it ends.
fn by_exact_path(problem: &Equilibrated<'_>, mut solution: Solution, tol: f64, stop: &dyn Fn() -> bool) -> Solution {
    let lcp = problem.original;
    if let Repaired::Solved(exact, pivots) = repair::repair(lcp, &solution.alpha, stop)
        && check_solution(lcp, &exact.z)
    {
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
    let candidate = Candidate {
        alpha: Some(exact.alpha.clone()),
        ..Candidate::point(vec![], Termination::ComplementaryBasis, found.iterations)
    };
    let mut solution = certify_callers(problem, exact.z.to_f64(), candidate, found.method, tol);
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
    crate::exact::feasibility::feasibility(problem.original, &found.rho, &found.beta, &|| control.expired().is_some())
}
