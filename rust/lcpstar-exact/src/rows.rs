//! Linear equations with double coefficients and more unknowns or rows than rank, solved next to a given point.

use super::dyadic::{RationalVec, Scaled, linear_form};
use super::padic::{Block, Unsolved, independent_rows_and_columns};
use num_bigint::BigInt;

/// Entries below these fractions of the largest are taken for zeros, one after the other.
pub(super) const GUESSES: [f64; 5] = [1e-14, 1e-12, 1e-10, 1e-8, 1e-6];

/// Linear equations `sum_j entry(i, j) v_j = rhs(i)` with double coefficients.
pub(super) struct Rows<'a> {
    pub(super) count: usize,
    pub(super) entry: &'a dyn Fn(usize, usize) -> f64,
    pub(super) rhs: &'a dyn Fn(usize) -> f64,
}

impl Rows<'_> {
    /// The exact solution of a maximal independent subset of the rows next to `v`: basic variables, taken among the
    /// largest entries, are solved for, the others keep their values. Also the rank.
    pub(super) fn point_near(&self, v: &[f64], stop: &dyn Fn() -> bool) -> Result<(RationalVec, usize), Unsolved> {
        let n = v.len();
        let mut preference: Vec<usize> = (0..n).collect();
        preference.sort_by(|&i, &j| v[j].total_cmp(&v[i]));
        let (rows, columns) = independent_rows_and_columns(self.count, n, self.entry, &preference, stop);
        if stop() {
            return Err(Unsolved::Interrupted);
        }
        let rank = rows.len();
        let mut basic = vec![false; n];
        for &j in &columns {
            basic[j] = true;
        }
        let fixed: Vec<f64> = (0..n).map(|j| if basic[j] { 0.0 } else { v[j] }).collect();
        let fixed = RationalVec::from_f64(&fixed);
        // The denominator is a power of two.
        let scale = fixed.denominator.bits() as i64 - 1;
        let rhs: Vec<Scaled> = rows
            .iter()
            .map(|&i| {
                let terms = (0..n).map(|j| (-(self.entry)(i, j), &fixed.numerators[j]));
                let sum = linear_form(terms.chain(std::iter::once(((self.rhs)(i), &fixed.denominator))));
                Scaled { value: sum.value, exponent: sum.exponent - scale }
            })
            .collect();
        let block = Block::new(rank, |i, j| (self.entry)(rows[i], columns[j]), stop)?;
        let solved = block.solve(&rhs, stop)?;
        let numerators: Vec<BigInt> = fixed.numerators.iter().map(|x| x * &solved.denominator).collect();
        let mut out = RationalVec { numerators, denominator: &fixed.denominator * &solved.denominator };
        for (&j, x) in columns.iter().zip(&solved.numerators) {
            out.numerators[j] = x * &fixed.denominator;
        }
        Ok((out, rank))
    }
}
