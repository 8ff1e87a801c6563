//! `auto` under a loose tolerance or a time limit: a short approximate attempt before the portfolio.
//!
//! Which attempt, and how long, was measured: see `benches/record/approximate.md`.

use super::approximate::{Approximate, solve};
use super::{Certify, Settings, pieces};
use crate::certify::certify;
use crate::control::Control;
use crate::methods::pgs_sm;
use crate::scaling::Equilibrated;
use crate::solution::{Candidate, Solution};
use crate::status::{Status, Termination};

/// From this `tol` on, an approximate answer may be all that is asked for.
const LOOSE: f64 = 1e-6;
/// Sweeps of the attempt when `tol` is loose.
const SWEEPS: usize = 30;
/// Sweeps of the attempt when only time is short: it is there to be better than nothing.
const FIRST_SWEEPS: usize = 20;

/// The portfolio, with an attempt before it where the settings ask for one. Under a loose `tol` the attempt answers when it
/// reaches it; under a time limit its point is there for a portfolio that runs out of time with a worse one.
pub(super) fn auto(problem: &Equilibrated<'_>, settings: &Settings, control: &Control<'_>) -> Solution {
    let loose = settings.tol >= LOOSE && settings.certify == Certify::Float;
    if (!loose && control.deadline.is_none()) || !sweeps_apply(problem) {
        return pieces::auto(problem, settings, control);
    }
    let (method, sweeps) = if loose {
        (Approximate::PgsSm(pgs_sm::Settings::default()), SWEEPS)
    } else {
        (Approximate::Nncg, FIRST_SWEEPS)
    };
    let limit = control.max_iterations.unwrap_or(usize::MAX);
    let attempt = solve(problem, settings, &method, &control.with_max_iterations(Some(sweeps.min(limit))));
    if loose && attempt.status == Status::Solved {
        return attempt;
    }
    let left = control.max_iterations.map(|limit| limit - attempt.iterations.min(limit));
    let mut solution = pieces::auto(problem, settings, &control.with_max_iterations(left));
    solution.iterations += attempt.iterations;
    if solution.status == Status::TimeLimit && attempt.residual < solution.residual {
        let termination = control.expired().unwrap_or(Termination::TimeLimit);
        let z = problem.scaling.z_from_caller(&attempt.z);
        return certify(problem, Candidate::point(z, termination, solution.iterations), attempt.method, settings.tol);
    }
    solution
}

/// A sweep needs a positive diagonal; where an entry is not, the attempt would only cost time.
fn sweeps_apply(problem: &Equilibrated<'_>) -> bool {
    (0..problem.lcp.n()).all(|i| problem.lcp.row(i)[i] > 0.0)
}
