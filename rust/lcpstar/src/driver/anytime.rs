//! `auto` under a loose tolerance or a time limit: a short approximate attempt before the portfolio.
//!
//! Which attempt, and how long, was measured: see `benches/record/approximate.md`.

use super::approximate::solve;
use super::pieces;
use super::portfolio::with_limit;
use super::settings::{Approximate, Certify, Settings};
use crate::control::Control;
use crate::equilibrate::Equilibrated;
use crate::iterative::{Dense, Goal};
use crate::judge::judge;
use crate::member::Member;
use crate::methods::nncg;
use crate::problem::Lcp;
use crate::solution::{Candidate, Solution};
use crate::status::{Status, Termination};

/// From this `tol` on, an approximate answer may be all that is asked for.
const LOOSE: f64 = 1e-6;
/// They go on while their rate promises the goal within `max(40, n / 8)` sweeps: beyond that pivoting costs less.
const WORTHWHILE: (usize, usize) = (40, 8);
/// Sweeps between two looks at their rate, the first after twice as many.
const LOOK: usize = 4;
/// Sweeps of the attempt when only time is short: it is there to be better than nothing.
const FIRST_SWEEPS: usize = 20;

/// The portfolio, with an attempt before it where the settings ask for one. Under a loose `tol` the attempt answers when it
/// reaches it; under a time limit its point is there for a portfolio that runs out of time with a worse one.
pub(super) fn auto(problem: &Equilibrated<'_>, settings: &Settings, control: &Control<'_>) -> Solution {
    let loose = settings.tol >= LOOSE && settings.certify == Certify::Float;
    let attempt = if loose {
        loosely(problem, settings, control)
    } else if control.deadline.is_some() && sweeps_apply(problem) {
        let control = with_limit(control, FIRST_SWEEPS);
        Some(solve(problem, settings, &Approximate::Nncg, &control))
    } else {
        None
    };
    let Some(attempt) = attempt else { return pieces::auto(problem, settings, control) };
    if loose && attempt.status() == Status::Solved {
        return attempt;
    }
    let left = control.max_iterations.map(|limit| limit.saturating_sub(attempt.iterations));
    let mut solution = pieces::auto(problem, settings, &control.with_max_iterations(left));
    solution.iterations += attempt.iterations;
    if solution.status() == Status::TimeLimit && attempt.residual < solution.residual {
        let termination = control.expired().unwrap_or(Termination::TimeLimit);
        let z = problem.scaling.z_from_caller(&attempt.z);
        return judge(problem, Candidate::point(z, termination, solution.iterations), attempt.method, settings.tol);
    }
    solution
}

/// For symmetric A, more or less: conjugate gradients while their rate leads there. For other A a sweep forecasts
/// nothing, and the portfolio is as quick.
fn loosely(problem: &Equilibrated<'_>, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    if !sweeps_apply(problem) || !is_nearly_symmetric(problem.original) {
        return None;
    }
    let scaling = &problem.scaling;
    let goal = Goal::new(settings.tol, scaling, scaling, problem.original.q());
    let z0 = settings.z0.as_deref().map(|z0| scaling.z_from_caller(z0));
    let forecast = Forecast::new(problem.lcp.n(), settings.tol);
    let found = nncg::nncg_while(&Dense::new(&problem.lcp), &goal, z0.as_deref(), control, forecast.watch());
    Some(judge(problem, found, Member::Nncg, settings.tol))
}

/// Whether sweeps that go on at their rate reach `tol` before they have cost as much as the full answer.
struct Forecast {
    sweeps: usize,
    tol: f64,
}

impl Forecast {
    fn new(n: usize, tol: f64) -> Self {
        Self { sweeps: WORTHWHILE.0.max(n / WORTHWHILE.1), tol }
    }

    /// To be asked after each sweep. The rate is that of the second half of the sweeps so far. Where the residual is below
    /// `tol` and the goal not reached, single rows are wrong, and a few more sweeps must do.
    fn watch(self) -> impl FnMut(usize, f64) -> bool {
        // The residual of z = 0 is near 1: q is scaled so.
        let mut residuals = vec![1.0_f64];
        let mut below = 0;
        move |sweep, residual| {
            residuals.push(residual);
            if residual <= self.tol {
                below += 1;
                return below < 2 * LOOK;
            }
            if sweep < 2 * LOOK || sweep % LOOK != 0 {
                return true;
            }
            let half = sweep / 2;
            let gained = (residuals[half] / residual).ln();
            let missing = (residual / self.tol).ln();
            sweep < self.sweeps
                && missing > 0.0
                && gained * (self.sweeps as f64 - sweep as f64) >= missing * (sweep - half) as f64
        }
    }
}

/// `|a_ij - a_ji| <= (a_ii a_jj)^(1/2) / 100`, for a positive diagonal.
fn is_nearly_symmetric(lcp: &Lcp) -> bool {
    let n = lcp.n();
    let near = |i: usize, j: usize| {
        let difference = lcp.row(i)[j] - lcp.row(j)[i];
        difference == 0.0 || difference * difference <= 1e-4 * lcp.row(i)[i] * lcp.row(j)[j]
    };
    (0..n).all(|i| (0..i).all(|j| near(i, j)))
}

/// A sweep needs a positive diagonal; where an entry is not, the attempt would only cost time.
fn sweeps_apply(problem: &Equilibrated<'_>) -> bool {
    (0..problem.lcp.n()).all(|i| problem.lcp.row(i)[i] > 0.0)
}
