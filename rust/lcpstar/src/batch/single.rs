//! One problem by the fastest road: the small kernel of the batch first, the driver behind it.

use super::tiny::{TinySolution, solve_one};
use crate::control::Control;
use crate::driver::{self, Certify, Method, Settings};
use crate::error::Result;
use crate::problem::Lcp;
use crate::residual::natural_residual;
use crate::solution::{Certificate, Solution};
use crate::status::Status;

/// Up to this order the driver does not look for islands either.
const WHOLE_UP_TO: usize = 16;

/// As [`driver::solve`], with the kernel for small problems in front of the portfolio of `"auto"`.
///
/// # Errors
/// As [`driver::solve`].
pub fn solve(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Result<Solution> {
    let plain = matches!(settings.method, Method::Auto)
        && settings.z0.is_none()
        && settings.certify == Certify::Float
        && settings.tol > 0.0
        && settings.tol < 1.0
        && control.max_iterations.is_none();
    // Above that order a zero may mean islands, which the driver solves apart.
    let whole = lcp.n() <= WHOLE_UP_TO || lcp.a().iter().all(|&a| a != 0.0);
    let answer = if plain && whole { solve_one(lcp.n(), lcp.a(), lcp.q(), settings.tol) } else { None };
    match answer {
        Some(answer) => Ok(solved(&answer)),
        None => driver::solve(lcp, settings, control),
    }
}

/// The kernel verified its answer by the rule of [`certify`](crate::certify::certify).
fn solved(answer: &TinySolution) -> Solution {
    let alpha: Vec<usize> = (0..answer.n).filter(|i| answer.alpha >> i & 1 == 1).collect();
    let (z, w) = (answer.z().to_vec(), answer.w().to_vec());
    Solution {
        natural_residual: natural_residual(&z, &w),
        z,
        w,
        status: Status::Solved,
        method: if alpha.is_empty() { "trivial" } else { "lemke_small" },
        iterations: answer.iterations,
        residual: answer.residual,
        certificate: Some(Certificate::Solution { alpha: alpha.clone(), exact: None }),
        alpha,
        ray: None,
        pieces: vec![],
        message: "solved: verified on the caller's numbers".into(),
    }
}
