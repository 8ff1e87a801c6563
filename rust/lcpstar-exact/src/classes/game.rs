//! The von Neumann value `v(A) = max over the simplex of min_i (Ax)_i`.

use super::budget::{Budget, Search};
use crate::imatrix::IMatrix;
use crate::int::Int;
use crate::lp::packing;

/// The value and optimal strategies, exact.
#[derive(Clone, Debug)]
pub struct Game {
    /// The value is `numerator / denominator`.
    pub numerator: Int,
    /// Positive.
    pub denominator: Int,
    /// `Ax >= v e`; divide by the sum of its entries.
    pub x: Vec<Int>,
    /// `A'y <= v e`; divide by the sum of its entries.
    pub y: Vec<Int>,
}

/// Solves the game of a square matrix of order n >= 1 by one linear program on `A + c`, shifted to be positive.
///
/// # Errors
/// `Stopped` by the budget.
pub fn solve(a: &IMatrix, budget: &Budget<'_>) -> Search<Game> {
    let least = a.entries().iter().min().cloned().unwrap_or_default();
    let shift = &Int::ONE - &least;
    let columns: Vec<Vec<Int>> =
        (0..a.columns()).map(|j| (0..a.rows()).map(|i| a.at(i, j) + &shift).collect()).collect();
    let (y, x, t) = packing(&columns, || budget.poll())?;
    let total = y.iter().fold(Int::ZERO, |sum, v| &sum + v);
    Ok(Game { numerator: &t - &(&shift * &total), denominator: total, x, y })
}
