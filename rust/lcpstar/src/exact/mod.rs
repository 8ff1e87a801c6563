//! Exact arithmetic on the binary numbers that were given.

pub mod dyadic;
pub mod modular;
pub mod padic;
pub mod proof;
pub mod reconstruct;
pub mod repair;
