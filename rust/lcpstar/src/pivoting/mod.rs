//! Complementary pairs, principal pivot transforms and dictionaries: what the pivoting methods share.

pub mod basis;
pub mod dictionary;
pub mod finish;
pub mod real;
pub mod semidefinite;
pub mod transform;

pub use crate::exact::var::Var;
pub use dictionary::{Dictionary, Entering};
pub use real::Real;

/// Pivots of an almost complementary path when the caller gives no limit: real problems need 0.3 to 3 n; worst cases need 2^n - 1.
#[must_use]
pub fn path_limit(n: usize) -> usize {
    50 + 10 * n
}
