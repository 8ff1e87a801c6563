//! The exact scalar: an `i128` while the number fits, a big integer behind it.

use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::{Signed, ToPrimitive};
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Mul, Neg, Sub};

/// An integer of any size. `Big` holds only what does not fit `Small`, so equality is structural.
#[derive(Clone, PartialEq, Eq, Hash)]
pub enum Int {
    /// Fits 128 bits.
    Small(i128),
    /// Does not.
    Big(Box<BigInt>),
}

impl Int {
    /// Zero.
    pub const ZERO: Self = Self::Small(0);
    /// One.
    pub const ONE: Self = Self::Small(1);

    /// As a big integer.
    #[must_use]
    pub fn to_big(&self) -> BigInt {
        match self {
            Self::Small(x) => BigInt::from(*x),
            Self::Big(x) => (**x).clone(),
        }
    }

    /// -1, 0 or 1.
    #[must_use]
    #[inline]
    pub fn sign(&self) -> i32 {
        match self {
            Self::Small(x) => x.signum() as i32,
            Self::Big(x) if x.is_negative() => -1,
            Self::Big(_) => 1,
        }
    }

    /// Whether it is zero.
    #[must_use]
    #[inline]
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Small(0))
    }

    /// Absolute value.
    #[must_use]
    pub fn abs(&self) -> Self {
        if self.sign() < 0 { -self } else { self.clone() }
    }

    /// The quotient, when `divisor` divides `self` without remainder.
    #[must_use]
    #[inline]
    pub fn div_exact(&self, divisor: &Self) -> Self {
        debug_assert!(!divisor.is_zero());
        match (self, divisor) {
            (_, Self::Small(1)) => self.clone(),
            (Self::Small(a), Self::Small(b)) => small_quotient(*a, *b),
            _ => Self::from(self.to_big() / divisor.to_big()),
        }
    }

    /// `(a b - c d) / e`, where the division is known to be exact: one step of fraction-free elimination.
    #[must_use]
    #[inline]
    pub fn cross(a: &Self, b: &Self, c: &Self, d: &Self, e: &Self) -> Self {
        if let (Self::Small(a), Self::Small(b), Self::Small(c), Self::Small(d), Self::Small(e)) = (a, b, c, d, e) {
            let difference = if is_short(*a) && is_short(*b) && is_short(*c) && is_short(*d) {
                Some(a * b - c * d)
            } else {
                a.checked_mul(*b).zip(c.checked_mul(*d)).and_then(|(ab, cd)| ab.checked_sub(cd))
            };
            if let Some(difference) = difference {
                return if *e == 1 { Self::Small(difference) } else { small_quotient(difference, *e) };
            }
        }
        Self::from((a.to_big() * b.to_big() - c.to_big() * d.to_big()) / e.to_big())
    }

    /// The greatest common divisor, nonnegative.
    #[must_use]
    pub fn gcd(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::Small(a), Self::Small(b)) if is_short(*a) && is_short(*b) => {
                let (mut a, mut b) = (a.unsigned_abs() as u64, b.unsigned_abs() as u64);
                while b != 0 {
                    (a, b) = (b, a % b);
                }
                Self::Small(i128::from(a))
            }
            _ => Self::from(self.to_big().gcd(&other.to_big())),
        }
    }

    /// The nearest double, up to a relative error below 2^-51; infinite when it is too large.
    #[must_use]
    pub fn to_f64(&self) -> f64 {
        match self {
            Self::Small(x) => *x as f64,
            Self::Big(x) => x.to_f64().unwrap_or(f64::INFINITY),
        }
    }
}

/// Both factors short: their product cannot overflow, and two products can be subtracted.
#[inline]
fn is_short(x: i128) -> bool {
    i128::from(x as i64) == x && x as i64 != i64::MIN
}

/// Hardware division when both fit a word.
#[inline]
fn small_quotient(a: i128, b: i128) -> Int {
    if is_short(a) && is_short(b) {
        return Int::Small(i128::from(a as i64 / b as i64));
    }
    match a.checked_div(b) {
        Some(x) => Int::Small(x),
        None => Int::from(BigInt::from(a) / BigInt::from(b)),
    }
}

impl From<BigInt> for Int {
    fn from(x: BigInt) -> Self {
        match x.to_i128() {
            Some(x) => Self::Small(x),
            None => Self::Big(Box::new(x)),
        }
    }
}

impl From<i64> for Int {
    fn from(x: i64) -> Self {
        Self::Small(i128::from(x))
    }
}

impl Add for &Int {
    type Output = Int;
    #[inline]
    fn add(self, other: &Int) -> Int {
        if let (Int::Small(a), Int::Small(b)) = (self, other)
            && let Some(x) = a.checked_add(*b)
        {
            return Int::Small(x);
        }
        Int::from(self.to_big() + other.to_big())
    }
}

impl Sub for &Int {
    type Output = Int;
    #[inline]
    fn sub(self, other: &Int) -> Int {
        if let (Int::Small(a), Int::Small(b)) = (self, other)
            && let Some(x) = a.checked_sub(*b)
        {
            return Int::Small(x);
        }
        Int::from(self.to_big() - other.to_big())
    }
}

impl Mul for &Int {
    type Output = Int;
    #[inline]
    fn mul(self, other: &Int) -> Int {
        if let (Int::Small(a), Int::Small(b)) = (self, other) {
            if is_short(*a) && is_short(*b) {
                return Int::Small(a * b);
            }
            if let Some(x) = a.checked_mul(*b) {
                return Int::Small(x);
            }
        }
        Int::from(self.to_big() * other.to_big())
    }
}

impl Neg for &Int {
    type Output = Int;
    fn neg(self) -> Int {
        match self {
            Int::Small(x) if *x != i128::MIN => Int::Small(-x),
            _ => Int::from(-self.to_big()),
        }
    }
}

impl PartialOrd for Int {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Int {
    fn cmp(&self, other: &Self) -> Ordering {
        match (self, other) {
            (Self::Small(a), Self::Small(b)) => a.cmp(b),
            _ => self.to_big().cmp(&other.to_big()),
        }
    }
}

impl fmt::Display for Int {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Small(x) => write!(f, "{x}"),
            Self::Big(x) => write!(f, "{x}"),
        }
    }
}

impl fmt::Debug for Int {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Default for Int {
    fn default() -> Self {
        Self::ZERO
    }
}

/// `x'y`.
#[must_use]
pub fn dot(x: &[Int], y: &[Int]) -> Int {
    debug_assert_eq!(x.len(), y.len());
    let mut sum = Int::ZERO;
    for (a, b) in x.iter().zip(y) {
        if !a.is_zero() && !b.is_zero() {
            sum = &sum + &(a * b);
        }
    }
    sum
}

/// Divides by the greatest common divisor of the entries: the primitive vector on the same ray.
pub fn make_primitive(x: &mut [Int]) {
    let mut divisor = Int::ZERO;
    for entry in x.iter() {
        if !entry.is_zero() {
            divisor = divisor.gcd(entry);
            if divisor == Int::ONE {
                return;
            }
        }
    }
    if !divisor.is_zero() {
        for entry in x.iter_mut() {
            *entry = entry.div_exact(&divisor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products cross the border of 128 bits and come back.
    #[test]
    fn crosses_into_big_integers_and_back() {
        let x = Int::Small(i128::MAX);
        let square = &x * &x;
        assert!(matches!(square, Int::Big(_)));
        assert_eq!(square.div_exact(&x), x);
        assert_eq!(&(&square - &square) + &Int::ONE, Int::ONE);
        assert_eq!(&Int::Small(i128::MIN) + &Int::Small(0), -&(-&Int::Small(i128::MIN)));
        assert_eq!((-&square).sign(), -1);
    }

    #[test]
    fn cross_is_exact_at_the_border() {
        let cases = [(i64::MAX, i64::MIN), (i64::MIN, i64::MIN), (3, -7), (0, 5)];
        for (a, b) in cases {
            for (c, d) in cases {
                let expected = BigInt::from(a) * b - BigInt::from(c) * d;
                let got = Int::cross(&a.into(), &b.into(), &c.into(), &d.into(), &Int::ONE);
                assert_eq!(got.to_big(), expected);
            }
        }
        let huge = Int::Small(1 << 100);
        assert_eq!(Int::cross(&huge, &huge, &huge, &Int::ONE, &huge), &huge - &Int::ONE);
    }

    #[test]
    fn primitive_vector() {
        let mut x = vec![Int::from(-6), Int::from(0), Int::from(9)];
        make_primitive(&mut x);
        assert_eq!(x, vec![Int::from(-2), Int::from(0), Int::from(3)]);
    }
}
