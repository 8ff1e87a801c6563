//! Rational reconstruction: the fraction behind its image modulo a large integer.

use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::{One, ToPrimitive, Zero};

/// A quotient this long betrays the fraction: in the expansion of a random residue it has probability 2^-45.
const TELLING_QUOTIENT_BITS: u64 = 46;

/// `(a, b)` with `b x = a mod modulus` and both small, `b > 0`; `None` when no fraction stands out.
///
/// Maximal-quotient reconstruction (Monagan): needs `modulus > 2^47 |a| b`, whatever the sizes of `a` and `b`.
/// Euclid's algorithm with Lehmer's leading-digit steps; a telling quotient never fits in one of those steps.
/// The answer is a guess, to be checked by the caller.
#[must_use]
pub fn rational(x: &BigInt, modulus: &BigInt) -> Option<(BigInt, BigInt)> {
    let x = x.mod_floor(modulus);
    if x.is_zero() {
        return Some((BigInt::zero(), BigInt::one()));
    }
    let (mut r0, mut r1) = (modulus.clone(), x);
    let (mut t0, mut t1) = (BigInt::zero(), BigInt::one());
    while !r1.is_zero() {
        if let Some([a, b, c, d]) = lehmer_step(&r0, &r1) {
            (r0, r1) = (&r0 * a + &r1 * b, &r0 * c + &r1 * d);
            (t0, t1) = (&t0 * a + &t1 * b, &t0 * c + &t1 * d);
            continue;
        }
        let (quotient, remainder) = r0.div_rem(&r1);
        if quotient.bits() >= TELLING_QUOTIENT_BITS {
            return Some(if t1 < BigInt::zero() { (-r1, -t1) } else { (r1, t1) });
        }
        let t2 = &t0 - &quotient * &t1;
        (r0, r1) = (r1, remainder);
        (t0, t1) = (t1, t2);
    }
    None // the remainder vanished: no quotient was telling
}

/// The cofactors of several Euclidean steps read off the 62 leading bits, when at least one is certain.
fn lehmer_step(r0: &BigInt, r1: &BigInt) -> Option<[i64; 4]> {
    let bits = r0.bits();
    if bits <= 64 || r1.bits() + 32 < bits {
        return None;
    }
    let shift = bits - 62;
    let mut x = leading(r0, shift)?;
    let mut y = leading(r1, shift)?;
    let (mut a, mut b, mut c, mut d) = (1i128, 0i128, 0i128, 1i128);
    loop {
        if y + c == 0 || y + d == 0 {
            break;
        }
        let q = (x + a) / (y + c);
        if q != (x + b) / (y + d) {
            break;
        }
        (a, c) = (c, a - q * c);
        (b, d) = (d, b - q * d);
        (x, y) = (y, x - q * y);
    }
    if b == 0 {
        return None;
    }
    Some([i64::try_from(a).ok()?, i64::try_from(b).ok()?, i64::try_from(c).ok()?, i64::try_from(d).ok()?])
}

/// `r >> shift`, at most 62 bits, without shifting the whole number.
fn leading(r: &BigInt, shift: u64) -> Option<i128> {
    let digits = r.magnitude();
    let word = (shift / 64) as usize;
    let offset = shift % 64;
    let mut low = digits.iter_u64_digits().skip(word);
    let first = low.next().unwrap_or(0);
    let second = low.next().unwrap_or(0);
    let value = (u128::from(first) | u128::from(second) << 64) >> offset;
    value.to_i128()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_come_back() {
        let modulus: BigInt = BigInt::from((1u64 << 59) - 55).pow(20);
        for (a, b) in [(0i64, 1i64), (1, 1), (-1, 1), (5, 7), (-123_456_789, 987_654_321), (i64::MAX, 3)] {
            let inverse = BigInt::from(b).modinv(&modulus).expect("b is a unit");
            let x = (BigInt::from(a) * inverse).mod_floor(&modulus);
            let (p, q) = rational(&x, &modulus).expect("small");
            assert_eq!(p * b, q * a);
        }
    }

    #[test]
    fn long_fractions_of_unequal_size_come_back() {
        let modulus: BigInt = BigInt::from((1u64 << 59) - 55).pow(40);
        let a = BigInt::from(3).pow(900); // 1427 bits
        let b = BigInt::from(7).pow(300); // 843 bits: together 2270 of 2360 - 47
        let inverse = b.modinv(&modulus).expect("unit");
        let x = (&a * inverse).mod_floor(&modulus);
        assert_eq!(rational(&x, &modulus), Some((a, b)));
    }

    /// Sums of residues are not reduced: a multiple of the modulus is the fraction 0.
    #[test]
    fn a_multiple_of_the_modulus_is_zero() {
        let modulus: BigInt = BigInt::from((1u64 << 59) - 55).pow(3);
        let zero = Some((BigInt::zero(), BigInt::one()));
        assert_eq!(rational(&BigInt::zero(), &modulus), zero);
        assert_eq!(rational(&(&modulus * 917_504), &modulus), zero);
    }

    #[test]
    fn a_random_residue_is_no_fraction() {
        let modulus: BigInt = BigInt::from((1u64 << 59) - 55).pow(20);
        let x = BigInt::from(3).pow(5000).mod_floor(&modulus);
        assert_eq!(rational(&x, &modulus), None);
    }
}
