//! All legitimate principal pivot transforms of a matrix: C0f, E0f, almost C0f, exact order k.

use super::budget::{Budget, Search};
use crate::elimination::principal_pivot_transform;
use crate::imatrix::{IMatrix, by_size, indices};

/// A positive multiple of every legitimate transform with its index set; A itself, on the empty set, comes first.
///
/// # Errors
/// `Stopped` by the budget.
pub fn legitimate(a: &IMatrix, budget: &Budget<'_>) -> Search<Vec<(u64, IMatrix)>> {
    let mut all = vec![(0, a.clone())];
    for mask in by_size(a.rows()) {
        budget.poll()?;
        if let Some((m, _)) = principal_pivot_transform(a, &indices(mask)) {
            all.push((mask, m.primitive()));
        }
    }
    Ok(all)
}
