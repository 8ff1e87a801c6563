//! `C += L' R` for few rows of L and R: what several delayed pivots, or the panel of a factorisation, leave to be done.
#![allow(unsafe_code, reason = "registers of AVX-512 named one by one: the compiler spills the tile to memory")]

use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// A window of a row-major matrix: row i is `numbers[i * stride..]`.
#[derive(Clone, Copy)]
pub struct Window<'a, T = f64> {
    /// From the first number of the window on.
    pub numbers: &'a [T],
    /// Distance of its rows.
    pub stride: usize,
}

/// `c_ij += sum_k left_ki right_kj` for `i < height`, `j < width`, `k < count`. O(height width count), no allocation.
///
/// # Panics
/// When a window is smaller than that.
pub fn add_products(
    c: &mut [f64],
    stride: usize,
    (height, width, count): (usize, usize, usize),
    left: Window<'_>,
    right: Window<'_>,
) {
    if height == 0 || width == 0 || count == 0 {
        return;
    }
    assert!(c.len() >= (height - 1) * stride + width && stride >= width);
    assert!(left.numbers.len() >= (count - 1) * left.stride + height);
    assert!(right.numbers.len() >= (count - 1) * right.stride + width);
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx512f") {
        // SAFETY: the machine has the instructions, and every number read or written lies in a window checked above.
        unsafe { avx512::add_products(c.as_mut_ptr(), stride, (height, width, count), left, right) };
        return;
    }
    portable(c, stride, (height, width, count), left, right);
}

/// Row by row, four terms of the sum at a time.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn portable(
    c: &mut [f64],
    stride: usize,
    (height, width, count): (usize, usize, usize),
    left: Window<'_>,
    right: Window<'_>,
) {
    let fused = target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64"));
    let fma = |a: f64, b: f64, c: f64| if fused { a.mul_add(b, c) } else { c + a * b };
    for (i, row) in c.chunks_mut(stride).take(height).enumerate() {
        let row = &mut row[..width];
        let factor = |k: usize| left.numbers[k * left.stride + i];
        let terms = |k: usize| &right.numbers[k * right.stride..][..width];
        let mut k = 0;
        while k + 4 <= count {
            let f = [factor(k), factor(k + 1), factor(k + 2), factor(k + 3)];
            let (r0, r1, r2, r3) = (terms(k), terms(k + 1), terms(k + 2), terms(k + 3));
            for j in 0..width {
                row[j] = fma(f[3], r3[j], fma(f[2], r2[j], fma(f[1], r1[j], fma(f[0], r0[j], row[j]))));
            }
            k += 4;
        }
        while k < count {
            let (f, r) = (factor(k), terms(k));
            for j in 0..width {
                row[j] = fma(f, r[j], row[j]);
            }
            k += 1;
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx512 {
    use super::Window;
    use std::arch::x86_64::{
        __m512d, _mm512_fmadd_pd, _mm512_mask_storeu_pd, _mm512_maskz_loadu_pd, _mm512_set1_pd, _mm512_setzero_pd,
    };

    /// Rows of a tile, and registers in each.
    const TILE: (usize, usize) = (4, 4);
    /// Columns gone through before the next rows, so that `right` stays in the first cache.
    const SLAB: usize = 256;

    /// # Safety
    /// The windows are as large as the function of the same name above asks.
    #[target_feature(enable = "avx512f")]
    pub unsafe fn add_products(
        c: *mut f64,
        stride: usize,
        (height, width, count): (usize, usize, usize),
        left: Window<'_>,
        right: Window<'_>,
    ) {
        let mut start = 0;
        while start < width {
            let end = (start + SLAB).min(width);
            let mut i = 0;
            while i < height {
                let rows = (height - i).min(TILE.0);
                let mut j = start;
                while j < end {
                    let wide = end - j >= 8 * TILE.1;
                    let mask = if end - j >= 8 { u8::MAX } else { (1 << (end - j)) - 1 };
                    // SAFETY: i < height, j < width, and the mask ends where the window does.
                    unsafe {
                        let at = At {
                            c: c.add(i * stride + j),
                            stride,
                            left: left.numbers.as_ptr().add(i),
                            left_stride: left.stride,
                            right: right.numbers.as_ptr().add(j),
                            right_stride: right.stride,
                            count,
                        };
                        match (rows == TILE.0, wide) {
                            (true, true) => tile::<{ TILE.0 }, { TILE.1 }>(&at, u8::MAX),
                            (true, false) => tile::<{ TILE.0 }, 1>(&at, mask),
                            (false, _) => (0..rows).for_each(|r| tile::<1, 1>(&at.row(r), mask)),
                        }
                    }
                    j += if wide && rows == TILE.0 { 8 * TILE.1 } else { 8 };
                }
                i += rows;
            }
            start = end;
        }
    }

    /// Where a tile begins.
    struct At {
        c: *mut f64,
        stride: usize,
        left: *const f64,
        left_stride: usize,
        right: *const f64,
        right_stride: usize,
        count: usize,
    }

    impl At {
        /// # Safety
        /// The tile has more than `r` rows.
        #[inline]
        unsafe fn row(&self, r: usize) -> Self {
            // SAFETY: as above.
            unsafe { Self { c: self.c.add(r * self.stride), left: self.left.add(r), ..*self } }
        }
    }

    /// R rows of V registers; the mask is that of every register.
    ///
    /// # Safety
    /// All of it lies in the windows.
    #[inline]
    #[target_feature(enable = "avx512f")]
    unsafe fn tile<const R: usize, const V: usize>(at: &At, mask: u8) {
        // SAFETY: as above.
        unsafe {
            let mut sums: [[__m512d; V]; R] = [[_mm512_setzero_pd(); V]; R];
            for r in 0..R {
                for v in 0..V {
                    sums[r][v] = _mm512_maskz_loadu_pd(mask, at.c.add(r * at.stride + 8 * v));
                }
            }
            for k in 0..at.count {
                let right = at.right.add(k * at.right_stride);
                let mut terms = [_mm512_setzero_pd(); V];
                for v in 0..V {
                    terms[v] = _mm512_maskz_loadu_pd(mask, right.add(8 * v));
                }
                for r in 0..R {
                    let factor = _mm512_set1_pd(*at.left.add(k * at.left_stride + r));
                    for v in 0..V {
                        sums[r][v] = _mm512_fmadd_pd(factor, terms[v], sums[r][v]);
                    }
                }
            }
            for r in 0..R {
                for v in 0..V {
                    _mm512_mask_storeu_pd(at.c.add(r * at.stride + 8 * v), mask, sums[r][v]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_agrees_with_three_loops_and_nothing_else_is_touched() {
        for (height, width, count) in
            [(0, 3, 2), (1, 1, 1), (3, 7, 2), (4, 32, 5), (5, 33, 16), (9, 300, 3), (8, 41, 9)]
        {
            let (stride, left_stride, right_stride) = (width + 3, height + 2, width + 1);
            let number = |k: usize| ((k * 7919 % 101) as f64) / 50.0 - 1.0;
            let left: Vec<f64> = (0..count * left_stride).map(number).collect();
            let right: Vec<f64> = (0..count * right_stride).map(|k| number(k + 17)).collect();
            let before: Vec<f64> = (0..(height + 1) * stride).map(|k| number(k + 5)).collect();
            let windows =
                (Window { numbers: &left, stride: left_stride }, Window { numbers: &right, stride: right_stride });
            for kernel in [add_products, portable] {
                let mut c = before.clone();
                kernel(&mut c, stride, (height, width, count), windows.0, windows.1);
                for (k, (&found, &before)) in c.iter().zip(&before).enumerate() {
                    let (i, j) = (k / stride, k % stride);
                    let term = |k: usize| left[k * left_stride + i] * right[k * right_stride + j];
                    let inside = i < height && j < width;
                    let expected = if inside { before + (0..count).map(term).sum::<f64>() } else { before };
                    assert!((found - expected).abs() < 1e-13, "{height} {width} {count}: {i} {j}");
                }
            }
        }
    }
}
