//! The ratio tests of Lemke's method for one problem: which row blocks the driving variable. [CPS92, sec. 4.4]

use super::lane::{Lane, Mask};
use super::tableau::{WIDTH, at};
use crate::pivots::SPREAD;

/// Ratios within this factor of the least one are tied.
pub const TIE: f64 = 1.0 + 1e-11;

/// The row of `value + z_0 covering` that is the last to become nonnegative as z_0 grows from 0; `None` if all are. O(n).
#[inline(always)]
pub fn last_to_become_nonnegative<X: Lane>(covering: &[X], value: &[X], needed: &mut [X]) -> Option<usize> {
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
pub fn first_to_reach_zero<X: Lane>(
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
    let tolerance = -SPREAD * largest.largest();
    if rows == 1 && at(column, row) < tolerance {
        return Some(row);
    }
    best_of_tied(column, ratio, X::splat(tolerance), favoured)
}

/// The same where rows are tied or a pivot is too small.
#[inline(always)]
fn best_of_tied<X: Lane>(column: &[X], ratio: &mut [X], tolerance: X, favoured: Option<usize>) -> Option<usize> {
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

#[cfg(test)]
mod tests {
    use super::super::lane::F64x8;
    use super::super::tableau::put;
    use super::*;

    type X = F64x8<false>;

    fn padded(v: &[f64]) -> Vec<X> {
        let mut out = vec![X::splat(0.0); v.len().div_ceil(WIDTH)];
        v.iter().enumerate().for_each(|(i, &x)| put(&mut out, i, x));
        out
    }

    /// The rule as it is said.
    fn plain(column: &[f64], value: &[f64], favoured: Option<usize>) -> Option<usize> {
        let tolerance = SPREAD * column.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let ratio = |i: usize| value[i].max(0.0) / -column[i];
        let rows: Vec<usize> = (0..column.len()).filter(|&i| -column[i] > tolerance).collect();
        let least = rows.iter().map(|&i| ratio(i)).min_by(f64::total_cmp)?;
        let tied = rows.iter().copied().filter(|&i| ratio(i) <= least * TIE);
        let largest = tied.clone().map(|i| -column[i]).max_by(f64::total_cmp)?;
        favoured.filter(|row| tied.clone().any(|i| i == *row)).or_else(|| tied.clone().find(|&i| -column[i] == largest))
    }

    /// Few different numbers, so that rows are tied; pivots that are too small, alone in front or among others; nothing that blocks.
    #[test]
    fn rows_are_those_of_the_rule() {
        const COLUMN: [f64; 8] = [-1.0, -0.5, -2.0, 0.0, 0.75, -1e-11, -3e-13, 1.5];
        const VALUE: [f64; 8] = [0.0, 1.0, 2.0, 0.5, -1e-17, 1e-12, 3.0, 1.5];
        let mut random = 1_u64;
        let mut pick = |count: usize| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) as usize % count
        };
        let mut found = [0; 2];
        for k in 0..20_000 {
            let n = 1 + k % 20;
            // From three numbers to all eight.
            let kinds = 3 + pick(6);
            let column: Vec<f64> = (0..n).map(|_| COLUMN[(pick(kinds) + k) % 8]).collect();
            let value: Vec<f64> = (0..n).map(|_| VALUE[pick(8)]).collect();
            let favoured = [None, Some(pick(n))][pick(2)];
            let mut ratio = padded(&value);
            let row = first_to_reach_zero(&padded(&column), &padded(&value), &mut ratio, favoured);
            assert_eq!(row, plain(&column, &value, favoured), "{column:?}, {value:?}, {favoured:?}");
            found[usize::from(row.is_some())] += 1;
            let covering: Vec<f64> = (0..n).map(|i| 1.0 + i as f64 / 32.0).collect();
            let needed: Vec<f64> = (0..n).map(|i| (0.5 - value[i]) / covering[i]).collect();
            let last = (0..n).rev().max_by(|&i, &j| needed[i].total_cmp(&needed[j])).filter(|&i| needed[i] > 0.0);
            let shifted: Vec<f64> = value.iter().map(|v| v - 0.5).collect();
            assert_eq!(last_to_become_nonnegative(&padded(&covering), &padded(&shifted), &mut ratio), last);
        }
        assert!(found.iter().all(|&count| count > 200), "{found:?}");
    }
}
