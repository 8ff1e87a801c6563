//! What a problem does not need: pairs whose `z_i` is zero in every solution, and parts that do not talk to each other.
//!
//! Safe for every matrix: the solutions of the parts, put together, are the solutions of the whole where parts are
//! islands, and the solution of the whole where they come one after the other.

mod blocks;
mod connected;
mod pattern;
mod zeros;

use crate::cutovers::WHOLE_UP_TO;
use crate::problem::Lcp;
pub use blocks::Part;
use pattern::Pattern;

/// Parts to solve one by one; every index that is in none has `z_i = 0` in every solution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// In the order in which they must be solved.
    pub parts: Vec<Part>,
}

/// How to solve LCP(q, A) in parts; `None` when it is one part with all indices, or of order up to 16.
///
/// Costs O(n) where every row has a negative entry early or `q_i < 0`, and the first row and column of A have no zero; O(n^2)
/// otherwise. What is done to an island depends on its own rows alone.
#[must_use]
pub fn plan(lcp: &Lcp) -> Option<Plan> {
    let n = lcp.n();
    if n <= WHOLE_UP_TO {
        return None;
    }
    let full = blocks::first_reaches_all(lcp);
    if full && !zeros::may_drop(lcp) {
        return None;
    }
    let mut pattern = Pattern::of(lcp);
    let kept = zeros::kept(lcp, &pattern);
    if kept.is_none() && full {
        return None;
    }
    pattern.transpose();
    let mut parts = Vec::new();
    for island in blocks::islands(&pattern, &pattern.set_of(0..n)) {
        if island.len() <= WHOLE_UP_TO {
            parts.push(Part { indices: island, follows: false });
            continue;
        }
        let Some(kept) = &kept else {
            parts.extend(blocks::parts(lcp, &pattern, &island));
            continue;
        };
        let left = pattern.set_of(island.into_iter().filter(|&i| kept.has(i)));
        for island in blocks::islands(&pattern, &left) {
            parts.extend(blocks::parts(lcp, &pattern, &island));
        }
    }
    (parts.len() != 1 || parts[0].indices.len() < n).then_some(Plan { parts })
}

/// The principal subproblem on `indices`.
#[must_use]
pub fn subproblem(lcp: &Lcp, indices: &[usize], q: Vec<f64>) -> Lcp {
    Lcp::trusted(indices.len(), crate::pivoting::basis::principal_block(lcp, indices), q)
}
