//! What an answer must satisfy: the referee of the stress campaign scores it in exact arithmetic on the numbers that were given.

use crate::input::Problem;
use lcpstar::exact::dyadic::RationalVec;
use lcpstar::{Solution, Status};
use lcpstar_referee::{Answer, Case, Score};

/// The limits a call was given.
pub struct Limits {
    pub max_iterations: Option<usize>,
    pub may_run_out_of_time: bool,
    pub exact: bool,
}

/// An answer, its limits and its certificate.
pub fn check(problem: &Problem, solution: &Solution, tol: f64, limits: &Limits) {
    let n = problem.n;
    assert!(solution.alpha().iter().all(|&i| i < n), "alpha {:?}", solution.alpha());
    assert!(!solution.message().is_empty());
    if let Some(limit) = limits.max_iterations
        && !limits.exact
    {
        let (made, method) = (solution.iterations(), solution.method());
        assert!(made <= limit, "{made} iterations of {limit} in {method:?}");
    }
    match solution.status() {
        Status::SecondaryRay => assert!(solution.ray().is_some(), "a ray without a ray"),
        Status::TimeLimit => assert!(limits.may_run_out_of_time, "nobody set a time limit"),
        _ => {}
    }
    if let Some(ray) = solution.ray() {
        let numbers = ray.z.iter().chain(&ray.z_hat).chain(&ray.w_hat).chain(&ray.d).chain([&ray.z0, &ray.z0_hat]);
        assert!(!numbers.clone().any(|x| x.is_nan()), "{ray:?}");
    }
    score(problem, &Answer::from(solution.clone()), tol);
}

/// The point and what is said of it.
pub fn score(problem: &Problem, answer: &Answer, tol: f64) {
    assert!(answer.z.iter().all(|z| z.is_finite() && *z >= 0.0), "z = {:?}", answer.z);
    let numbers = answer.w.iter().chain([&answer.residual, &answer.natural_residual]);
    assert!(!numbers.clone().any(|x| x.is_nan()), "{answer:?}");
    if let Score::Wrong(why) = Case::new(problem).score(answer, tol) {
        panic!("{why}: {answer:?}");
    }
}

/// `z >= 0, w >= 0, z'w = 0`, exactly.
pub fn solves_exactly(problem: &Problem, z: &RationalVec) -> bool {
    problem.exact_solution(z).is_ok()
}

/// A direction that stays in the solution set: `r >= 0, A r >= 0, r'A r = 0`.
pub fn is_direction(problem: &Problem, r: &RationalVec) -> bool {
    problem.exact_direction(r).is_ok()
}
