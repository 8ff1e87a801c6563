//! Block principal pivoting. [JP94], [KP11]
//!
//! Guess `alpha`, solve `A[alpha, alpha] z_alpha = -q_alpha`, and exchange every index whose sign is wrong; when the
//! number of wrong signs stops falling, exchange only the largest such index (Murty's rule [Mur74], finite for P).
//! For a P-matrix it ends at the unique solution, typically after 2 to 8 factorisations, whatever n.

use crate::control::Control;
use crate::pivoting::basis::basic_point;
use crate::problem::Lcp;
use crate::residual::slack;
use crate::solution::Candidate;
use crate::status::Termination;

/// Options of block principal pivoting.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Block exchanges that may fail to reduce the number of wrong signs before Murty's rule takes over.
    pub patience: usize,
    /// First guess of the index set with `z_i > 0`; `None`: `{i : q_i < 0}`.
    pub alpha: Option<Vec<usize>>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { patience: 5, alpha: None }
    }
}

/// Factorisations allowed when the caller gives no limit.
#[must_use]
pub fn default_limit(n: usize) -> usize {
    30 + n
}

/// Solves LCP(q, A) for a P-matrix A. O(|alpha|^3 + n^2) an iteration.
#[must_use]
pub fn block_pivoting(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    let mut in_alpha = vec![false; n];
    match &settings.alpha {
        Some(alpha) => alpha.iter().for_each(|&i| in_alpha[i] = true),
        None => in_alpha.iter_mut().zip(lcp.q()).for_each(|(a, &q)| *a = q < 0.0),
    }
    let (mut fewest, mut patience) = (n + 1, settings.patience);
    let mut iterations = 0;
    let mut z = vec![0.0; n];
    let termination = loop {
        if let Some(reason) = control.stop(iterations, default_limit(n)) {
            break reason;
        }
        let alpha = members(&in_alpha);
        match basic_point(lcp, &alpha) {
            Some(point) => z = point,
            None => break Termination::Breakdown("A[alpha, alpha] became singular: A is not a P-matrix"),
        }
        iterations += 1;
        let (w, magnitude) = slack(lcp, &z);
        let wrong = |i: usize| if in_alpha[i] { z[i] < 0.0 } else { w[i] < -SIGN * magnitude[i] };
        let infeasible: Vec<usize> = (0..n).filter(|&i| wrong(i)).collect();
        let Some(&last) = infeasible.last() else {
            break Termination::ComplementaryBasis;
        };
        if infeasible.len() < fewest {
            fewest = infeasible.len();
            patience = settings.patience;
        } else if patience > 0 {
            patience -= 1;
        }
        if patience > 0 {
            infeasible.iter().for_each(|&i| in_alpha[i] = !in_alpha[i]);
        } else {
            in_alpha[last] = !in_alpha[last];
        }
    };
    let alpha = (termination == Termination::ComplementaryBasis).then(|| members(&in_alpha));
    Candidate { alpha, ..Candidate::point(z, termination, iterations) }
}

/// `w_i` counts as negative below `-SIGN (|A||z| + |q|)_i`: rounding must not exchange an index for ever.
const SIGN: f64 = 4.0 * f64::EPSILON;

fn members(in_alpha: &[bool]) -> Vec<usize> {
    (0..in_alpha.len()).filter(|&i| in_alpha[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reproducible symmetric positive definite problem with a planted solution.
    #[test]
    fn positive_definite_in_few_factorisations() {
        let n = 40;
        let b: Vec<f64> = (0..n * n).map(|k| ((k * 7919 % 101) as f64) / 50.0 - 1.0).collect();
        let dot = |i: usize, j: usize| (0..n).map(|k| b[i * n + k] * b[j * n + k]).sum::<f64>();
        let a: Vec<f64> = (0..n * n).map(|k| dot(k / n, k % n) + if k / n == k % n { 1.0 } else { 0.0 }).collect();
        let z: Vec<f64> = (0..n).map(|i| ((i * 37 % 11) as f64 - 5.0).max(0.0)).collect();
        let q = (0..n).map(|i| if z[i] > 0.0 { 0.0 } else { 1.0 } - (0..n).map(|j| a[i * n + j] * z[j]).sum::<f64>());
        let lcp = Lcp::new(n, a.clone(), q.collect()).expect("valid");
        let found = block_pivoting(&lcp, &Settings::default(), &Control::default());
        assert_eq!(found.termination, Termination::ComplementaryBasis);
        assert!(found.iterations <= 8, "{}", found.iterations);
        assert!(found.z.iter().zip(&z).all(|(x, y)| (x - y).abs() < 1e-9));
    }

    #[test]
    fn singular_block_is_a_breakdown() {
        let lcp = Lcp::new(2, vec![1.0, 1.0, 1.0, 1.0], vec![-1.0, -2.0]).expect("valid");
        let found = block_pivoting(&lcp, &Settings::default(), &Control::default());
        assert!(matches!(found.termination, Termination::Breakdown(_)));
    }
}
