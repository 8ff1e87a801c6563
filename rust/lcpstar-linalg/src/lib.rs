//! Vectors, double-double sums, dense and sparse factorisations: functions on slices, which know nothing of problems. The only
//! crate that names faer and nalgebra; its entry points are not generic, so that their code is compiled here and nowhere else.

pub mod backend;
pub mod blocked;
pub mod compensated;
pub mod cutovers;
pub mod dd;
pub mod kernels;
pub mod square;
pub mod update;
