//! Exact arithmetic on the binary numbers that were given.

pub mod cone;
pub mod dyadic;
pub mod elimination;
pub mod face;
pub mod imatrix;
pub mod int;
pub mod lp;
pub mod modular;
pub mod padic;
pub mod proof;
pub mod reconstruct;
pub mod repair;
pub mod sufficiency;
