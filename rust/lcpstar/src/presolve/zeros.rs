//! Pairs whose `z_i` is zero in every solution.

use crate::problem::Lcp;

/// Which indices remain; `None` when all do.
///
/// A row with `a_ij >= 0` for all remaining j, and `q_i > 0` or `q_i = 0 < a_ii`, has `w_i > 0` whenever `z_i > 0`:
/// so `z_i = 0` in every solution, `w_i >= 0` holds by itself, and pair i may be dropped, which may free other rows.
/// Each row remembers one negative entry and looks for the next only when that column is dropped: O(n^2) in all.
pub fn kept(lcp: &Lcp) -> Option<Vec<bool>> {
    let n = lcp.n();
    let candidate = |i: usize| lcp.q()[i] > 0.0 || (lcp.q()[i] == 0.0 && lcp.row(i)[i] > 0.0);
    let negative_from = |i: usize, j: usize| lcp.row(i)[j..].iter().position(|&a| a < 0.0).map_or(n, |k| j + k);
    if !(0..n).any(|i| candidate(i) && negative_from(i, 0) == n) {
        return None;
    }
    let mut dropped = vec![false; n];
    let mut watched: Vec<usize> = (0..n).map(|i| if candidate(i) { negative_from(i, 0) } else { 0 }).collect();
    loop {
        let mut changed = false;
        for i in (0..n).filter(|&i| candidate(i)) {
            if dropped[i] {
                continue;
            }
            while watched[i] < n && dropped[watched[i]] {
                watched[i] = negative_from(i, watched[i] + 1);
            }
            if watched[i] == n {
                dropped[i] = true;
                changed = true;
            }
        }
        if !changed {
            return Some(dropped.iter().map(|dropped| !dropped).collect());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept_of(a: &[f64], q: &[f64]) -> Option<Vec<bool>> {
        kept(&Lcp::new(q.len(), a.to_vec(), q.to_vec()).expect("valid"))
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
