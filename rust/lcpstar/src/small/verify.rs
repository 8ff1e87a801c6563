//! Whether a point solves the problem, in the arithmetic of the lanes and therefore with room for its errors: what is
//! accepted here, [`certify`](crate::certify) accepts. What is not, is looked at again by a slower path.
//!
//! Let `m = |A||z| + |q|`. The computed `w_i` is off by at most `e_i = (n + 2) eps/2 m_i` [Hig02, sec. 3.1], so
//! `|min(z_i, w_i)| <= b_i := |w_i| + e_i` where `z_i > 0` and `max(e_i - w_i, 0)` where `z_i = 0`. Never `z_i` itself, which
//! has other units than `w_i`: with the equilibrated problem's entries below 2 and `|q'| < 1`, `m'_i <= 2 n max|z'| + 1`,
//! and ratios `b_i / m_i` do not depend on the scaling, so `(2 n + 1) max_i b_i / m_i` bounds the scale-free residual
//! without equilibrating.
//!
//! `certify` also bounds `max|min(z', w')|` itself on the equilibrated problem. `b_i <= 0.5e-6 |q_i|` in every row is enough for
//! that in any units; where a row fails it, as one with `q_i = 0` does, the scaling is needed: [`is_small_when_equilibrated`].

use super::lane::{Lane, Mask};
use crate::problem::Lcp;
use crate::scaling::{Scaling, times_power_of_two};

/// Lane by lane: accepted or not, and bounds of both residuals.
pub struct Verdict<X: Lane> {
    /// Lanes that solve their problem.
    pub solved: X::Mask,
    /// Lanes that do if [`is_small_when_equilibrated`] says so.
    pub unsettled: X::Mask,
    /// Bound of the scale-free residual.
    pub residual: X,
    /// Bound of the natural residual in the caller's units.
    pub natural_residual: X,
}

/// `m_i` outside this range might hide an overflow or underflow: such rows are not for the fast path.
const MAGNITUDES: std::ops::Range<f64> = 1e-280..1e280;

/// Rounding is forgiven in proportion to `m_i` up to this multiple of `max|q|`: beyond it z is so large that rounding could
/// hide any error, and the slower path decides.
const LARGEST: f64 = 1e8;

/// Judges `z >= 0` and `w = A z + q` as computed. O(n^2).
#[inline(always)]
pub fn verify<X: Lane, const N: usize>(n: usize, a: &[X], q: &[X], z: &[X], w: &[X], tol: f64) -> Verdict<X> {
    let n = if N == 0 { n } else { N };
    let (a, q, z, w) = (&a[..n * n], &q[..n], &z[..n], &w[..n]);
    let mut largest_q = X::splat(0.0);
    for i in 0..n {
        largest_q = q[i].abs().max(largest_q);
    }
    let mut rows = Rows {
        rounding: X::splat(0.5 * (n as f64 + 2.0) * X::EPS * 1.01),
        allowed: largest_q.mul(X::splat(9.99 * tol)),
        largest_m: largest_q.mul(X::splat(LARGEST)),
        solved: X::Mask::ALL,
        small: X::Mask::ALL,
        empty: X::Mask::NONE,
        ratio: X::splat(0.0),
        natural: X::splat(0.0),
    };
    let mut i = 0;
    while i + 4 <= n {
        let mut m = [q[i].abs(), q[i + 1].abs(), q[i + 2].abs(), q[i + 3].abs()];
        for j in 0..n {
            for r in 0..4 {
                m[r] = m[r].add_product(a[(i + r) * n + j].abs(), z[j]);
            }
        }
        for r in 0..4 {
            rows.judge(q[i + r], z[i + r], w[i + r], m[r]);
        }
        i += 4;
    }
    while i < n {
        let mut m = q[i].abs();
        for j in 0..n {
            m = m.add_product(a[i * n + j].abs(), z[j]);
        }
        rows.judge(q[i], z[i], w[i], m);
        i += 1;
    }
    let residual = rows.ratio.mul(X::splat(2.0 * n as f64 + 1.0));
    let mut solved = rows.solved.and(residual.le(X::splat(0.999 * tol)));
    if solved.and(rows.empty).any() {
        solved = solved.and(nothing_lost::<X, N>(n, a, q, z));
    }
    let unsettled = solved.and(rows.small.not());
    Verdict { solved: solved.and(rows.small), unsettled, residual, natural_residual: rows.natural }
}

/// Lanes where an `m_i = 0` means that the row has no term, not that every product underflowed.
#[inline(always)]
fn nothing_lost<X: Lane, const N: usize>(n: usize, a: &[X], q: &[X], z: &[X]) -> X::Mask {
    let n = if N == 0 { n } else { N };
    let zero = X::splat(0.0);
    let mut all = X::Mask::ALL;
    for i in 0..n {
        let (mut m, mut terms) = (q[i].abs(), X::Mask::NONE);
        for j in 0..n {
            let size = a[i * n + j].abs();
            m = m.add_product(size, z[j]);
            terms = terms.or(zero.lt(size).and(zero.lt(z[j])));
        }
        all = all.and(zero.lt(m).or(terms.not()));
    }
    all
}

/// In every row, `b_i` below this part of `|q_i|` keeps `max|min(z', w')|` below `ABSOLUTE` of `certify`, since `|q'| < 1`.
const PART_OF_Q: f64 = 0.5e-6;

/// Whether `max|min(z', w')| <= max(tol, 1e-6)` on the equilibrated problem, for a point that passed everything else.
#[cold]
pub fn is_small_when_equilibrated(n: usize, a: &[f64], q: &[f64], z: &[f64], w: &[f64], tol: f64) -> bool {
    let lcp = Lcp::trusted(n, a.to_vec(), q.to_vec());
    let scaling = Scaling::new(&lcp);
    let rounding = 0.5 * (n as f64 + 2.0) * f64::EPSILON * 1.01;
    (0..n).all(|i| {
        let m = lcp.row(i).iter().zip(z).fold(q[i].abs(), |m, (a, z)| m + a.abs() * z);
        let b = if z[i] > 0.0 { w[i].abs() } else { (-w[i]).max(0.0) } + rounding * m;
        times_power_of_two(b, scaling.rows[i] + scaling.q) <= 0.999 * tol.max(2.0 * PART_OF_Q)
    })
}

/// The rows judged so far.
struct Rows<X: Lane> {
    rounding: X,
    allowed: X,
    largest_m: X,
    solved: X::Mask,
    /// `b_i` is a small part of `|q_i|`.
    small: X::Mask,
    /// Some `m_i` is zero.
    empty: X::Mask,
    ratio: X,
    natural: X,
}

impl<X: Lane> Rows<X> {
    /// Row i: `q_i`, `z_i`, `w_i` and `m_i`. Not a closure: those are not compiled for the instruction set of their caller.
    #[inline(always)]
    fn judge(&mut self, q: X, z: X, w: X, m: X) {
        let zero = X::splat(0.0);
        let (least, most) = (X::splat(MAGNITUDES.start), X::splat(MAGNITUDES.end));
        let e = self.rounding.mul(m);
        let b = e.sub(w).max(w.add(e).only(zero.lt(z))).max(zero).only(zero.lt(m));
        let in_range = m.lt(most).and(least.lt(m).or(m.eq(zero)));
        let in_units = b.le(self.allowed.add_product(X::splat(7.9 * f64::EPSILON), m.min(self.largest_m)));
        self.solved = self.solved.and(in_range).and(in_units).and(zero.le(z));
        self.empty = self.empty.or(m.eq(zero));
        self.small = self.small.and(b.le(q.abs().mul(X::splat(PART_OF_Q))));
        self.ratio = b.div(m.max(least)).max(self.ratio);
        self.natural = b.max(self.natural);
    }
}

/// [`verify`] for one problem in double precision, vectorised along the rows of the padded matrix `a`, `width` vectors
/// a row; also writes `w = A z + q`. O(n^2).
#[inline(always)]
pub fn verify_one<X: Lane<Number = f64>>(
    n: usize,
    width: usize,
    a: &[X],
    q: &[f64],
    z: &[X],
    w: &mut [f64],
    sums: &mut [[X; 2]],
    tol: f64,
) -> Judged {
    for (sums, row) in sums.iter_mut().zip(a.chunks_exact(width)) {
        let mut sum = [X::splat(0.0); 2];
        for (a, z) in row.iter().zip(z) {
            sum[0] = sum[0].add_product(*a, *z);
            sum[1] = sum[1].add_product(a.abs(), *z);
        }
        *sums = sum;
    }
    let rounding = 0.5 * (n as f64 + 2.0) * f64::EPSILON * 1.01;
    let largest_q = q.iter().fold(0.0, |m: f64, x| if x.abs() > m { x.abs() } else { m });
    let (allowed, largest_m) = (9.99 * tol * largest_q, LARGEST * largest_q);
    let (mut solved, mut small, mut ratio, mut natural) = (true, true, 0.0_f64, 0.0_f64);
    for i in 0..n {
        let (wi, m) = (q[i] + sums[i][0].sum(), q[i].abs() + sums[i][1].sum());
        let zi = z[i / X::LANES].get(i % X::LANES);
        w[i] = wi;
        let e = rounding * m;
        let b = match (m > 0.0, zi > 0.0) {
            (false, _) => 0.0,
            (true, false) => (e - wi).max(0.0),
            (true, true) => wi.abs() + e,
        };
        let terms = || a[i * width..(i + 1) * width].iter().zip(z).any(|(a, z)| is_term(*a, *z));
        let in_range = if m == 0.0 { !terms() } else { MAGNITUDES.contains(&m) };
        solved &= in_range && zi >= 0.0 && b <= allowed + 7.9 * f64::EPSILON * m.min(largest_m);
        small &= b <= PART_OF_Q * q[i].abs();
        ratio = ratio.max(b / m.max(MAGNITUDES.start));
        natural = natural.max(b);
    }
    let residual = (2.0 * n as f64 + 1.0) * ratio;
    solved &= residual <= 0.999 * tol;
    Judged { solved: solved && small, unsettled: solved && !small, residual, natural_residual: natural }
}

/// Whether a lane of `a z` is not zero, though it may underflow.
#[inline(always)]
fn is_term<X: Lane>(a: X, z: X) -> bool {
    let zero = X::splat(0.0);
    zero.lt(a.abs()).and(zero.lt(z)).any()
}

/// What [`verify_one`] found.
#[derive(Clone, Copy, Debug)]
pub struct Judged {
    /// Whether the point solves the problem.
    pub solved: bool,
    /// It does if [`is_small_when_equilibrated`] says so.
    pub unsettled: bool,
    /// Bound of the scale-free residual.
    pub residual: f64,
    /// Bound of the natural residual in the caller's units.
    pub natural_residual: f64,
}
