//! The approximate methods: one goal, one start, dense or sparse.

use super::Settings;
use crate::control::Control;
use crate::equilibrate::{Equilibrated, Rows};
use crate::error::{LcpError, Result};
use crate::iterative::{Dense, Goal, Matrix, Sparse};
use crate::judge::judge;
use crate::member::Member;
use crate::methods::{admm, apgd, newton, nncg, pgs, pgs_sm};
use crate::problem::Lcp;
use crate::solution::{Candidate, Solution};
use crate::sparse::SparseLcp;
use crate::tails::Tails;

/// A method that improves a point from iteration to iteration, and its options.
#[derive(Clone, Debug)]
pub enum Approximate {
    /// Projected Gauss-Seidel.
    Pgs(pgs::Settings),
    /// Projected Gauss-Seidel with subspace minimisation.
    PgsSm(pgs_sm::Settings),
    /// Nonsmooth nonlinear conjugate gradients.
    Nncg,
    /// Accelerated projected gradients.
    Apgd,
    /// ADMM.
    Admm(admm::Settings),
    /// Newton's method on the minimum map.
    Newton(newton::Settings),
}

impl Approximate {
    /// The method of that name with its default options.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "pgs" => Some(Self::Pgs(pgs::Settings::default())),
            "pgs_sm" => Some(Self::PgsSm(pgs_sm::Settings::default())),
            "nncg" => Some(Self::Nncg),
            "apgd" => Some(Self::Apgd),
            "admm" => Some(Self::Admm(admm::Settings::default())),
            "newton" => Some(Self::Newton(newton::Settings::default())),
            _ => None,
        }
    }

    /// Its name in results.
    #[must_use]
    pub fn member(&self) -> Member {
        match self {
            Self::Pgs(_) => Member::Pgs,
            Self::PgsSm(_) => Member::PgsSm,
            Self::Nncg => Member::Nncg,
            Self::Apgd => Member::Apgd,
            Self::Admm(_) => Member::Admm,
            Self::Newton(_) => Member::Newton,
        }
    }

    /// Ranges of the options.
    pub(super) fn check(&self) -> Result<()> {
        let within = |name, value: f64, holds: bool, rule| {
            if holds { Ok(()) } else { Err(LcpError::OutOfRange { name, value, rule }) }
        };
        let relaxation = |x: f64| within("relaxation", x, x > 0.0 && x < 2.0, "in (0, 2)");
        let positive = |name, count: usize| within(name, count as f64, count > 0, "at least 1");
        match self {
            Self::Pgs(options) => relaxation(options.relaxation),
            Self::PgsSm(options) => {
                relaxation(options.relaxation)?;
                positive("sweeps", options.sweeps)?;
                positive("solves", options.solves)
            }
            Self::Admm(options) => {
                relaxation(options.relaxation)?;
                within("rho", options.rho, options.rho > 0.0 && options.rho.is_finite(), "positive and finite")
            }
            Self::Newton(options) => positive("patience", options.patience),
            Self::Nncg | Self::Apgd => Ok(()),
        }
    }

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
