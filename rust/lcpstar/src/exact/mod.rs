//! Exact arithmetic on the binary numbers that were given.
