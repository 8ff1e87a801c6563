//! Bytes become problems and options. Few bytes make a structured problem, so that the fuzzer reaches all sizes, classes
//! and scales by small steps; a spent input reads as zeros.

pub use lcpstar_referee::Problem;
use std::sync::LazyLock;

/// A cursor over the fuzzer's bytes.
pub struct Bytes<'a> {
    data: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub fn new(data: &'a [u8]) -> Self {
        Self { data }
    }

    pub fn byte(&mut self) -> u8 {
        match self.data.split_first() {
            Some((&first, rest)) => {
                self.data = rest;
                first
            }
            None => 0,
        }
    }

    /// In `0..m`.
    pub fn below(&mut self, m: usize) -> usize {
        usize::from(self.byte()) % m
    }

    pub fn flag(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    /// Any double, NaN and infinities included.
    pub fn raw(&mut self) -> f64 {
        let mut bytes = [0; 8];
        bytes.iter_mut().for_each(|b| *b = self.byte());
        f64::from_bits(u64::from_le_bytes(bytes))
    }

    /// A number of the given taste; mostly small integers, because ties are what breaks pivoting.
    pub fn number(&mut self, taste: Taste) -> f64 {
        let b = self.byte();
        let small = f64::from(b as i8 >> 4) / if b & 8 == 0 { 1.0 } else { 4.0 };
        match (taste, b) {
            (Taste::Integers, _) => f64::from(b as i8 % 5),
            (_, 0) => 0.0,
            (Taste::Decimals, _) => f64::from(b as i8) * 0.1,
            (Taste::Wild, 0xf0..=0xff) => {
                let x = self.raw();
                if x.is_finite() { x } else { f64::from(b) }
            }
            (Taste::Wild, 0xe0..=0xef) => 2f64.powi(i32::from(self.byte() as i8) * 8),
            (Taste::Wild, 0xd0..=0xdf) => -(2f64.powi(i32::from(self.byte() as i8) * 8)),
            (Taste::Wild, 0xc8..=0xcf) => 1.0 + f64::from(b & 7) * f64::EPSILON,
            (Taste::Wild, 0xc0..=0xc7) => -1.0 - f64::from(b & 7) * f64::EPSILON,
            (Taste::Wild, _) => small,
        }
    }
}

/// Where numbers come from.
#[derive(Clone, Copy)]
pub enum Taste {
    Integers,
    Decimals,
    Wild,
}

/// A base of order at most `most.min(8)`, bent into a class, copied along the diagonal up to order `most`, scaled.
pub fn problem(bytes: &mut Bytes<'_>, most: usize) -> Problem {
    let taste = [Taste::Integers, Taste::Decimals, Taste::Wild][bytes.below(3)];
    let n = bytes.below(most.min(8) + 1);
    let shape = bytes.below(10);
    let mut base = Problem { n, a: vec![0.0; n * n], q: vec![0.0; n] };
    base.a.iter_mut().for_each(|x| *x = bytes.number(taste));
    base.q.iter_mut().for_each(|x| *x = bytes.number(taste));
    bend(&mut base, shape);
    let copies = 1 + bytes.below((most / n.max(1)).clamp(1, 8));
    let mut problem = copied(base, copies, bytes);
    if bytes.below(4) == 3 {
        scale(&mut problem, bytes);
    }
    for x in problem.a.iter_mut().chain(&mut problem.q) {
        *x = tamed(*x);
    }
    problem
}

/// Into a class: PSD, skew, Z, dominant, bimatrix, symmetric, triangular, rank one, nearly singular.
fn bend(problem: &mut Problem, shape: usize) {
    let (n, b) = (problem.n, problem.a.clone());
    let at = |i: usize, j: usize| b[i * n + j];
    let half = n / 2;
    for i in 0..n {
        for j in 0..n {
            problem.a[i * n + j] = match shape {
                1 => (0..n).map(|k| at(k, i) * at(k, j)).sum(),
                2 => at(i, j) - at(j, i),
                3 if i != j => -at(i, j).abs(),
                4 if i == j => (0..n).map(|k| at(i, k).abs() + at(k, i).abs()).sum::<f64>() + 1.0,
                5 if (i < half) == (j < half) => 0.0,
                5 => at(i, j).abs(),
                6 => at(i.min(j), i.max(j)),
                7 if j > i => 0.0,
                8 => at(i, 0) * at(0, j),
                9 if i == n - 1 => (0..n - 1).map(|k| at(k, j)).sum(),
                _ => continue,
            };
        }
    }
    if shape == 5 {
        problem.q.iter_mut().for_each(|q| *q = -q.abs());
    }
}

/// Block diagonal copies with a link from each to the next; q changes from copy to copy.
fn copied(one: Problem, copies: usize, bytes: &mut Bytes<'_>) -> Problem {
    if copies == 1 || one.n == 0 {
        return one;
    }
    let (m, n) = (one.n, one.n * copies);
    let mut big = Problem { n, a: vec![0.0; n * n], q: vec![0.0; n] };
    let (links, fill, change) = (bytes.number(Taste::Wild), bytes.number(Taste::Wild) * 0.01, bytes.byte());
    for i in 0..n {
        for j in 0..n {
            big.a[i * n + j] = match (j / m) as isize - (i / m) as isize {
                0 => one.a[i % m * m + j % m],
                1 => links,
                _ if (i * 7 + j * 3) % 5 == 0 => fill,
                _ => 0.0,
            };
        }
        let sign = if change >> (i / m) & 1 == 1 { -1.0 } else { 1.0 };
        big.q[i] = one.q[i % m] * sign + f64::from(change >> 4) * (i / m) as f64;
    }
    big
}

/// Rows, columns and q times powers of two.
fn scale(problem: &mut Problem, bytes: &mut Bytes<'_>) {
    let n = problem.n;
    let strength = [1, 4, 30][bytes.below(3)];
    let mut powers = || 2f64.powi(i32::from(bytes.byte() as i8 >> 3) * strength);
    let (r, c): (Vec<f64>, Vec<f64>) = (0..n).map(|_| (powers(), powers())).unzip();
    let s = powers();
    for i in 0..n {
        for j in 0..n {
            problem.a[i * n + j] *= r[i] * c[j];
        }
        problem.q[i] *= r[i] * s;
    }
}

/// Finite; and, unless `LCPSTAR_FUZZ_EXTREMES` is set, far from both ends of the range of doubles.
pub fn tamed(x: f64) -> f64 {
    if *EXTREMES {
        return if x.is_finite() { x } else { f64::MAX };
    }
    match x.abs() {
        size if size < 1e-140 => 0.0,
        size if size > 1e140 || size.is_nan() => 1e140,
        _ => x,
    }
}

static EXTREMES: LazyLock<bool> = LazyLock::new(|| std::env::var_os("LCPSTAR_FUZZ_EXTREMES").is_some());
