//! The safeguard of Newton's method: predictor-corrector steps along the interior path `z_i w_i = mu`, `z, w > 0`. [Meh92]

use crate::control::Control;
use crate::iterative::{Factors, Matrix};

/// How a step went.
pub(super) enum Step {
    /// mu has fallen far enough for another guess of the active set.
    Near,
    /// Not yet.
    Far,
    /// No step could be taken; why.
    Stuck(&'static str),
}

/// A pair `z, w > 0`, not yet with `w = A z + q`.
pub(super) struct InteriorPath<'m> {
    factors: Box<dyn Factors + 'm>,
    pub(super) z: Vec<f64>,
    pub(super) w: Vec<f64>,
    /// The next guess is due when mu is below this.
    guess_below: f64,
    short_steps: usize,
    /// `A z + q - w`.
    residual: Vec<f64>,
    shift: Vec<f64>,
    dz: Vec<f64>,
    dw: Vec<f64>,
    /// `dz_i dw_i` of the predictor.
    product: Vec<f64>,
}

/// Entries of the first z and w on an equilibrated problem.
const START: f64 = 0.3;
/// mu falls by this factor between two guesses.
const GUESS: f64 = 1e-2;
/// Fraction of the way to the boundary.
const TO_BOUNDARY: f64 = 0.99;
/// mu below this: rounding rules.
const LEAST: f64 = 1e-30;
/// Steps below this, so many in a row, end the path.
const SHORT: f64 = 1e-3;
const SHORT_STEPS: usize = 4;
/// `w_i / z_i` at most.
const STEEPEST: f64 = 1e20;

impl<'m> InteriorPath<'m> {
    pub(super) fn new(factors: Box<dyn Factors + 'm>, n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Self {
            factors,
            z: vec![START; n],
            w: vec![START; n],
            guess_below: GUESS * START * START,
            short_steps: 0,
            residual: zeros(),
            shift: zeros(),
            dz: zeros(),
            dw: zeros(),
            product: zeros(),
        }
    }

    /// One factorisation of `A + diag(w / z)`, two solves, one step.
    pub(super) fn advance(&mut self, matrix: &impl Matrix, control: &Control<'_>) -> Step {
        let n = self.z.len();
        matrix.affine(&self.z, &mut self.residual);
        for i in 0..n {
            self.residual[i] -= self.w[i];
            self.shift[i] = (self.w[i] / self.z[i]).min(STEEPEST);
        }
        if !self.factors.shifted(&self.shift, &|| control.expired().is_some()) {
            return Step::Stuck("A + D became singular for a positive diagonal D: A is not a P0-matrix");
        }
        let mu = self.mu();
        self.product.fill(0.0);
        self.direction(matrix, 0.0);
        let reach = self.reach();
        let predicted =
            (0..n).map(|i| (self.z[i] + reach * self.dz[i]) * (self.w[i] + reach * self.dw[i])).sum::<f64>();
        let centering = (predicted / (n as f64 * mu)).clamp(0.0, 1.0).powi(3);
        for i in 0..n {
            self.product[i] = self.dz[i] * self.dw[i];
        }
        self.direction(matrix, centering * mu);
        let step = (TO_BOUNDARY * self.reach()).min(1.0);
        for i in 0..n {
            self.z[i] = (self.z[i] + step * self.dz[i]).max(f64::MIN_POSITIVE);
            self.w[i] = (self.w[i] + step * self.dw[i]).max(f64::MIN_POSITIVE);
        }
        self.judge(step)
    }

    fn mu(&self) -> f64 {
        self.z.iter().zip(&self.w).map(|(z, w)| z * w).sum::<f64>() / self.z.len() as f64
    }

    /// `z_i dw_i + w_i dz_i = target - z_i w_i - product_i`, `dw = A dz + residual`.
    fn direction(&mut self, matrix: &impl Matrix, target: f64) {
        for i in 0..self.z.len() {
            let complementarity = (target - self.product[i]) / self.z[i] - self.w[i];
            self.dz[i] = complementarity - self.residual[i];
        }
        self.factors.solve(&mut self.dz);
        matrix.multiply(&self.dz, &mut self.dw);
        self.dw.iter_mut().zip(&self.residual).for_each(|(dw, r)| *dw += r);
    }

    /// The longest step up to 1 that keeps z and w nonnegative; NaN if the direction is.
    fn reach(&self) -> f64 {
        let pairs = self.z.iter().zip(&self.dz).chain(self.w.iter().zip(&self.dw));
        let mut longest = 1.0_f64;
        for (x, d) in pairs {
            if d.is_nan() {
                return f64::NAN;
            }
            if *d < 0.0 {
                longest = longest.min(-x / d);
            }
        }
        longest
    }

    fn judge(&mut self, step: f64) -> Step {
        if step.is_nan() {
            return Step::Stuck("the Newton system of the interior path could not be solved");
        }
        self.short_steps = if step < SHORT { self.short_steps + 1 } else { 0 };
        if self.short_steps == SHORT_STEPS {
            return Step::Stuck("the steps became too short: A is not monotone here, or rounding rules");
        }
        let mu = self.mu();
        if mu <= LEAST {
            return Step::Stuck("the interior path is at rounding level");
        }
        if mu > self.guess_below {
            return Step::Far;
        }
        self.guess_below = GUESS * mu;
        Step::Near
    }
}
