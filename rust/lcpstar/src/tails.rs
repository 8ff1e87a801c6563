//! Tails: rows in which the solution of a discretised equation has decayed to rounding beside its largest entries.
//!
//! A row whose error is a large part of its own numbers may make an unsolvable problem look solved, so the rule refuses it. Where
//! A is a P-matrix there is a solution for every q, and an error below the rounding of the part of the problem that the row
//! belongs to is forgiven. The P-matrices that are recognised are the weakly chained diagonally dominant ones with a positive
//! diagonal: `a_ii >= sum_(j != i) |a_ij|` in every row, and from every row a chain of nonzero entries leads to a row where the
//! inequality is strict. Such a matrix is nonsingular [AF16], and so is each of its principal submatrices: a row whose
//! chain is cut has lost an entry and has become strict. Shrinking the off-diagonal entries to zero keeps all that, so no
//! principal minor changes sign on the way to the diagonal: all are positive.

use crate::equilibrate::Rows;
use crate::linalg::dd::two_sum;

/// What is forgiven in each row of an equilibrated problem.
#[derive(Clone, Debug)]
pub struct Tails {
    q: Vec<f64>,
    rounding: Vec<f64>,
}

impl Tails {
    /// Those of the equilibrated copy `scaled` of `original`; `None` unless A is recognised as a P-matrix. O(nnz log n).
    #[must_use]
    pub fn new<P: Rows>(original: &P, scaled: &P) -> Option<Self> {
        is_chained_dominant(original).then(|| {
            let (q, parts) = (scaled.q(), parts(scaled));
            let mut largest = vec![0.0_f64; q.len()];
            for (q, &part) in q.iter().zip(&parts) {
                largest[part] = largest[part].max(q.abs());
            }
            Self { q: q.to_vec(), rounding: parts.iter().map(|&part| 32.0 * f64::EPSILON * largest[part]).collect() }
        })
    }

    /// Whether the error `off` of row i, with `m = (|A||z| + |q|)_i`, is forgiven. In a row of which q_i is the greater part
    /// nothing decays.
    #[must_use]
    pub fn forgive(&self, i: usize, off: f64, m: f64) -> bool {
        2.0 * self.q[i].abs() < m && off <= self.rounding[i]
    }
}

/// Whether A is weakly chained diagonally dominant with a positive diagonal, decided exactly. O(nnz).
fn is_chained_dominant<P: Rows>(lcp: &P) -> bool {
    let n = lcp.n();
    let mut strict = Vec::new();
    for i in 0..n {
        let (mut diagonal, mut others) = (0.0, Vec::new());
        lcp.for_each(i, |j, a| if j == i { diagonal = a } else { others.push(-a.abs()) });
        match (diagonal > 0.0).then(|| sign_of_sum(diagonal, &others)).flatten() {
            Some(1) => strict.push(i),
            Some(0) => {}
            _ => return false,
        }
    }
    // Backwards along the chains from the strict rows.
    let mut into = vec![Vec::new(); n];
    if strict.len() < n {
        for i in 0..n {
            lcp.for_each(i, |j, a| {
                if j != i && a != 0.0 {
                    into[j].push(i)
                }
            });
        }
    }
    let mut reached = vec![false; n];
    strict.iter().for_each(|&i| reached[i] = true);
    let mut count = strict.len();
    while let Some(j) = strict.pop() {
        for i in std::mem::take(&mut into[j]) {
            if !std::mem::replace(&mut reached[i], true) {
                count += 1;
                strict.push(i);
            }
        }
    }
    count == n
}

/// The sign of `start + sum x`; `None` where only longer arithmetic could tell.
fn sign_of_sum(start: f64, x: &[f64]) -> Option<i8> {
    let (mut sum, mut error, mut is_exact) = (start, 0.0, true);
    for &x in x {
        let (s, e) = two_sum(sum, x);
        (sum, error, is_exact) = (s, error + e, is_exact && e == 0.0);
    }
    let total = sum + error;
    // Each error is below eps times the sum of sizes, which the positive start bounds where the total is not negative.
    let doubt = (x.len() as f64 * f64::EPSILON).powi(2) * start;
    if is_exact && sum == 0.0 {
        Some(0)
    } else if total.abs() > doubt {
        Some(if total > 0.0 { 1 } else { -1 })
    } else {
        None
    }
}

/// A number per index, itself an index, that is the same for i and j where `a_ij` or `a_ji` is not 0, or a chain of such pairs
/// joins them: union-find with path halving, O(nnz log n) at most. [TL84]
fn parts<P: Rows>(lcp: &P) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..lcp.n()).collect();
    let root = |parent: &mut [usize], mut i: usize| {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    };
    for i in 0..lcp.n() {
        lcp.for_each(i, |j, x| {
            if x != 0.0 {
                let (a, b) = (root(&mut parent, i), root(&mut parent, j));
                parent[a.max(b)] = a.min(b);
            }
        });
    }
    (0..lcp.n()).map(|i| root(&mut parent, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Lcp;

    fn recognised(n: usize, a: &[f64]) -> bool {
        is_chained_dominant(&Lcp::new(n, a.to_vec(), vec![0.0; n]).expect("valid"))
    }

    #[test]
    fn chains_to_a_strict_row_decide() {
        assert!(recognised(2, &[2.0, -1.0, 1.0, 2.0]));
        assert!(recognised(3, &[2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 2.0]), "the second difference");
        assert!(!recognised(2, &[1.0, -1.0, -1.0, 1.0]), "no strict row");
        assert!(!recognised(3, &[1.0, -1.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 1.0]), "no chain to the strict one");
        assert!(!recognised(2, &[1.0, -2.0, 0.0, 1.0]) && !recognised(1, &[0.0]) && !recognised(1, &[-1.0]));
    }

    #[test]
    fn rounding_is_no_dominance() {
        // 0.1 + 0.2 rounds up: 0.30000000000000004 is not dominated by the exact sum of the two, which is larger still.
        assert_eq!(sign_of_sum(0.1 + 0.2, &[-0.1, -0.2]), Some(1));
        assert_eq!(sign_of_sum(0.3, &[-0.1, -0.2]), Some(-1));
        assert_eq!(sign_of_sum(4.0, &[-1.0; 4]), Some(0));
    }
}
