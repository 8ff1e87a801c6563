//! Lemke's method for one problem in memory that is used again: the survivor of singular, copositive and unsymmetric
//! problems behind the lane kernels. [CPS92, sec. 4.4]
//!
//! In an almost complementary basis every pair `(w_i, z_i)` has one basic variable, but one pair, the missing one, has
//! none: z_0 is basic in its place. So values are kept by pair. Let the rows a be those with w_i nonbasic. Only the
//! part of the tableau that belongs to them is kept, `t`, the inverse of the columns of the basic z's and of z_0 in the
//! rows a; the driving column and the pivot row are computed from it and from A. A pivot costs O(n |a|), not O(n^2).
//!
//! The covering vector is not `e` but spread over [1, 2): the line `q + z_0 d` then meets degenerate bases only by
//! accident, which is what a lexicographic rule is for otherwise. Among tied rows that of z_0 wins, then the largest
//! pivot.

use super::lane::{BLOCK, Lane, Mask};
use super::verify::{Columns, Judged, RowMajor, is_small_when_equilibrated, verify_one};

/// Numbers per row are padded to a multiple of this.
pub(super) const WIDTH: usize = 8;

/// How the method stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    /// z_0 left: the basis is complementary.
    Basis,
    /// No blocking row.
    Ray,
    /// Too many pivots.
    Limit,
}

/// The variable that drives: that of the missing pair which did not leave last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Driving {
    W,
    Z,
}

/// Refinement steps at most.
const REFINEMENTS: usize = 2;

/// Pivots per row of the problem after which the method gives up.
pub(crate) const PIVOTS_PER_ROW: usize = 10;

/// Order beyond which the limit on pivots no longer grows: the portfolio does better than to wait.
const PATIENT_UP_TO: usize = 64;

/// Smallest pivot relative to the largest entry of the driving column.
pub(crate) const PIVOT_TOLERANCE: f64 = 1e-10;

/// Ratios within this factor of the least one are tied.
pub(crate) const TIE: f64 = 1.0 + 1e-11;

/// A value that cancels to less than this part of itself is rounding error, and zero.
pub(crate) const NOISE: f64 = 1e-14;

/// A sum smaller than this part of its terms' magnitudes is rounding error.
pub(crate) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A correction that leaves less than this part of a value shows that the value was rounding error.
pub(crate) const CANCELLED: f64 = 1e-8;

/// The basis and what belongs to it; grows to the largest problem it has seen. Vectors of numbers are padded.
pub struct Basis<X> {
    n: usize,
    /// Vectors per column of A and per row of t.
    width: usize,
    /// Column j of `A` at `j width`.
    columns: Vec<X>,
    covering: Vec<X>,
    /// Row p belongs to the basic variable of pair `pairs[p]`, column k to w of pair `pairs[k]`; zero beyond.
    t: Vec<X>,
    /// Pairs with w nonbasic, in the order of the rows of t.
    pairs: Vec<usize>,
    /// Where a pair stands there.
    place: Vec<Option<usize>>,
    /// The basic variable of each pair.
    value: Vec<X>,
    /// The driving column, by pair.
    column: Vec<X>,
    ratio: Vec<X>,
    /// Numbers in the order of the columns of t.
    row: Vec<X>,
    z: Vec<X>,
    sums: Vec<[X; 2]>,
    /// Whether the last run ended with a complementary basis.
    pub found_basis: bool,
    /// Pivots of the last run.
    pub pivots: usize,
}

/// Number `i` of a padded vector.
#[inline(always)]
pub(super) fn at<X: Lane<Number = f64>>(v: &[X], i: usize) -> f64 {
    v[i / WIDTH].get(i % WIDTH)
}

#[inline(always)]
pub(super) fn put<X: Lane<Number = f64>>(v: &mut [X], i: usize, x: f64) {
    v[i / WIDTH].set(i % WIDTH, x);
}

impl<X> Default for Basis<X> {
    fn default() -> Self {
        Self {
            n: 0,
            width: 0,
            columns: Vec::new(),
            covering: Vec::new(),
            t: Vec::new(),
            pairs: Vec::new(),
            place: Vec::new(),
            value: Vec::new(),
            column: Vec::new(),
            ratio: Vec::new(),
            row: Vec::new(),
            z: Vec::new(),
            sums: Vec::new(),
            found_basis: false,
            pivots: 0,
        }
    }
}

impl<X: Lane<Number = f64>> Basis<X> {
    /// Runs the method and refines the answer until it is verified; `None` if that fails. `w = A z + q` as computed.
    #[inline(always)]
    pub fn solve_and_verify(&mut self, n: usize, a: &[f64], q: &[f64], w: &mut [f64], tol: f64) -> Option<Judged> {
        self.pivots = 0;
        self.found_basis = false;
        if !self.load(n, a) {
            return None;
        }
        let mut stop = Stop::Ray;
        for covering in COVERINGS {
            let limit = self.pivots + PIVOTS_PER_ROW * n.min(PATIENT_UP_TO);
            stop = self.solve(a, q, covering, limit);
            if stop == Stop::Basis {
                break;
            }
        }
        self.found_basis = stop == Stop::Basis;
        if !self.found_basis {
            return None;
        }
        let judged = self.verified(q, w, tol);
        self.settled(judged, n, a, q, w, tol)
    }

    /// Judges a point `z >= 0` that was found elsewhere; `w = A z + q` as computed. O(n^2).
    #[inline(always)]
    pub fn verify_point(
        &mut self,
        n: usize,
        a: &[f64],
        q: &[f64],
        z: &[f64],
        w: &mut [f64],
        tol: f64,
    ) -> Option<Judged> {
        self.resize(n);
        for (x, z) in self.z.iter_mut().zip(z.chunks(WIDTH)) {
            *x = X::from_slice(z);
        }
        let judged = verify_one(&RowMajor { n, a }, q, &self.z, &mut self.sums, w, tol);
        self.settled(judged, n, a, q, w, tol)
    }

    /// The verdict, if it is that the point solves the problem.
    #[inline(always)]
    fn settled(&self, mut judged: Judged, n: usize, a: &[f64], q: &[f64], w: &[f64], tol: f64) -> Option<Judged> {
        if judged.unsettled {
            let z: Vec<f64> = (0..n).map(|j| self.z(j)).collect();
            judged.solved = is_small_when_equilibrated(n, a, q, &z, w, tol);
        }
        judged.solved.then_some(judged)
    }

    /// Memory for problems of order n.
    #[inline(always)]
    fn resize(&mut self, n: usize) {
        let (width, zero) = (n.div_ceil(WIDTH), X::splat(0.0));
        if n != self.n {
            self.n = n;
            self.width = width;
            self.columns.resize(n * width, zero);
            self.t.resize(n * width, zero);
            for v in [&mut self.covering, &mut self.value, &mut self.column, &mut self.row] {
                v.clear();
                v.resize(width, zero);
            }
            for v in [&mut self.ratio, &mut self.z] {
                v.resize(width, zero);
            }
            self.sums.resize(width, [zero; 2]);
            self.pairs.reserve(n);
            self.place.resize(n, None);
        }
    }

    /// The columns of the row-major `a`. `false` if a number is not finite: the pivots may never come across it.
    #[inline(always)]
    fn load(&mut self, n: usize, a: &[f64]) -> bool {
        self.resize(n);
        let (width, zero) = (self.width, X::splat(0.0));
        let mut nothing = zero;
        for block in 0..width {
            let first = block * WIDTH;
            let mut rows: [&[f64]; WIDTH] = [&[]; WIDTH];
            for (l, row) in rows.iter_mut().enumerate() {
                // Lanes beyond the last row repeat it; they are cleared below.
                let i = (first + l).min(n - 1);
                *row = &a[i * n..(i + 1) * n];
            }
            let real = X::Mask::from_bits(u32::MAX >> (32 - WIDTH.min(n - first)));
            for j in (0..n).step_by(BLOCK) {
                let mut columns = [zero; BLOCK];
                let count = BLOCK.min(n - j);
                X::load_columns(&rows.map(|row| &row[j..]), &mut columns[..count]);
                for (c, column) in columns[..count].iter().enumerate() {
                    self.columns[(j + c) * width + block] = column.only(real);
                    nothing = nothing.add_product(*column, zero);
                }
            }
        }
        !nothing.eq(zero).not().any()
    }

    /// Runs the method until `limit` pivots were counted. O(n |a|) a pivot.
    #[inline(always)]
    fn solve(&mut self, a: &[f64], q: &[f64], covering: fn(usize) -> f64, limit: usize) -> Stop {
        let Some(mut missing) = self.start(q, covering) else {
            return Stop::Basis;
        };
        let mut driving = Driving::Z;
        loop {
            self.drive(missing, driving);
            let Some(blocking) = first_to_reach_zero(&self.column, &self.value, &mut self.ratio, missing) else {
                return Stop::Ray;
            };
            let complement = if self.is_basic(blocking) { Driving::W } else { Driving::Z };
            self.exchange(a, blocking, missing, driving);
            self.pivots += 1;
            if blocking == missing {
                return Stop::Basis;
            }
            if self.pivots >= limit {
                return Stop::Limit;
            }
            (missing, driving) = (blocking, complement);
        }
    }

    /// `w = q + A z + d z_0`; z_0 takes the place of the w that becomes nonnegative last. `None` if `q >= 0`.
    #[inline(always)]
    fn start(&mut self, q: &[f64], covering: fn(usize) -> f64) -> Option<usize> {
        self.pairs.clear();
        self.place.fill(None);
        let (mut missing, mut largest) = (None, 0.0);
        for (i, &q) in q.iter().enumerate() {
            let d = covering(i);
            put(&mut self.covering, i, d);
            put(&mut self.value, i, q);
            if -q / d > largest {
                (missing, largest) = (Some(i), -q / d);
            }
        }
        let missing = missing?;
        grow(&mut self.value, &self.covering, largest);
        put(&mut self.value, missing, largest);
        let row = &mut self.t[..self.width];
        row.fill(X::splat(0.0));
        put(row, 0, 1.0 / at(&self.covering, missing));
        self.pairs.push(missing);
        self.place[missing] = Some(0);
        self.pivots += 1;
        Some(missing)
    }

    /// The column of the driving variable: how the basic ones change as it grows.
    #[inline(always)]
    fn drive(&mut self, missing: usize, driving: Driving) {
        let (width, m) = (self.width, self.pairs.len());
        let used = m.div_ceil(WIDTH);
        let own = &self.columns[missing * width..(missing + 1) * width];
        let Some(artificial) = self.place[missing] else { return };
        match driving {
            Driving::Z => {
                self.row.fill(X::splat(0.0));
                for (k, &pair) in self.pairs.iter().enumerate() {
                    put(&mut self.row, k, at(own, pair));
                }
                self.column.copy_from_slice(own);
            }
            Driving::W => self.column.fill(X::splat(0.0)),
        }
        // By place at first, in ratio: the change of the basic z's and of z_0.
        for p in 0..m {
            let row = &self.t[p * width..p * width + used];
            let change = match driving {
                Driving::Z => {
                    let mut sum = X::splat(0.0);
                    for (t, x) in row.iter().zip(&self.row) {
                        sum = sum.add_product(*t, *x);
                    }
                    -sum.sum()
                }
                Driving::W => at(row, artificial),
            };
            put(&mut self.ratio, p, change);
            if change != 0.0 {
                let pair = self.pairs[p];
                let source =
                    if p == artificial { &self.covering[..] } else { &self.columns[pair * width..(pair + 1) * width] };
                let factor = X::splat(change);
                for (c, a) in self.column.iter_mut().zip(source) {
                    *c = c.add_product(factor, *a);
                }
            }
        }
        for (p, &pair) in self.pairs.iter().enumerate() {
            put(&mut self.column, pair, at(&self.ratio, p));
        }
    }

    /// The driving variable becomes basic and that of the pair `blocking` leaves.
    #[inline(always)]
    fn exchange(&mut self, a: &[f64], blocking: usize, missing: usize, driving: Driving) {
        let (n, width, m) = (self.n, self.width, self.pairs.len());
        let Some(artificial) = self.place[missing] else { return };
        let reciprocal = 1.0 / at(&self.column, blocking);
        self.row.fill(X::splat(0.0));
        match self.place[blocking] {
            Some(p) => self.row.copy_from_slice(&self.t[p * width..(p + 1) * width]),
            None => {
                let used = m.div_ceil(WIDTH);
                for (p, &pair) in self.pairs.iter().enumerate() {
                    let entry = if p == artificial { at(&self.covering, blocking) } else { a[blocking * n + pair] };
                    let factor = X::splat(entry);
                    for (r, t) in self.row.iter_mut().zip(&self.t[p * width..p * width + used]) {
                        *r = r.add_product(factor, *t);
                    }
                }
            }
        }
        let minus = X::splat(-reciprocal);
        for r in &mut self.row {
            *r = r.mul(minus);
        }
        // Where the column of the variable that leaves, or nothing, is to stand.
        let column = match (driving, self.place[blocking]) {
            (Driving::W, _) => Some(artificial),
            (Driving::Z, None) => Some(m),
            (Driving::Z, Some(_)) => None,
        };
        let used = (m + 1).div_ceil(WIDTH).min(width);
        for (p, &pair) in self.pairs.iter().enumerate() {
            let change = at(&self.column, pair);
            let row = &mut self.t[p * width..p * width + used];
            if change != 0.0 {
                let factor = X::splat(change);
                for (t, r) in row.iter_mut().zip(&self.row) {
                    *t = t.add_product(factor, *r);
                }
            }
            if let Some(k) = column {
                put(row, k, change * reciprocal);
            }
        }
        let value = -at(&self.value, blocking) * reciprocal;
        grow(&mut self.value, &self.column, value);
        let artificial_value = at(&self.value, missing);
        put(&mut self.value, blocking, artificial_value);
        put(&mut self.value, missing, value);
        self.move_places(blocking, missing, driving, reciprocal);
    }

    /// z_0 takes the place of the pair `blocking`, in the rows and columns of t too.
    #[inline(always)]
    fn move_places(&mut self, blocking: usize, missing: usize, driving: Driving, reciprocal: f64) {
        let (width, m) = (self.width, self.pairs.len());
        let Some(artificial) = self.place[missing] else { return };
        let row = |p: usize| p * width..(p + 1) * width;
        match (driving, self.place[blocking]) {
            (Driving::Z, Some(p)) => {
                self.t.copy_within(row(artificial), p * width);
                self.t[row(artificial)].copy_from_slice(&self.row);
            }
            (Driving::Z, None) => {
                self.t.copy_within(row(artificial), m * width);
                put(&mut self.row, m, reciprocal);
                self.t[row(artificial)].copy_from_slice(&self.row);
                self.pairs.push(blocking);
                self.place[blocking] = Some(m);
            }
            (Driving::W, None) => {
                self.pairs[artificial] = blocking;
                self.place[blocking] = Some(artificial);
                self.place[missing] = None;
            }
            (Driving::W, Some(p)) => {
                self.t.copy_within(row(artificial), p * width);
                self.remove(artificial);
                self.place[missing] = None;
            }
        }
    }

    /// Row and column `p` of t go; the last ones take their places.
    #[inline(always)]
    fn remove(&mut self, p: usize) {
        let (width, last) = (self.width, self.pairs.len() - 1);
        self.t.copy_within(last * width..(last + 1) * width, p * width);
        for row in self.t.chunks_exact_mut(width).take(last) {
            let x = at(row, last);
            put(row, p, x);
            put(row, last, 0.0);
        }
        if p != last {
            self.place[self.pairs[last]] = Some(p);
        }
        self.pairs.swap_remove(p);
    }

    /// Puts the basic z's in place, negative rounding set to zero, and judges them; `w = A z + q` as computed.
    #[inline(always)]
    fn verified(&mut self, q: &[f64], w: &mut [f64], tol: f64) -> Judged {
        self.z.fill(X::splat(0.0));
        for &j in &self.pairs {
            put(&mut self.z, j, at(&self.value, j).max(0.0));
        }
        let mut judged = self.judge(q, w, tol);
        for _ in 0..REFINEMENTS {
            if judged.solved || judged.unsettled {
                break;
            }
            self.refine(q, w);
            judged = self.judge(q, w, tol);
        }
        judged
    }

    #[inline(always)]
    fn judge(&mut self, q: &[f64], w: &mut [f64], tol: f64) -> Judged {
        let columns =
            Columns { width: self.width, columns: &self.columns[..self.n * self.width], support: &self.pairs };
        verify_one(&columns, q, &self.z, &mut self.sums, w, tol)
    }

    /// z_j.
    #[inline(always)]
    pub fn z(&self, j: usize) -> f64 {
        at(&self.z, j)
    }

    /// Whether z_j is basic, or z_0 in its place.
    #[inline(always)]
    pub fn is_basic(&self, j: usize) -> bool {
        self.place[j].is_some()
    }

    /// `z_a -= A_aa^-1 w_a`; what is rounding error beside the terms of `A_aa^-1 q_a` becomes zero.
    #[inline(always)]
    fn refine(&mut self, q: &[f64], w: &[f64]) {
        let zero = X::splat(0.0);
        let used = self.pairs.len().div_ceil(WIDTH);
        self.row.fill(zero);
        self.ratio.fill(zero);
        for (k, &pair) in self.pairs.iter().enumerate() {
            put(&mut self.row, k, w[pair]);
            put(&mut self.ratio, k, q[pair].abs());
        }
        for (p, &j) in self.pairs.iter().enumerate() {
            let (mut step, mut size) = (zero, zero);
            let row = &self.t[p * self.width..p * self.width + used];
            for (t, (w, q)) in row.iter().zip(self.row.iter().zip(&self.ratio)) {
                step = step.add_product(*t, *w);
                size = size.add_product(t.abs(), *q);
            }
            let (old, new) = (at(&self.z, j), at(&self.z, j) - step.sum());
            let least = (CANCELLED * old).max(ROUNDING * size.sum());
            put(&mut self.z, j, if new > least { new } else { 0.0 });
        }
    }
}

/// The place of the first number of `value` to reach zero as the driving variable grows, which changes them by `column`:
/// `favoured`, where z_0 is, if that is among them, else that of the largest pivot.
#[inline(always)]
pub(super) fn first_to_reach_zero<X: Lane<Number = f64>>(
    column: &[X],
    value: &[X],
    ratio: &mut [X],
    favoured: usize,
) -> Option<usize> {
    let (zero, infinity) = (X::splat(0.0), X::splat(f64::INFINITY));
    let largest = column.iter().fold(zero, |m, c| m.max(c.abs())).largest();
    let tolerance = X::splat(-PIVOT_TOLERANCE * largest);
    let mut least = infinity;
    for ((ratio, r), c) in ratio.iter_mut().zip(value).zip(column) {
        *ratio = r.max(zero).div(c.neg()).or_else(c.lt(tolerance), infinity);
        least = ratio.min(least);
    }
    let least = least.smallest();
    if least == f64::INFINITY {
        return None;
    }
    let bound = X::splat(least * TIE);
    let (mut place, mut pivot) = (None, 0.0);
    for (block, ratio) in ratio.iter().enumerate() {
        let mut tied = ratio.le(bound).bits();
        while tied != 0 {
            let i = block * WIDTH + tied.trailing_zeros() as usize;
            tied &= tied - 1;
            if i == favoured {
                return Some(i);
            }
            let x = at(column, i).abs();
            if x > pivot {
                (place, pivot) = (Some(i), x);
            }
        }
    }
    place
}

/// `v += factor direction`; what cancels is rounding error, and zero.
#[inline(always)]
pub(super) fn grow<X: Lane<Number = f64>>(v: &mut [X], direction: &[X], factor: f64) {
    let (factor, noise) = (X::splat(factor), X::splat(NOISE));
    for (r, c) in v.iter_mut().zip(direction) {
        let sum = r.add_product(*c, factor);
        *r = sum.only(r.abs().mul(noise).lt(sum.abs()));
    }
}

/// Covering vectors, entry by entry, the next one after a ray or too many pivots.
const COVERINGS: [fn(usize) -> f64; 2] = [spread, |_| 1.0];

/// Entry i of the covering vector: 1 plus the fractional part of `(i + 1)` times the golden ratio.
#[inline(always)]
pub(crate) fn spread(i: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    1.0 + ((i + 1) as f64 * GOLDEN).fract()
}
