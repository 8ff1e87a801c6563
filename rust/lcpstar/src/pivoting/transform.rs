//! The principal pivot transform of (A, q). [CPS92, sec. 2.3]

use crate::control::Control;
use crate::equilibrate::Equilibrated;
use crate::error::{LcpError, Result};
use crate::linalg::backend::{DenseLu, rank};
use crate::linalg::kernels::axpy;
use crate::pivoting::basis::principal_block;
use crate::problem::{Lcp, check_finite, check_finite_matrix};
use crate::scaling::times_power_of_two;

/// LCP(p, M): the principal pivot transform of LCP(q, A) on `alpha`, in which `w_alpha` and `z_alpha` trade places:
///
/// `M_aa = A_aa^-1`, `M_ab = -A_aa^-1 A_ab`, `M_ba = A_ba A_aa^-1`, `M_bb = A_bb - A_ba A_aa^-1 A_ab`,
/// `p_a = -A_aa^-1 q_a`, `p_b = q_b - A_ba A_aa^-1 q_a` with `b` the complement of `a = alpha`. O(n^2 |alpha|). `None` when
/// `control` stops it, which it may do everywhere but inside a factorisation of `A[alpha, alpha]`.
///
/// # Errors
/// `BadIndex` for an index out of range or repeated; `SingularBlock` when `A[alpha, alpha]` is singular to rounding
/// (rank by complete pivoting on the equilibrated block, threshold `|alpha| EPS`); `NotFinite` for an entry of M or p beyond
/// the range of doubles.
pub fn principal_pivot_transform(lcp: &Lcp, alpha: &[usize], control: &Control<'_>) -> Result<Option<Lcp>> {
    let n = lcp.n();
    let mut in_alpha = vec![false; n];
    for &i in alpha {
        let repeated = in_alpha.get(i).copied().unwrap_or(false);
        if i >= n || repeated {
            return Err(LcpError::BadIndex { name: "alpha", index: i64::try_from(i).unwrap_or(i64::MAX), n, repeated });
        }
        in_alpha[i] = true;
    }
    let beta: Vec<usize> = (0..n).filter(|&i| !in_alpha[i]).collect();
    let k = alpha.len();

    // The block is factored in its own equilibrated units: powers of two, so nothing is rounded on the way.
    let zeros = vec![0.0; k];
    let block_lcp = Lcp::trusted(k, principal_block(lcp, alpha), zeros);
    let block = Equilibrated::new(&block_lcp);
    let (rows, columns) = (&block.scaling.rows, &block.scaling.columns);
    let singular = |rank: usize| Err(LcpError::SingularBlock { alpha: alpha.to_vec(), rank });
    let Some(lu) = DenseLu::new(k, block.lcp.a()) else {
        return singular(rank(k, block.lcp.a()).min(k.saturating_sub(1)));
    };

    // X = A_aa^-1 [I | A_ab | q_a], some columns at a time; k rows, n + 1 columns.
    let m = n + 1;
    let entry = |r: usize, c: usize| match c {
        _ if c < k => f64::from(u8::from(r == c)),
        _ if c < n => lcp.row(alpha[r])[beta[c - k]],
        _ => lcp.q()[alpha[r]],
    };
    let mut x = vec![0.0; k * m];
    for first in (0..m).step_by(COLUMNS) {
        if control.expired().is_some() {
            return Ok(None);
        }
        let width = COLUMNS.min(m - first);
        let rhs: Vec<f64> = (0..k * width)
            .map(|at| times_power_of_two(entry(at / width, first + at % width), rows[at / width]))
            .collect();
        for (r, solved) in lu.solve_many(&rhs, width).chunks_exact(width).enumerate() {
            x[r * m + first..r * m + first + width].copy_from_slice(solved);
        }
    }
    let inverse = (0..k * k).map(|at| times_power_of_two(x[at / k * m + at % k], -rows[at % k]).abs());
    if !is_surely_regular(k, inverse) {
        let found = rank(k, block.lcp.a());
        if found < k {
            return singular(found);
        }
    }
    for (row, &c) in x.chunks_exact_mut(m).zip(columns) {
        row.iter_mut().for_each(|x| *x = times_power_of_two(*x, c));
    }

    let (mut a, mut p) = (vec![0.0; n * n], vec![0.0; n]);
    for (r, &i) in alpha.iter().enumerate() {
        let row = &x[r * m..(r + 1) * m];
        for (c, &j) in alpha.iter().enumerate() {
            a[i * n + j] = row[c];
        }
        for (c, &j) in beta.iter().enumerate() {
            a[i * n + j] = -row[k + c];
        }
        p[i] = -row[n];
    }
    for &i in &beta {
        if control.expired().is_some() {
            return Ok(None);
        }
        // (A_ia X) gives M_ia, and what is subtracted from A_ib and q_i.
        let mut product = vec![0.0; m];
        for (r, &l) in alpha.iter().enumerate() {
            axpy(lcp.row(i)[l], &x[r * m..(r + 1) * m], &mut product);
        }
        for (c, &j) in alpha.iter().enumerate() {
            a[i * n + j] = product[c];
        }
        for (c, &j) in beta.iter().enumerate() {
            a[i * n + j] = lcp.row(i)[j] - product[k + c];
        }
        p[i] = lcp.q()[i] - product[n];
    }
    check_finite_matrix("M", &a, n)?;
    check_finite("p", &p)?;
    Ok(Some(Lcp::trusted(n, a, p)))
}

/// Columns that are solved for at a time.
const COLUMNS: usize = 128;

/// Whether [`rank`] must find full rank, given the entries of `|B^-1|`, with `max|B| < 2`.
///
/// Complete pivoting leaves Schur complements S of which every `S^-1` is a block of `B^-1`, so that no pivot is below
/// `1 / (k max|B^-1|)`; none is above `2 k` in practice. [Hig02, sec. 9.4]
fn is_surely_regular(k: usize, mut inverse: impl Iterator<Item = f64>) -> bool {
    let k = k as f64;
    inverse.all(|x| 2.0 * k * k * k * f64::EPSILON * x < 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transform(lcp: &Lcp, alpha: &[usize]) -> Result<Lcp> {
        principal_pivot_transform(lcp, alpha, &Control::default()).map(|found| found.expect("not stopped"))
    }

    #[test]
    fn example_5_of_the_paper() {
        // A^-1 as the paper prints it, det A = -3.
        let a = vec![0.0, 1.0, 1.0, 2.0, 0.0, 1.0, -1.0, -1.0, 0.0];
        let lcp = Lcp::new(3, a, vec![1.0, 2.0, 3.0]).expect("valid");
        let m = transform(&lcp, &[0, 1, 2]).expect("nonsingular");
        let expected = [-1.0, 1.0, -1.0, 1.0, -1.0, -2.0, 2.0, 1.0, 2.0].map(|x| x / 3.0);
        for (found, expected) in m.a().iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }

    #[test]
    fn an_entry_beyond_the_doubles_is_named() {
        let lcp = Lcp::new(1, vec![1e-310], vec![1.0]).expect("valid");
        let error = transform(&lcp, &[0]).expect_err("1e310 is no double");
        assert_eq!(error, LcpError::NotFinite { name: "M", index: vec![0, 0], value: f64::INFINITY });
    }

    #[test]
    fn singular_block_is_named() {
        let lcp = Lcp::new(3, vec![0.1, 0.2, 1.0, 0.3, 0.6, 1.0, 1.0, 1.0, 1.0], vec![0.0; 3]).expect("valid");
        let error = transform(&lcp, &[0, 1]).expect_err("rank 1");
        assert_eq!(error, LcpError::SingularBlock { alpha: vec![0, 1], rank: 1 });
        assert!(transform(&lcp, &[]).is_ok());
        assert!(matches!(transform(&lcp, &[1, 1]), Err(LcpError::BadIndex { repeated: true, .. })));
        assert!(matches!(transform(&lcp, &[3]), Err(LcpError::BadIndex { repeated: false, .. })));
    }
}
