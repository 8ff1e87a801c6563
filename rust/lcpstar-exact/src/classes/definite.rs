//! Definiteness of the quadratic form `x'Sx`, S symmetric, by symmetric fraction-free elimination.

use super::budget::{Budget, Search};
use crate::elimination::reduce_unless;
use crate::imatrix::IMatrix;
use crate::int::{Int, make_primitive};

/// `x` with `x'Sx < 0`, or with `x != 0` and `x'Sx <= 0` when `strict`; `None` if S is PSD (PD). O(n^3).
///
/// # Errors
/// `Stopped` by the budget.
pub fn negative_direction(s: &IMatrix, strict: bool, budget: &Budget<'_>) -> Search<Option<Vec<Int>>> {
    let n = s.rows();
    let mut m = s.clone();
    let mut previous = Int::ONE;
    let mut left: Vec<usize> = (0..n).collect();
    let mut done: Vec<usize> = Vec::new();
    while !left.is_empty() {
        if let Some(&i) = left.iter().find(|&&i| m.at(i, i).sign() < 0) {
            return lift(s, &done, &[(i, 1)], budget).map(Some);
        }
        let Some(position) = left.iter().position(|&i| m.at(i, i).sign() > 0) else {
            break;
        };
        let k = left.remove(position);
        let pivot = m.at(k, k).clone();
        for &i in &left {
            budget.poll()?;
            for &j in left.iter().filter(|&&j| j >= i) {
                let x = Int::cross(&pivot, m.at(i, j), m.at(i, k), m.at(k, j), &previous);
                m.set(j, i, x.clone());
                m.set(i, j, x);
            }
        }
        previous = pivot;
        done.push(k);
    }
    // Zero diagonal left: an off-diagonal entry makes the form indefinite, none makes it singular.
    for (p, &i) in left.iter().enumerate() {
        for &j in &left[p + 1..] {
            let sign = m.at(i, j).sign();
            if sign != 0 {
                return lift(s, &done, &[(i, 1), (j, -sign)], budget).map(Some);
            }
        }
    }
    left.first().filter(|_| strict).map(|&i| lift(s, &done, &[(i, 1)], budget)).transpose()
}

/// Completes `u`, given off `done`, by the minimiser of the form over the eliminated variables `done`.
fn lift(s: &IMatrix, done: &[usize], u: &[(usize, i32)], budget: &Budget<'_>) -> Search<Vec<Int>> {
    let k = done.len();
    let system = IMatrix::from_fn(k, k + 1, |i, j| {
        if j < k {
            s.at(done[i], done[j]).clone()
        } else {
            u.iter().fold(Int::ZERO, |sum, &(c, sign)| &sum - &(&Int::from(i64::from(sign)) * s.at(done[i], c)))
        }
    });
    let reduced = reduce_unless(system, k, || budget.poll())?;
    let (y, t) = reduced.particular(k, k).unwrap_or((vec![Int::ZERO; k], Int::ONE));
    let mut x = vec![Int::ZERO; s.rows()];
    for (value, &i) in y.into_iter().zip(done) {
        x[i] = value;
    }
    for &(c, sign) in u {
        x[c] = &t * &Int::from(i64::from(sign));
    }
    make_primitive(&mut x);
    Ok(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn witnesses_are_right_and_exist_when_they_should() {
        let cases: [(&[[i64; 3]; 3], bool, bool); 5] = [
            (&[[2, 1, 0], [1, 2, 1], [0, 1, 2]], true, true),
            (&[[1, 1, 1], [1, 1, 1], [1, 1, 1]], true, false),
            (&[[1, 2, 0], [2, 1, 0], [0, 0, 1]], false, false),
            (&[[0, 0, 0], [0, 0, 1], [0, 1, 0]], false, false),
            (&[[1, 1, 1], [1, 1, 2], [1, 2, 1]], false, false),
        ];
        for (rows, psd, pd) in cases {
            let s = IMatrix::from_rows(rows);
            for (strict, holds) in [(false, psd), (true, pd)] {
                let found = negative_direction(&s, strict, &Budget::unlimited()).expect("no limit");
                assert_eq!(found.is_none(), holds, "{rows:?}");
                if let Some(x) = found {
                    let value = s.form(&x, &x).sign();
                    assert!(value < 0 || (strict && value == 0 && x.iter().any(|v| !v.is_zero())));
                }
            }
        }
    }
}
