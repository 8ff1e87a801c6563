//! Complementary pairs, principal pivot transforms and dictionaries: what the pivoting methods share.

pub mod basis;
pub mod dictionary;
pub mod real;
pub mod transform;
pub mod var;

pub use dictionary::{Dictionary, Entering};
pub use real::Real;
pub use var::Var;
