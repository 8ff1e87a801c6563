//! The kernel for small problems in front of the portfolio of `"auto"`.

use super::{Certify, Method, Settings};
use crate::control::Control;
use crate::problem::Lcp;
use crate::residual::natural_residual;
use crate::small::{TinySolution, solve_one};
use crate::solution::{Certificate, Solution};
use crate::status::Status;

/// Up to this order islands stay whole.
const WHOLE_UP_TO: usize = 16;

/// The kernel's verified answer, where the settings ask for nothing it cannot do. `None` says nothing about the problem.
pub(super) fn solve(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    let plain = matches!(settings.method, Method::Auto)
        && settings.z0.is_none()
        && settings.certify == Certify::Float
        && settings.tol > 0.0
        && settings.tol < 1.0
        && control.max_iterations.is_none();
    // Above that order a zero may mean islands, which are solved apart.
    let whole = lcp.n() <= WHOLE_UP_TO || lcp.a().iter().all(|&a| a != 0.0);
    if plain && whole { solve_one(lcp.n(), lcp.a(), lcp.q(), settings.tol).map(|answer| solved(&answer)) } else { None }
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
