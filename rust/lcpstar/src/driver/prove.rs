//! `certify="exact"`: an answer found in floating point is proved in rational arithmetic, repaired, or left unproved.
//!
//! The exact methods are exact by construction. What they find is put into the caller's problem all the same before it is
//! said ([`Farkas::new`], [`check_solution`]): one look at the numbers, whatever became of them on the way. Only the equations
//! of a basis that [`prove_solution`] accepts are not: the p-adic solve has proved them.

use super::settings::{Certify, Settings};
use crate::control::Control;
use crate::cutovers::PROGRAMMES_UP_TO;
use crate::equilibrate::{Equilibrated, Rows};
use crate::exact::face::{prove_by_programme, prove_tight};
use crate::exact::feasibility::{Feasibility, feasibility as exact_feasibility};
use crate::exact::proof::{ExactSolution, ProofOutcome, check_solution, prove_solution};
use crate::exact::ray::prove_ray;
use crate::exact::repair::{self, Repaired};
use crate::judge::proved;
use crate::linalg::dd::Dd;
use crate::linalg::kernels::max_abs;
use crate::member::Member;
use crate::methods::{feasibility, lemke};
use crate::problem::Lcp;
use crate::refute::{Farkas, Refutation};
use crate::residual::slack;
use crate::solution::Solution;
use crate::status::{Status, Termination};
use crate::verdict::{Aside, Certificate, Evidence, Verdict};

/// Proves `solution` on the given binary numbers.
///
/// A solved problem: the support is solved exactly and every sign checked; if the basis was wrong, exact pivoting from
/// it finds the right one. An infeasible one is proved already. Anything else: exact feasibility, then Lemke's
/// method in exact arithmetic. `certificate.exact` says whether it succeeded within the limits of `control`.
pub(super) fn prove<P: Rows>(
    problem: &Equilibrated<'_, P>,
    mut solution: Solution,
    settings: &Settings,
    control: &Control<'_>,
) -> Solution {
    let (tol, asked) = (settings.tol, settings.certify == Certify::Exact);
    let Some(lcp) = problem.original.dense() else { return solution };
    let stop = || control.expired().is_some();
    match solution.status() {
        Status::Infeasible => return solution,
        Status::TimeLimit => {}
        Status::Solved => {
            if let Some(exact) = solution_near(&lcp, &solution, control, &stop) {
                return proved(problem, exact, &solution, tol, asked);
            }
            if let Some(farkas) = exact_farkas(&lcp, control) {
                let residual = solution.residual;
                let mut solution = infeasible(solution, farkas);
                solution.message.push_str(&format!("; z solves it only up to a residual of {residual:.2e}"));
                return solution;
            }
        }
        Status::NearlyInfeasible | Status::SecondaryRay | Status::MaxIterations | Status::NumericalBreakdown => {
            if let Some(farkas) = exact_farkas(&lcp, control) {
                return infeasible(solution, farkas);
            }
            return by_exact_path(problem, &lcp, solution, settings, &stop);
        }
    }
    solution.message.push_str("; not proved: the limits were reached, or the exact path from this basis ends on a ray");
    solution
}

/// A proof that the problem has a solution near `solution` or none at all; failing both, `solution` is not called one.
pub(super) fn or_withdrawn<P: Rows>(
    problem: &Equilibrated<'_, P>,
    solution: Solution,
    settings: &Settings,
    control: &Control<'_>,
) -> Solution {
    let residual = solution.residual;
    let mut solution = prove(problem, solution, settings, control);
    let is_proved = matches!(
        solution.certificate(),
        Some(Certificate::Solution { exact: Some(_), .. } | Certificate::Infeasible { .. })
    );
    if !is_proved {
        let termination = control.expired().unwrap_or(Termination::Breakdown("only rounding decides"));
        solution.verdict = Verdict::of(Evidence::Stopped(termination, None));
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
    lcp: &Lcp,
    solution: &Solution,
    control: &Control<'_>,
    stop: &dyn Fn() -> bool,
) -> Option<ExactSolution> {
    if let ProofOutcome::Proved(exact) = prove_solution(lcp.view(), &solution.alpha, stop) {
        return Some(exact);
    }
    let near = Near::new(lcp, solution);
    let found =
        near.tight_rows(stop).or_else(|| near.double_double_path(control, stop)).or_else(|| near.programmes()).or_else(
            || match repair::repair(lcp.view(), &solution.alpha, stop) {
                Repaired::Solved(exact, _) => Some(exact),
                Repaired::Ray(_) | Repaired::Interrupted => None,
            },
        );
    found.filter(|exact| check_solution(lcp.view(), &exact.z))
}

/// A point that solves the problem to rounding, and where an exact solution is looked for.
struct Near<'a> {
    problem: Equilibrated<'a>,
    solution: &'a Solution,
    /// On the equilibrated problem.
    z: Vec<f64>,
    w: Vec<f64>,
}

/// What counts as zero on the equilibrated problem, one guess after the other, times `max(1, max|z|)`.
const ZEROS: [f64; 3] = [1e-14, 1e-11, 1e-8];
const PROGRAMMES: u32 = 64;

impl<'a> Near<'a> {
    fn new(lcp: &'a Lcp, solution: &'a Solution) -> Self {
        let problem = Equilibrated::new(lcp);
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
        self.guesses().find_map(|(support, tight)| {
            prove_tight(self.problem.original.view(), &self.solution.z, &support, &tight, stop)
        })
    }

    /// Differences that doubles cannot see decide the basis of a degenerate solution: q is exact data, and its last bits
    /// say which of the pairs that vanish to rounding are basic.
    fn double_double_path(&self, control: &Control<'_>, stop: &dyn Fn() -> bool) -> Option<ExactSolution> {
        let control = control.with_max_iterations(None);
        let found = lemke::lemke_from::<Dd>(&self.problem.lcp, &self.solution.alpha, &control);
        match prove_solution(self.problem.original.view(), &found.alpha?, stop) {
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
                prove_by_programme(self.problem.original.view(), &alpha)
            })
        })
    }
}

/// Lemke's method in exact arithmetic from the best basis; its ray is proved when that is how it ends.
fn by_exact_path<P: Rows>(
    problem: &Equilibrated<'_, P>,
    lcp: &Lcp,
    mut solution: Solution,
    settings: &Settings,
    stop: &dyn Fn() -> bool,
) -> Solution {
    if let Repaired::Solved(exact, pivots) = repair::repair(lcp.view(), &solution.alpha, stop)
        && check_solution(lcp.view(), &exact.z)
    {
        solution.iterations += pivots;
        solution.method = Member::ExactLemke;
        return proved(problem, exact, &solution, settings.tol, settings.certify == Certify::Exact);
    }
    if let Some(ray) = &solution.ray
        && solution.status() == Status::SecondaryRay
        && let Some(exact) = prove_ray(lcp.view(), &ray.d, &ray.z_hat, ray.z0_hat, stop)
    {
        solution.verdict = Verdict::of(Evidence::Stopped(Termination::SecondaryRay, Some(Aside::Ray(exact.z))));
    }
    solution
}

pub(super) fn infeasible(mut solution: Solution, farkas: Farkas) -> Solution {
    solution.verdict = Verdict::of(Evidence::Refuted(Refutation::Exact(farkas)));
    solution.message = "infeasible, proved in exact arithmetic: y >= 0, A'y <= 0, q'y < 0".to_owned();
    solution
}

/// A Farkas vector: the simplex method in doubles proposes a basis, exact pivoting decides from it.
pub(super) fn exact_farkas(lcp: &Lcp, control: &Control<'_>) -> Option<Farkas> {
    let control = control.with_max_iterations(None);
    let found = feasibility::feasibility(&Equilibrated::new(lcp).lcp, &control);
    match exact_feasibility(lcp.view(), &found.rho, &found.beta, &|| control.expired().is_some()) {
        Feasibility::Infeasible(y) => Farkas::new(lcp, y),
        Feasibility::Feasible(_) | Feasibility::Interrupted => None,
    }
}
