//! lcpstar: the linear complementarity problem LCP(q, A),
//!
//! find `z` with  `w = A z + q >= 0`,  `z >= 0`,  `z'w = 0`,
//!
//! solved, verified and, on request, proved. Imports point one way:
//! `error, status <- problem <- linalg, residual, pivoting, exact <- methods, certify <- driver <- batch`.
//! [CPS92] writes `M` for our `A`; here `M` is a principal pivot transform of `A`.

pub mod classes;
pub mod error;
pub mod exact;
pub mod problem;
pub mod status;

pub use error::{LcpError, Result};
pub use problem::Lcp;
pub use status::{Status, Termination};
