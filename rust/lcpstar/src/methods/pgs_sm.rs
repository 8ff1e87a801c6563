//! Projected Gauss-Seidel with subspace minimisation: sweeps find the support, a direct solve on it finishes.
//! [MNS08], [SNE10]
//!
//! For symmetric PSD A the sweeps converge as in projected Gauss-Seidel, and once the support is right one solve ends the
//! method; a solve that brings no smaller residual is undone and the next round sweeps twice as often.

use crate::control::Control;
use crate::iterative::sweep::{DIVERGED, ROUNDING, SKIPPED, diverges};
use crate::iterative::{Goal, Incumbent, Matrix, Support, Sweep, start};
use crate::solution::Candidate;
use crate::status::Termination;

/// Options.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Sweeps before the first solve.
    pub sweeps: usize,
    /// Solves in a round: after each, indices with the wrong sign leave the support.
    pub solves: usize,
    /// The relaxation factor of the sweeps, in (0, 2).
    pub relaxation: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { sweeps: 5, solves: 4, relaxation: 1.0 }
    }
}

/// Sweeps when the caller sets no limit.
pub const DEFAULT_MAX_ITERATIONS: usize = 5000;
/// Sweeps of a round at most.
const LONGEST_ROUND: usize = 320;

/// Iterates from `z0` or 0; counts sweeps. O(n^2) a sweep, O(|alpha|^3) a solve.
#[must_use]
pub fn pgs_sm(
    matrix: &impl Matrix,
    goal: &Goal,
    settings: &Settings,
    z0: Option<&[f64]>,
    control: &Control<'_>,
) -> Candidate {
    let n = matrix.n();
    let sweep = Sweep::new(matrix, settings.relaxation);
    let (mut z, mut w) = start(matrix, z0);
    let mut best = Incumbent::new(goal, n);
    let mut subspace = Subspace::new(matrix, settings.solves, control);
    let (mut iterations, mut round, mut swept) = (0, settings.sweeps, 0);
    let termination = loop {
        if best.offer(matrix, &z, &w) {
            break Termination::Converged;
        }
        if let Some(reason) = control.stop(iterations, DEFAULT_MAX_ITERATIONS) {
            break reason;
        }
        let change = sweep.run(matrix, &mut z, &mut w, false);
        iterations += 1;
        swept += 1;
        if diverges(&z) {
            break Termination::Breakdown(DIVERGED);
        }
        if swept < round && change > 0.0 {
            continue;
        }
        matrix.affine(&z, &mut w);
        if best.offer(matrix, &z, &w) {
            break Termination::Converged;
        }
        let before = goal.measure(&z, &w).residual;
        let better = subspace.minimise(matrix, &sweep, &mut best, &z, &w);
        if subspace.reached {
            break Termination::Converged;
        }
        if better < before {
            z.copy_from_slice(&subspace.best_z);
            w.copy_from_slice(&subspace.best_w);
            round = settings.sweeps;
        } else if change == 0.0 {
            break Termination::Breakdown(if sweep.skips { SKIPPED } else { ROUNDING });
        } else {
            round = (2 * round).min(LONGEST_ROUND);
        }
        swept = 0;
    };
    Candidate::point(best.z, termination, iterations)
}

/// The solves of one round and the best projected point among them.
struct Subspace<'m> {
    support: Support<'m>,
    solves: usize,
    z: Vec<f64>,
    w: Vec<f64>,
    projected: Vec<f64>,
    best_z: Vec<f64>,
    /// `w` of the point measured last; of `best_z` in the end.
    best_w: Vec<f64>,
    reached: bool,
}

impl<'m> Subspace<'m> {
    fn new(matrix: &'m impl Matrix, solves: usize, control: &'m Control<'m>) -> Self {
        let zeros = || vec![0.0; matrix.n()];
        Self {
            support: Support::new(matrix, control),
            solves,
            z: zeros(),
            w: zeros(),
            projected: zeros(),
            best_z: zeros(),
            best_w: zeros(),
            reached: false,
        }
    }

    /// The least residual of the points `max(0, z)` that the solves lead to.
    fn minimise<M: Matrix>(
        &mut self,
        matrix: &'m M,
        sweep: &Sweep,
        best: &mut Incumbent<'_>,
        z: &[f64],
        w: &[f64],
    ) -> f64 {
        let mut least = f64::INFINITY;
        let support = &mut self.support;
        self.z.copy_from_slice(z);
        self.w.copy_from_slice(w);
        for solve in 0..self.solves {
            let (z, w) = (&mut self.z, &mut self.w);
            // First the indices that a sweep would keep positive; then those with the wrong sign leave and enter.
            let changed = support.choose(z.len(), |i| sweep.stays_positive(i, z, w));
            if (solve > 0 && changed == 0) || !support.solve(matrix, z, w) {
                break;
            }
            self.projected.iter_mut().zip(z.iter()).for_each(|(p, z)| *p = z.max(0.0));
            matrix.affine(&self.projected, &mut self.best_w);
            let measure = best.measure(&self.projected, &self.best_w);
            self.reached = best.offer_measured(matrix, &self.projected, measure);
            if measure.residual < least {
                least = measure.residual;
                self.best_z.copy_from_slice(&self.projected);
            }
            if self.reached {
                break;
            }
        }
        if least.is_finite() {
            matrix.affine(&self.best_z, &mut self.best_w);
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iterative::Dense;
    use crate::problem::Lcp;

    /// `B B' + shift I` with B of `rank` columns, and a planted complementary pair.
    fn planted(n: usize, rank: usize, shift: f64) -> (Lcp, Vec<f64>) {
        let b: Vec<f64> = (0..n * rank).map(|k| ((k * 7919 % 101) as f64) / 50.0 - 1.0).collect();
        let dot = |i: usize, j: usize| (0..rank).map(|k| b[i * rank + k] * b[j * rank + k]).sum::<f64>() / rank as f64;
        let a: Vec<f64> = (0..n * n).map(|k| dot(k / n, k % n) + if k / n == k % n { shift } else { 0.0 }).collect();
        let z: Vec<f64> = (0..n).map(|i| ((i * 37 % 11) as f64 - 5.0).max(0.0) / 5.0).collect();
        let q = (0..n).map(|i| if z[i] > 0.0 { 0.0 } else { 1.0 } - (0..n).map(|j| a[i * n + j] * z[j]).sum::<f64>());
        (Lcp::new(n, a.clone(), q.collect()).expect("valid"), z)
    }

    #[test]
    fn the_support_solve_ends_at_rounding_level() {
        let (lcp, expected) = planted(60, 60, 1e-3);
        let goal = Goal::plain(1e-13, lcp.q());
        let found = pgs_sm(&Dense::new(&lcp), &goal, &Settings::default(), None, &Control::default());
        assert_eq!(found.termination, Termination::Converged);
        assert!(found.iterations < 200, "{}", found.iterations);
        assert!(found.z.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-8));
    }

    #[test]
    fn a_singular_matrix_is_no_obstacle() {
        let (lcp, _) = planted(60, 20, 0.0);
        let goal = Goal::plain(1e-11, lcp.q());
        let found = pgs_sm(&Dense::new(&lcp), &goal, &Settings::default(), None, &Control::default());
        assert_eq!(found.termination, Termination::Converged);
    }

    #[test]
    fn what_the_sweeps_skip_the_solve_can_reach() {
        // A quadratic program with one equation: a zero on the diagonal.
        let lcp = Lcp::new(2, vec![1.0, -1.0, 1.0, 0.0], vec![0.5, -1.0]).expect("valid");
        let goal = Goal::plain(1e-12, lcp.q());
        let found = pgs_sm(&Dense::new(&lcp), &goal, &Settings::default(), Some(&[2.0, 2.0]), &Control::default());
        assert_eq!(found.termination, Termination::Converged);
        assert!((found.z[0] - 1.0).abs() < 1e-12 && (found.z[1] - 1.5).abs() < 1e-12, "{:?}", found.z);
    }
}
