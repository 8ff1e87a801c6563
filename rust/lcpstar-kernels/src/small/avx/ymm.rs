//! Four doubles in a register of AVX2: [`Places`], and macros of the parent.

use super::places::Places;
use crate::small::lane::{BLOCK, Lane, Mask};
use std::arch::x86_64::{
    __m128i, __m256d, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _MM_FROUND_NO_EXC, _MM_FROUND_TO_ZERO, _mm_add_pd,
    _mm_cvtsd_f64, _mm_loadu_pd, _mm_max_pd, _mm_min_pd, _mm_unpackhi_pd, _mm256_add_pd, _mm256_and_pd,
    _mm256_andnot_pd, _mm256_blendv_pd, _mm256_castpd_si256, _mm256_castpd128_pd256, _mm256_castpd256_pd128,
    _mm256_castsi256_pd, _mm256_cmp_pd, _mm256_cvttpd_epi32, _mm256_div_pd, _mm256_extractf128_pd, _mm256_fmadd_pd,
    _mm256_fnmadd_pd, _mm256_insertf128_pd, _mm256_loadu_pd, _mm256_max_pd, _mm256_min_pd, _mm256_movemask_pd,
    _mm256_mul_pd, _mm256_or_pd, _mm256_permute2f128_pd, _mm256_round_pd, _mm256_set1_pd, _mm256_setr_pd,
    _mm256_slli_epi64, _mm256_srli_epi64, _mm256_storeu_pd, _mm256_sub_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
    _mm256_xor_pd,
};
use std::mem::transmute;

/// Four doubles in one register.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Ymm(pub(super) __m256d);

numbers!(Ymm, 4);

/// All bits or none, lane by lane.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct YmmMask(__m256d);

impl Mask for YmmMask {
    const LANES: usize = 4;
    // SAFETY: any bits are numbers.
    const NONE: Self = Self(unsafe { transmute::<[u64; 4], __m256d>([0; 4]) });
    const ALL: Self = Self(unsafe { transmute::<[u64; 4], __m256d>([u64::MAX; 4]) });

    #[inline(always)]
    fn get(&self, l: usize) -> bool {
        self.bits() >> l & 1 == 1
    }
    #[inline(always)]
    fn set(&mut self, l: usize, yes: bool) {
        // SAFETY: a register is its words in memory, in order.
        let words: &mut [u64; 4] = unsafe { &mut *std::ptr::from_mut(self).cast() };
        words[l] = if yes { u64::MAX } else { 0 };
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        let words: [u64; 4] = std::array::from_fn(|l| u64::from(bits >> l & 1).wrapping_neg());
        // SAFETY: as `NONE`.
        Self(unsafe { transmute::<[u64; 4], __m256d>(words) })
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
    fn any(self) -> bool {
        self.bits() != 0
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        unsafe { _mm256_movemask_pd(self.0) as u32 }
    }
}

/// From here on doubles are integers.
const TWO_52: f64 = 4_503_599_627_370_496.0;

/// As `transpose_zmm`.
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

/// The sum, largest or smallest of the lanes: upper half with lower half, again and again.
macro_rules! fold_ymm {
    ($x:expr, $instruction:ident) => {
        unsafe {
            let two = $instruction(_mm256_castpd256_pd128($x), _mm256_extractf128_pd::<1>($x));
            _mm_cvtsd_f64($instruction(two, _mm_unpackhi_pd(two, two)))
        }
    };
}

impl Lane for Ymm {
    type Index = Places<4>;

    operations!(
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
        pick!(v, at, _mm256_setr_pd, 0 1 2 3)
    }
    #[inline(always)]
    fn sum(self) -> f64 {
        fold_ymm!(self.0, _mm_add_pd)
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        fold_ymm!(self.0, _mm_max_pd)
    }
    #[inline(always)]
    fn smallest(self) -> f64 {
        fold_ymm!(self.0, _mm_min_pd)
    }
    #[inline(always)]
    fn exponent(self) -> Self {
        // The biased exponent in the last bits of a double of size 2^52 to 2^53.
        let whole = Self::splat(TWO_52).0;
        let biased = unsafe { _mm256_srli_epi64::<52>(_mm256_castpd_si256(self.abs().0)) };
        Self(unsafe { _mm256_or_pd(_mm256_castsi256_pd(biased), whole) }).sub(Self::splat(TWO_52 + 1022.0))
    }
    #[inline(always)]
    fn truncated(self) -> Self {
        Self(unsafe { _mm256_round_pd::<{ _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC }>(self.0) })
    }
    #[inline(always)]
    fn two_to(self) -> Self {
        let biased = self.add(Self::splat(TWO_52 + 1023.0));
        Self(unsafe { _mm256_castsi256_pd(_mm256_slli_epi64::<52>(_mm256_castpd_si256(biased.0))) })
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
