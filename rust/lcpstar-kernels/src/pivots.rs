//! What a pivot must exceed, relative to the largest entry of its column: one number for either way to break ties.
//! In doubles, for equilibrated problems; other arithmetic scales it by the ratio of the rounding errors.

/// Where an order breaks ties (lexicographic, or the first hit), which may ask for any pivot: no larger than what n pivots leave of
/// zero, lest a row that must leave be passed over.
pub const ORDERED: f64 = 1e-11;

/// Where a covering vector or a cost is spread so that ties are improbable, and the largest pivot of the rows that tie is taken: a small
/// pivot is never needed, so the caution is greater.
pub const SPREAD: f64 = 1e-10;
