//! The sweep of projected Gauss-Seidel: `z_i <- max(0, z_i - omega w_i / a_ii)`, one index after the other. [Cry71]

use super::Matrix;

/// Step lengths of a sweep; `w = A z + q` is kept up to date by columns, so an index that does not move costs O(1).
pub struct Sweep {
    /// `omega / a_ii`; 0 where the diagonal entry is not positive: such an index is skipped.
    steps: Vec<f64>,
    /// Whether an index is skipped.
    pub skips: bool,
}

/// A diagonal entry of an equilibrated matrix counts as positive above this.
const POSITIVE: f64 = 1e-14;

impl Sweep {
    /// Steps for the relaxation factor `omega`. O(n).
    #[must_use]
    pub fn new(matrix: &impl Matrix, omega: f64) -> Self {
        let step = |i: usize| {
            let a = matrix.diagonal(i);
            if a > POSITIVE { omega / a } else { 0.0 }
        };
        let steps: Vec<f64> = (0..matrix.n()).map(step).collect();
        Self { skips: steps.contains(&0.0), steps }
    }

    /// One sweep, upwards or downwards. O(n) for each index that moves. Returns the largest `|change of z_i|`.
    pub fn run(&self, matrix: &impl Matrix, z: &mut [f64], w: &mut [f64], downwards: bool) -> f64 {
        let mut largest = 0.0_f64;
        for k in 0..z.len() {
            let i = if downwards { z.len() - 1 - k } else { k };
            let next = (z[i] - self.steps[i] * w[i]).max(0.0);
            let change = next - z[i];
            if change != 0.0 {
                z[i] = next;
                matrix.add_column(i, change, w);
                largest = largest.max(change.abs());
            }
        }
        largest
    }

    /// Whether the next sweep would leave `z_i` positive: a guess of the support. Skipped indices: `z_i > w_i`.
    #[must_use]
    pub fn stays_positive(&self, i: usize, z: &[f64], w: &[f64]) -> bool {
        let step = if self.steps[i] > 0.0 { self.steps[i] } else { 1.0 };
        z[i] > step * w[i]
    }
}

/// `w` is recomputed after so many sweeps: its rounding errors add up.
pub const REFRESH: usize = 32;
/// A change of z below this fraction of `max|z|` is no change.
pub const STALLED: f64 = 1e-16;
/// Why a sweep that changes nothing cannot go on.
pub const SKIPPED: &str =
    "the sweep changes nothing more, and skips rows whose diagonal entry is not positive: one of them is violated";
/// As [`SKIPPED`], when nothing is skipped.
pub const ROUNDING: &str = "the sweep changes nothing more: its residual is at rounding level";
/// Why an iterate that grows without bound ends the iteration.
pub const DIVERGED: &str = "the iterates grow without bound: the matrix is outside the class of the method";
/// `|z|` above this on an equilibrated problem is divergence.
const HUGE: f64 = 1e100;

/// Whether an entry is huge or NaN.
#[must_use]
pub fn diverges(z: &[f64]) -> bool {
    z.iter().any(|z| z.abs() >= HUGE || z.is_nan())
}

#[cfg(test)]
mod tests {
    use super::super::Dense;
    use super::*;
    use crate::problem::Lcp;

    #[test]
    fn one_sweep_by_hand() {
        let lcp = Lcp::new(3, vec![2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0], vec![-4.0, -5.0, 1.0]).expect("valid");
        let matrix = Dense::new(&lcp);
        let sweep = Sweep::new(&matrix, 1.0);
        assert!(sweep.skips);
        let (mut z, mut w) = (vec![0.0; 3], lcp.q().to_vec());
        assert_eq!(sweep.run(&matrix, &mut z, &mut w, false), 2.0);
        assert_eq!((z.as_slice(), w.as_slice()), ([2.0, 1.5, 0.0].as_slice(), [1.5, 0.0, 1.0].as_slice()));
        sweep.run(&matrix, &mut z, &mut w, true);
        assert_eq!(z, [1.25, 1.5, 0.0]);
    }
}
