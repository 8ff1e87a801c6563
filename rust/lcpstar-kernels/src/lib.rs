//! Small problems in SIMD registers: [`small`] solves one at a time, [`batch`] one per lane. Every answer is verified by the rule in
//! [`small::verify`], which is stricter than that of the judge; what the kernels leave goes back to the caller. Functions on slices, which
//! know nothing of other methods.

pub mod batch;
pub mod cutovers;
pub mod member;
pub mod pivots;
pub mod small;
