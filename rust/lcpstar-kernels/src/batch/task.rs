//! What a worker reads, and the codes of the methods in its results.

use super::io::{Guess, Problems};
use crate::member::Member;

/// Newton's method in lanes.
pub const NEWTON: u8 = Member::Newton.code();
/// Lemke's method, in lanes or for one problem.
pub const LEMKE: u8 = Member::Lemke.code();
/// Every support, in lanes.
pub const ENUMERATE: u8 = Member::Enumerate.code();

/// What is asked of every problem.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// Bounds the residual of a solved problem.
    pub tol: f64,
    /// Guessed supports.
    pub guess: Guess<'a>,
    /// Whether the lanes are to try.
    pub in_lanes: bool,
}

/// What a worker reads.
pub(super) struct Task<'a> {
    pub problems: &'a Problems<'a>,
    pub asked: &'a Asked<'a>,
    /// Place of the chunk in the batch.
    pub first: usize,
}
