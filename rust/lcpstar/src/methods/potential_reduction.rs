//! The paper's potential reduction method, faithful, with a direction that keeps its digits.
//!
//! `psi(z, w) = kappa log z'w - sum log z_i w_i` is reduced from a strictly feasible point; `kappa` grows with
//! `z'w / min_i z_i w_i`. Convergence is proved nowhere beyond P0: on `A = [[1, 2], [2, 1]]`, `q = (-7, -3)`,
//! `z^0 = (2, 3)` the iterates tend to a point with `z'w = 7/4`. Such a stall is reported, never called solved.

mod direction;
mod phase_one;

pub use direction::{Direction, DirectionSolver, scaled_direction};
pub use phase_one::strictly_feasible;

use crate::control::Control;
use crate::equilibrate::Rows;
use crate::error::{LcpError, Result};
use crate::linalg::kernels::max_abs;
use crate::problem::{Lcp, check_finite};
use crate::residual::{equilibrated_residual, natural_residual, slack};
use crate::scaling::Scaling;
use crate::solution::Candidate;
use crate::status::Termination;

/// The method's parameters in the paper's letters; defaults reproduce Table 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Length of the direction in the scaled norm, in (0, 1).
    pub beta: f64,
    /// Backtracking factor: trial step `m` is `gamma^m`, in (0, 1).
    pub gamma: f64,
    /// Fraction of the predicted decrease asked of a step, in (0, 1/2).
    pub sigma: f64,
    /// `kappa = kappa_factor max(n, z'w / min z_i w_i)`, above 1.
    pub kappa_factor: f64,
    /// The first trial step is `gamma^min_halvings`. Table 1 needs 1.
    pub min_halvings: usize,
    /// How the direction is computed.
    pub direction: DirectionSolver,
    /// Steps 0.95 of the way to the boundary instead of inside the ellipsoid of radius `beta`.
    pub long_step: bool,
    /// When to stop.
    pub stop: Stop,
}

/// The stopping rule, tested after each step.
#[derive(Clone, Debug, PartialEq)]
pub enum Stop {
    /// The paper's `z'w <= eps`.
    Gap(f64),
    /// The residual that `certify` will compute is at most `tol / 2`: the `eps` that fits the point at hand.
    Residual(f64),
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            beta: 0.5,
            gamma: 0.5,
            sigma: 0.2,
            kappa_factor: 1.01,
            min_halvings: 1,
            direction: DirectionSolver::Cholesky,
            long_step: false,
            stop: Stop::Gap(1e-5),
        }
    }
}

impl Settings {
    /// # Errors
    /// `OutOfRange` names the parameter outside its range.
    pub fn validate(&self) -> Result<()> {
        let (stop_name, stop) = match self.stop {
            Stop::Gap(eps) => ("eps", eps),
            Stop::Residual(tol) => ("tol", tol),
        };
        let rules = [
            ("beta", self.beta, self.beta > 0.0 && self.beta < 1.0, "in (0, 1)"),
            ("gamma", self.gamma, self.gamma > 0.0 && self.gamma < 1.0, "in (0, 1)"),
            ("sigma", self.sigma, self.sigma > 0.0 && self.sigma < 0.5, "in (0, 1/2)"),
            ("kappa_factor", self.kappa_factor, self.kappa_factor > 1.0 && self.kappa_factor.is_finite(), "above 1"),
            ("min_halvings", self.min_halvings as f64, self.min_halvings < MAX_HALVINGS, "below 60"),
            (stop_name, stop, stop > 0.0 && stop.is_finite(), "positive"),
        ];
        match rules.iter().find(|(_, _, holds, _)| !holds) {
            None => Ok(()),
            Some(&(name, value, _, rule)) => Err(LcpError::OutOfRange { name, value, rule }),
        }
    }
}

/// Iterations when the caller sets no limit.
pub const DEFAULT_MAX_ITERATIONS: usize = 1000;
/// Trial steps shorter than `gamma^60` are no steps.
const MAX_HALVINGS: usize = 60;
/// A stall: over this many iterations (or `n`, if larger) ...
const STALL_WINDOW: usize = 100;
/// ... `z'w` fell by less than this fraction.
const STALL_DECREASE: f64 = 1e-3;
/// Fraction of the way to the boundary in the long-step mode.
const TO_BOUNDARY: f64 = 0.95;

/// Row `k` of the paper's table: the point reached and the step that led there.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Iteration, from 1.
    pub k: usize,
    /// `z^k`.
    pub z: Vec<f64>,
    /// `w^k`.
    pub w: Vec<f64>,
    /// `d_z^(k-1)`, which led to `z^k`.
    pub dz: Vec<f64>,
    /// `d_w^(k-1)`.
    pub dw: Vec<f64>,
    /// `psi(z^(k-1), w^(k-1))` with `kappa^(k-1)`.
    pub psi: f64,
    /// `kappa^(k-1)`.
    pub kappa: f64,
    /// `m`: the step was `gamma^m` times the direction.
    pub halvings: usize,
    /// The solver that gave the direction; differs from the one asked for after a switch.
    pub solver: DirectionSolver,
}

/// A strictly feasible pair.
#[derive(Clone)]
struct Point {
    z: Vec<f64>,
    w: Vec<f64>,
}

impl Point {
    fn gap(&self) -> f64 {
        self.z.iter().zip(&self.w).map(|(z, w)| z * w).sum()
    }

    /// `min_i z_i w_i`, the paper's rho.
    fn smallest_product(&self) -> f64 {
        self.z.iter().zip(&self.w).map(|(z, w)| z * w).fold(f64::INFINITY, f64::min)
    }

    /// `psi(z, w)` for a given `kappa`.
    fn potential(&self, kappa: f64) -> f64 {
        kappa * self.gap().ln() - self.z.iter().zip(&self.w).map(|(z, w)| (z * w).ln()).sum::<f64>()
    }
}

/// The paper's potential reduction method on the caller's own numbers, from `z0` or from [`strictly_feasible`].
///
/// O(n^3) an iteration. Linear convergence for row sufficient A; no guarantee beyond P0. `trace` is called with
/// each row of the table.
///
/// # Errors
/// `OutOfRange` for a parameter, `WrongLength`, `NotFinite` or `NotStrictlyFeasible` for `z0`.
pub fn potential_reduction(
    lcp: &Lcp,
    z0: Option<&[f64]>,
    settings: &Settings,
    control: &Control<'_>,
    mut trace: impl FnMut(Record),
) -> Result<Candidate> {
    settings.validate()?;
    let n = lcp.n();
    if n == 0 {
        return Ok(Candidate::point(Vec::new(), Termination::Converged, 0));
    }
    let mut point = match z0 {
        Some(z0) => checked_start(lcp, z0)?,
        None => match strictly_feasible(lcp, control) {
            Ok(z) => Point { w: slack(lcp, &z).0, z },
            Err(failed) => return Ok(*failed),
        },
    };
    let scaling = lcp.scaling();
    let mut progress = Progress::new(n);
    let mut solver = settings.direction;
    let mut k = 0;
    let termination = loop {
        if settings.reached(lcp, &point, &scaling) {
            break Termination::Converged;
        }
        if let Some(stop) = control.stop(k, DEFAULT_MAX_ITERATIONS) {
            break stop;
        }
        if progress.stalled(point.gap()) {
            break Termination::Breakdown(
                "z'w stopped falling: one product z_i w_i vanishes before the others; outside P0 nothing forbids this",
            );
        }
        let kappa = settings.kappa_factor * (n as f64).max(point.gap() / point.smallest_product());
        let Some(direction) = scaled_direction(lcp.a(), &point.z, &point.w, kappa, solver) else {
            break Termination::Breakdown("the direction is not finite: a product z_i w_i underflowed");
        };
        solver = direction.solver;
        let Some(step) = settings.line_search(&point, &direction, kappa) else {
            break Termination::Breakdown("no step along the direction decreases the potential");
        };
        let psi = point.potential(kappa);
        point.advance(&step);
        k += 1;
        trace(Record {
            k,
            z: point.z.clone(),
            w: point.w.clone(),
            dz: step.dz,
            dw: step.dw,
            psi,
            kappa,
            halvings: step.halvings,
            solver,
        });
    };
    Ok(Candidate::point(point.z, termination, k))
}

/// Whether `z0 > 0` and `A z0 + q > 0`.
#[must_use]
pub fn is_strictly_feasible(lcp: &Lcp, z0: &[f64]) -> bool {
    checked_start(lcp, z0).is_ok()
}

fn checked_start(lcp: &Lcp, z0: &[f64]) -> Result<Point> {
    if z0.len() != lcp.n() {
        return Err(LcpError::WrongLength { name: "z0", expected: lcp.n(), found: z0.len() });
    }
    check_finite("z0", z0)?;
    let w0 = slack(lcp, z0).0;
    for (name, v) in [("z0", z0), ("A z0 + q", &w0)] {
        if let Some(index) = v.iter().position(|&x| x.is_nan() || x <= 0.0) {
            return Err(LcpError::NotStrictlyFeasible { name, index, value: v[index] });
        }
    }
    Ok(Point { z: z0.to_vec(), w: w0 })
}

/// A step that passed the line search: `gamma^halvings (dz, dw)`.
struct Step {
    dz: Vec<f64>,
    dw: Vec<f64>,
    length: f64,
    halvings: usize,
}

impl Point {
    fn advance(&mut self, step: &Step) {
        for (x, d) in self.z.iter_mut().zip(&step.dz).chain(self.w.iter_mut().zip(&step.dw)) {
            *x += step.length * d;
        }
    }
}

impl Settings {
    /// Steps 2 and 3 of the paper: the direction at its length, then the smallest `m` with enough decrease.
    fn line_search(&self, point: &Point, direction: &Direction, kappa: f64) -> Option<Step> {
        let (scale, first) = if self.long_step {
            (TO_BOUNDARY * direction.to_boundary(), 0)
        } else {
            (self.beta / direction.norm(), self.min_halvings)
        };
        if !scale.is_finite() || scale <= 0.0 {
            return None;
        }
        let slope = scale * direction.slope();
        let halvings = (first..MAX_HALVINGS).find(|&m| {
            let length = self.gamma.powi(m as i32);
            direction.potential_change(&point.z, &point.w, kappa, length * scale) <= self.sigma * length * slope
        })?;
        let times = |x: &[f64], d: &[f64]| x.iter().zip(d).map(|(x, d)| scale * x * d).collect();
        Some(Step {
            dz: times(&point.z, &direction.u),
            dw: times(&point.w, &direction.v),
            length: self.gamma.powi(halvings as i32),
            halvings,
        })
    }

    fn reached(&self, lcp: &Lcp, point: &Point, scaling: &Scaling) -> bool {
        match self.stop {
            Stop::Gap(eps) => point.gap() <= eps,
            Stop::Residual(tol) => {
                natural_residual(&point.z, &point.w) <= 5.0 * tol * max_abs(lcp.q())
                    && equilibrated_residual(&scaling.z_from_caller(&point.z), &scaling.w_from_caller(&point.w))
                        <= 0.5 * tol
            }
        }
    }
}

/// Remembers `z'w` at the start of the current window.
struct Progress {
    window: usize,
    iterations: usize,
    gap: f64,
}

impl Progress {
    fn new(n: usize) -> Self {
        Self { window: STALL_WINDOW.max(n), iterations: 0, gap: f64::INFINITY }
    }

    fn stalled(&mut self, gap: f64) -> bool {
        self.iterations += 1;
        if self.iterations % self.window != 1 {
            return false;
        }
        let stalled = gap > (1.0 - STALL_DECREASE) * self.gap;
        self.gap = gap;
        stalled
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper() -> Lcp {
        let a = vec![0.0, 1.0, 1.0, 2.0, 0.0, 2.0, -2.0, -5.0, 0.0];
        Lcp::new(3, a, vec![-4.0, -7.0, 10.0]).expect("finite")
    }

    fn run(lcp: &Lcp, z0: Option<&[f64]>, settings: &Settings) -> (Candidate, Vec<Record>) {
        let mut rows = Vec::new();
        let found = potential_reduction(lcp, z0, settings, &Control::default(), |row| rows.push(row));
        (found.expect("valid input"), rows)
    }

    fn near(found: &[f64], expected: &[f64], half_digit: f64) {
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() <= half_digit, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn table_1_to_every_printed_digit() {
        for direction in [DirectionSolver::Cholesky, DirectionSolver::Qr] {
            let settings = Settings { direction, ..Settings::default() };
            let (found, rows) = run(&paper(), Some(&[1.0, 1.0, 5.0]), &settings);
            near(&rows[0].z, &[1.05298, 1.09436, 4.75675], 5e-6);
            near(&rows[0].w, &[1.85110, 4.61945, 2.42226], 5e-6);
            near(&rows[1].z, &[1.09564, 1.17472, 4.52917], 5e-6);
            near(&rows[49].w, &[0.006079, 0.003885, 0.002808], 5e-7);
            let printed = [(1, 29.3308), (2, 23.2919), (50, 2.4618), (96, 1.1684), (97, 1.1416), (100, 1.0565)];
            for (k, psi) in printed {
                near(&[rows[k - 1].psi], &[psi], 5e-5);
            }
            assert_eq!((found.termination, found.iterations), (Termination::Converged, 108));
        }
    }

    #[test]
    fn stall_of_the_two_by_two_counterexample_is_reported() {
        let lcp = Lcp::new(2, vec![1.0, 2.0, 2.0, 1.0], vec![-7.0, -3.0]).expect("finite");
        for min_halvings in [0, 1] {
            let settings = Settings { min_halvings, ..Settings::default() };
            let (found, rows) = run(&lcp, Some(&[2.0, 3.0]), &settings);
            assert!(matches!(found.termination, Termination::Breakdown(_)), "{:?}", found.termination);
            let last = rows.last().expect("steps were made");
            assert!(last.z.iter().zip(&last.w).map(|(z, w)| z * w).sum::<f64>() > 1.7);
        }
    }

    #[test]
    fn phase_one_starts_the_paper_example_and_long_steps_are_few() {
        let settings = Settings { long_step: true, stop: Stop::Residual(1e-8), ..Settings::default() };
        let (found, rows) = run(&paper(), None, &settings);
        assert_eq!(found.termination, Termination::Converged);
        assert!(rows.len() <= 40, "{}", rows.len());
    }

    #[test]
    fn no_strictly_feasible_point_is_a_breakdown_and_a_bad_start_an_error() {
        let lcp = Lcp::new(1, vec![-1.0], vec![0.0]).expect("finite");
        let (found, rows) = run(&lcp, None, &Settings::default());
        assert!(matches!(found.termination, Termination::Breakdown(_)) && rows.is_empty());
        let start = potential_reduction(&paper(), Some(&[1.0; 3]), &Settings::default(), &Control::default(), |_| ());
        assert!(matches!(start, Err(LcpError::NotStrictlyFeasible { name: "A z0 + q", index: 0, .. })));
    }
}
