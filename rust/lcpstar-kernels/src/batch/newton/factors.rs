//! The blocks of several problems, factored side by side.

use crate::small::lane::{Lane, Mask};
use crate::small::prefetch::Prefetch;

/// Smallest pivot, relative to the diagonal entry it started from.
pub const FLOOR: f64 = 1e-9;

/// A negative w_i smaller than this many spacings of `max|q|` is left alone: rounding, in a degenerate row.
pub(super) const NOISE: f64 = 64.0;

/// Crout's `A_aa = L U` and what it makes of the right-hand side. Rows of L and columns of U lie contiguous: each new number is the
/// product of one of each.
pub(super) struct Factors<X: Lane> {
    /// L, row by row.
    lower: Vec<X>,
    /// U with unit diagonal, column by column.
    upper: Vec<X>,
    /// `1 / L_jj`.
    pub inverse: Vec<X>,
    /// `-L^-1 q_a`.
    y: Vec<X>,
}

impl<X: Lane> Factors<X> {
    /// Memory for blocks up to order `n`.
    pub fn new(n: usize) -> Self {
        let zero = X::splat(0.0);
        Self { lower: vec![zero; n * n], upper: vec![zero; n * n], inverse: vec![zero; n], y: vec![zero; n] }
    }

    /// Factors the block `A_aa` among the identity on the other rows and columns. Returns the lanes in which no pivot was raised.
    #[inline(always)]
    pub fn compute<const N: usize>(
        &mut self,
        n: usize,
        a: &[X],
        q: &[X],
        alpha: &[X::Mask],
        symmetric: bool,
        prefetch: &mut Prefetch,
    ) -> X::Mask {
        let n = if N == 0 { n } else { N };
        let (a, q, alpha) = (&a[..n * n], &q[..n], &alpha[..n]);
        let (lower, upper) = (&mut self.lower[..n * n], &mut self.upper[..n * n]);
        let (inverse, y) = (&mut self.inverse[..n], &mut self.y[..n]);
        let (one, floor) = (X::splat(1.0), X::splat(FLOOR));
        let mut regular = X::Mask::ALL;
        for j in 0..n {
            prefetch.step();
            let inside = alpha[j];
            // Column j of L, from the diagonal down.
            let row = &upper[j * n..j * n + j];
            Column { n, j, a: &a[j..], stride: n, inside, alpha, row, scale: one }.write(j, lower);
            let least = a[j * n + j].abs().mul(floor);
            let pivot = lower[j * n + j];
            regular = regular.and(least.le(pivot).or(inside.not()));
            let pivot = pivot.max(least).or_else(inside, one);
            let reciprocal = one.div(pivot);
            lower[j * n + j] = pivot;
            inverse[j] = reciprocal;
            // Row j of U, right of the diagonal.
            if symmetric {
                for i in j + 1..n {
                    upper[i * n + j] = lower[i * n + j].mul(reciprocal);
                }
            } else {
                let row = &lower[j * n..j * n + j];
                Column { n, j, a: &a[j * n..], stride: 1, inside, alpha, row, scale: reciprocal }.write(j + 1, upper);
            }
            let mut sum = q[j].neg().only(inside);
            for (l, y) in lower[j * n..j * n + j].iter().zip(&y[..j]) {
                sum = sum.sub_product(*l, *y);
            }
            y[j] = sum.mul(reciprocal);
        }
        regular
    }

    /// `z = U^-1 y`.
    #[inline(always)]
    pub fn substitute_back<const N: usize>(&self, n: usize, z: &mut [X]) {
        let n = if N == 0 { n } else { N };
        z[..n].copy_from_slice(&self.y[..n]);
        self.solve_upper::<N>(n, z);
    }

    /// `x = U^-1 x`.
    #[inline(always)]
    pub fn solve_upper<const N: usize>(&self, n: usize, x: &mut [X]) {
        let n = if N == 0 { n } else { N };
        for i in (1..n).rev() {
            let (before, x) = x[..=i].split_at_mut(i);
            for (z, u) in before.iter_mut().zip(&self.upper[i * n..i * n + i]) {
                *z = z.sub_product(*u, x[0]);
            }
        }
    }

    /// `x = L^-1 x`.
    #[inline(always)]
    pub fn solve_lower<const N: usize>(&self, n: usize, x: &mut [X]) {
        let n = if N == 0 { n } else { N };
        for i in 0..n {
            let (before, x) = x[..=i].split_at_mut(i);
            let mut sum = x[0];
            for (l, y) in self.lower[i * n..i * n + i].iter().zip(&*before) {
                sum = sum.sub_product(*l, *y);
            }
            x[0] = sum.mul(self.inverse[i]);
        }
    }

    /// Sets to zero what is not larger than the rounding errors of the two substitutions it came from: degenerate rows of a
    /// guessed support, in which anything else is a wrong w. O(n^2).
    #[inline(always)]
    pub fn clean<const N: usize>(&self, n: usize, q: &[X], alpha: &[X::Mask], z: &mut [X]) {
        let n = if N == 0 { n } else { N };
        let (lower, upper, inverse, y) = (&self.lower[..n * n], &self.upper[..n * n], &self.inverse[..n], &self.y[..n]);
        let z = &mut z[..n];
        let rounding = X::splat(NOISE * f64::EPSILON);
        for i in 0..n {
            let mut size = q[i].abs().only(alpha[i]);
            for k in 0..i {
                size = size.add_product(lower[i * n + k].abs(), y[k].abs());
            }
            size = size.mul(inverse[i].abs());
            for k in i + 1..n {
                size = size.add_product(upper[k * n + i].abs(), z[k].abs());
            }
            z[i] = z[i].only(size.mul(rounding).lt(z[i].abs()));
        }
    }
}

/// `(a_r - rows_r row) scale`, which goes to column j of `rows`, row after row.
struct Column<'a, X: Lane> {
    n: usize,
    j: usize,
    /// Holds `a_r` at `r stride`.
    a: &'a [X],
    stride: usize,
    /// Whether j is in the support, and which rows are.
    inside: X::Mask,
    alpha: &'a [X::Mask],
    row: &'a [X],
    scale: X,
}

impl<X: Lane> Column<'_, X> {
    /// For all r from `first` on, four at a time.
    #[inline(always)]
    fn write(&self, first: usize, rows: &mut [X]) {
        let mut i = first;
        while i + 4 <= self.n {
            self.entries::<4>(i, rows);
            i += 4;
        }
        match self.n - i {
            3 => self.entries::<3>(i, rows),
            2 => self.entries::<2>(i, rows),
            1 => self.entries::<1>(i, rows),
            _ => {}
        }
    }

    /// For R rows from i on.
    #[inline(always)]
    fn entries<const R: usize>(&self, i: usize, rows: &mut [X]) {
        let (n, j, row) = (self.n, self.j, self.row);
        let mut sum = [X::splat(0.0); R];
        let mut others = [row; R];
        for r in 0..R {
            sum[r] = self.a[(i + r) * self.stride].only(self.inside.and(self.alpha[i + r]));
            others[r] = &rows[(i + r) * n..(i + r) * n + j];
        }
        for (k, x) in row.iter().enumerate() {
            for r in 0..R {
                sum[r] = sum[r].sub_product(others[r][k], *x);
            }
        }
        for r in 0..R {
            rows[(i + r) * n + j] = sum[r].mul(self.scale);
        }
    }
}
