//! What a method hands to `certify` ([`Candidate`]) and what the caller gets ([`Solution`]).

use crate::exact::sufficiency::NotSufficient;
use crate::member::Member;
use crate::status::{Status, Termination};
use crate::verdict::{Certificate, Verdict};

/// A secondary ray of Lemke's method: `w + t w_hat = A (z + t z_hat) + q + d (z0 + t z0_hat)` stays
/// almost complementary for all `t >= 0`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ray {
    /// Where the ray starts.
    pub z: Vec<f64>,
    /// Value of the artificial variable there, positive.
    pub z0: f64,
    /// Direction, nonnegative, not zero.
    pub z_hat: Vec<f64>,
    /// Direction of the artificial variable, nonnegative.
    pub z0_hat: f64,
    /// Direction of the slacks, `w_hat = A z_hat + d z0_hat >= 0`.
    pub w_hat: Vec<f64>,
    /// The covering vector, up to a positive factor that `z0` and `z0_hat` make up for.
    pub d: Vec<f64>,
}

/// What a method found, in the units of the problem it was given. A claim until certified.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The last or best iterate.
    pub z: Vec<f64>,
    /// Indices with `z_i` basic, when the method ends with a basis.
    pub alpha: Option<Vec<usize>>,
    /// How the method stopped.
    pub termination: Termination,
    /// Pivots or iterations.
    pub iterations: usize,
    /// The secondary ray, when that is how it stopped.
    pub ray: Option<Ray>,
    /// A candidate Farkas vector: `y >= 0, A'y <= 0, q'y < 0`.
    pub farkas: Option<Vec<f64>>,
    /// A proof that A is not sufficient.
    pub not_sufficient: Option<NotSufficient>,
}

impl Candidate {
    /// A point without basis, ray or Farkas vector.
    #[must_use]
    pub fn point(z: Vec<f64>, termination: Termination, iterations: usize) -> Self {
        Self { z, alpha: None, termination, iterations, ray: None, farkas: None, not_sufficient: None }
    }
}

/// A part of the problem that was solved on its own: its indices and who answered.
pub type Piece = (Vec<usize>, Member);

/// The verified result of one solve.
#[derive(Clone, Debug)]
pub struct Solution {
    pub(crate) z: Vec<f64>,
    pub(crate) w: Vec<f64>,
    /// Private to the judge, who alone can make one.
    pub(crate) verdict: Verdict,
    pub(crate) method: Member,
    pub(crate) iterations: usize,
    pub(crate) residual: f64,
    pub(crate) natural_residual: f64,
    pub(crate) alpha: Vec<usize>,
    pub(crate) ray: Option<Ray>,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) message: String,
}

impl Solution {
    /// The point, in the caller's units.
    #[must_use]
    pub fn z(&self) -> &[f64] {
        &self.z
    }

    /// `A z + q`, recomputed.
    #[must_use]
    pub fn w(&self) -> &[f64] {
        &self.w
    }

    /// What is claimed of the problem.
    #[must_use]
    pub fn status(&self) -> Status {
        self.verdict.status()
    }

    /// Whether it is solved.
    #[must_use]
    pub fn is_solved(&self) -> bool {
        self.status() == Status::Solved
    }

    /// Who found the point.
    #[must_use]
    pub fn method(&self) -> Member {
        self.method
    }

    /// Pivots or iterations of that method and of those tried before it.
    #[must_use]
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// `max|min(z', w')| / max(1, max|z'|)` on the equilibrated problem, measured.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// `max|min(z, w)|` on the caller's numbers, measured.
    #[must_use]
    pub fn natural_residual(&self) -> f64 {
        self.natural_residual
    }

    /// The complementary basis, or the support of `z` where the method has no basis.
    #[must_use]
    pub fn alpha(&self) -> &[usize] {
        &self.alpha
    }

    /// Proof of the status, where there is one.
    #[must_use]
    pub fn certificate(&self) -> Option<&Certificate> {
        self.verdict.certificate()
    }

    /// The secondary ray, in the caller's units.
    #[must_use]
    pub fn ray(&self) -> Option<&Ray> {
        self.ray.as_ref()
    }

    /// The parts that were solved one by one; empty when the problem was solved whole. Indices in no part have `z_i = 0`
    /// in every solution.
    #[must_use]
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// One sentence: what happened and what to try next.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }
}
