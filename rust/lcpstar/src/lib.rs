//! lcpstar: the linear complementarity problem LCP(q, A),
//!
//! find `z` with  `w = A z + q >= 0`,  `z >= 0`,  `z'w = 0`,
//!
//! solved, verified and, on request, proved. Imports point one way:
//! `error, status <- problem <- linalg, residual, pivoting, exact, presolve <- methods, judge <- driver <- batch`.
//! [CPS92] writes `M` for our `A`; here `M` is a principal pivot transform of `A`.

pub mod accuracy;
pub mod batch;
pub mod control;
pub mod driver;
pub mod equilibrate;
pub mod error;
pub mod iterative;
pub mod judge;
pub mod methods;
pub mod pivoting;
pub mod presolve;
pub mod problem;
pub mod refute;
pub mod residual;
pub mod scaling;
pub mod solution;
pub mod solutions;
pub mod sparse;
pub mod status;
pub mod tails;
pub mod verdict;

pub use control::Control;
pub use error::{LcpError, Result};
pub use lcpstar_exact as exact;
pub use lcpstar_exact::classes;
pub use lcpstar_kernels::member::{self, Member};
pub use lcpstar_kernels::small;
pub use lcpstar_linalg as linalg;
pub use problem::Lcp;
pub use solution::{Candidate, Piece, Ray, Solution};
pub use sparse::SparseLcp;
pub use status::{Status, Termination};
pub use verdict::{Certificate, Verdict};
