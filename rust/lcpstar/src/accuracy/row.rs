//! `A z + q` row by row without any rounding: numbers of any size, sums that cancel to the last bit.

use crate::scaling::{Scaling, times_power_of_two};

/// A number `mantissa 2^exponent` with `mantissa` 0 or in [1/2, 1) by size: as exact as a double, with room at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wide {
    mantissa: f64,
    exponent: i64,
}

impl Wide {
    pub(super) const ZERO: Self = Self { mantissa: 0.0, exponent: 0 };

    /// A finite double, exactly.
    pub(super) fn new(x: f64) -> Self {
        Self { mantissa: x, exponent: 0 }.normal()
    }

    fn normal(self) -> Self {
        if self.mantissa == 0.0 {
            return Self::ZERO;
        }
        let e = crate::scaling::exponent(self.mantissa);
        Self { mantissa: times_power_of_two(self.mantissa, -e), exponent: self.exponent + i64::from(e) }
    }

    /// `2^e` times this.
    pub(super) fn shifted(self, e: i32) -> Self {
        if self.mantissa == 0.0 { self } else { Self { exponent: self.exponent + i64::from(e), ..self } }
    }

    /// The exponent; far below all others for 0.
    pub(super) fn exponent(self) -> i64 {
        if self.mantissa == 0.0 { i64::from(i32::MIN) } else { self.exponent }
    }

    /// The smaller of the two.
    pub(super) fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// The larger of the two.
    pub(super) fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    pub(super) fn abs(self) -> Self {
        Self { mantissa: self.mantissa.abs(), ..self }
    }

    pub(super) fn is_negative(self) -> bool {
        self.mantissa < 0.0
    }

    /// The product, rounded once.
    pub(super) fn times(self, other: Self) -> Self {
        Self { mantissa: self.mantissa * other.mantissa, exponent: self.exponent + other.exponent }.normal()
    }

    /// The quotient, rounded once; `other` is not 0.
    pub(super) fn over(self, other: Self) -> Self {
        Self { mantissa: self.mantissa / other.mantissa, exponent: self.exponent - other.exponent }.normal()
    }

    /// `2^-unit` times this as a double: the nearest, infinite when it is too large, never 0 unless this is.
    pub(super) fn in_units(self, unit: i64) -> f64 {
        let e = (self.exponent - unit).clamp(-4000, 4000) as i32;
        let x = times_power_of_two(self.mantissa, e);
        if x == 0.0 { f64::from_bits(1).copysign(self.mantissa) * f64::from(u8::from(self.mantissa != 0.0)) } else { x }
    }

    /// A double above this, which is known to a few units in the last place; 0 for 0.
    pub(super) fn up(self) -> f64 {
        if self.mantissa == 0.0 { 0.0 } else { self.times(Self::new(1.0 + 8.0 * f64::EPSILON)).to_f64().next_up() }
    }

    /// The nearest double; infinite when it is too large, never 0 unless this is.
    pub(super) fn to_f64(self) -> f64 {
        self.in_units(0)
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        let unit = self.exponent().max(other.exponent());
        self.in_units(unit).partial_cmp(&other.in_units(unit))
    }
}

/// Limbs for every product of two doubles, from 2^-2148 to 2^2048, and for 2^64 of them.
const LIMBS: usize = 67;
/// The exponent of the lowest bit.
const LOWEST: i32 = -2148;

/// A sum of products of doubles of one sign, in fixed point: wide enough for all of them, so that nothing is rounded.
#[derive(Clone)]
struct Sum {
    limbs: [u64; LIMBS],
}

impl Sum {
    const ZERO: Self = Self { limbs: [0; LIMBS] };

    /// Adds `mantissa 2^exponent`.
    fn add(&mut self, mantissa: u128, exponent: i32) {
        let shift = (exponent - LOWEST).unsigned_abs() as usize;
        let (limb, bit) = (shift / 64, shift % 64);
        // 106 bits at any place of a limb reach into three of them.
        let (low, high) = (mantissa as u64, (mantissa >> 64) as u64);
        let spill = |x: u64| if bit == 0 { 0 } else { x >> (64 - bit) };
        let mut carry = false;
        for (i, part) in [low << bit, high << bit | spill(low), spill(high)].into_iter().enumerate() {
            if let Some(place) = self.limbs.get_mut(limb + i) {
                (*place, carry) = carrying_add(*place, part, carry);
            }
        }
        for place in self.limbs.iter_mut().skip(limb + 3) {
            if !carry {
                break;
            }
            (*place, carry) = carrying_add(*place, 0, carry);
        }
    }

    /// `self - other`, of which `self` is not the smaller; or their sum.
    fn combined(&self, other: &Self, subtract: bool) -> Wide {
        let mut limbs = self.limbs;
        let mut carry = subtract;
        for (x, &y) in limbs.iter_mut().zip(&other.limbs) {
            (*x, carry) = carrying_add(*x, if subtract { !y } else { y }, carry);
        }
        let Some(top) = limbs.iter().rposition(|&x| x != 0) else { return Wide::ZERO };
        let below = |k: usize| if top >= k { limbs[top - k] } else { 0 };
        let high = u128::from(below(0)) << 64 | u128::from(below(1));
        let zeros = high.leading_zeros();
        let leading = high << zeros | u128::from(below(2).checked_shr(64 - zeros).unwrap_or(0));
        let exponent = i64::from(LOWEST) + 64 * (top as i64 - 1) - i64::from(zeros);
        Wide { mantissa: leading as f64, exponent }.normal()
    }
}

fn carrying_add(x: u64, y: u64, carry: bool) -> (u64, bool) {
    let (sum, first) = x.overflowing_add(y);
    let (sum, second) = sum.overflowing_add(u64::from(carry));
    (sum, first | second)
}

/// `|x| = mantissa 2^exponent` with an integer mantissa; x is finite.
fn parts(x: f64) -> (u64, i32) {
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
    if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) }
}

/// `w_i` and `(|A||z| + |q|)_i` of one row, each rounded once: the sums are exact.
pub(super) fn row(q: f64, a: &[f64], z: impl Fn(usize) -> f64) -> (Wide, Wide) {
    let (mut positive, mut negative) = (Sum::ZERO, Sum::ZERO);
    let mut add = |x: f64, y: f64| {
        let ((m, e), (k, f)) = (parts(x), parts(y));
        let product = u128::from(m) * u128::from(k);
        if product != 0 {
            let sum = if x.is_sign_negative() == y.is_sign_negative() { &mut positive } else { &mut negative };
            sum.add(product, e + f);
        }
    };
    add(q, 1.0);
    a.iter().enumerate().for_each(|(k, &a)| add(a, z(k)));
    let magnitude = positive.combined(&negative, false);
    let is_less = positive.limbs.iter().rev().lt(negative.limbs.iter().rev());
    let w = if is_less {
        let size = negative.combined(&positive, true);
        Wide { mantissa: -size.mantissa, ..size }
    } else {
        positive.combined(&negative, true)
    };
    (w, magnitude)
}

/// One row of a point, each number as exact as a double is.
pub(super) struct Row {
    pub(super) z: Wide,
    pub(super) w: Wide,
    /// `(|A||z| + |q|)_i`.
    pub(super) magnitude: Wide,
}

impl Row {
    pub(super) fn new(z: f64, q: f64, a: &[f64], at: impl Fn(usize) -> f64) -> Self {
        let (w, magnitude) = row(q, a, at);
        Self { z: Wide::new(z), w, magnitude }
    }

    /// `z_i` and `w_i` of the scaled problem.
    pub(super) fn scaled(&self, scaling: &Scaling, i: usize) -> (Wide, Wide) {
        (self.z.shifted(scaling.q - scaling.columns[i]), self.w.shifted(scaling.q + scaling.rows[i]))
    }

    /// How far `w_i` is from what z_i asks for, as a part of the magnitude.
    pub(super) fn backward_error(&self) -> Wide {
        if self.z.is_negative() {
            return Wide::new(f64::MAX).shifted(2);
        }
        let is_right = if self.z == Wide::ZERO { !self.w.is_negative() } else { self.w == Wide::ZERO };
        if is_right { Wide::ZERO } else { self.w.abs().over(self.magnitude) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::dyadic::{RationalVec, linear_form, ratio_to_f64};
    use num_bigint::BigInt;

    #[test]
    fn rows_are_exact() {
        let cases: [(f64, &[f64], &[f64]); 7] = [
            (-1.0, &[2.0], &[1e308]),
            (1e-200, &[1e-200, -1e-200], &[1e-200, 1e-200]),
            (0.0, &[5e-324], &[5e-324]),
            (f64::MAX, &[f64::MAX, -f64::MAX, 1e-300], &[f64::MAX, f64::MAX, 1e-300]),
            (1.0, &[1e16, -1e16], &[1.0 + f64::EPSILON, 1.0]),
            (-0.1, &[0.3, 0.7, -0.9], &[0.5, -0.25, 1e-30]),
            (0.0, &[], &[]),
        ];
        for (q, a, z) in cases {
            let exact = RationalVec::from_f64(z);
            let terms = std::iter::once((q, &exact.denominator)).chain(a.iter().copied().zip(&exact.numerators));
            let form = linear_form(terms);
            // As a multiple of the power of two above it, so that the expected number is a double.
            let (value, shift) = (form.value, form.exponent - exact.denominator.bits() as i64 + 1);
            let (w, m) = row(q, a, |k| z[k]);
            let unit = w.exponent();
            let expected = if shift >= unit {
                ratio_to_f64(&(value << (shift - unit)), &1.into())
            } else {
                ratio_to_f64(&value, &(BigInt::from(1) << (unit - shift)))
            };
            assert_eq!(w.in_units(unit), expected, "{q:e} {a:?} {z:?}");
            assert!(m >= w.abs());
        }
    }

    #[test]
    fn numbers_beyond_the_doubles() {
        let big = Wide::new(f64::MAX).times(Wide::new(f64::MAX));
        assert_eq!((big.to_f64(), big.over(big).to_f64()), (f64::INFINITY, 1.0));
        let small = Wide::new(-5e-324).times(Wide::new(5e-324));
        assert!(small.to_f64() == -5e-324 && small < Wide::ZERO && small.max(big) == big && small.min(big) == small);
        assert_eq!((Wide::new(5e-324).up(), Wide::ZERO.up()), (1e-323, 0.0));
    }
}
