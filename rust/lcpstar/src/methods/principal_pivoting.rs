//! Principal pivoting by the criss-cross method with least indices. [HRT93], [FNT98], [CI06]
//!
//! From complementary basis to complementary basis: the least index whose basic variable is negative is exchanged with
//! its partner or, where the diagonal entry is zero, together with the least index that can raise it. Neither q nor a
//! covering vector is perturbed. For sufficient matrices it ends at a solution or at a row that proves FEA(q, A) empty.
//!
//! No class is assumed. The proof that it is finite compares two bases in which the largest moving index is exchanged;
//! where that comparison fails to contradict itself it holds a vector that refutes sufficiency, and the method ends there.

use crate::control::Control;
use crate::exact::sufficiency::{self, Evidence};
use crate::pivoting::{Dictionary, Real, Var, basis};
use crate::problem::Lcp;
use crate::solution::Candidate;
use crate::status::Termination;

/// Pivots allowed when the caller gives no limit: about n are usual, the worst case is exponential.
#[must_use]
pub fn default_limit(n: usize) -> usize {
    200 + 50 * n
}

/// Solves LCP(q, A), or hands over a Farkas vector or a proof that A is not sufficient. O(n^2) a pivot.
#[must_use]
pub fn principal_pivoting<T: Real>(lcp: &Lcp, control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    let mut path = Path::<T>::new(lcp);
    let end = path.follow(control, default_limit(n));
    let alpha = path.alpha();
    let last = |termination| Candidate::point(path.point(), termination, path.pivots);
    match end {
        End::Solved => {
            let z = basis::basic_point(lcp, &alpha).unwrap_or_else(|| path.point());
            let point = Candidate::point(z, Termination::ComplementaryBasis, path.pivots);
            Candidate { alpha: Some(alpha), ..point }
        }
        End::Infeasible(k) => {
            Candidate { farkas: basis::row_multiplier(lcp, &alpha, k), ..last(Termination::Infeasible) }
        }
        End::NotSufficient(evidence) => {
            let proof = sufficiency::prove(lcp.view(), &evidence, &|| control.expired().is_some());
            let termination = match proof {
                Some(_) => Termination::NotSufficient,
                None => Termination::Breakdown("A looks insufficient, but rounding hides the proof"),
            };
            Candidate { not_sufficient: proof, ..last(termination) }
        }
        End::Stopped(reason) => last(reason),
    }
}

/// How a path ends.
enum End {
    Solved,
    /// The row of this pair is nonpositive with a negative value.
    Infeasible(usize),
    NotSufficient(Evidence),
    Stopped(Termination),
}

/// A value is negative below `-SIGN EPSILON sqrt(n) max(1, max|value|)`.
const SIGN: f64 = 256.0;
/// An entry is zero below `ZERO EPSILON` times the largest of its row and column.
const ZERO: f64 = 65_536.0;

/// A dictionary whose basis is complementary between pivots.
struct Path<T> {
    n: usize,
    dictionary: Dictionary<T>,
    /// Row of the basic variable and column of the nonbasic one of each pair.
    row: Vec<usize>,
    column: Vec<usize>,
    in_alpha: Vec<bool>,
    /// The basis in which a negative pair was last exchanged, as long as no larger index has moved since.
    seen: Vec<bool>,
    is_seen: Vec<bool>,
    pivots: usize,
}

impl<T: Real> Path<T> {
    fn new(lcp: &Lcp) -> Self {
        let n = lcp.n();
        Self {
            n,
            dictionary: Dictionary::new(lcp, &vec![0.0; n]),
            row: (0..n).collect(),
            column: (0..n).collect(),
            in_alpha: vec![false; n],
            seen: vec![false; n * n],
            is_seen: vec![false; n],
            pivots: 0,
        }
    }

    fn follow(&mut self, control: &Control<'_>, default_limit: usize) -> End {
        loop {
            if let Some(reason) = control.stop(self.pivots, default_limit) {
                return End::Stopped(reason);
            }
            let Some(k) = self.first_negative() else { return End::Solved };
            if self.is_seen[k] {
                let before = (0..self.n).filter(|&i| self.seen[k * self.n + i]).collect();
                return End::NotSufficient(Evidence::Points(before, self.alpha()));
            }
            let zero = self.zero(k);
            let diagonal = self.entry(k, k);
            if diagonal < -zero {
                return End::NotSufficient(self.direction(vec![(k, 1)], false));
            }
            self.remember(k);
            if diagonal > zero {
                self.exchange(k, k);
                self.in_alpha[k] = !self.in_alpha[k];
                self.forget_below(k);
                continue;
            }
            let Some(r) = (0..self.n).find(|&j| j != k && self.entry(k, j) > zero) else { return End::Infeasible(k) };
            if let Some(evidence) = self.second_order(k, r, zero) {
                return End::NotSufficient(evidence);
            }
            self.exchange_pairs(k, r);
        }
    }

    /// The least index with a negative value.
    fn first_negative(&self) -> Option<usize> {
        let value = |i: usize| self.dictionary.value(self.row[i]).to_f64();
        let scale = (0..self.n).map(|i| value(i).abs()).fold(1.0, f64::max);
        let noise = SIGN * T::EPSILON * (self.n as f64).sqrt() * scale;
        (0..self.n).find(|&i| value(i) < -noise)
    }

    /// Entry of the principal pivot transform in the row of pair `i` and the column of pair `j`.
    fn entry(&self, i: usize, j: usize) -> f64 {
        self.dictionary.coefficient(self.row[i], self.column[j]).to_f64()
    }

    /// What counts as zero in row and column `k`.
    fn zero(&self, k: usize) -> f64 {
        let largest = (0..self.n).map(|j| self.entry(k, j).abs().max(self.entry(j, k).abs())).fold(0.0, f64::max);
        ZERO * T::EPSILON * largest
    }

    /// With a zero diagonal entry, entries mirrored in it must have opposite signs: the first pair up to `r` that
    /// breaks this on the way of the pivot gives a vector with two nonbasic variables.
    fn second_order(&self, k: usize, r: usize, zero: f64) -> Option<Evidence> {
        for j in (0..r).filter(|&j| j != k) {
            // x_k (M x)_k = x_k M_kj <= 0 and (M x)_j = x_k M_jk + M_jj < 0 for x_j = 1, x_k large.
            if self.entry(j, k) < -zero {
                return Some(self.direction(vec![(k, multiple(self.entry(j, j), self.entry(j, k))), (j, 1)], false));
            }
        }
        let (raises, answers) = (self.entry(k, r), self.entry(r, k));
        if answers > zero {
            return Some(self.direction(vec![(k, -multiple(self.entry(r, r), answers)), (r, 1)], false));
        }
        if answers >= -zero {
            // In A' the roles of row and column k change: x_k (M'x)_k = 0, (M'x)_r = x_k M_kr + M_rr < 0.
            return Some(self.direction(vec![(k, -multiple(self.entry(r, r), raises)), (r, 1)], true));
        }
        None
    }

    /// Nonbasic variables with these values. The transform of A' is that of A transposed, with the signs of alpha changed.
    fn direction(&self, mut values: Vec<(usize, i64)>, transposed: bool) -> Evidence {
        if transposed {
            values.iter_mut().filter(|(i, _)| self.in_alpha[*i]).for_each(|(_, v)| *v = -*v);
        }
        Evidence::Direction { alpha: self.alpha(), values, transposed }
    }

    /// Both pairs are exchanged: basic k with nonbasic r, then basic r with nonbasic k.
    fn exchange_pairs(&mut self, k: usize, r: usize) {
        self.exchange(k, r);
        self.exchange(r, k);
        self.row.swap(k, r);
        self.column.swap(k, r);
        for i in [k, r] {
            self.in_alpha[i] = !self.in_alpha[i];
        }
        self.forget_below(k.max(r));
        if r > k {
            self.is_seen[r] = false;
        }
    }

    fn exchange(&mut self, i: usize, j: usize) {
        self.dictionary.exchange(self.row[i], self.column[j]);
        self.pivots += 1;
    }

    fn remember(&mut self, k: usize) {
        self.is_seen[k] = true;
        self.seen[k * self.n..(k + 1) * self.n].copy_from_slice(&self.in_alpha);
    }

    fn forget_below(&mut self, largest: usize) {
        self.is_seen[..largest].fill(false);
    }

    fn alpha(&self) -> Vec<usize> {
        (0..self.n).filter(|&i| self.in_alpha[i]).collect()
    }

    /// `z` of the basis, negative entries included.
    fn point(&self) -> Vec<f64> {
        let mut z = vec![0.0; self.n];
        for r in 0..self.n {
            if let Var::Z(i) = self.dictionary.basic(r) {
                z[i] = self.dictionary.value(r).to_f64();
            }
        }
        z
    }
}

/// A power of two that makes `t |b|` exceed `c` clearly.
fn multiple(c: f64, b: f64) -> i64 {
    let ratio = (2.0 * c / b.abs()).clamp(0.0, 2f64.powi(60));
    1 << (ratio.max(1.0).log2().ceil() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dd::Dd;

    fn run(a: &[f64], q: &[f64]) -> Candidate {
        let lcp = Lcp::new(q.len(), a.to_vec(), q.to_vec()).expect("valid");
        principal_pivoting::<f64>(&lcp, &Control::default())
    }

    #[test]
    fn exchange_pivots_solve_a_skew_symmetric_problem() {
        // PSD with a zero diagonal: every pivot exchanges two pairs.
        let found = run(&[0.0, 1.0, -1.0, 0.0], &[-1.0, 2.0]);
        assert_eq!((found.termination, found.z.as_slice()), (Termination::ComplementaryBasis, &[2.0, 1.0][..]));
        let found = run(&[0.0, -1.0, 1.0, 0.0], &[-1.0, -2.0]);
        assert_eq!(found.termination, Termination::Infeasible);
        assert!(found.farkas.expect("a row")[0] > 0.0);
    }

    #[test]
    fn a_matrix_that_is_not_sufficient_is_refuted() {
        for a in [
            [-1.0, 0.0, 0.0, 1.0], // negative diagonal
            [0.0, 1.0, 1.0, 0.0],  // mirrored entries of one sign
            [0.0, 1.0, 0.0, 1.0],  // an entry mirrored in zero
        ] {
            let found = run(&a, &[-1.0, -1.0]);
            assert_eq!(found.termination, Termination::NotSufficient, "{a:?}");
            assert!(found.not_sufficient.is_some());
        }
    }

    #[test]
    fn arithmetics_agree() {
        let lcp = Lcp::new(2, vec![2.0, 1.0, 1.0, 2.0], vec![-5.0, -6.0]).expect("valid");
        let (plain, double) =
            (principal_pivoting::<f64>(&lcp, &Control::default()), principal_pivoting::<Dd>(&lcp, &Control::default()));
        assert_eq!((plain.iterations, &plain.z), (double.iterations, &double.z));
        assert_eq!(plain.iterations, 2);
    }
}
