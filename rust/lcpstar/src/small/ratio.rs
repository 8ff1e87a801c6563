//! The ratio tests of Lemke's method for one problem: which row blocks the driving variable. [CPS92, sec. 4.4]

use super::lane::{Lane, Mask};
use super::tableau::{WIDTH, at};

/// Smallest pivot relative to the largest entry of the driving column.
pub(crate) const PIVOT_TOLERANCE: f64 = 1e-10;

/// Ratios within this factor of the least one are tied.
pub(crate) const TIE: f64 = 1.0 + 1e-11;

/// The row of `value + z_0 covering` that is the last to become nonnegative as z_0 grows from 0; `None` if all are. O(n).
#[inline(always)]
pub fn last_to_become_nonnegative<X: Lane<Number = f64>>(
    covering: &[X],
    value: &[X],
    needed: &mut [X],
) -> Option<usize> {
    let mut largest = X::splat(0.0);
    for ((needed, v), d) in needed.iter_mut().zip(value).zip(covering) {
        *needed = v.neg().div(*d);
        largest = needed.max(largest);
    }
    let largest = largest.largest();
    if largest > 0.0 { first_at_least(needed, largest) } else { None }
}

/// The row of the basic variable that reaches zero first as the driving one grows, which changes them by `column`: `favoured` if
/// it is among them, else that of the largest pivot. `None` if nothing blocks. O(n).
#[inline(always)]
pub fn first_to_reach_zero<X: Lane<Number = f64>>(
    column: &[X],
    value: &[X],
    ratio: &mut [X],
    favoured: Option<usize>,
) -> Option<usize> {
    let ratio = &mut ratio[..column.len()];
    let (zero, infinity) = (X::splat(0.0), X::splat(f64::INFINITY));
    let (mut least, mut largest) = (infinity, zero);
    for ((ratio, v), c) in ratio.iter_mut().zip(value).zip(column) {
        *ratio = v.max(zero).div(c.neg()).or_else(c.lt(zero), infinity);
        least = ratio.min(least);
        largest = c.abs().max(largest);
    }
    // Nearly always one row, and its pivot is large enough: found before it is known what large enough is.
    let least = least.smallest();
    let bound = X::splat(least * TIE);
    let (mut row, mut rows) = (0, 0);
    for (block, ratio) in ratio.iter().enumerate() {
        let tied = ratio.le(bound).bits();
        row = if tied == 0 { row } else { block * WIDTH + tied.trailing_zeros() as usize };
        rows += u32::from(tied != 0) + u32::from(tied & tied.wrapping_sub(1) != 0);
    }
    let tolerance = -PIVOT_TOLERANCE * largest.largest();
    if rows == 1 && at(column, row) < tolerance {
        return Some(row);
    }
    best_of_tied(column, ratio, X::splat(tolerance), favoured)
}

/// The same where rows are tied or a pivot is too small.
#[inline(always)]
fn best_of_tied<X: Lane<Number = f64>>(
    column: &[X],
    ratio: &mut [X],
    tolerance: X,
    favoured: Option<usize>,
) -> Option<usize> {
    let (zero, infinity) = (X::splat(0.0), X::splat(f64::INFINITY));
    let mut least = infinity;
    for (ratio, c) in ratio.iter_mut().zip(column) {
        *ratio = ratio.or_else(c.lt(tolerance), infinity);
        least = ratio.min(least);
    }
    let least = least.smallest();
    if least == f64::INFINITY {
        return None;
    }
    if let Some(row) = favoured
        && at(ratio, row) <= least * TIE
    {
        return Some(row);
    }
    let bound = X::splat(least * TIE);
    let mut largest = zero;
    for (ratio, c) in ratio.iter_mut().zip(column) {
        // From now on the pivots of the tied rows.
        *ratio = c.neg().only(ratio.le(bound));
        largest = ratio.max(largest);
    }
    first_at_least(ratio, largest.largest())
}

/// The first number of a padded vector that is not below `bound`. A loop, since closures are not compiled for the instruction set
/// of their caller.
#[inline(always)]
fn first_at_least<X: Lane>(v: &[X], bound: f64) -> Option<usize> {
    for (block, x) in v.iter().enumerate() {
        let rows = X::splat(bound).le(*x).bits();
        if rows != 0 {
            return Some(block * WIDTH + rows.trailing_zeros() as usize);
        }
    }
    None
}
