//! How a method stopped ([`Termination`]) and what that means for the caller ([`Status`]).

/// The outcome reported to the user. What [`crate::Solution`] says of itself comes from the [`judge`](crate::judge) alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
#[non_exhaustive]
pub enum Status {
    /// The point passed the rule of the judge, or an exact solution was proved.
    Solved,
    /// FEA(q, A) is empty: the certificate's y has `y >= 0`, `A'y <= 0`, `q'y < 0` exactly.
    Infeasible,
    /// No z with `sum(z)` below the certificate's bound is feasible, and the bound is large.
    NearlyInfeasible,
    /// Lemke's method ended on a ray and nothing follows from it for this matrix.
    SecondaryRay,
    /// The iteration limit was reached.
    MaxIterations,
    /// The time limit was reached.
    TimeLimit,
    /// The method could not go on in floating point; `message` says why.
    NumericalBreakdown,
}

impl Status {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 7] = [
        Self::Solved,
        Self::Infeasible,
        Self::NearlyInfeasible,
        Self::SecondaryRay,
        Self::MaxIterations,
        Self::TimeLimit,
        Self::NumericalBreakdown,
    ];

    /// Whether it says something about the problem, and not only how a method stopped.
    #[must_use]
    pub fn is_answer(self) -> bool {
        matches!(self, Self::Solved | Self::Infeasible | Self::NearlyInfeasible)
    }

    /// The name used in Python and on the command line.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Infeasible => "infeasible",
            Self::NearlyInfeasible => "nearly_infeasible",
            Self::SecondaryRay => "secondary_ray",
            Self::MaxIterations => "max_iterations",
            Self::TimeLimit => "time_limit",
            Self::NumericalBreakdown => "numerical_breakdown",
        }
    }
}

/// How a method stopped: one variant per way out of its loop. A claim, not yet a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    /// A complementary feasible basis (pivoting methods).
    ComplementaryBasis,
    /// The method's own stopping rule on its residual or gap.
    Converged,
    /// Lemke: no blocking row.
    SecondaryRay,
    /// The method found a candidate Farkas vector.
    Infeasible,
    /// `max_iterations` was reached.
    IterationLimit,
    /// `time_limit` was reached.
    TimeLimit,
    /// The observer asked to stop (Ctrl-C).
    Interrupted,
    /// The method is for Z-matrices, and this entry is positive.
    NotZ {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// The method holds a proof that A is not sufficient.
    NotSufficient,
    /// It cannot go on; the reason.
    Breakdown(&'static str),
}
