//! Complementary pairs, principal pivot transforms and dictionaries: what the pivoting methods share.

pub mod basis;
pub mod delayed;
pub mod dictionary;
pub mod finish;
pub mod path;
pub mod real;
pub mod semidefinite;
pub mod transform;

pub use crate::exact::var::Var;
pub use delayed::DelayedDictionary;
pub use dictionary::{Dictionary, Entering};
pub use path::Tableau;
pub use real::Real;
