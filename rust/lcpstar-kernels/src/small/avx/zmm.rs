//! Eight doubles in a register of AVX-512: [`Places`], and macros of the parent.

use super::Ymm;
use super::places::Places;
use crate::small::lane::{BLOCK, Lane, Mask};
use std::arch::x86_64::{
    __m256i, __m512d, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _MM_FROUND_NO_EXC, _MM_FROUND_TO_ZERO, _mm256_loadu_pd,
    _mm512_abs_pd, _mm512_add_pd, _mm512_castpd256_pd512, _mm512_castpd512_pd256, _mm512_cmp_pd_mask,
    _mm512_cvttpd_epi32, _mm512_div_pd, _mm512_extractf64x4_pd, _mm512_fmadd_pd, _mm512_fnmadd_pd, _mm512_getexp_pd,
    _mm512_insertf64x4, _mm512_loadu_pd, _mm512_mask_blend_pd, _mm512_maskz_loadu_pd, _mm512_maskz_mov_pd,
    _mm512_max_pd, _mm512_min_pd, _mm512_mul_pd, _mm512_roundscale_pd, _mm512_scalef_pd, _mm512_set1_pd,
    _mm512_setr_pd, _mm512_shuffle_f64x2, _mm512_storeu_pd, _mm512_sub_pd, _mm512_unpackhi_pd, _mm512_unpacklo_pd,
};
use std::mem::transmute;

/// Eight doubles in one register.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Zmm(__m512d);

numbers!(Zmm, 8);

/// A bit per lane.
#[derive(Clone, Copy, Debug)]
pub struct Bits(u8);

impl Mask for Bits {
    const LANES: usize = 8;
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
    fn from_bits(bits: u32) -> Self {
        Self(bits as u8)
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

/// The sum, largest or smallest of the lanes: upper half with lower half, again and again.
macro_rules! fold_zmm {
    ($x:expr, $wide:ident) => {{
        let (low, high) = unsafe { (_mm512_castpd512_pd256($x), _mm512_extractf64x4_pd::<1>($x)) };
        Ymm(low).$wide(Ymm(high))
    }};
}

/// Number l of vector k and number k of vector l change places.
#[inline(always)]
fn transpose_zmm(v: [__m512d; 8]) -> [__m512d; 8] {
    let (mut pairs, mut out) = (v, v);
    unsafe {
        for k in 0..4 {
            pairs[2 * k] = _mm512_unpacklo_pd(v[2 * k], v[2 * k + 1]);
            pairs[2 * k + 1] = _mm512_unpackhi_pd(v[2 * k], v[2 * k + 1]);
        }
        for k in 0..2 {
            let [a, b, c, d] = [pairs[k], pairs[k + 2], pairs[k + 4], pairs[k + 6]];
            let (ab0, ab1) = (_mm512_shuffle_f64x2::<0x88>(a, b), _mm512_shuffle_f64x2::<0xdd>(a, b));
            let (cd0, cd1) = (_mm512_shuffle_f64x2::<0x88>(c, d), _mm512_shuffle_f64x2::<0xdd>(c, d));
            out[k] = _mm512_shuffle_f64x2::<0x88>(ab0, cd0);
            out[k + 4] = _mm512_shuffle_f64x2::<0xdd>(ab0, cd0);
            out[k + 2] = _mm512_shuffle_f64x2::<0x88>(ab1, cd1);
            out[k + 6] = _mm512_shuffle_f64x2::<0xdd>(ab1, cd1);
        }
    }
    out
}

// SAFETY of every block below: see the head of `avx`.
impl Lane for Zmm {
    type Index = Places<8>;

    operations!(
        8,
        Bits,
        _mm512_cmp_pd_mask,
        _mm512_set1_pd,
        _mm512_fmadd_pd,
        _mm512_fnmadd_pd,
        add = _mm512_add_pd,
        sub = _mm512_sub_pd,
        mul = _mm512_mul_pd,
        div = _mm512_div_pd,
        max = _mm512_max_pd,
        min = _mm512_min_pd
    );

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
    fn load_columns(rows: &[&[f64]], first: usize, out: &mut [Self]) {
        if out.len() == 8 {
            // Two rows meet in a register on their way from memory, which leaves half the shuffles.
            let mut v = [Self::splat(0.0).0; 8];
            for (k, v) in v.iter_mut().enumerate() {
                let (l, half) = (4 * (k / 2 % 2) + k % 2, first + 4 * (k / 4));
                let (upper, lower) = (&rows[l][half..half + 4], &rows[l + 2][half..half + 4]);
                *v = unsafe {
                    let upper = _mm512_castpd256_pd512(_mm256_loadu_pd(upper.as_ptr()));
                    _mm512_insertf64x4::<1>(upper, _mm256_loadu_pd(lower.as_ptr()))
                };
            }
            for (k, pairs) in v.as_chunks::<4>().0.iter().enumerate() {
                let [a, b, c, d] = *pairs;
                unsafe {
                    let (ab, cd) = (_mm512_unpacklo_pd(a, b), _mm512_unpacklo_pd(c, d));
                    out[4 * k].0 = _mm512_shuffle_f64x2::<0x88>(ab, cd);
                    out[4 * k + 2].0 = _mm512_shuffle_f64x2::<0xdd>(ab, cd);
                    let (ab, cd) = (_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d));
                    out[4 * k + 1].0 = _mm512_shuffle_f64x2::<0x88>(ab, cd);
                    out[4 * k + 3].0 = _mm512_shuffle_f64x2::<0xdd>(ab, cd);
                }
            }
            return;
        }
        let mut v = [Self::splat(0.0).0; 8];
        for l in 0..8 {
            v[l] = Self::from_slice(&rows[l][first..first + out.len()]).0;
        }
        let v = transpose_zmm(v);
        for (k, out) in out.iter_mut().enumerate().take(8) {
            out.0 = v[k];
        }
    }
    #[inline(always)]
    fn store_columns(columns: &[Self], rows: &mut [f64], stride: usize) {
        let mut v = [Self::splat(0.0).0; 8];
        for (k, column) in columns.iter().enumerate().take(8) {
            v[k] = column.0;
        }
        let v = transpose_zmm(v);
        for l in 0..8 {
            let row = &mut rows[l * stride..l * stride + BLOCK];
            unsafe { _mm512_storeu_pd(row.as_mut_ptr(), v[l]) };
        }
    }
    #[inline(always)]
    fn index(self, limit: usize, stride: usize) -> Places<8> {
        let place = self.max(Self::splat(0.0)).min(Self::splat((limit - 1) as f64));
        // SAFETY: eight integers are eight integers.
        Places::new(unsafe { transmute::<__m256i, [u32; 8]>(_mm512_cvttpd_epi32(place.0)) }, limit, stride)
    }
    #[inline(always)]
    fn pick(v: &[Self], at: Places<8>) -> Self {
        pick!(v, at, _mm512_setr_pd, 0 1 2 3 4 5 6 7)
    }
    #[inline(always)]
    fn sum(self) -> f64 {
        fold_zmm!(self.0, add).sum()
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        fold_zmm!(self.0, max).largest()
    }
    #[inline(always)]
    fn smallest(self) -> f64 {
        fold_zmm!(self.0, min).smallest()
    }
    #[inline(always)]
    fn exponent(self) -> Self {
        Self(unsafe { _mm512_add_pd(_mm512_getexp_pd(self.0), Self::splat(1.0).0) })
    }
    #[inline(always)]
    fn truncated(self) -> Self {
        Self(unsafe { _mm512_roundscale_pd::<{ _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC }>(self.0) })
    }
    #[inline(always)]
    fn two_to(self) -> Self {
        Self(unsafe { _mm512_scalef_pd(Self::splat(1.0).0, self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_abs_pd(self.0) })
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
