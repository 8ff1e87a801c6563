//! Whether a small LCP has a solution at all, decided exactly on the binary numbers by trying every support.
//!
//! The solution set is a union of polyhedra `{z >= 0, A_SS z = -q_S, A z + q >= 0}` without lines, so if there is a solution
//! there is one at a vertex. With S its support and T its rows with w = 0, `A_TS` has full column rank there, since a null
//! vector could be added and subtracted. So: for every S, then every T that contains S while the rank falls short, the one
//! solution of `A_TS z = -q_T` is tried. 3^n systems at most.

use crate::exact::{parts, sign, sum_of_products};
use crate::problems::Problem;
use num_bigint::BigInt;
use num_traits::{Signed, Zero};

/// The rows of `(A | q)` as integers, after rows and columns were scaled by powers of two.
struct Integers {
    n: usize,
    a: Vec<BigInt>,
    q: Vec<BigInt>,
}

impl Integers {
    fn new(problem: &Problem) -> Self {
        let n = problem.n;
        let (a, q): (Vec<_>, Vec<_>) =
            (problem.a.iter().map(|&x| parts(x)).collect(), problem.q.iter().map(|&x| parts(x)).collect());
        let least = |entries: &mut dyn Iterator<Item = (i64, i64)>| entries.filter(|x| x.0 != 0).map(|x| x.1).min();
        let column: Vec<i64> = (0..n).map(|j| least(&mut (0..n).map(|i| a[i * n + j])).unwrap_or(0)).collect();
        let row: Vec<i64> = (0..n)
            .map(|i| {
                let entries = (0..n).map(|j| (a[i * n + j].0, a[i * n + j].1 - column[j])).chain([q[i]]);
                least(&mut entries.into_iter()).unwrap_or(0)
            })
            .collect();
        let integer =
            |(m, e): (i64, i64), shift: i64| if m == 0 { BigInt::zero() } else { BigInt::from(m) << (e - shift) };
        Self {
            n,
            a: (0..n * n).map(|k| integer(a[k], row[k / n] + column[k % n])).collect(),
            q: (0..n).map(|i| integer(q[i], row[i])).collect(),
        }
    }

    fn entry(&self, i: usize, j: usize) -> &BigInt {
        &self.a[i * self.n + j]
    }

    /// The solution `(numerators, denominator > 0)` of `A_TS z = -q_T`; `None` if there is none. `Err` when not unique.
    fn solve(&self, rows: &[usize], columns: &[usize]) -> Result<Option<(Vec<BigInt>, BigInt)>, ()> {
        let k = columns.len();
        let mut table: Vec<Vec<BigInt>> = rows
            .iter()
            .map(|&i| columns.iter().map(|&j| self.entry(i, j).clone()).chain([-&self.q[i]]).collect())
            .collect();
        // Fraction-free Gauss-Jordan elimination: after step c the first c pivots all equal `previous`.
        let mut previous = BigInt::from(1);
        for c in 0..k {
            let Some(p) = (c..rows.len()).find(|&r| !table[r][c].is_zero()) else { return Err(()) };
            table.swap(c, p);
            let pivot_row = table[c].clone();
            for (r, row) in table.iter_mut().enumerate() {
                if r != c {
                    let factor = row[c].clone();
                    for j in 0..=k {
                        row[j] = (&pivot_row[c] * &row[j] - &factor * &pivot_row[j]) / &previous;
                    }
                }
            }
            previous = pivot_row[c].clone();
        }
        if table[k..].iter().any(|row| !row[k].is_zero()) {
            return Ok(None);
        }
        let flip = previous.is_negative();
        let numerators = table[..k].iter().map(|row| if flip { -&row[k] } else { row[k].clone() }).collect();
        Ok(Some((numerators, previous.abs())))
    }

    /// Whether `z_S = numerators / denominator` is nonnegative with `w >= 0`, and `w = 0` on S.
    fn solves(&self, support: &[usize], (numerators, denominator): &(Vec<BigInt>, BigInt)) -> bool {
        let w = |i: usize| -> BigInt {
            let products = support.iter().zip(numerators).map(|(&j, z)| self.entry(i, j) * z);
            products.sum::<BigInt>() + &self.q[i] * denominator
        };
        numerators.iter().all(|z| !z.is_negative())
            && (0..self.n).all(|i| if support.contains(&i) { w(i).is_zero() } else { sign(&w(i)) >= 0 })
    }
}

/// The part of the problem that decides whether it has a solution. Rows with `a_ii > sum_j |a_ij|` that the others do not refer
/// to are left out: with R their indices, `A_RR` is a P-matrix, so w_R and z_R can be found for any z of the core.
pub fn core(problem: &Problem) -> Problem {
    let n = problem.n;
    let is_dominant = |i: usize| {
        let size = |j: usize| if i == j { problem.row(i)[j] } else { -problem.row(i)[j].abs() };
        sum_of_products((0..n).map(|j| (size(j), 1.0))).0.is_positive()
    };
    let mut inside: Vec<bool> = (0..n).map(|i| !is_dominant(i)).collect();
    let mut todo: Vec<usize> = (0..n).filter(|&i| inside[i]).collect();
    while let Some(i) = todo.pop() {
        for j in (0..n).filter(|&j| problem.row(i)[j] != 0.0) {
            if !std::mem::replace(&mut inside[j], true) {
                todo.push(j);
            }
        }
    }
    let kept: Vec<usize> = (0..n).filter(|&i| inside[i]).collect();
    let a = kept.iter().flat_map(|&i| kept.iter().map(move |&j| problem.row(i)[j])).collect();
    Problem { n: kept.len(), a, q: kept.iter().map(|&i| problem.q[i]).collect() }
}

/// The members of a bit set.
fn members(set: usize) -> Vec<usize> {
    (0..usize::BITS as usize).filter(|i| set >> i & 1 == 1).collect()
}

/// Whether LCP(q, A) has an exact solution. Up to 3^n eliminations: for n <= 6 or so.
pub fn is_solvable(problem: &Problem) -> bool {
    let integers = Integers::new(problem);
    let n = problem.n;
    (0..1_usize << n).any(|set| {
        let support = members(set);
        match integers.solve(&support, &support) {
            Ok(found) => found.is_some_and(|z| integers.solves(&support, &z)),
            Err(()) => {
                let rest = !set & ((1 << n) - 1);
                // Every nonempty subset of the other rows.
                let mut extra = rest;
                while extra != 0 {
                    let rows = members(set | extra);
                    if let Ok(Some(z)) = integers.solve(&rows, &support)
                        && integers.solves(&support, &z)
                    {
                        return true;
                    }
                    extra = (extra - 1) & rest;
                }
                false
            }
        }
    })
}

/// Whether the support alone gives an exact solution: the cheap first question.
pub fn support_solves(problem: &Problem, support: &[usize]) -> bool {
    let integers = Integers::new(problem);
    matches!(integers.solve(support, support), Ok(Some(z)) if integers.solves(support, &z))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(a: &[f64], q: &[f64]) -> Problem {
        Problem { n: q.len(), a: a.to_vec(), q: q.to_vec() }
    }

    #[test]
    fn solvable_and_not() {
        assert!(is_solvable(&problem(&[], &[])));
        assert!(is_solvable(&problem(&[2.0], &[-1.0])));
        assert!(!is_solvable(&problem(&[-2.0], &[-1.0])));
        assert!(!is_solvable(&problem(&[0.0], &[-1.0])));
        assert!(is_solvable(&problem(&[0.0], &[0.0])));
        // Bimatrix: every covering vector ends on a ray.
        assert!(is_solvable(&problem(&[0.0, 1.0, 1.0, 0.0], &[-1.0, -1.0])));
        // Feasible at z = (0, 1), but then w_2 = 1.
        assert!(!is_solvable(&problem(&[0.0, 1.0, 0.0, 0.0], &[-1.0, 1.0])));
    }

    #[test]
    fn rows_that_decide_nothing_are_left_out() {
        // Row 1 is dominant and no other row needs z_1; row 2 is dominant, but row 0 needs z_2.
        let p = problem(&[-1.0, 0.0, 1.0, 2.0, 4.0, -1.0, 0.5, 0.0, 2.0], &[-1.0, -5.0, 3.0]);
        let decides = core(&p);
        assert_eq!((decides.n, decides.a, decides.q), (2, vec![-1.0, 1.0, 0.5, 2.0], vec![-1.0, 3.0]));
        assert_eq!(is_solvable(&p), is_solvable(&core(&p)));
    }

    #[test]
    fn a_singular_block_needs_a_row_outside_the_support() {
        // z = (1, 1, 0): A_SS of S = {1, 2} is [[0, 1], [0, 0]], and only the row of w_3 = z_1 - z_2 gives z_1.
        let p = problem(&[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, -1.0, 0.0], &[-1.0, -1.0, 0.0]);
        assert!(is_solvable(&p));
        assert!(!support_solves(&p, &[0, 1]));
    }

    #[test]
    fn powers_of_two_change_nothing() {
        let a = [
            0.0, 2.0, -1.0, 2.0, -1.0, 0.0, 2.0, 2.0, -2.0, 0.0, -2.0, 2.0, 1.0, -2.0, 0.0, 0.0, 2.0, -1.0, 0.0, -2.0,
            0.0, 0.0, 2.0, 1.0, -1.0,
        ];
        let q = [1.0, -2.0, -3.0, -3.0, -3.0];
        assert!(!is_solvable(&problem(&a, &q)));
        let d = [2f64.powi(40), 1.0, 2f64.powi(-40), 8.0, 2f64.powi(-300)];
        let scaled: Vec<f64> = (0..25).map(|k| a[k] * d[k / 5] * d[4 - k % 5]).collect();
        assert!(!is_solvable(&problem(&scaled, &[d[0], -2.0 * d[1], -3.0 * d[2], -3.0 * d[3], -3.0 * d[4]])));
    }
}
