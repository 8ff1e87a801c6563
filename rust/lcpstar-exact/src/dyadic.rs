//! Doubles as what they are, binary rationals; exact sums of products; rational vectors over one denominator.

use num_bigint::{BigInt, Sign};
use num_integer::Integer;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// `mantissa * 2^exponent` with an odd mantissa, or zero with both fields zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dyadic {
    /// Odd, or zero; at most 53 bits.
    pub mantissa: i64,
    /// Power of two.
    pub exponent: i32,
}

impl Dyadic {
    /// The finite double `x`, without rounding.
    #[must_use]
    pub fn new(x: f64) -> Self {
        debug_assert!(x.is_finite());
        let bits = x.to_bits();
        let biased = ((bits >> 52) & 0x7ff) as i32;
        let fraction = bits & ((1 << 52) - 1);
        let (magnitude, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | (1 << 52), biased - 1075) };
        if magnitude == 0 {
            return Self { mantissa: 0, exponent: 0 };
        }
        let shift = magnitude.trailing_zeros();
        let mantissa = (magnitude >> shift) as i64;
        Self { mantissa: if x < 0.0 { -mantissa } else { mantissa }, exponent: exponent + shift as i32 }
    }

    /// Whether it is zero.
    #[must_use]
    pub fn is_zero(self) -> bool {
        self.mantissa == 0
    }

    /// `floor(log2 |x|) + 1` for `x != 0`.
    #[must_use]
    pub fn magnitude(self) -> i32 {
        64 - self.mantissa.unsigned_abs().leading_zeros() as i32 + self.exponent
    }
}

/// The exact number `value * 2^exponent`.
#[derive(Clone, Debug)]
pub struct Scaled {
    /// Integer part.
    pub value: BigInt,
    /// Power of two.
    pub exponent: i64,
}

impl Scaled {
    /// A double.
    #[must_use]
    pub fn from_f64(x: f64) -> Self {
        let d = Dyadic::new(x);
        Self { value: BigInt::from(d.mantissa), exponent: i64::from(d.exponent) }
    }

    /// The same number with a smaller or equal exponent.
    pub fn lower_to(&mut self, exponent: i64) {
        if self.exponent > exponent {
            self.value <<= self.exponent - exponent;
        }
        self.exponent = self.exponent.min(exponent);
    }
}

/// `sum c_j v_j` over the pairs, exactly.
pub fn linear_form<'a>(terms: impl Iterator<Item = (f64, &'a BigInt)> + Clone) -> Scaled {
    let exponent = terms
        .clone()
        .filter(|(c, v)| *c != 0.0 && !v.is_zero())
        .map(|(c, _)| Dyadic::new(c).exponent)
        .min()
        .unwrap_or(0);
    let mut value = BigInt::zero();
    for (c, v) in terms {
        if c != 0.0 && !v.is_zero() {
            let d = Dyadic::new(c);
            value += (v * d.mantissa) << (d.exponent - exponent);
        }
    }
    Scaled { value, exponent: i64::from(exponent) }
}

/// `numerators[j] / denominator`, `denominator > 0`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RationalVec {
    /// One integer an entry.
    pub numerators: Vec<BigInt>,
    /// Common and positive; not necessarily in lowest terms.
    pub denominator: BigInt,
}

impl RationalVec {
    /// The doubles `v`, without rounding.
    #[must_use]
    pub fn from_f64(v: &[f64]) -> Self {
        Self::from_scaled(v.iter().map(|&x| Scaled::from_f64(x)).collect(), BigInt::one())
    }

    /// `v_j / denominator` for exact `v_j`.
    #[must_use]
    pub fn from_scaled(mut v: Vec<Scaled>, mut denominator: BigInt) -> Self {
        let lowest = v.iter().filter(|x| !x.value.is_zero()).map(|x| x.exponent).min().unwrap_or(0);
        for x in &mut v {
            if !x.value.is_zero() {
                x.lower_to(lowest);
            }
        }
        let mut numerators: Vec<BigInt> = v.into_iter().map(|x| x.value).collect();
        if lowest < 0 {
            denominator <<= -lowest;
        } else if lowest > 0 {
            for x in &mut numerators {
                *x <<= lowest;
            }
        }
        if denominator.is_negative() {
            denominator = -denominator;
            for x in &mut numerators {
                *x = -std::mem::take(x);
            }
        }
        let mut out = Self { numerators, denominator };
        out.cancel_twos();
        out
    }

    /// Powers of two come from scaling: they are removed cheaply, other common factors are left.
    fn cancel_twos(&mut self) {
        let common = self
            .numerators
            .iter()
            .chain(std::iter::once(&self.denominator))
            .filter_map(BigInt::trailing_zeros)
            .min()
            .unwrap_or(0);
        if common > 0 {
            for x in &mut self.numerators {
                *x >>= common;
            }
            self.denominator >>= common;
        }
    }

    /// Divides numerators and denominator by their greatest common divisor.
    pub fn reduce(&mut self) {
        let mut gcd = self.denominator.clone();
        for x in &self.numerators {
            if gcd.is_one() {
                return;
            }
            gcd = gcd.gcd(x);
        }
        if !gcd.is_one() {
            for x in &mut self.numerators {
                *x /= &gcd;
            }
            self.denominator /= &gcd;
        }
    }

    /// Entry j times `2^exponents[j]`: back from an equilibrated problem.
    #[must_use]
    pub fn times_powers_of_two(&self, exponents: &[i32]) -> Self {
        let shifted = self.numerators.iter().zip(exponents);
        let entries = shifted.map(|(x, &e)| Scaled { value: x.clone(), exponent: i64::from(e) }).collect();
        Self::from_scaled(entries, self.denominator.clone())
    }

    /// Entries.
    #[must_use]
    pub fn len(&self) -> usize {
        self.numerators.len()
    }

    /// Whether there are no entries.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.numerators.is_empty()
    }

    /// The nearest doubles (to within one unit in the last place; out of range becomes infinite or zero).
    #[must_use]
    pub fn to_f64(&self) -> Vec<f64> {
        self.numerators.iter().map(|x| ratio_to_f64(x, &self.denominator)).collect()
    }

    /// As [`Self::to_f64`] times a power of two that brings the largest entry near 1: for a direction or a multiplier,
    /// whose factor is free.
    #[must_use]
    pub fn direction_to_f64(&self) -> Vec<f64> {
        let largest = self.numerators.iter().map(BigInt::bits).max().unwrap_or(0);
        let shift = self.denominator.bits() as i64 - largest as i64;
        if shift.abs() < 512 {
            return self.to_f64();
        }
        let (up, down) = (shift.max(0), (-shift).max(0));
        let denominator = &self.denominator << down;
        self.numerators.iter().map(|x| ratio_to_f64(&(x << up), &denominator)).collect()
    }

    /// Entries that are not zero.
    #[must_use]
    pub fn support(&self) -> Vec<usize> {
        (0..self.len()).filter(|&j| !self.numerators[j].is_zero()).collect()
    }
}

/// `numerator / denominator` rounded to nearest through a quotient of at least 66 bits with a sticky bit.
#[must_use]
pub fn ratio_to_f64(numerator: &BigInt, denominator: &BigInt) -> f64 {
    if numerator.is_zero() {
        return 0.0;
    }
    let shift = 66 + denominator.bits() as i64 - numerator.bits() as i64;
    let (top, bottom) = if shift >= 0 {
        (numerator.magnitude() << shift, denominator.magnitude().clone())
    } else {
        (numerator.magnitude().clone(), denominator.magnitude() << -shift)
    };
    let (quotient, remainder) = top.div_rem(&bottom);
    let mut q = quotient.to_u128().unwrap_or(u128::MAX);
    if !remainder.is_zero() {
        q |= 1;
    }
    let negative = (numerator.sign() == Sign::Minus) != (denominator.sign() == Sign::Minus);
    let magnitude = scale_by_power(q as f64, -shift);
    if negative { -magnitude } else { magnitude }
}

/// `x * 2^e`, in steps that neither overflow nor lose bits early.
fn scale_by_power(mut x: f64, mut e: i64) -> f64 {
    while e > 1000 && x.is_finite() {
        x *= 2f64.powi(1000);
        e -= 1000;
    }
    while e < -900 && x != 0.0 {
        // Down to the normal range first: only the last multiplication may round into the subnormals.
        let step = if e < -1900 { 900 } else { (-e).min(900) };
        x *= 2f64.powi(-(step as i32));
        e += step;
    }
    x * 2f64.powi(e as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_double_is_taken_apart_exactly() {
        for x in [0.0, -0.0, 1.0, -3.5, 0.1, f64::MAX, f64::MIN_POSITIVE, 5e-324, -1e-310] {
            let d = Dyadic::new(x);
            assert!(d.mantissa == 0 || d.mantissa % 2 != 0);
            let v = RationalVec::from_f64(&[x]);
            assert_eq!(v.to_f64()[0], x);
            if x != 0.0 {
                assert!(2f64.powi(d.magnitude() - 1) <= x.abs(), "{x}");
            }
        }
    }

    #[test]
    fn thirds_round_to_nearest() {
        for (p, q) in [(1, 3), (-2, 3), (10, 7), (1_000_003, 17)] {
            assert_eq!(ratio_to_f64(&BigInt::from(p), &BigInt::from(q)), f64::from(p) / f64::from(q));
        }
    }

    #[test]
    fn powers_of_two_are_carried_exactly() {
        let v = RationalVec { numerators: vec![BigInt::from(1), BigInt::from(-2)], denominator: BigInt::from(3) };
        assert_eq!(v.times_powers_of_two(&[3, -1]).to_f64(), [8.0 / 3.0, -1.0 / 3.0]);
    }

    #[test]
    fn a_sum_that_cancels_in_floating_point_is_exact() {
        let v = RationalVec::from_f64(&[1e16, 1.0, 1e16]);
        let s = linear_form([1.0, 1.0, -1.0].into_iter().zip(&v.numerators));
        assert_eq!(s.value << s.exponent.max(0), v.denominator);
    }
}
