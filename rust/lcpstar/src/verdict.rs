//! What is claimed of a problem. A [`Verdict`] is made from [`Evidence`] and from nothing else, by one function; evidence for
//! "solved", "infeasible" and "nearly infeasible" is made by those who checked it.
//!
//! ```compile_fail
//! // The fields are private: nobody else says "solved".
//! let verdict = lcpstar::Verdict { status: lcpstar::Status::Solved, certificate: None };
//! ```

use crate::exact::dyadic::RationalVec;
use crate::exact::proof::ExactSolution;
use crate::exact::sufficiency::NotSufficient;
use crate::refute::Refutation;
use crate::residual::Passed;
use crate::small::Accepted;
use crate::status::{Status, Termination};

/// A status with its certificate.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    status: Status,
    certificate: Option<Certificate>,
}

/// What a verdict rests on.
#[expect(dead_code, reason = "tokens are there to be there, not to be read")]
pub(crate) enum Evidence {
    /// A point passed the rule of the judge; the support or basis that it belongs to.
    Passed(Passed, Vec<usize>),
    /// A point passed the stricter rule of a kernel.
    Accepted(Accepted, Vec<usize>),
    /// An exact solution.
    Proved(ExactSolution),
    /// A proof that no small point is feasible, or none at all.
    Refuted(Refutation),
    /// None of these: how the method stopped, and what it proved beside.
    Stopped(Termination, Option<Aside>),
}

/// An exact statement that says nothing about the problem itself.
pub(crate) enum Aside {
    /// An exact solution that no double holds.
    Solution(ExactSolution),
    /// The direction of z of an exact secondary ray.
    Ray(RationalVec),
    NotSufficient(NotSufficient),
}

impl Verdict {
    /// The one constructor.
    pub(crate) fn of(evidence: Evidence) -> Self {
        let solution = |alpha, exact| (Status::Solved, Some(Certificate::Solution { alpha, exact }));
        let (status, certificate) = match evidence {
            Evidence::Passed(_, alpha) | Evidence::Accepted(_, alpha) => solution(alpha, None),
            Evidence::Proved(ExactSolution { alpha, z, .. }) => solution(alpha, Some(z)),
            Evidence::Refuted(Refutation::Exact(farkas)) => {
                (Status::Infeasible, Some(Certificate::Infeasible { y: farkas.into_vector() }))
            }
            Evidence::Refuted(Refutation::Nearly(near)) => {
                let (y, bound) = near.into_parts();
                (Status::NearlyInfeasible, Some(Certificate::NearlyInfeasible { y, bound }))
            }
            Evidence::Stopped(termination, aside) => (stopped(termination), aside.map(Certificate::from)),
        };
        Self { status, certificate }
    }

    /// The status.
    #[must_use]
    pub fn status(&self) -> Status {
        self.status
    }

    /// Its certificate.
    #[must_use]
    pub fn certificate(&self) -> Option<&Certificate> {
        self.certificate.as_ref()
    }
}

/// The status of a point that neither solves the problem nor comes with a proof that nothing does.
fn stopped(termination: Termination) -> Status {
    match termination {
        Termination::SecondaryRay => Status::SecondaryRay,
        Termination::IterationLimit => Status::MaxIterations,
        Termination::TimeLimit | Termination::Interrupted => Status::TimeLimit,
        Termination::ComplementaryBasis
        | Termination::Converged
        | Termination::Infeasible
        | Termination::NotZ { .. }
        | Termination::NotSufficient
        | Termination::Breakdown(_) => Status::NumericalBreakdown,
    }
}

/// Why the status may be believed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Certificate {
    /// `z` solves the problem; `alpha` is its complementary basis or support.
    Solution {
        /// Indices with `w_i = 0` in the basis.
        alpha: Vec<usize>,
        /// The solution in exact arithmetic, when it was proved there.
        exact: Option<RationalVec>,
    },
    /// `y >= 0, A'y <= 0, q'y < 0` exactly: no `z >= 0` has `A z + q >= 0`.
    Infeasible {
        /// The Farkas vector.
        y: RationalVec,
    },
    /// `y >= 0, q'y < 0`, and `A'y` exceeds 0 by no more than rounding of its own sums.
    NearlyInfeasible {
        /// The vector.
        y: Vec<f64>,
        /// `-q'y / max(A'y)`, rounded down: no feasible z has a smaller sum.
        bound: f64,
    },
    /// A secondary ray, proved in exact arithmetic: no claim about the problem.
    Ray {
        /// Direction of `z`.
        z_hat: RationalVec,
    },
    /// A vector that refutes the sufficiency of A, checked in exact arithmetic: no claim about the problem.
    NotSufficient(NotSufficient),
}

impl From<Aside> for Certificate {
    fn from(aside: Aside) -> Self {
        match aside {
            Aside::Solution(ExactSolution { alpha, z, .. }) => Self::Solution { alpha, exact: Some(z) },
            Aside::Ray(z_hat) => Self::Ray { z_hat },
            Aside::NotSufficient(found) => Self::NotSufficient(found),
        }
    }
}
