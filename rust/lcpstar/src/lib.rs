#![doc = include_str!("../README.md")]
//!
//! # Inside
//! Imports point one way: `error, status <- problem <- residual, pivoting, presolve <- methods, judge <- driver <- batch <- api`; linear
//! algebra, exact arithmetic and the kernels for small problems are crates below. [CPS92] writes `M` for our `A`; inside, `M` is a
//! principal pivot transform of `A`. Hidden modules are for the crates of this repository and promise nothing.

mod api;
mod error;
mod judge;
mod options;
mod presolve;
mod problem;
mod refute;
mod residual;
mod solution;
mod sparse;
mod status;
mod tails;
mod verdict;

#[doc(hidden)]
pub mod accuracy;
#[doc(hidden)]
pub mod batch;
#[doc(hidden)]
pub mod control;
#[doc(hidden)]
pub mod cutovers;
#[doc(hidden)]
pub mod driver;
#[doc(hidden)]
pub mod equilibrate;
#[cfg(feature = "exact")]
#[doc(hidden)]
pub mod explore;
#[doc(hidden)]
pub mod iterative;
#[doc(hidden)]
pub mod methods;
#[doc(hidden)]
pub mod pivoting;
#[doc(hidden)]
pub mod scaling;
#[cfg(feature = "exact")]
#[doc(hidden)]
pub mod solutions;

#[cfg(feature = "exact")]
pub use api::all_solutions;
pub use api::{Batch, classify, is_in_class, ppt, solve, solve_batch, solve_sparse};
pub use driver::{Certify, Method};
pub use error::{LcpError, Result};
pub use lcpstar_exact::dyadic::RationalVec;
pub use lcpstar_exact::sufficiency::NotSufficient;
pub use lcpstar_kernels::member::Member;
pub use options::Options;
pub use problem::Lcp;
pub use solution::{Piece, Ray, Solution};
#[cfg(feature = "exact")]
pub use solutions::Face;
pub use sparse::SparseLcp;
pub use status::Status;
pub use verdict::Certificate;

#[doc(hidden)]
pub use control::Control;
#[doc(hidden)]
pub use lcpstar_exact::{self as exact, classes};
#[doc(hidden)]
pub use lcpstar_kernels::{member, small};
#[doc(hidden)]
pub use lcpstar_linalg as linalg;
#[doc(hidden)]
pub use solution::Candidate;
#[doc(hidden)]
pub use status::Termination;
#[doc(hidden)]
pub use verdict::Verdict;

/// What most programs need: `use lcpstar::prelude::*;`.
pub mod prelude {
    pub use crate::{Certificate, Lcp, Options, Solution, SparseLcp, Status, solve, solve_batch, solve_sparse};
}
