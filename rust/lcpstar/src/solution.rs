//! What a method hands to `certify` ([`Candidate`]) and what the caller gets ([`Solution`]).

use crate::exact::dyadic::RationalVec;
use crate::exact::sufficiency::NotSufficient;
use crate::status::{Status, Termination};

/// A secondary ray of Lemke's method: `w + t w_hat = A (z + t z_hat) + q + d (z0 + t z0_hat)` stays
/// almost complementary for all `t >= 0`.
#[derive(Clone, Debug, PartialEq)]
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

/// Why the status may be believed.
#[derive(Clone, Debug, PartialEq)]
pub enum Certificate {
    /// `z` solves the problem; `alpha` is its complementary basis or support.
    Solution {
        /// Indices with `w_i = 0` in the basis.
        alpha: Vec<usize>,
        /// The solution in exact arithmetic, when it was proved there.
        exact: Option<RationalVec>,
    },
    /// `y >= 0, A'y <= 0, q'y < 0`: no `z >= 0` has `A z + q >= 0`.
    Infeasible {
        /// The Farkas vector.
        y: Vec<f64>,
        /// The vector in exact arithmetic, when it was proved there.
        exact: Option<RationalVec>,
    },
    /// A secondary ray, proved in exact arithmetic: no claim about the problem.
    Ray {
        /// Direction of `z`.
        z_hat: RationalVec,
    },
    /// A vector that refutes the sufficiency of A, checked in exact arithmetic: no claim about the problem.
    NotSufficient(NotSufficient),
}

/// A part of the problem that was solved on its own: its indices and the method that answered.
pub type Piece = (Vec<usize>, &'static str);

/// The verified result of one solve.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The point, in the caller's units.
    pub z: Vec<f64>,
    /// `A z + q`, recomputed in twice the working precision.
    pub w: Vec<f64>,
    /// The verdict.
    pub status: Status,
    /// Which method (or member of the portfolio) produced the point.
    pub method: &'static str,
    /// Pivots or iterations of that method and of those tried before it.
    pub iterations: usize,
    /// Scale-free residual on the equilibrated problem; `tol` bounds it when solved.
    pub residual: f64,
    /// `max|min(z, w)|` on the caller's numbers.
    pub natural_residual: f64,
    /// The complementary basis, or the support of `z` where the method has no basis.
    pub alpha: Vec<usize>,
    /// Proof of the status, where there is one.
    pub certificate: Option<Certificate>,
    /// The secondary ray, in the caller's units.
    pub ray: Option<Ray>,
    /// The parts that were solved one by one; empty when the problem was solved whole. Indices in no part have `z_i = 0`
    /// in every solution.
    pub pieces: Vec<Piece>,
    /// One sentence: what happened and what to try next.
    pub message: String,
}
