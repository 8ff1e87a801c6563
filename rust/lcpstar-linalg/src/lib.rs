//! Vectors, double-double sums and dense solves.

pub mod backend;
pub mod blocked;
pub mod compensated;
pub mod dd;
pub mod kernels;
pub mod update;
