//! Exact arithmetic on the binary numbers that were given: proofs of solutions, rays and infeasibility, and the classes of
//! matrices. Knows problems as borrowed numbers ([`problem::Problem`]), nothing of methods, tolerances or floating-point answers
//! beyond the supports they propose; depends on big integers only.

pub mod classes;
pub mod cone;
mod cutovers;
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
pub mod problem;
pub mod proof;
pub mod ray;
pub mod reconstruct;
pub mod repair;
mod rows;
pub mod sufficiency;
pub mod var;
