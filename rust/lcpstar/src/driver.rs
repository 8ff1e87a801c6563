//! One problem in, one verified solution out: equilibrate, run a method or the portfolio, certify.

mod anytime;
mod approximate;
pub(crate) mod doubt;
mod interior_point;
mod parts;
mod pieces;
mod polish;
mod portfolio;
mod prove;
mod settings;
mod small;
mod start;

use crate::control::Control;
use crate::cutovers::DENSE_UP_TO;
use crate::equilibrate::{Equilibrated, Rows};
use crate::error::{LcpError, Result};
use crate::judge::{judge, without_tails};
use crate::member::Member;
use crate::methods::{bilinear, block_pivoting, chandrasekaran, enumerate, lemke, lemke_howson, potential_reduction};
use crate::pivoting::basis::basic_point;
use crate::problem::Lcp;
use crate::residual::slack;
use crate::scaling::{exponent, times_power_of_two};
use crate::small::TINY_ORDER;
use crate::solution::{Candidate, Solution};
use crate::sparse::SparseLcp;
use crate::status::{Status, Termination};

pub use settings::{Approximate, Certify, DEFAULT_RESTARTS, Method, Settings};
use settings::{check, check_common};
use start::{at_once, support, trivial};

/// Solves LCP(q, A) and verifies the answer against the caller's numbers.
///
/// # Errors
/// Only for a broken promise of the caller: a wrong length, a number that is not finite, an option out of range.
pub fn solve(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Result<Solution> {
    match solve_briefly(lcp, settings, control) {
        Some(solution) => Ok(solution),
        None => solve_at_length(lcp, settings, control),
    }
}

/// The first step of [`solve`]: the kernel for small problems, microseconds up to order [`BRIEF_UP_TO`](crate::cutovers::BRIEF_UP_TO). `None` says nothing
/// about the problem or the settings.
#[must_use]
pub fn solve_briefly(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    small::solve(lcp, settings, control)
}

/// The first step of [`solve`] where a guess is given: what that and a few exchanges solve. `None` says nothing about the problem
/// or the settings.
pub(crate) fn solve_from_guess(lcp: &Lcp, settings: &Settings) -> Option<Solution> {
    small::from_guess(lcp, settings)
}

/// What follows in [`solve`].
///
/// # Errors
/// As [`solve`].
pub fn solve_at_length(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Result<Solution> {
    check(lcp, settings)?;
    let problem = Equilibrated::new(lcp);
    let solution = match at_once(&problem, settings) {
        Some(solution) => solution,
        None => {
            let solution = by_method(&problem, settings, control)?;
            polish::polished(&problem, &solution, settings.tol, control).unwrap_or(solution)
        }
    };
    let is_auto = matches!(settings.method, Method::Auto);
    if is_auto && doubt::hides_q(lcp, &solution) {
        return Ok(prove::or_withdrawn(&problem, solution, settings, control));
    }
    if is_auto && doubt::is_undecided(&solution) {
        let decided = prove::prove(&problem, solution.clone(), settings, control);
        let is_answer = matches!(decided.status(), Status::Solved | Status::Infeasible);
        return Ok(if is_answer { decided } else { solution });
    }
    Ok(finished(&problem, solution, settings, control))
}

/// The end of the road: a proof where one is asked for, advice where a method by name gave no answer.
fn finished<P: Rows>(
    problem: &Equilibrated<'_, P>,
    mut solution: Solution,
    settings: &Settings,
    control: &Control<'_>,
) -> Solution {
    solution = without_tails(problem, solution, settings.tol);
    if settings.certify == Certify::Exact {
        solution = prove::prove(problem, solution, settings, control);
    }
    let has_answer = matches!(solution.status(), Status::Solved | Status::Infeasible);
    if !has_answer && !matches!(settings.method, Method::Auto) {
        solution.message.push_str("; method=\"auto\" tries others");
    }
    solution
}

fn by_method(problem: &Equilibrated<'_>, settings: &Settings, control: &Control<'_>) -> Result<Solution> {
    let lcp = problem.original;
    let scaled = &problem.lcp;
    Ok(match &settings.method {
        Method::Auto => anytime::auto(problem, settings, control),
        Method::PrincipalPivoting => portfolio::principal_pivoting(problem, settings.tol, control),
        Method::Chandrasekaran => {
            judge(problem, chandrasekaran::chandrasekaran(scaled, control), Member::Chandrasekaran, settings.tol)
        }
        Method::Enumerate => judge(problem, enumerate::enumerate(scaled, control), Member::Enumerate, settings.tol),
        Method::Lemke { settings: options, restarts, seed } => match &options.d {
            Some(d) => {
                let options = lemke::Settings { d: Some(covering_vector(problem, d)) };
                judge(problem, lemke::lemke::<f64>(scaled, &options, control), Member::Lemke, settings.tol)
            }
            None => portfolio::lemke(problem, *restarts, *seed, settings, control),
        },
        Method::LemkeHowson(options) => {
            judge(problem, lemke_howson::lemke_howson(scaled, options, control), Member::LemkeHowson, settings.tol)
        }
        Method::Bilinear(options) => {
            judge(problem, bilinear::bilinear(scaled, options, control), Member::Bilinear, settings.tol)
        }
        Method::BlockPivoting(options) => {
            let mut options = options.clone();
            options.alpha = options.alpha.or_else(|| settings.z0.as_deref().map(support));
            judge(
                problem,
                block_pivoting::block_pivoting(scaled, &options, control),
                Member::BlockPivoting,
                settings.tol,
            )
        }
        Method::InteriorPoint(options) => {
            let found = interior_point::dense(problem, settings, options, control);
            let solution = judge(problem, found, Member::InteriorPoint, settings.tol);
            if options.finish { portfolio::finished_by_pivots(problem, solution, settings, control) } else { solution }
        }
        Method::PotentialReduction(options) => {
            let stop = potential_reduction::Stop::Residual(settings.tol);
            let options = potential_reduction::Settings { stop, ..options.clone() };
            let z0 = settings.z0.as_deref().filter(|z0| potential_reduction::is_strictly_feasible(lcp, z0));
            reduce_potential(problem, z0, &options, control, settings.tol, |_| ())?
        }
        Method::Approximate(method) => approximate::solve(problem, settings, method, control),
    })
}

/// Names of the methods that take a sparse A.
pub const SPARSE_METHODS: &[&str] = &["auto", "interior_point", "newton", "pgs", "pgs_sm", "nncg", "apgd", "admm"];

/// Solves a sparse LCP and verifies the answer. Up to order [`TINY_ORDER`] the matrix is made dense and every method of [`solve`] is at
/// hand; above, `"auto"` is the interior point method on `D A D`.
///
/// # Errors
/// `UnknownName` for a method that takes no sparse A of that order; `OutOfRange` for `tol` and options; `WrongLength`, `NotFinite` or
/// `Negative` for `z0`; `TooLarge` for an exact proof beyond [`DENSE_UP_TO`], because it is made on a dense copy.
pub fn solve_sparse(lcp: &SparseLcp, settings: &Settings, control: &Control<'_>) -> Result<Solution> {
    let takes_sparse = matches!(settings.method, Method::Auto | Method::InteriorPoint(_) | Method::Approximate(_));
    if !takes_sparse {
        let value = "one that needs a dense A".to_owned();
        return Err(LcpError::UnknownName { name: "method", value, choices: SPARSE_METHODS });
    }
    if lcp.n() <= TINY_ORDER {
        return solve(&lcp.to_dense(), settings, control);
    }
    check_common(lcp.n(), settings)?;
    if settings.certify == Certify::Exact && lcp.n() > DENSE_UP_TO {
        let name = "certify=\"exact\" with a sparse A, which is proved on a dense copy,";
        return Err(LcpError::TooLarge { name, n: lcp.n(), limit: DENSE_UP_TO });
    }
    let problem = Equilibrated::new(lcp);
    let solution = match (&settings.method, trivial(&problem, settings.tol)) {
        (_, Some(solution)) => solution,
        (Method::Approximate(method), None) => approximate::solve(&problem, settings, method, control),
        (method, None) => {
            let options = if let Method::InteriorPoint(options) = method { options } else { &Default::default() };
            interior_point::sparse(&problem, settings, options, control)
        }
    };
    Ok(finished(&problem, solution, settings, control))
}

/// The paper's potential reduction method with its own stopping rule; `trace` receives each row of its table.
///
/// The tolerance of the verdict follows from the rule: `z'w <= eps` bounds every `min(z_i, w_i)` by `sqrt(eps)`, and
/// that is what "solved" asks of the equilibrated residual (at most `1e-2`).
///
/// # Errors
/// `OutOfRange` for a parameter; `WrongLength`, `NotFinite` or `NotStrictlyFeasible` for `z0`.
pub fn potential_reduction(
    lcp: &Lcp,
    z0: Option<&[f64]>,
    settings: &potential_reduction::Settings,
    control: &Control<'_>,
    trace: impl FnMut(potential_reduction::Record),
) -> Result<Solution> {
    let tol = match settings.stop {
        potential_reduction::Stop::Gap(eps) => eps.sqrt().min(1e-2),
        potential_reduction::Stop::Residual(tol) => tol,
    };
    reduce_potential(&Equilibrated::new(lcp), z0, settings, control, tol, trace)
}

fn reduce_potential(
    problem: &Equilibrated<'_>,
    z0: Option<&[f64]>,
    settings: &potential_reduction::Settings,
    control: &Control<'_>,
    tol: f64,
    trace: impl FnMut(potential_reduction::Record),
) -> Result<Solution> {
    let found = potential_reduction::potential_reduction(problem.original, z0, settings, control, trace)?;
    let stopped = found.termination == Termination::Converged;
    let z = problem.scaling.z_from_caller(&found.z);
    // The stop bounds min(z_i, w_i) by the root of z'w, which is no small part of a row where both vanish at the solution. Where
    // the judge says so, the basis that the point tells of is tried.
    let w = slack(&problem.lcp, &z).0;
    let alpha: Vec<usize> = (0..z.len()).filter(|&i| z[i] >= w[i]).collect();
    let solution = judge(problem, Candidate { z, ..found }, Member::PotentialReduction, tol);
    if !stopped || solution.is_solved() {
        return Ok(solution);
    }
    let Some(z) = basic_point(&problem.lcp, &alpha) else { return Ok(solution) };
    let basic = Candidate::point(z, Termination::ComplementaryBasis, solution.iterations);
    let basic = judge(problem, Candidate { alpha: Some(alpha), ..basic }, Member::PotentialReduction, tol);
    Ok(if basic.is_solved() { basic } else { solution })
}

/// The caller's covering vector on the equilibrated problem, scaled to a maximum near 1: a common factor only changes
/// the unit of `z_0`, which should be that of everything else.
fn covering_vector(problem: &Equilibrated<'_>, d: &[f64]) -> Vec<f64> {
    let scaled = |d: &f64, shift: i32| times_power_of_two(*d, shift);
    let shift = |d: &f64, r: &i32| exponent(*d) + r;
    let largest = d.iter().zip(&problem.scaling.rows).map(|(d, r)| shift(d, r)).max().unwrap_or(0);
    d.iter().zip(&problem.scaling.rows).map(|(d, r)| scaled(d, r - largest).max(f64::MIN_POSITIVE)).collect()
}
