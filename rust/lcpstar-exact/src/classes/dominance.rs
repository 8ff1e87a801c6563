//! Polynomial tests that settle P and P0 without a search.
//!
//! Principal minors of `A D`, D a positive diagonal, have the signs of those of A. So A is P (P0) when some `A D` is
//! positive (semi)definite, or diagonally dominant with a positive diagonal [CPS92, sec. 3.3].

use super::budget::{Budget, Search};
use super::definite::negative_direction;
use crate::imatrix::IMatrix;
use crate::int::Int;

/// Whether a test shows that A is P (`strict`) or P0.
///
/// # Errors
/// `Stopped` by the budget.
pub fn is_known(a: &IMatrix, strict: bool, budget: &Budget<'_>) -> Search<bool> {
    if is_dominant(a) || is_dominant(&a.transpose()) {
        return Ok(true);
    }
    let ones = vec![Int::ONE; a.rows()];
    for d in [Some(ones), balance_along_tree(a), Some(balance_in_the_mean(a))].into_iter().flatten() {
        let scaled = IMatrix::from_fn(a.rows(), a.rows(), |i, j| a.at(i, j) * &d[j]);
        if negative_direction(&scaled.symmetric_part(), strict, budget)?.is_none() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// `a_ii > sum of |a_ij|, j != i`.
fn is_dominant(a: &IMatrix) -> bool {
    (0..a.rows()).all(|i| {
        let off = (0..a.rows()).filter(|&j| j != i).fold(Int::ZERO, |sum, j| &sum + &a.at(i, j).abs());
        (a.at(i, i) - &off).sign() > 0
    })
}

/// `d` with `|a_ij| d_j = |a_ji| d_i` along a spanning forest of the pairs with both entries nonzero: exact when A is a
/// column-scaled skew-symmetric or symmetric matrix off the diagonal. `None` when the numbers grow out of hand.
fn balance_along_tree(a: &IMatrix) -> Option<Vec<Int>> {
    let n = a.rows();
    let mut d: Vec<Option<(Int, Int)>> = vec![None; n];
    for root in 0..n {
        if d[root].is_some() {
            continue;
        }
        d[root] = Some((Int::ONE, Int::ONE));
        let mut todo = vec![root];
        while let Some(i) = todo.pop() {
            let (p, q) = d[i].clone()?;
            for j in 0..n {
                if d[j].is_none() && !a.at(i, j).is_zero() && !a.at(j, i).is_zero() {
                    let (p, q) = (&p * &a.at(j, i).abs(), &q * &a.at(i, j).abs());
                    let g = p.gcd(&q);
                    d[j] = Some((p.div_exact(&g), q.div_exact(&g)));
                    todo.push(j);
                }
            }
        }
    }
    let fractions: Vec<(Int, Int)> = d.into_iter().collect::<Option<_>>()?;
    let common = fractions.iter().fold(Int::ONE, |lcm, (_, q)| (&lcm * q).div_exact(&lcm.gcd(q)));
    matches!(common, Int::Small(_)).then(|| fractions.iter().map(|(p, q)| p * &common.div_exact(q)).collect())
}

/// As [`balance_along_tree`] in the geometric mean over all pairs, rounded to integers.
fn balance_in_the_mean(a: &IMatrix) -> Vec<Int> {
    const SWEEPS: usize = 40;
    const RESOLUTION: f64 = 1_048_576.0;
    let n = a.rows();
    let size: Vec<f64> = a.entries().iter().map(|x| x.to_f64().abs()).collect();
    let mut logs = vec![0.0_f64; n];
    for _ in 0..SWEEPS {
        for j in 0..n {
            let wanted: Vec<f64> = (0..n)
                .filter(|&i| i != j && size[i * n + j] > 0.0 && size[j * n + i] > 0.0)
                .map(|i| logs[i] + (size[j * n + i] / size[i * n + j]).ln())
                .collect();
            if !wanted.is_empty() {
                logs[j] = wanted.iter().sum::<f64>() / wanted.len() as f64;
            }
        }
    }
    let top = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    logs.iter().map(|l| Int::from(((l - top).exp() * RESOLUTION).round().max(1.0) as i64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(a: &IMatrix, strict: bool) -> bool {
        is_known(a, strict, &Budget::unlimited()).expect("no limit")
    }

    #[test]
    fn scaled_skew_plus_diagonal_is_p_and_scaled_skew_is_p0() {
        // ((0 1 -2; -1 0 3; 2 -3 0) + D) E with E = diag(1, 5, 7).
        let skew = IMatrix::from_rows(&[[0, 5, -14], [-1, 0, 21], [2, -15, 0]]);
        assert!(known(&skew, false) && !known(&skew, true));
        let p = IMatrix::from_rows(&[[1, 5, -14], [-1, 5, 21], [2, -15, 7]]);
        assert!(known(&p, true));
    }

    /// det = -3: no test may say P0.
    #[test]
    fn says_nothing_about_others() {
        assert!(!known(&IMatrix::from_rows(&[[1, 2], [2, 1]]), false));
    }
}
