//! Rigorous bounds on `max|z - z*|`, for two classes of P-matrices.

use crate::equilibrate::{Equilibrated, Rows};
use crate::linalg::backend::{DenseCholesky, DenseLu};
use crate::linalg::kernels::{dot, dot_compensated, max_abs};
use crate::problem::Lcp;
use crate::residual::slack;
use crate::scaling::{Scaling, times_power_of_two};
use crate::sparse::SparseLcp;

/// A bound, or none, and why.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    pub(super) value: Option<f64>,
    pub(super) reason: &'static str,
}

const H_PLUS: &str = "A is an H-matrix with positive diagonal: |z - z*| <= v for v > 0 with <A> v >= |min(diag(A) z, w)|, \
     <A> the comparison matrix [CX06]";
const DEFINITE: &str =
    "A + A' is positive definite: |z - z*| <= max|r| + |(A - I) r|_2 / lambda, r = min(z, w), on D A D [MP90]";
/// Why there is no bound.
pub(super) const NONE: &str = "none: A was shown neither to be an H-matrix with positive diagonal nor to have A + A' positive \
     definite, so that the solution need not be unique";

/// Half a unit in the last place, doubled: the error of one operation is below.
const EPS: f64 = f64::EPSILON;
/// Products that underflow lose less than this each.
const TINY: f64 = 1e-300;

/// An upper bound of the error of [`dot_compensated`] with n terms, result s and magnitude m. [ORO05, prop. 5.5]
fn compensated_error(n: usize, s: f64, m: f64) -> f64 {
    let n = (n + 4) as f64;
    EPS * s.abs() + 2.0 * (n * EPS) * (n * EPS) * m + n * TINY
}

/// `min(x, y)` of two numbers known up to their errors: its midpoint and how far it may be from there.
fn minimum(x: f64, x_error: f64, y: f64, y_error: f64) -> (f64, f64) {
    let (low, high) = ((x - x_error).min(y - y_error), (x + x_error).min(y + y_error));
    let middle = x.min(y);
    (middle, (high - middle).max(middle - low) * (1.0 + 4.0 * EPS) + EPS * middle.abs() + TINY)
}

/// `b_i >= |min(a_ii z_i, w_i)|`.
fn diagonal_residual(n: usize, a_ii: f64, z: f64, w: f64, magnitude: f64) -> f64 {
    let x = a_ii * z;
    let (middle, error) = minimum(x, EPS * x.abs() + TINY, w, compensated_error(n, w, magnitude));
    (middle.abs() + error) * (1.0 + 4.0 * EPS)
}

/// Powers of two that change a digit would void the proof.
fn is_exact(original: &[f64], scaled: &[f64]) -> bool {
    original.iter().zip(scaled).all(|(a, s)| *a == 0.0 || s.is_normal() && a.is_normal())
}

/// `max 2^(c_i - q) v_i`, rounded up; `None` when it overflows.
fn in_units_of_the_caller(scaling: &Scaling, v: impl Iterator<Item = f64>) -> Option<f64> {
    let largest = v.zip(&scaling.columns).map(|(v, c)| times_power_of_two(v, c - scaling.q)).fold(0.0, f64::max);
    let up = largest * (1.0 + 4.0 * EPS);
    up.is_finite().then_some(up)
}

/// For H-matrices with positive diagonal. With `I` in the place of the row scaling `diag(A)^-1` this is Theorem 2.1 of
/// [CX06]; its proof gives the bound entry by entry. O(n^3).
pub(super) fn comparison(problem: &Equilibrated<'_>, z: &[f64]) -> Bound {
    let (lcp, scaling) = (&problem.lcp, &problem.scaling);
    let n = lcp.n();
    let none = Bound { value: None, reason: NONE };
    if (0..n).any(|i| lcp.row(i)[i] <= 0.0) || !is_exact(problem.original.a(), lcp.a()) {
        return none;
    }
    let z = scaling.z_from_caller(z);
    let (w, magnitude) = slack(lcp, &z);
    let b: Vec<f64> = (0..n).map(|i| diagonal_residual(n, lcp.row(i)[i], z[i], w[i], magnitude[i])).collect();
    let mut rows = vec![0.0; n * n];
    for i in 0..n {
        for (j, (m, a)) in rows[i * n..(i + 1) * n].iter_mut().zip(lcp.row(i)).enumerate() {
            *m = if i == j { *a } else { -a.abs() };
        }
    }
    let solved = DenseLu::new(n, &rows).map(|lu| lu.solve(&padded(&b)));
    let Some(v) = solved.filter(|v| v.iter().all(|&v| v > 0.0 && v.is_finite())) else { return none };
    let products = (0..n).map(|i| dot_compensated(0.0, &rows[i * n..(i + 1) * n], &v));
    let Some(kappa) = inflation(n, products, &b) else { return none };
    Bound { value: in_units_of_the_caller(scaling, v.iter().map(|v| kappa * v)), reason: H_PLUS }
}

/// As [`comparison`], with a sparse factorisation.
pub(super) fn comparison_sparse(original: &SparseLcp, scaled: &SparseLcp, scaling: &Scaling, z: &[f64]) -> Bound {
    let n = scaled.n();
    let none = Bound { value: None, reason: NONE };
    let exact = (0..n).all(|i| is_exact(original.row(i).1, scaled.row(i).1));
    let diagonal: Vec<f64> = (0..n).map(|i| scaled.entry(i, i)).collect();
    if !exact || diagonal.iter().any(|&a| a <= 0.0) {
        return none;
    }
    let z = scaling.z_from_caller(z);
    let (w, magnitude) = scaled.slack(&z);
    let b: Vec<f64> = (0..n).map(|i| diagonal_residual(n, diagonal[i], z[i], w[i], magnitude[i])).collect();
    let mut entries = Vec::new();
    for i in 0..n {
        let (columns, values) = scaled.row(i);
        entries.extend(columns.iter().zip(values).map(|(&j, &a)| (i, j, if i == j { a } else { -a.abs() })));
    }
    let solved = super::sparse_solve(n, &entries, &padded(&b));
    let Some(v) = solved.filter(|v| v.iter().all(|&v| v > 0.0 && v.is_finite())) else { return none };
    let mut row = (Vec::new(), Vec::new());
    let products = (0..n).map(|i| {
        let (columns, values) = scaled.row(i);
        row.0.clear();
        row.0.extend(columns.iter().zip(values).map(|(&j, &a)| if i == j { a } else { -a.abs() }));
        row.1.clear();
        row.1.extend(columns.iter().map(|&j| v[j]));
        dot_compensated(0.0, &row.0, &row.1)
    });
    let Some(kappa) = inflation(n, products, &b) else { return none };
    Bound { value: in_units_of_the_caller(scaling, v.iter().map(|v| kappa * v)), reason: H_PLUS }
}

/// b plus a little everywhere, so that `<A> v` comes out positive in every row.
fn padded(b: &[f64]) -> Vec<f64> {
    let pad = match max_abs(b) {
        0.0 => 1.0,
        largest => 1e-6 * largest,
    };
    b.iter().map(|b| b + pad).collect()
}

/// `kappa` with `<A> (kappa v) >= b`, given `<A> v` and its magnitude in each row; `None` unless `<A> v > 0`, which proves
/// that `<A>` is an M-matrix.
fn inflation(n: usize, products: impl Iterator<Item = (f64, f64)>, b: &[f64]) -> Option<f64> {
    let mut kappa = 0.0_f64;
    for ((s, m), b) in products.zip(b) {
        let lower = (s - compensated_error(n, s, m)) * (1.0 - 2.0 * EPS);
        if lower.is_nan() || lower <= 0.0 {
            return None;
        }
        kappa = kappa.max(b / lower * (1.0 + 2.0 * EPS));
    }
    Some(kappa * (1.0 + 4.0 * EPS))
}

/// For `A + A'` positive definite. With `r = min(z, w)` the point `z - r` solves the problem with `q + (A - I) r`, and two
/// solutions differ by at most the difference of their q over lambda. O(n^3).
pub(super) fn definite(lcp: &Lcp, scaling: &Scaling, z: &[f64]) -> Bound {
    let n = lcp.n();
    let none = Bound { value: None, reason: NONE };
    let congruent = Equilibrated::with(lcp, scaling.congruent(lcp.q()));
    let scaled = &congruent.lcp;
    if n == 0 || !is_exact(lcp.a(), scaled.a()) {
        return none;
    }
    let Some(lambda) = least_eigenvalue(scaled) else { return none };
    let z = congruent.scaling.z_from_caller(z);
    let (w, magnitude) = slack(scaled, &z);
    let (r, error): (Vec<f64>, Vec<f64>) =
        (0..n).map(|i| minimum(z[i], 0.0, w[i], compensated_error(n, w[i], magnitude[i]))).unzip();
    let (size, rounding) = (r.iter().map(|r| r.abs()).collect::<Vec<_>>(), 2.0 * (n + 4) as f64 * EPS);
    let mut square = 0.0;
    for i in 0..n {
        let row: Vec<f64> = scaled.row(i).iter().map(|a| a.abs()).collect();
        let product = (dot(scaled.row(i), &r) - r[i]).abs();
        let up = product
            + rounding * (dot(&row, &size) + size[i])
            + (dot(&row, &error) + error[i]) * (1.0 + rounding)
            + n as f64 * TINY;
        square += up * up;
    }
    let largest = size.iter().zip(&error).map(|(r, e)| r + e).fold(0.0, f64::max);
    let bound = (largest + square.sqrt() / lambda) * (1.0 + 2.0 * rounding);
    let value = in_units_of_the_caller(&congruent.scaling, std::iter::repeat_n(bound, n));
    Bound { value, reason: DEFINITE }
}

/// A positive number below the least eigenvalue of `(A + A') / 2`: when Cholesky of `S - mu I` runs to its end,
/// `S - mu I` has no eigenvalue below its backward error. [Rum06]
fn least_eigenvalue(lcp: &Lcp) -> Option<f64> {
    let n = lcp.n();
    let symmetric = |i: usize, j: usize| 0.5 * (lcp.row(i)[j] + lcp.row(j)[i]);
    let mut s: Vec<f64> = (0..n * n).map(|k| symmetric(k / n, k % n)).collect();
    let estimate = estimate(n, &s)?;
    let trace: f64 = (0..n).map(|i| s[i * n + i]).sum();
    // gamma_{n+1} of [Rum06] with room for blocked sums, and the rounding of S and of the shift.
    let backward = 8.0 * (n + 8) as f64 * EPS * (trace + max_abs(&s) * n as f64);
    let mut shifted = 0.0;
    for fraction in [0.99, 0.9, 0.5, 0.1] {
        let mu = fraction * estimate;
        if mu <= 2.0 * backward {
            return None;
        }
        (0..n).for_each(|i| s[i * n + i] -= mu - shifted);
        shifted = mu;
        if DenseCholesky::new(n, &s).is_some() {
            return Some((mu - backward) * (1.0 - 4.0 * EPS));
        }
    }
    None
}

/// Inverse iteration: near the least eigenvalue, from above. `None` when S is not positive definite to rounding.
fn estimate(n: usize, s: &[f64]) -> Option<f64> {
    let factor = DenseCholesky::new(n, s)?;
    let mut x: Vec<f64> = (0..n).map(|i| 1.0 + ((i * 7919) % 101) as f64 / 101.0).collect();
    let mut lambda = f64::INFINITY;
    for _ in 0..INVERSE_ITERATIONS {
        let norm = dot(&x, &x).sqrt();
        x.iter_mut().for_each(|x| *x /= norm);
        x = factor.solve(&x);
        lambda = 1.0 / dot(&x, &x).sqrt();
    }
    (lambda.is_finite() && lambda > 0.0).then_some(lambda)
}

const INVERSE_ITERATIONS: usize = 8;
