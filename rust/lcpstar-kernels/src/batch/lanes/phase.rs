//! The methods that lanes try, one after the other.

/// Iterations of Newton's method after which a problem goes on to Lemke's method.
const ITERATIONS: usize = 6;

/// In this order.
pub(super) const PHASES: [Phase; 5] = [Phase::Guess, Phase::Point, Phase::Enumerate, Phase::Newton, Phase::Lemke];

/// What lanes do together.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// One factorisation for the support that the caller guesses.
    Guess,
    /// The point that the caller guesses, as it is.
    Point,
    Enumerate,
    Newton,
    Lemke,
}

impl Phase {
    pub fn is_newton(self) -> bool {
        self == Self::Newton
    }

    /// At most.
    pub fn iterations(self) -> usize {
        if self.is_newton() { ITERATIONS } else { 1 }
    }
}
