//! When an iteration may stop, and the best point it has seen. One rule for all of them, in the terms of the judge.

use super::Matrix;
use crate::linalg::kernels::max_abs;
use crate::residual::{ABSOLUTE, Row, Rule, off_by};
use crate::scaling::{Scaling, times_power_of_two};
use crate::tails::Tails;

/// The residual to reach, measured on the equilibrated problem whatever problem the iteration runs on.
///
/// Units are changed by factors per index: `z'_i = z_factor_i z_i`. Empty factors mean 1.
#[derive(Clone, Debug)]
pub struct Goal {
    tol: f64,
    z_factor: Vec<f64>,
    w_factor: Vec<f64>,
    /// To the caller's units, and the largest `|q_i|` there.
    z_caller: Vec<f64>,
    w_caller: Vec<f64>,
    max_q: f64,
    /// What is forgiven, in the units of the target; none where the end of the road looks after tails.
    tails: Option<Tails>,
}

/// The residual of the contract, and its numerator.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// `max|min(z', w')| / max(1, max|z'|)`.
    pub residual: f64,
    /// `max|min(z', w')|`.
    pub natural: f64,
}

impl Goal {
    /// The goal of an iteration on the problem scaled by `scaling`, measured on that scaled by `target`. `q` is the caller's.
    #[must_use]
    pub fn new(tol: f64, scaling: &Scaling, target: &Scaling, q: &[f64]) -> Self {
        let same = scaling == target;
        let factor = |e: i32| times_power_of_two(1.0, e);
        let factors = |f: &dyn Fn(usize) -> i32| (0..q.len()).map(|i| factor(f(i))).collect::<Vec<f64>>();
        let changed = |f: &dyn Fn(usize) -> i32| if same { vec![] } else { factors(f) };
        Self {
            tol,
            z_factor: changed(&|i| scaling.columns[i] - scaling.q + target.q - target.columns[i]),
            w_factor: changed(&|i| target.rows[i] + target.q - scaling.rows[i] - scaling.q),
            z_caller: factors(&|i| scaling.columns[i] - scaling.q),
            w_caller: factors(&|i| -scaling.rows[i] - scaling.q),
            max_q: max_abs(q),
            tails: None,
        }
    }

    /// The same goal, where tails are cut off.
    #[must_use]
    pub fn without_tails(self, tails: Option<Tails>) -> Self {
        Self { tails, ..self }
    }

    /// The goal of an iteration on the caller's numbers as they are.
    #[must_use]
    pub fn plain(tol: f64, q: &[f64]) -> Self {
        let same = Scaling { rows: vec![0; q.len()], columns: vec![0; q.len()], q: 0 };
        Self::new(tol, &same, &same, q)
    }

    /// The tolerance.
    #[must_use]
    pub fn tol(&self) -> f64 {
        self.tol
    }

    /// Measures a point. O(n).
    #[must_use]
    pub fn measure(&self, z: &[f64], w: &[f64]) -> Measure {
        let (mut natural, mut largest) = (0.0_f64, 1.0_f64);
        let mut add = |z: f64, w: f64| {
            natural = natural.max(z.min(w).abs());
            largest = largest.max(z);
        };
        if self.z_factor.is_empty() {
            z.iter().zip(w).for_each(|(&z, &w)| add(z, w));
        } else {
            let factors = self.z_factor.iter().zip(&self.w_factor);
            z.iter().zip(w).zip(factors).for_each(|((z, w), (f, g))| add(z * f, w * g));
        }
        // `max` and `min` lose a NaN, which must never look small.
        let natural = if z.iter().chain(w).any(|x| x.is_nan()) { f64::INFINITY } else { natural };
        Measure { residual: natural / largest, natural }
    }

    /// Whether the judge will accept the point, or the point without the smaller member of each pair. O(n^2) for a dense A.
    #[must_use]
    pub fn is_reached(&self, matrix: &impl Matrix, z: &[f64]) -> bool {
        let (w, magnitude) = matrix.slack(z);
        if self.accepts(z, &w, &magnitude) {
            return true;
        }
        let smaller = |i: usize| z[i] * factor(&self.z_factor, i) < w[i] * factor(&self.w_factor, i);
        let pairs: Vec<f64> = (0..z.len()).map(|i| if smaller(i) { 0.0 } else { z[i] }).collect();
        let (w, magnitude) = matrix.slack(&pairs);
        self.accepts(&pairs, &w, &magnitude)
    }

    /// The [`Rule`] of the judge.
    fn accepts(&self, z: &[f64], w: &[f64], magnitude: &[f64]) -> bool {
        let mut rule = Rule::new(self.tol, self.max_q);
        for i in 0..z.len() {
            let (off, g) = (off_by(z[i], w[i]), factor(&self.w_factor, i));
            rule.add(Row {
                equilibrated: [z[i] * factor(&self.z_factor, i), w[i] * g],
                caller: [z[i] * self.z_caller[i], w[i] * self.w_caller[i], magnitude[i] * self.w_caller[i]],
                part: if off == 0.0 { 0.0 } else { off / magnitude[i] },
                is_tail: self.tails.as_ref().is_some_and(|tails| tails.forgive(i, off * g, magnitude[i] * g)),
            });
        }
        rule.passed(0.0).is_some()
    }

    fn may_be_reached(&self, measure: Measure) -> bool {
        measure.residual <= self.tol && measure.natural <= self.tol.max(ABSOLUTE)
    }
}

/// Empty factors mean 1.
fn factor(factors: &[f64], i: usize) -> f64 {
    factors.get(i).copied().unwrap_or(1.0)
}

/// The best point so far: any stop returns it, so more iterations never give a worse one.
pub struct Incumbent<'a> {
    goal: &'a Goal,
    /// The point.
    pub z: Vec<f64>,
    /// Its residual; infinite before the first.
    pub residual: f64,
    /// The full check is worth its price below this residual.
    check_below: f64,
}

impl<'a> Incumbent<'a> {
    /// Starts from z = 0, unmeasured.
    #[must_use]
    pub fn new(goal: &'a Goal, n: usize) -> Self {
        Self { goal, z: vec![0.0; n], residual: f64::INFINITY, check_below: f64::INFINITY }
    }

    /// Keeps `z >= 0`, with `w = A z + q`, if it is the best yet. `true` when it reaches the goal. O(n), except when it
    /// seems to.
    pub fn offer(&mut self, matrix: &impl Matrix, z: &[f64], w: &[f64]) -> bool {
        self.offer_measured(matrix, z, self.goal.measure(z, w))
    }

    /// As [`Incumbent::offer`], for a z with signs: they are cut off, and w is computed again.
    pub fn offer_clipped(&mut self, matrix: &impl Matrix, z: &mut [f64], w: &mut [f64]) -> bool {
        if z.iter().any(|&z| z < 0.0) {
            z.iter_mut().for_each(|z| *z = z.max(0.0));
            matrix.affine(z, w);
        }
        self.offer(matrix, z, w)
    }

    /// [`Goal::measure`].
    #[must_use]
    pub fn measure(&self, z: &[f64], w: &[f64]) -> Measure {
        self.goal.measure(z, w)
    }

    /// As [`Incumbent::offer`], for a point that was measured.
    pub fn offer_measured(&mut self, matrix: &impl Matrix, z: &[f64], measure: Measure) -> bool {
        if measure.residual < self.residual {
            self.residual = measure.residual;
            self.z.copy_from_slice(z);
        }
        if !self.goal.may_be_reached(measure) || measure.residual > self.check_below {
            return false;
        }
        let reached = self.goal.is_reached(matrix, z);
        if reached {
            self.z.copy_from_slice(z);
        } else {
            self.check_below = 0.5 * measure.residual;
        }
        reached
    }
}

#[cfg(test)]
mod tests {
    use super::super::Dense;
    use super::*;
    use crate::problem::Lcp;
    use crate::residual::equilibrated_residual;

    #[test]
    fn measured_as_by_the_contract_in_any_units() {
        let (z, w) = (vec![3.0, 0.0, 0.5], vec![-0.25, 2.0, 0.125]);
        let plain = Goal::plain(1e-3, &[1.0; 3]).measure(&z, &w);
        assert_eq!(plain.residual, equilibrated_residual(&z, &w));
        let from = Scaling { rows: vec![1, -2, 3], columns: vec![0, 4, -1], q: 2 };
        let target = Scaling { rows: vec![0, 0, 0], columns: vec![0, 0, 0], q: 0 };
        let measured = Goal::new(1e-3, &from, &target, &[1.0; 3]).measure(&z, &w);
        let (z, w) = (from.z_to_caller(&z), from.w_to_caller(&w));
        assert_eq!(measured.residual, equilibrated_residual(&z, &w));
    }

    #[test]
    fn a_nan_is_never_kept_and_a_worse_point_neither() {
        let lcp = Lcp::new(2, vec![1.0, 0.0, 0.0, 1.0], vec![-1.0, -1.0]).expect("valid");
        let (matrix, goal) = (Dense::new(&lcp), Goal::plain(1e-9, lcp.q()));
        let mut best = Incumbent::new(&goal, 2);
        assert!(!best.offer(&matrix, &[0.5, 1.0], &[-0.5, 0.0]));
        assert!(!best.offer(&matrix, &[f64::NAN, 1.0], &[0.0, 0.0]));
        assert!(!best.offer(&matrix, &[0.0, 0.0], &[-1.0, -1.0]));
        assert_eq!(best.z, [0.5, 1.0]);
        assert!(best.offer(&matrix, &[1.0, 1.0], &[0.0, 0.0]));
        assert_eq!(best.z, [1.0, 1.0]);
    }

    #[test]
    fn a_claim_from_a_drifted_w_is_checked() {
        let lcp = Lcp::new(1, vec![1.0], vec![-1.0]).expect("valid");
        let (matrix, goal) = (Dense::new(&lcp), Goal::plain(1e-9, lcp.q()));
        assert!(!Incumbent::new(&goal, 1).offer(&matrix, &[0.5], &[0.0]));
    }
}
