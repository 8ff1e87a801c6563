//! Exact kernels behind the matrix-class predicates.

pub mod budget;
pub mod class;
pub mod connected;
pub mod cover;
pub mod definite;
pub mod dominance;
pub mod formula;
pub mod game;
pub mod minors;
pub mod pieces;
pub mod scan;
pub mod semimonotone;
pub mod solvable;
pub mod subdefinite;
pub mod sufficient;
pub mod transforms;
pub mod zero_solutions;
