//! The lanes of [`lane`](super::lane) in registers of AVX-512 and AVX2, same bits as `F64x8<true>`.
//!
//! The compiler vectorises the portable lanes well in short kernels and poorly in long ones; naming the instructions
//! makes the speed predictable. Nothing here checks that the machine has them: `work` and `small` choose a type only
//! in functions compiled for, and entered on, machines that do.
#![allow(unsafe_code, reason = "instructions of the machine; see above for who may call them")]

use super::lane::{BLOCK, Lane, Mask, Pair};
use std::arch::x86_64::{
    __m128i, __m256d, __m256i, __m512d, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm_add_pd, _mm_cvtsd_f64, _mm_loadu_pd,
    _mm_max_pd, _mm_min_pd, _mm_unpackhi_pd, _mm256_add_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd,
    _mm256_castpd128_pd256, _mm256_castpd256_pd128, _mm256_cmp_pd, _mm256_cvttpd_epi32, _mm256_div_pd,
    _mm256_extractf128_pd, _mm256_fmadd_pd, _mm256_fnmadd_pd, _mm256_insertf128_pd, _mm256_loadu_pd, _mm256_max_pd,
    _mm256_min_pd, _mm256_movemask_pd, _mm256_mul_pd, _mm256_or_pd, _mm256_permute2f128_pd, _mm256_set1_pd,
    _mm256_setr_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd, _mm256_xor_pd,
    _mm512_abs_pd, _mm512_add_pd, _mm512_castpd256_pd512, _mm512_castpd512_pd256, _mm512_cmp_pd_mask,
    _mm512_cvttpd_epi32, _mm512_div_pd, _mm512_extractf64x4_pd, _mm512_fmadd_pd, _mm512_fnmadd_pd, _mm512_insertf64x4,
    _mm512_loadu_pd, _mm512_mask_blend_pd, _mm512_maskz_loadu_pd, _mm512_maskz_mov_pd, _mm512_max_pd, _mm512_min_pd,
    _mm512_mul_pd, _mm512_set1_pd, _mm512_setr_pd, _mm512_shuffle_f64x2, _mm512_storeu_pd, _mm512_sub_pd,
    _mm512_unpackhi_pd, _mm512_unpacklo_pd,
};
use std::mem::transmute;

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

/// One place in memory for each of `L` lanes, all in the first `span` vectors.
#[derive(Clone, Copy, Debug)]
pub struct Places<const L: usize> {
    numbers: [u32; L],
    span: usize,
}

impl<const L: usize> Places<L> {
    /// Lane l of vector `stride * vectors[l]`.
    #[inline(always)]
    fn new(vectors: [u32; L], limit: usize, stride: usize) -> Self {
        let mut numbers = vectors;
        for (l, number) in numbers.iter_mut().enumerate() {
            *number = *number * (L * stride) as u32 + l as u32;
        }
        Self { numbers, span: (limit - 1) * stride + 1 }
    }
}

/// Number after number: the machine's gather is slower where it is kept from leaking data.
macro_rules! pick {
    ($v:ident, $at:ident, $number:ty, $set:ident, $($l:literal)*) => {{
        assert!($v.len() >= $at.span);
        let first: *const $number = $v.as_ptr().cast();
        Self(unsafe { $set($(*first.add($at.numbers[$l] as usize)),*) })
    }};
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
    type Index = Places<8>;

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
        pick!(v, at, f64, _mm512_setr_pd, 0 1 2 3 4 5 6 7)
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

/// Four doubles in one register.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Ymm(__m256d);

numbers!(Ymm, f64, 4);

/// All bits or none, lane by lane.
macro_rules! words {
    ($mask:ident, $register:ident, $word:ty, $lanes:literal, $and:ident, $or:ident, $xor:ident, $movemask:ident) => {
        /// All bits or none, lane by lane.
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub struct $mask($register);

        impl Mask for $mask {
            const LANES: usize = $lanes;
            // SAFETY: any bits are numbers.
            const NONE: Self = Self(unsafe { transmute::<[$word; $lanes], $register>([0; $lanes]) });
            const ALL: Self = Self(unsafe { transmute::<[$word; $lanes], $register>([<$word>::MAX; $lanes]) });

            #[inline(always)]
            fn get(&self, l: usize) -> bool {
                self.bits() >> l & 1 == 1
            }
            #[inline(always)]
            fn set(&mut self, l: usize, yes: bool) {
                // SAFETY: a register is its words in memory, in order.
                let words: &mut [$word; $lanes] = unsafe { &mut *std::ptr::from_mut(self).cast() };
                words[l] = if yes { <$word>::MAX } else { 0 };
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                let words: [$word; $lanes] = std::array::from_fn(|l| <$word>::from(bits >> l & 1).wrapping_neg());
                // SAFETY: as `NONE`.
                Self(unsafe { transmute::<[$word; $lanes], $register>(words) })
            }
            #[inline(always)]
            fn and(self, x: Self) -> Self {
                Self(unsafe { $and(self.0, x.0) })
            }
            #[inline(always)]
            fn or(self, x: Self) -> Self {
                Self(unsafe { $or(self.0, x.0) })
            }
            #[inline(always)]
            fn xor(self, x: Self) -> Self {
                Self(unsafe { $xor(self.0, x.0) })
            }
            #[inline(always)]
            fn not(self) -> Self {
                Self(unsafe { $xor(self.0, Self::ALL.0) })
            }
            #[inline(always)]
            fn any(self) -> bool {
                self.bits() != 0
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                unsafe { $movemask(self.0) as u32 }
            }
        }
    };
}

words!(YmmMask, __m256d, u64, 4, _mm256_and_pd, _mm256_or_pd, _mm256_xor_pd, _mm256_movemask_pd);

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
    type Index = Places<4>;

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
    fn load_columns(rows: &[&[f64]], first: usize, out: &mut [Self]) {
        for (b, out) in out.chunks_mut(4).enumerate() {
            let first = first + 4 * b;
            if let [out0, out1, out2, out3] = out {
                // Two rows meet in a register on their way from memory, which leaves half the shuffles.
                let mut v = [Self::splat(0.0).0; 4];
                for (k, v) in v.iter_mut().enumerate() {
                    let (l, half) = (k % 2, first + 2 * (k / 2));
                    let (upper, lower) = (&rows[l][half..half + 2], &rows[l + 2][half..half + 2]);
                    *v = unsafe {
                        let upper = _mm256_castpd128_pd256(_mm_loadu_pd(upper.as_ptr()));
                        _mm256_insertf128_pd::<1>(upper, _mm_loadu_pd(lower.as_ptr()))
                    };
                }
                let [a, b, c, d] = v;
                unsafe {
                    (out0.0, out1.0) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
                    (out2.0, out3.0) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
                }
                continue;
            }
            let mut v = [Self::splat(0.0).0; 4];
            for l in 0..4 {
                v[l] = Self::from_slice(&rows[l][first..first + out.len()]).0;
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
    fn index(self, limit: usize, stride: usize) -> Places<4> {
        let place = self.max(Self::splat(0.0)).min(Self::splat((limit - 1) as f64));
        // SAFETY: four integers are four integers.
        Places::new(unsafe { transmute::<__m128i, [u32; 4]>(_mm256_cvttpd_epi32(place.0)) }, limit, stride)
    }
    #[inline(always)]
    fn pick(v: &[Self], at: Places<4>) -> Self {
        pick!(v, at, f64, _mm256_setr_pd, 0 1 2 3)
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

// After the macros, which it uses.
mod single;
pub use single::{YmmS, ZmmS};
