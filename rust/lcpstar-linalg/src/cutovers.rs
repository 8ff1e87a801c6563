//! All cut-overs of linear algebra: orders at which another method or another path takes over, each with the file in `benches/record/`
//! that shows why.

/// From this order on faer factors, below it nalgebra: there a factorisation costs less than faer's dispatch. Record: `backend.md`.
pub const FAER_FROM: usize = 48;

/// From this order on the library's Cholesky factorisation of `B + D` is as fast as this crate's. Not recorded.
pub const SHIFTED_LIBRARY_FROM: usize = 1024;
