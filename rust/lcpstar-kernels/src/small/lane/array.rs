//! Lanes as a plain array, for every machine.

use super::{Lane, Mask};

const LANES: usize = 8;

/// Eight doubles: one AVX-512 register, two of AVX2.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct F64x8<const FUSED: bool>([f64; LANES]);

/// All bits or none, lane by lane.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct M64x8([u64; LANES]);

impl<const FUSED: bool> F64x8<FUSED> {
    #[inline(always)]
    fn each(self, x: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] = f(self.0[l], x.0[l]);
        }
        out
    }

    #[inline(always)]
    fn fold(self, f: impl Fn(f64, f64) -> f64) -> f64 {
        let (mut x, mut count) = (self.0, LANES);
        while count > 1 {
            count /= 2;
            for l in 0..count {
                x[l] = f(x[l], x[l + count]);
            }
        }
        x[0]
    }

    #[inline(always)]
    fn test(self, x: Self, f: impl Fn(f64, f64) -> bool) -> M64x8 {
        let mut out = M64x8::NONE;
        for l in 0..LANES {
            out.0[l] = if f(self.0[l], x.0[l]) { u64::MAX } else { 0 };
        }
        out
    }
}

impl<const FUSED: bool> Lane for F64x8<FUSED> {
    type Mask = M64x8;
    type Index = [usize; LANES];
    const LANES: usize = LANES;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; LANES])
    }
    #[inline(always)]
    fn from_slice(x: &[f64]) -> Self {
        let mut out = Self([0.0; LANES]);
        for (out, x) in out.0.iter_mut().zip(x) {
            *out = *x;
        }
        out
    }
    #[inline(always)]
    fn get(&self, l: usize) -> f64 {
        self.0[l]
    }
    #[inline(always)]
    fn set(&mut self, l: usize, x: f64) {
        self.0[l] = x;
    }
    #[inline(always)]
    fn set_from(&mut self, l: usize, x: &Self) {
        self.0[l] = x.0[l];
    }
    #[inline(always)]
    fn load_columns(rows: &[&[f64]], first: usize, out: &mut [Self]) {
        for (l, row) in rows.iter().enumerate() {
            for (out, x) in out.iter_mut().zip(&row[first..]) {
                out.0[l] = *x;
            }
        }
    }
    #[inline(always)]
    fn store_columns(columns: &[Self], rows: &mut [f64], stride: usize) {
        for l in 0..LANES {
            for (x, column) in rows[l * stride..].iter_mut().zip(columns) {
                *x = column.0[l];
            }
        }
    }
    #[inline(always)]
    fn index(self, limit: usize, stride: usize) -> [usize; LANES] {
        self.0.map(|x| (x.max(0.0) as usize).min(limit - 1) * stride)
    }
    #[inline(always)]
    fn pick(v: &[Self], at: [usize; LANES]) -> Self {
        let mut out = Self([0.0; LANES]);
        for l in 0..LANES {
            out.0[l] = v[at[l]].0[l];
        }
        out
    }
    #[inline(always)]
    fn sum(self) -> f64 {
        self.fold(|a, b| a + b)
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        self.fold(f64::max)
    }
    #[inline(always)]
    fn smallest(self) -> f64 {
        self.fold(f64::min)
    }
    #[inline(always)]
    fn add(self, x: Self) -> Self {
        self.each(x, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, x: Self) -> Self {
        self.each(x, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, x: Self) -> Self {
        self.each(x, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, x: Self) -> Self {
        self.each(x, |a, b| a / b)
    }
    #[inline(always)]
    fn add_product(self, a: Self, b: Self) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] = if FUSED { a.0[l].mul_add(b.0[l], self.0[l]) } else { self.0[l] + a.0[l] * b.0[l] };
        }
        out
    }
    #[inline(always)]
    fn sub_product(self, a: Self, b: Self) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] = if FUSED { (-a.0[l]).mul_add(b.0[l], self.0[l]) } else { self.0[l] - a.0[l] * b.0[l] };
        }
        out
    }
    #[inline(always)]
    fn exponent(self) -> Self {
        self.each(self, |x, _| ((x.to_bits() >> 52 & 0x7ff) as i64 - 1022) as f64)
    }
    #[inline(always)]
    fn truncated(self) -> Self {
        self.each(self, |x, _| x as i64 as f64)
    }
    #[inline(always)]
    fn two_to(self) -> Self {
        self.each(self, |x, _| f64::from_bits(((x as i64 + 1023) as u64) << 52))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.each(self, |a, _| a.abs())
    }
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(self, |a, _| -a)
    }
    #[inline(always)]
    fn max(self, x: Self) -> Self {
        self.each(x, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn min(self, x: Self) -> Self {
        self.each(x, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn lt(self, x: Self) -> M64x8 {
        self.test(x, |a, b| a < b)
    }
    #[inline(always)]
    fn le(self, x: Self) -> M64x8 {
        self.test(x, |a, b| a <= b)
    }
    #[inline(always)]
    fn eq(self, x: Self) -> M64x8 {
        self.test(x, |a, b| a == b)
    }
    #[inline(always)]
    fn only(self, mask: M64x8) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] = f64::from_bits(self.0[l].to_bits() & mask.0[l]);
        }
        out
    }
    #[inline(always)]
    fn or_else(self, mask: M64x8, x: Self) -> Self {
        let mut out = self;
        for l in 0..LANES {
            let (a, b, m) = (self.0[l].to_bits(), x.0[l].to_bits(), mask.0[l]);
            out.0[l] = f64::from_bits((a & m) | (b & !m));
        }
        out
    }
}

impl M64x8 {
    #[inline(always)]
    fn each(self, x: Self, f: impl Fn(u64, u64) -> u64) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] = f(self.0[l], x.0[l]);
        }
        out
    }
}

impl Mask for M64x8 {
    const LANES: usize = LANES;
    const NONE: Self = Self([0; LANES]);
    const ALL: Self = Self([u64::MAX; LANES]);

    #[inline(always)]
    fn get(&self, l: usize) -> bool {
        self.0[l] != 0
    }
    #[inline(always)]
    fn set(&mut self, l: usize, yes: bool) {
        self.0[l] = if yes { u64::MAX } else { 0 };
    }
    #[inline(always)]
    fn and(self, x: Self) -> Self {
        self.each(x, |a, b| a & b)
    }
    #[inline(always)]
    fn or(self, x: Self) -> Self {
        self.each(x, |a, b| a | b)
    }
    #[inline(always)]
    fn xor(self, x: Self) -> Self {
        self.each(x, |a, b| a ^ b)
    }
    #[inline(always)]
    fn not(self) -> Self {
        self.each(self, |a, _| !a)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.iter().fold(0, |any, m| any | m) != 0
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..LANES).fold(0, |bits, l| bits | u32::from(self.0[l] != 0) << l)
    }
}
