//! The exact finish where A is symmetric and positive semidefinite: one Cholesky factorisation for each guess of the support.
//!
//! There w is the same in every solution, and any `z_beta >= 0` with `A[beta, beta] z_beta = -q_beta`, `beta = {i : w_i = 0}`,
//! is one: a linear programme. [CPS92, sec. 3.1] Cholesky with pivoting on large z finds a basis; the z of the columns that depend on it are
//! pushed to zero one by one, which ends at a vertex.

use super::basis::Block;
use crate::linalg::blocked::BlockFactor;
use crate::linalg::kernels::{self, LANES, add_combination, axpy, max_abs};
use crate::problem::Lcp;

/// A Cholesky pivot below this fraction of its diagonal entry counts as zero.
const RANK: f64 = 1e-11;
/// A sign is wrong below minus this, times `max(1, max|z|)`.
const SIGN: f64 = 1e-13;
/// A rate of change below this does not block.
const RATE: f64 = 1e-11;
/// More wrong signs than the n-th part of all: another round would not mend the guess.
const HOPELESS: usize = 8;
/// A basic value below this fraction of the largest is zero.
const ZERO: f64 = 1e-14;

/// The basic point of the guess `z_i > w_i`, moved to a vertex where the block is singular, then of the sets reached by
/// exchanging every index with the wrong sign, while their number falls: z, negative by rounding at most, and its basis. O(n^3) a
/// round: one or two factorisations.
#[must_use]
pub fn semidefinite(lcp: &Lcp, z: &[f64], w: &[f64], rounds: usize) -> Option<(Vec<f64>, Vec<usize>)> {
    let n = lcp.n();
    let mut in_beta: Vec<bool> = z.iter().zip(w).map(|(z, w)| z > w).collect();
    let (mut block, mut point, mut slack) = (Block::default(), vec![0.0; n], vec![0.0; n]);
    let mut fewest = usize::MAX;
    for _ in 0..rounds {
        let mut alpha: Vec<usize> = (0..n).filter(|&i| in_beta[i]).collect();
        let Some(rank) = block.factor_semidefinite(lcp, &mut alpha, z, RANK) else { break };
        block.point(lcp.q(), &mut point);
        if rank < alpha.len() {
            let (basis, is_new) = vertex(block.factors(), &alpha, rank, &point, z);
            alpha = basis;
            if is_new {
                if !block.factor_symmetric(lcp, &alpha, 0.0) {
                    break;
                }
                block.point(lcp.q(), &mut point);
            }
        }
        kernels::affine(lcp.q(), lcp.a(), &point, &mut slack);
        let noise = -SIGN * max_abs(&point).max(1.0);
        let mut in_alpha = vec![false; n];
        alpha.iter().for_each(|&i| in_alpha[i] = true);
        let wrong: Vec<usize> =
            (0..n).filter(|&i| if in_alpha[i] { point[i] < noise } else { slack[i] < noise }).collect();
        if wrong.is_empty() {
            block.refine(lcp, &mut point);
            alpha.sort_unstable();
            return Some((point, alpha));
        }
        if wrong.len() >= fewest.min(n / HOPELESS + 2) {
            break;
        }
        fewest = wrong.len();
        wrong.iter().for_each(|&i| in_beta[i] = !in_alpha[i]);
    }
    None
}

/// The basis of a vertex of `{z_alpha >= 0 : A[alpha, alpha] z_alpha = -q_alpha}`, from the factors of its first `rank` indices,
/// the solution with zero at the others, and a point near the face; and whether it is another than those indices.
/// O(rank (|alpha| - rank) |alpha|).
fn vertex(factor: &BlockFactor, alpha: &[usize], rank: usize, solution: &[f64], near: &[f64]) -> (Vec<usize>, bool) {
    let mut basis = alpha[..rank].to_vec();
    let mut values: Vec<f64> = basis.iter().map(|&i| solution[i]).collect();
    let noise = -SIGN * max_abs(&values).max(1.0);
    let pushed = values.iter().any(|&x| x < noise);
    if pushed {
        push(factor, &mut basis, &mut values, &alpha[rank..], near);
    }
    let least = ZERO * max_abs(&values);
    let kept: Vec<usize> = basis.into_iter().zip(&values).filter(|&(_, &x)| x > least).map(|(i, _)| i).collect();
    let is_new = pushed || kept.len() < rank;
    (kept, is_new)
}

/// Pushes the dependent columns from their values in `near` to zero, the smallest first; a basic variable that reaches zero
/// before leaves the basis for the column. `values` of the basis are those for zeros at first.
fn push(factor: &BlockFactor, basis: &mut [usize], values: &mut [f64], dependent: &[usize], near: &[f64]) {
    let rank = basis.len();
    let stride = dependent.len().next_multiple_of(LANES);
    let mut table = columns_in_basis(factor, rank, dependent.len(), stride);
    let z: Vec<f64> = dependent.iter().map(|&i| near[i]).collect();
    for (value, row) in values.iter_mut().zip(table.chunks_exact(stride)) {
        *value -= kernels::dot(&row[..z.len()], &z);
    }
    let mut order: Vec<usize> = (0..z.len()).collect();
    order.sort_by(|&i, &j| z[i].total_cmp(&z[j]));
    let mut column = vec![0.0; rank];
    let mut pivot_row = vec![0.0; stride];
    for j in order {
        column.iter_mut().zip(table.chunks_exact(stride)).for_each(|(c, row)| *c = row[j]);
        let rates = column.iter().zip(&*values).enumerate().filter(|(_, (c, _))| **c < -RATE);
        let blocking = rates.map(|(k, (c, x))| (k, x.max(0.0) / -c)).min_by(|a, b| a.1.total_cmp(&b.1));
        let step = blocking.map_or(z[j], |(_, step)| step.min(z[j]));
        axpy(step, &column, values);
        if let Some((k, _)) = blocking.filter(|&(_, step)| step < z[j]) {
            let inverse = 1.0 / column[k];
            pivot_row.iter_mut().zip(&table[k * stride..]).for_each(|(p, x)| *p = -x * inverse);
            kernels::pivot(&mut table, stride, k, j, &pivot_row);
            table[k * stride..(k + 1) * stride].iter_mut().for_each(|x| *x = -*x);
            basis[k] = dependent[j];
            values[k] = z[j] - step;
        }
    }
}

/// `A[B, B]^-1 A[B, D]` for the basis B, the first `rank` columns, and the `count` columns D after it; row by row.
fn columns_in_basis(factor: &BlockFactor, rank: usize, count: usize, stride: usize) -> Vec<f64> {
    let mut table = vec![0.0; rank * stride];
    let mut factors = Vec::with_capacity(rank);
    for k in (0..rank).rev() {
        let row = factor.row(k);
        let (above, below) = table.split_at_mut((k + 1) * stride);
        let target = &mut above[k * stride..];
        target[..count].copy_from_slice(&row[rank..rank + count]);
        factors.clear();
        factors.extend(row[k + 1..rank].iter().map(|x| -x));
        add_combination(target, &factors, below);
        let inverse = 1.0 / row[k];
        target.iter_mut().for_each(|x| *x *= inverse);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pivoting::finish::measured;

    /// `B B'` with repeated rows: rank n / 3, solved by a z with positive entries at two thirds of the indices.
    fn repeated(n: usize) -> (Lcp, Vec<f64>, Vec<f64>) {
        let number = |i: usize, k: usize| ((i * 31 + k * 17 + i * k) * 7919 % 11) as f64 / 5.0 - 1.0;
        let b = |i: usize, k: usize| number(i % (2 * n / 3), k);
        let a: Vec<f64> =
            (0..n * n).map(|ij| (0..n / 3).map(|k| b(ij / n, k) * b(ij % n, k)).sum::<f64>() / n as f64).collect();
        let z: Vec<f64> = (0..n).map(|i| if i % 3 == 0 { 0.0 } else { 1.0 + (i * 7 % 13) as f64 }).collect();
        let w: Vec<f64> = (0..n).map(|i| if i % 3 == 0 { 1.0 } else { 0.0 }).collect();
        let q = (0..n).map(|i| w[i] - a[i * n..(i + 1) * n].iter().zip(&z).map(|(a, z)| a * z).sum::<f64>()).collect();
        (Lcp::new(n, a, q).expect("valid"), z, w)
    }

    #[test]
    fn a_point_of_a_face_becomes_a_vertex() {
        for n in [9, 30, 90, 150] {
            let (lcp, z, w) = repeated(n);
            let near: Vec<f64> = z.iter().map(|z| z + 1e-5).collect();
            let slack: Vec<f64> = w.iter().map(|w| w + 1e-6).collect();
            let (z, alpha) = semidefinite(&lcp, &near, &slack, 2).expect("found");
            let residual = measured(&lcp, z.clone(), alpha.clone(), true).residual;
            assert!(residual < 1e-13, "{n}: {residual}");
            assert!(alpha.len() <= n / 3);
            assert!((0..n).all(|i| z[i] == 0.0 || alpha.binary_search(&i).is_ok()));
        }
    }

    #[test]
    fn indefinite_is_refused() {
        let lcp = Lcp::new(2, vec![1.0, 2.0, 2.0, 1.0], vec![-3.0, -3.0]).expect("valid");
        assert!(semidefinite(&lcp, &[1.0, 1.0], &[0.0, 0.0], 2).is_none());
    }
}
