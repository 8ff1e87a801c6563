//! Exact arithmetic on binary rationals, independent of the library's.

use num_bigint::BigInt;
use num_traits::{One, Signed, ToPrimitive, Zero};
use std::cmp::Ordering;

/// `value * 2^exponent`.
#[derive(Clone, Debug)]
pub struct Dyadic {
    value: BigInt,
    exponent: i64,
}

impl Dyadic {
    pub fn zero() -> Self {
        Self { value: BigInt::zero(), exponent: 0 }
    }

    /// A finite double as it is.
    pub fn new(x: f64) -> Self {
        assert!(x.is_finite(), "exact arithmetic was asked about {x}");
        let bits = x.to_bits();
        let (biased, fraction) = ((bits >> 52 & 0x7ff) as i64, bits & ((1 << 52) - 1));
        let (magnitude, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
        let value = if x < 0.0 { -BigInt::from(magnitude) } else { BigInt::from(magnitude) };
        Self { value, exponent: if magnitude == 0 { 0 } else { exponent } }
    }

    pub fn integer(x: &BigInt) -> Self {
        Self { value: x.clone(), exponent: 0 }
    }

    pub fn times(&self, other: &Self) -> Self {
        Self { value: &self.value * &other.value, exponent: self.exponent + other.exponent }
    }

    pub fn times_power_of_two(&self, e: i64) -> Self {
        Self { value: self.value.clone(), exponent: self.exponent + e }
    }

    pub fn plus(&self, other: &Self) -> Self {
        if self.value.is_zero() {
            return other.clone();
        }
        if other.value.is_zero() {
            return self.clone();
        }
        let exponent = self.exponent.min(other.exponent);
        Self {
            value: (&self.value << (self.exponent - exponent)) + (&other.value << (other.exponent - exponent)),
            exponent,
        }
    }

    pub fn minus(&self, other: &Self) -> Self {
        self.plus(&Self { value: -&other.value, exponent: other.exponent })
    }

    pub fn abs(&self) -> Self {
        Self { value: self.value.abs(), exponent: self.exponent }
    }

    pub fn sign(&self) -> Ordering {
        self.value.cmp(&BigInt::zero())
    }

    pub fn is_zero(&self) -> bool {
        self.value.is_zero()
    }

    pub fn at_most(&self, other: &Self) -> bool {
        self.minus(other).sign() != Ordering::Greater
    }

    pub fn min(&self, other: &Self) -> Self {
        if self.at_most(other) { self.clone() } else { other.clone() }
    }

    pub fn max(&self, other: &Self) -> Self {
        if self.at_most(other) { other.clone() } else { self.clone() }
    }

    /// About the same double, for messages.
    pub fn about(&self) -> f64 {
        let shift = self.value.bits() as i64 - 60;
        let top = (if shift > 0 { &self.value >> shift } else { &self.value << -shift }).to_f64().unwrap_or(f64::NAN);
        top * 2f64.powi((shift + self.exponent).clamp(-1100, 1100) as i32)
    }
}

/// `sum_j c_j x_j + last`.
pub fn form(c: &[f64], x: &[Dyadic], last: &Dyadic) -> Dyadic {
    c.iter()
        .zip(x)
        .filter(|(c, x)| **c != 0.0 && !x.is_zero())
        .fold(last.clone(), |sum, (&c, x)| sum.plus(&Dyadic::new(c).times(x)))
}

/// `2^e`.
pub fn power_of_two(e: i64) -> Dyadic {
    Dyadic { value: BigInt::one(), exponent: e }
}
