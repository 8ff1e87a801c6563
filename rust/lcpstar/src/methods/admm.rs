//! ADMM: Douglas-Rachford splitting of `A z + q` and the nonnegative orthant. [BPCPE11], [LM79], [SBGBB20]
//!
//! `x = (A + rho I)^-1 (rho (z - u) - q)`, `z <- max(0, r x + (1 - r) z + u)`, `u += r x + (1 - r) z_old - z`. One
//! factorisation serves every iteration at the same rho. Converges for `A + A'` PSD, symmetric or not, from any start; the
//! condition number of A enters through rho alone, so large mass ratios cost refactorisations, not sweeps.

use crate::control::Control;
use crate::iterative::sweep::{DIVERGED, diverges};
use crate::iterative::{Factors, Goal, Incumbent, Matrix, Support, start};
use crate::linalg::kernels::max_abs;
use crate::solution::Candidate;
use crate::status::Termination;

/// Options.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The first rho; it adapts.
    pub rho: f64,
    /// The over-relaxation r, in (0, 2).
    pub relaxation: f64,
    /// Whether the support is solved for when it has settled.
    pub polish: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { rho: 0.1, relaxation: 1.6, polish: true }
    }
}

/// Iterations when the caller sets no limit.
pub const DEFAULT_MAX_ITERATIONS: usize = 5000;
/// Iterations between two looks at rho.
const LOOK: usize = 10;
/// rho changes when primal and dual residual differ by more than this factor squared.
const UNBALANCED: f64 = 3.0;
/// Range of rho on an equilibrated problem.
const RHO: (f64, f64) = (1e-9, 1e6);

/// Iterates from `z0` or 0. O(n^3) for each rho, then O(n^2) an iteration; for a sparse A a sparse factorisation and two
/// sparse solves. The loop allocates only when it factors.
#[must_use]
pub fn admm(
    matrix: &impl Matrix,
    goal: &Goal,
    settings: &Settings,
    z0: Option<&[f64]>,
    control: &Control<'_>,
) -> Candidate {
    let (z, w) = start(matrix, z0);
    let mut best = Incumbent::new(goal, matrix.n());
    if best.offer(matrix, &z, &w) {
        return Candidate::point(best.z, Termination::Converged, 0);
    }
    let mut splitting = Splitting::new(matrix.factors(), settings, z, w);
    let mut polish = Polish::new(Support::new(matrix, control), matrix.n());
    let mut iterations = 0;
    let termination = loop {
        if let Some(reason) = control.stop(iterations, DEFAULT_MAX_ITERATIONS) {
            break reason;
        }
        if iterations % LOOK == 0 && !splitting.balance(matrix.q(), iterations == 0, control) {
            break control.expired().unwrap_or(Termination::Breakdown("A + rho I could not be factored"));
        }
        splitting.advance(matrix.q());
        iterations += 1;
        matrix.affine(&splitting.z, &mut splitting.w);
        if best.offer(matrix, &splitting.z, &splitting.w) {
            break Termination::Converged;
        }
        if settings.polish && iterations % LOOK == 0 && polish.finish(matrix, &splitting, &mut best) {
            break Termination::Converged;
        }
        if diverges(&splitting.x) {
            break Termination::Breakdown(DIVERGED);
        }
    };
    Candidate::point(best.z, termination, iterations)
}

/// x, z and the scaled multiplier u, with `-rho u` in the place of w.
struct Splitting<'m> {
    factors: Box<dyn Factors + 'm>,
    rho: f64,
    relaxation: f64,
    /// `rho` on every place of the diagonal.
    shift: Vec<f64>,
    x: Vec<f64>,
    z: Vec<f64>,
    u: Vec<f64>,
    /// `A z + q`.
    w: Vec<f64>,
    /// `max|x - z|` and `rho max|z - z_old|` of the last iteration.
    primal: f64,
    dual: f64,
}

impl<'m> Splitting<'m> {
    fn new(factors: Box<dyn Factors + 'm>, settings: &Settings, z: Vec<f64>, w: Vec<f64>) -> Self {
        let rho = settings.rho;
        let u = w.iter().map(|w| -w.max(0.0) / rho).collect();
        let (x, shift) = (z.clone(), vec![rho; z.len()]);
        Self { factors, rho, relaxation: settings.relaxation, shift, x, z, u, w, primal: 0.0, dual: 0.0 }
    }

    /// One iteration.
    fn advance(&mut self, q: &[f64]) {
        for i in 0..q.len() {
            self.x[i] = self.rho * (self.z[i] - self.u[i]) - q[i];
        }
        self.factors.solve(&mut self.x);
        (self.primal, self.dual) = (0.0, 0.0);
        for i in 0..q.len() {
            let relaxed = self.relaxation * self.x[i] + (1.0 - self.relaxation) * self.z[i];
            let z = (relaxed + self.u[i]).max(0.0);
            self.u[i] += relaxed - z;
            self.primal = self.primal.max((self.x[i] - z).abs());
            self.dual = self.dual.max(self.rho * (z - self.z[i]).abs());
            self.z[i] = z;
        }
    }

    /// Brings the two residuals, each in proportion to what it is made of, to one size; factors when rho changes.
    fn balance(&mut self, q: &[f64], first: bool, control: &Control<'_>) -> bool {
        if !first {
            let of_z = max_abs(&self.x).max(max_abs(&self.z)).max(f64::MIN_POSITIVE);
            let of_w = max_abs(q).max(self.rho * max_abs(&self.u));
            let ratio = ((self.primal / of_z) / (self.dual / of_w).max(f64::MIN_POSITIVE)).sqrt();
            if !ratio.is_finite() || (1.0 / UNBALANCED..UNBALANCED).contains(&ratio) {
                return true;
            }
            let rho = (self.rho * ratio.clamp(1e-2, 1e2)).clamp(RHO.0, RHO.1);
            if rho == self.rho {
                return true;
            }
            let factor = self.rho / rho;
            self.u.iter_mut().for_each(|u| *u *= factor);
            self.rho = rho;
            self.shift.fill(rho);
        }
        self.factors.shifted(&self.shift, &|| control.expired().is_some())
    }
}

/// The direct solve on the support, tried once for each support that has settled.
struct Polish<'m> {
    support: Support<'m>,
    /// The support at the last look.
    last: Vec<bool>,
    tried: bool,
    z: Vec<f64>,
    w: Vec<f64>,
}

impl<'m> Polish<'m> {
    fn new(support: Support<'m>, n: usize) -> Self {
        Self { support, last: vec![false; n], tried: false, z: vec![0.0; n], w: vec![0.0; n] }
    }

    /// `true` when the goal is reached. A negative index leaves the support once.
    fn finish(&mut self, matrix: &impl Matrix, splitting: &Splitting<'_>, best: &mut Incumbent<'_>) -> bool {
        let n = self.z.len();
        let positive = |i: usize| splitting.z[i] > 0.0;
        if (0..n).any(|i| self.last[i] != positive(i)) {
            (0..n).for_each(|i| self.last[i] = positive(i));
            self.tried = false;
            return false;
        }
        if std::mem::replace(&mut self.tried, true) {
            return false;
        }
        self.z.copy_from_slice(&splitting.z);
        self.support.choose(n, positive);
        for _ in 0..2 {
            if !self.support.solve(matrix, &mut self.z, &mut self.w) {
                return false;
            }
            let (z, w) = (&self.z, &self.w);
            let changed = self.support.choose(n, |i| z[i] > w[i]);
            self.z.iter_mut().for_each(|z| *z = z.max(0.0));
            matrix.affine(&self.z, &mut self.w);
            if best.offer(matrix, &self.z, &self.w) {
                return true;
            }
            if changed == 0 {
                return false;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iterative::Dense;
    use crate::problem::Lcp;

    /// A diagonal of masses from 1 to `ratio`, coupled to its neighbours; not symmetric with a skew part.
    fn chain(n: usize, ratio: f64, skew: f64) -> Lcp {
        let inverse_mass = |i: usize| ratio.powf(-(i as f64) / (n - 1) as f64);
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => inverse_mass(i) + if i > 0 { inverse_mass(i - 1) } else { 0.0 },
            1 => -inverse_mass(i.min(j)) + if i < j { skew } else { -skew },
            _ => 0.0,
        };
        let a = (0..n * n).map(|k| entry(k / n, k % n)).collect();
        Lcp::new(n, a, (0..n).map(|i| if i == 0 { -0.1 } else { 0.01 - 0.02 * (i % 2) as f64 }).collect())
            .expect("valid")
    }

    #[test]
    fn with_and_without_polish_symmetric_or_not() {
        for skew in [0.0, 0.3] {
            for polish in [false, true] {
                let lcp = chain(12, 1.0, skew);
                let goal = Goal::plain(1e-8, lcp.q());
                let settings = Settings { polish, ..Settings::default() };
                let found = admm(&Dense::new(&lcp), &goal, &settings, None, &Control::default());
                assert_eq!(found.termination, Termination::Converged, "{skew} {polish}");
            }
        }
    }

    #[test]
    fn a_mass_ratio_of_a_million_is_solved() {
        let lcp = chain(12, 1e6, 0.0);
        let goal = Goal::plain(1e-9, lcp.q());
        let found = admm(&Dense::new(&lcp), &goal, &Settings::default(), None, &Control::default());
        assert_eq!(found.termination, Termination::Converged);
        assert!(found.iterations <= 500, "{}", found.iterations);
    }
}
