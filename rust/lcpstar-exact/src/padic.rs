//! Exact solution of square systems by p-adic (Dixon) lifting.
//!
//! `K x = b` is scaled by powers of two to integers `K' x' = b'`. One factorisation modulo a word-size prime gives
//! the digits of `x'` in base p, one solve and one exact residual a digit, and the rational numbers are recovered
//! from enough digits. Cost: k^3/3 word operations for the factors, about 4 k^2 for each of the (2 log det K') / 59
//! digits. [Dixon, Numer. Math. 40 (1982)]

use super::dyadic::Dyadic;
use super::modular::{ModularLu, PRIMES, Prime, independent};

/// Bits of one limb of a matrix entry or residual. A 53-bit mantissa at any offset touches two limbs, and
/// 2^15 products of a limb and a digit fit in an `i128`.
pub(super) const LIMB: u32 = 52;
pub(super) const LIMB_MASK: i128 = (1 << LIMB) - 1;

/// Bits kept beyond the expected length of the numerators, for a factor of the denominator that a combination lost.
pub(super) const SLACK: u64 = 96;

/// Why there is no solution to hand over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsolved {
    /// Singular modulo a 59-bit prime, hence singular but for a chance of about k 2^-59.
    Singular,
    /// `stop` said so.
    Interrupted,
}

/// One limb of every entry, compressed by rows.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    pub(super) start: Vec<usize>,
    pub(super) column: Vec<u32>,
    pub(super) value: Vec<i64>,
}

/// A nonsingular square matrix of doubles, scaled to integers and factored modulo a prime.
#[derive(Clone, Debug)]
pub struct Block {
    pub(super) order: usize,
    pub(super) row_exponent: Vec<i64>,
    pub(super) column_exponent: Vec<i64>,
    pub(super) planes: Vec<Plane>,
    /// log2 of the largest entry, and of Hadamard's bound of the determinant.
    pub(super) entry_bits: u64,
    pub(super) determinant_bits: u64,
    pub(super) prime: Prime,
    pub(super) lu: ModularLu,
}

impl Block {
    /// Scales and factors the matrix with the given entries.
    ///
    /// # Errors
    /// `Singular`, or `Interrupted` when `stop` says so before a column is eliminated.
    pub fn new(order: usize, entry: impl Fn(usize, usize) -> f64, stop: &dyn Fn() -> bool) -> Result<Self, Unsolved> {
        let entries: Vec<Dyadic> = (0..order * order).map(|ij| Dyadic::new(entry(ij / order, ij % order))).collect();
        let (row_exponent, column_exponent) = integer_scaling(order, order, &entries);
        let shift = |i: usize, j: usize| {
            (i64::from(entries[i * order + j].exponent) + row_exponent[i] + column_exponent[j]) as u64
        };
        let prime = PRIMES[0];
        let residues =
            (0..order * order).map(|ij| residue(prime, entries[ij], shift(ij / order, ij % order))).collect();
        let unsolved = || if stop() { Unsolved::Interrupted } else { Unsolved::Singular };
        let lu = ModularLu::new(prime, order, residues, stop).ok_or_else(unsolved)?;
        let mut row_bits = vec![0; order];
        for i in 0..order {
            for j in 0..order {
                let e = entries[i * order + j];
                if !e.is_zero() {
                    row_bits[i] = row_bits[i].max(i64::from(e.magnitude()) + row_exponent[i] + column_exponent[j]);
                }
            }
        }
        let log_order = u64::from(usize::BITS - order.leading_zeros());
        let entry_bits = row_bits.iter().copied().max().unwrap_or(0) as u64;
        let determinant_bits = row_bits.iter().map(|&b| b as u64 + log_order.div_ceil(2)).sum();
        let planes = planes(order, entry_bits, &entries, shift);
        Ok(Self { order, row_exponent, column_exponent, planes, entry_bits, determinant_bits, prime, lu })
    }
}

/// Exponents `(r, c)` that make every `2^(r_i + c_j) a_ij` an integer, after balancing the magnitudes so that few
/// bits are spent on spread.
fn integer_scaling(m: usize, n: usize, entries: &[Dyadic]) -> (Vec<i64>, Vec<i64>) {
    let (mut r, mut c) = (vec![0i64; m], vec![0i64; n]);
    let nonzero = |i: usize, j: usize| Some(entries[i * n + j]).filter(|e| !e.is_zero());
    let magnitude = |i, j| nonzero(i, j).map(|e| i64::from(e.magnitude()));
    for _ in 0..4 {
        for i in 0..m {
            r[i] = -middle((0..n).filter_map(|j| magnitude(i, j).map(|x| x + c[j])));
        }
        for j in 0..n {
            c[j] = -middle((0..m).filter_map(|i| magnitude(i, j).map(|x| x + r[i])));
        }
    }
    let lowest = |i: usize, j: usize| nonzero(i, j).map(|e| i64::from(e.exponent));
    for i in 0..m {
        r[i] = -(0..n).filter_map(|j| lowest(i, j).map(|x| x + c[j])).min().unwrap_or(0);
    }
    for j in 0..n {
        c[j] -= (0..m).filter_map(|i| lowest(i, j).map(|x| x + r[i] + c[j])).min().unwrap_or(0);
    }
    (r, c)
}

/// The largest value weighs as much as all others: rows end near the same maximum without being ruled by it.
fn middle(values: impl Iterator<Item = i64>) -> i64 {
    values.max().unwrap_or(0)
}

fn residue(prime: Prime, entry: Dyadic, shift: u64) -> u64 {
    let mantissa = prime.reduce_signed(i128::from(entry.mantissa));
    if mantissa == 0 { 0 } else { prime.mul(mantissa, prime.pow(2, shift)) }
}

fn planes(order: usize, entry_bits: u64, entries: &[Dyadic], shift: impl Fn(usize, usize) -> u64) -> Vec<Plane> {
    let count = entry_bits as usize / LIMB as usize + 1;
    let mut planes = vec![Plane { start: vec![0], column: Vec::new(), value: Vec::new() }; count];
    for i in 0..order {
        for j in 0..order {
            let entry = entries[i * order + j];
            if entry.is_zero() {
                continue;
            }
            let shift = shift(i, j);
            let limb = (shift / u64::from(LIMB)) as usize;
            let spread = i128::from(entry.mantissa.unsigned_abs()) << (shift % u64::from(LIMB));
            let sign = entry.mantissa.signum();
            for (l, part) in [(limb, spread & LIMB_MASK), (limb + 1, spread >> LIMB)] {
                if part != 0 {
                    planes[l].column.push(j as u32);
                    planes[l].value.push(sign * part as i64);
                }
            }
        }
        for plane in &mut planes {
            plane.start.push(plane.column.len());
        }
    }
    planes
}

/// Rows and columns of a nonsingular submatrix of full rank of the `m x n` matrix of doubles, columns in the given
/// order of preference. True independence is certain; full rank but for a chance of about `m 2^-59`.
#[must_use]
pub fn independent_rows_and_columns(
    m: usize,
    n: usize,
    entry: impl Fn(usize, usize) -> f64,
    preference: &[usize],
    stop: &dyn Fn() -> bool,
) -> (Vec<usize>, Vec<usize>) {
    let entries: Vec<Dyadic> = (0..m * n).map(|ij| Dyadic::new(entry(ij / n, ij % n))).collect();
    let (r, c) = integer_scaling(m, n, &entries);
    let residues = (0..m * n)
        .map(|ij| residue(PRIMES[0], entries[ij], (i64::from(entries[ij].exponent) + r[ij / n] + c[ij % n]) as u64))
        .collect();
    independent(PRIMES[0], n, residues, preference, stop)
}

#[cfg(test)]
mod tests {
    use super::super::dyadic::{Scaled, linear_form};
    use super::*;
    use num_bigint::BigInt;
    use num_traits::Zero;

    fn xorshift(state: &mut u64) -> f64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    fn check(n: usize, a: &[f64], b: &[f64]) {
        let block = Block::new(n, |i, j| a[i * n + j], &|| false).expect("nonsingular");
        let rhs: Vec<Scaled> = b.iter().map(|&x| Scaled::from_f64(x)).collect();
        let x = block.solve(&rhs, &|| false).expect("not interrupted");
        for i in 0..n {
            let terms = (0..n).map(|j| (a[i * n + j], &x.numerators[j])).chain([(-b[i], &x.denominator)]);
            assert!(linear_form(terms).value.is_zero(), "row {i} of {n}");
        }
    }

    #[test]
    fn random_systems_are_solved_exactly() {
        let mut state = 1;
        for n in [0, 1, 2, 3, 5, 8, 13, 40, 70] {
            let a: Vec<f64> = (0..n * n).map(|_| xorshift(&mut state)).collect();
            let b: Vec<f64> = (0..n).map(|_| xorshift(&mut state)).collect();
            check(n, &a, &b);
        }
    }

    #[test]
    fn rows_and_columns_of_all_sizes_are_solved_exactly() {
        let mut state = 7;
        for n in [2, 6, 17] {
            let scale = |i: usize| 2f64.powi((i as i32 * 37) % 160 - 80) * 1.7;
            let a: Vec<f64> = (0..n * n).map(|ij| xorshift(&mut state) * scale(ij / n) * scale(ij % n + 3)).collect();
            let b: Vec<f64> = (0..n).map(|i| xorshift(&mut state) * scale(2 * i)).collect();
            check(n, &a, &b);
        }
        check(2, &[1e-300, 1e300, 1e300, 3e-300], &[1e-300, 1e300]);
        check(1, &[5e-324], &[f64::MAX]);
        check(3, &[1.0, 2.0, 0.0, 0.0, -1.0, 4.0, 1.0, 0.0, 1.0], &[0.0, -8.0, 2.0]);
    }

    /// Weights of the combination are no random numbers: that of indices 0, 1, 2 is the one of 3, and (1, 1, 1, -1) sums to 0.
    #[test]
    fn a_combination_that_vanishes_ends() {
        let unit = |n: usize| (0..n * n).map(|k| f64::from(u8::from(k / n == k % n))).collect::<Vec<_>>();
        for code in 0..3usize.pow(5) {
            let b: Vec<f64> = (0..5).map(|i| (code / 3usize.pow(i) % 3) as f64 - 1.0).collect();
            check(5, &unit(5), &b);
        }
        let block = [0.25, 0.0, 0.0, 1.0, 0.0, 0.25, 0.0, 1.0, 0.0, 0.0, 0.25, 1.0, 0.0, 0.0, 0.0, 1.0];
        check(4, &block, &[0.0, 0.0, 0.0, -0.25]);
    }

    /// x = 7 p^6 + 5 looks like 5 in its first digits.
    #[test]
    fn a_guess_from_too_few_digits_is_not_taken() {
        let block = Block::new(1, |_, _| 1.0, &|| false).expect("nonsingular");
        let value: BigInt = BigInt::from(block.prime.value()).pow(6) * 7u32 + 5u32;
        let x = block.solve(&[Scaled { value: value.clone(), exponent: 0 }], &|| false).expect("not interrupted");
        assert_eq!(x.numerators[0], value * &x.denominator);
    }

    #[test]
    fn a_singular_block_is_called_singular() {
        assert_eq!(Block::new(2, |_, _| 0.1, &|| false).err(), Some(Unsolved::Singular));
    }

    #[test]
    fn an_interrupt_is_obeyed() {
        let block = Block::new(1, |_, _| 3.0, &|| false).expect("nonsingular");
        assert_eq!(block.solve(&[Scaled::from_f64(1.0)], &|| true).err(), Some(Unsolved::Interrupted));
    }
}
