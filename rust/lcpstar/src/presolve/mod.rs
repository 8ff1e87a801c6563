//! What a problem does not need: pairs whose `z_i` is zero in every solution, and parts that do not talk to each other.
//!
//! Safe for every matrix: the solutions of the parts, put together, are the solutions of the whole where parts are
//! islands, and the solution of the whole where they come one after the other.

mod blocks;
mod zeros;

use crate::problem::Lcp;

/// Parts to solve one by one; every index that is in none has `z_i = 0` in every solution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// In the order in which they must be solved.
    pub parts: Vec<Part>,
}

/// A principal subproblem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its indices, increasing.
    pub indices: Vec<usize>,
    /// Whether its rows hold entries of parts before it: then its q is `q + A z` of those.
    pub follows: bool,
}

/// How to solve LCP(q, A) in parts; `None` when it is one part with all indices.
///
/// Costs O(n) when no row can be dropped and the first row and column of A have no zero, O(n^2) otherwise.
#[must_use]
pub fn plan(lcp: &Lcp) -> Option<Plan> {
    let n = lcp.n();
    let kept = zeros::kept(lcp);
    if kept.is_none() && (n < 2 || blocks::first_reaches_all(lcp)) {
        return None;
    }
    let kept = kept.unwrap_or_else(|| (0..n).collect());
    let parts = blocks::parts(lcp, &kept);
    (parts.len() > 1 || kept.len() < n).then_some(Plan { parts })
}

/// The principal subproblem on `indices`.
#[must_use]
pub fn subproblem(lcp: &Lcp, indices: &[usize], q: Vec<f64>) -> Lcp {
    Lcp::trusted(indices.len(), crate::pivoting::basis::principal_block(lcp, indices), q)
}
