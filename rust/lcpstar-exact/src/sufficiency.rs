//! Proofs that a matrix is not sufficient: a vector whose products with its image are nonpositive and not all zero.
//!
//! A is column sufficient when `x_i (A x)_i <= 0` for all i implies `x_i (A x)_i = 0` for all i, row sufficient when A'
//! is column sufficient, and sufficient when both hold. [CPS92, sec. 3.5]

use super::dyadic::{RationalVec, Scaled, linear_form};
use super::padic::Block;
use crate::problem::Problem;
use num_bigint::{BigInt, Sign};
use num_traits::{One, Zero};

/// `x_i (B x)_i <= 0` for all i, `< 0` for some i, with `B = A` or, `transposed`, `B = A'`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotSufficient {
    /// The vector.
    pub x: RationalVec,
    /// Whether it refutes row sufficiency (`B = A'`) rather than column sufficiency.
    pub transposed: bool,
}

/// How a pivoting method found such a vector, in terms of complementary bases.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// The difference of the basic points of two index sets.
    Points(Vec<usize>, Vec<usize>),
    /// The pairs `(z, A z)` in which the nonbasic variables of the basis `alpha` have the given values, the others 0.
    Direction {
        /// The basis.
        alpha: Vec<usize>,
        /// Pairs of the nonbasic variables and their values.
        values: Vec<(usize, i64)>,
        /// Whether it is a direction of A'.
        transposed: bool,
    },
}

/// The exact vector of `evidence`; `None` when a block is singular, the vector proves nothing, or `stop` said so.
///
/// Cost: one or two p-adic solves of order `|alpha|` and n^2 products of long integers.
#[must_use]
pub fn prove(lcp: Problem<'_>, evidence: &Evidence, stop: &dyn Fn() -> bool) -> Option<NotSufficient> {
    let found = match evidence {
        Evidence::Points(first, second) => {
            let x = difference(&basic_point(lcp, first, stop)?, &basic_point(lcp, second, stop)?);
            NotSufficient { x, transposed: false }
        }
        Evidence::Direction { alpha, values, transposed } => {
            let x = direction(&|i, j| entry(lcp, *transposed, i, j), lcp.n(), alpha, values, stop)?;
            NotSufficient { x, transposed: *transposed }
        }
    };
    check(lcp, &found).then_some(found)
}

/// Whether `found` refutes sufficiency of A, exactly. O(n^2) operations on long integers.
#[must_use]
pub fn check(lcp: Problem<'_>, found: &NotSufficient) -> bool {
    let (n, x) = (lcp.n(), &found.x.numerators);
    let mut strict = false;
    for i in (0..n).filter(|&i| !x[i].is_zero()) {
        let image = linear_form((0..n).map(|j| (entry(lcp, found.transposed, i, j), &x[j]))).value;
        match x[i].sign() * image.sign() {
            Sign::Plus => return false,
            Sign::Minus => strict = true,
            Sign::NoSign => {}
        }
    }
    strict
}

fn entry(lcp: Problem<'_>, transposed: bool, i: usize, j: usize) -> f64 {
    if transposed { lcp.row(j)[i] } else { lcp.row(i)[j] }
}

/// `z` with `A[alpha, alpha] z_alpha = -q_alpha`, zero elsewhere.
fn basic_point(lcp: Problem<'_>, alpha: &[usize], stop: &dyn Fn() -> bool) -> Option<RationalVec> {
    let block = Block::new(alpha.len(), |i, j| lcp.row(alpha[i])[alpha[j]], stop).ok()?;
    let rhs: Vec<Scaled> = alpha.iter().map(|&i| Scaled::from_f64(-lcp.q()[i])).collect();
    let part = block.solve(&rhs, stop).ok()?;
    let mut z = RationalVec { numerators: vec![BigInt::zero(); lcp.n()], denominator: part.denominator };
    for (&i, x) in alpha.iter().zip(part.numerators) {
        z.numerators[i] = x;
    }
    Some(z)
}

/// `z` with `(B z)_i = values_i` on alpha, `z_i = values_i` outside.
fn direction(
    entry: &dyn Fn(usize, usize) -> f64,
    n: usize,
    alpha: &[usize],
    values: &[(usize, i64)],
    stop: &dyn Fn() -> bool,
) -> Option<RationalVec> {
    let (of_image, of_z): (Vec<_>, Vec<_>) =
        values.iter().map(|&(i, v)| (i, BigInt::from(v))).partition(|(i, _)| alpha.contains(i));
    let block = Block::new(alpha.len(), |i, j| entry(alpha[i], alpha[j]), stop).ok()?;
    let one = BigInt::one();
    let rhs: Vec<Scaled> = alpha
        .iter()
        .map(|&i| {
            let given = of_image.iter().find(|(j, _)| *j == i).map_or((0.0, &one), |(_, v)| (1.0, v));
            linear_form(of_z.iter().map(|(j, v)| (-entry(i, *j), v)).chain([given]))
        })
        .collect();
    let part = block.solve(&rhs, stop).ok()?;
    let mut z = RationalVec { numerators: vec![BigInt::zero(); n], denominator: part.denominator };
    for (i, v) in of_z {
        z.numerators[i] = v * &z.denominator;
    }
    for (&i, x) in alpha.iter().zip(part.numerators) {
        z.numerators[i] = x;
    }
    Some(z)
}

fn difference(a: &RationalVec, b: &RationalVec) -> RationalVec {
    let numerators = a.numerators.iter().zip(&b.numerators);
    let mut x = RationalVec {
        numerators: numerators.map(|(x, y)| x * &b.denominator - y * &a.denominator).collect(),
        denominator: &a.denominator * &b.denominator,
    };
    x.reduce();
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_refutes_and_a_sufficient_matrix_is_not_refuted() {
        let values = vec![(0, 1), (1, -1)];
        let evidence = Evidence::Direction { alpha: vec![], values, transposed: false };
        let proof =
            prove(Problem::new(&[1.0, 2.0, 2.0, 1.0], &[-1.0, -1.0]), &evidence, &|| false).expect("x = (1, -1)");
        assert_eq!(proof.x.to_f64(), [1.0, -1.0]);
        assert!(prove(Problem::new(&[2.0, 1.0, 1.0, 2.0], &[-1.0, -1.0]), &evidence, &|| false).is_none());
    }

    #[test]
    fn the_transpose_is_another_question() {
        // x_2 (A'x)_2 = x_2 x_1, x_1 (A'x)_1 = 0: not row sufficient; column sufficient it is not, either, by x_1 x_2.
        let problem = Problem::new(&[0.0, 1.0, 0.0, 0.0], &[-1.0, -1.0]);
        for transposed in [false, true] {
            let evidence = Evidence::Direction { alpha: vec![], values: vec![(0, -1), (1, 1)], transposed };
            assert!(prove(problem, &evidence, &|| false).is_some_and(|proof| proof.transposed == transposed));
        }
    }

    #[test]
    fn directions_of_a_transformed_basis_solve_the_block() {
        // alpha = {0}: (A z)_0 = 2 and z_1 = 1 for A = [[2, 1], [1, 3]] give z_0 = 1/2.
        let problem = Problem::new(&[2.0, 1.0, 1.0, 3.0], &[-1.0, -1.0]);
        let entry = |i: usize, j: usize| problem.row(i)[j];
        let z = direction(&entry, 2, &[0], &[(0, 2), (1, 1)], &|| false).expect("nonsingular");
        assert_eq!(z.to_f64(), [0.5, 1.0]);
    }
}
