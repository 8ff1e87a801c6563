//! Homogeneous predictor-corrector for monotone LCP, with an exact finish. [AndY99], [Meh92], [Gon96]
//!
//! For A + A' PSD it ends, from any start, with a solution or with a Farkas vector that shows that none exists. Beyond
//! (sufficient matrices) it is used with a safeguard: short steps end it, and only `certify` judges its point.

mod infeasible;
mod iterate;
mod sparse;
mod system;

use crate::cutovers::SPARSE_FROM;
pub use sparse::Sparse;
pub use system::{Dense, NewtonSystem, Problem};

use crate::control::Control;
use crate::linalg::kernels::max_abs;
use crate::pivoting::finish::Finished;
use crate::problem::Lcp;
use crate::residual::equilibrated_residual;
use crate::solution::Candidate;
use crate::sparse::SparseLcp;
use crate::status::Termination;
use iterate::Iterate;

/// Options.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The equilibrated residual to reach.
    pub tol: f64,
    /// Whether to finish at a complementary basis.
    pub finish: bool,
    /// A guess in the units of the problem given.
    pub z0: Option<Vec<f64>>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tol: 1e-9, finish: true, z0: None }
    }
}

/// Iterations when the caller sets no limit.
pub const DEFAULT_MAX_ITERATIONS: usize = 100;
/// The finish is tried first at this residual, however small `tol` is; then each time the residual fell as much again.
const FIRST_FINISH: f64 = 1e-9;
const NEXT_FINISH: f64 = 1e-2;
/// z_i and w_i within this factor of each other do not say yet which of them ends at zero.
const DECIDED: f64 = 10.0;
/// Steps below this ...
const SHORT_STEP: f64 = 1e-3;
/// ... this many times in a row end the method.
const SHORT_STEPS: usize = 3;
/// `tau` below this fraction of `kappa`: look for a Farkas vector.
const TAU_VANISHES: f64 = 1e-6;

/// Solves an equilibrated LCP. O(n^3) an iteration: one factorisation, a sparse one where nearly all of a symmetric A is zero.
#[must_use]
pub fn interior_point(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Candidate {
    if is_nearly_empty(lcp) {
        let sparse = SparseLcp::from_dense(lcp);
        if let Some(mut system) = Sparse::new(&sparse, Some(lcp), *control) {
            return run(&mut system, settings, control);
        }
    }
    run(&mut Dense::new(lcp), settings, control)
}

/// Whether a sparse Cholesky factorisation is the better one. O(n^2).
fn is_nearly_empty(lcp: &Lcp) -> bool {
    let entries = || lcp.a().iter().filter(|&&a| a != 0.0).count();
    lcp.n() >= SPARSE_FROM && lcp.is_symmetric() && SPARSE * entries() <= lcp.a().len()
}

const SPARSE: usize = 24;

/// As [`interior_point`] for a sparse A; each iteration costs a sparse factorisation.
#[must_use]
pub fn interior_point_sparse(lcp: &SparseLcp, settings: &Settings, control: &Control<'_>) -> Candidate {
    match Sparse::new(lcp, None, *control) {
        Some(mut system) => run(&mut system, settings, control),
        None => {
            let reason = Termination::Breakdown("the sparse matrix is too large to index");
            Candidate::point(vec![0.0; lcp.n()], control.expired().unwrap_or(reason), 0)
        }
    }
}

fn run(system: &mut impl Problem, settings: &Settings, control: &Control<'_>) -> Candidate {
    let mut iterate = start(system, settings.z0.as_deref());
    let mut finish_at = settings.tol.max(FIRST_FINISH);
    let mut last_try = Try { residual: 1e-3, undecided: system.n() / 5 + 1 };
    let mut best = Best::default();
    let mut short_steps = 0;
    let mut iteration = 0;
    let termination = loop {
        iterate.update_residuals(system);
        let residual = iterate.residual(system.q());
        best.offer(&iterate, residual);
        if iterate.tau < TAU_VANISHES * iterate.kappa
            && let Some(farkas) = system.farkas_vector(&iterate.z, &iterate.w)
        {
            let point = best.z_or(&iterate);
            return Candidate { farkas: Some(farkas), ..Candidate::point(point, Termination::Infeasible, iteration) };
        }
        if residual <= finish_at {
            if settings.finish {
                best.finish(system);
            }
            if best.residual <= settings.tol {
                break Termination::Converged;
            }
            finish_at = residual * NEXT_FINISH;
        } else if settings.finish {
            let this_try = Try::of(&iterate, residual);
            if this_try.is_worth_it_after(&last_try) {
                if best.finish_quickly(system) && best.residual <= settings.tol {
                    break Termination::Converged;
                }
                last_try = this_try;
            }
        }
        if let Some(stop) = control.stop(iteration, DEFAULT_MAX_ITERATIONS) {
            break stop;
        }
        if short_steps == SHORT_STEPS {
            break Termination::Breakdown("the steps became too short: A is not monotone here, or rounding rules");
        }
        match iterate.advance(system) {
            Some(step) if step < SHORT_STEP => short_steps += 1,
            Some(_) => short_steps = 0,
            None => break Termination::Breakdown("the Newton system could not be solved"),
        }
        iteration += 1;
    };
    if best.residual > settings.tol && settings.finish && matches!(termination, Termination::Breakdown(_)) {
        best.finish(system);
    }
    let termination = if best.residual <= settings.tol { Termination::Converged } else { termination };
    Candidate { alpha: best.alpha, ..Candidate::point(best.z, termination, iteration) }
}

/// `z = w = 0.3 e`, `tau = 1`, all products equal; with a guess, its point pushed into the interior as far as its residual is large.
fn start(problem: &impl Problem, z0: Option<&[f64]>) -> Iterate {
    let n = problem.n();
    if let Some(z0) = z0 {
        let w0 = problem.slack(z0);
        let residual = equilibrated_residual(z0, &w0);
        if residual <= WARM {
            let floor = residual.max(1e-6).sqrt() * max_abs(z0).max(1.0);
            let push = |x: &f64| x.max(floor);
            return Iterate::new(z0.iter().map(push).collect(), w0.iter().map(push).collect(), 1.0, floor * floor);
        }
    }
    Iterate::new(vec![START; n], vec![START; n], 1.0, START * START)
}

/// Entries of the cold start. Measured: on an equilibrated problem 0.1 to 0.3 takes one iteration less than 1.
const START: f64 = 0.3;
/// A guess with a larger residual is no better than the cold start.
const WARM: f64 = 1e-2;

/// The cheap half of the finish, one factorisation, is tried when the support is clear, however large the residual.
struct Try {
    residual: f64,
    /// Pairs that do not say yet which of the two ends at zero.
    undecided: usize,
}

impl Try {
    /// O(n).
    fn of(iterate: &Iterate, residual: f64) -> Self {
        let is_undecided = |&(&z, &w): &(&f64, &f64)| z < DECIDED * w && w < DECIDED * z;
        Self { residual, undecided: iterate.z.iter().zip(&iterate.w).filter(is_undecided).count() }
    }

    /// Less than half as many pairs are undecided, or the residual fell to a tenth.
    fn is_worth_it_after(&self, last: &Self) -> bool {
        self.residual <= 0.1 * last.residual || 2 * self.undecided < last.undecided
    }
}

/// The best point so far.
struct Best {
    z: Vec<f64>,
    w: Vec<f64>,
    alpha: Option<Vec<usize>>,
    residual: f64,
}

impl Default for Best {
    fn default() -> Self {
        Self { z: Vec::new(), w: Vec::new(), alpha: None, residual: f64::INFINITY }
    }
}

impl Best {
    fn offer(&mut self, iterate: &Iterate, residual: f64) {
        if residual < self.residual || self.z.is_empty() {
            self.z.clear();
            self.z.extend(iterate.z.iter().map(|z| z / iterate.tau));
            self.w.clear();
            self.w.extend(iterate.w.iter().map(|w| w / iterate.tau));
            self.alpha = None;
            self.residual = residual;
        }
    }

    fn finish(&mut self, problem: &impl Problem) {
        if let Some(found) = problem.finish(&self.z, &self.w).filter(|found| found.residual <= self.residual) {
            self.accept(found);
        }
    }

    fn finish_quickly(&mut self, problem: &impl Problem) -> bool {
        let found = problem.finish_quickly(&self.z, &self.w).filter(|found| found.residual <= self.residual);
        let is_some = found.is_some();
        found.into_iter().for_each(|found| self.accept(found));
        is_some
    }

    fn accept(&mut self, found: Finished) {
        self.z = found.z;
        self.alpha = found.is_basis.then_some(found.alpha);
        self.residual = found.residual;
    }

    fn z_or(&self, iterate: &Iterate) -> Vec<f64> {
        if self.z.is_empty() { iterate.z.clone() } else { self.z.clone() }
    }
}
