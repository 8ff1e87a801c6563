//! The direct solve on a support: `A[alpha, alpha] z_alpha = -q_alpha`, from a point near by.

use super::{Factors, Matrix};
use crate::control::Control;
use crate::linalg::kernels::max_abs;

/// A support and its factorisation.
///
/// The solve is proximal: `z += (A_aa + shift I)^-1 (-w_a)`, repeated. For a nonsingular block that is iterative refinement;
/// in a singular one (a stack of boxes) the part of z in its kernel stays what it was. [PB14, sec. 4.1]
pub struct Support<'m> {
    factors: Box<dyn Factors + 'm>,
    control: &'m Control<'m>,
    alpha: Vec<usize>,
    step: Vec<f64>,
}

/// From the first that any nonsingular block forgives to one that any consistent block needs.
const SHIFTS: [f64; 3] = [1e-12, 1e-9, 1e-6];
/// Steps at most with one factorisation.
const STEPS: usize = 8;
/// `w_alpha` below this is solved for, on the way to rounding level.
const SOLVED: f64 = 1e-6;

impl<'m> Support<'m> {
    /// Of a matrix; nothing is factored once `control` says stop.
    #[must_use]
    pub fn new(matrix: &'m impl Matrix, control: &'m Control<'m>) -> Self {
        let n = matrix.n();
        Self { factors: matrix.factors(), control, alpha: Vec::with_capacity(n), step: vec![0.0; n] }
    }

    /// The index set.
    #[must_use]
    pub fn alpha(&self) -> &[usize] {
        &self.alpha
    }

    /// Chooses the index set. Returns how many indices changed, `n` the first time.
    pub fn choose(&mut self, n: usize, belongs: impl Fn(usize) -> bool) -> usize {
        let mut kept = 0;
        let old = std::mem::take(&mut self.alpha);
        let mut alpha = Vec::with_capacity(n);
        let mut rest = old.iter().peekable();
        for i in (0..n).filter(|&i| belongs(i)) {
            while rest.peek().is_some_and(|&&j| j < i) {
                rest.next();
            }
            kept += usize::from(rest.peek() == Some(&&i));
            alpha.push(i);
        }
        let changed = old.len() + alpha.len() - 2 * kept;
        self.alpha = alpha;
        changed
    }

    /// Replaces z by a point that is 0 off the support and has `w = 0` on it, near z there; signs are free. `w = A z + q`.
    /// One factorisation, or up to three where the block is singular. `false` when it found none.
    pub fn solve(&mut self, matrix: &impl Matrix, z: &mut [f64], w: &mut [f64]) -> bool {
        let mut next = 0;
        for i in 0..z.len() {
            if self.alpha.get(next) == Some(&i) {
                next += 1;
            } else {
                z[i] = 0.0;
            }
        }
        matrix.affine(z, w);
        if self.alpha.is_empty() {
            return true;
        }
        for shift in SHIFTS {
            let stop = || self.control.expired().is_some();
            if self.factors.on_support(&self.alpha, shift, &stop) && self.refine(matrix, z, w) {
                return true;
            }
            if !max_abs(z).is_finite() || z.iter().any(|z| z.is_nan()) {
                z.fill(0.0);
                matrix.affine(z, w);
            }
        }
        false
    }

    /// Whether `w_alpha` vanished.
    fn refine(&mut self, matrix: &impl Matrix, z: &mut [f64], w: &mut [f64]) -> bool {
        let mut error = self.error(w);
        for _ in 0..STEPS {
            self.step.copy_from_slice(w);
            self.factors.solve(&mut self.step);
            z.iter_mut().zip(&self.step).for_each(|(z, s)| *z -= s);
            matrix.affine(z, w);
            let last = error;
            error = self.error(w);
            if error.is_nan() || error <= f64::EPSILON * max_abs(z).max(1.0) || error > 0.5 * last {
                break;
            }
        }
        error <= SOLVED + 100.0 * f64::EPSILON * max_abs(z)
    }

    /// `max|w_alpha|`, NaN if any is.
    fn error(&self, w: &[f64]) -> f64 {
        self.alpha.iter().map(|&i| w[i].abs()).fold(0.0, |m, x| if x > m || x.is_nan() { x } else { m })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Dense;
    use super::*;
    use crate::problem::Lcp;

    #[test]
    fn a_singular_block_keeps_its_kernel() {
        // Rank one: z_0 + z_1 = 2, and z_0 - z_1 stays what it was.
        let lcp = Lcp::new(3, vec![1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0], vec![-2.0, -2.0, 1.0]).expect("valid");
        let matrix = Dense::new(&lcp);
        let control = Control::default();
        let mut support = Support::new(&matrix, &control);
        assert_eq!(support.choose(3, |i| i < 2), 2);
        assert_eq!(support.choose(3, |i| i < 2), 0);
        let (mut z, mut w) = (vec![0.7, 0.1, 5.0], vec![0.0; 3]);
        assert!(support.solve(&matrix, &mut z, &mut w));
        assert!((z[0] - 1.3).abs() < 1e-3 && (z[1] - 0.7).abs() < 1e-3 && z[2] == 0.0, "{z:?}");
        assert!(w[0].abs() < 1e-12 && w[2] == 1.0, "{w:?}");
        assert_eq!(support.choose(3, |i| i > 0), 2);
    }

    #[test]
    fn an_inconsistent_block_is_refused() {
        let lcp = Lcp::new(2, vec![1.0, 1.0, 1.0, 1.0], vec![-1.0, -2.0]).expect("valid");
        let matrix = Dense::new(&lcp);
        let control = Control::default();
        let mut support = Support::new(&matrix, &control);
        support.choose(2, |_| true);
        assert!(!support.solve(&matrix, &mut [0.0; 2], &mut [0.0; 2]));
    }
}
