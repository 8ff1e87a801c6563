//! Exact linear programs of small size: an integer simplex tableau with Bland's rule.

use super::int::{Int, make_primitive};
use std::convert::Infallible;

/// Rows `t x = t_rhs` with one positive common denominator `d`; the last row is the objective.
struct Tableau {
    rows: Vec<Vec<Int>>,
    basis: Vec<usize>,
    d: Int,
}

impl Tableau {
    /// Exchanges basic variable of row `r` for column `c`; the pivot is positive, so `d` stays positive.
    fn pivot<E>(&mut self, r: usize, c: usize, stopped: &impl Fn() -> Result<(), E>) -> Result<(), E> {
        let pivot = self.rows[r][c].clone();
        let row = self.rows[r].clone();
        for (i, other) in self.rows.iter_mut().enumerate() {
            if i != r {
                stopped()?;
                let factor = other[c].clone();
                for (x, y) in other.iter_mut().zip(&row) {
                    *x = Int::cross(&pivot, x, &factor, y, &self.d);
                }
            }
        }
        self.d = pivot;
        self.basis[r] = c;
        Ok(())
    }

    /// Bland's rule on the first `columns` columns until no reduced cost is negative; `false` if unbounded.
    fn minimise<E>(&mut self, columns: usize, stopped: &impl Fn() -> Result<(), E>) -> Result<bool, E> {
        let objective = self.rows.len() - 1;
        while let Some(c) = (0..columns).find(|&j| self.rows[objective][j].sign() < 0) {
            let rhs = self.rows[objective].len() - 1;
            let mut best: Option<usize> = None;
            for i in (0..objective).filter(|&i| self.rows[i][c].sign() > 0) {
                let smaller = best.is_none_or(|b| {
                    let left = &self.rows[i][rhs] * &self.rows[b][c];
                    let right = &self.rows[b][rhs] * &self.rows[i][c];
                    left < right || (left == right && self.basis[i] < self.basis[b])
                });
                if smaller {
                    best = Some(i);
                }
            }
            let Some(r) = best else { return Ok(false) };
            self.pivot(r, c, stopped)?;
        }
        Ok(true)
    }
}

/// The answer to `G x = b, x >= 0`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Feasibility {
    /// `(x, t)`: `G x = t b`, `x >= 0`, `t > 0`.
    Point(Vec<Int>, Int),
    /// Farkas: `y'G >= 0`, `y'b < 0`.
    Farkas(Vec<Int>),
}

/// Decides `G x = b, x >= 0`; `columns` are the columns of G, each as long as `b`.
#[must_use]
pub fn feasible(columns: &[Vec<Int>], b: &[Int]) -> Feasibility {
    let (m, k) = (b.len(), columns.len());
    let flip: Vec<bool> = b.iter().map(|x| x.sign() < 0).collect();
    let signed = |i: usize, x: &Int| if flip[i] { -x } else { x.clone() };
    let mut rows: Vec<Vec<Int>> = (0..m)
        .map(|i| {
            let mut row: Vec<Int> = columns.iter().map(|c| signed(i, &c[i])).collect();
            row.extend((0..m).map(|j| Int::from(i64::from(i == j))));
            row.push(signed(i, &b[i]));
            row
        })
        .collect();
    // Minimise the sum of the artificial variables: reduced costs start as minus the column sums.
    let objective = (0..=k + m)
        .map(|j| {
            let sum = rows.iter().fold(Int::ZERO, |sum, row| &sum + &row[j]);
            if (k..k + m).contains(&j) { Int::ZERO } else { -&sum }
        })
        .collect();
    rows.push(objective);
    let mut tableau = Tableau { rows, basis: (k..k + m).collect(), d: Int::ONE };
    let Ok(bounded) = tableau.minimise::<Infallible>(k, &|| Ok(()));
    debug_assert!(bounded, "a sum of nonnegative variables is bounded below");
    let last = &tableau.rows[m];
    if last[k + m].is_zero() {
        let mut x = vec![Int::ZERO; k];
        for (row, &column) in tableau.basis.iter().enumerate() {
            if column < k {
                x[column] = tableau.rows[row][k + m].clone();
            }
        }
        return Feasibility::Point(x, tableau.d);
    }
    // Reduced cost of artificial i is 1 - pi_i, so y = -pi, with the sign of the row given back.
    let mut y: Vec<Int> = (0..m).map(|i| signed(i, &(&last[k + i] - &tableau.d))).collect();
    make_primitive(&mut y);
    Feasibility::Farkas(y)
}

/// `max 1'p` subject to `B p <= 1, p >= 0` for a positive matrix B given by rows: `(p, u, t)`, all over the common
/// denominator `t > 0`; `u` is optimal in the dual `min 1'u, B'u >= 1, u >= 0`.
///
/// # Errors
/// What `stopped` says, which is asked before each row of a pivot.
pub fn packing<E>(b: &[Vec<Int>], stopped: impl Fn() -> Result<(), E>) -> Result<(Vec<Int>, Vec<Int>, Int), E> {
    let (m, k) = (b.len(), b.first().map_or(0, Vec::len));
    let mut rows: Vec<Vec<Int>> = (0..m)
        .map(|i| {
            let mut row = b[i].clone();
            row.extend((0..m).map(|j| Int::from(i64::from(i == j))));
            row.push(Int::ONE);
            row
        })
        .collect();
    rows.push((0..=k + m).map(|j| Int::from(-i64::from(j < k))).collect());
    let mut tableau = Tableau { rows, basis: (k..k + m).collect(), d: Int::ONE };
    let bounded = tableau.minimise(k + m, &stopped)?;
    debug_assert!(bounded, "B is positive");
    let mut p = vec![Int::ZERO; k];
    for (row, &column) in tableau.basis.iter().enumerate() {
        if column < k {
            p[column] = tableau.rows[row][k + m].clone();
        }
    }
    let u = tableau.rows[m][k..k + m].to_vec();
    Ok((p, u, tableau.d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::int::dot;

    fn ints(x: &[i64]) -> Vec<Int> {
        x.iter().map(|&v| v.into()).collect()
    }

    #[test]
    fn point_or_farkas() {
        let columns = [ints(&[1, 2]), ints(&[3, 1]), ints(&[-1, 0])];
        for b in [ints(&[4, 3]), ints(&[-5, 0]), ints(&[-1, -1]), ints(&[0, 0]), ints(&[2, 1])] {
            match feasible(&columns, &b) {
                Feasibility::Point(x, t) => {
                    assert!(t.sign() > 0 && x.iter().all(|v| v.sign() >= 0));
                    for i in 0..2 {
                        let row: Vec<Int> = columns.iter().map(|c| c[i].clone()).collect();
                        assert_eq!(dot(&row, &x), &t * &b[i]);
                    }
                }
                Feasibility::Farkas(y) => {
                    assert!(columns.iter().all(|c| dot(c, &y).sign() >= 0) && dot(&y, &b).sign() < 0);
                    assert_eq!(b, ints(&[-1, -1]), "only this one is infeasible");
                }
            }
        }
    }

    #[test]
    fn packing_is_dual() {
        let Ok((p, u, t)) = packing::<Infallible>(&[ints(&[3, 1]), ints(&[1, 2])], || Ok(()));
        let sum = |v: &[Int]| v.iter().fold(Int::ZERO, |s, x| &s + x);
        assert_eq!(sum(&p), sum(&u));
        assert_eq!((sum(&p), t), (Int::from(3), Int::from(5)));
    }
}
