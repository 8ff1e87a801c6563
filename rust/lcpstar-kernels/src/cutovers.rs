//! All cut-overs of the kernels: orders at which another method or another path takes over, each with the file in `benches/record/`
//! that shows why.

/// Up to this order lanes try every support by its minors. Not recorded.
pub const MINORS_ORDER: usize = 3;

/// Up to this order Lemke's method runs in lanes: above, one problem at a time is faster. Not recorded.
pub const LEMKE_ORDER: usize = 12;

/// Up to this order lanes try Newton's method without a guess: above, Lemke's method costs a third less where A is singular. Not recorded.
pub const NEWTON_ORDER: usize = 16;

/// Up to this order sixteen problems at a time, two chains of operations, are faster than eight. Not recorded.
pub const PAIR_ORDER: usize = 16;

/// Up to this order masking the rows outside the support is cheaper than leaving them out. Not recorded.
pub const MASKED_ORDER: usize = 16;

/// Up to this order a guessed support is tried in lanes. Not recorded.
pub const GUESS_ORDER: usize = 32;

/// Up to this order the kernel's limit on pivots grows: above, the portfolio does better than to wait. Not recorded.
pub const PATIENT_UP_TO: usize = 64;

/// Up to this order the kernel for small problems goes before the portfolio. Record: `families.md`.
pub const TINY_ORDER: usize = 128;
