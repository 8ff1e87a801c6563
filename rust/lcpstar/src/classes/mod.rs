//! Exact kernels behind the matrix-class predicates.
