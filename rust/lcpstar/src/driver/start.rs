//! The answers that cost no pivot.

use super::doubt;
use super::settings::{Method, Settings};
use crate::equilibrate::{Equilibrated, Rows};
use crate::judge::judge;
use crate::member::Member;
use crate::pivoting::basis::basic_point;
use crate::solution::{Candidate, Solution};
use crate::status::Termination;

/// `q >= 0`, or a guess that is right.
pub(super) fn at_once(problem: &Equilibrated<'_>, settings: &Settings) -> Option<Solution> {
    let from_values = matches!(settings.method, Method::Approximate(_));
    trivial(problem, settings.tol).or_else(|| if from_values { None } else { warm(problem, settings) })
}

/// `q >= 0`: z = 0 solves the problem, whatever A is.
pub(super) fn trivial<P: Rows>(problem: &Equilibrated<'_, P>, tol: f64) -> Option<Solution> {
    problem.original.q().iter().all(|&q| q >= 0.0).then(|| {
        let z = vec![0.0; problem.original.n()];
        let candidate = Candidate { alpha: Some(vec![]), ..Candidate::point(z, Termination::ComplementaryBasis, 0) };
        judge(problem, candidate, Member::Trivial, tol)
    })
}

/// The support of `z0`, then `z0` itself, is tried as it is: right, it costs one factorisation and no pivot.
fn warm(problem: &Equilibrated<'_>, settings: &Settings) -> Option<Solution> {
    let z0 = settings.z0.as_deref()?;
    let alpha = support(z0);
    let basic = basic_point(&problem.lcp, &alpha).map(|z| (z, Some(alpha)));
    let given = Some((problem.scaling.z_from_caller(z0), None));
    [basic, given].into_iter().flatten().find_map(|(z, alpha)| {
        let candidate = Candidate { alpha, ..Candidate::point(z, Termination::ComplementaryBasis, 0) };
        let solution = judge(problem, candidate, Member::WarmStart, settings.tol);
        (solution.is_solved() && !doubt::misses_q(problem.original, &solution)).then_some(solution)
    })
}

/// Indices of the positive entries.
pub(super) fn support(z: &[f64]) -> Vec<usize> {
    (0..z.len()).filter(|&i| z[i] > 0.0).collect()
}
