//! `auto`: the portfolio on each part of the problem that can be solved on its own, the answer certified on the whole.

use super::parts::{name, subproblem};
use super::settings::Settings;
use super::start::at_once;
use super::{portfolio, small};
use crate::control::Control;
use crate::equilibrate::Equilibrated;
use crate::judge::judge;
use crate::member::Member;
use crate::presolve::{self, Part, Plan};
use crate::problem::Lcp;
use crate::small::TINY_ORDER;
use crate::solution::{Candidate, Piece, Solution};
use crate::status::{Status, Termination};
use crate::verdict::Certificate;

/// The portfolio, in parts where presolve finds some.
///
/// Each part is treated as `solve` would treat it alone, on the caller's numbers, so islands get the same digits whatever
/// stands beside them. A part without an answer sends the whole problem to the portfolio, unless a limit was hit.
pub(super) fn auto(problem: &Equilibrated<'_>, settings: &Settings, control: &Control<'_>) -> Solution {
    let Some(plan) = presolve::plan(problem.original) else {
        return portfolio::auto(problem, settings, control);
    };
    let mut assembly = Assembly::new(problem, settings);
    let termination = assembly.solve(&plan, control);
    let spent = assembly.iterations;
    if let Some(termination) = termination {
        let solution = assembly.finish(termination);
        if solution.status() != Status::NumericalBreakdown {
            return solution;
        }
    }
    let left = control.max_iterations.map(|limit| limit.saturating_sub(spent));
    let mut solution = portfolio::auto(problem, settings, &control.with_max_iterations(left));
    solution.iterations += spent;
    solution
}

/// The answers of the parts solved so far.
struct Assembly<'a> {
    problem: &'a Equilibrated<'a>,
    settings: &'a Settings,
    z: Vec<f64>,
    alpha: Vec<usize>,
    farkas: Option<Vec<f64>>,
    pieces: Vec<Piece>,
    iterations: usize,
}

impl<'a> Assembly<'a> {
    fn new(problem: &'a Equilibrated<'a>, settings: &'a Settings) -> Self {
        let z = vec![0.0; problem.lcp.n()];
        Self { problem, settings, z, alpha: vec![], farkas: None, pieces: vec![], iterations: 0 }
    }

    /// How the parts ended: all solved, one infeasible or a limit hit; `None` when a part has no answer.
    fn solve(&mut self, plan: &Plan, control: &Control<'_>) -> Option<Termination> {
        for part in &plan.parts {
            let left = control.max_iterations.map(|limit| limit.saturating_sub(self.iterations));
            let control = &control.with_max_iterations(left);
            let lcp = subproblem(self.problem.original, part, &self.z)?;
            if let Some((z, alpha, iterations)) = self.unverified(&lcp, control) {
                self.add(part, &z, &alpha, Member::BlockPivoting, iterations);
                continue;
            }
            let solution = self.part(part, &lcp, control);
            let alpha = if solution.status() == Status::Solved { &solution.alpha[..] } else { &[] };
            self.add(part, &solution.z, alpha, solution.method, solution.iterations);
            match solution.status() {
                Status::Solved => {}
                Status::Infeasible | Status::NearlyInfeasible => {
                    self.set_farkas(part, solution.certificate());
                    return Some(Termination::Infeasible);
                }
                Status::TimeLimit => return Some(control.expired().unwrap_or(Termination::TimeLimit)),
                Status::MaxIterations if control.max_iterations.is_some() => return Some(Termination::IterationLimit),
                Status::MaxIterations | Status::SecondaryRay | Status::NumericalBreakdown => return None,
            }
        }
        self.alpha.sort_unstable();
        Some(Termination::ComplementaryBasis)
    }

    /// Remembers what a part came to.
    fn add(&mut self, part: &Part, z: &[f64], alpha: &[usize], method: Member, iterations: usize) {
        part.indices.iter().zip(z).for_each(|(&i, z)| self.z[i] = *z);
        self.alpha.extend(alpha.iter().map(|&i| part.indices[i]));
        self.pieces.push((part.indices.clone(), method));
        self.iterations += iterations;
    }

    /// A large part by block pivoting on the caller's numbers, if that is quick: no verdict of its own, since the whole gets one.
    fn unverified(&self, lcp: &Lcp, control: &Control<'_>) -> Option<(Vec<f64>, Vec<usize>, usize)> {
        let asked = self.settings.z0.is_none() && control.max_iterations.is_none();
        if !asked || lcp.n() <= TINY_ORDER {
            return None;
        }
        small::by_block_pivoting(lcp, small::equilibrated_if_unbalanced(lcp).as_ref(), control)
    }

    /// One part as a problem of its own.
    fn part(&self, part: &Part, lcp: &Lcp, control: &Control<'_>) -> Solution {
        let z0 = self.settings.z0.as_ref().map(|z0| part.indices.iter().map(|&i| z0[i]).collect());
        let settings = Settings { z0, ..self.settings.clone() };
        if let Some(solution) = small::solve_part(lcp, &settings, control) {
            return solution;
        }
        let problem = Equilibrated::new(lcp);
        at_once(&problem, &settings).unwrap_or_else(|| portfolio::auto(&problem, &settings, control))
    }

    /// The part's Farkas vector in the units of the equilibrated whole; `certify` decides whether it is one of the whole.
    fn set_farkas(&mut self, part: &Part, certificate: Option<&Certificate>) {
        let y = match certificate {
            Some(Certificate::Infeasible { y }) => y.direction_to_f64(),
            Some(Certificate::NearlyInfeasible { y, .. }) => y.clone(),
            _ => return,
        };
        let mut whole = vec![0.0; self.z.len()];
        for (&i, y) in part.indices.iter().zip(y) {
            whole[i] = crate::scaling::times_power_of_two(y, -self.problem.scaling.rows[i]);
        }
        self.farkas = Some(whole);
    }

    fn finish(self, termination: Termination) -> Solution {
        let z = self.problem.scaling.z_from_caller(&self.z);
        let alpha = (termination == Termination::ComplementaryBasis).then_some(self.alpha);
        let point = Candidate::point(z, termination, self.iterations);
        let candidate = Candidate { alpha, farkas: self.farkas, ..point };
        let mut solution = judge(self.problem, candidate, name(&self.pieces), self.settings.tol);
        solution.pieces = self.pieces;
        solution
    }
}
