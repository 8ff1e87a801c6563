//! Exact arithmetic on the binary numbers that were given.

pub mod cone;
pub mod elimination;
pub mod imatrix;
pub mod int;
pub mod lp;
