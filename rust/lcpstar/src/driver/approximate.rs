//! The approximate methods: one goal, one start, dense or sparse.

use super::settings::{Approximate, Settings};
use crate::control::Control;
use crate::equilibrate::{Equilibrated, Rows};
use crate::iterative::{Dense, Goal, Matrix, Sparse};
use crate::judge::judge;
use crate::methods::{admm, apgd, newton, nncg, pgs, pgs_sm};
use crate::problem::Lcp;
use crate::solution::{Candidate, Solution};
use crate::sparse::SparseLcp;
use crate::tails::Tails;

impl Approximate {
    /// Runs it on a scaled problem; `z0` in its units.
    pub(super) fn run(
        &self,
        matrix: &impl Matrix,
        goal: &Goal,
        z0: Option<&[f64]>,
        control: &Control<'_>,
    ) -> Candidate {
        match self {
            Self::Pgs(options) => pgs::pgs(matrix, goal, options, z0, control),
            Self::PgsSm(options) => pgs_sm::pgs_sm(matrix, goal, options, z0, control),
            Self::Nncg => nncg::nncg(matrix, goal, z0, control),
            Self::Apgd => apgd::apgd(matrix, goal, z0, control),
            Self::Admm(options) => admm::admm(matrix, goal, options, z0, control),
            Self::Newton(options) => newton::newton(matrix, goal, options, z0, control),
        }
    }
}

/// Runs the method on `D A D`, because `D_r A D_c` with `D_r != D_c` need not be monotone when A is; the goal is measured on
/// the equilibrated problem all the same. Starts from the values of `z0`.
pub(super) fn solve<P: Rows + Iterated>(
    problem: &Equilibrated<'_, P>,
    settings: &Settings,
    method: &Approximate,
    control: &Control<'_>,
) -> Solution {
    let (original, target) = (problem.original, &problem.scaling);
    let scaling = target.congruent(original.q());
    let goal = Goal::new(settings.tol, &scaling, target, original.q()).without_tails(P::tails(problem));
    let z0 = settings.z0.as_deref().map(|z0| scaling.z_from_caller(z0));
    let run = |lcp: &P| method.run(&lcp.matrix(), &goal, z0.as_deref(), control);
    let found = if scaling == *target {
        run(&problem.lcp)
    } else {
        let found = run(&original.scaled(&scaling));
        Candidate { z: target.z_from_caller(&scaling.z_to_caller(&found.z)), ..found }
    };
    judge(problem, found, method.member(), settings.tol)
}

/// A problem whose matrix the iterations know.
pub(super) trait Iterated: Sized {
    /// The matrix as they see it.
    fn matrix(&self) -> impl Matrix;
    /// The tails that an iteration may cut off.
    fn tails(problem: &Equilibrated<'_, Self>) -> Option<Tails>;
}

impl Iterated for Lcp {
    /// Sweeps and solves carry a tail to its end.
    fn tails(_: &Equilibrated<'_, Self>) -> Option<Tails> {
        None
    }

    fn matrix(&self) -> impl Matrix {
        Dense::new(self)
    }
}

impl Iterated for SparseLcp {
    fn tails(problem: &Equilibrated<'_, Self>) -> Option<Tails> {
        Tails::new(problem.original, &problem.lcp)
    }

    fn matrix(&self) -> impl Matrix {
        Sparse::new(self)
    }
}
