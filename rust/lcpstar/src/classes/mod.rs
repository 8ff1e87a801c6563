//! Exact kernels behind the matrix-class predicates.

pub mod budget;
pub mod connected;
pub mod cover;
pub mod definite;
pub mod game;
pub mod minors;
pub mod semimonotone;
pub mod solvable;
pub mod subdefinite;
pub mod sufficient;
pub mod transforms;
pub mod zero_solutions;
