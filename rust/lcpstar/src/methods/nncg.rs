//! Nonsmooth nonlinear conjugate gradients: Fletcher-Reeves steps on the residual of a Gauss-Seidel sweep. [SNE10b]
//!
//! A sweep is a fixed-point map `P`; `z - P(z)` plays the gradient. No proof of convergence is known; a restart, which is
//! a plain sweep, follows whenever that gradient or the residual grows, so the method does not fall far behind
//! projected Gauss-Seidel, and is usually several times faster on stacks.

use crate::control::Control;
use crate::iterative::sweep::{DIVERGED, REFRESH, ROUNDING, SKIPPED, STALLED, diverges};
use crate::iterative::{Goal, Incumbent, Matrix, Sweep, start};
use crate::linalg::kernels::{axpy, dot, max_abs};
use crate::solution::Candidate;
use crate::status::Termination;

/// Sweeps when the caller sets no limit.
pub const DEFAULT_MAX_ITERATIONS: usize = 5000;
/// A residual that grew by this factor since the best is a restart.
const GROWTH: f64 = 10.0;

/// Iterates from `z0` or 0. A sweep and O(n): `A p` follows from the change of w in the sweep. The loop does not allocate.
#[must_use]
pub fn nncg(matrix: &impl Matrix, goal: &Goal, z0: Option<&[f64]>, control: &Control<'_>) -> Candidate {
    nncg_while(matrix, goal, z0, control, |_, _| true)
}

/// As [`nncg`], as long as `promising(sweeps, least residual)` says so; asked after each sweep.
#[must_use]
pub fn nncg_while(
    matrix: &impl Matrix,
    goal: &Goal,
    z0: Option<&[f64]>,
    control: &Control<'_>,
    mut promising: impl FnMut(usize, f64) -> bool,
) -> Candidate {
    let n = matrix.n();
    let sweep = Sweep::new(matrix, 1.0);
    let (mut z, mut w) = start(matrix, z0);
    let (mut before_z, mut before_w) = (z.clone(), w.clone());
    // The direction p and A p.
    let (mut p, mut a_p) = (vec![0.0; n], vec![0.0; n]);
    let mut best = Incumbent::new(goal, n);
    let mut last_square = f64::INFINITY;
    let mut iterations = 0;
    let mut reached = best.offer(matrix, &z, &w);
    let termination = loop {
        if reached {
            break Termination::Converged;
        }
        if let Some(reason) = control.stop(iterations, DEFAULT_MAX_ITERATIONS) {
            break reason;
        }
        before_z.copy_from_slice(&z);
        before_w.copy_from_slice(&w);
        let change = sweep.run(matrix, &mut z, &mut w, false);
        iterations += 1;
        let measure = goal.measure(&z, &w);
        let grown = measure.residual > GROWTH * best.residual;
        reached = best.offer_measured(matrix, &z, measure);
        if !reached && !promising(iterations, best.residual) {
            break Termination::IterationLimit;
        }
        if change <= STALLED * max_abs(&z) {
            break Termination::Breakdown(if sweep.skips { SKIPPED } else { ROUNDING });
        }
        if diverges(&z) {
            break Termination::Breakdown(DIVERGED);
        }
        // -gradient = z - before_z, and A times it = w - before_w.
        before_z.iter_mut().zip(&z).for_each(|(b, z)| *b = z - *b);
        before_w.iter_mut().zip(&w).for_each(|(b, w)| *b = w - *b);
        let square = dot(&before_z, &before_z);
        let beta = square / last_square;
        last_square = square;
        if beta > 1.0 || grown {
            // Not -gradient: a plain sweep takes that step anyway, and the next restart would follow at once.
            p.fill(0.0);
            a_p.fill(0.0);
        } else {
            axpy(beta, &p, &mut z);
            axpy(beta, &a_p, &mut w);
            p.iter_mut().zip(&before_z).for_each(|(p, d)| *p = beta * *p + d);
            a_p.iter_mut().zip(&before_w).for_each(|(p, d)| *p = beta * *p + d);
        }
        if iterations % REFRESH == 0 {
            matrix.affine(&z, &mut w);
        }
    };
    Candidate::point(best.z, termination, iterations)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iterative::Dense;
    use crate::methods::pgs;
    use crate::problem::Lcp;

    /// A chain: tridiagonal, condition number about n^2.
    fn chain(n: usize) -> Lcp {
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        };
        let a = (0..n * n).map(|k| entry(k / n, k % n)).collect();
        Lcp::new(n, a, (0..n).map(|i| if i % 3 == 0 { -1.0 } else { 0.2 }).collect()).expect("valid")
    }

    #[test]
    fn a_chain_needs_far_fewer_sweeps_than_gauss_seidel() {
        let lcp = chain(40);
        let goal = Goal::plain(1e-8, lcp.q());
        let matrix = Dense::new(&lcp);
        let found = nncg(&matrix, &goal, None, &Control::default());
        let plain = pgs::pgs(&matrix, &goal, &pgs::Settings::default(), None, &Control::default());
        assert_eq!((found.termination, plain.termination), (Termination::Converged, Termination::Converged));
        assert!(3 * found.iterations < plain.iterations, "{} against {}", found.iterations, plain.iterations);
    }

    #[test]
    fn a_warm_start_at_the_solution_costs_no_sweep() {
        let lcp = chain(10);
        let goal = Goal::plain(1e-9, lcp.q());
        let matrix = Dense::new(&lcp);
        let found = nncg(&matrix, &goal, None, &Control::default());
        assert_eq!(nncg(&matrix, &goal, Some(&found.z), &Control::default()).iterations, 0);
    }
}
