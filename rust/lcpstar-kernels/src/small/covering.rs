//! Covering vectors of Lemke's method.
//!
//! Spread over [1, 2), not `e`: the line `q + z_0 d` then meets degenerate bases only by accident, which is what a lexicographic
//! rule is for otherwise.

/// A covering vector.
#[derive(Clone, Copy, Debug)]
pub enum Covering {
    /// See [`spread`].
    Spread,
    /// `e`.
    Ones,
}

impl Covering {
    /// Entry i.
    #[inline(always)]
    pub fn entry(self, i: usize) -> f64 {
        match self {
            Self::Spread => spread(i),
            Self::Ones => 1.0,
        }
    }
}

/// Entry i of the covering vector: 1 plus the fractional part of `(i + 1)` times the golden ratio, to 52 bits.
#[inline(always)]
pub fn spread(i: usize) -> f64 {
    /// 2^64 times the fractional part.
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    f64::from_bits(1.0_f64.to_bits() | (i as u64 + 1).wrapping_mul(GOLDEN) >> 12)
}
