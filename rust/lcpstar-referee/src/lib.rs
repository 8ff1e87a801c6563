//! The referee: what was said about an LCP is right, an honest "no", or wrong. Everything is recomputed in exact arithmetic that
//! shares nothing with the solver; of lcpstar it uses the types it scores, and the equilibration that defines `residual`, once it
//! is seen to be one. `lcpstar-stress` and the fuzzer ask it; [`attacks`] are the problems it has seen solvers fail at.

pub mod attacks;
mod exact;
mod problems;
mod proofs;
pub mod referee;
mod solvable;

pub use attacks::{ATTACKS, Attack};
pub use problems::Problem;
pub use referee::{Answer, Case, Score};
