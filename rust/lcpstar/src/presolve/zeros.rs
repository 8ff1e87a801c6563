//! Pairs whose `z_i` is zero in every solution.

use super::pattern::{Pattern, Set, next_common};
use crate::problem::Lcp;

/// Whether some row that could be dropped has no negative entry. O(n) where rows show one early.
pub fn may_drop(lcp: &Lcp) -> bool {
    (0..lcp.n()).any(|i| is_candidate(lcp, i) && lcp.row(i).iter().all(|&a| a >= 0.0))
}

/// Whether `w_i > 0` where `z_i > 0` and the other terms of row i are not negative.
fn is_candidate(lcp: &Lcp, i: usize) -> bool {
    lcp.q()[i] > 0.0 || (lcp.q()[i] == 0.0 && lcp.row(i)[i] > 0.0)
}

/// Which indices remain; `None` when all do.
///
/// A row with `a_ij >= 0` for all remaining j, and `q_i > 0` or `q_i = 0 < a_ii`, has `w_i > 0` whenever `z_i > 0`:
/// so `z_i = 0` in every solution, `w_i >= 0` holds by itself, and pair i may be dropped, which may free other rows.
/// Each row remembers one negative entry and looks for the next only when that column is dropped: O(n^2 / 64) in all.
pub fn kept(lcp: &Lcp, pattern: &Pattern) -> Option<Set> {
    let n = lcp.n();
    let mut kept = pattern.set_of(0..n);
    let mut watched: Vec<(usize, Option<usize>)> =
        (0..n).filter(|&i| is_candidate(lcp, i)).map(|i| (i, next_common(pattern.negative(i), &kept.0, 0))).collect();
    if watched.iter().all(|(_, negative)| negative.is_some()) {
        return None;
    }
    loop {
        let before = watched.len();
        watched.retain_mut(|(i, negative)| {
            if let Some(j) = *negative {
                *negative = next_common(pattern.negative(*i), &kept.0, j);
            }
            if negative.is_none() {
                kept.remove(*i);
            }
            negative.is_some()
        });
        if watched.len() == before {
            return Some(kept);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept_of(a: &[f64], q: &[f64]) -> Option<Vec<bool>> {
        let lcp = Lcp::new(q.len(), a.to_vec(), q.to_vec()).expect("valid");
        kept(&lcp, &Pattern::of(&lcp)).map(|kept| (0..q.len()).map(|i| kept.has(i)).collect())
    }

    #[test]
    fn one_drop_frees_another() {
        // Row 2 is nonnegative; row 1 has its only negative entry in column 2.
        let a = [1.0, 0.0, 0.0, 1.0, 1.0, -1.0, 2.0, 3.0, 0.0];
        assert_eq!(kept_of(&a, &[-1.0, 1.0, 1.0]), Some(vec![true, false, false]));
    }

    #[test]
    fn a_zero_of_q_needs_a_positive_diagonal() {
        // q_1 = 0 = a_11: z_1 > 0 may be what row 0 needs.
        assert_eq!(kept_of(&[0.0, 1.0, 0.0, 0.0], &[-1.0, 0.0]), None);
        assert_eq!(kept_of(&[1.0, 1.0, 0.0, 1.0], &[-1.0, 0.0]), Some(vec![true, false]));
    }
}
