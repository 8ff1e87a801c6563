//! The kernel for small problems in front of the portfolio of `"auto"`.

use super::doubt;
use super::parts::{self, subproblem};
use super::portfolio::SHIFT;
use super::settings::{Certify, Method, Settings, check_common};
use super::start::support;
use crate::control::Control;
use crate::cutovers::{GUESS_FROM, KERNEL_FIRST_UP_TO, SCALED_ABOVE};
use crate::equilibrate::Equilibrated;
use crate::judge::judge;
use crate::member::Member;
use crate::methods::block_pivoting;
use crate::pivoting::basis::basic_point;
use crate::presolve::{self, Plan};
use crate::problem::Lcp;
use crate::small::{self, Accepted, Answer, TINY_ORDER, verify_point};
use crate::solution::{Candidate, Solution};
use crate::status::Termination;
use crate::verdict::{Evidence, Verdict};

/// The kernel's verified answer, part by part where presolve finds some. `None` says nothing about the problem.
pub(super) fn solve(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    let n = lcp.n();
    if n > TINY_ORDER || !is_plain(settings, control) {
        return None;
    }
    if settings.z0.is_some() {
        if n < GUESS_FROM || check_common(n, settings).is_err() {
            return None;
        }
        return from_guess(lcp, settings).or_else(|| solve(lcp, &Settings { z0: None, ..settings.clone() }, control));
    }
    match presolve::plan(lcp) {
        None => solve_part(lcp, settings, control),
        Some(plan) => solve_parts(lcp, &plan, settings, control),
    }
}

/// Whether nothing but a solution within `tol` is asked for.
fn is_plain(settings: &Settings, control: &Control<'_>) -> bool {
    matches!(settings.method, Method::Auto)
        && settings.certify == Certify::Float
        && settings.tol > 0.0
        && settings.tol < 1.0
        && control.max_iterations.is_none()
}

/// A few exchanges of block pivoting from the support of `z0` on the caller's own numbers: one factorisation where it is right, two or
/// three where it is nearly right. Then `z0` itself, whose support may be singular. For what is left, the kernel's pivots cost less
/// than a path from the guess. `None` says nothing about the problem or the settings.
pub(super) fn from_guess(lcp: &Lcp, settings: &Settings) -> Option<Solution> {
    let n = lcp.n();
    let z0 = settings.z0.as_deref().filter(|_| n <= TINY_ORDER)?;
    let verified = |z: Vec<f64>, alpha: Vec<usize>, iterations: usize| {
        verified(lcp, z, Some(alpha), settings.tol).map(|found| Solution {
            method: Member::WarmStart,
            iterations,
            ..found
        })
    };
    let options =
        block_pivoting::Settings { alpha: Some(support(z0)), patience: 1, ..block_pivoting::Settings::default() };
    let limit = Control::default().with_max_iterations(Some(GUESS_FACTORISATIONS));
    let found = block_pivoting::block_pivoting(lcp, &options, &limit);
    let basis = found.alpha.and_then(|alpha| {
        let z: Vec<f64> = found.z.iter().map(|z| z.max(0.0)).collect();
        verified(z, alpha, found.iterations - 1)
    });
    basis.or_else(|| verified(z0.to_vec(), support(z0), 0))
}

/// Factorisations granted to a guess.
const GUESS_FACTORISATIONS: usize = 4;

/// As [`solve`], for a problem that presolve has left in one part.
pub(super) fn solve_part(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    let n = lcp.n();
    if n > TINY_ORDER || settings.z0.is_some() || !is_plain(settings, control) {
        return None;
    }
    let balanced = equilibrated_if_unbalanced(lcp);
    if n > KERNEL_FIRST_UP_TO
        && lcp.is_symmetric()
        && let Some((z, alpha, iterations)) = by_block_pivoting(lcp, balanced.as_ref(), control)
        && let Some(solution) = verified(lcp, z, Some(alpha), settings.tol)
    {
        let method = if solution.alpha.is_empty() { Member::Trivial } else { Member::BlockPivoting };
        return Some(Solution { method, iterations, ..solution });
    }
    let (mut z, mut w) = (vec![0.0; n], vec![0.0; n]);
    let worked_on = balanced.as_ref().map_or(lcp, |problem| &problem.lcp);
    let answer = small::solve(worked_on.a(), worked_on.q(), settings.tol, &mut z, &mut w);
    let (alpha, iterations) = match answer {
        Answer::Solved { accepted, alpha, iterations } if balanced.is_none() => {
            return Some(solved(z, w, accepted, members(n, alpha), iterations));
        }
        Answer::Solved { alpha, iterations, .. } | Answer::Basis { alpha, iterations } => {
            (members(n, alpha), iterations)
        }
        Answer::None => return None,
    };
    let problem = balanced.unwrap_or_else(|| Equilibrated::new(lcp));
    if matches!(answer, Answer::Solved { .. })
        && let Some(solution) = verified(lcp, problem.scaling.z_to_caller(&z), Some(alpha.clone()), settings.tol)
    {
        return Some(Solution { iterations, ..solution });
    }
    from_basis(&problem, alpha, iterations, settings.tol)
}

/// Factorisations granted to block pivoting above it.
const FACTORISATIONS: usize = 8;

/// The problem with which to work, where the caller's numbers will not do.
pub(super) fn equilibrated_if_unbalanced(lcp: &Lcp) -> Option<Equilibrated<'_>> {
    (lcp.n() > SCALED_ABOVE && is_unbalanced(lcp)).then(|| Equilibrated::new(lcp))
}

/// z, its basis (its support, where blocks were shifted) and the number of factorisations of block pivoting, on the equilibrated
/// problem where that is given. Not verified.
pub(super) fn by_block_pivoting(
    lcp: &Lcp,
    equilibrated: Option<&Equilibrated<'_>>,
    control: &Control<'_>,
) -> Option<(Vec<f64>, Vec<usize>, usize)> {
    if !is_for_blocks(lcp) {
        return None;
    }
    let balanced = equilibrated.map_or(lcp, |problem| &problem.lcp);
    let largest = (0..lcp.n()).fold(0.0_f64, |m, i| m.max(balanced.row(i)[i]));
    let options =
        block_pivoting::Settings { murty: false, shift: SHIFT * largest, ..block_pivoting::Settings::default() };
    let found = block_pivoting::block_pivoting(balanced, &options, &control.with_max_iterations(Some(FACTORISATIONS)));
    let mut z: Vec<f64> = found.z.iter().map(|z| z.max(0.0)).collect();
    if let Some(problem) = equilibrated {
        z = problem.scaling.z_to_caller(&z);
    }
    let alpha = match found.termination {
        Termination::Converged => support(&z),
        _ => found.alpha?,
    };
    Some((z, alpha, found.iterations))
}

/// A basis that pivots led to, its point solved for again on the original numbers: where many pivots have lost digits, as with
/// mass ratios of 10^6, the basis may be right all the same.
fn from_basis(problem: &Equilibrated<'_>, alpha: Vec<usize>, iterations: usize, tol: f64) -> Option<Solution> {
    let lcp = problem.original;
    let scaled = basic_point(&problem.lcp, &alpha)?;
    let z: Vec<f64> = problem.scaling.z_to_caller(&scaled).iter().map(|z| z.max(0.0)).collect();
    let solution = match verified(lcp, z, Some(alpha.clone()), tol) {
        Some(solution) => Solution { iterations, ..solution },
        None => {
            let point = Candidate::point(scaled, Termination::ComplementaryBasis, iterations);
            judge(problem, Candidate { alpha: Some(alpha), ..point }, Member::LemkeSmall, tol)
        }
    };
    (solution.is_solved() && !doubt::misses_q(lcp, &solution)).then_some(solution)
}

/// Every part by the kernel, the whole verified.
fn solve_parts(lcp: &Lcp, plan: &Plan, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    if plan.parts.iter().any(|part| part.indices.len() > TINY_ORDER) {
        return None;
    }
    let mut z = vec![0.0; lcp.n()];
    let (mut alpha, mut pieces, mut iterations) = (vec![], vec![], 0);
    for part in &plan.parts {
        let solution = solve_part(&subproblem(lcp, part, &z)?, settings, control)?;
        part.indices.iter().zip(&solution.z).for_each(|(&i, x)| z[i] = *x);
        alpha.extend(solution.alpha.iter().map(|&i| part.indices[i]));
        iterations += solution.iterations;
        pieces.push((part.indices.clone(), solution.method));
    }
    alpha.sort_unstable();
    let whole = verified(lcp, z, Some(alpha), settings.tol)?;
    Some(Solution { method: parts::name(&pieces), iterations, pieces, ..whole })
}

/// Whether block pivoting is likely to end: the diagonal is positive, and A symmetric or without a zero in its first row, which
/// frictional contact has.
fn is_for_blocks(lcp: &Lcp) -> bool {
    (0..lcp.n()).all(|i| lcp.row(i)[i] > 0.0) && (lcp.row(0).iter().all(|&a| a != 0.0) || lcp.is_symmetric())
}

/// Whether the diagonal spans more than `UNBALANCED`: pivots and rounding of large entries would then be compared with small
/// ones, and the kernel works on the equilibrated problem. O(n).
fn is_unbalanced(lcp: &Lcp) -> bool {
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for i in 0..lcp.n() {
        let size = lcp.row(i)[i].abs();
        if size > 0.0 {
            (least, most) = (least.min(size), most.max(size));
        }
    }
    most > UNBALANCED * least
}

const UNBALANCED: f64 = 1e2;

/// The i below n whose bit is set.
fn members(n: usize, bits: u128) -> Vec<usize> {
    (0..n).filter(|i| bits >> i & 1 == 1).collect()
}

/// A point that was found elsewhere, `z >= 0`, as a solution, if it is one; with the basis that led to it, or its support.
fn verified(lcp: &Lcp, z: Vec<f64>, basis: Option<Vec<usize>>, tol: f64) -> Option<Solution> {
    let mut w = vec![0.0; lcp.n()];
    let accepted = verify_point(lcp.a(), lcp.q(), tol, &z, &mut w)?;
    // Where a negative z_i of the basis was cut off, the point is not that of the basis.
    let vanishes = |i: usize| {
        let size = lcp.row(i).iter().zip(&z).map(|(a, z)| (a * z).abs()).sum::<f64>() + lcp.q()[i].abs();
        w[i].abs() <= 64.0 * f64::EPSILON * size
    };
    let of_point = |alpha: &Vec<usize>| alpha.iter().all(|&i| z[i] > 0.0 || vanishes(i));
    let alpha = basis.filter(of_point).unwrap_or_else(|| support(&z));
    Some(solved(z, w, accepted, alpha, 0))
}

/// What the kernel accepted, by the rule that is stricter than that of the judge.
fn solved(z: Vec<f64>, w: Vec<f64>, accepted: Accepted, alpha: Vec<usize>, iterations: usize) -> Solution {
    Solution {
        method: if alpha.is_empty() { Member::Trivial } else { Member::LemkeSmall },
        natural_residual: accepted.natural_residual(),
        residual: accepted.residual(),
        verdict: Verdict::of(Evidence::Accepted(accepted, alpha.clone())),
        z,
        w,
        iterations,
        alpha,
        ray: None,
        pieces: vec![],
        message: "solved: verified on the caller's numbers".into(),
    }
}
