//! Exact arithmetic on the binary numbers that were given.

pub mod cone;
pub mod dyadic;
pub mod elimination;
pub mod face;
pub mod farkas;
pub mod feasibility;
pub mod imatrix;
pub mod int;
mod lift;
pub mod lp;
pub mod modular;
pub mod padic;
pub mod proof;
pub mod ray;
pub mod reconstruct;
pub mod repair;
mod rows;
pub mod sufficiency;
