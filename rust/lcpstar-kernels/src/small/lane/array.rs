//! Lanes as plain arrays, for every machine.

use super::{Lane, Mask};

macro_rules! lanes {
    ($(#[$doc:meta])* $lane:ident, $mask:ident, $number:ty, $bits:ty, $lanes:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        #[repr(C, align(64))]
        pub struct $lane<const FUSED: bool>([$number; $lanes]);

        /// All bits or none, lane by lane.
        #[derive(Clone, Copy, Debug)]
        #[repr(C, align(64))]
        pub struct $mask([$bits; $lanes]);

        impl<const FUSED: bool> $lane<FUSED> {
            #[inline(always)]
            fn each(self, x: Self, f: impl Fn($number, $number) -> $number) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    out.0[l] = f(self.0[l], x.0[l]);
                }
                out
            }

            #[inline(always)]
            fn fold(self, f: impl Fn(f64, f64) -> f64) -> f64 {
                let (mut x, mut count) = (self.0.map(f64::from), $lanes);
                while count > 1 {
                    count /= 2;
                    for l in 0..count {
                        x[l] = f(x[l], x[l + count]);
                    }
                }
                x[0]
            }

            #[inline(always)]
            fn test(self, x: Self, f: impl Fn($number, $number) -> bool) -> $mask {
                let mut out = $mask::NONE;
                for l in 0..$lanes {
                    out.0[l] = if f(self.0[l], x.0[l]) { <$bits>::MAX } else { 0 };
                }
                out
            }
        }

        impl<const FUSED: bool> Lane for $lane<FUSED> {
            type Number = $number;
            type Mask = $mask;
            type Index = [usize; $lanes];
            const LANES: usize = $lanes;
            const EPS: f64 = <$number>::EPSILON as f64;

            #[inline(always)]
            fn splat(x: f64) -> Self {
                Self([x as $number; $lanes])
            }
            #[inline(always)]
            fn from_slice(x: &[$number]) -> Self {
                let mut out = Self([0.0; $lanes]);
                for (out, x) in out.0.iter_mut().zip(x) {
                    *out = *x;
                }
                out
            }
            #[inline(always)]
            fn get(&self, l: usize) -> f64 {
                f64::from(self.0[l])
            }
            #[inline(always)]
            fn set(&mut self, l: usize, x: $number) {
                self.0[l] = x;
            }
            #[inline(always)]
            fn set_from(&mut self, l: usize, x: &Self) {
                self.0[l] = x.0[l];
            }
            #[inline(always)]
            fn load_columns(rows: &[&[$number]], first: usize, out: &mut [Self]) {
                for (l, row) in rows.iter().enumerate() {
                    for (out, x) in out.iter_mut().zip(&row[first..]) {
                        out.0[l] = *x;
                    }
                }
            }
            #[inline(always)]
            fn store_columns(columns: &[Self], rows: &mut [$number], stride: usize) {
                for l in 0..$lanes {
                    for (x, column) in rows[l * stride..].iter_mut().zip(columns) {
                        *x = column.0[l];
                    }
                }
            }
            #[inline(always)]
            fn index(self, limit: usize, stride: usize) -> [usize; $lanes] {
                self.0.map(|x| (x.max(0.0) as usize).min(limit - 1) * stride)
            }
            #[inline(always)]
            fn pick(v: &[Self], at: [usize; $lanes]) -> Self {
                let mut out = Self([0.0; $lanes]);
                for l in 0..$lanes {
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
                for l in 0..$lanes {
                    out.0[l] = if FUSED { a.0[l].mul_add(b.0[l], self.0[l]) } else { self.0[l] + a.0[l] * b.0[l] };
                }
                out
            }
            #[inline(always)]
            fn sub_product(self, a: Self, b: Self) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    out.0[l] = if FUSED { (-a.0[l]).mul_add(b.0[l], self.0[l]) } else { self.0[l] - a.0[l] * b.0[l] };
                }
                out
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
            fn lt(self, x: Self) -> $mask {
                self.test(x, |a, b| a < b)
            }
            #[inline(always)]
            fn le(self, x: Self) -> $mask {
                self.test(x, |a, b| a <= b)
            }
            #[inline(always)]
            fn eq(self, x: Self) -> $mask {
                self.test(x, |a, b| a == b)
            }
            #[inline(always)]
            fn only(self, mask: $mask) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    out.0[l] = <$number>::from_bits(self.0[l].to_bits() & mask.0[l]);
                }
                out
            }
            #[inline(always)]
            fn or_else(self, mask: $mask, x: Self) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    let (a, b, m) = (self.0[l].to_bits(), x.0[l].to_bits(), mask.0[l]);
                    out.0[l] = <$number>::from_bits((a & m) | (b & !m));
                }
                out
            }
        }

        impl $mask {
            #[inline(always)]
            fn each(self, x: Self, f: impl Fn($bits, $bits) -> $bits) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    out.0[l] = f(self.0[l], x.0[l]);
                }
                out
            }
        }

        impl Mask for $mask {
            const LANES: usize = $lanes;
            const NONE: Self = Self([0; $lanes]);
            const ALL: Self = Self([<$bits>::MAX; $lanes]);

            #[inline(always)]
            fn get(&self, l: usize) -> bool {
                self.0[l] != 0
            }
            #[inline(always)]
            fn set(&mut self, l: usize, yes: bool) {
                self.0[l] = if yes { <$bits>::MAX } else { 0 };
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
                (0..$lanes).fold(0, |bits, l| bits | u32::from(self.0[l] != 0) << l)
            }
        }
    };
}

lanes!(
    /// Eight doubles: one AVX-512 register, two of AVX2.
    F64x8, M64x8, f64, u64, 8
);

lanes!(
    /// Eight floats: one register of AVX2.
    F32x8, M32x8, f32, u32, 8
);
