//! The interior point method runs on `D A D`, because `D_r A D_c` with `D_r != D_c` need not be monotone when A is.

use super::settings::{Approximate, Settings};
use super::{approximate, polish};
use crate::control::Control;
use crate::equilibrate::{Equilibrated, Rows};
use crate::judge::{judge, without_tails};
use crate::member::Member;
use crate::methods::interior_point;
use crate::problem::Lcp;
use crate::solution::{Candidate, Solution};
use crate::sparse::SparseLcp;

/// What it finds on a dense problem.
pub(super) fn dense(
    problem: &Equilibrated<'_>,
    settings: &Settings,
    options: &interior_point::Settings,
    control: &Control<'_>,
) -> Candidate {
    congruent(problem, settings, options, |lcp: &Lcp, options| interior_point::interior_point(lcp, options, control))
}

/// The answer on a sparse problem: then Newton's method from its point where single rows of that do not hold.
pub(super) fn sparse(
    problem: &Equilibrated<'_, SparseLcp>,
    settings: &Settings,
    options: &interior_point::Settings,
    control: &Control<'_>,
) -> Solution {
    let run = |lcp: &SparseLcp, options: &_| interior_point::interior_point_sparse(lcp, options, control);
    let solution = judge(problem, congruent(problem, settings, options, run), Member::InteriorPoint, settings.tol);
    let solution = without_tails(problem, solution, settings.tol);
    if !polish::is_near(&solution, settings.tol) || control.max_iterations.is_some() {
        return solution;
    }
    let settings = Settings { z0: Some(solution.z.clone()), ..settings.clone() };
    let newton = Approximate::Newton(Default::default());
    let polished = approximate::solve(problem, &settings, &newton, control);
    if polished.is_solved() {
        Solution { method: solution.method, iterations: solution.iterations, ..polished }
    } else {
        solution
    }
}

/// Runs it on `D A D` and carries what it finds to the equilibrated problem, with the tolerance that gives `tol` there.
fn congruent<P: Rows>(
    problem: &Equilibrated<'_, P>,
    settings: &Settings,
    options: &interior_point::Settings,
    run: impl Fn(&P, &interior_point::Settings) -> Candidate,
) -> Candidate {
    let (original, target) = (problem.original, &problem.scaling);
    let scaling = target.congruent(original.q());
    let z0 = settings.z0.as_deref().map(|z0| scaling.z_from_caller(z0));
    let tol = (settings.tol / scaling.distance(target).max(1.0)).max(f64::EPSILON);
    let options = interior_point::Settings { tol, z0, ..options.clone() };
    if scaling == *target {
        return run(&problem.lcp, &options);
    }
    let found = run(&original.scaled(&scaling), &options);
    let multipliers = |y: &Vec<f64>| target.multiplier_from_caller(&scaling.multiplier_to_caller(y));
    let farkas = found.farkas.as_ref().map(multipliers);
    Candidate { z: target.z_from_caller(&scaling.z_to_caller(&found.z)), farkas, ..found }
}
