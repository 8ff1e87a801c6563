//! Projected Gauss-Seidel and its over-relaxation (PSOR). [Cry71], [Man77], [CPS92, sec. 5.4]
//!
//! Converges linearly for symmetric PD A with relaxation in (0, 2), and for H+-matrices (M-matrices among them) with
//! relaxation up to 1; for symmetric PSD A with a positive diagonal `w` converges. Slow where masses differ: the rate is
//! 1 - O(1 / cond A).

use crate::control::Control;
use crate::iterative::sweep::{DIVERGED, REFRESH, ROUNDING, SKIPPED, STALLED, diverges};
use crate::iterative::{Goal, Incumbent, Matrix, Sweep, start};
use crate::linalg::kernels::max_abs;
use crate::solution::Candidate;
use crate::status::Termination;

/// Options.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The factor omega in (0, 2); 1 is Gauss-Seidel.
    pub relaxation: f64,
    /// Whether every other sweep runs downwards.
    pub symmetric: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { relaxation: 1.0, symmetric: false }
    }
}

/// Sweeps when the caller sets no limit.
pub const DEFAULT_MAX_ITERATIONS: usize = 5000;

/// Iterates from `z0` or 0. At most O(n^2) a sweep, O(nnz) for a sparse A: an index that stays at 0 costs O(1). The loop does
/// not allocate.
#[must_use]
pub fn pgs(
    matrix: &impl Matrix,
    goal: &Goal,
    settings: &Settings,
    z0: Option<&[f64]>,
    control: &Control<'_>,
) -> Candidate {
    let sweep = Sweep::new(matrix, settings.relaxation);
    let (mut z, mut w) = start(matrix, z0);
    let mut best = Incumbent::new(goal, matrix.n());
    let mut iterations = 0;
    let termination = loop {
        if best.offer(matrix, &z, &w) {
            break Termination::Converged;
        }
        if let Some(reason) = control.stop(iterations, DEFAULT_MAX_ITERATIONS) {
            break reason;
        }
        let change = sweep.run(matrix, &mut z, &mut w, settings.symmetric && iterations % 2 == 1);
        iterations += 1;
        if iterations % REFRESH == 0 {
            matrix.affine(&z, &mut w);
        }
        if change <= STALLED * max_abs(&z) {
            break Termination::Breakdown(if sweep.skips { SKIPPED } else { ROUNDING });
        }
        if diverges(&z) {
            break Termination::Breakdown(DIVERGED);
        }
    };
    Candidate::point(best.z, termination, iterations)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iterative::{Dense, Sparse};
    use crate::problem::Lcp;
    use crate::sparse::SparseLcp;

    #[test]
    fn positive_definite_converges_with_every_option() {
        let lcp =
            Lcp::new(3, vec![4.0, 1.0, 1.0, 1.0, 3.0, -1.0, 1.0, -1.0, 2.0], vec![-1.0, 2.0, -3.0]).expect("valid");
        let goal = Goal::plain(1e-12, lcp.q());
        for relaxation in [0.5, 1.0, 1.7] {
            for symmetric in [false, true] {
                let settings = Settings { relaxation, symmetric };
                let found = pgs(&Dense::new(&lcp), &goal, &settings, None, &Control::default());
                assert_eq!(found.termination, Termination::Converged, "{settings:?}");
                assert!(found.z.iter().zip([0.0, 0.0, 1.5]).all(|(z, e)| (z - e).abs() < 1e-11), "{:?}", found.z);
            }
        }
    }

    #[test]
    fn a_zero_diagonal_is_a_reason_not_a_division() {
        // w_1 = z_0 - 1 with a_11 = 0: the sweep can do nothing about row 1.
        let lcp = Lcp::new(2, vec![1.0, -1.0, 1.0, 0.0], vec![-0.5, -1.0]).expect("valid");
        let goal = Goal::plain(1e-9, lcp.q());
        let found = pgs(&Dense::new(&lcp), &goal, &Settings::default(), None, &Control::default());
        assert_eq!(found.termination, Termination::Breakdown(SKIPPED));
        assert_eq!(found.z, [0.5, 0.0]);
    }

    #[test]
    fn divergence_ends() {
        let lcp = Lcp::new(2, vec![1.0, -3.0, -3.0, 1.0], vec![-1.0, -1.0]).expect("valid");
        let goal = Goal::plain(1e-9, lcp.q());
        let found = pgs(&Dense::new(&lcp), &goal, &Settings::default(), None, &Control::default());
        assert_eq!(found.termination, Termination::Breakdown(DIVERGED));
        assert!(found.z.iter().all(|z| z.is_finite()));
    }

    #[test]
    fn sparse_walks_the_same_path() {
        let n: usize = 60;
        let mut entries = (vec![0], vec![], vec![]);
        for i in 0..n {
            for j in i.saturating_sub(1)..(i + 2).min(n) {
                entries.1.push(j);
                entries.2.push(if i == j { 2.5 } else { -1.0 });
            }
            entries.0.push(entries.1.len());
        }
        let q = (0..n).map(|i| ((i * 7) % 11) as f64 / 6.0 - 1.0).collect();
        let lcp = SparseLcp::new(entries.0, entries.1, entries.2, q).expect("valid");
        let goal = Goal::plain(1e-10, lcp.q());
        let sparse = pgs(&Sparse::new(&lcp), &goal, &Settings::default(), None, &Control::default());
        let dense = pgs(&Dense::new(&lcp.to_dense()), &goal, &Settings::default(), None, &Control::default());
        assert_eq!(sparse.termination, Termination::Converged);
        assert_eq!(sparse.iterations, dense.iterations);
        assert!(sparse.z.iter().zip(&dense.z).all(|(a, b)| (a - b).abs() < 1e-13));
    }
}
