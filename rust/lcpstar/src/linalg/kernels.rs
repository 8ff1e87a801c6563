//! The inner loops, compiled once per instruction set and chosen at run time, so that one wheel serves every machine.

use super::dd::{two_prod, two_sum};
use multiversion::multiversion;

/// `y += f x`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn axpy(f: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += f * x;
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
    const LANES: usize = 4;
    let (mut sum, mut error, mut magnitude) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let (xs, ys) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let (x_tail, y_tail) = (xs.remainder(), ys.remainder());
    for (x, y) in xs.zip(ys) {
        for l in 0..LANES {
            let (p, e) = two_prod(x[l], y[l]);
            let (s, f) = two_sum(sum[l], p);
            sum[l] = s;
            error[l] += e + f;
            magnitude[l] += p.abs();
        }
    }
    let (mut s, mut c, mut m) = (start, 0.0, start.abs());
    for l in 0..LANES {
        let (t, f) = two_sum(s, sum[l]);
        s = t;
        c += error[l] + f;
        m += magnitude[l];
    }
    for (x, y) in x_tail.iter().zip(y_tail) {
        let (p, e) = two_prod(*x, *y);
        let (t, f) = two_sum(s, p);
        s = t;
        c += e + f;
        m += p.abs();
    }
    (s + c, m)
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
