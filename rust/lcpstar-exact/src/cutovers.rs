//! All cut-overs of exact arithmetic: orders at which another method or another path takes over, each with the file in `benches/record/`
//! that shows why.

/// Up to this order subsets are tried by size, so that the witness is a smallest one. Not recorded.
pub const BY_SIZE_UP_TO: usize = 10;
