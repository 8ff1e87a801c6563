//! Proofs on the given binary numbers: a solution from its support.
//!
//! Nothing here trusts floating point: it proposes supports and filters signs under a rigorous error bound, and
//! what it cannot decide is decided in integers.

use super::dyadic::{RationalVec, Scaled, linear_form};
use super::padic::{Block, Unsolved};
use super::rows::Rows;
use crate::problem::Problem;
use num_bigint::BigInt;
use num_traits::{Signed, Zero};
use std::cmp::Ordering;

/// A point proved to solve LCP(q, A); made in this crate alone.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ExactSolution {
    /// The index set whose rows were solved: `w_alpha = 0`, `z_i = 0` outside.
    pub alpha: Vec<usize>,
    /// The solution.
    pub z: RationalVec,
}

impl ExactSolution {
    /// `w = A z + q`, exactly.
    #[must_use]
    pub fn w(&self, lcp: Problem<'_>) -> RationalVec {
        exact_w(lcp, &self.z)
    }
}

/// What came of an attempt to prove a solution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProofOutcome {
    /// Proved.
    Proved(ExactSolution),
    /// `z_i < 0` at the basic point of `alpha`.
    NegativeZ(usize),
    /// `w_i < 0` at the basic point of `alpha`.
    NegativeW(usize),
    /// `A[alpha, alpha]` has this rank modulo a large prime, and the basic point of that rank does not solve the
    /// rows of `alpha`.
    Singular {
        /// Rank found.
        rank: usize,
    },
    /// `stop` said so.
    Interrupted,
}

/// Proves or refutes that the complementary basis `alpha` solves LCP(q, A): `A[alpha, alpha] z_alpha = -q_alpha`
/// exactly, then the sign of every `z_i` and `w_i`.
///
/// A singular block is replaced by a nonsingular submatrix of full rank; its basic point is accepted only when all
/// rows of `alpha` hold. Cost: one p-adic solve of order `|alpha|`, then `n |alpha|` flops and an exact sum for each
/// row that they cannot decide.
#[must_use]
pub fn prove_solution(lcp: Problem<'_>, alpha: &[usize], stop: &dyn Fn() -> bool) -> ProofOutcome {
    let block = Block::new(alpha.len(), |i, j| lcp.row(alpha[i])[alpha[j]], stop);
    let rhs: Vec<Scaled> = alpha.iter().map(|&i| Scaled::from_f64(-lcp.q()[i])).collect();
    match block.and_then(|block| block.solve(&rhs, stop)) {
        Ok(part) => conclude(lcp, alpha, spread(lcp.n(), alpha, part), true),
        Err(Unsolved::Interrupted) => ProofOutcome::Interrupted,
        Err(Unsolved::Singular) => prove_singular(lcp, alpha, stop),
    }
}

fn prove_singular(lcp: Problem<'_>, alpha: &[usize], stop: &dyn Fn() -> bool) -> ProofOutcome {
    let k = alpha.len();
    let values = vec![0.0; k];
    let rows = Rows { count: k, entry: &|i, j| lcp.row(alpha[i])[alpha[j]], rhs: &|i| -lcp.q()[alpha[i]] };
    match rows.point_near(&values, stop) {
        Ok((part, rank)) => match conclude(lcp, alpha, spread(lcp.n(), alpha, part), false) {
            ProofOutcome::Singular { .. } => ProofOutcome::Singular { rank },
            outcome => outcome,
        },
        Err(Unsolved::Interrupted) => ProofOutcome::Interrupted,
        Err(Unsolved::Singular) => ProofOutcome::Singular { rank: 0 },
    }
}

fn conclude(lcp: Problem<'_>, alpha: &[usize], z: RationalVec, rows_hold: bool) -> ProofOutcome {
    if let Some(i) = z.numerators.iter().position(Signed::is_negative) {
        return ProofOutcome::NegativeZ(i);
    }
    let mut in_alpha = vec![false; lcp.n()];
    for &i in alpha {
        in_alpha[i] = true;
    }
    let signs = WSigns::new(lcp, &z);
    for i in 0..lcp.n() {
        if in_alpha[i] && rows_hold {
            continue;
        }
        match (signs.sign(i), in_alpha[i]) {
            (Ordering::Equal, _) | (Ordering::Greater, false) => {}
            (_, true) => return ProofOutcome::Singular { rank: 0 },
            (Ordering::Less, false) => return ProofOutcome::NegativeW(i),
        }
    }
    ProofOutcome::Proved(ExactSolution { alpha: alpha.to_vec(), z })
}

/// Whether `z` solves LCP(q, A) exactly.
#[must_use]
pub fn check_solution(lcp: Problem<'_>, z: &RationalVec) -> bool {
    let signs = WSigns::new(lcp, z);
    z.len() == lcp.n()
        && (0..lcp.n()).all(|i| {
            let z_sign = z.numerators[i].sign();
            match signs.sign(i) {
                Ordering::Less => false,
                Ordering::Equal => z_sign != num_bigint::Sign::Minus,
                Ordering::Greater => z_sign == num_bigint::Sign::NoSign,
            }
        })
}

fn exact_w(lcp: Problem<'_>, z: &RationalVec) -> RationalVec {
    let w = (0..lcp.n()).map(|i| exact_row(lcp, i, z)).collect();
    RationalVec::from_scaled(w, z.denominator.clone())
}

fn exact_row(lcp: Problem<'_>, i: usize, z: &RationalVec) -> Scaled {
    let terms = lcp.row(i).iter().copied().zip(&z.numerators);
    linear_form(terms.chain(std::iter::once((lcp.q()[i], &z.denominator))))
}

/// Signs of `(A z + q)_i`: doubles under an error bound, integers where that does not decide.
struct WSigns<'a> {
    lcp: Problem<'a>,
    z: &'a RationalVec,
    rounded: Vec<f64>,
    faithful: bool,
}

impl<'a> WSigns<'a> {
    fn new(lcp: Problem<'a>, z: &'a RationalVec) -> Self {
        let rounded = z.to_f64();
        let faithful = rounded.iter().zip(&z.numerators).all(|(x, v)| x.is_normal() || v.is_zero());
        Self { lcp, z, rounded, faithful }
    }

    fn sign(&self, i: usize) -> Ordering {
        if self.faithful {
            let (mut sum, mut magnitude) = (self.lcp.q()[i], self.lcp.q()[i].abs());
            for (a, z) in self.lcp.row(i).iter().zip(&self.rounded) {
                sum += a * z;
                magnitude += (a * z).abs();
            }
            // n + 1 additions, products and rounded z: (n + 4) eps covers them twice over; underflow apart.
            let n = self.rounded.len() as f64;
            let bound = magnitude * ((n + 8.0) * f64::EPSILON) + (n + 1.0) * f64::MIN_POSITIVE;
            if sum.abs() > bound && magnitude.is_finite() {
                return sum.total_cmp(&0.0);
            }
        }
        exact_row(self.lcp, i, self.z).value.cmp(&BigInt::zero())
    }
}

/// `part` on `alpha`, zero elsewhere.
pub(super) fn spread(n: usize, alpha: &[usize], part: RationalVec) -> RationalVec {
    let mut numerators = vec![BigInt::zero(); n];
    for (&i, x) in alpha.iter().zip(part.numerators) {
        numerators[i] = x;
    }
    RationalVec { numerators, denominator: part.denominator }
}

#[cfg(test)]
#[allow(clippy::panic)] // a test says what it found
mod tests {
    use super::*;
    use num_rational::BigRational;

    fn never() -> bool {
        false
    }

    /// Gauss elimination in fractions: the basic point of alpha, or None when the block is singular.
    fn brute_basic_point(lcp: Problem<'_>, alpha: &[usize]) -> Option<Vec<BigRational>> {
        let k = alpha.len();
        let number = |x: f64| BigRational::from_float(x).expect("finite");
        let mut t: Vec<Vec<BigRational>> = alpha
            .iter()
            .map(|&i| alpha.iter().map(|&j| number(lcp.row(i)[j])).chain([number(-lcp.q()[i])]).collect())
            .collect();
        for c in 0..k {
            let p = (c..k).find(|&r| !t[r][c].is_zero())?;
            t.swap(c, p);
            for r in 0..k {
                if r != c && !t[r][c].is_zero() {
                    let f = &t[r][c] / &t[c][c];
                    for j in c..=k {
                        let s = &f * &t[c][j];
                        t[r][j] -= s;
                    }
                }
            }
        }
        let mut z = vec![BigRational::zero(); lcp.n()];
        for (r, &i) in alpha.iter().enumerate() {
            z[i] = &t[r][k] / &t[r][r];
        }
        Some(z)
    }

    fn brute_w(lcp: Problem<'_>, z: &[BigRational], i: usize) -> BigRational {
        let number = |x: f64| BigRational::from_float(x).expect("finite");
        lcp.row(i).iter().zip(z).fold(number(lcp.q()[i]), |s, (&a, z)| s + number(a) * z)
    }

    #[test]
    fn verdicts_agree_with_fractions_on_all_bases_of_small_integer_problems() {
        let mut rng = fastrand::Rng::with_seed(12345);
        let mut draw = |m: u32| f64::from(rng.u32(..m));
        let mut proved = 0;
        for _ in 0..150 {
            let n = 4;
            let a: Vec<f64> = (0..n * n).map(|_| draw(5) - 2.0).collect();
            let q: Vec<f64> = (0..n).map(|_| draw(5) - 3.0).collect();
            let problem = Problem::new(&a, &q);
            for mask in 0..1usize << n {
                let alpha: Vec<usize> = (0..n).filter(|i| mask >> i & 1 == 1).collect();
                let outcome = prove_solution(problem, &alpha, &never);
                let Some(z) = brute_basic_point(problem, &alpha) else {
                    if let ProofOutcome::Proved(s) = &outcome {
                        assert!(check_solution(problem, &s.z));
                    }
                    continue;
                };
                let solves =
                    z.iter().all(|x| !x.is_negative()) && (0..n).all(|i| !brute_w(problem, &z, i).is_negative());
                match outcome {
                    ProofOutcome::Proved(s) => {
                        assert!(solves && check_solution(problem, &s.z));
                        for i in 0..n {
                            let exact = BigRational::new(s.z.numerators[i].clone(), s.z.denominator.clone());
                            assert_eq!(exact, z[i]);
                        }
                        proved += 1;
                    }
                    ProofOutcome::NegativeZ(i) => assert!(z[i].is_negative()),
                    ProofOutcome::NegativeW(i) => assert!(brute_w(problem, &z, i).is_negative()),
                    other => panic!("{other:?}"),
                }
            }
        }
        assert!(proved > 50, "{proved}");
    }

    #[test]
    fn each_statement_about_a_solution_is_checked() {
        let check = |a: f64, q: f64, z: &[f64]| check_solution(Problem::new(&[a], &[q]), &RationalVec::from_f64(z));
        assert!(check(1.0, -1.0, &[1.0]) && check(1.0, 1.0, &[0.0]) && check(0.0, 0.0, &[1.0]));
        assert!(!check(1.0, -1.0, &[0.0]), "w < 0");
        assert!(!check(0.0, 0.0, &[-1.0]), "z < 0 = w");
        assert!(!check(0.0, 1.0, &[-1.0]), "z < 0 < w");
        assert!(!check(0.0, 1.0, &[1.0]), "z w > 0");
        assert!(!check(1.0, -1.0, &[1.0, 0.0]), "two entries");
    }

    #[test]
    fn a_tie_that_rounding_hides_is_decided() {
        // w_2 = 1 - 3 z_1 with z_1 = fl(1/3) solves exactly 1 - 3 fl(1/3) = 2^-54 > 0, and -2^-54 with the signs swapped.
        let third = 1.0 / 3.0;
        let (up, down) = ([-third, 1.0], [-third, -1.0]);
        let up = Problem::new(&[1.0, 0.0, -3.0, 1.0], &up);
        assert!(matches!(prove_solution(up, &[0], &never), ProofOutcome::Proved(_)));
        let down = Problem::new(&[1.0, 0.0, 3.0, 1.0], &down);
        assert_eq!(prove_solution(down, &[0], &never), ProofOutcome::NegativeW(1));
    }

    #[test]
    fn a_singular_block_with_a_consistent_system_is_proved() {
        let p = Problem::new(&[1.0, 1.0, 1.0, 1.0], &[-1.0, -1.0]);
        assert!(matches!(prove_solution(p, &[0, 1], &never), ProofOutcome::Proved(_)));
        let bad = Problem::new(&[1.0, 1.0, 1.0, 1.0], &[-1.0, -2.0]);
        assert_eq!(prove_solution(bad, &[0, 1], &never), ProofOutcome::Singular { rank: 1 });
    }
}
