//! `auto` under a loose tolerance or a time limit: a short approximate attempt before the portfolio.
//!
//! Which attempt, and how long, was measured: see `benches/record/approximate.md`.

use super::approximate::{Approximate, solve};
use super::{Certify, Settings, pieces};
use crate::certify::certify;
use crate::control::Control;
use crate::iterative::{Dense, Goal, Matrix};
use crate::methods::{nncg, pgs_sm};
use crate::problem::Lcp;
use crate::scaling::Equilibrated;
use crate::solution::{Candidate, Solution};
use crate::status::{Status, Termination};

/// From this `tol` on, an approximate answer may be all that is asked for.
pub(super) const LOOSE: f64 = 1e-6;
/// Sweeps of conjugate gradients between two looks at their progress.
const CHUNK: usize = 16;
/// They go on while their rate promises the goal after `max(40, n / 4)` sweeps: beyond that a few factorisations cost less.
const WORTHWHILE: (usize, usize) = (40, 4);
/// Sweeps granted to the subspace minimisation that follows.
const SWEEPS: usize = 30;
/// Sweeps of the attempt when only time is short: it is there to be better than nothing.
const FIRST_SWEEPS: usize = 20;

/// The portfolio, with an attempt before it where the settings ask for one. Under a loose `tol` the attempt answers when it
/// reaches it; under a time limit its point is there for a portfolio that runs out of time with a worse one.
pub(super) fn auto(problem: &Equilibrated<'_>, settings: &Settings, control: &Control<'_>) -> Solution {
    let loose = settings.tol >= LOOSE && settings.certify == Certify::Float;
    let attempt = match () {
        () if loose => loosely(problem, settings, control),
        () if control.deadline.is_some() && sweeps_apply(problem) => {
            let control = with_limit(control, FIRST_SWEEPS);
            Some(solve(problem, settings, &Approximate::Nncg, &control))
        }
        () => None,
    };
    let Some(attempt) = attempt else { return pieces::auto(problem, settings, control) };
    if loose && attempt.status == Status::Solved {
        return attempt;
    }
    let left = control.max_iterations.map(|limit| limit.saturating_sub(attempt.iterations));
    let mut solution = pieces::auto(problem, settings, &control.with_max_iterations(left));
    solution.iterations += attempt.iterations;
    if solution.status == Status::TimeLimit && attempt.residual < solution.residual {
        let termination = control.expired().unwrap_or(Termination::TimeLimit);
        let z = problem.scaling.z_from_caller(&attempt.z);
        return certify(problem, Candidate::point(z, termination, solution.iterations), attempt.method, settings.tol);
    }
    solution
}

/// For symmetric A, up to the rounding of whoever made it: conjugate gradients while they promise to get there, then subspace minimisation from their point.
/// For other A a sweep promises nothing, and the portfolio is as quick.
fn loosely(problem: &Equilibrated<'_>, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    if !sweeps_apply(problem) || !is_nearly_symmetric(problem.original) {
        return None;
    }
    let matrix = Dense::new(&problem.lcp);
    let scaling = &problem.scaling;
    let goal = Goal::new(settings.tol, scaling, scaling, problem.original.q());
    let n = matrix.n();
    let mut z = settings.z0.as_deref().map_or_else(|| vec![0.0; n], |z0| scaling.z_from_caller(z0));
    let mut w = vec![0.0; n];
    let mut spent = 0;
    loop {
        let left = with_limit(&with_spent(control, spent), CHUNK);
        let found = nncg::nncg(&matrix, &goal, Some(&z), &left);
        spent += found.iterations;
        let stopped = !matches!(found.termination, Termination::IterationLimit);
        if stopped || control.max_iterations.is_some_and(|limit| spent >= limit) {
            return Some(certify(problem, Candidate { iterations: spent, ..found }, "nncg", settings.tol));
        }
        z = found.z;
        matrix.affine(&z, &mut w);
        // The residual of z = 0 is near 1: q is scaled so.
        let digits = -goal.measure(&z, &w).residual.ln();
        if spent as f64 * -settings.tol.ln() > digits * WORTHWHILE.0.max(n / WORTHWHILE.1) as f64 {
            break;
        }
    }
    let left = with_limit(&with_spent(control, spent), SWEEPS);
    let found = pgs_sm::pgs_sm(&matrix, &goal, &pgs_sm::Settings::default(), Some(&z), &left);
    let iterations = spent + found.iterations;
    Some(certify(problem, Candidate { iterations, ..found }, "pgs_sm", settings.tol))
}

/// The same limits, and at most `limit` iterations.
fn with_limit<'a>(control: &Control<'a>, limit: usize) -> Control<'a> {
    control.with_max_iterations(Some(control.max_iterations.map_or(limit, |own| own.min(limit))))
}

/// The same limits less the iterations spent.
fn with_spent<'a>(control: &Control<'a>, spent: usize) -> Control<'a> {
    control.with_max_iterations(control.max_iterations.map(|limit| limit.saturating_sub(spent)))
}

/// `|a_ij - a_ji| <= 1e-6 (a_ii a_jj)^(1/2)`, for a positive diagonal.
fn is_nearly_symmetric(lcp: &Lcp) -> bool {
    let n = lcp.n();
    let near = |i: usize, j: usize| {
        let difference = lcp.row(i)[j] - lcp.row(j)[i];
        difference == 0.0 || difference * difference <= 1e-12 * lcp.row(i)[i] * lcp.row(j)[j]
    };
    (0..n).all(|i| (0..i).all(|j| near(i, j)))
}

/// A sweep needs a positive diagonal; where an entry is not, the attempt would only cost time.
fn sweeps_apply(problem: &Equilibrated<'_>) -> bool {
    (0..problem.lcp.n()).all(|i| problem.lcp.row(i)[i] > 0.0)
}
