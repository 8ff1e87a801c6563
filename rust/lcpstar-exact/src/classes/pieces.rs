//! SOL(q, A) as a union of polyhedra, and what a single solution looks like from nearby.

use super::budget::{Budget, Search};
use crate::cone::Cone;
use crate::imatrix::{IMatrix, complement, indices};
use crate::int::Int;
use crate::lp::{Feasibility, feasible};

/// The nonempty polyhedron `{z >= 0 : z = 0 off alpha, w = Az + q >= 0, w = 0 on alpha}`.
#[derive(Clone, Debug)]
pub struct Polyhedron {
    /// The index set.
    pub alpha: u64,
    /// Vertices `z / t`.
    pub vertices: Vec<(Vec<Int>, Int)>,
    /// Extreme directions.
    pub rays: Vec<Vec<Int>>,
}

/// All nonempty pieces of SOL(q, A): one double description per index set.
///
/// # Errors
/// `Stopped` by the budget.
pub fn pieces(a: &IMatrix, q: &[Int], budget: &Budget<'_>) -> Search<Vec<Polyhedron>> {
    let n = a.rows();
    let mut found = Vec::new();
    budget.begin(1 << n);
    for mask in 0..1u64 << n {
        budget.step()?;
        let alpha = indices(mask);
        let k = alpha.len();
        let row = |i: usize| {
            let mut row: Vec<Int> = alpha.iter().map(|&j| a.at(i, j).clone()).collect();
            row.push(q[i].clone());
            row
        };
        let mut cone = Cone::orthant(k + 1);
        alpha.iter().for_each(|&i| cone.zero(row(i)));
        indices(complement(mask, n)).into_iter().for_each(|i| cone.nonnegative(row(i)));
        let mut piece = Polyhedron { alpha: mask, vertices: Vec::new(), rays: Vec::new() };
        for mut ray in cone.rays_unless(|| budget.poll())? {
            let t = ray.pop().unwrap_or_default();
            let z = crate::imatrix::embed(&ray, &alpha, n);
            if t.is_zero() {
                piece.rays.push(z);
            } else {
                piece.vertices.push((z, t));
            }
        }
        if !piece.vertices.is_empty() {
            found.push(piece);
        }
    }
    Ok(found)
}

/// Whether a solution is isolated, given `positive` (z_i > 0) and `degenerate` (z_i = w_i = 0): no direction d != 0 has
/// `d = 0` off both, `(Ad)_i = 0` on `positive`, and `d, Ad` nonnegative and complementary on `degenerate`.
///
/// # Errors
/// `Stopped` by the budget.
pub fn is_isolated(a: &IMatrix, positive: u64, degenerate: u64, budget: &Budget<'_>) -> Search<bool> {
    let free = indices(positive);
    let ties = indices(degenerate);
    for choice in 0..1u64 << ties.len() {
        let moving: Vec<usize> = indices(choice).into_iter().map(|i| ties[i]).collect();
        let slack: Vec<usize> = ties.iter().copied().filter(|i| !moving.contains(i)).collect();
        let rows: Vec<usize> = free.iter().chain(&ties).copied().collect();
        let column = |j: usize, sign: i64| rows.iter().map(|&i| a.at(i, j) * &Int::from(sign)).collect::<Vec<_>>();
        let mut columns: Vec<Vec<Int>> = Vec::new();
        free.iter().for_each(|&j| columns.extend([column(j, 1), column(j, -1)]));
        moving.iter().for_each(|&j| columns.push(column(j, 1)));
        slack.iter().for_each(|&s| columns.push(rows.iter().map(|&i| Int::from(-i64::from(i == s))).collect()));
        // One normalisation per variable and sign: d_j = 1 or d_j = -1.
        let variables = 2 * free.len() + moving.len();
        for normal in 0..variables {
            budget.poll()?;
            let opposite = if normal < 2 * free.len() { Some(normal ^ 1) } else { None };
            let with_norm: Vec<Vec<Int>> = columns
                .iter()
                .enumerate()
                .map(|(c, column)| {
                    let mut column = column.clone();
                    column.push(Int::from(if c == normal { 1 } else { -i64::from(opposite == Some(c)) }));
                    column
                })
                .collect();
            let mut b = vec![Int::ZERO; rows.len()];
            b.push(Int::ONE);
            if let Feasibility::Point(..) = feasible(&with_norm, &b) {
                return Ok(false);
            }
        }
    }
    Ok(true)
}
