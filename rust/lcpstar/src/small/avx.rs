//! The lanes of [`lane`](super::lane) in registers of AVX-512 and AVX2, same bits as `F64x8<true>`.
//!
//! The compiler vectorises the portable lanes well in short kernels and poorly in long ones; naming the instructions
//! makes the speed predictable. Nothing here checks that the machine has them: `work` and `small` choose a type only
//! in functions compiled for, and entered on, machines that do.
#![allow(unsafe_code, reason = "instructions of the machine; see above for who may call them")]

use super::lane::{BLOCK, Lane, Mask, Pair};
use std::arch::x86_64::{
    __m128i, __m256, __m256d, __m256i, __m512, __m512d, __m512i, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm_add_epi32,
    _mm_add_pd, _mm_cvtsd_f64, _mm_max_pd, _mm_min_pd, _mm_mullo_epi32, _mm_set1_epi32, _mm_setr_epi32,
    _mm_unpackhi_pd, _mm256_add_epi32, _mm256_add_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd,
    _mm256_castpd_ps, _mm256_castpd256_pd128, _mm256_castps_pd, _mm256_cmp_pd, _mm256_cvttpd_epi32, _mm256_div_pd,
    _mm256_extractf128_pd, _mm256_fmadd_pd, _mm256_fnmadd_pd, _mm256_i32gather_pd, _mm256_loadu_pd,
    _mm256_maskz_loadu_ps, _mm256_max_pd, _mm256_min_pd, _mm256_movemask_pd, _mm256_mul_pd, _mm256_mullo_epi32,
    _mm256_or_pd, _mm256_permute2f128_pd, _mm256_permute2f128_ps, _mm256_set1_epi32, _mm256_set1_pd, _mm256_setr_epi32,
    _mm256_setzero_ps, _mm256_shuffle_ps, _mm256_storeu_pd, _mm256_storeu_ps, _mm256_sub_pd, _mm256_unpackhi_pd,
    _mm256_unpackhi_ps, _mm256_unpacklo_pd, _mm256_unpacklo_ps, _mm256_xor_pd, _mm512_abs_pd, _mm512_abs_ps,
    _mm512_add_epi32, _mm512_add_pd, _mm512_add_ps, _mm512_castpd_ps, _mm512_castpd256_pd512, _mm512_castpd512_pd256,
    _mm512_castps_pd, _mm512_cmp_pd_mask, _mm512_cmp_ps_mask, _mm512_cvttpd_epi32, _mm512_cvttps_epi32, _mm512_div_pd,
    _mm512_div_ps, _mm512_extractf64x4_pd, _mm512_fmadd_pd, _mm512_fmadd_ps, _mm512_fnmadd_pd, _mm512_fnmadd_ps,
    _mm512_i32gather_pd, _mm512_i32gather_ps, _mm512_insertf64x4, _mm512_loadu_pd, _mm512_mask_blend_pd,
    _mm512_mask_blend_ps, _mm512_maskz_loadu_pd, _mm512_maskz_mov_pd, _mm512_maskz_mov_ps, _mm512_max_pd,
    _mm512_max_ps, _mm512_min_pd, _mm512_min_ps, _mm512_mul_pd, _mm512_mul_ps, _mm512_mullo_epi32, _mm512_set1_epi32,
    _mm512_set1_pd, _mm512_set1_ps, _mm512_setr_epi32, _mm512_shuffle_f64x2, _mm512_storeu_pd, _mm512_sub_pd,
    _mm512_sub_ps, _mm512_unpackhi_pd, _mm512_unpacklo_pd,
};

/// Eight doubles in two registers of AVX2.
pub type Ymm2 = Pair<Ymm>;

/// The operations of [`Lane`] that differ between registers by the instruction only.
macro_rules! operations {
    ($number:ident, $lanes:literal, $mask:ident, $compare:ident, $splat:ident, $fma:ident, $fnma:ident, $($name:ident = $instruction:ident),*) => {
        type Number = $number;
        type Mask = $mask;
        const LANES: usize = $lanes;
        const EPS: f64 = $number::EPSILON as f64;

        $(#[inline(always)]
        fn $name(self, x: Self) -> Self {
            Self(unsafe { $instruction(self.0, x.0) })
        })*
        #[inline(always)]
        fn splat(x: f64) -> Self {
            Self(unsafe { $splat(x as $number) })
        }
        #[inline(always)]
        fn add_product(self, a: Self, b: Self) -> Self {
            Self(unsafe { $fma(a.0, b.0, self.0) })
        }
        #[inline(always)]
        fn sub_product(self, a: Self, b: Self) -> Self {
            Self(unsafe { $fnma(a.0, b.0, self.0) })
        }
        #[inline(always)]
        fn neg(self) -> Self {
            Self::splat(-0.0).sub(self)
        }
        #[inline(always)]
        fn lt(self, x: Self) -> $mask {
            $mask(unsafe { $compare::<_CMP_LT_OQ>(self.0, x.0) })
        }
        #[inline(always)]
        fn le(self, x: Self) -> $mask {
            $mask(unsafe { $compare::<_CMP_LE_OQ>(self.0, x.0) })
        }
        #[inline(always)]
        fn eq(self, x: Self) -> $mask {
            $mask(unsafe { $compare::<_CMP_EQ_OQ>(self.0, x.0) })
        }
        #[inline(always)]
        fn get(&self, l: usize) -> f64 {
            f64::from(self.numbers()[l])
        }
        #[inline(always)]
        fn set(&mut self, l: usize, x: $number) {
            self.numbers_mut()[l] = x;
        }
        #[inline(always)]
        fn set_from(&mut self, l: usize, x: &Self) {
            self.numbers_mut()[l] = x.numbers()[l];
        }
    };
}

/// A register as numbers in memory.
macro_rules! numbers {
    ($register:ident, $number:ident, $lanes:literal) => {
        impl $register {
            #[inline(always)]
            fn numbers(&self) -> &[$number; $lanes] {
                // SAFETY: a register is its numbers in memory, in order.
                unsafe { &*std::ptr::from_ref(self).cast() }
            }

            #[inline(always)]
            fn numbers_mut(&mut self) -> &mut [$number; $lanes] {
                // SAFETY: as `numbers`.
                unsafe { &mut *std::ptr::from_mut(self).cast() }
            }
        }
    };
}

/// Eight doubles in one register.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Zmm(__m512d);

numbers!(Zmm, f64, 8);

/// A bit per lane.
macro_rules! bits {
    ($mask:ident, $bits:ty, $lanes:literal) => {
        /// A bit per lane.
        #[derive(Clone, Copy, Debug)]
        pub struct $mask($bits);

        impl Mask for $mask {
            const LANES: usize = $lanes;
            const NONE: Self = Self(0);
            const ALL: Self = Self(<$bits>::MAX);

            #[inline(always)]
            fn get(&self, l: usize) -> bool {
                self.0 >> l & 1 == 1
            }
            #[inline(always)]
            fn set(&mut self, l: usize, yes: bool) {
                self.0 = self.0 & !(1 << l) | <$bits>::from(yes) << l;
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                Self(bits as $bits)
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
    };
}

bits!(Bits, u8, 8);
bits!(WideBits, u16, 16);

/// Places of numbers, all in the first `span` vectors.
#[derive(Clone, Copy, Debug)]
pub struct ZmmIndex {
    numbers: __m256i,
    span: usize,
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

// SAFETY of every block below: see the head of this file.
impl Lane for Zmm {
    type Index = ZmmIndex;

    operations!(
        f64,
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
    fn load_columns(rows: &[&[f64]], out: &mut [Self]) {
        let mut v = [Self::splat(0.0).0; 8];
        for l in 0..8 {
            v[l] = Self::from_slice(&rows[l][..out.len()]).0;
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
    fn index(self, limit: usize, stride: usize) -> ZmmIndex {
        let place = self.max(Self::splat(0.0)).min(Self::splat((limit - 1) as f64));
        let numbers = unsafe {
            let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let vectors = _mm256_mullo_epi32(_mm512_cvttpd_epi32(place.0), _mm256_set1_epi32(8 * stride as i32));
            _mm256_add_epi32(vectors, lanes)
        };
        ZmmIndex { numbers, span: (limit - 1) * stride + 1 }
    }
    #[inline(always)]
    fn pick(v: &[Self], at: ZmmIndex) -> Self {
        assert!(v.len() >= at.span);
        Self(unsafe { _mm512_i32gather_pd::<8>(at.numbers, v.as_ptr().cast()) })
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

/// Sixteen floats in one register.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct ZmmS(__m512);

numbers!(ZmmS, f32, 16);

/// Places of numbers, all in the first `span` vectors.
#[derive(Clone, Copy, Debug)]
pub struct ZmmSIndex {
    numbers: __m512i,
    span: usize,
}

impl Lane for ZmmS {
    type Index = ZmmSIndex;

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
    fn load_columns(rows: &[&[f32]], out: &mut [Self]) {
        let mut v = [unsafe { _mm256_setzero_ps() }; 8];
        let mut halves = [v; 2];
        for (h, half) in halves.iter_mut().enumerate() {
            for l in 0..8 {
                // Numbers beyond the row are not read.
                let row = &rows[8 * h + l][..out.len()];
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
    fn index(self, limit: usize, stride: usize) -> ZmmSIndex {
        let place = self.max(Self::splat(0.0)).min(Self::splat((limit - 1) as f64));
        let numbers = unsafe {
            let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            let vectors = _mm512_mullo_epi32(_mm512_cvttps_epi32(place.0), _mm512_set1_epi32(16 * stride as i32));
            _mm512_add_epi32(vectors, lanes)
        };
        ZmmSIndex { numbers, span: (limit - 1) * stride + 1 }
    }
    #[inline(always)]
    fn pick(v: &[Self], at: ZmmSIndex) -> Self {
        assert!(v.len() >= at.span);
        Self(unsafe { _mm512_i32gather_ps::<4>(at.numbers, v.as_ptr().cast()) })
    }
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

/// Four doubles in one register.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Ymm(__m256d);

numbers!(Ymm, f64, 4);

/// All bits or none, lane by lane.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct YmmMask(__m256d);

/// Places of numbers, all in the first `span` vectors.
#[derive(Clone, Copy, Debug)]
pub struct YmmIndex {
    numbers: __m128i,
    span: usize,
}

impl Mask for YmmMask {
    const LANES: usize = 4;
    // SAFETY: any bits are doubles.
    const NONE: Self = Self(unsafe { std::mem::transmute::<[u64; 4], __m256d>([0; 4]) });
    const ALL: Self = Self(unsafe { std::mem::transmute::<[u64; 4], __m256d>([u64::MAX; 4]) });

    #[inline(always)]
    fn get(&self, l: usize) -> bool {
        self.bits() >> l & 1 == 1
    }
    #[inline(always)]
    fn set(&mut self, l: usize, yes: bool) {
        // SAFETY: a register is four words in memory, in order.
        let words: &mut [u64; 4] = unsafe { &mut *std::ptr::from_mut(self).cast() };
        words[l] = if yes { u64::MAX } else { 0 };
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        let mut mask = Self::NONE;
        for l in 0..4 {
            mask.set(l, bits >> l & 1 == 1);
        }
        mask
    }
    #[inline(always)]
    fn and(self, x: Self) -> Self {
        Self(unsafe { _mm256_and_pd(self.0, x.0) })
    }
    #[inline(always)]
    fn or(self, x: Self) -> Self {
        Self(unsafe { _mm256_or_pd(self.0, x.0) })
    }
    #[inline(always)]
    fn xor(self, x: Self) -> Self {
        Self(unsafe { _mm256_xor_pd(self.0, x.0) })
    }
    #[inline(always)]
    fn not(self) -> Self {
        Self(unsafe { _mm256_xor_pd(self.0, Self::ALL.0) })
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
        unsafe { _mm256_movemask_pd(self.0) as u32 }
    }
}

/// As [`transpose_zmm`].
#[inline(always)]
fn transpose_ymm([a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
    unsafe {
        let (ab0, ab1) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
        let (cd0, cd1) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
        [
            _mm256_permute2f128_pd::<0x20>(ab0, cd0),
            _mm256_permute2f128_pd::<0x20>(ab1, cd1),
            _mm256_permute2f128_pd::<0x31>(ab0, cd0),
            _mm256_permute2f128_pd::<0x31>(ab1, cd1),
        ]
    }
}

impl Lane for Ymm {
    type Index = YmmIndex;

    operations!(
        f64,
        4,
        YmmMask,
        _mm256_cmp_pd,
        _mm256_set1_pd,
        _mm256_fmadd_pd,
        _mm256_fnmadd_pd,
        add = _mm256_add_pd,
        sub = _mm256_sub_pd,
        mul = _mm256_mul_pd,
        div = _mm256_div_pd,
        max = _mm256_max_pd,
        min = _mm256_min_pd
    );

    #[inline(always)]
    fn from_slice(x: &[f64]) -> Self {
        if let Some(whole) = x.first_chunk::<4>() {
            return Self(unsafe { _mm256_loadu_pd(whole.as_ptr()) });
        }
        let mut out = Self::splat(0.0);
        for (l, x) in x.iter().enumerate() {
            out.set(l, *x);
        }
        out
    }
    #[inline(always)]
    fn load_columns(rows: &[&[f64]], out: &mut [Self]) {
        for (b, out) in out.chunks_mut(4).enumerate() {
            let mut v = [Self::splat(0.0).0; 4];
            for l in 0..4 {
                v[l] = Self::from_slice(&rows[l][4 * b..4 * b + out.len()]).0;
            }
            let v = transpose_ymm(v);
            for (k, out) in out.iter_mut().enumerate() {
                out.0 = v[k];
            }
        }
    }
    #[inline(always)]
    fn store_columns(columns: &[Self], rows: &mut [f64], stride: usize) {
        // Backwards: a second half that is not whole reaches into the next rows.
        for (b, columns) in columns.chunks(4).enumerate().take(BLOCK / 4).rev() {
            let mut v = [Self::splat(0.0).0; 4];
            for (k, column) in columns.iter().enumerate() {
                v[k] = column.0;
            }
            let v = transpose_ymm(v);
            for l in 0..4 {
                let first = l * stride + 4 * b;
                let row = &mut rows[first..first + 4];
                unsafe { _mm256_storeu_pd(row.as_mut_ptr(), v[l]) };
            }
        }
    }
    #[inline(always)]
    fn index(self, limit: usize, stride: usize) -> YmmIndex {
        let place = self.max(Self::splat(0.0)).min(Self::splat((limit - 1) as f64));
        let numbers = unsafe {
            let lanes = _mm_setr_epi32(0, 1, 2, 3);
            let vectors = _mm_mullo_epi32(_mm256_cvttpd_epi32(place.0), _mm_set1_epi32(4 * stride as i32));
            _mm_add_epi32(vectors, lanes)
        };
        YmmIndex { numbers, span: (limit - 1) * stride + 1 }
    }
    #[inline(always)]
    fn pick(v: &[Self], at: YmmIndex) -> Self {
        assert!(v.len() >= at.span);
        Self(unsafe { _mm256_i32gather_pd::<8>(v.as_ptr().cast(), at.numbers) })
    }
    #[inline(always)]
    fn sum(self) -> f64 {
        unsafe {
            let two = _mm_add_pd(_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0));
            _mm_cvtsd_f64(_mm_add_pd(two, _mm_unpackhi_pd(two, two)))
        }
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        unsafe {
            let two = _mm_max_pd(_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0));
            _mm_cvtsd_f64(_mm_max_pd(two, _mm_unpackhi_pd(two, two)))
        }
    }
    #[inline(always)]
    fn smallest(self) -> f64 {
        unsafe {
            let two = _mm_min_pd(_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0));
            _mm_cvtsd_f64(_mm_min_pd(two, _mm_unpackhi_pd(two, two)))
        }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_pd(Self::splat(-0.0).0, self.0) })
    }
    #[inline(always)]
    fn only(self, mask: YmmMask) -> Self {
        Self(unsafe { _mm256_and_pd(self.0, mask.0) })
    }
    #[inline(always)]
    fn or_else(self, mask: YmmMask, x: Self) -> Self {
        Self(unsafe { _mm256_blendv_pd(x.0, self.0, mask.0) })
    }
}
