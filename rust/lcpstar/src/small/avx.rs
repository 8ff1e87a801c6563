//! The lanes of [`lane`](super::lane) in registers of AVX-512 and AVX2, same bits as `F64x8<true>`.
//!
//! The compiler vectorises the portable lanes well in short kernels and poorly in long ones; naming the instructions
//! makes the speed predictable. Nothing here checks that the machine has them: `work` and `tiny` choose a type only
//! in functions compiled for, and entered on, machines that do.
#![allow(unsafe_code, reason = "instructions of the machine; see above for who may call them")]

use super::lane::{Lane, Mask};
use std::arch::x86_64::{
    __m128d, __m256d, __m512d, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm_add_pd, _mm_cvtsd_f64, _mm_max_pd, _mm_min_pd,
    _mm_unpackhi_pd, _mm256_add_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd, _mm256_castpd256_pd128,
    _mm256_cmp_pd, _mm256_div_pd, _mm256_extractf128_pd, _mm256_fmadd_pd, _mm256_fnmadd_pd, _mm256_loadu_pd,
    _mm256_max_pd, _mm256_min_pd, _mm256_movemask_pd, _mm256_mul_pd, _mm256_or_pd, _mm256_set1_pd, _mm256_sub_pd,
    _mm256_xor_pd, _mm512_abs_pd, _mm512_add_pd, _mm512_castpd512_pd256, _mm512_cmp_pd_mask, _mm512_div_pd,
    _mm512_extractf64x4_pd, _mm512_fmadd_pd, _mm512_fnmadd_pd, _mm512_loadu_pd, _mm512_mask_blend_pd,
    _mm512_maskz_loadu_pd, _mm512_maskz_mov_pd, _mm512_max_pd, _mm512_min_pd, _mm512_mul_pd, _mm512_set1_pd,
    _mm512_sub_pd,
};

/// Combines eight lanes, upper half with lower half, again and again.
#[inline(always)]
fn fold(
    [low, high]: [__m256d; 2],
    wide: impl Fn(__m256d, __m256d) -> __m256d,
    narrow: impl Fn(__m128d, __m128d) -> __m128d,
) -> f64 {
    let four = wide(low, high);
    unsafe {
        let two = narrow(_mm256_castpd256_pd128(four), _mm256_extractf128_pd::<1>(four));
        _mm_cvtsd_f64(narrow(two, _mm_unpackhi_pd(two, two)))
    }
}

/// Eight doubles in one register.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Zmm(__m512d);

/// A bit per lane.
#[derive(Clone, Copy, Debug)]
pub struct Bits(u8);

impl Mask for Bits {
    const NONE: Self = Self(0);
    const ALL: Self = Self(u8::MAX);

    #[inline(always)]
    fn get(&self, l: usize) -> bool {
        self.0 >> l & 1 == 1
    }
    #[inline(always)]
    fn set(&mut self, l: usize, yes: bool) {
        self.0 = self.0 & !(1 << l) | u8::from(yes) << l;
    }
    #[inline(always)]
    fn and(self, x: Self) -> Self {
        Self(self.0 & x.0)
    }
    #[inline(always)]
    fn or(self, x: Self) -> Self {
        Self(self.0 | x.0)
    }
    #[inline(always)]
    fn xor(self, x: Self) -> Self {
        Self(self.0 ^ x.0)
    }
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
    #[inline(always)]
    fn choose(self, yes: Self, no: Self) -> Self {
        Self(self.0 & yes.0 | !self.0 & no.0)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
}

impl Zmm {
    #[inline(always)]
    fn halves(self) -> [__m256d; 2] {
        unsafe { [_mm512_castpd512_pd256(self.0), _mm512_extractf64x4_pd::<1>(self.0)] }
    }

    #[inline(always)]
    fn numbers(&self) -> &[f64; 8] {
        // SAFETY: a register is eight doubles in memory, in order.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }
}

// SAFETY of every block below: see the head of this file.
impl Lane for Zmm {
    type Number = f64;
    type Mask = Bits;
    const LANES: usize = 8;
    const EPS: f64 = f64::EPSILON;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self(unsafe { _mm512_set1_pd(x) })
    }
    #[inline(always)]
    fn from_slice(x: &[f64]) -> Self {
        let x8 = x.len().min(8);
        if x8 == 8 {
            return Self(unsafe { _mm512_loadu_pd(x.as_ptr()) });
        }
        // Lanes beyond the slice are not read.
        Self(unsafe { _mm512_maskz_loadu_pd((1 << x8) - 1, x.as_ptr()) })
    }
    #[inline(always)]
    fn get(&self, l: usize) -> f64 {
        self.numbers()[l]
    }
    #[inline(always)]
    fn set(&mut self, l: usize, x: f64) {
        // SAFETY: as `numbers`.
        let numbers: &mut [f64; 8] = unsafe { &mut *std::ptr::from_mut(self).cast() };
        numbers[l] = x;
    }
    #[inline(always)]
    fn sum(self) -> f64 {
        fold(self.halves(), |a, b| unsafe { _mm256_add_pd(a, b) }, |a, b| unsafe { _mm_add_pd(a, b) })
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        fold(self.halves(), |a, b| unsafe { _mm256_max_pd(a, b) }, |a, b| unsafe { _mm_max_pd(a, b) })
    }
    #[inline(always)]
    fn smallest(self) -> f64 {
        fold(self.halves(), |a, b| unsafe { _mm256_min_pd(a, b) }, |a, b| unsafe { _mm_min_pd(a, b) })
    }
    #[inline(always)]
    fn add(self, x: Self) -> Self {
        Self(unsafe { _mm512_add_pd(self.0, x.0) })
    }
    #[inline(always)]
    fn sub(self, x: Self) -> Self {
        Self(unsafe { _mm512_sub_pd(self.0, x.0) })
    }
    #[inline(always)]
    fn mul(self, x: Self) -> Self {
        Self(unsafe { _mm512_mul_pd(self.0, x.0) })
    }
    #[inline(always)]
    fn div(self, x: Self) -> Self {
        Self(unsafe { _mm512_div_pd(self.0, x.0) })
    }
    #[inline(always)]
    fn add_product(self, a: Self, b: Self) -> Self {
        Self(unsafe { _mm512_fmadd_pd(a.0, b.0, self.0) })
    }
    #[inline(always)]
    fn sub_product(self, a: Self, b: Self) -> Self {
        Self(unsafe { _mm512_fnmadd_pd(a.0, b.0, self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_abs_pd(self.0) })
    }
    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm512_sub_pd(_mm512_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn max(self, x: Self) -> Self {
        Self(unsafe { _mm512_max_pd(self.0, x.0) })
    }
    #[inline(always)]
    fn min(self, x: Self) -> Self {
        Self(unsafe { _mm512_min_pd(self.0, x.0) })
    }
    #[inline(always)]
    fn lt(self, x: Self) -> Bits {
        Bits(unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, x.0) })
    }
    #[inline(always)]
    fn le(self, x: Self) -> Bits {
        Bits(unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, x.0) })
    }
    #[inline(always)]
    fn eq(self, x: Self) -> Bits {
        Bits(unsafe { _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(self.0, x.0) })
    }
    #[inline(always)]
    fn only(self, mask: Bits) -> Self {
        Self(unsafe { _mm512_maskz_mov_pd(mask.0, self.0) })
    }
    #[inline(always)]
    fn or_else(self, mask: Bits, x: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_pd(mask.0, x.0, self.0) })
    }
}

/// Eight doubles in two registers.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Ymm2([__m256d; 2]);

/// All bits or none, lane by lane.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct YmmMask([__m256d; 2]);

impl YmmMask {
    #[inline(always)]
    fn words(&self) -> &[u64; 8] {
        // SAFETY: two registers are eight words in memory, in order.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }

    #[inline(always)]
    fn each(self, x: Self, f: impl Fn(__m256d, __m256d) -> __m256d) -> Self {
        Self([f(self.0[0], x.0[0]), f(self.0[1], x.0[1])])
    }
}

impl Mask for YmmMask {
    // SAFETY: any bits are doubles.
    const NONE: Self = Self([unsafe { std::mem::transmute::<[u64; 4], __m256d>([0; 4]) }; 2]);
    const ALL: Self = Self([unsafe { std::mem::transmute::<[u64; 4], __m256d>([u64::MAX; 4]) }; 2]);

    #[inline(always)]
    fn get(&self, l: usize) -> bool {
        self.words()[l] != 0
    }
    #[inline(always)]
    fn set(&mut self, l: usize, yes: bool) {
        // SAFETY: as `words`.
        let words: &mut [u64; 8] = unsafe { &mut *std::ptr::from_mut(self).cast() };
        words[l] = if yes { u64::MAX } else { 0 };
    }
    #[inline(always)]
    fn and(self, x: Self) -> Self {
        self.each(x, |a, b| unsafe { _mm256_and_pd(a, b) })
    }
    #[inline(always)]
    fn or(self, x: Self) -> Self {
        self.each(x, |a, b| unsafe { _mm256_or_pd(a, b) })
    }
    #[inline(always)]
    fn xor(self, x: Self) -> Self {
        self.each(x, |a, b| unsafe { _mm256_xor_pd(a, b) })
    }
    #[inline(always)]
    fn not(self) -> Self {
        self.each(Self::ALL, |a, b| unsafe { _mm256_andnot_pd(a, b) })
    }
    #[inline(always)]
    fn choose(self, yes: Self, no: Self) -> Self {
        self.and(yes).or(self.not().and(no))
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        unsafe { (_mm256_movemask_pd(self.0[0]) | _mm256_movemask_pd(self.0[1]) << 4) as u32 }
    }
}

impl Ymm2 {
    #[inline(always)]
    fn numbers(&self) -> &[f64; 8] {
        // SAFETY: two registers are eight doubles in memory, in order.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }

    #[inline(always)]
    fn each(self, x: Self, f: impl Fn(__m256d, __m256d) -> __m256d) -> Self {
        Self([f(self.0[0], x.0[0]), f(self.0[1], x.0[1])])
    }
}

impl Lane for Ymm2 {
    type Number = f64;
    type Mask = YmmMask;
    const LANES: usize = 8;
    const EPS: f64 = f64::EPSILON;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([unsafe { _mm256_set1_pd(x) }; 2])
    }
    #[inline(always)]
    fn from_slice(x: &[f64]) -> Self {
        if let Some(whole) = x.first_chunk::<8>() {
            return Self(unsafe { [_mm256_loadu_pd(whole.as_ptr()), _mm256_loadu_pd(whole.as_ptr().add(4))] });
        }
        let mut out = Self::splat(0.0);
        for (l, x) in x.iter().enumerate() {
            out.set(l, *x);
        }
        out
    }
    #[inline(always)]
    fn get(&self, l: usize) -> f64 {
        self.numbers()[l]
    }
    #[inline(always)]
    fn set(&mut self, l: usize, x: f64) {
        // SAFETY: as `numbers`.
        let numbers: &mut [f64; 8] = unsafe { &mut *std::ptr::from_mut(self).cast() };
        numbers[l] = x;
    }
    #[inline(always)]
    fn sum(self) -> f64 {
        fold(self.0, |a, b| unsafe { _mm256_add_pd(a, b) }, |a, b| unsafe { _mm_add_pd(a, b) })
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        fold(self.0, |a, b| unsafe { _mm256_max_pd(a, b) }, |a, b| unsafe { _mm_max_pd(a, b) })
    }
    #[inline(always)]
    fn smallest(self) -> f64 {
        fold(self.0, |a, b| unsafe { _mm256_min_pd(a, b) }, |a, b| unsafe { _mm_min_pd(a, b) })
    }
    #[inline(always)]
    fn add(self, x: Self) -> Self {
        self.each(x, |a, b| unsafe { _mm256_add_pd(a, b) })
    }
    #[inline(always)]
    fn sub(self, x: Self) -> Self {
        self.each(x, |a, b| unsafe { _mm256_sub_pd(a, b) })
    }
    #[inline(always)]
    fn mul(self, x: Self) -> Self {
        self.each(x, |a, b| unsafe { _mm256_mul_pd(a, b) })
    }
    #[inline(always)]
    fn div(self, x: Self) -> Self {
        self.each(x, |a, b| unsafe { _mm256_div_pd(a, b) })
    }
    #[inline(always)]
    fn add_product(self, a: Self, b: Self) -> Self {
        Self([0, 1].map(|h| unsafe { _mm256_fmadd_pd(a.0[h], b.0[h], self.0[h]) }))
    }
    #[inline(always)]
    fn sub_product(self, a: Self, b: Self) -> Self {
        Self([0, 1].map(|h| unsafe { _mm256_fnmadd_pd(a.0[h], b.0[h], self.0[h]) }))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.each(self, |a, _| unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), a) })
    }
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(self, |a, _| unsafe { _mm256_sub_pd(_mm256_set1_pd(-0.0), a) })
    }
    #[inline(always)]
    fn max(self, x: Self) -> Self {
        self.each(x, |a, b| unsafe { _mm256_max_pd(a, b) })
    }
    #[inline(always)]
    fn min(self, x: Self) -> Self {
        self.each(x, |a, b| unsafe { _mm256_min_pd(a, b) })
    }
    #[inline(always)]
    fn lt(self, x: Self) -> YmmMask {
        YmmMask(self.each(x, |a, b| unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(a, b) }).0)
    }
    #[inline(always)]
    fn le(self, x: Self) -> YmmMask {
        YmmMask(self.each(x, |a, b| unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(a, b) }).0)
    }
    #[inline(always)]
    fn eq(self, x: Self) -> YmmMask {
        YmmMask(self.each(x, |a, b| unsafe { _mm256_cmp_pd::<_CMP_EQ_OQ>(a, b) }).0)
    }
    #[inline(always)]
    fn only(self, mask: YmmMask) -> Self {
        self.each(Self(mask.0), |a, m| unsafe { _mm256_and_pd(a, m) })
    }
    #[inline(always)]
    fn or_else(self, mask: YmmMask, x: Self) -> Self {
        Self([0, 1].map(|h| unsafe { _mm256_blendv_pd(x.0[h], self.0[h], mask.0[h]) }))
    }
}
