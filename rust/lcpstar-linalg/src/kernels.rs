//! The inner loops, compiled once per instruction set and chosen at run time, so that one wheel serves every machine.

use super::dd::{two_prod, two_sum};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// `y += f x`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn axpy(f: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += f * x;
    }
}

/// One pivot of a dictionary stored in rows of `stride` numbers, `stride` a multiple of [`LANES`]: row `r` becomes
/// `pivot_row`, and every other row gets `pivot_row` times its entry in column `c`, that entry counting as zero.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn pivot(rows: &mut [f64], stride: usize, r: usize, c: usize, pivot_row: &[f64]) {
    for (i, row) in rows.chunks_exact_mut(stride).enumerate() {
        if i == r {
            row.copy_from_slice(pivot_row);
            continue;
        }
        let f = row[c];
        if f != 0.0 {
            row[c] = 0.0;
            for (y, x) in row.chunks_exact_mut(LANES).zip(pivot_row.chunks_exact(LANES)) {
                for l in 0..LANES {
                    y[l] += f * x[l];
                }
            }
        }
    }
}

/// `y += sum_k f_k x_k`, the `x_k` of `y.len()` numbers each, one after the other; lengths are multiples of [`LANES`].
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn add_combination(y: &mut [f64], f: &[f64], x: &[f64]) {
    let fused = target_cfg_f!(any(target_feature = "fma", target_feature = "avx512f", target_arch = "aarch64"));
    let n = y.len();
    for (b, y) in y.chunks_exact_mut(LANES).enumerate() {
        let mut sums = [0.0; LANES];
        sums.copy_from_slice(y);
        for (k, &f) in f.iter().enumerate() {
            let x = &x[k * n + b * LANES..][..LANES];
            for l in 0..LANES {
                sums[l] = if fused { f.mul_add(x[l], sums[l]) } else { sums[l] + f * x[l] };
            }
        }
        y.copy_from_slice(&sums);
    }
}

/// The ratios `values_i / (sign column_i)` where that rate exceeds `tol`, infinity elsewhere; returns the least.
/// Lengths are multiples of [`LANES`].
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn ratios(values: &[f64], column: &[f64], sign: f64, tol: f64, ratios: &mut [f64]) -> f64 {
    let mut least = [f64::INFINITY; LANES];
    let numbers = values.chunks_exact(LANES).zip(column.chunks_exact(LANES));
    for (ratios, (values, column)) in ratios.chunks_exact_mut(LANES).zip(numbers) {
        for l in 0..LANES {
            let rate = sign * column[l];
            let ratio = if rate > tol { values[l] / rate } else { f64::INFINITY };
            ratios[l] = ratio;
            least[l] = if ratio < least[l] { ratio } else { least[l] };
        }
    }
    least.iter().fold(f64::INFINITY, |m, &x| if x < m { x } else { m })
}

/// `max |x_i|` for a length that is a multiple of [`LANES`]; NaN counts as zero.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn largest(x: &[f64]) -> f64 {
    let mut largest = [0.0_f64; LANES];
    for x in x.chunks_exact(LANES) {
        for l in 0..LANES {
            let size = x[l].abs();
            largest[l] = if size > largest[l] { size } else { largest[l] };
        }
    }
    largest.iter().fold(0.0, |m: f64, x| m.max(*x))
}

/// One sweep of the projected Gauss-Seidel method for symmetric A with a positive diagonal, `w = A z + q` kept up to date;
/// returns how many `z_i` became positive or zero. O(n^2), less the rows whose `z_i` does not move.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn gauss_seidel_sweep(a: &[f64], z: &mut [f64], w: &mut [f64]) -> usize {
    let n = z.len();
    let mut changed = 0;
    for i in 0..n {
        let row = &a[i * n..(i + 1) * n];
        let (old, moved) = (z[i], z[i] - w[i] / row[i]);
        let new = if moved > 0.0 { moved } else { 0.0 };
        let step = new - old;
        if step != 0.0 {
            z[i] = new;
            changed += usize::from((new > 0.0) != (old > 0.0));
            for (w, a) in w.iter_mut().zip(row) {
                *w += step * a;
            }
        }
    }
    changed
}

/// Whether a row-major matrix of order `n` is symmetric. O(n^2), by square tiles with one branch each.
#[must_use]
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn is_symmetric(n: usize, a: &[f64]) -> bool {
    for i0 in (0..n).step_by(LANES) {
        let rows = LANES.min(n - i0);
        for j0 in (0..=i0).step_by(LANES) {
            let columns = LANES.min(n - j0);
            let mut differ = 0;
            if rows == LANES && columns == LANES {
                // Row by row into one tile, column by column out of it.
                let mut tile = [[0.0; LANES]; LANES];
                for (k, row) in tile.iter_mut().enumerate() {
                    row.copy_from_slice(&a[(i0 + k) * n + j0..][..LANES]);
                }
                let mut differs = [0_u64; LANES];
                for l in 0..LANES {
                    let transposed = &a[(j0 + l) * n + i0..][..LANES];
                    for k in 0..LANES {
                        differs[k] |= u64::from(transposed[k] != tile[k][l]);
                    }
                }
                differ = differs.iter().fold(0, |all, x| all | x);
            } else {
                for l in 0..columns {
                    let transposed = &a[(j0 + l) * n + i0..][..rows];
                    for (k, x) in transposed.iter().enumerate() {
                        differ += u64::from(*x != a[(i0 + k) * n + j0 + l]);
                    }
                }
            }
            if differ != 0 {
                return false;
            }
        }
    }
    true
}

/// Whether every number is zero or its size lies in `range`. No early exit: the loop is vectorised.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn all_zero_or_within(x: &[f64], least: f64, most: f64) -> bool {
    let mut outside = [0_u64; LANES];
    let chunks = x.chunks_exact(LANES);
    let is_inside = |x: f64| x == 0.0 || (least..most).contains(&x.abs());
    let tail = chunks.remainder().iter().all(|&x| is_inside(x));
    for x in chunks {
        for l in 0..LANES {
            let size = x[l].abs();
            // Not of a comparison, so that NaN lies outside.
            outside[l] |= u64::from(!((size >= least) & (size < most)) & (size != 0.0));
        }
    }
    tail && outside.iter().all(|&x| x == 0)
}

/// `x_j row_factor factor_j`, where the product of the factors is exact.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn scale_row(x: &[f64], row_factor: f64, factors: &[f64], out: &mut [f64]) {
    for ((out, x), f) in out.iter_mut().zip(x).zip(factors) {
        *out = x * (row_factor * f);
    }
}

/// `max_j (e_j + c_j)` for the binary exponents `e_j` of `x`, with `2^(e-1) <= |x| < 2^e`, and `m_j = max(m_j, e_j + r)`; zeros
/// count with the exponent `zero`. `None` where x holds a subnormal number.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn max_exponents(x: &[f64], zero: i32, c: &[i32], r: i32, m: &mut [i32]) -> Option<i32> {
    let (mut largest, mut subnormal) = (i32::MIN, 0_u64);
    for ((x, &c), m) in x.iter().zip(c).zip(m) {
        let size = x.to_bits() << 1 >> 1;
        let biased = size >> 52;
        let e = if biased == 0 { zero } else { biased as i32 - 1022 };
        subnormal |= u64::from((size != 0) & (biased == 0));
        largest = largest.max(e + c);
        *m = (*m).max(e + r);
    }
    (subnormal == 0).then_some(largest)
}

/// Numbers handled together by the kernels that ask for padded rows.
pub const LANES: usize = 8;

/// `y = start + A x` for a row-major matrix with rows of `x.len()` numbers.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn affine(start: &[f64], a: &[f64], x: &[f64], y: &mut [f64]) {
    if x.is_empty() {
        y.copy_from_slice(start);
        return;
    }
    for ((y, s), row) in y.iter_mut().zip(start).zip(a.chunks_exact(x.len())) {
        let mut sums = [0.0; LANES];
        let (row8, x8) = (row.chunks_exact(LANES), x.chunks_exact(LANES));
        let tail: f64 = row8.remainder().iter().zip(x8.remainder()).map(|(a, x)| a * x).sum();
        for (a, x) in row8.zip(x8) {
            for l in 0..LANES {
                sums[l] += a[l] * x[l];
            }
        }
        *y = s + (sums.iter().sum::<f64>() + tail);
    }
}

/// `x'y`, eight running sums so that the compiler can vectorise it.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (x8, y8) = (x.chunks_exact(8), y.chunks_exact(8));
    let tail: f64 = x8.remainder().iter().zip(y8.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in x8.zip(y8) {
        for l in 0..8 {
            sums[l] += x[l] * y[l];
        }
    }
    sums.iter().sum::<f64>() + tail
}

/// `start + x'y` as if computed in twice the working precision, and `|start| + |x|'|y|`.
///
/// Algorithm Dot2 of [ORO05] in four lanes; error at most `eps |result| + gamma_n^2 (|start| + |x|'|y|)`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn dot_compensated(start: f64, x: &[f64], y: &[f64]) -> (f64, f64) {
    // Both give the same bits; a fused multiply-add is the faster where the processor has one.
    let fused = target_cfg_f!(any(target_feature = "fma", target_feature = "avx512f", target_arch = "aarch64"));
    let product = |x: f64, y: f64| if fused { (x * y, x.mul_add(y, -(x * y))) } else { two_prod(x, y) };
    let (mut sum, mut error, mut magnitude) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let (xs, ys) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let (x_tail, y_tail) = (xs.remainder(), ys.remainder());
    for (x, y) in xs.zip(ys) {
        // One loop a step, each one vector instruction: together they are not vectorised.
        let (mut p, mut e, mut s, mut t) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            (p[l], e[l]) = product(x[l], y[l]);
        }
        for l in 0..LANES {
            s[l] = sum[l] + p[l];
        }
        for l in 0..LANES {
            t[l] = s[l] - sum[l];
        }
        for l in 0..LANES {
            e[l] += (sum[l] - (s[l] - t[l])) + (p[l] - t[l]);
        }
        for l in 0..LANES {
            error[l] += e[l];
            magnitude[l] += p[l].abs();
        }
        sum = s;
    }
    let (mut s, mut c, mut m) = (start, 0.0, start.abs());
    for l in 0..LANES {
        let (t, f) = two_sum(s, sum[l]);
        s = t;
        c += error[l] + f;
        m += magnitude[l];
    }
    for (x, y) in x_tail.iter().zip(y_tail) {
        let (p, e) = product(*x, *y);
        let (t, f) = two_sum(s, p);
        s = t;
        c += e + f;
        m += p.abs();
    }
    (s + c, m)
}

/// `max |x_i|`, and `m_i = max(m_i, |x_i|)`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn max_into(x: &[f64], m: &mut [f64]) -> f64 {
    let mut largest = [0.0_f64; LANES];
    let (x8, tail) = (x.chunks_exact(LANES), x.chunks_exact(LANES).remainder());
    let (m8, m_tail) = m.split_at_mut(x.len() - tail.len());
    for (x, m) in x8.zip(m8.chunks_exact_mut(LANES)) {
        for l in 0..LANES {
            let size = x[l].abs();
            largest[l] = if size > largest[l] { size } else { largest[l] };
            m[l] = if size > m[l] { size } else { m[l] };
        }
    }
    for (x, m) in tail.iter().zip(m_tail) {
        largest[0] = largest[0].max(x.abs());
        *m = m.max(x.abs());
    }
    largest.iter().fold(0.0, |m: f64, x| m.max(*x))
}

/// Whether every number is finite: the sum of `0 x` is zero exactly then.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn all_finite(x: &[f64]) -> bool {
    let mut poison = [0.0; LANES];
    let chunks = x.chunks_exact(LANES);
    let tail: f64 = chunks.remainder().iter().map(|x| 0.0 * x).sum();
    for x in chunks {
        for l in 0..LANES {
            poison[l] += 0.0 * x[l];
        }
    }
    poison.iter().sum::<f64>() + tail == 0.0
}

/// `max |x_i|`, 0 for the empty vector.
#[must_use]
pub fn max_abs(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compensated_dot_survives_cancellation() {
        let x = [1e16, 1.0, -1e16, 3.0, 0.5];
        let y = [1.0, 1.0, 1.0, 2.0, 2.0];
        assert_eq!(dot_compensated(1.0, &x, &y).0, 9.0);
    }

    #[test]
    fn dot_and_axpy_agree_with_loops_at_every_length() {
        for n in 0..40 {
            let x: Vec<f64> = (0..n).map(|i| f64::from(i) - 3.0).collect();
            let mut y: Vec<f64> = (0..n).map(|i| f64::from(i * i % 7)).collect();
            let expected: f64 = x.iter().zip(&y).map(|(x, y)| x * y).sum();
            assert_eq!(dot(&x, &y), expected);
            assert_eq!(dot_compensated(0.0, &x, &y).0, expected);
            let sums: Vec<f64> = x.iter().zip(&y).map(|(x, y)| y + 2.0 * x).collect();
            axpy(2.0, &x, &mut y);
            assert_eq!(y, sums);
        }
    }
}
