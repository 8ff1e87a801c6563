//! The exact finish: from a point near a solution to a complementary basis and a residual at rounding level.
//!
//! The support is guessed from `z_i > w_i`; the point is then solved for, projected, or moved along its face to a vertex. For
//! symmetric A that is tried first from one Cholesky factorisation, see [`semidefinite`](super::semidefinite).
//! Nothing is believed here: each candidate is measured on the data, and only a better one replaces the point.

use crate::linalg::backend::RowSpace;
use crate::linalg::kernels::{axpy, dot, max_abs};
use crate::pivoting::basis::basic_point;
use crate::pivoting::semidefinite::semidefinite;
use crate::problem::Lcp;
use crate::residual::{equilibrated_residual, slack};
use lcpstar_kernels::pivots::ORDERED;

/// A finished point of the equilibrated problem.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Nonnegative.
    pub z: Vec<f64>,
    /// Indices with `w_i = 0`: a complementary basis when `is_basis`, otherwise the support of z.
    pub alpha: Vec<usize>,
    /// Whether `A[alpha, alpha]` is nonsingular and reproduces z.
    pub is_basis: bool,
    /// The larger of its equilibrated residual and its [`excess`].
    pub residual: f64,
}

/// Residual at rounding level: the finish stops looking for better.
pub(super) const ROUNDING: f64 = 1e-14;
/// A z larger than q by the inverse of this belongs to a block that is singular to rounding: the rounding of `A z` hides q, and
/// a problem without a solution seems to have one.
const HIDES_Q: f64 = 1e-12;
/// Block exchanges of wrong signs at most.
const EXCHANGES: usize = 8;
/// Ranks of the projection: entries of R below these fractions count as zero. From the likely to the cautious.
const RANK_TOLERANCES: [f64; 4] = [1e-12, 1e-10, 1e-8, 1e-14];
/// An index with both `z_i` and `w_i` below this stays out of the support but keeps its equation.
const DEGENERATE: f64 = 1e-7;

/// Tries to finish the point `(z, w)` of an equilibrated problem; the best candidate, whatever its residual.
/// O(n^3); a few factorisations.
#[must_use]
pub fn finish(lcp: &Lcp, z: &[f64], w: &[f64], symmetric: bool) -> Option<Finished> {
    let mut best = if symmetric { by_cholesky(lcp, z, w, EXCHANGES) } else { None };
    if best.as_ref().is_some_and(|found| found.residual <= ROUNDING) {
        return best;
    }
    let guess: Vec<usize> = (0..lcp.n()).filter(|&i| z[i] > w[i]).collect();
    let basic = exchange(lcp, guess.clone(), EXCHANGES);
    if basic.as_ref().is_some_and(|found| found.residual <= ROUNDING) {
        return basic;
    }
    best = best.into_iter().chain(basic).min_by(|a, b| a.residual.total_cmp(&b.residual));
    let better = |candidate: &Finished, best: &Option<Finished>| {
        best.as_ref().is_none_or(|best| candidate.residual < best.residual)
    };
    for tolerance in RANK_TOLERANCES {
        let Some(face) = Face::project(lcp, z, &guess, tolerance) else { continue };
        if face.residual > 1e-9 {
            continue;
        }
        let vertex = face.clone().vertex(lcp, w, tolerance);
        for candidate in [vertex, Some(face)].into_iter().flatten() {
            if better(&candidate, &best) {
                best = Some(candidate);
            }
        }
        if best.as_ref().is_some_and(|found| found.residual <= ROUNDING) {
            break;
        }
    }
    best
}

/// Only the guess and one exchange: O(n^3), two factorisations of the order of the support. `Some` when that is a solution
/// to rounding.
#[must_use]
pub fn finish_quickly(lcp: &Lcp, z: &[f64], w: &[f64], symmetric: bool) -> Option<Finished> {
    let found = if symmetric {
        by_cholesky(lcp, z, w, 2)
    } else {
        exchange(lcp, (0..lcp.n()).filter(|&i| z[i] > w[i]).collect(), 2)
    };
    found.filter(|found| found.residual <= ROUNDING)
}

/// Measured, see [`semidefinite`].
fn by_cholesky(lcp: &Lcp, z: &[f64], w: &[f64], rounds: usize) -> Option<Finished> {
    semidefinite(lcp, z, w, rounds).map(|(z, alpha)| measured(lcp, z, alpha, true))
}

/// The basic point of `alpha`, then of the sets reached by exchanging every index with the wrong sign, while their
/// number falls.
fn exchange(lcp: &Lcp, mut alpha: Vec<usize>, rounds: usize) -> Option<Finished> {
    let mut best: Option<Finished> = None;
    let mut fewest = usize::MAX;
    for _ in 0..rounds {
        let Some(z) = basic_point(lcp, &alpha) else { break };
        let w = slack(lcp, &z).0;
        let candidate = measured(lcp, z.clone(), alpha.clone(), true);
        if best.as_ref().is_none_or(|best| candidate.residual < best.residual) {
            best = Some(candidate);
        }
        let mut inside = vec![false; lcp.n()];
        alpha.iter().for_each(|&i| inside[i] = true);
        let wrong: Vec<usize> = (0..lcp.n()).filter(|&i| if inside[i] { z[i] < 0.0 } else { w[i] < 0.0 }).collect();
        if wrong.is_empty() || wrong.len() >= fewest || best.as_ref().is_some_and(|b| b.residual <= ROUNDING) {
            break;
        }
        fewest = wrong.len();
        wrong.iter().for_each(|&i| inside[i] = !inside[i]);
        alpha = (0..lcp.n()).filter(|&i| inside[i]).collect();
    }
    best
}

pub(super) fn measured(lcp: &Lcp, mut z: Vec<f64>, alpha: Vec<usize>, is_basis: bool) -> Finished {
    z.iter_mut().for_each(|x| *x = x.max(0.0));
    let (w, magnitude) = slack(lcp, &z);
    let residual = residual(lcp.q(), &z, &w, &magnitude);
    Finished { z, alpha, is_basis, residual }
}

/// The larger of the equilibrated residual and the [`excess`]; infinite where z says nothing about q.
#[must_use]
pub fn residual(q: &[f64], z: &[f64], w: &[f64], magnitude: &[f64]) -> f64 {
    let residual = equilibrated_residual(z, w).max(excess(z, w, magnitude));
    let is_lost = residual.is_nan() || HIDES_Q * max_abs(z) > max_abs(q);
    if is_lost { f64::INFINITY } else { residual }
}

/// `max_i |min(z_i, w_i)|` beyond the rounding `8 eps (|A||z| + |q|)_i` of its row: unlike the equilibrated residual it
/// is not divided by `max|z|`, so that a huge z cannot hide an error.
#[must_use]
pub fn excess(z: &[f64], w: &[f64], magnitude: &[f64]) -> f64 {
    let beyond = |((&z, &w), &m): ((&f64, &f64), &f64)| z.min(w).abs() - 8.0 * f64::EPSILON * m;
    z.iter().zip(w).zip(magnitude).map(beyond).fold(0.0, f64::max)
}

/// A point with the support `alpha` and `w_alpha = 0`.
type Face = Finished;

impl Face {
    /// The point nearest to `z` with `z_i = 0` off `alpha` and `(A z + q)_alpha = 0`.
    fn project(lcp: &Lcp, z: &[f64], alpha: &[usize], tolerance: f64) -> Option<Self> {
        let block = crate::pivoting::basis::principal_block(lcp, alpha);
        let space = RowSpace::new(alpha.len(), alpha.len(), &block, tolerance);
        Some(corrected(lcp, z, alpha, alpha, &space))
    }

    /// Moves along the face until the columns of its support are independent: a vertex of the solution set.
    ///
    /// The moves keep `w = 0` on the rows where it is zero and stop where the next `z_i` or `w_i` reaches zero.
    fn vertex(self, lcp: &Lcp, near_w: &[f64], tolerance: f64) -> Option<Finished> {
        let n = lcp.n();
        let columns: Vec<usize> = (0..n).filter(|&i| self.z[i] > 0.0).collect();
        let mut w = slack(lcp, &self.z).0;
        let is_row = |i: usize| self.alpha.contains(&i) || (near_w[i] < DEGENERATE && w[i].abs() < DEGENERATE);
        let rows: Vec<usize> = (0..n).filter(|&i| is_row(i)).collect();
        let space = RowSpace::new(rows.len(), columns.len(), &gather(lcp, &rows, &columns), tolerance);
        let null = space.null_space();
        if null.is_empty() {
            return self.with_basis(lcp, &columns, &rows, tolerance);
        }
        let others: Vec<usize> = (0..n).filter(|i| rows.binary_search(i).is_err()).collect();
        // Each move carries its change of z on the support and of w on the other rows.
        let mut moves: Vec<Vec<f64>> = null
            .into_iter()
            .map(|mut v| {
                let changes: Vec<f64> =
                    others.iter().map(|&i| columns.iter().zip(&v).map(|(&j, v)| lcp.row(i)[j] * v).sum()).collect();
                v.extend(changes);
                v
            })
            .collect();
        let mut values: Vec<f64> = columns.iter().map(|&i| self.z[i]).chain(others.iter().map(|&i| w[i])).collect();
        while let Some(v) = moves.pop() {
            let Some((hit, step)) = first_hit(&values, &v) else { continue };
            axpy(step, &v, &mut values);
            values[hit] = 0.0;
            eliminate(&mut moves, &v, hit);
        }
        let mut z = vec![0.0; n];
        for (&i, &x) in columns.iter().zip(&values) {
            z[i] = x.max(0.0);
        }
        w.fill(0.0);
        for (&i, &x) in others.iter().zip(&values[columns.len()..]) {
            w[i] = x;
        }
        let support: Vec<usize> = (0..n).filter(|&i| z[i] > 0.0).collect();
        let rows: Vec<usize> = (0..n).filter(|&i| w[i] == 0.0).collect();
        let space = RowSpace::new(rows.len(), support.len(), &gather(lcp, &rows, &support), tolerance);
        corrected(lcp, &z, &support, &rows, &space).with_basis(lcp, &support, &rows, tolerance)
    }

    /// Completes the independent columns of the support to a nonsingular principal block with rows where `w = 0`.
    fn with_basis(self, lcp: &Lcp, support: &[usize], rows: &[usize], tolerance: f64) -> Option<Finished> {
        let space = RowSpace::new(rows.len(), support.len(), &gather(lcp, rows, support), tolerance);
        let mut alpha: Vec<usize> =
            space.spanning_rows().iter().map(|&k| rows[k]).chain(support.iter().copied()).collect();
        alpha.sort_unstable();
        alpha.dedup();
        for alpha in [support.to_vec(), alpha] {
            if let Some(found) =
                exchange(lcp, alpha, EXCHANGES).filter(|found| found.residual <= self.residual.max(ROUNDING))
            {
                return Some(found);
            }
        }
        Some(self)
    }
}

/// The entries of A in the given rows and columns, row-major.
fn gather(lcp: &Lcp, rows: &[usize], columns: &[usize]) -> Vec<f64> {
    rows.iter().flat_map(|&i| columns.iter().map(move |&j| lcp.row(i)[j])).collect()
}

/// `z` on its support, corrected twice by the shortest solution of `(A z + q)_rows = 0`.
fn corrected(lcp: &Lcp, z: &[f64], support: &[usize], rows: &[usize], space: &RowSpace) -> Finished {
    let mut point = vec![0.0; lcp.n()];
    support.iter().for_each(|&i| point[i] = z[i]);
    for _ in 0..2 {
        let w = slack(lcp, &point).0;
        let negated: Vec<f64> = rows.iter().map(|&i| -w[i]).collect();
        for (&i, d) in support.iter().zip(space.shortest_solution(&negated)) {
            point[i] += d;
        }
    }
    measured(lcp, point, support.to_vec(), false)
}

/// The entry that reaches zero first along `v` or `-v`, and the signed step; `None` when neither way is blocked.
fn first_hit(values: &[f64], v: &[f64]) -> Option<(usize, f64)> {
    let size = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let mut hit: Option<(usize, f64)> = None;
    for (i, (&x, &d)) in values.iter().zip(v).enumerate() {
        if d.abs() > ORDERED * size {
            let step = -x.max(0.0) / d;
            if hit.is_none_or(|(_, best)| step.abs() < best.abs()) {
                hit = Some((i, step));
            }
        }
    }
    // The nearest zero over both directions is the first hit in its own direction.
    hit
}

/// Makes entry `hit` of every move zero with the help of `v`, the move just made.
fn eliminate(moves: &mut [Vec<f64>], v: &[f64], hit: usize) {
    for m in moves {
        let factor = -m[hit] / v[hit];
        axpy(factor, v, m);
        m[hit] = 0.0;
        let size = dot(m, m).sqrt();
        if size > 0.0 {
            m.iter_mut().for_each(|x| *x /= size);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lcp(a: &[f64], q: &[f64]) -> Lcp {
        Lcp::new(q.len(), a.to_vec(), q.to_vec()).expect("finite")
    }

    #[test]
    fn nearby_point_becomes_the_basis() {
        let problem = lcp(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0]);
        let found = finish(&problem, &[1.33, 2.34], &[1e-3, 1e-3], true).expect("finished");
        assert_eq!((found.alpha, found.is_basis), (vec![0, 1], true));
        assert!(found.residual <= ROUNDING);
    }

    #[test]
    fn singular_block_ends_at_a_vertex() {
        // z_1 + z_2 + z_3 = 1: the analytic centre is no vertex.
        let problem = lcp(&[1.0; 9], &[-1.0; 3]);
        for symmetric in [true, false] {
            let found = finish(&problem, &[0.3334, 0.3332, 0.3335], &[1e-6; 3], symmetric).expect("finished");
            assert!(found.residual <= ROUNDING && found.is_basis, "{found:?}");
            assert_eq!(found.alpha.len(), 1);
        }
    }

    #[test]
    fn wrong_guess_is_repaired_by_exchanges() {
        let problem = lcp(&[2.0, 1.0, 1.0, 2.0], &[-5.0, 6.0]);
        let found = finish(&problem, &[2.0, 0.3], &[0.1, 0.2], true).expect("finished");
        assert_eq!((found.alpha, found.is_basis), (vec![0], true));
    }
}
