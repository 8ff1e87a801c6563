//! A point of the homogeneous model, its residuals, its Newton directions and its steps.
//!
//! Unknowns `(z, tau, w, kappa) > 0` with `w = A z + tau q`, `kappa = -z'A z / tau - q'z`, `z_i w_i = tau kappa = 0`;
//! `z / tau` solves LCP(q, A) when `tau > 0`, and `tau = 0 < kappa` shows that nothing is feasible when A is PSD.
//! [AndY99]; their x, s are our z, w.

use super::system::NewtonSystem;
use crate::linalg::kernels::{dot, max_abs};

/// Added to `W Z^-1`: a proximal term, which keeps the system solvable where A is singular on the support of z and
/// vanishes from the residual as the steps do. [FriO12]
const PROXIMITY: f64 = 1e-11;
/// Refinements of one solve at most.
const REFINEMENTS: usize = 3;
/// A last correction above this fraction calls for another factorisation.
const ACCURATE: f64 = 1e-8;
/// A first correction below this fraction: solves with this factorisation are good as they are.
const GOOD: f64 = 1e-9;
/// Refinement ends when a correction is below this fraction of the solution.
const REFINED: f64 = 1e-13;
/// Centrality correctors at most, and the growth of the step that each must bring.
const CORRECTORS: usize = 2;
const CORRECTOR_GAIN: f64 = 0.02;
/// A corrector aims this much further, and at products within this factor of the target.
const CORRECTOR_REACH: f64 = 0.2;
const CORRECTOR_BAND: f64 = 10.0;

/// A direction in all four unknowns.
#[derive(Clone, Debug, Default)]
struct Direction {
    z: Vec<f64>,
    w: Vec<f64>,
    tau: f64,
    kappa: f64,
}

/// The current point and the workspace of an iteration.
pub struct Iterate {
    /// `z`.
    pub z: Vec<f64>,
    /// `w`.
    pub w: Vec<f64>,
    /// `tau`.
    pub tau: f64,
    /// `kappa`.
    pub kappa: f64,
    /// `A z`.
    az: Vec<f64>,
    /// `(A + A')z / tau + q`, the gradient of `z'A z / tau + q'z`.
    gradient: Vec<f64>,
    /// `z'A z / tau`.
    form: f64,
    /// `w - A z - tau q`.
    r_p: Vec<f64>,
    /// `kappa + z'A z / tau + q'z`.
    r_g: f64,
    /// `(z'w + tau kappa) / (n + 1)`.
    pub mu: f64,
    d: Vec<f64>,
    /// `-(A + D)^-1 q`.
    x_q: Vec<f64>,
    /// Right-hand sides: of the complementarity rows, and of the solve.
    rc: Vec<f64>,
    rk: f64,
    /// Second-order term of `z'A z / tau` along the affine direction.
    curvature: f64,
    rhs: Vec<f64>,
    work: Vec<f64>,
    direction: Direction,
    trial: Direction,
    trial_rc: Vec<f64>,
    /// Whether the current factorisation needs refinement.
    refine: bool,
}

impl Iterate {
    /// The point `z, w > 0`, `tau`, `kappa`; allocates all that the iteration needs.
    #[must_use]
    pub fn new(z: Vec<f64>, w: Vec<f64>, tau: f64, kappa: f64) -> Self {
        let n = z.len();
        let zeros = || vec![0.0; n];
        let direction = || Direction { z: vec![0.0; n], w: vec![0.0; n], tau: 0.0, kappa: 0.0 };
        Self {
            z,
            w,
            tau,
            kappa,
            az: zeros(),
            gradient: zeros(),
            form: 0.0,
            r_p: zeros(),
            r_g: 0.0,
            mu: 0.0,
            d: zeros(),
            x_q: zeros(),
            rc: zeros(),
            rk: 0.0,
            curvature: 0.0,
            rhs: zeros(),
            work: zeros(),
            direction: direction(),
            trial: direction(),
            trial_rc: zeros(),
            refine: false,
        }
    }

    /// Residuals of the model at this point. Two products with A, one when it is symmetric.
    pub fn update_residuals(&mut self, system: &impl NewtonSystem) {
        let q = system.q();
        system.multiply(&self.z, &mut self.az);
        if system.is_symmetric() {
            self.gradient.copy_from_slice(&self.az);
        } else {
            system.multiply_transposed(&self.z, &mut self.gradient);
        }
        for i in 0..self.z.len() {
            self.gradient[i] = (self.gradient[i] + self.az[i]) / self.tau + q[i];
            self.r_p[i] = self.w[i] - self.az[i] - self.tau * q[i];
        }
        self.form = dot(&self.z, &self.az) / self.tau;
        self.r_g = self.kappa + self.form + dot(q, &self.z);
        self.mu = (dot(&self.z, &self.w) + self.tau * self.kappa) / (self.z.len() + 1) as f64;
    }

    /// The equilibrated residual of `z / tau`, and a tenth of it before its division by `max|z|`: as `certify` will
    /// look at it, so that a diverging z is not taken for convergence.
    #[must_use]
    pub fn residual(&self, q: &[f64]) -> f64 {
        let worst = self
            .z
            .iter()
            .zip(&self.az)
            .zip(q)
            .map(|((z, az), q)| (z / self.tau).min(az / self.tau + q).abs())
            .fold(0.0, f64::max);
        (worst / (max_abs(&self.z) / self.tau).max(1.0)).max(0.1 * worst)
    }

    /// Predictor, corrector, centrality correctors, step: one factorisation. The step length, or `None` when the
    /// factorisation fails or the direction is not finite.
    pub fn advance(&mut self, system: &mut impl NewtonSystem) -> Option<f64> {
        for i in 0..self.z.len() {
            self.d[i] = self.w[i] / self.z[i] + PROXIMITY;
        }
        if !system.factor(&self.d) {
            return None;
        }
        for (rhs, q) in self.rhs.iter_mut().zip(system.q()) {
            *rhs = -q;
        }
        self.refine = false;
        if !self.solve_for_q(system) && system.factor_again(&self.d) {
            self.solve_for_q(system);
        }
        if self.x_q.iter().any(|x| !x.is_finite()) {
            return None;
        }

        self.affine_target();
        self.newton_direction(system, 1.0);
        let affine_step = self.longest_step().min(1.0);
        let sigma = centring(affine_step);
        self.corrected_target(system, sigma);
        self.newton_direction(system, 1.0 - sigma);
        let mut longest = self.longest_step();
        for _ in 0..CORRECTORS {
            if longest * TO_BOUNDARY >= 1.0 {
                break;
            }
            let Some(better) = self.centrality_corrector(system, sigma, longest) else { break };
            longest = better;
        }
        let step = (longest * (1.0 - self.mu).clamp(TO_BOUNDARY, NEARLY)).min(1.0);
        self.take(step);
        Some(step)
    }

    /// `x_q = -(A + D)^-1 q`, on which the factorisation is tried out: when the first correction, from a residual in
    /// working precision, is small, this factorisation needs no refinement; otherwise every solve gets it. Whether
    /// the result is accurate.
    fn solve_for_q(&mut self, system: &mut impl NewtonSystem) -> bool {
        self.x_q.copy_from_slice(&self.rhs);
        system.back_solve(&mut self.x_q);
        system.multiply(&self.x_q, &mut self.work);
        for i in 0..self.work.len() {
            self.work[i] = self.rhs[i] - self.d[i] * self.x_q[i] - self.work[i];
        }
        system.back_solve(&mut self.work);
        let correction = max_abs(&self.work) / max_abs(&self.x_q);
        self.refine = correction.is_nan() || correction > GOOD;
        if self.refine {
            return solve_refined(system, &self.d, &self.rhs, &mut self.x_q, &mut self.work);
        }
        for (x, c) in self.x_q.iter_mut().zip(&self.work) {
            *x += c;
        }
        true
    }

    /// Right-hand side of the affine direction.
    fn affine_target(&mut self) {
        for i in 0..self.z.len() {
            self.rc[i] = -self.z[i] * self.w[i];
        }
        self.rk = -self.tau * self.kappa;
        self.curvature = 0.0;
    }

    /// Mehrotra's second-order terms and the centring `sigma mu`. [Meh92]
    ///
    /// The form `z'A z / tau` has one, too, `v'A v / tau` with `v = dz - z dtau / tau`: without it a full step leaves a
    /// quarter of the gap.
    fn corrected_target(&mut self, system: &impl NewtonSystem, sigma: f64) {
        let d = &self.direction;
        for i in 0..self.z.len() {
            self.rhs[i] = d.z[i] - self.z[i] * (d.tau / self.tau);
        }
        system.multiply(&self.rhs, &mut self.work);
        self.curvature = dot(&self.rhs, &self.work) / self.tau;
        for i in 0..self.z.len() {
            self.rc[i] = sigma * self.mu - self.z[i] * self.w[i] - d.z[i] * d.w[i];
        }
        self.rk = sigma * self.mu - self.tau * self.kappa - d.tau * d.kappa;
    }

    /// Solves the Newton system for `rc`, `rk` and the fraction `eta` of the residuals into `direction`.
    fn newton_direction(&mut self, system: &mut impl NewtonSystem, eta: f64) {
        for i in 0..self.z.len() {
            self.rhs[i] = self.rc[i] / self.z[i] + eta * self.r_p[i];
        }
        if self.refine {
            solve_refined(system, &self.d, &self.rhs, &mut self.direction.z, &mut self.work);
        } else {
            self.direction.z.copy_from_slice(&self.rhs);
            system.back_solve(&mut self.direction.z);
        }
        let d = &mut self.direction;
        let slope = self.kappa / self.tau + self.form / self.tau - dot(&self.gradient, &self.x_q);
        d.tau = (self.rk / self.tau + eta * self.r_g + self.curvature + dot(&self.gradient, &d.z)) / slope;
        for i in 0..self.z.len() {
            d.z[i] += self.x_q[i] * d.tau;
            d.w[i] = (self.rc[i] - self.w[i] * d.z[i]) / self.z[i];
        }
        d.kappa = (self.rk - self.kappa * d.tau) / self.tau;
    }

    /// Gondzio's corrector: moves the products that a longer step would leave outside a band around the target back into
    /// it. Keeps the new direction, and returns its step, only when the step grows. [Gon96]
    fn centrality_corrector(&mut self, system: &mut impl NewtonSystem, sigma: f64, longest: f64) -> Option<f64> {
        let reach = (longest.min(1.0) + CORRECTOR_REACH).min(1.0);
        let target = sigma * self.mu;
        let correction = |z: f64, dz: f64, w: f64, dw: f64| {
            let product = (z + reach * dz) * (w + reach * dw);
            let wanted = product.clamp(target / CORRECTOR_BAND, target * CORRECTOR_BAND);
            (wanted - product).max(-CORRECTOR_BAND * target)
        };
        let d = &self.direction;
        self.trial_rc.clone_from(&self.rc);
        let rk = self.rk;
        for i in 0..self.z.len() {
            self.rc[i] += correction(self.z[i], d.z[i], self.w[i], d.w[i]);
        }
        self.rk += correction(self.tau, d.tau, self.kappa, d.kappa);
        self.trial.z.clone_from(&d.z);
        self.trial.w.clone_from(&d.w);
        (self.trial.tau, self.trial.kappa) = (d.tau, d.kappa);
        self.newton_direction(system, 1.0 - sigma);
        let better = self.longest_step();
        if better >= longest + CORRECTOR_GAIN {
            return Some(better);
        }
        std::mem::swap(&mut self.direction, &mut self.trial);
        std::mem::swap(&mut self.rc, &mut self.trial_rc);
        self.rk = rk;
        None
    }

    /// The step at which the first of z, w, tau, kappa reaches zero.
    fn longest_step(&self) -> f64 {
        let d = &self.direction;
        let mut fastest = (-d.tau / self.tau).max(-d.kappa / self.kappa);
        for i in 0..self.z.len() {
            fastest = fastest.max(-d.z[i] / self.z[i]).max(-d.w[i] / self.w[i]);
        }
        if fastest > 0.0 { 1.0 / fastest } else { f64::INFINITY }
    }

    fn take(&mut self, step: f64) {
        let d = &self.direction;
        for i in 0..self.z.len() {
            self.z[i] += step * d.z[i];
            self.w[i] += step * d.w[i];
        }
        self.tau += step * d.tau;
        self.kappa += step * d.kappa;
        // The model is homogeneous: keep the larger of tau, kappa near 1.
        let scale = 1.0 / self.tau.max(self.kappa);
        self.z.iter_mut().chain(&mut self.w).for_each(|x| *x *= scale);
        self.tau *= scale;
        self.kappa *= scale;
    }
}

/// Fraction of the way to the boundary; more, `1 - mu`, near the solution, but never all of it.
const TO_BOUNDARY: f64 = 0.95;
const NEARLY: f64 = 0.999;

/// Mehrotra's centring from the step that the affine direction allows.
fn centring(affine_step: f64) -> f64 {
    (1.0 - affine_step).powi(3).clamp(1e-10, 1.0)
}

/// `x = (A + D)^-1 b`, refined on residuals in twice the working precision; whether the corrections died out.
fn solve_refined(system: &mut impl NewtonSystem, d: &[f64], b: &[f64], x: &mut [f64], work: &mut [f64]) -> bool {
    x.copy_from_slice(b);
    system.back_solve(x);
    let mut last = f64::INFINITY;
    for _ in 0..REFINEMENTS {
        system.residual(d, x, b, work);
        system.back_solve(work);
        let size = max_abs(work) / max_abs(x);
        if size.is_nan() || size > 0.5 * last {
            break;
        }
        for (x, s) in x.iter_mut().zip(&*work) {
            *x += s;
        }
        last = size;
        if size <= REFINED {
            break;
        }
    }
    last <= ACCURATE
}
