//! The methods that lanes try, one after the other.

/// Iterations of Newton's method after which a problem goes on to Lemke's method.
const ITERATIONS: usize = 6;

/// In this order.
pub(super) const PHASES: [Phase; 6] =
    [Phase::Guess, Phase::Point, Phase::Single, Phase::Enumerate, Phase::Newton, Phase::Lemke];

/// What lanes do together.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// One factorisation for the support that the caller guesses.
    Guess,
    /// The point that the caller guesses, as it is.
    Point,
    /// Newton's method in single precision.
    Single,
    Enumerate,
    Newton,
    Lemke,
}

impl Phase {
    pub fn is_newton(self) -> bool {
        matches!(self, Self::Single | Self::Newton)
    }

    /// At most.
    pub fn iterations(self) -> usize {
        if self.is_newton() { ITERATIONS } else { 1 }
    }
}
