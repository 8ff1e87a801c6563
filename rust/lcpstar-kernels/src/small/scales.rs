//! The equilibration of the contract in the arithmetic of the lanes: Ruiz sweeps on powers of two, the same factors, bit for bit, as
//! the general solver computes with integers. [Rui01]

use super::lane::{BLOCK, Lane, Mask};

/// Sweeps at most.
const SWEEPS: usize = 12;

/// Largest order in lanes.
pub const LANES_UP_TO: usize = 32;
/// Most vectors of columns of one problem.
pub const WIDEST: usize = 24;

/// Numbers whose products with the factors stay far from both ends of the range of doubles.
const LEAST: f64 = 1e-150;
const MOST: f64 = 1e150;

/// `R`, `C` and `S`: `A' = R A C`, `q' = S R q`, so that `z' = S C^-1 z` and `w' = S R w`.
pub struct Scales<X, const N: usize> {
    /// Factors of rows, as many as there are.
    pub rows: [X; N],
    /// Factors of columns.
    pub columns: [X; N],
    /// The factor of q.
    pub q: X,
}

impl<X: Lane, const N: usize> Scales<X, N> {
    /// The factors of w and z in row i (or block of rows i): `R_i`, `1 / C_i`, `S`.
    #[inline(always)]
    pub fn of(&self, i: usize) -> [X; 3] {
        [self.rows[i], X::splat(1.0).div(self.columns[i]), self.q]
    }
}

/// The factor that moves a largest entry half the way to 1: `2^-(e / 2)`, rounded towards 1, where `2^(e-1) <= x < 2^e`; 1 for 0.
#[inline(always)]
fn halfway<X: Lane>(x: X) -> X {
    let half = x.exponent().mul(X::splat(-0.5)).truncated().two_to();
    half.or_else(X::splat(0.0).lt(x), X::splat(1.0))
}

/// `2^-e`, where `2^(e-1) <= x < 2^e`; 1 for 0.
#[inline(always)]
fn below_one<X: Lane>(x: X) -> X {
    x.exponent().neg().two_to().or_else(X::splat(0.0).lt(x), X::splat(1.0))
}

/// The scales of the problem in each lane, and the lanes in which they can be trusted. O(n^2) a sweep, two or three as a rule.
#[inline(always)]
pub fn in_lanes<X: Lane, const N: usize>(n: usize, a: &[X], q: &[X]) -> (Scales<X, LANES_UP_TO>, X::Mask) {
    let n = if N == 0 { n } else { N };
    let (zero, one) = (X::splat(0.0), X::splat(1.0));
    let mut scales = Scales { rows: [one; LANES_UP_TO], columns: [one; LANES_UP_TO], q: one };
    let (mut least, mut most) = (one, one);
    for x in a[..n * n].iter().chain(&q[..n]) {
        let size = x.abs();
        most = size.max(most);
        least = size.or_else(zero.lt(size), one).min(least);
    }
    let trusted = most.lt(X::splat(MOST)).and(X::splat(LEAST).le(least));
    for _ in 0..SWEEPS {
        let (mut row_max, mut column_max) = ([zero; LANES_UP_TO], [zero; LANES_UP_TO]);
        for i in 0..n {
            let r = scales.rows[i];
            let mut largest = zero;
            for j in 0..n {
                let size = a[i * n + j].abs();
                largest = size.mul(scales.columns[j]).max(largest);
                column_max[j] = size.mul(r).max(column_max[j]);
            }
            row_max[i] = largest;
        }
        let mut settled = X::Mask::ALL;
        for i in 0..n {
            let r = halfway(row_max[i].mul(scales.rows[i]));
            let c = halfway(column_max[i].mul(scales.columns[i]));
            settled = settled.and(r.eq(one)).and(c.eq(one));
            scales.rows[i] = scales.rows[i].mul(r);
            scales.columns[i] = scales.columns[i].mul(c);
        }
        if !settled.not().any() {
            break;
        }
    }
    let mut largest = zero;
    for i in 0..n {
        largest = q[i].abs().mul(scales.rows[i]).max(largest);
    }
    scales.q = below_one(largest);
    (scales, trusted)
}

/// The scales of one problem, rows and columns in vectors of `BLOCK`, the factor of q in every lane; `None` where they cannot be
/// trusted. O(n^2) a sweep.
#[inline(always)]
pub fn of_one<X: Lane>(a: &[f64], q: &[f64]) -> Option<Scales<X, WIDEST>> {
    let (n, width) = (q.len(), q.len().div_ceil(BLOCK));
    let (zero, one) = (X::splat(0.0), X::splat(1.0));
    let mut scales = Scales { rows: [one; WIDEST], columns: [one; WIDEST], q: one };
    let (mut least, mut most) = (one, one);
    for x in a.chunks(BLOCK).chain(q.chunks(BLOCK)) {
        let size = X::from_slice(x).abs();
        most = size.max(most);
        least = size.or_else(zero.lt(size), one).min(least);
    }
    if width > WIDEST || !(most.largest() < MOST && least.smallest() >= LEAST) {
        return None;
    }
    for _ in 0..SWEEPS {
        let (mut row_max, mut column_max) = ([zero; WIDEST], [zero; WIDEST]);
        for (i, row) in a.chunks_exact(n).enumerate() {
            let r = X::splat(scales.rows[i / BLOCK].get(i % BLOCK));
            let mut largest = zero;
            for (k, numbers) in row.chunks(BLOCK).enumerate() {
                let size = X::from_slice(numbers).abs();
                largest = size.mul(scales.columns[k]).max(largest);
                column_max[k] = size.mul(r).max(column_max[k]);
            }
            row_max[i / BLOCK].set(i % BLOCK, largest.largest());
        }
        let mut settled = X::Mask::ALL;
        for k in 0..width {
            let r = halfway(row_max[k].mul(scales.rows[k]));
            let c = halfway(column_max[k].mul(scales.columns[k]));
            settled = settled.and(r.eq(one)).and(c.eq(one));
            scales.rows[k] = scales.rows[k].mul(r);
            scales.columns[k] = scales.columns[k].mul(c);
        }
        if !settled.not().any() {
            break;
        }
    }
    let mut largest = zero;
    for (q, r) in q.chunks(BLOCK).zip(&scales.rows) {
        largest = X::from_slice(q).abs().mul(*r).max(largest);
    }
    scales.q = below_one(X::splat(largest.largest()));
    Some(scales)
}
