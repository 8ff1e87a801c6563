//! Vectors, double-double sums and dense solves.

pub mod backend;
pub mod dd;
pub mod kernels;
