//! The kernel for small problems in front of the portfolio of `"auto"`.

use super::{Certify, Method, Settings};
use crate::control::Control;
use crate::linalg::kernels;
use crate::presolve;
use crate::problem::Lcp;
use crate::residual::natural_residual;
use crate::small::{TINY_ORDER, TinySolution, solve_one};
use crate::solution::{Certificate, Solution};
use crate::status::Status;

/// Up to this order the kernel goes before everything else; above it, block pivoting goes before it where it can.
const FIRST_UP_TO: usize = 32;

/// The kernel's verified answer, where presolve leaves the problem whole. `None` says nothing about the problem.
pub(super) fn solve(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    let n = lcp.n();
    let whole = n <= TINY_ORDER && presolve::plan(lcp).is_none() && !block_pivoting_first(lcp);
    if whole { solve_part(lcp, settings, control) } else { None }
}

/// Whether block pivoting is tried before the kernel: for symmetric A with a positive diagonal, above a certain order.
pub(super) fn block_pivoting_first(lcp: &Lcp) -> bool {
    let n = lcp.n();
    n > FIRST_UP_TO && (0..n).all(|i| lcp.row(i)[i] > 0.0) && kernels::is_symmetric(n, lcp.a())
}

/// As [`solve`], for a problem that presolve has left in one part.
pub(super) fn solve_part(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    let plain = matches!(settings.method, Method::Auto)
        && settings.z0.is_none()
        && settings.certify == Certify::Float
        && settings.tol > 0.0
        && settings.tol < 1.0
        && control.max_iterations.is_none();
    if plain { solve_one(lcp.n(), lcp.a(), lcp.q(), settings.tol).map(|answer| solved(&answer)) } else { None }
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
