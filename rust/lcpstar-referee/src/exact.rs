//! Exact sums of products of doubles, and numbers wide enough to compare them in.
//!
//! Written for the referee alone: nothing here is shared with the exact arithmetic of the library it judges.

use lcpstar::exact::dyadic::RationalVec;
use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};
use std::cmp::Ordering;

/// `x = mantissa 2^exponent`, mantissa odd; `(0, 0)` for zero.
pub fn parts(x: f64) -> (i64, i64) {
    let bits = x.to_bits();
    let biased = i64::from(((bits >> 52) & 0x7ff) as u16);
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let (magnitude, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    if magnitude == 0 {
        return (0, 0);
    }
    let zeros = i64::from(magnitude.trailing_zeros());
    let odd = magnitude >> zeros;
    (if x < 0.0 { -odd } else { odd }, exponent + zeros)
}

/// `sum x_k y_k` of finite doubles as `(value, exponent)`, `value 2^exponent`, without rounding.
pub fn sum_of_products(terms: impl Iterator<Item = (f64, f64)> + Clone) -> (BigInt, i64) {
    let product = |(x, y): (f64, f64)| {
        let ((a, e), (b, f)) = (parts(x), parts(y));
        (i128::from(a) * i128::from(b), e + f)
    };
    let nonzero = terms.map(product).filter(|(m, _)| *m != 0);
    let (mut lowest, mut highest, mut count) = (i64::MAX, i64::MIN, 0_i64);
    for (m, e) in nonzero.clone() {
        lowest = lowest.min(e);
        highest = highest.max(e + 128 - i64::from(m.unsigned_abs().leading_zeros()));
        count += 1;
    }
    if count == 0 {
        return (BigInt::zero(), 0);
    }
    let bits = highest - lowest + 64 - i64::from(count.leading_zeros());
    if bits <= 126 {
        return (BigInt::from(nonzero.map(|(m, e)| m << (e - lowest)).sum::<i128>()), lowest);
    }
    (nonzero.map(|(m, e)| BigInt::from(m) << (e - lowest)).sum(), lowest)
}

/// `mantissa 2^exponent` with `|mantissa|` in [1, 2), or zero: a double without limits to its exponent. Each operation
/// rounds by 2^-52 at most.
#[derive(Clone, Copy, Debug)]
pub struct Wide {
    mantissa: f64,
    exponent: i64,
}

impl Wide {
    pub const ZERO: Self = Self { mantissa: 0.0, exponent: 0 };
    pub const ONE: Self = Self { mantissa: 1.0, exponent: 0 };

    fn normal(mantissa: f64, exponent: i64) -> Self {
        if mantissa == 0.0 {
            return Self::ZERO;
        }
        let (odd, e) = parts(mantissa);
        let shift = 63 - i64::from(odd.unsigned_abs().leading_zeros());
        Self { mantissa: odd as f64 / 2f64.powi(shift as i32), exponent: exponent + e + shift }
    }

    pub fn new(x: f64) -> Self {
        Self::normal(x, 0)
    }

    pub fn from_exact((value, exponent): &(BigInt, i64)) -> Self {
        let excess = (value.bits() as i64 - 64).max(0);
        Self::normal((value >> excess).to_f64().unwrap_or(0.0), exponent + excess)
    }

    pub fn shifted(self, e: i64) -> Self {
        if self.mantissa == 0.0 { self } else { Self { exponent: self.exponent + e, ..self } }
    }

    pub fn abs(self) -> Self {
        Self { mantissa: self.mantissa.abs(), ..self }
    }

    pub fn neg(self) -> Self {
        Self { mantissa: -self.mantissa, ..self }
    }

    pub fn is_zero(self) -> bool {
        self.mantissa == 0.0
    }

    pub fn is_positive(self) -> bool {
        self.mantissa > 0.0
    }

    pub fn times(self, other: Self) -> Self {
        Self::normal(self.mantissa * other.mantissa, self.exponent + other.exponent)
    }

    /// `other != 0`.
    pub fn over(self, other: Self) -> Self {
        Self::normal(self.mantissa / other.mantissa, self.exponent - other.exponent)
    }

    pub fn plus(self, other: Self) -> Self {
        if self.is_zero() {
            return other;
        }
        if other.is_zero() {
            return self;
        }
        let top = self.exponent.max(other.exponent);
        let at = |x: Self| {
            let gap = top - x.exponent;
            if gap > 200 { 0.0 } else { x.mantissa * 2f64.powi(-(gap as i32)) }
        };
        Self::normal(at(self) + at(other), top)
    }

    pub fn max(self, other: Self) -> Self {
        if self.cmp(other) == Ordering::Less { other } else { self }
    }

    pub fn min(self, other: Self) -> Self {
        if self.cmp(other) == Ordering::Less { self } else { other }
    }

    pub fn cmp(self, other: Self) -> Ordering {
        let sign = |x: Self| if x.mantissa > 0.0 { 1 } else { -i32::from(x.mantissa < 0.0) };
        if sign(self) != sign(other) || sign(self) == 0 {
            return sign(self).cmp(&sign(other));
        }
        let larger = (self.exponent, self.mantissa.abs())
            .partial_cmp(&(other.exponent, other.mantissa.abs()))
            .unwrap_or(Ordering::Equal);
        if self.mantissa > 0.0 { larger } else { larger.reverse() }
    }

    /// `self <= other` but for a relative 2^-40, which covers the rounding of the operations above.
    pub fn at_most(self, other: Self) -> bool {
        self.cmp(other.times(Self::new(1.0 + 2f64.powi(-40)))) != Ordering::Greater
    }

    pub fn to_f64(self) -> f64 {
        let e = self.exponent.clamp(-1100, 1100) as i32;
        self.mantissa * 2f64.powi(e / 2) * 2f64.powi(e - e / 2)
    }
}

/// `sum x_k y_k`, rounded once.
pub fn wide_sum(terms: impl Iterator<Item = (f64, f64)> + Clone) -> Wide {
    Wide::from_exact(&sum_of_products(terms))
}

/// `sum A_ij numerators_j + denominator q_i` as an integer times a power of two; only its sign is used.
pub fn integer_form<'a>(terms: impl Iterator<Item = (f64, &'a BigInt)> + Clone) -> BigInt {
    let nonzero = terms.filter(|(c, v)| *c != 0.0 && !v.is_zero());
    let lowest = nonzero.clone().map(|(c, _)| parts(c).1).min().unwrap_or(0);
    nonzero
        .map(|(c, v)| {
            let (m, e) = parts(c);
            (v * m) << (e - lowest)
        })
        .sum()
}

/// -1, 0 or 1.
pub fn sign(x: &BigInt) -> i32 {
    i32::from(x.is_positive()) - i32::from(x.is_negative())
}

/// Whether each z_i is the double nearest to the exact one: no further than half a unit in the last place.
pub fn is_rounded(z: &[f64], exact: &RationalVec) -> Result<(), String> {
    const LOWEST: i64 = 1075;
    for (i, (&z, numerator)) in z.iter().zip(&exact.numerators).enumerate() {
        let (mantissa, exponent) = parts(z);
        let stated = (BigInt::from(mantissa) << (exponent + LOWEST)) * &exact.denominator;
        let off = (stated - (numerator << LOWEST)).abs();
        if off > (numerator.abs() << (LOWEST - 53)) + &exact.denominator {
            return Err(format!("z[{i}] = {z:e} is not the proved one, rounded"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_exact_from_end_to_end_of_the_range() {
        let (value, exponent) = sum_of_products([(1e300, 1e300), (5e-324, 5e-324), (-1e300, 1e300)].into_iter());
        assert_eq!((value, exponent), (BigInt::from(1), -2148));
        assert_eq!(wide_sum([(0.1, 3.0), (-0.3, 1.0)].into_iter()).to_f64(), 2f64.powi(-55));
    }

    #[test]
    fn wide_numbers_compare_and_add() {
        let (a, b) = (Wide::new(3.0), Wide::new(-2.5));
        assert_eq!(a.plus(b).to_f64(), 0.5);
        assert_eq!(a.times(b).to_f64(), -7.5);
        assert_eq!(a.over(b).to_f64(), -1.2);
        assert!(b.cmp(a).is_lt() && b.cmp(Wide::ZERO).is_lt() && a.cmp(Wide::ZERO).is_gt());
        assert!(Wide::new(1e-300).times(Wide::new(1e-300)).is_positive());
    }
}
