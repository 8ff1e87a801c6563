//! Solves with a factored block by Hensel lifting: the digits of the solution in base p, and the rational numbers they belong to.

use super::dyadic::{RationalVec, Scaled};
use super::padic::{Block, LIMB, LIMB_MASK, SLACK, Unsolved};
use super::reconstruct;
use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::{One, Zero};

impl Block {
    /// Solves `K x = b` exactly.
    ///
    /// # Errors
    /// `Interrupted`.
    pub fn solve(&self, rhs: &[Scaled], stop: &dyn Fn() -> bool) -> Result<RationalVec, Unsolved> {
        debug_assert_eq!(rhs.len(), self.order);
        let (integers, rhs_exponent) = self.scale_rhs(rhs);
        let rhs_bits = integers.iter().map(BigInt::bits).max().unwrap_or(0);
        if rhs_bits == 0 {
            return Ok(RationalVec { numerators: vec![BigInt::zero(); self.order], denominator: BigInt::one() });
        }
        let log_order = u64::from(usize::BITS - self.order.leading_zeros());
        // Numerator and denominator of a positive combination (weights below 2^20), and the telling quotient.
        let enough = 2 * self.determinant_bits + rhs_bits + log_order + 20 + 48;
        let last_step = enough as usize / 58 + 2;
        let mut lift = Lift::new(self, &integers, rhs_bits);
        let mut attempt_at = 4usize;
        loop {
            let near_the_end = lift.digits.len() < last_step && attempt_at * 5 > last_step * 4;
            let steps = if near_the_end { last_step } else { attempt_at };
            while lift.digits.len() < steps {
                if stop() {
                    return Err(Unsolved::Interrupted);
                }
                lift.step();
            }
            if let Some((numerators, denominator)) = lift.reconstruct(rhs_bits, stop) {
                let v = numerators
                    .into_iter()
                    .zip(&self.column_exponent)
                    .map(|(value, &c)| Scaled { value, exponent: c - rhs_exponent })
                    .collect();
                return Ok(RationalVec::from_scaled(v, denominator));
            }
            // Beyond Hadamard's bound success is certain but for an unlucky combination: go on with more digits.
            attempt_at = if steps >= last_step { steps + steps / 4 + 4 } else { steps + steps / 2 };
        }
    }

    /// `b' = 2^s R b` in integers, and `s`.
    fn scale_rhs(&self, rhs: &[Scaled]) -> (Vec<BigInt>, i64) {
        let used = rhs.iter().zip(&self.row_exponent).filter(|(b, _)| !b.value.is_zero());
        let s = -used.map(|(b, r)| b.exponent + r).min().unwrap_or(0);
        let integers = rhs
            .iter()
            .zip(&self.row_exponent)
            .map(|(b, r)| if b.value.is_zero() { BigInt::zero() } else { &b.value << (b.exponent + r + s) });
        (integers.collect(), s)
    }
}

/// The digits found so far and the exact residual `b' - K' x'`, divided by `p^digits`.
pub(super) struct Lift<'a> {
    block: &'a Block,
    /// `order` rows of `limbs` limbs, two's complement in base 2^52: the top limb carries the sign.
    residual: Vec<i64>,
    limbs: usize,
    limb_residues: Vec<u64>,
    /// p^-1 mod 2^52.
    p_inverse: u64,
    pub(super) digits: Vec<Vec<u64>>,
    image: Vec<u64>,
}

impl<'a> Lift<'a> {
    pub(super) fn new(block: &'a Block, rhs: &[BigInt], rhs_bits: u64) -> Self {
        let log_order = u64::from(usize::BITS - block.order.leading_zeros());
        let bits = rhs_bits.max(block.entry_bits + log_order) + 3;
        let limbs = (bits as usize / LIMB as usize + 1).max(block.planes.len());
        let mut residual = Vec::with_capacity(block.order * limbs);
        for b in rhs {
            residual.extend(to_limbs(b, limbs));
        }
        let prime = block.prime;
        let base = prime.pow(2, u64::from(LIMB));
        let mut limb_residues = vec![1; limbs];
        for l in 1..limbs {
            limb_residues[l] = prime.mul(limb_residues[l - 1], base);
        }
        let p = prime.value();
        // Newton's iteration doubles the correct bits of an inverse modulo a power of two.
        let mut p_inverse = p;
        for _ in 0..6 {
            p_inverse = p_inverse.wrapping_mul(2u64.wrapping_sub(p.wrapping_mul(p_inverse)));
        }
        let image = vec![0; block.order];
        Self { block, residual, limbs, limb_residues, p_inverse, digits: Vec::new(), image }
    }

    /// One more digit: `x = K'^-1 r mod p`, then `r = (r - K' x) / p` exactly.
    pub(super) fn step(&mut self) {
        let (block, limbs, prime) = (self.block, self.limbs, self.block.prime);
        for (image, row) in self.image.iter_mut().zip(self.residual.chunks_exact(limbs)) {
            let sum: i128 = row.iter().zip(&self.limb_residues).map(|(&l, &w)| i128::from(l) * i128::from(w)).sum();
            *image = prime.reduce_signed(sum);
        }
        let mut digit = vec![0; block.order];
        block.lu.solve(&self.image, &mut digit);
        for i in 0..block.order {
            let row = &mut self.residual[i * limbs..(i + 1) * limbs];
            let mut carry = 0i128;
            for l in 0..limbs {
                let mut t = i128::from(row[l]) + carry;
                if let Some(plane) = block.planes.get(l) {
                    let span = plane.start[i]..plane.start[i + 1];
                    let terms = plane.column[span.clone()].iter().zip(&plane.value[span]);
                    t -= terms.map(|(&j, &v)| i128::from(v) * i128::from(digit[j as usize])).sum::<i128>();
                }
                let q = (t as u64).wrapping_mul(self.p_inverse) & LIMB_MASK as u64;
                carry = (t - i128::from(q) * i128::from(prime.value())) >> LIMB;
                row[l] = q as i64;
            }
            // The rest is a multiple of p: 0, or -p for a negative quotient.
            row[limbs - 1] += ((carry / i128::from(prime.value())) << LIMB) as i64;
        }
        self.digits.push(digit);
    }

    /// Numerators and their denominator, proved by size: `K' num = den b'` holds modulo `p^m` and both sides are
    /// smaller than half of it. `None` without enough digits, or when `stop` says so before a numerator.
    pub(super) fn reconstruct(&self, rhs_bits: u64, stop: &dyn Fn() -> bool) -> Option<(Vec<BigInt>, BigInt)> {
        let order = self.block.order;
        let p = self.block.prime.value();
        let powers = PowerTree::new(p, self.digits.len());
        let weight = |j: usize| (j as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 44 | 1;
        let combined: Vec<u128> = self
            .digits
            .iter()
            .map(|x| x.iter().enumerate().map(|(j, &d)| u128::from(d) * u128::from(weight(j))).sum())
            .collect();
        let modulus = BigInt::from(p).pow(self.digits.len() as u32);
        let (sum, denominator) = reconstruct::rational(&powers.combine(&combined), &modulus)?;
        let margin = self.block.entry_bits + u64::from(usize::BITS - order.leading_zeros()) + 2;
        // Nonnegative numerators are at most their weighted sum; if some are negative, all digits are needed.
        let fits = ((sum.bits() + margin).max(denominator.bits() + rhs_bits) + SLACK) as usize / 58 + 2;
        [fits.min(self.digits.len()), self.digits.len()].into_iter().find_map(|count| {
            let modulus = BigInt::from(p).pow(count as u32);
            let longest = modulus.bits().saturating_sub(margin + 1);
            let (numerators, denominator) =
                self.numerators(count, &powers, &modulus, denominator.clone(), longest, stop)?;
            let proved = denominator.bits() + rhs_bits + 2 < modulus.bits();
            proved.then_some((numerators, denominator))
        })
    }

    /// `den x mod p^count`, symmetric, with the small factors of the denominator that the combination lost put
    /// back; `None` when a numerator is too long to prove the equations.
    fn numerators(
        &self,
        count: usize,
        powers: &PowerTree,
        modulus: &BigInt,
        mut denominator: BigInt,
        longest: u64,
        stop: &dyn Fn() -> bool,
    ) -> Option<(Vec<BigInt>, BigInt)> {
        let half = modulus >> 1;
        let mut numerators: Vec<BigInt> = Vec::with_capacity(self.block.order);
        let mut digits = vec![0u128; count];
        for j in 0..self.block.order {
            if stop() {
                return None;
            }
            for (d, x) in digits.iter_mut().zip(&self.digits) {
                *d = u128::from(x[j]);
            }
            let mut v = (powers.combine(&digits) * denominator.mod_floor(modulus)).mod_floor(modulus);
            if v > half {
                v -= modulus;
            }
            if v.bits() > longest {
                let (numerator, factor) = reconstruct::rational(&v, modulus)?;
                denominator *= &factor;
                for x in &mut numerators {
                    *x *= &factor;
                }
                v = numerator;
            }
            numerators.push(v);
        }
        numerators.iter().all(|v| v.bits() <= longest).then_some((numerators, denominator))
    }
}

/// `value` in `limbs` two's complement limbs of 52 bits.
fn to_limbs(value: &BigInt, limbs: usize) -> Vec<i64> {
    let mask = BigInt::from(LIMB_MASK);
    let mut rest = value.clone();
    let mut out = Vec::with_capacity(limbs);
    for l in 0..limbs {
        let low: BigInt = if l + 1 < limbs { &rest & &mask } else { rest.clone() };
        out.push(i64::try_from(&low).expect("invariant: the limbs were counted from the bits"));
        rest >>= LIMB;
    }
    out
}

/// Powers `p^(16 2^l)`: digits are summed by halves, so that long numbers meet numbers of the same length.
struct PowerTree {
    p: u64,
    powers: Vec<BigInt>,
}

impl PowerTree {
    const LEAF: usize = 16;

    fn new(p: u64, digits: usize) -> Self {
        let mut powers = vec![BigInt::from(p).pow(Self::LEAF as u32)];
        while Self::LEAF << powers.len() < digits {
            let last = &powers[powers.len() - 1];
            powers.push(last * last);
        }
        Self { p, powers }
    }

    /// `sum d_s p^s`.
    fn combine(&self, digits: &[u128]) -> BigInt {
        let mut level: Vec<BigInt> = digits
            .chunks(Self::LEAF)
            .map(|leaf| leaf.iter().rev().fold(BigInt::zero(), |acc, &d| acc * self.p + d))
            .collect();
        for power in &self.powers {
            level = level
                .chunks(2)
                .map(|pair| match pair {
                    [low, high] => low + high * power,
                    rest => rest[0].clone(),
                })
                .collect();
        }
        level.pop().unwrap_or_default()
    }
}
