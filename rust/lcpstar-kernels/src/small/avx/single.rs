//! Single precision: [`Places`] and macros of the parent.

use super::Places;
use crate::small::lane::{BLOCK, Lane, Mask};
use std::arch::x86_64::{
    __m256, __m256i, __m512, __m512i, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_ps, _mm256_and_ps,
    _mm256_andnot_ps, _mm256_blendv_ps, _mm256_castpd_ps, _mm256_castps_pd, _mm256_cmp_ps, _mm256_cvttps_epi32,
    _mm256_div_ps, _mm256_fmadd_ps, _mm256_fnmadd_ps, _mm256_loadu_ps, _mm256_maskz_loadu_ps, _mm256_max_ps,
    _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_or_ps, _mm256_permute2f128_ps, _mm256_set1_ps,
    _mm256_setr_ps, _mm256_setzero_ps, _mm256_shuffle_ps, _mm256_storeu_ps, _mm256_sub_ps, _mm256_unpackhi_ps,
    _mm256_unpacklo_ps, _mm256_xor_ps, _mm512_abs_ps, _mm512_add_ps, _mm512_castpd_ps, _mm512_castpd256_pd512,
    _mm512_castpd512_pd256, _mm512_castps_pd, _mm512_cmp_ps_mask, _mm512_cvttps_epi32, _mm512_div_ps,
    _mm512_extractf64x4_pd, _mm512_fmadd_ps, _mm512_fnmadd_ps, _mm512_insertf64x4, _mm512_mask_blend_ps,
    _mm512_maskz_mov_ps, _mm512_max_ps, _mm512_min_ps, _mm512_mul_ps, _mm512_set1_ps, _mm512_setr_ps, _mm512_sub_ps,
};
use std::mem::transmute;

/// Number after number: no kernel folds floats.
macro_rules! folds {
    () => {
        #[inline(always)]
        fn sum(self) -> f64 {
            self.numbers().iter().copied().map(f64::from).sum()
        }
        #[inline(always)]
        fn largest(self) -> f64 {
            f64::from(self.numbers().iter().copied().fold(f32::NEG_INFINITY, f32::max))
        }
        #[inline(always)]
        fn smallest(self) -> f64 {
            f64::from(self.numbers().iter().copied().fold(f32::INFINITY, f32::min))
        }
    };
}

/// Sixteen floats in one register.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct ZmmS(__m512);

bits!(WideBits, u16, 16);

numbers!(ZmmS, f32, 16);

impl Lane for ZmmS {
    type Index = Places<16>;

    operations!(
        f32,
        16,
        WideBits,
        _mm512_cmp_ps_mask,
        _mm512_set1_ps,
        _mm512_fmadd_ps,
        _mm512_fnmadd_ps,
        add = _mm512_add_ps,
        sub = _mm512_sub_ps,
        mul = _mm512_mul_ps,
        div = _mm512_div_ps,
        max = _mm512_max_ps,
        min = _mm512_min_ps
    );

    #[inline(always)]
    fn from_slice(x: &[f32]) -> Self {
        let mut out = Self::splat(0.0);
        for (l, x) in x.iter().enumerate().take(16) {
            out.set(l, *x);
        }
        out
    }
    #[inline(always)]
    fn load_columns(rows: &[&[f32]], first: usize, out: &mut [Self]) {
        let mut v = [unsafe { _mm256_setzero_ps() }; 8];
        let mut halves = [v; 2];
        for (h, half) in halves.iter_mut().enumerate() {
            for l in 0..8 {
                // Numbers beyond the row are not read.
                let row = &rows[8 * h + l][first..first + out.len()];
                v[l] = unsafe { _mm256_maskz_loadu_ps(u8::MAX >> (8 - row.len()), row.as_ptr()) };
            }
            *half = transpose_floats(v);
        }
        for (k, out) in out.iter_mut().enumerate() {
            let (low, high) = unsafe { (_mm256_castps_pd(halves[0][k]), _mm256_castps_pd(halves[1][k])) };
            out.0 = unsafe { _mm512_castpd_ps(_mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high)) };
        }
    }
    #[inline(always)]
    fn store_columns(columns: &[Self], rows: &mut [f32], stride: usize) {
        for h in 0..2 {
            let mut v = [unsafe { _mm256_setzero_ps() }; 8];
            for (k, column) in columns.iter().enumerate().take(8) {
                let whole = unsafe { _mm512_castps_pd(column.0) };
                v[k] = unsafe {
                    _mm256_castpd_ps(if h == 0 {
                        _mm512_castpd512_pd256(whole)
                    } else {
                        _mm512_extractf64x4_pd::<1>(whole)
                    })
                };
            }
            let v = transpose_floats(v);
            for l in 0..8 {
                let first = (8 * h + l) * stride;
                let row = &mut rows[first..first + BLOCK];
                unsafe { _mm256_storeu_ps(row.as_mut_ptr(), v[l]) };
            }
        }
    }
    #[inline(always)]
    fn index(self, limit: usize, stride: usize) -> Places<16> {
        let place = self.max(Self::splat(0.0)).min(Self::splat((limit - 1) as f64));
        // SAFETY: sixteen integers are sixteen integers.
        Places::new(unsafe { transmute::<__m512i, [u32; 16]>(_mm512_cvttps_epi32(place.0)) }, limit, stride)
    }
    #[inline(always)]
    fn pick(v: &[Self], at: Places<16>) -> Self {
        pick!(v, at, f32, _mm512_setr_ps, 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15)
    }
    folds!();
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_abs_ps(self.0) })
    }
    #[inline(always)]
    fn only(self, mask: WideBits) -> Self {
        Self(unsafe { _mm512_maskz_mov_ps(mask.0, self.0) })
    }
    #[inline(always)]
    fn or_else(self, mask: WideBits, x: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_ps(mask.0, x.0, self.0) })
    }
}

/// As [`transpose_zmm`], eight floats by eight.
#[inline(always)]
fn transpose_floats(v: [__m256; 8]) -> [__m256; 8] {
    let (mut pairs, mut fours, mut out) = (v, v, v);
    unsafe {
        for k in 0..4 {
            pairs[2 * k] = _mm256_unpacklo_ps(v[2 * k], v[2 * k + 1]);
            pairs[2 * k + 1] = _mm256_unpackhi_ps(v[2 * k], v[2 * k + 1]);
        }
        for k in 0..2 {
            let [a, b, c, d] = [pairs[4 * k], pairs[4 * k + 1], pairs[4 * k + 2], pairs[4 * k + 3]];
            fours[4 * k] = _mm256_shuffle_ps::<0x44>(a, c);
            fours[4 * k + 1] = _mm256_shuffle_ps::<0xee>(a, c);
            fours[4 * k + 2] = _mm256_shuffle_ps::<0x44>(b, d);
            fours[4 * k + 3] = _mm256_shuffle_ps::<0xee>(b, d);
        }
        for k in 0..4 {
            out[k] = _mm256_permute2f128_ps::<0x20>(fours[k], fours[k + 4]);
            out[k + 4] = _mm256_permute2f128_ps::<0x31>(fours[k], fours[k + 4]);
        }
    }
    out
}

/// Eight floats in one register of AVX2.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct YmmS(__m256);

numbers!(YmmS, f32, 8);
words!(YmmSMask, __m256, u32, 8, _mm256_and_ps, _mm256_or_ps, _mm256_xor_ps, _mm256_movemask_ps);

impl Lane for YmmS {
    type Index = Places<8>;

    operations!(
        f32,
        8,
        YmmSMask,
        _mm256_cmp_ps,
        _mm256_set1_ps,
        _mm256_fmadd_ps,
        _mm256_fnmadd_ps,
        add = _mm256_add_ps,
        sub = _mm256_sub_ps,
        mul = _mm256_mul_ps,
        div = _mm256_div_ps,
        max = _mm256_max_ps,
        min = _mm256_min_ps
    );

    #[inline(always)]
    fn from_slice(x: &[f32]) -> Self {
        if let Some(whole) = x.first_chunk::<8>() {
            return Self(unsafe { _mm256_loadu_ps(whole.as_ptr()) });
        }
        let mut out = Self::splat(0.0);
        for (l, x) in x.iter().enumerate() {
            out.set(l, *x);
        }
        out
    }
    #[inline(always)]
    fn load_columns(rows: &[&[f32]], first: usize, out: &mut [Self]) {
        let mut v = [unsafe { _mm256_setzero_ps() }; 8];
        for l in 0..8 {
            v[l] = Self::from_slice(&rows[l][first..first + out.len()]).0;
        }
        let v = transpose_floats(v);
        for (k, out) in out.iter_mut().enumerate().take(8) {
            out.0 = v[k];
        }
    }
    #[inline(always)]
    fn store_columns(columns: &[Self], rows: &mut [f32], stride: usize) {
        let mut v = [unsafe { _mm256_setzero_ps() }; 8];
        for (k, column) in columns.iter().enumerate().take(8) {
            v[k] = column.0;
        }
        let v = transpose_floats(v);
        for l in 0..8 {
            let row = &mut rows[l * stride..l * stride + BLOCK];
            unsafe { _mm256_storeu_ps(row.as_mut_ptr(), v[l]) };
        }
    }
    #[inline(always)]
    fn index(self, limit: usize, stride: usize) -> Places<8> {
        let place = self.max(Self::splat(0.0)).min(Self::splat((limit - 1) as f64));
        // SAFETY: eight integers are eight integers.
        Places::new(unsafe { transmute::<__m256i, [u32; 8]>(_mm256_cvttps_epi32(place.0)) }, limit, stride)
    }
    #[inline(always)]
    fn pick(v: &[Self], at: Places<8>) -> Self {
        pick!(v, at, f32, _mm256_setr_ps, 0 1 2 3 4 5 6 7)
    }
    folds!();
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_ps(Self::splat(-0.0).0, self.0) })
    }
    #[inline(always)]
    fn only(self, mask: YmmSMask) -> Self {
        Self(unsafe { _mm256_and_ps(self.0, mask.0) })
    }
    #[inline(always)]
    fn or_else(self, mask: YmmSMask, x: Self) -> Self {
        Self(unsafe { _mm256_blendv_ps(x.0, self.0, mask.0) })
    }
}
