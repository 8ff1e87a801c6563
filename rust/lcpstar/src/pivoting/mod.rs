//! Complementary pairs, principal pivot transforms and dictionaries: what the pivoting methods share.
