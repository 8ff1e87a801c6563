//! What the caller of a batch may choose.

use super::Guess;
use crate::driver::Method;
use lcpstar_kernels::batch::task::Asked;

/// What the caller may choose.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// `Auto` for the kernels with the portfolio behind them; any other method solves every problem alone.
    pub method: &'a Method,
    /// Bounds `residual` of a solved problem.
    pub tol: f64,
    /// Threads at most; 0: one per core.
    pub threads: usize,
    /// Guessed supports.
    pub guess: Guess<'a>,
    /// Says whether the caller wants to stop; asked between chunks.
    pub interrupted: Option<&'a (dyn Fn() -> bool + Sync)>,
}

impl Settings<'_> {
    /// Whether the kernels for small problems are asked before the general solver.
    pub(super) fn by_kernels(&self) -> bool {
        matches!(self.method, Method::Auto)
    }

    /// What the kernels are asked.
    pub(super) fn asked(&self) -> Asked<'_> {
        Asked { tol: self.tol, guess: self.guess, in_lanes: self.by_kernels() }
    }
}
