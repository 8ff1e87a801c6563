//! The portfolio: which methods are tried, in which order, and what is reported when none succeeds.
//!
//! Deterministic; the first member whose point is certified (solved, or infeasible with a checked Farkas vector) answers
//! and is named in the result. A member that fails costs its pivot budget, never the answer.

use super::settings::{Certify, DEFAULT_RESTARTS, Settings};
use super::start::support;
use super::{interior_point as congruent, polish};
use crate::control::Control;
use crate::cutovers::{
    BLOCK_PIVOTING_FROM, DOUBLE_DOUBLE_UP_TO, ENUMERATE_UP_TO, FINISH_IN_DOUBLE_DOUBLE_UP_TO, SHIFT_ABOVE,
    WARM_PATH_FIRST_UP_TO,
};
use crate::equilibrate::Equilibrated;
use crate::judge::judge;
use crate::linalg::dd::Dd;
use crate::member::Member;
use crate::methods::{
    bilinear, block_pivoting, chandrasekaran, enumerate, feasibility, interior_point, lemke, lemke_howson,
    principal_pivoting as criss_cross,
};
use crate::problem::Lcp;
use crate::residual::slack;
use crate::solution::{Candidate, Solution};
use crate::status::{Status, Termination};

/// The members tried so far: their pivots, and the best answer that is not final.
struct Portfolio<'a> {
    problem: &'a Equilibrated<'a>,
    tol: f64,
    control: Control<'a>,
    iterations: usize,
    members: usize,
    best: Option<Solution>,
}

impl<'a> Portfolio<'a> {
    fn new(problem: &'a Equilibrated<'a>, tol: f64, control: &Control<'a>) -> Self {
        Self { problem, tol, control: *control, iterations: 0, members: 0, best: None }
    }

    /// Runs one member with what is left of the caller's limits. `true` when its answer is final.
    fn run(&mut self, name: Member, method: impl FnOnce(&Control<'_>) -> Candidate) -> bool {
        let left = self.control.max_iterations.map(|limit| limit.saturating_sub(self.iterations));
        if self.members > 0 && (left == Some(0) || self.control.expired().is_some()) {
            return true;
        }
        let mut solution = judge(self.problem, method(&self.control.with_max_iterations(left)), name, self.tol);
        if let Some(polished) = polish::polished(self.problem, &solution, self.tol, &self.control) {
            solution = polished;
        }
        self.iterations += solution.iterations;
        self.members += 1;
        solution.iterations = self.iterations;
        let is_final = solution.status().is_answer();
        if is_final || self.best.as_ref().is_none_or(|best| rank(&solution) < rank(best)) {
            self.best = Some(solution);
        }
        is_final
    }

    fn finish(self) -> Solution {
        let mut solution = self.best.expect("invariant: every portfolio runs its first member");
        solution.iterations = self.iterations;
        if self.members > 1 && !solution.status().is_answer() {
            solution.message = format!("{} ({} attempts)", solution.message, self.members);
        }
        solution
    }
}

/// Which of two unsolved results to report: a limit that was hit says most, then a ray, then a breakdown; then the residual.
fn rank(solution: &Solution) -> (u8, f64) {
    let class = match solution.status() {
        Status::NumericalBreakdown if solution.certificate().is_some() => 0,
        Status::Solved | Status::Infeasible | Status::NearlyInfeasible => 0,
        Status::TimeLimit | Status::MaxIterations => 1,
        Status::SecondaryRay => 2,
        Status::NumericalBreakdown => 3,
    };
    (class, solution.residual)
}

/// From the guess, if there is one; then Lemke with d = e, then double-doubles, then random covering vectors.
pub(super) fn lemke(
    problem: &Equilibrated<'_>,
    restarts: usize,
    seed: u64,
    settings: &Settings,
    control: &Control<'_>,
) -> Solution {
    let mut portfolio = Portfolio::new(problem, settings.tol, control);
    if !from_guess(&mut portfolio, settings) {
        lemke_members(&mut portfolio, restarts, seed);
    }
    portfolio.finish()
}

/// Lemke's method from the support of `z0`: few pivots when it is nearly right; when it fails, all else is as without it.
fn from_guess(portfolio: &mut Portfolio<'_>, settings: &Settings) -> bool {
    let Some(alpha) = settings.z0.as_deref().map(support).filter(|alpha| !alpha.is_empty()) else { return false };
    let lcp = &portfolio.problem.lcp;
    portfolio.run(Member::LemkeWarm, |control| {
        let limit = control.max_iterations.unwrap_or(usize::MAX).min(20 + lcp.n());
        lemke::lemke_from::<f64>(lcp, &alpha, &control.with_max_iterations(Some(limit)))
    })
}

/// An interior point that is near a solution and did not become one of the accuracy of doubles: Lemke's method from its
/// support, in doubles, then in double-doubles.
pub(super) fn finished_by_pivots(
    problem: &Equilibrated<'_>,
    solution: Solution,
    settings: &Settings,
    control: &Control<'_>,
) -> Solution {
    let is_finished = matches!(solution.status(), Status::Infeasible | Status::NearlyInfeasible)
        || (solution.status() == Status::Solved && solution.residual <= FINISHED)
        || solution.residual > NEARLY;
    if is_finished || control.max_iterations.is_some() {
        return solution;
    }
    let lcp = &problem.lcp;
    let z = problem.scaling.z_from_caller(&solution.z);
    let w = slack(lcp, &z).0;
    let alpha: Vec<usize> = (0..z.len()).filter(|&i| z[i] > w[i]).collect();
    let limited = with_limit(control, 20 + lcp.n());
    for path in [lemke::lemke_from::<f64>, lemke::lemke_from::<Dd>] {
        let found = path(lcp, &alpha, &limited);
        let (pivots, ended) = (found.iterations, found.termination);
        let mut found = judge(problem, found, solution.method, settings.tol);
        if found.status() == Status::Solved && found.residual <= solution.residual {
            found.iterations = solution.iterations;
            found.message.push_str(&format!("; finished by {pivots} pivots of Lemke's method"));
            return found;
        }
        if matches!(ended, Termination::TimeLimit | Termination::Interrupted) && solution.status() != Status::Solved {
            let unfinished = Candidate::point(z, ended, solution.iterations);
            return judge(problem, unfinished, solution.method, settings.tol);
        }
        if lcp.n() > FINISH_IN_DOUBLE_DOUBLE_UP_TO {
            break;
        }
    }
    solution
}

/// What the finish of the interior point method should leave, and what it may start from.
const FINISHED: f64 = 1e-12;
const NEARLY: f64 = 1e-6;

/// Criss-cross in doubles, then in double-doubles where rounding hid a proof.
pub(super) fn principal_pivoting(problem: &Equilibrated<'_>, tol: f64, control: &Control<'_>) -> Solution {
    let mut portfolio = Portfolio::new(problem, tol, control);
    let lcp = &problem.lcp;
    portfolio.run(Member::PrincipalPivoting, |control| criss_cross::principal_pivoting::<f64>(lcp, control));
    let unclear = |best: &Solution| best.status() == Status::NumericalBreakdown && best.certificate().is_none();
    if portfolio.best.as_ref().is_some_and(unclear) {
        portfolio
            .run(Member::PrincipalPivotingDoubleDouble, |control| criss_cross::principal_pivoting::<Dd>(lcp, control));
    }
    portfolio.finish()
}

/// See the module. Members: Chandrasekaran (Z), the guess, block pivoting (P-like), Lemke-Howson (bimatrix), Lemke and its
/// restarts, the interior point method, successive linear programmes.
pub(super) fn auto(problem: &Equilibrated<'_>, settings: &Settings, control: &Control<'_>) -> Solution {
    let mut portfolio = Portfolio::new(problem, settings.tol, control);
    let lcp = &problem.lcp;
    let n = lcp.n();
    if chandrasekaran::positive_off_diagonal(lcp).is_none()
        && portfolio.run(Member::Chandrasekaran, |control| chandrasekaran::chandrasekaran(lcp, control))
    {
        return portfolio.finish();
    }
    // The transform costs as much as many factorisations of a large block.
    let warm_first = n <= WARM_PATH_FIRST_UP_TO;
    if warm_first && from_guess(&mut portfolio, settings) {
        return portfolio.finish();
    }
    let positive_diagonal = (0..n).all(|i| lcp.row(i)[i] > 0.0);
    if n >= BLOCK_PIVOTING_FROM && positive_diagonal {
        let options = block_pivoting::Settings {
            alpha: settings.z0.as_deref().map(support),
            murty: false,
            shift: if n > SHIFT_ABOVE && settings.certify == Certify::Float { SHIFT } else { 0.0 },
            ..block_pivoting::Settings::default()
        };
        let found = portfolio.run(Member::BlockPivoting, |control| {
            let limit = control.max_iterations.unwrap_or(usize::MAX).min(BLOCK_PIVOTING_BUDGET);
            block_pivoting::block_pivoting(lcp, &options, &control.with_max_iterations(Some(limit)))
        });
        if found {
            return portfolio.finish();
        }
    }
    if !warm_first && from_guess(&mut portfolio, settings) {
        return portfolio.finish();
    }
    if lemke_howson::bimatrix_split(lcp).is_some() {
        for label in [0, n / 2, n - 1] {
            let options = lemke_howson::Settings { label };
            if portfolio.run(Member::LemkeHowson, |control| lemke_howson::lemke_howson(lcp, &options, control)) {
                return portfolio.finish();
            }
        }
    }
    last_resorts(portfolio, settings)
}

/// What [`auto`] tries where A has no structure that helps: Lemke and its restarts, the interior point method, successive
/// linear programmes, all index sets.
fn last_resorts(mut portfolio: Portfolio<'_>, settings: &Settings) -> Solution {
    let problem = portfolio.problem;
    let lcp = &problem.lcp;
    if lemke_members(&mut portfolio, DEFAULT_RESTARTS, 0) {
        return portfolio.finish();
    }
    // Frictional contact under a heavy load: the pivots that matter are as small as the rounding of redundant rows.
    let options = interior_point::Settings::default();
    if portfolio.run(Member::InteriorPoint, |control| congruent::dense(problem, settings, &options, control)) {
        return portfolio.finish();
    }
    let options = bilinear::Settings::default();
    let programmes =
        |control: &Control<'_>| bilinear::bilinear(lcp, &options, &with_limit(control, pivots_worthwhile(lcp.n())));
    if !portfolio.run(Member::Bilinear, programmes) && lcp.n() <= ENUMERATE_UP_TO {
        portfolio.run(Member::Enumerate, |control| enumerate::enumerate(lcp, control));
    }
    portfolio.finish()
}

/// Pivots granted to successive linear programmes: what they solve they solve within a few n, and a pivot is O(n^2).
fn pivots_worthwhile(n: usize) -> usize {
    bilinear::default_limit(n).min((10 * n).max(PROGRAMMES_WORK / (n * n).max(1)))
}

/// `pivots n^2`: well below a second.
const PROGRAMMES_WORK: usize = 1_000_000_000;

/// Shift of the diagonal for singular symmetric problems, beside its largest entry: far above rounding, and so far below 1 that
/// one proximal step makes up for it. Not where a proof is asked for, which needs a nonsingular basis.
pub(super) const SHIFT: f64 = 1e-10;

/// Factorisations granted to block pivoting before the portfolio moves on.
const BLOCK_PIVOTING_BUDGET: usize = 25;

/// One linear programme decides whether FEA(q, A) is empty, whatever the class of A: the ray of Lemke's method need not.
fn feasible_point(lcp: &Lcp, control: &Control<'_>) -> Candidate {
    let found = feasibility::feasibility(lcp, control);
    let limited = control.max_iterations.is_some();
    let ended = |termination| Candidate::point(vec![0.0; lcp.n()], termination, found.iterations);
    match found.verdict {
        feasibility::Verdict::Infeasible(y) => Candidate { farkas: Some(y), ..ended(Termination::Infeasible) },
        feasibility::Verdict::Stopped(why @ (Termination::TimeLimit | Termination::Interrupted)) => ended(why),
        feasibility::Verdict::Stopped(why @ Termination::IterationLimit) if limited => ended(why),
        feasibility::Verdict::Feasible(_) | feasibility::Verdict::Stopped(_) => {
            ended(Termination::Breakdown("a linear programme did not show that FEA(q, A) is empty"))
        }
    }
}

/// From the support of a point within `tol`, in double-doubles: signs at the rounding level of doubles decide the basis.
fn from_near(portfolio: &mut Portfolio<'_>) -> bool {
    let near = portfolio.best.as_ref().filter(|best| polish::is_near(best, portfolio.tol));
    let Some(alpha) = near.map(|best| support(&best.z)) else { return false };
    let lcp = &portfolio.problem.lcp;
    portfolio
        .run(Member::LemkeDoubleDouble, |control| lemke::lemke_from::<Dd>(lcp, &alpha, &with_limit(control, lcp.n())))
}

/// `true` when one of them gave the final answer.
fn lemke_members(portfolio: &mut Portfolio<'_>, restarts: usize, seed: u64) -> bool {
    let lcp = &portfolio.problem.lcp;
    let n = lcp.n();
    let plain = lemke::Settings::default();
    if portfolio.run(Member::Lemke, |control| lemke::lemke::<f64>(lcp, &plain, control)) {
        return true;
    }
    let mut random = fastrand::Rng::with_seed(seed);
    for restart in 0..restarts {
        // (0.1, 1.1)^n: any fixed d can be attacked, a random one needs few pivots on Murty's and Fathi's examples.
        let d = (0..n).map(|_| 0.1 + random.f64()).collect();
        let options = lemke::Settings { d: Some(d) };
        if portfolio.run(Member::LemkeRandomD, |control| lemke::lemke::<f64>(lcp, &options, control)) {
            return true;
        }
        if restart > 0 {
            continue;
        }
        if from_near(portfolio) {
            return true;
        }
        if n <= DOUBLE_DOUBLE_UP_TO
            && portfolio.run(Member::LemkeDoubleDouble, |control| lemke::lemke::<Dd>(lcp, &plain, control))
        {
            return true;
        }
        if portfolio.run(Member::Feasibility, |control| feasible_point(lcp, control)) {
            return true;
        }
    }
    false
}

/// The same limits, and at most `limit` iterations.
pub(super) fn with_limit<'a>(control: &Control<'a>, limit: usize) -> Control<'a> {
    control.with_max_iterations(Some(control.max_iterations.map_or(limit, |own| own.min(limit))))
}
