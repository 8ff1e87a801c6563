//! What a caller may choose.

use crate::control::Control;
use crate::driver::{Certify, Method, Settings};
use std::time::{Duration, Instant};

/// What a caller may choose; [`Options::default`] is right for most problems.
///
/// ```
/// use lcpstar::{Certify, Method, Options};
/// # fn main() -> lcpstar::Result<()> {
/// let options = Options::default().method(Method::from_name("lemke")?).certify(Certify::Exact);
/// let solution = lcpstar::solve(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0], &options)?;
/// assert!(solution.is_solved());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
#[must_use]
pub struct Options {
    pub(crate) settings: Settings,
    pub(crate) max_iterations: Option<usize>,
    pub(crate) time_limit: Option<Duration>,
    pub(crate) threads: usize,
}

impl Options {
    /// The method; [`Method::Auto`] unless it is said.
    pub fn method(mut self, method: Method) -> Self {
        self.settings.method = method;
        self
    }

    /// Bound on [`residual`](crate::Solution::residual) of a solved problem, in (0, 1); 1e-9 unless it is said.
    pub fn tol(mut self, tol: f64) -> Self {
        self.settings.tol = tol;
        self
    }

    /// A guess: its support or its values help, whatever they are. In a batch, `n` numbers for each problem.
    pub fn z0(mut self, z0: Vec<f64>) -> Self {
        self.settings.z0 = Some(z0);
        self
    }

    /// Whether the answer is to be proved in exact arithmetic.
    pub fn certify(mut self, certify: Certify) -> Self {
        self.settings.certify = certify;
        self
    }

    /// Pivots or iterations at most.
    pub fn max_iterations(mut self, iterations: usize) -> Self {
        self.max_iterations = Some(iterations);
        self
    }

    /// Time at most: a method stops at its next iteration.
    pub fn time_limit(mut self, limit: Duration) -> Self {
        self.time_limit = Some(limit);
        self
    }

    /// Threads at most in a batch; 0, the default, is one per core. One problem is solved on the calling thread.
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = threads;
        self
    }

    /// From now on.
    pub(crate) fn control(&self) -> Control<'static> {
        let deadline = deadline(self.time_limit);
        Control { max_iterations: self.max_iterations, deadline, interrupted: None }
    }
}

/// A limit too long to express is none.
pub(crate) fn deadline(limit: Option<Duration>) -> Option<Instant> {
    limit.and_then(|limit| Instant::now().checked_add(limit))
}
