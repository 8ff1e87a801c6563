//! SOL(0, A), the cone-like set `x >= 0, Ax >= 0, x'Ax = 0`: R0, R, the star conditions and Garcia's L2.

use super::budget::{Budget, Search};
use crate::cone::Cone;
use crate::elimination::reduce;
use crate::imatrix::{IMatrix, by_size, complement, embed, indices};
use crate::int::Int;
use crate::lp::{Feasibility, feasible};
use std::ops::ControlFlow;

/// Visits rays of SOL(0, A), smaller supports first. On the piece of support `alpha` the set is the cone
/// `x_alpha >= 0, A[alpha, alpha] x = 0, A[rest, alpha] x >= 0`; its extreme rays with smaller support belong to
/// smaller pieces, so those with full support, over all alpha, generate every piece.
///
/// # Errors
/// `Stopped` by the budget.
pub fn visit<T>(
    a: &IMatrix,
    budget: &Budget<'_>,
    mut ray: impl FnMut(Vec<Int>) -> ControlFlow<T>,
) -> Search<Option<T>> {
    let n = a.rows();
    budget.begin((1u64 << n.min(63)) - 1);
    for mask in by_size(n) {
        budget.step()?;
        for x in piece(a, mask, budget)? {
            if let ControlFlow::Break(found) = ray(x) {
                return Ok(Some(found));
            }
        }
    }
    Ok(None)
}

/// Rays of the piece of `mask` whose support is all of it.
fn piece(a: &IMatrix, mask: u64, budget: &Budget<'_>) -> Search<Vec<Vec<Int>>> {
    let (n, alpha, rest) = (a.rows(), indices(mask), indices(complement(mask, a.rows())));
    let k = alpha.len();
    let mut basis = reduce(a.principal(&alpha), k).null_space(k);
    let outside = |x: &[Int]| a.block(&rest, &alpha).times(x).iter().all(|v| v.sign() >= 0);
    let rays = match basis.len() {
        0 => return Ok(Vec::new()),
        1 => {
            let mut x = basis.swap_remove(0);
            if x[0].sign() < 0 {
                x.iter_mut().for_each(|v| *v = -&*v);
            }
            if outside(&x) { vec![x] } else { Vec::new() }
        }
        _ => {
            let mut cone = Cone::orthant(k);
            for row in &alpha {
                cone.zero(a.block(&[*row], &alpha).entries().to_vec());
            }
            for row in &rest {
                cone.nonnegative(a.block(&[*row], &alpha).entries().to_vec());
            }
            cone.rays_unless(|| budget.poll())?
        }
    };
    Ok(rays.into_iter().filter(|x| x.iter().all(|v| v.sign() > 0)).map(|x| embed(&x, &alpha, n)).collect())
}

/// A ray of SOL(0, A), if A is not in R0.
///
/// # Errors
/// `Stopped` by the budget.
pub fn nonzero_solution(a: &IMatrix, budget: &Budget<'_>) -> Search<Option<Vec<Int>>> {
    visit(a, budget, ControlFlow::Break)
}

/// `(z, t)`, `z != 0`, `t >= 0`, with z in SOL(t e, A), if A is not in R. Zero `t` first.
///
/// # Errors
/// `Stopped` by the budget.
pub fn regularity_violation(a: &IMatrix, budget: &Budget<'_>) -> Search<Option<(Vec<Int>, Int)>> {
    if let Some(x) = nonzero_solution(a, budget)? {
        return Ok(Some((x, Int::ZERO)));
    }
    let n = a.rows();
    for mask in by_size(n) {
        budget.poll()?;
        let (alpha, rest) = (indices(mask), indices(complement(mask, n)));
        let k = alpha.len();
        let mut cone = Cone::orthant(k + 1);
        let row = |i: usize| {
            let mut row: Vec<Int> = alpha.iter().map(|&j| a.at(i, j).clone()).collect();
            row.push(Int::ONE);
            row
        };
        alpha.iter().for_each(|&i| cone.zero(row(i)));
        rest.iter().for_each(|&i| cone.nonnegative(row(i)));
        if let Some(ray) = cone.rays_unless(|| budget.poll())?.into_iter().next() {
            return Ok(Some((embed(&ray[..k], &alpha, n), ray[k].clone())));
        }
    }
    Ok(None)
}

/// Which condition on the rays of SOL(0, A) is asked for. All are linear on each piece, so rays suffice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Star {
    /// `A'x <= 0`: with E0 the class E0s, with C0 the class C0*.
    Plain,
    /// And `(A'x)_i != 0` only where `(Ax)_i != 0`: with E0 the class tE0s.
    Tilde,
}

/// A ray of SOL(0, A) that breaks the condition, and the index where it does.
///
/// # Errors
/// `Stopped` by the budget.
pub fn star_violation(a: &IMatrix, star: Star, budget: &Budget<'_>) -> Search<Option<(Vec<Int>, usize)>> {
    visit(a, budget, |x| {
        let (w, y) = (a.times(&x), a.transpose_times(&x));
        let bad =
            (0..a.rows()).find(|&i| y[i].sign() > 0 || (star == Star::Tilde && !y[i].is_zero() && w[i].is_zero()));
        match bad {
            Some(i) => ControlFlow::Break((x, i)),
            None => ControlFlow::Continue(()),
        }
    })
}

/// A ray x of SOL(0, A) for which no `0 != y >= 0` exists with supp y in supp x, `A'y <= 0` and `(A'y)_i = 0` where
/// `(Ax)_i = 0`; and Ville's alternative: u, `u_i >= 0` where `(Ax)_i > 0`, with `(Au)_j > 0` on the support of x.
///
/// # Errors
/// `Stopped` by the budget.
pub fn garcia_violation(a: &IMatrix, budget: &Budget<'_>) -> Search<Option<(Vec<Int>, Vec<Int>)>> {
    let n = a.rows();
    visit(a, budget, |x| {
        let w = a.times(&x);
        let mut columns: Vec<Vec<Int>> = Vec::new();
        for j in (0..n).filter(|&j| x[j].sign() > 0) {
            let mut column = a.row(j).to_vec();
            column.push(Int::ONE);
            columns.push(column);
        }
        for i in (0..n).filter(|&i| w[i].sign() > 0) {
            columns.push((0..=n).map(|r| Int::from(i64::from(r == i))).collect());
        }
        let b: Vec<Int> = (0..=n).map(|r| Int::from(i64::from(r == n))).collect();
        match feasible(&columns, &b) {
            Feasibility::Point(..) => ControlFlow::Continue(()),
            Feasibility::Farkas(mut u) => {
                u.truncate(n);
                ControlFlow::Break((x, u))
            }
        }
    })
}
