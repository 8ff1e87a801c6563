//! Accelerated projected gradients with restart for symmetric A; forward-reflected-backward steps for other A.
//! [Nes83], [OC15], [MHNT15], [MT20]
//!
//! Symmetric PSD: `f(z) = z'Az / 2 + q'z` falls like O(1/k^2), faster with the restarts; the metric is the diagonal of A.
//! Not symmetric: there is no f, and momentum need not converge; `z <- max(0, z - s (2 w - w_previous))` does for
//! `A + A'` PSD, with s from the observed Lipschitz constant. One product with A an iteration either way.

use crate::control::Control;
use crate::iterative::sweep::{DIVERGED, diverges};
use crate::iterative::{Goal, Incumbent, Matrix, start};
use crate::solution::Candidate;
use crate::status::Termination;

/// Iterations when the caller sets no limit.
pub const DEFAULT_MAX_ITERATIONS: usize = 5000;
/// The step may grow by this factor an iteration.
const GROW: f64 = 1.02;
/// Momentum is recomputed from z after so many iterations: `A y` is carried along by linearity.
const REFRESH: usize = 64;

/// Iterates from `z0` or 0. O(n^2) an iteration, O(nnz) for a sparse A. The loop does not allocate.
#[must_use]
pub fn apgd(matrix: &impl Matrix, goal: &Goal, z0: Option<&[f64]>, control: &Control<'_>) -> Candidate {
    let (z, w) = start(matrix, z0);
    if matrix.is_symmetric() {
        accelerated(matrix, goal, z, w, control)
    } else {
        reflected(matrix, goal, z, w, control)
    }
}

/// `1 / a_ii`, or 1 where that is not positive: the metric of the gradient step.
fn metric(matrix: &impl Matrix) -> Vec<f64> {
    let entry = |i: usize| matrix.diagonal(i);
    (0..matrix.n()).map(|i| if entry(i) > 1e-8 { 1.0 / entry(i) } else { 1.0 }).collect()
}

/// Nesterov's method with backtracking on the step and a restart whenever the momentum points uphill.
fn accelerated(
    matrix: &impl Matrix,
    goal: &Goal,
    mut z: Vec<f64>,
    mut w: Vec<f64>,
    control: &Control<'_>,
) -> Candidate {
    let n = matrix.n();
    let metric = metric(matrix);
    // y = z + momentum and A y + q; the next z and its w.
    let (mut y, mut w_y) = (z.clone(), w.clone());
    let (mut next_z, mut next_w) = (z.clone(), w.clone());
    let mut best = Incumbent::new(goal, n);
    let (mut step, mut theta) = (1.0, 1.0_f64);
    let mut iterations = 0;
    let termination = loop {
        if best.offer(matrix, &z, &w) {
            break Termination::Converged;
        }
        if let Some(reason) = control.stop(iterations, DEFAULT_MAX_ITERATIONS) {
            break reason;
        }
        step *= GROW;
        loop {
            for i in 0..n {
                next_z[i] = (y[i] - step * metric[i] * w_y[i]).max(0.0);
            }
            matrix.affine(&next_z, &mut next_w);
            if is_short_enough(&metric, step, &next_z, &next_w, &y, &w_y) {
                break;
            }
            step *= 0.7;
        }
        iterations += 1;
        let uphill: f64 = (0..n).map(|i| w_y[i] * (next_z[i] - z[i])).sum();
        let next_theta = 0.5 * (theta * (theta * theta + 4.0).sqrt() - theta * theta);
        let momentum = if uphill > 0.0 { 0.0 } else { theta * (1.0 - theta) / (theta * theta + next_theta) };
        theta = if uphill > 0.0 { 1.0 } else { next_theta };
        for i in 0..n {
            y[i] = next_z[i] + momentum * (next_z[i] - z[i]);
            w_y[i] = next_w[i] + momentum * (next_w[i] - w[i]);
        }
        if iterations % REFRESH == 0 {
            matrix.affine(&y, &mut w_y);
        }
        std::mem::swap(&mut z, &mut next_z);
        std::mem::swap(&mut w, &mut next_w);
        if diverges(&z) {
            break Termination::Breakdown(DIVERGED);
        }
    };
    Candidate::point(best.z, termination, iterations)
}

/// `d'A d <= d'D d / step` for `d = next - y`: the quadratic model with that step is an upper bound.
fn is_short_enough(metric: &[f64], step: f64, next_z: &[f64], next_w: &[f64], y: &[f64], w_y: &[f64]) -> bool {
    let (mut curvature, mut square) = (0.0, 0.0);
    for i in 0..y.len() {
        let d = next_z[i] - y[i];
        curvature += d * (next_w[i] - w_y[i]);
        square += d * d / metric[i];
    }
    // Below the rounding of the curvature the test says nothing; a NaN passes and is seen later.
    step * curvature <= square * (1.0 + 1e-12) || curvature.is_nan() || step < 1e-12
}

/// The forward-reflected-backward method.
fn reflected(matrix: &impl Matrix, goal: &Goal, mut z: Vec<f64>, mut w: Vec<f64>, control: &Control<'_>) -> Candidate {
    let n = matrix.n();
    let metric = metric(matrix);
    let mut last_w = w.clone();
    let (mut next_z, mut next_w) = (z.clone(), w.clone());
    let mut best = Incumbent::new(goal, n);
    let (mut step, mut last_step) = (0.5, 0.5);
    let mut iterations = 0;
    let termination = loop {
        if best.offer(matrix, &z, &w) {
            break Termination::Converged;
        }
        if let Some(reason) = control.stop(iterations, DEFAULT_MAX_ITERATIONS) {
            break reason;
        }
        for i in 0..n {
            let reflected = step * w[i] + last_step * (w[i] - last_w[i]);
            next_z[i] = (z[i] - metric[i] * reflected).max(0.0);
        }
        matrix.affine(&next_z, &mut next_w);
        iterations += 1;
        // The next step: below half the inverse of the Lipschitz constant seen, in the metric.
        let lipschitz = observed_lipschitz(&metric, &next_z, &next_w, &z, &w);
        last_step = step;
        step = if lipschitz > 0.0 { (GROW * step).min(0.45 / lipschitz) } else { GROW * step };
        last_w.copy_from_slice(&w);
        std::mem::swap(&mut z, &mut next_z);
        std::mem::swap(&mut w, &mut next_w);
        if diverges(&z) {
            break Termination::Breakdown(DIVERGED);
        }
    };
    Candidate::point(best.z, termination, iterations)
}

/// `|A d| / |d|` for the last step d, in the norms of the metric.
fn observed_lipschitz(metric: &[f64], next_z: &[f64], next_w: &[f64], z: &[f64], w: &[f64]) -> f64 {
    let (mut change, mut square) = (0.0, 0.0);
    for i in 0..z.len() {
        let (d, v) = (next_z[i] - z[i], next_w[i] - w[i]);
        change += metric[i] * v * v;
        square += d * d / metric[i];
    }
    if square > 0.0 { (change / square).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iterative::Dense;
    use crate::problem::Lcp;

    fn solve(n: usize, a: Vec<f64>, q: Vec<f64>) -> Candidate {
        let lcp = Lcp::new(n, a, q).expect("valid");
        apgd(&Dense::new(&lcp), &Goal::plain(1e-9, lcp.q()), None, &Control::default())
    }

    #[test]
    fn singular_psd_converges() {
        let found = solve(2, vec![1.0, 1.0, 1.0, 1.0], vec![-2.0, -2.0]);
        assert_eq!(found.termination, Termination::Converged);
        assert!((found.z[0] + found.z[1] - 2.0).abs() < 1e-8);
    }

    #[test]
    fn a_rotation_converges_without_symmetry() {
        // Monotone, skew: plain projected gradients circle around the solution (1, 2).
        let found = solve(2, vec![0.0, 1.0, -1.0, 0.0], vec![-2.0, 1.0]);
        assert_eq!(found.termination, Termination::Converged);
        assert!((found.z[0] - 1.0).abs() < 1e-7 && (found.z[1] - 2.0).abs() < 1e-7, "{:?}", found.z);
    }

    #[test]
    fn unbounded_descent_ends() {
        let found = solve(2, vec![-1.0, 0.0, 0.0, 1.0], vec![-1.0, 1.0]);
        assert!(matches!(found.termination, Termination::Breakdown(_) | Termination::IterationLimit));
        assert!(found.z.iter().all(|z| z.is_finite()));
    }

    #[test]
    fn step_test_is_exact_on_a_diagonal() {
        // d'Ad = 4, d'd = 1: steps up to 1/4.
        assert!(is_short_enough(&[1.0], 0.25, &[1.0], &[4.0], &[0.0], &[0.0]));
        assert!(!is_short_enough(&[1.0], 0.26, &[1.0], &[4.0], &[0.0], &[0.0]));
    }
}
