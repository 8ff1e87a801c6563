//! Lemke's method for one small problem in memory that is used again: the survivor of singular, copositive and
//! unsymmetric problems behind the lane kernel. [CPS92, sec. 4.4]
//!
//! A condensed tableau: row r reads `basic_r = rhs_r + sum_j t_rj nonbasic_j + column_r driving`. Slot j of the
//! columns holds the nonbasic member of the pair `(w_j, z_j)`; the driving variable has a column of its own, so that
//! the ratio test and the update run over contiguous memory and a pivot moves one column.
//!
//! The covering vector is not `e` but spread over [1, 2): the line `q + z_0 d` then meets degenerate bases only by
//! accident, which is what a lexicographic rule is for otherwise. Among tied rows the one holding z_0 wins, then the
//! largest pivot.

/// Numbers per row are padded to a multiple of this.
const WIDTH: usize = 8;

/// `WIDTH` numbers, aligned as the widest registers want them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Block([f64; WIDTH]);

const ZERO: Block = Block([0.0; WIDTH]);

/// Who sits in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Basic {
    W(usize),
    Z(usize),
    Z0,
}

/// How the method stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// z_0 left: the basis is complementary.
    Basis,
    /// No blocking row.
    Ray,
    /// Too many pivots.
    Limit,
}

/// Smallest pivot relative to the largest entry of the driving column.
const PIVOT_TOLERANCE: f64 = 1e-10;

/// Ratios within this factor of the least one are tied.
const TIE: f64 = 1.0 + 1e-11;

/// The tableau and what belongs to it; grows to the largest problem it has seen.
#[derive(Debug, Default)]
pub struct Tableau {
    n: usize,
    /// Blocks per row.
    width: usize,
    t: Vec<Block>,
    column: Vec<Block>,
    rhs: Vec<Block>,
    /// The new pivot row.
    row: Vec<Block>,
    ratio: Vec<Block>,
    basic: Vec<Basic>,
    /// Whether slot j holds z_j rather than w_j.
    holds_z: Vec<bool>,
    /// Pivots of the last run.
    pub pivots: usize,
}

/// Number `i` of a vector of blocks.
#[inline(always)]
fn at(v: &[Block], i: usize) -> f64 {
    v[i / WIDTH].0[i % WIDTH]
}

#[inline(always)]
fn at_mut(v: &mut [Block], i: usize) -> &mut f64 {
    &mut v[i / WIDTH].0[i % WIDTH]
}

impl Tableau {
    /// Runs the method on the row-major `a` and `q`, at most `limit` pivots. O(n^2) a pivot.
    #[inline(always)]
    pub fn solve(&mut self, n: usize, a: &[f64], q: &[f64], limit: usize) -> Stop {
        self.load(n, a, q);
        let Some(mut row) = self.first_row() else {
            return Stop::Basis;
        };
        let mut driving = Basic::Z0;
        loop {
            let left = std::mem::replace(&mut self.basic[row], driving);
            self.exchange(row);
            self.pivots += 1;
            driving = match left {
                Basic::Z0 => return Stop::Basis,
                Basic::W(i) => self.drive(i, true),
                Basic::Z(i) => self.drive(i, false),
            };
            if self.pivots >= limit {
                return Stop::Limit;
            }
            match self.blocking_row() {
                Some(blocking) => row = blocking,
                None => return Stop::Ray,
            }
        }
    }

    /// `w = q + A z + d z_0`, with z_0's column ready to drive.
    #[inline(always)]
    fn load(&mut self, n: usize, a: &[f64], q: &[f64]) {
        let width = n.div_ceil(WIDTH);
        if n != self.n {
            self.n = n;
            self.width = width;
            self.t.resize(n * width, ZERO);
            for v in [&mut self.column, &mut self.rhs, &mut self.row, &mut self.ratio] {
                v.resize(width, ZERO);
            }
            self.basic.resize(n, Basic::Z0);
            self.holds_z.resize(n, true);
            for v in [&mut self.t, &mut self.column, &mut self.rhs] {
                v.fill(ZERO);
            }
        }
        self.pivots = 0;
        for i in 0..n {
            let source = &a[i * n..(i + 1) * n];
            let target = &mut self.t[i * width..(i + 1) * width];
            let (whole, rest) = source.as_chunks::<WIDTH>();
            for (t, s) in target.iter_mut().zip(whole) {
                t.0 = *s;
            }
            if !rest.is_empty() {
                let mut last = ZERO;
                last.0[..rest.len()].copy_from_slice(rest);
                target[width - 1] = last;
            }
            *at_mut(&mut self.rhs, i) = q[i];
            *at_mut(&mut self.column, i) = spread(i);
            self.basic[i] = Basic::W(i);
            self.holds_z[i] = true;
        }
    }

    /// The row that z_0 enters: the last to become nonnegative. `None` if `q >= 0`.
    #[inline(always)]
    fn first_row(&self) -> Option<usize> {
        let (mut row, mut largest) = (None, 0.0);
        for i in 0..self.n {
            let needed = -at(&self.rhs, i) / at(&self.column, i);
            if needed > largest {
                (row, largest) = (Some(i), needed);
            }
        }
        row
    }

    /// The driving variable and the basic one of `row` change places; the latter's column is left in `column`.
    #[inline(always)]
    fn exchange(&mut self, row: usize) {
        let (n, width) = (self.n, self.width);
        let reciprocal = 1.0 / at(&self.column, row);
        let pivot = &mut self.t[row * width..(row + 1) * width];
        for (p, t) in self.row.iter_mut().zip(pivot) {
            for l in 0..WIDTH {
                p.0[l] = -t.0[l] * reciprocal;
                t.0[l] = 0.0;
            }
        }
        let value = -at(&self.rhs, row) * reciprocal;
        // Adding 1 times the new row to the zeroed old one writes it without a branch.
        *at_mut(&mut self.rhs, row) = 0.0;
        *at_mut(&mut self.column, row) = 1.0;
        let new = &self.row[..width];
        for i in 0..n {
            let f = at(&self.column, i);
            let target = &mut self.t[i * width..(i + 1) * width];
            for (t, p) in target.iter_mut().zip(new) {
                for l in 0..WIDTH {
                    t.0[l] += f * p.0[l];
                }
            }
        }
        for (r, c) in self.rhs.iter_mut().zip(&mut self.column) {
            for l in 0..WIDTH {
                r.0[l] += c.0[l] * value;
                c.0[l] *= reciprocal;
            }
        }
    }

    /// The partner of the variable that has just left drives next: their columns change places.
    #[inline(always)]
    fn drive(&mut self, pair: usize, w_left: bool) -> Basic {
        let (block, lane) = (pair / WIDTH, pair % WIDTH);
        for i in 0..self.n {
            std::mem::swap(&mut self.t[i * self.width + block].0[lane], at_mut(&mut self.column, i));
        }
        self.holds_z[pair] = !w_left;
        if w_left { Basic::Z(pair) } else { Basic::W(pair) }
    }

    /// The first row to reach zero as the driving variable grows.
    #[inline(always)]
    fn blocking_row(&mut self) -> Option<usize> {
        let mut largest = [0.0; WIDTH];
        for c in &self.column {
            for l in 0..WIDTH {
                let x = c.0[l].abs();
                largest[l] = if x > largest[l] { x } else { largest[l] };
            }
        }
        let tolerance = -PIVOT_TOLERANCE * largest.iter().fold(0.0, |m: f64, &x| m.max(x));
        let mut least = [f64::INFINITY; WIDTH];
        for ((ratio, r), c) in self.ratio.iter_mut().zip(&self.rhs).zip(&self.column) {
            for l in 0..WIDTH {
                let value = if r.0[l] > 0.0 { r.0[l] } else { 0.0 };
                let x = if c.0[l] < tolerance { value / -c.0[l] } else { f64::INFINITY };
                ratio.0[l] = x;
                least[l] = if x < least[l] { x } else { least[l] };
            }
        }
        let least = least.iter().fold(f64::INFINITY, |m: f64, &x| m.min(x));
        if least == f64::INFINITY {
            return None;
        }
        let bound = least * TIE;
        let (mut row, mut pivot) = (None, 0.0);
        for i in 0..self.n {
            if at(&self.ratio, i) <= bound {
                if self.basic[i] == Basic::Z0 {
                    return Some(i);
                }
                let x = at(&self.column, i).abs();
                if x > pivot {
                    (row, pivot) = (Some(i), x);
                }
            }
        }
        row
    }

    /// Writes the basic z's, negative rounding set to zero.
    #[inline(always)]
    pub fn solution(&self, z: &mut [f64]) {
        z.fill(0.0);
        for i in 0..self.n {
            if let Basic::Z(j) = self.basic[i] {
                let x = at(&self.rhs, i);
                z[j] = if x > 0.0 { x } else { 0.0 };
            }
        }
    }

    /// Whether z_j is basic.
    #[inline(always)]
    pub fn is_basic(&self, j: usize) -> bool {
        !self.holds_z[j]
    }

    /// `z_a -= A_aa^-1 w_a`, the inverse read off the final tableau.
    #[inline(always)]
    pub fn refine(&self, z: &mut [f64], w: &[f64]) {
        for i in 0..self.n {
            if let Basic::Z(j) = self.basic[i] {
                let row = &self.t[i * self.width..(i + 1) * self.width];
                let mut step = 0.0;
                for (k, w) in w.iter().enumerate() {
                    if self.is_basic(k) {
                        step += at(row, k) * w;
                    }
                }
                let x = z[j] - step;
                z[j] = if x > 0.0 { x } else { 0.0 };
            }
        }
    }
}

/// Entry i of the covering vector: 1 plus the fractional part of `(i + 1)` times the golden ratio.
#[inline(always)]
fn spread(i: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    1.0 + ((i + 1) as f64 * GOLDEN).fract()
}
