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
//! that in any units. Where a row fails it, as one with `q_i = 0` does: let every nonzero row and column have its largest entry
//! in [1/K, K]. The first sweep of the equilibration moves no exponent by more than half of `log K`; it leaves no entry above 1
//! and no row below `1/K`, which the other sweeps undo by halves. So with two bits for its rounding `2^(r_i + s) max|q| <=
//! 16 K^3`, and `16 K^3 max b_i <= 1e-6 max|q|` is enough. Beyond that the scaling is needed: [`is_small_when_equilibrated`].

use super::lane::{BLOCK, Lane, Mask};
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
    let mut rows = Rows::new(n, largest_q, tol);
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
    let mut small = rows.small;
    if solved.and(small.not()).any() {
        let grown = rows.natural.mul(growth::<X, N>(n, a));
        small = small.or(grown.le(largest_q.mul(X::splat(absolute(tol)))));
    }
    let unsettled = solved.and(small.not());
    Verdict { solved: solved.and(small), unsettled, residual, natural_residual: rows.natural }
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

/// What `max|min(z', w')|` may be.
#[inline(always)]
fn absolute(tol: f64) -> f64 {
    0.999 * tol.max(2.0 * PART_OF_Q)
}

/// `16 K^3`, see the module.
#[inline(always)]
fn growth<X: Lane, const N: usize>(n: usize, a: &[X]) -> X {
    let n = if N == 0 { n } else { N };
    let (zero, one) = (X::splat(0.0), X::splat(1.0));
    let (mut most, mut least) = (one, one);
    for i in 0..n {
        let (mut row, mut column) = (zero, zero);
        for j in 0..n {
            row = a[i * n + j].abs().max(row);
            column = a[j * n + i].abs().max(column);
        }
        for x in [row, column] {
            most = x.max(most);
            least = x.or_else(zero.lt(x), one).min(least);
        }
    }
    let k = most.max(one.div(least));
    k.mul(k).mul(k).mul(X::splat(16.0))
}

/// Whether `max|min(z', w')| <= max(tol, 1e-6)` on the equilibrated problem, for a point that passed everything else.
#[cold]
pub fn is_small_when_equilibrated(n: usize, a: &[f64], q: &[f64], z: &[f64], w: &[f64], tol: f64) -> bool {
    let lcp = Lcp::trusted(n, a.to_vec(), q.to_vec());
    let scaling = Scaling::new(&lcp);
    let rounding = 0.5 * (n as f64 + 2.0) * f64::EPSILON * 1.01;
    (0..n).all(|i| {
        let m = lcp.row(i).iter().zip(z).fold(q[i].abs(), |m, (a, z)| m + a.abs() * z);
        let b = if z[i] > 0.0 { w[i].abs() } else { (-w[i]).max(0.0) } + rounding * m;
        times_power_of_two(b, scaling.rows[i] + scaling.q) <= absolute(tol)
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
    #[inline(always)]
    fn new(n: usize, largest_q: X, tol: f64) -> Self {
        Self {
            rounding: X::splat(0.5 * (n as f64 + 2.0) * X::EPS * 1.01),
            allowed: largest_q.mul(X::splat(9.99 * tol)),
            largest_m: largest_q.mul(X::splat(LARGEST)),
            solved: X::Mask::ALL,
            small: X::Mask::ALL,
            empty: X::Mask::NONE,
            ratio: X::splat(0.0),
            natural: X::splat(0.0),
        }
    }

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

/// [`verify`] for one problem in double precision, a row-major; also writes `w = A z + q`. O(n^2).
#[inline(always)]
pub fn verify_one<X: Lane<Number = f64>>(
    a: &[f64],
    q: &[f64],
    z: &[X],
    sums: &mut [[X; 2]],
    w: &mut [f64],
    tol: f64,
) -> Judged {
    let n = q.len();
    let mut largest_q = X::splat(0.0);
    for q in q.chunks(BLOCK) {
        largest_q = X::from_slice(q).abs().max(largest_q);
    }
    slacks_and_magnitudes(a, q, z, sums);
    let largest_q = largest_q.largest();
    let mut rows = Rows::<X>::new(n, X::splat(largest_q), tol);
    let padded = sums.iter().zip(z);
    for (((sums, z), q), w) in padded.zip(q.chunks(BLOCK)).zip(w.chunks_mut(BLOCK)) {
        rows.judge(X::from_slice(q), *z, sums[0], sums[1]);
        for (l, w) in w.iter_mut().enumerate() {
            *w = sums[0].get(l);
        }
    }
    let (ratio, natural) = (rows.ratio.largest(), rows.natural.largest());
    let residual = (2.0 * n as f64 + 1.0) * ratio;
    let mut solved = !rows.solved.not().any() && residual <= 0.999 * tol;
    if solved && rows.empty.any() {
        solved = !something_lost(n, a, z, sums);
    }
    let mut small = !rows.small.not().any();
    if solved && !small {
        small = natural * growth_of_one::<X>(n, a) <= absolute(tol) * largest_q;
    }
    Judged { solved: solved && small, unsettled: solved && !small, residual, natural_residual: natural }
}

/// `w = A z + q` and `m = |A||z| + |q|` block by block, for the blocks of z. O(n^2), four rows at a time.
#[inline(always)]
fn slacks_and_magnitudes<X: Lane<Number = f64>>(a: &[f64], q: &[f64], z: &[X], sums: &mut [[X; 2]]) {
    const ROWS: usize = 4;
    let (n, zero) = (q.len(), X::splat(0.0));
    let whole = n / BLOCK;
    sums.fill([zero; 2]);
    for first in (0..n).step_by(ROWS) {
        let mut rows: [&[f64]; ROWS] = [&[]; ROWS];
        for (r, row) in rows.iter_mut().enumerate() {
            // Rows beyond the last repeat it.
            let i = (first + r).min(n - 1);
            *row = &a[i * n..(i + 1) * n];
        }
        let mut both = [[zero; 2]; ROWS];
        for (k, &z) in z.iter().enumerate() {
            for (row, both) in rows.iter().zip(&mut both) {
                let a = if k < whole {
                    X::from_slice(&row[k * BLOCK..(k + 1) * BLOCK])
                } else {
                    X::from_slice(&row[k * BLOCK..])
                };
                *both = [both[0].add_product(a, z), both[1].add_product(a.abs(), z)];
            }
        }
        for (i, both) in (first..n).zip(both) {
            sums[i / BLOCK][0].set(i % BLOCK, q[i] + both[0].sum());
            sums[i / BLOCK][1].set(i % BLOCK, q[i].abs() + both[1].sum());
        }
    }
}

/// Whether a row with `m_i = 0` has a product that underflowed.
#[inline(always)]
fn something_lost<X: Lane<Number = f64>>(n: usize, a: &[f64], z: &[X], sums: &[[X; 2]]) -> bool {
    let positive = |j: usize| z[j / BLOCK].get(j % BLOCK) > 0.0;
    a.chunks_exact(n)
        .enumerate()
        .filter(|(i, _)| sums[i / BLOCK][1].get(i % BLOCK) == 0.0)
        .any(|(_, row)| row.iter().enumerate().any(|(j, &a)| a != 0.0 && positive(j)))
}

/// Vectors per row up to which the columns are looked at.
const WIDEST: usize = 32;

/// [`growth`] for one problem.
#[inline(always)]
fn growth_of_one<X: Lane<Number = f64>>(n: usize, a: &[f64]) -> f64 {
    let width = n.div_ceil(BLOCK);
    if width > WIDEST {
        return f64::INFINITY;
    }
    let (zero, one) = (X::splat(0.0), X::splat(1.0));
    let mut across = [zero; WIDEST];
    let (mut most, mut least) = (1.0_f64, 1.0_f64);
    for row in a.chunks_exact(n) {
        let mut largest = zero;
        for (numbers, m) in row.chunks(BLOCK).zip(&mut across) {
            let size = X::from_slice(numbers).abs();
            largest = size.max(largest);
            *m = size.max(*m);
        }
        let largest = largest.largest();
        most = most.max(largest);
        least = if largest > 0.0 { least.min(largest) } else { least };
    }
    for m in &across[..width] {
        least = least.min(m.or_else(zero.lt(*m), one).smallest());
    }
    16.0 * most.max(1.0 / least).powi(3)
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
