//! A point with its numbers.

use crate::residual::Passed;

/// A point in the caller's units, measured.
pub(super) struct Judged {
    pub(super) z: Vec<f64>,
    pub(super) w: Vec<f64>,
    pub(super) residual: f64,
    pub(super) natural_residual: f64,
    pub(super) passed: Option<Passed>,
}

impl Judged {
    pub(super) fn is_finite(&self) -> bool {
        self.z.iter().chain(&self.w).chain([&self.residual, &self.natural_residual]).all(|x| x.is_finite())
    }
}
