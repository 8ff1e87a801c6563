//! Rigorous bounds on `max|z - z*|`, for two classes of P-matrices.

use super::row::{Row, Wide};
use crate::control::Control;
use crate::equilibrate::{Equilibrated, Rows};
use crate::linalg::backend::{DenseCholesky, DenseLu, SparseFactor};
use crate::linalg::kernels::{dot, dot_compensated, max_abs};
use crate::problem::Lcp;
use crate::scaling::Scaling;
use crate::sparse::SparseLcp;

/// A bound, or none, and why.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    pub(super) value: Option<f64>,
    pub(super) reason: &'static str,
}

impl Bound {
    /// Without a proof, or without the time for one.
    fn none(control: &Control<'_>) -> Self {
        Self { value: None, reason: if control.expired().is_some() { STOPPED } else { NONE } }
    }
}

const H_PLUS: &str = "A is an H-matrix with positive diagonal: |z - z*| <= v for v > 0 with <A> v >= |min(diag(A) z, w)|, \
     <A> the comparison matrix [CX06]";
const DEFINITE: &str =
    "A + A' is positive definite: |z - z*| <= max|r| + |(A - I) r|_2 / lambda, r = min(z, w), on D A D [MP90]";
/// Why there is no bound.
pub(super) const NONE: &str = "none: A was shown neither to be an H-matrix with positive diagonal nor to have A + A' positive \
     definite, so that the solution need not be unique";

const STOPPED: &str = "none: stopped before one was found";

/// Half a unit in the last place, doubled: the error of one operation is below.
const EPS: f64 = f64::EPSILON;
/// Products that underflow lose less than this each.
const TINY: f64 = 1e-300;

/// An upper bound of the error of [`dot_compensated`] with n terms, result s and magnitude m. [ORO05, prop. 5.5]
fn compensated_error(n: usize, s: f64, m: f64) -> f64 {
    let n = (n + 4) as f64;
    EPS * s.abs() + 2.0 * (n * EPS) * (n * EPS) * m + n * TINY
}

/// Powers of two that change a digit would void the proof.
fn is_exact(original: &[f64], scaled: &[f64]) -> bool {
    original.iter().zip(scaled).all(|(a, s)| *a == 0.0 || s.is_normal() && a.is_normal())
}

/// A vector in units of `2^exponent`, at most 1 by size and above rounding level where it is not 0.
struct InUnits {
    exponent: i64,
    numbers: Vec<f64>,
}

impl InUnits {
    fn new(x: &[Wide]) -> Self {
        let exponent = x.iter().map(|x| x.exponent()).max().unwrap_or(0);
        Self { exponent, numbers: x.iter().map(|x| x.in_units(exponent)).collect() }
    }

    /// `max 2^(c_i - q) v_i` for v in these units, rounded up.
    fn largest_of_caller(&self, scaling: &Scaling, v: impl Iterator<Item = Wide>) -> f64 {
        let exponent = self.exponent as i32 - scaling.q;
        v.zip(&scaling.columns).map(|(v, c)| v.shifted(exponent + c)).fold(Wide::ZERO, Wide::max).up()
    }
}

/// `min(a_ii z_i, w_i)` for every i; the nearest numbers.
fn diagonal_residual(scaling: &Scaling, diagonal: &[f64], point: &[Row]) -> InUnits {
    let of_row = |(i, row): (usize, &Row)| {
        let (z, w) = row.scaled(scaling, i);
        Wide::new(diagonal[i]).times(z).min(w)
    };
    let r: Vec<Wide> = point.iter().enumerate().map(of_row).collect();
    InUnits::new(&r)
}

/// Above a number that is known to a few units in the last place or to the smallest double; 0 stays 0.
fn above(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.abs() * (1.0 + 8.0 * EPS) + TINY }
}

/// For H-matrices with positive diagonal. With `I` in the place of the row scaling `diag(A)^-1` this is Theorem 2.1 of
/// [CX06]; its proof gives the bound entry by entry. O(n^3).
pub(super) fn comparison(problem: &Equilibrated<'_>, point: &[Row], control: &Control<'_>) -> Bound {
    let lcp = &problem.lcp;
    let n = lcp.n();
    let diagonal: Vec<f64> = (0..n).map(|i| lcp.row(i)[i]).collect();
    if diagonal.iter().any(|&a| a <= 0.0) || !is_exact(problem.original.a(), lcp.a()) {
        return Bound::none(control);
    }
    let mut rows: Vec<f64> = lcp.a().iter().map(|a| -a.abs()).collect();
    diagonal.iter().enumerate().for_each(|(i, a)| rows[i * n + i] = *a);
    by_comparison(
        &problem.scaling,
        &diagonal,
        point,
        control,
        |b| DenseLu::new(n, &rows).map(|lu| lu.solve(b)),
        |i, v| dot_compensated(0.0, &rows[i * n..(i + 1) * n], v),
    )
}

/// As [`comparison`], with a sparse factorisation.
pub(super) fn comparison_sparse(
    original: &SparseLcp,
    scaled: &SparseLcp,
    scaling: &Scaling,
    point: &[Row],
    control: &Control<'_>,
) -> Bound {
    let n = scaled.n();
    let diagonal: Vec<f64> = (0..n).map(|i| scaled.entry(i, i)).collect();
    if diagonal.iter().any(|&a| a <= 0.0) || !(0..n).all(|i| is_exact(original.row(i).1, scaled.row(i).1)) {
        return Bound::none(control);
    }
    let row = |i: usize| {
        let (columns, values) = scaled.row(i);
        columns.iter().zip(values).map(move |(&j, &a)| (j, if i == j { a } else { -a.abs() }))
    };
    let entries: Vec<_> = (0..n).flat_map(|i| row(i).map(move |(j, a)| (i, j, a))).collect();
    by_comparison(
        scaling,
        &diagonal,
        point,
        control,
        |b| sparse_solve(n, &entries, b, control),
        |i, v| {
            let (a, x): (Vec<f64>, Vec<f64>) = row(i).map(|(j, a)| (a, v[j])).unzip();
            dot_compensated(0.0, &a, &x)
        },
    )
}

/// `solve` and `times` (a row, with the sum of sizes) are those of the comparison matrix.
fn by_comparison(
    scaling: &Scaling,
    diagonal: &[f64],
    point: &[Row],
    control: &Control<'_>,
    solve: impl FnOnce(&[f64]) -> Option<Vec<f64>>,
    times: impl Fn(usize, &[f64]) -> (f64, f64),
) -> Bound {
    let n = point.len();
    let r = diagonal_residual(scaling, diagonal, point);
    let b: Vec<f64> = r.numbers.iter().map(|&r| above(r)).collect();
    if control.expired().is_some() {
        return Bound::none(control);
    }
    let Some(v) = solve(&padded(&b)).filter(|v| v.iter().all(|&v| v > 0.0 && v.is_finite())) else {
        return Bound::none(control);
    };
    let Some(kappa) = inflation(n, (0..n).map(|i| times(i, &v)), &b) else { return Bound::none(control) };
    let v = v.into_iter().map(|v| Wide::new(v).times(Wide::new(kappa)));
    Bound { value: Some(r.largest_of_caller(scaling, v)), reason: H_PLUS }
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
    Some(kappa * (1.0 + 4.0 * EPS)).filter(|kappa| kappa.is_finite())
}

/// For `A + A'` positive definite. With `r = min(z, w)` the point `z - r` solves the problem with `q + (A - I) r`, and two
/// solutions differ by at most the difference of their q over lambda. O(n^3).
pub(super) fn definite(lcp: &Lcp, scaling: &Scaling, point: &[Row], control: &Control<'_>) -> Bound {
    let n = lcp.n();
    let congruent = Equilibrated::with(lcp, scaling.congruent(lcp.q()));
    let (scaled, scaling) = (&congruent.lcp, &congruent.scaling);
    if n == 0 || !is_exact(lcp.a(), scaled.a()) {
        return Bound::none(control);
    }
    let Some(lambda) = least_eigenvalue(scaled, control) else { return Bound::none(control) };
    let least = |(i, row): (usize, &Row)| {
        let (z, w) = row.scaled(scaling, i);
        z.min(w)
    };
    let r: Vec<Wide> = point.iter().enumerate().map(least).collect();
    let units = InUnits::new(&r);
    let (r, rounding) = (&units.numbers, 2.0 * (n + 8) as f64 * EPS);
    let size: Vec<f64> = r.iter().map(|&r| above(r)).collect();
    let product = |i: usize| {
        let row: Vec<f64> = scaled.row(i).iter().map(|a| a.abs()).collect();
        (dot(scaled.row(i), r) - r[i]).abs() + rounding * (dot(&row, &size) + size[i]) + n as f64 * TINY
    };
    let products: Vec<f64> = (0..n).map(product).collect();
    let largest = max_abs(&products);
    let norm = largest * products.iter().map(|p| (p / largest).powi(2)).sum::<f64>().sqrt();
    if size.iter().all(|&r| r == 0.0) {
        return Bound { value: Some(0.0), reason: DEFINITE };
    }
    let bound = (max_abs(&size) + norm / lambda) * (1.0 + 2.0 * rounding);
    let value = if bound.is_finite() {
        units.largest_of_caller(scaling, std::iter::repeat_n(Wide::new(bound), n))
    } else {
        f64::INFINITY
    };
    Bound { value: Some(value), reason: DEFINITE }
}

/// A positive number below the least eigenvalue of `(A + A') / 2`: when Cholesky of `S - mu I` runs to its end,
/// `S - mu I` has no eigenvalue below its backward error. [Rum06]
fn least_eigenvalue(lcp: &Lcp, control: &Control<'_>) -> Option<f64> {
    let n = lcp.n();
    let symmetric = |i: usize, j: usize| 0.5 * (lcp.row(i)[j] + lcp.row(j)[i]);
    let mut s: Vec<f64> = (0..n * n).map(|k| symmetric(k / n, k % n)).collect();
    let estimate = estimate(n, &s, control)?;
    let trace: f64 = (0..n).map(|i| s[i * n + i]).sum();
    // gamma_{n+1} of [Rum06] with room for blocked sums, and the rounding of S and of the shift.
    let backward = 8.0 * (n + 8) as f64 * EPS * (trace + max_abs(&s) * n as f64) + n as f64 * TINY;
    let mut shifted = 0.0;
    for fraction in [0.99, 0.9, 0.5, 0.1] {
        let mu = fraction * estimate;
        if mu <= 2.0 * backward || control.expired().is_some() {
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
fn estimate(n: usize, s: &[f64], control: &Control<'_>) -> Option<f64> {
    let factor = DenseCholesky::new(n, s)?;
    let mut x: Vec<f64> = (0..n).map(|i| 1.0 + ((i * 7919) % 101) as f64 / 101.0).collect();
    let mut lambda = f64::INFINITY;
    for _ in 0..INVERSE_ITERATIONS {
        if control.expired().is_some() {
            return None;
        }
        let norm = dot(&x, &x).sqrt();
        x.iter_mut().for_each(|x| *x /= norm);
        x = factor.solve(&x);
        lambda = 1.0 / dot(&x, &x).sqrt();
    }
    (lambda.is_finite() && lambda > 0.0).then_some(lambda)
}

const INVERSE_ITERATIONS: usize = 8;

/// The solution of `M v = b` for a sparse M given by entries. `None` without a factorisation.
fn sparse_solve(n: usize, entries: &[(usize, usize, f64)], b: &[f64], control: &Control<'_>) -> Option<Vec<f64>> {
    let mut factor = SparseFactor::new(n, entries, false).filter(|_| control.expired().is_none())?;
    let mut v = b.to_vec();
    factor.factor(&vec![0.0; n]).then(|| factor.solve(&mut v))?;
    Some(v)
}
