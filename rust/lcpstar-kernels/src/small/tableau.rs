//! The condensed tableau of one small problem, in memory that is used again. [CPS92, sec. 2.3]
//!
//! `basic_i = value_i + sum_j t_ij nonbasic_j`: n rows, and n + 1 columns kept as vectors, in which a pivot exchanges one
//! variable of each kind. Rows that depend on others keep doing so, because all of them see the same row operations; what is
//! computed from an inverse of the basic block shows its errors there as small pivots. Yet a column sees the pivots when it is
//! needed, not before.

use super::covering::Covering;
use super::lane::{BLOCK, Lane, Mask};

/// Numbers per column are padded to a multiple of this.
pub(super) const WIDTH: usize = 8;

/// Late pivots per row of the problem after which every column sees them. A pivot needs one column, which catches up with those since it
/// drove last: with k pivots, `k^2 / 2` steps of O(n) at most, where all columns at every pivot take `(n + 1) k`.
const LATE_PER_ROW: usize = 2;

/// A value that cancels to less than this part of itself is rounding error, and zero.
pub const NOISE: f64 = 1e-14;

/// Variables are numbered: `w_j` is j, `z_j` is `n + j`, `z_0` is `2 n`.
pub struct Tableau<X> {
    n: usize,
    /// Vectors per column.
    width: usize,
    /// Column j at `j width`; at first those of A, then the covering vector.
    t: Vec<X>,
    /// The basic variables, by row.
    value: Vec<X>,
    /// The variable that drives.
    driver: usize,
    /// The driving columns of the late pivots, then that of the driver: how the basic variables change as it grows.
    driving: Vec<X>,
    /// Pivots that some columns have not seen.
    late: Vec<Pivot>,
    /// How many of them column j has seen.
    seen: Vec<usize>,
    /// The variable of each row.
    basic: Vec<usize>,
    /// The row of each basic variable, the column of each other one.
    place: Vec<usize>,
}

/// What a pivot in row r with driving column c does to the others: with `p = -t_r / c_r`, column t becomes `t + p c`, and p in
/// row r.
#[derive(Clone, Copy)]
struct Pivot {
    r: usize,
    /// `-1 / c_r`.
    factor: f64,
}

impl Pivot {
    #[inline(always)]
    fn apply<X: Lane>(self, c: &[X], t: &mut [X]) {
        let (p, b) = (X::splat(at(t, self.r) * self.factor), self.r / WIDTH);
        // A whole vector, because one that was just written to in part is slow to read.
        let own = p.or_else(is_number::<X>(self.r, b), t[b].add_product(c[b], p));
        for (t, c) in t.iter_mut().zip(c) {
            *t = t.add_product(*c, p);
        }
        t[b] = own;
    }

    /// The same for the basic variables; what cancels is rounding error, and zero.
    #[inline(always)]
    fn apply_to_values<X: Lane>(self, c: &[X], value: &mut [X]) {
        let (p, noise) = (X::splat(at(value, self.r) * self.factor), X::splat(NOISE));
        for (b, (v, c)) in value.iter_mut().zip(c).enumerate() {
            let sum = v.add_product(*c, p);
            *v = p.or_else(is_number::<X>(self.r, b), sum.only(v.abs().mul(noise).lt(sum.abs())));
        }
    }

    /// The column of the variable that left, which was a unit vector.
    #[inline(always)]
    fn apply_to_own<X: Lane>(self, c: &[X], t: &mut [X]) {
        let p = X::splat(-self.factor);
        for (b, (t, c)) in t.iter_mut().zip(c).enumerate() {
            *t = p.or_else(is_number::<X>(self.r, b), c.mul(p));
        }
    }
}

impl<X> Default for Tableau<X> {
    fn default() -> Self {
        Self {
            n: 0,
            width: 0,
            t: Vec::new(),
            value: Vec::new(),
            driver: 0,
            driving: Vec::new(),
            late: Vec::new(),
            seen: Vec::new(),
            basic: Vec::new(),
            place: Vec::new(),
        }
    }
}

impl<X: Lane> Tableau<X> {
    /// `w = q + A z + d z_0` for the row-major `a`. `false` if a number of it is not finite: the pivots may never come across it.
    /// O(n^2).
    #[inline(always)]
    pub fn load(&mut self, a: &[f64], q: &[f64], covering: Covering) -> bool {
        let n = q.len();
        self.resize(n);
        let width = self.width;
        for (value, q) in self.value.iter_mut().zip(q.chunks(WIDTH)) {
            *value = X::from_slice(q);
        }
        let last = &mut self.t[n * width..];
        last.fill(X::splat(0.0));
        for i in 0..n {
            put(last, i, covering.entry(i));
            self.basic[i] = i;
            self.place[i] = i;
            self.place[n + i] = i;
        }
        self.place[2 * n] = n;
        self.late.clear();
        self.seen.fill(0);
        self.load_columns(a)
    }

    /// Memory for problems of order n.
    #[inline(always)]
    fn resize(&mut self, n: usize) {
        if n != self.n {
            let (width, zero) = (n.div_ceil(WIDTH), X::splat(0.0));
            self.n = n;
            self.width = width;
            self.t.resize((n + 1) * width, zero);
            self.value.resize(width, zero);
            // What is written before it is read only grows: no time goes into clearing it.
            self.driving.resize(self.driving.len().max(LATE_PER_ROW * n * width), zero);
            self.late.reserve(LATE_PER_ROW * n);
            self.seen.resize(n + 1, 0);
            self.basic.resize(n, 0);
            self.place.resize(2 * n + 1, 0);
        }
    }

    #[inline(always)]
    fn load_columns(&mut self, a: &[f64]) -> bool {
        let (n, width, zero) = (self.n, self.width, X::splat(0.0));
        // Blocks of known length first: for them the compiler knows every instruction.
        let (whole, mut columns) = (n - n % BLOCK, [zero; BLOCK]);
        // Products with zero: not zero where a number is not finite.
        let mut nothing = [zero; BLOCK];
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
                let count = if j < whole {
                    X::load_columns(&rows, j, &mut columns);
                    BLOCK
                } else {
                    X::load_columns(&rows, j, &mut columns[..n - whole]);
                    n - whole
                };
                for (c, column) in columns[..count].iter().enumerate() {
                    self.t[(j + c) * width + block] = column.only(real);
                    nothing[c] = nothing[c].add_product(*column, zero);
                }
            }
        }
        let nothing = nothing.iter().fold(zero, |sum, nothing| sum.add(*nothing));
        !nothing.eq(zero).not().any()
    }

    /// The column of z_0 before the first pivot.
    #[inline(always)]
    pub fn covering(&self) -> &[X] {
        &self.t[self.n * self.width..]
    }

    /// The row i and the index j of each basic `z_j`; z_0 must not be basic.
    #[inline(always)]
    pub fn basic_z(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.n).filter_map(|i| Some((i, self.z_in_row(i)?)))
    }

    /// The j of the `z_j` that is basic in row i, if one is.
    #[inline(always)]
    fn z_in_row(&self, i: usize) -> Option<usize> {
        self.basic[i].checked_sub(self.n)
    }

    /// Column j sees the late pivots. O(n) for each that it has missed.
    #[inline(always)]
    fn catch_up(&mut self, j: usize) {
        let (width, seen) = (self.width, self.seen[j]);
        apply_all::<X, 0>(&self.late[seen..], &self.driving[seen * width..], &mut self.t[j * width..(j + 1) * width]);
        self.seen[j] = self.late.len();
    }

    /// `step_i = sum_j t_ij w_j` and `size_i = sum_j |t_ij q_j|`, over the nonbasic `w_j` whose `z_j` is basic: in the rows of
    /// those, `A_aa^-1 w_a` and `|A_aa^-1| |q_a|`.
    #[inline(always)]
    pub fn times_inverse(&mut self, w: &[f64], q: &[f64], step: &mut [X], size: &mut [X]) {
        step.fill(X::splat(0.0));
        size.fill(X::splat(0.0));
        for i in 0..self.n {
            let Some(j) = self.z_in_row(i) else {
                continue;
            };
            let own = self.place[j];
            self.catch_up(own);
            let (w, q) = (X::splat(w[j]), X::splat(q[j].abs()));
            let column = &self.t[own * self.width..(own + 1) * self.width];
            for ((step, size), t) in step.iter_mut().zip(size.iter_mut()).zip(column) {
                *step = step.add_product(*t, w);
                *size = size.add_product(t.abs(), q);
            }
        }
    }

    /// Vectors per column: `W`, or what is stored where `W` is 0 because the compiler is not told.
    #[inline(always)]
    fn width<const W: usize>(&self) -> usize {
        if W == 0 { self.width } else { W }
    }

    /// The variable that drives from now on, one that is not basic. O(n) for each pivot that its column has missed.
    #[inline(always)]
    pub fn drive<const W: usize>(&mut self, variable: usize) {
        let (width, own) = (self.width::<W>(), self.place[variable]);
        let (driven, free) = self.driving.split_at_mut(self.late.len() * width);
        let (seen, column) = (self.seen[own], &mut free[..width]);
        column.copy_from_slice(&self.t[own * width..(own + 1) * width]);
        apply_all::<X, W>(&self.late[seen..], &driven[seen * width..], column);
        self.driver = variable;
    }

    /// The driving variable becomes basic in row r; the one that leaves. O(n).
    #[inline(always)]
    pub fn exchange<const W: usize>(&mut self, r: usize) -> usize {
        let (width, own, first) = (self.width::<W>(), self.place[self.driver], self.late.len() * self.width::<W>());
        let c = &self.driving[first..first + width];
        let pivot = Pivot { r, factor: -1.0 / at(c, r) };
        pivot.apply_to_values(c, &mut self.value[..width]);
        pivot.apply_to_own(c, &mut self.t[own * width..(own + 1) * width]);
        self.late.push(pivot);
        self.seen[own] = self.late.len();
        if self.late.len() == LATE_PER_ROW * self.n {
            for j in 0..=self.n {
                self.catch_up(j);
            }
            self.late.clear();
            self.seen.fill(0);
        }
        let leaving = self.basic[r];
        self.basic[r] = self.driver;
        self.place[self.driver] = r;
        self.place[leaving] = own;
        leaving
    }

    /// How the basic variables change as the driving one grows, by row.
    #[inline(always)]
    pub fn driving_column<const W: usize>(&self) -> &[X] {
        let (width, late) = (self.width::<W>(), self.late.len());
        &self.driving[late * width..(late + 1) * width]
    }

    /// The basic variables, by row.
    #[inline(always)]
    pub fn values<const W: usize>(&self) -> &[X] {
        &self.value[..self.width::<W>()]
    }

    /// The row of a variable, if it is basic.
    #[inline(always)]
    pub fn row_of(&self, variable: usize) -> Option<usize> {
        let row = self.place[variable];
        (self.basic.get(row) == Some(&variable)).then_some(row)
    }
}

/// A column sees pivots with driving columns `driven`, one after the other.
#[inline(always)]
fn apply_all<X: Lane, const W: usize>(pivots: &[Pivot], driven: &[X], column: &mut [X]) {
    for (pivot, c) in pivots.iter().zip(driven.chunks_exact(if W == 0 { column.len() } else { W })) {
        pivot.apply(c, column);
    }
}

/// Number `i` of a padded vector.
#[inline(always)]
pub(super) fn at<X: Lane>(v: &[X], i: usize) -> f64 {
    v[i / WIDTH].get(i % WIDTH)
}

#[inline(always)]
pub(super) fn put<X: Lane>(v: &mut [X], i: usize, x: f64) {
    v[i / WIDTH].set(i % WIDTH, x);
}

/// Which number of vector `block` is number `i` of a padded vector.
#[inline(always)]
fn is_number<X: Lane>(i: usize, block: usize) -> X::Mask {
    const COUNT: [f64; WIDTH] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    X::from_slice(&COUNT).eq(X::splat(i as f64 - (WIDTH * block) as f64))
}

#[cfg(test)]
mod tests {
    use super::super::lane::F64x8;
    use super::*;
    use std::ops::Range;

    /// Reproducible, between -1/2 and 1/2.
    fn noise(k: usize) -> f64 {
        (k * 7919 % 10_007) as f64 / 10_007.0 - 0.5
    }

    /// The tableau as rows of plain numbers: `w_i = q_i + sum_j a_ij z_j + d_i z_0`, a column for each variable that is not basic.
    struct Plain {
        rows: Vec<Vec<f64>>,
        values: Vec<f64>,
        basic: Vec<usize>,
        nonbasic: Vec<usize>,
        /// The variable that left last.
        left: usize,
    }

    impl Plain {
        fn exchange(&mut self, r: usize, variable: usize) -> usize {
            let s = self.nonbasic.iter().position(|&v| v == variable).expect("not basic");
            let pivot = self.rows[r][s];
            let row: Vec<f64> =
                (0..self.nonbasic.len()).map(|j| if j == s { 1.0 } else { -self.rows[r][j] } / pivot).collect();
            let value = -self.values[r] / pivot;
            for i in (0..self.basic.len()).filter(|&i| i != r) {
                let c = self.rows[i][s];
                for j in 0..self.nonbasic.len() {
                    self.rows[i][j] = if j == s { 0.0 } else { self.rows[i][j] } + c * row[j];
                }
                self.values[i] += c * value;
            }
            (self.rows[r], self.values[r]) = (row, value);
            std::mem::swap(&mut self.basic[r], &mut self.nonbasic[s]);
            self.left = self.nonbasic[s];
            self.left
        }
    }

    /// Pivots on both, compared: the k-th for each k of `range`. Every fifth variable that drives has left just before.
    fn follow<X: Lane, const W: usize>(tableau: &mut Tableau<X>, plain: &mut Plain, range: Range<usize>) {
        let n = plain.basic.len();
        for k in range {
            let variable = if k % 5 == 4 { plain.left } else { plain.nonbasic[(7 * k + 3) % (n + 1)] };
            tableau.drive::<W>(variable);
            let s = plain.nonbasic.iter().position(|&v| v == variable).expect("not basic");
            let size = |i: usize| plain.rows[i][s].abs();
            for i in 0..n {
                let difference = at(tableau.driving_column::<W>(), i) - plain.rows[i][s];
                assert!(difference.abs() <= 1e-9 * (1.0 + size(i)), "n = {n}, pivot {k}, row {i}: {difference}");
            }
            let r = (0..n).max_by(|&i, &j| size(i).total_cmp(&size(j))).expect("a row");
            assert_eq!(tableau.exchange::<W>(r), plain.exchange(r, variable));
            for (i, &variable) in plain.basic.iter().enumerate() {
                assert_eq!(tableau.row_of(variable), Some(i));
            }
            assert!(plain.nonbasic.iter().all(|&variable| tableau.row_of(variable).is_none()));
            for i in 0..n {
                let difference = at(tableau.values::<W>(), i) - plain.values[i];
                assert!(difference.abs() <= 1e-9 * (1.0 + plain.values[i].abs()), "n = {n}, pivot {k}, row {i}");
            }
        }
    }

    /// Any sequence of pivots, so many that every column has to see them, in columns of one register and of several, of which the
    /// compiler is told and of which it is not; zeros among the entries.
    #[test]
    fn pivots_are_those_of_plain_rows() {
        let mut tableau = Tableau::<F64x8<false>>::default();
        for n in [1, 3, 8, 9, 20, 30, 33, 64, 65, 90, 12] {
            let entry =
                |i: usize, j: usize| if (i * 31 + j * 17).is_multiple_of(5) { 0.0 } else { noise(i * n + j + n) };
            let a: Vec<f64> = (0..n * n).map(|e| entry(e / n, e % n) + f64::from(e / n == e % n)).collect();
            let q: Vec<f64> = (0..n).map(|i| noise(5 * i + n)).collect();
            let mut plain = Plain {
                rows: (0..n).map(|i| [&a[i * n..(i + 1) * n], &[Covering::Spread.entry(i)]].concat()).collect(),
                values: q.clone(),
                basic: (0..n).collect(),
                nonbasic: (n..=2 * n).collect(),
                left: 0,
            };
            assert!(tableau.load(&a, &q, Covering::Spread));
            tableau.drive::<0>(2 * n);
            let (half, all) = ((n + 10) / 5 * 5, LATE_PER_ROW * n + 25);
            match tableau.width {
                1 => follow::<_, 1>(&mut tableau, &mut plain, 0..half),
                2 => follow::<_, 2>(&mut tableau, &mut plain, 0..half),
                3 => follow::<_, 3>(&mut tableau, &mut plain, 0..half),
                4 => follow::<_, 4>(&mut tableau, &mut plain, 0..half),
                _ => follow::<_, 0>(&mut tableau, &mut plain, 0..half),
            }
            follow::<_, 0>(&mut tableau, &mut plain, half..all);
        }
    }

    /// `A_aa step_a = w_a` after the pivots that bring in `z_a`. Asked twice: a column sees each pivot once.
    #[test]
    fn the_inverse_of_the_basis_is_in_the_columns_of_what_left() {
        let (n, k) = (12, 9);
        let a: Vec<f64> = (0..n * n).map(|e| noise(e) + if e / n == e % n { 4.0 } else { 0.0 }).collect();
        let w: Vec<f64> = (0..n).map(|i| noise(7 * i + 2)).collect();
        let mut tableau = Tableau::<F64x8<false>>::default();
        assert!(tableau.load(&a, &w, Covering::Ones));
        for j in 0..k {
            tableau.drive::<0>(n + j);
            assert_eq!(tableau.exchange::<0>(j), j);
        }
        for _ in 0..2 {
            let (mut step, mut size) = ([F64x8::splat(0.0); 2], [F64x8::splat(0.0); 2]);
            tableau.times_inverse(&w, &w, &mut step, &mut size);
            for i in 0..k {
                let sum = (0..k).map(|j| a[i * n + j] * at(&step, j)).sum::<f64>();
                assert!((sum - w[i]).abs() <= 1e-14, "row {i}: {sum}, {}", w[i]);
                assert!(at(&size, i) >= (1.0 - 1e-14) * at(&step, i).abs());
            }
        }
    }

    #[test]
    fn numbers_that_are_not_finite_are_seen() {
        let mut tableau = Tableau::<F64x8<false>>::default();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for place in 0..9 {
                let mut a = [1.0; 9];
                assert!(tableau.load(&a, &[0.0; 3], Covering::Ones));
                a[place] = bad;
                assert!(!tableau.load(&a, &[0.0; 3], Covering::Ones));
            }
        }
    }
}
