//! One small problem at a time, without a single allocation: Lemke's method in reused memory, verified by
//! the rule of `certify`. `solve` tries it first; the batch runs it and its lanes on whole arrays of problems.
//!
//! A time limit is not looked at: the limit on pivots ends a run of order 128 within a few milliseconds.

pub(crate) mod ahead;
#[cfg(target_arch = "x86_64")]
pub(crate) mod avx;
pub(crate) mod covering;
pub(crate) mod dispatch;
pub(crate) mod lane;
pub(crate) mod lemke;
pub(crate) mod ratio;
pub(crate) mod tableau;
pub(crate) mod verify;

use ahead::Ahead;
use dispatch::{Task, run};
use verify::Judged;

/// Largest order that [`solve`] takes.
pub const TINY_ORDER: usize = 128;

/// A verified solution, beside its z and w.
#[derive(Clone, Copy, Debug)]
pub struct Verified {
    /// Bit i: z_i is basic.
    pub alpha: u128,
    /// Pivots.
    pub iterations: usize,
    /// Bound of the scale-free residual, at most `tol`.
    pub residual: f64,
    /// Bound of the natural residual in the caller's units.
    pub natural_residual: f64,
}

/// What the kernel has to say about a problem.
#[derive(Clone, Copy, Debug)]
pub enum Answer {
    /// A verified solution.
    Solved(Verified),
    /// The basis on which the method ended, whose point could not be verified as it stands.
    Basis {
        /// Bit i: z_i is in it.
        alpha: u128,
        /// Pivots.
        iterations: usize,
    },
    /// Nothing.
    None,
}

/// Solves and verifies LCP(q, A) by Lemke's method, `a` row-major; writes z and `w = A z + q`. O(n^2) a pivot; after the first
/// call on a thread for the largest n, nothing is allocated.
///
/// [`Answer::None`] says nothing about the problem (n too large, a ray, a number that is not finite): ask the general solver.
#[must_use]
pub fn solve(a: &[f64], q: &[f64], tol: f64, z: &mut [f64], w: &mut [f64]) -> Answer {
    if !fits(a, q, z, w) {
        return Answer::None;
    }
    let mut basic = [false; TINY_ORDER];
    let basic = &mut basic[..q.len()];
    let outcome = run(Task::Solve { z, basic, ahead: &mut Ahead::default() }, a, q, w, tol);
    if !outcome.found_basis {
        return Answer::None;
    }
    let (alpha, iterations) = (bits(basic.iter().copied()), outcome.pivots);
    match outcome.judged {
        Some(judged) => Answer::Solved(Verified::new(judged, alpha, iterations)),
        None => Answer::Basis { alpha, iterations },
    }
}

/// A point that was found elsewhere, `z >= 0`, verified; w is written, and alpha its support. O(n^2), otherwise as [`solve`].
#[must_use]
pub fn verify_point(a: &[f64], q: &[f64], tol: f64, z: &[f64], w: &mut [f64]) -> Option<Verified> {
    if !fits(a, q, z, w) {
        return None;
    }
    let alpha = bits(z.iter().map(|&z| z > 0.0));
    let judged = run(Task::Verify { z }, a, q, w, tol).judged?;
    Some(Verified::new(judged, alpha, 0))
}

impl Verified {
    const fn new(judged: Judged, alpha: u128, iterations: usize) -> Self {
        let Judged { residual, natural_residual, .. } = judged;
        Self { alpha, iterations, residual, natural_residual }
    }
}

fn fits(a: &[f64], q: &[f64], z: &[f64], w: &[f64]) -> bool {
    let n = q.len();
    (1..=TINY_ORDER).contains(&n) && a.len() == n * n && z.len() == n && w.len() == n
}

fn bits(yes: impl Iterator<Item = bool>) -> u128 {
    yes.enumerate().fold(0, |bits, (i, yes)| bits | u128::from(yes) << i)
}
