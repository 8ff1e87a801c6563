//! All cut-overs of solving: orders at which another method or another path takes over, each with the file in `benches/record/`
//! that shows why.

/// Up to this order a call from Python keeps the interpreter's lock: it takes microseconds. Record: `call.md`.
pub const BRIEF_UP_TO: usize = 16;

/// Up to this order a problem, or an island of one, is not taken apart: a few pivots cost less. Not recorded.
pub const WHOLE_UP_TO: usize = 16;

/// Above this order the kernel works on the equilibrated problem where A is unbalanced. Not recorded.
pub const SCALED_ABOVE: usize = 16;

/// From this order on a guess is tried before the kernel: below, a basis tried at once would have to be proved. Not recorded.
pub const GUESS_FROM: usize = 17;

/// Up to this order an answer in doubt is proved or withdrawn: a proof is cheap there. Not recorded.
pub const PROVED_UP_TO: usize = 16;

/// Up to this order, and for so many index sets, exact linear programmes look for a solution. Not recorded.
pub const PROGRAMMES_UP_TO: usize = 16;

/// Up to this order every index set is tried when everything else has failed. Not recorded.
pub const ENUMERATE_UP_TO: usize = 12;

/// From this order on block pivoting goes before Lemke's method: below, a few pivots cost less than a factorisation. Not recorded.
pub const BLOCK_PIVOTING_FROM: usize = 24;

/// Up to this order the kernel's pivots cost less than the few factorisations that a symmetric A needs. Record: `families.md`.
pub const KERNEL_FIRST_UP_TO: usize = 64;

/// Above this order the portfolio shifts singular symmetric blocks: below it, that was tried before the kernel. Not recorded.
pub const SHIFT_ABOVE: usize = 64;

/// Up to this order Lemke's method follows a guess before block pivoting starts from it. Not recorded.
pub const WARM_PATH_FIRST_UP_TO: usize = 128;

/// Up to this order the kernels try a problem of a batch before the general solver does. Not recorded.
pub const LEMKE_ALONE_UP_TO: usize = 192;

/// From this order on a symmetric A that is nearly empty is factored as a sparse matrix. Not recorded.
pub const SPARSE_FROM: usize = 200;

/// Up to this order a Farkas vector is repaired by an exact solve with the rows that are tight. Not recorded.
pub const REPAIR_UP_TO: usize = 64;

/// Up to this order a path in double-doubles is worth its 20-fold cost. Not recorded.
pub const DOUBLE_DOUBLE_UP_TO: usize = 400;

/// From this order on a library factors principal blocks by Cholesky: its loops block for the second cache, too. Record: `backend.md`.
pub const LIBRARY_CHOLESKY_FROM: usize = 600;

/// Up to this order a path in double-doubles finishes from a support that is nearly right: it has few pivots. Not recorded.
pub const FINISH_IN_DOUBLE_DOUBLE_UP_TO: usize = 1000;

/// Up to this order a sparse problem is made dense where exact arithmetic or a Farkas vector needs it. Not recorded.
pub const DENSE_UP_TO: usize = 2000;
