//! Newton's method on `min(z, A z + q) = 0`: the primal-dual active set method, with an interior path as its safeguard.
//! [HIK03], [Meh92]
//!
//! A Newton step guesses `alpha = {i : z_i > w_i}` and solves `A[alpha, alpha] z_alpha = -q_alpha`. Finite and monotone for
//! M-matrices, quick from any start near a solution; alone it cycles on P-matrices of order 3 [BG12], and on a grid its free
//! boundary may move by one point a step. So when the guesses stop settling, predictor-corrector steps along the path
//! `z_i w_i = mu` take over, for monotone A without fail; each time mu has fallen by 100 the active set method tries again
//! from there.

mod path;

use crate::control::Control;
use crate::iterative::{Goal, Incumbent, Matrix, Support, start};
use crate::solution::Candidate;
use crate::status::Termination;
use path::InteriorPath;

/// Options.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Guesses in a row that may change as many indices as the best before, until the interior path takes over.
    pub patience: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { patience: 3 }
    }
}

/// Factorisations when the caller sets no limit.
pub const DEFAULT_MAX_ITERATIONS: usize = 200;

/// Iterates from `z0` or 0; counts factorisations. O(|alpha|^3) a guess, O(n^3) a step on the path; a sparse
/// factorisation each for a sparse A.
#[must_use]
pub fn newton(
    matrix: &impl Matrix,
    goal: &Goal,
    settings: &Settings,
    z0: Option<&[f64]>,
    control: &Control<'_>,
) -> Candidate {
    let n = matrix.n();
    let (z, w) = start(matrix, z0);
    let mut best = Incumbent::new(goal, n);
    if best.offer(matrix, &z, &w) {
        return Candidate::point(best.z, Termination::Converged, 0);
    }
    let mut path = InteriorPath::new(matrix.factors(), n);
    let mut active = ActiveSet::new(Support::new(matrix, control), z, w, settings.patience);
    let mut iterations = 0;
    let mut guessing = true;
    let termination = loop {
        if let Some(reason) = control.stop(iterations, DEFAULT_MAX_ITERATIONS) {
            break reason;
        }
        iterations += 1;
        if guessing {
            match active.advance(matrix, &mut best) {
                Step::Reached => break Termination::Converged,
                Step::Settling => {}
                Step::Stalled => guessing = false,
            }
        } else {
            match path.advance(matrix, control) {
                path::Step::Near => {
                    active.restart(&path.z, &path.w);
                    guessing = true;
                }
                path::Step::Far => {}
                path::Step::Stuck(reason) => break control.expired().unwrap_or(Termination::Breakdown(reason)),
            }
        }
    };
    Candidate::point(best.z, termination, iterations)
}

/// How a guess went.
enum Step {
    /// The goal is reached.
    Reached,
    /// The guesses still settle.
    Settling,
    /// They do not.
    Stalled,
}

/// The active set iteration between two restarts.
struct ActiveSet<'m> {
    support: Support<'m>,
    z: Vec<f64>,
    w: Vec<f64>,
    clipped: Vec<f64>,
    clipped_w: Vec<f64>,
    /// The fewest indices that a guess changed.
    fewest: usize,
    patience: usize,
    left: usize,
}

impl<'m> ActiveSet<'m> {
    fn new(support: Support<'m>, z: Vec<f64>, w: Vec<f64>, patience: usize) -> Self {
        let (clipped, clipped_w) = (z.clone(), w.clone());
        Self { support, z, w, clipped, clipped_w, fewest: usize::MAX, patience, left: patience }
    }

    /// From a point of the path: there the guesses settle at once or not yet.
    fn restart(&mut self, z: &[f64], w: &[f64]) {
        self.z.copy_from_slice(z);
        self.w.copy_from_slice(w);
        (self.fewest, self.left, self.patience) = (usize::MAX, 1, 1);
    }

    /// One guess, one factorisation.
    fn advance(&mut self, matrix: &impl Matrix, best: &mut Incumbent<'_>) -> Step {
        let n = self.z.len();
        let (z, w) = (&self.z, &self.w);
        let first = self.fewest == usize::MAX;
        let changed = self.support.choose(n, |i| z[i] > w[i]);
        if changed == 0 && !first {
            return Step::Stalled; // the same set again, and its point was not good enough
        }
        if !self.support.solve(matrix, &mut self.z, &mut self.w) {
            return Step::Stalled;
        }
        self.clipped.copy_from_slice(&self.z);
        self.clipped_w.copy_from_slice(&self.w);
        if best.offer_clipped(matrix, &mut self.clipped, &mut self.clipped_w) {
            return Step::Reached;
        }
        // Settling means halving: a free boundary that moves by one point a guess does not settle.
        if first {
            self.fewest = n + 1;
        } else if 2 * changed <= self.fewest {
            self.fewest = changed;
            self.left = self.patience;
        } else {
            self.left = self.left.saturating_sub(1);
        }
        if self.left == 0 { Step::Stalled } else { Step::Settling }
    }
}

#[cfg(test)]
mod tests;
