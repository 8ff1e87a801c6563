//! `A x + start` in twice the working precision, with its rounding scale: what every verdict rests on.
#![allow(unsafe_code, reason = "registers of AVX-512 named one by one: half the time of the portable loop")]

use super::kernels::dot_compensated;

/// Row by row `start_i + a_i'x` as by [`dot_compensated`], with the same error bound, and `|start_i| + |a_i|'|x|`; A is
/// row-major with rows of `x.len()` numbers. O(n^2).
#[must_use]
pub fn affine_compensated(start: &[f64], a: &[f64], x: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = x.len();
    assert!(a.len() == start.len() * n);
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx512f") {
        // SAFETY: the machine has the instructions.
        return unsafe { avx512::affine_compensated(start, a, x) };
    }
    start.iter().enumerate().map(|(i, &start)| dot_compensated(start, &a[i * n..(i + 1) * n], x)).unzip()
}

/// As [`affine_compensated`] for the given rows alone: `start_i + a_i'x` and its rounding scale for each i of `rows`, in their
/// order. O(n |rows|).
#[must_use]
pub fn rows_compensated(start: &[f64], a: &[f64], x: &[f64], rows: &[usize]) -> (Vec<f64>, Vec<f64>) {
    let n = x.len();
    assert!(a.len() == start.len() * n && rows.iter().all(|&i| i < start.len()));
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx512f") {
        // SAFETY: the machine has the instructions.
        return unsafe { avx512::rows_compensated(start, a, x, rows) };
    }
    rows.iter().map(|&i| dot_compensated(start[i], &a[i * n..(i + 1) * n], x)).unzip()
}

#[cfg(target_arch = "x86_64")]
mod avx512 {
    use super::super::dd::two_sum;
    use std::arch::x86_64::{
        __m512d, _mm512_abs_pd, _mm512_add_pd, _mm512_fmsub_pd, _mm512_maskz_loadu_pd, _mm512_mul_pd,
        _mm512_setzero_pd, _mm512_storeu_pd, _mm512_sub_pd,
    };

    /// Rows handled together.
    const ROWS: usize = 4;

    #[target_feature(enable = "avx512f")]
    pub fn affine_compensated(start: &[f64], a: &[f64], x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        all(start.len(), |k| k, start, a, x)
    }

    #[target_feature(enable = "avx512f")]
    pub fn rows_compensated(start: &[f64], a: &[f64], x: &[f64], rows: &[usize]) -> (Vec<f64>, Vec<f64>) {
        all(rows.len(), |k| rows[k], start, a, x)
    }

    /// The rows `row(k)` for `k < count`.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn all(count: usize, row: impl Fn(usize) -> usize, start: &[f64], a: &[f64], x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut y, mut m) = (vec![0.0; count], vec![0.0; count]);
        let mut k = 0;
        while k < count {
            // The last rows are done again rather than in a loop of their own.
            let first = if k + ROWS <= count { k } else { count.saturating_sub(ROWS) };
            if count >= ROWS {
                let four = [row(first), row(first + 1), row(first + 2), row(first + 3)];
                rows::<ROWS>(start, a, x, four, &mut y[first..], &mut m[first..]);
                k = first + ROWS;
            } else {
                rows::<1>(start, a, x, [row(k)], &mut y[k..], &mut m[k..]);
                k += 1;
            }
        }
        (y, m)
    }

    /// Algorithm Dot2 of [ORO05] in eight lanes, for R rows.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn rows<const R: usize>(start: &[f64], a: &[f64], x: &[f64], row: [usize; R], y: &mut [f64], m: &mut [f64]) {
        let n = x.len();
        let row: [_; R] = row.map(|i| (&a[i * n..(i + 1) * n], start[i]));
        let zero = _mm512_setzero_pd();
        let (mut sums, mut errors, mut sizes) = ([zero; R], [zero; R], [zero; R]);
        let mut j = 0;
        while j < n {
            let mask = if n - j >= 8 { u8::MAX } else { (1 << (n - j)) - 1 };
            // SAFETY: the mask ends where row and vector do.
            let load = |from: &[f64]| unsafe { _mm512_maskz_loadu_pd(mask, from.as_ptr().add(j)) };
            let xs = load(x);
            for r in 0..R {
                let entries = load(row[r].0);
                let product = _mm512_mul_pd(entries, xs);
                let product_error = _mm512_fmsub_pd(entries, xs, product);
                let sum = _mm512_add_pd(sums[r], product);
                let part = _mm512_sub_pd(sum, sums[r]);
                let sum_error =
                    _mm512_add_pd(_mm512_sub_pd(sums[r], _mm512_sub_pd(sum, part)), _mm512_sub_pd(product, part));
                sums[r] = sum;
                errors[r] = _mm512_add_pd(errors[r], _mm512_add_pd(product_error, sum_error));
                sizes[r] = _mm512_add_pd(sizes[r], _mm512_abs_pd(product));
            }
            j += 8;
        }
        for r in 0..R {
            let start = row[r].1;
            let (sums, errors, sizes) = (lanes(sums[r]), lanes(errors[r]), lanes(sizes[r]));
            let (mut sum, mut error, mut size) = (start, 0.0, start.abs());
            for l in 0..8 {
                let (t, f) = two_sum(sum, sums[l]);
                sum = t;
                error += errors[l] + f;
                size += sizes[l];
            }
            (y[r], m[r]) = (sum + error, size);
        }
    }

    #[inline]
    #[target_feature(enable = "avx512f")]
    fn lanes(x: __m512d) -> [f64; 8] {
        let mut out = [0.0; 8];
        // SAFETY: eight numbers fit.
        unsafe { _mm512_storeu_pd(out.as_mut_ptr(), x) };
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_row_by_row_at_every_size_and_survives_cancellation() {
        for n in 0..35 {
            let a: Vec<f64> = (0..n * n).map(|k| ((k * 7919 % 101) as f64) / 50.0 - 1.0).collect();
            let x: Vec<f64> = (0..n).map(|i| if i % 3 == 0 { 1e16 } else { 1.0 / (1 + i) as f64 }).collect();
            let plain: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[i * n + j] * x[j]).sum()).collect();
            // What is left of the sum when its rounded value is taken away: all digits have cancelled.
            let start: Vec<f64> = plain.iter().map(|x: &f64| -x).collect();
            let (y, m) = affine_compensated(&start, &a, &x);
            let rows: Vec<usize> = (0..n).rev().step_by(2).collect();
            let some = rows_compensated(&start, &a, &x, &rows);
            assert!(rows.iter().enumerate().all(|(k, &i)| (some.0[k], some.1[k]) == (y[i], m[i])));
            for i in 0..n {
                let (expected, size) = dot_compensated(start[i], &a[i * n..(i + 1) * n], &x);
                assert!((y[i] - expected).abs() <= 1e-28 * size + 4e-16 * expected.abs(), "{n} {i}");
                assert!((m[i] - size).abs() <= 1e-14 * size);
            }
        }
    }
}
