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
