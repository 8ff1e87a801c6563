//! One small problem at a time, without a single allocation: Lemke's method in reused memory, verified by
//! a rule that is stricter than that of the judge. `solve` tries it first; the batch runs it and its lanes on whole arrays of problems.
//!
//! A time limit is not looked at: the limit on pivots ends a run of order 128 within a few milliseconds.

#[cfg(target_arch = "x86_64")]
pub mod avx;
pub mod covering;
pub mod dispatch;
pub mod lane;
pub mod lemke;
pub mod prefetch;
pub mod ratio;
pub mod scales;
pub mod tableau;
pub mod verify;

pub use crate::cutovers::TINY_ORDER;
use dispatch::{Task, run};
use prefetch::Prefetch;
pub use verify::Accepted;

/// What the kernel has to say about a problem.
#[derive(Clone, Copy, Debug)]
pub enum Answer {
    /// A solution that was accepted.
    Solved {
        /// By whom.
        accepted: Accepted,
        /// Bit i: z_i is basic.
        alpha: u128,
        /// Pivots.
        iterations: usize,
    },
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
    let outcome = run(Task::Solve { z, basic, prefetch: &mut Prefetch::default() }, a, q, w, tol);
    if !outcome.found_basis {
        return Answer::None;
    }
    let (alpha, iterations) = (bits(basic.iter().copied()), outcome.pivots);
    match outcome.accepted {
        Some(accepted) => Answer::Solved { accepted, alpha, iterations },
        None => Answer::Basis { alpha, iterations },
    }
}

/// A point that was found elsewhere, `z >= 0`, judged; w is written. O(n^2), otherwise as [`solve`].
#[must_use]
pub fn verify_point(a: &[f64], q: &[f64], tol: f64, z: &[f64], w: &mut [f64]) -> Option<Accepted> {
    if !fits(a, q, z, w) {
        return None;
    }
    run(Task::Verify { z }, a, q, w, tol).accepted
}

fn fits(a: &[f64], q: &[f64], z: &[f64], w: &[f64]) -> bool {
    let n = q.len();
    (1..=TINY_ORDER).contains(&n) && a.len() == n * n && z.len() == n && w.len() == n
}

fn bits(yes: impl Iterator<Item = bool>) -> u128 {
    yes.enumerate().fold(0, |bits, (i, yes)| bits | u128::from(yes) << i)
}
