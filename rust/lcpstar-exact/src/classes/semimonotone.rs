//! Semimonotone and copositive matrices by one linear solve per index set.
//!
//! If every proper principal submatrix of A is in E0 and A is not, the convex cone `{x : Ax < 0}` is nonempty and
//! misses the boundary of the orthant, so it lies in its interior; then it holds no line, A is nonsingular and
//! `A^-1 <= 0`. Hence A is in E0 if and only if no `A[alpha, alpha]` is nonsingular with `-A[alpha, alpha]^-1 e > 0`.
//! The same argument with `{x : Ax <= 0}` gives E: either `A^-1 < 0`, or the null space is one positive ray.
//! For symmetric S = A + A' semimonotone and copositive are the same [CPS92, sec. 3.8, 3.9].

use super::budget::{Budget, Search};
use crate::elimination::reduce;
use crate::imatrix::{IMatrix, by_size, embed, indices};
use crate::int::{Int, make_primitive};

/// Support-minimal `x >= 0` with `(Ax)_i < 0` (`<= 0` when `strict`) wherever `x_i > 0`; `None` if A is in E0 (in E).
///
/// # Errors
/// `Stopped` by the budget.
pub fn violation(a: &IMatrix, strict: bool, budget: &Budget<'_>) -> Search<Option<Vec<Int>>> {
    let n = a.rows();
    budget.begin((1u64 << n.min(63)) - 1);
    for mask in by_size(n) {
        budget.step()?;
        let alpha = indices(mask);
        if let Some(x) = block_violation(a, &alpha, strict) {
            return Ok(Some(embed(&x, &alpha, n)));
        }
    }
    Ok(None)
}

/// As [`violation`] for `x'Ax < 0` (`<= 0`), `x >= 0`: C0 and C.
///
/// # Errors
/// `Stopped` by the budget.
pub fn copositive_violation(a: &IMatrix, strict: bool, budget: &Budget<'_>) -> Search<Option<Vec<Int>>> {
    violation(&a.symmetric_part(), strict, budget)
}

/// `x > 0` with `A[alpha, alpha] x = -e`, or with `A[alpha, alpha] x = 0` and nullity one when `strict`.
fn block_violation(a: &IMatrix, alpha: &[usize], strict: bool) -> Option<Vec<Int>> {
    let k = alpha.len();
    if let [i] = alpha {
        let sign = a.at(*i, *i).sign();
        return (sign < 0 || (strict && sign == 0)).then(|| vec![Int::ONE]);
    }
    let system =
        IMatrix::from_fn(k, k + 1, |i, j| if j < k { a.at(alpha[i], alpha[j]).clone() } else { Int::from(-1) });
    let reduced = reduce(system, k);
    let mut x = match k - reduced.rank() {
        0 => reduced.particular(k, k)?.0,
        1 if strict => {
            let mut x = reduced.null_space(k).pop()?;
            if x[0].sign() < 0 {
                x.iter_mut().for_each(|v| *v = -&*v);
            }
            x
        }
        _ => return None,
    };
    make_primitive(&mut x);
    x.iter().all(|v| v.sign() > 0).then_some(x)
}

/// Support-minimal zeros `x >= 0` of the form of a copositive A: every zero is a sum of these with support inside its own.
///
/// On the support of a zero the block `S[alpha, alpha]` is PSD, so `S[alpha, alpha] x = 0`.
///
/// # Errors
/// `Stopped` by the budget.
pub fn zeros_of_copositive_form(a: &IMatrix, budget: &Budget<'_>) -> Search<Vec<Vec<Int>>> {
    let (n, s) = (a.rows(), a.symmetric_part());
    let mut zeros = Vec::new();
    for mask in by_size(n) {
        budget.poll()?;
        let alpha = indices(mask);
        let block = s.principal(&alpha);
        let mut basis = reduce(block, alpha.len()).null_space(alpha.len());
        if basis.len() == 1
            && let Some(x) = basis.pop()
        {
            let sign = x[0].sign();
            if sign != 0 && x.iter().all(|v| v.sign() == sign) {
                let x: Vec<Int> = x.iter().map(Int::abs).collect();
                zeros.push(embed(&x, &alpha, n));
            }
        }
    }
    Ok(zeros)
}
