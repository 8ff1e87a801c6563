//! Whether a point solves the problem, in the arithmetic of the lanes and therefore with room for its errors: what is accepted here,
//! the rule of the judge accepts (`lcpstar::residual::Rule`). What is not, is looked at again by a slower path.
//!
//! Let `m = |A||z| + |q|`. The computed `w_i` is off by at most `e_i = (n + 2) eps/2 m_i` [Hig02, sec. 3.1], so
//! `|min(z_i, w_i)| <= b_i := |w_i| + e_i` where `z_i > 0` and `max(e_i - w_i, 0)` where `z_i = 0`. The tests of the rule follow one by
//! one from those of [`Rows::judge`] and [`Scaled::is_small`], each with a thousandth to spare for the rounding of the test itself:
//!
//! 1. and 3.: `max|min(z', w')| <= max b'_i`, which may be `tol max(1, max|z'|)` and `max(tol, 1e-6)` at most;
//! 2. `b_i <= 10 tol max|q| + 8 eps m_i`;
//! 4. `b_i <= tol m_i / (2 n + 1)`, a smaller part of `m_i` than `sqrt(tol)`. So near to complementarity a basis is right and not only
//!    its point.

use super::lane::{BLOCK, Lane, Mask};
use super::scales::Scales;

/// The number of "solved" among the statuses; a batch writes it for what was accepted.
pub const SOLVED: u8 = 0;

/// That a point was accepted; nothing outside this file makes one. Both residuals are measured, for w as it was computed.
#[derive(Clone, Copy, Debug)]
pub struct Accepted {
    residual: f64,
    natural_residual: f64,
}

impl Accepted {
    /// `max|min(z', w')| / max(1, max|z'|)` on the equilibrated problem.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// `max|min(z, w)|` in the caller's units.
    #[must_use]
    pub fn natural_residual(&self) -> f64 {
        self.natural_residual
    }
}

/// Lane by lane: accepted or not, and both residuals as measured.
pub struct Verdict<X: Lane> {
    solved: X::Mask,
    residual: X,
    natural_residual: X,
}

impl<X: Lane> Verdict<X> {
    /// Lanes that solve their problem.
    #[inline(always)]
    pub fn solved(&self) -> X::Mask {
        self.solved
    }

    /// The acceptance of lane `l`, if it solves its problem.
    #[inline(always)]
    pub fn accepted(&self, l: usize) -> Option<Accepted> {
        let (residual, natural_residual) = (self.residual.get(l), self.natural_residual.get(l));
        self.solved.get(l).then_some(Accepted { residual, natural_residual })
    }
}

/// `m_i` outside this range might hide an overflow or underflow: such rows are not for the fast path.
const MAGNITUDES: std::ops::Range<f64> = 1e-280..1e280;

/// Rounding is forgiven in proportion to `m_i` up to this multiple of `max|q|`: beyond it z is so large that rounding could
/// hide any error, and the slower path decides.
const LARGEST: f64 = 1e8;

/// What `max|min(z', w')|` may be.
const ABSOLUTE: f64 = 1e-6;

/// Judges `z >= 0` and `w = A z + q` as computed, in the lanes that are `asked`. O(n^2). The scales are found if one of them may solve
/// its problem.
#[inline(always)]
pub fn verify<X: Lane, const N: usize>(
    n: usize,
    a: &[X],
    q: &[X],
    z: &[X],
    w: &[X],
    tol: f64,
    scales: &mut Scales<X>,
    asked: X::Mask,
) -> Verdict<X> {
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
            scales.bounds[i + r] = rows.judge(z[i + r], w[i + r], m[r]);
        }
        i += 4;
    }
    while i < n {
        let mut m = q[i].abs();
        for j in 0..n {
            m = m.add_product(a[i * n + j].abs(), z[j]);
        }
        scales.bounds[i] = rows.judge(z[i], w[i], m);
        i += 1;
    }
    let mut solved = rows.solved.and(asked);
    if solved.and(rows.empty).any() {
        solved = solved.and(nothing_lost::<X, N>(n, a, q, z));
    }
    if !solved.any() {
        return Verdict { solved, residual: rows.natural, natural_residual: rows.natural };
    }
    scales.find_in_lanes::<N>(n, a, q);
    let mut scaled = Scaled::new();
    for i in 0..n {
        scaled.add(z[i], w[i], scales.bounds[i], scales.of(i));
    }
    let solved = solved.and(scales.trusted).and(scaled.is_small(tol));
    Verdict { solved, residual: scaled.residual(), natural_residual: rows.natural }
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

/// The rows judged so far, in the caller's units.
struct Rows<X: Lane> {
    rounding: X,
    allowed: X,
    part: X,
    largest_m: X,
    solved: X::Mask,
    /// Some `m_i` is zero.
    empty: X::Mask,
    natural: X,
}

impl<X: Lane> Rows<X> {
    #[inline(always)]
    fn new(n: usize, largest_q: X, tol: f64) -> Self {
        Self {
            rounding: X::splat(0.5 * (n as f64 + 2.0) * f64::EPSILON * 1.01),
            allowed: largest_q.mul(X::splat(9.99 * tol)),
            part: X::splat(0.999 * tol / (2.0 * n as f64 + 1.0)),
            largest_m: largest_q.mul(X::splat(LARGEST)),
            solved: X::Mask::ALL,
            empty: X::Mask::NONE,
            natural: X::splat(0.0),
        }
    }

    /// Row i: `z_i`, `w_i`, `m_i`; returns `b_i`. Not a closure: those are not compiled for the instruction set of their caller.
    #[inline(always)]
    fn judge(&mut self, z: X, w: X, m: X) -> X {
        let zero = X::splat(0.0);
        let (least, most) = (X::splat(MAGNITUDES.start), X::splat(MAGNITUDES.end));
        let e = self.rounding.mul(m);
        let b = e.sub(w).max(w.add(e).only(zero.lt(z))).max(zero).only(zero.lt(m));
        let in_range = m.lt(most).and(least.lt(m).or(m.eq(zero)));
        let in_units = b.le(self.allowed.add_product(X::splat(7.9 * f64::EPSILON), m.min(self.largest_m)));
        let in_part = b.le(m.mul(self.part));
        self.solved = self.solved.and(in_range).and(in_units).and(in_part).and(zero.le(z));
        self.empty = self.empty.or(m.eq(zero));
        self.natural = z.min(w).abs().max(self.natural);
        b
    }
}

/// The rows judged so far, on the equilibrated problem.
struct Scaled<X: Lane> {
    /// `max b'_i`, `max|min(z', w')|` and `max(1, max|z'|)`.
    bound: X,
    violation: X,
    largest_z: X,
}

impl<X: Lane> Scaled<X> {
    #[inline(always)]
    fn new() -> Self {
        Self { bound: X::splat(0.0), violation: X::splat(0.0), largest_z: X::splat(1.0) }
    }

    /// Row i: `z_i`, `w_i`, `b_i`, and the factors `R_i`, `1 / C_i`, `S`.
    #[inline(always)]
    fn add(&mut self, z: X, w: X, b: X, [r, c, s]: [X; 3]) {
        let (z, w) = (z.mul(c).mul(s), w.mul(r).mul(s));
        self.bound = b.mul(r).mul(s).max(self.bound);
        self.violation = z.min(w).abs().max(self.violation);
        self.largest_z = z.max(self.largest_z);
    }

    /// Tests 1 and 3, lane by lane.
    #[inline(always)]
    fn is_small(&self, tol: f64) -> X::Mask {
        let relative = self.bound.le(self.largest_z.mul(X::splat(0.999 * tol)));
        relative.and(self.bound.le(X::splat(0.999 * tol.max(ABSOLUTE))))
    }

    #[inline(always)]
    fn residual(&self) -> X {
        self.violation.div(self.largest_z)
    }
}

/// [`verify`] for one problem in double precision, a row-major; also writes `w = A z + q`. O(n^2).
#[inline(always)]
pub fn verify_one<X: Lane>(
    a: &[f64],
    q: &[f64],
    z: &[X],
    sums: &mut [[X; 2]],
    w: &mut [f64],
    tol: f64,
    scales: &mut Scales<X>,
) -> Option<Accepted> {
    let n = q.len();
    let mut largest_q = X::splat(0.0);
    for q in q.chunks(BLOCK) {
        largest_q = X::from_slice(q).abs().max(largest_q);
    }
    slacks_and_magnitudes(a, q, z, sums);
    let mut rows = Rows::<X>::new(n, X::splat(largest_q.largest()), tol);
    for (((sums, z), w), b) in sums.iter().zip(z).zip(w.chunks_mut(BLOCK)).zip(&mut scales.bounds) {
        *b = rows.judge(*z, sums[0], sums[1]);
        for (l, w) in w.iter_mut().enumerate() {
            *w = sums[0].get(l);
        }
    }
    if rows.solved.not().any() || (rows.empty.any() && something_lost(n, a, z, sums)) {
        return None;
    }
    scales.find_for_one(a, q);
    let mut scaled = Scaled::new();
    for (k, (sums, z)) in sums.iter().zip(z).enumerate() {
        scaled.add(*z, sums[0], scales.bounds[k], scales.of(k));
    }
    for x in [&mut scaled.bound, &mut scaled.violation, &mut scaled.largest_z] {
        *x = X::splat(x.largest());
    }
    let solved = !scales.trusted.and(scaled.is_small(tol)).not().any();
    let (residual, natural_residual) = (scaled.residual().get(0), rows.natural.largest());
    solved.then_some(Accepted { residual, natural_residual })
}

/// `w = A z + q` and `m = |A||z| + |q|` block by block, for the blocks of z. O(n^2), four rows at a time.
#[inline(always)]
fn slacks_and_magnitudes<X: Lane>(a: &[f64], q: &[f64], z: &[X], sums: &mut [[X; 2]]) {
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
fn something_lost<X: Lane>(n: usize, a: &[f64], z: &[X], sums: &[[X; 2]]) -> bool {
    let positive = |j: usize| z[j / BLOCK].get(j % BLOCK) > 0.0;
    a.chunks_exact(n)
        .enumerate()
        .filter(|(i, _)| sums[i / BLOCK][1].get(i % BLOCK) == 0.0)
        .any(|(_, row)| row.iter().enumerate().any(|(j, &a)| a != 0.0 && positive(j)))
}
