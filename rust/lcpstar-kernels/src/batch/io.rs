//! What goes into a batch and what comes out: borrowed arrays, never copied whole.

use crate::small::Accepted;
use crate::small::prefetch::Prefetch;
use crate::small::verify::SOLVED;

/// Which block of an array belongs to problem k.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// Block k.
    Each,
    /// Block 0 for every problem.
    One,
    /// Block `map[k]`.
    Mapped(&'a [usize]),
}

impl Source<'_> {
    /// The block of problem `k`.
    #[inline(always)]
    #[must_use]
    pub fn block(self, k: usize) -> usize {
        match self {
            Self::Each => k,
            Self::One => 0,
            Self::Mapped(map) => map[k],
        }
    }
}

/// Numbers of the caller.
#[derive(Clone, Copy, Debug)]
pub enum Numbers<'a> {
    /// Double precision.
    Double(&'a [f64]),
    /// Single precision: each number stands for the double that equals it.
    Single(&'a [f32]),
}

impl<'a> Numbers<'a> {
    /// One block of `length` numbers.
    #[inline(always)]
    fn block(self, block: usize, length: usize) -> Self {
        let range = block * length..(block + 1) * length;
        match self {
            Self::Double(x) => Self::Double(&x[range]),
            Self::Single(x) => Self::Single(&x[range]),
        }
    }

    /// Writes the numbers in double precision to `copy`.
    fn copy(self, copy: &mut Vec<f64>) {
        copy.clear();
        match self {
            Self::Double(x) => copy.extend_from_slice(x),
            Self::Single(x) => copy.extend(x.iter().map(|x| f64::from(*x))),
        }
    }
}

/// `count` problems of order `n`: blocks of `n * n` numbers of `a` (row-major) and of `n` numbers of `q`.
#[derive(Clone, Copy, Debug)]
pub struct Problems<'a> {
    /// Order.
    pub n: usize,
    /// Problems.
    pub count: usize,
    /// Matrices.
    pub a: Numbers<'a>,
    /// Where each problem's matrix is.
    pub a_source: Source<'a>,
    /// Vectors.
    pub q: Numbers<'a>,
    /// Where each problem's vector is.
    pub q_source: Source<'a>,
}

impl<'a> Problems<'a> {
    /// The matrix of problem `k`.
    #[inline(always)]
    fn matrix(&self, k: usize) -> Numbers<'a> {
        self.a.block(self.a_source.block(k), self.n * self.n)
    }

    /// Copies A and q of problem `k`.
    pub fn copy(&self, k: usize, a: &mut Vec<f64>, q: &mut Vec<f64>) {
        self.matrix(k).copy(a);
        self.q.block(self.q_source.block(k), self.n).copy(q);
    }

    /// Whether all `a_ii > 0` in problem `k`.
    #[inline(always)]
    pub fn has_positive_diagonal(&self, k: usize) -> bool {
        // Backwards: contact problems have their zeros at the end.
        match self.matrix(k) {
            Numbers::Double(a) => a.iter().step_by(self.n + 1).rev().all(|&x| x > 0.0),
            Numbers::Single(a) => a.iter().step_by(self.n + 1).rev().all(|&x| x > 0.0),
        }
    }

    /// Plans to ask for the matrix of problem `k`, all of it within `steps` steps.
    #[inline(always)]
    pub fn plan(&self, prefetch: &mut Prefetch, k: usize, steps: usize) {
        match self.matrix(k) {
            Numbers::Double(a) => prefetch.plan(a, steps),
            Numbers::Single(a) => prefetch.plan(a, steps),
        }
    }
}

/// A guess of each problem's support, e.g. that of the last frame.
#[derive(Clone, Copy, Debug)]
pub enum Guess<'a> {
    /// Start from the rows with `q_i < 0`.
    None,
    /// Bit i of mask k: z_i of problem k is positive (n <= 64).
    Masks(&'a [u64]),
    /// `n` flags per problem.
    Flags(&'a [bool]),
    /// `n` numbers per problem: positive where z is.
    Points(&'a [f64]),
}

impl Guess<'_> {
    /// Whether z_i of problem `k` is guessed positive; `otherwise` without a guess.
    #[inline(always)]
    #[must_use]
    pub fn contains(self, n: usize, k: usize, i: usize, otherwise: bool) -> bool {
        match self {
            Self::None => otherwise,
            Self::Masks(masks) => masks[k] >> i & 1 == 1,
            Self::Flags(flags) => flags[k * n + i],
            Self::Points(z) => z[k * n + i] > 0.0,
        }
    }
}

/// Where supports are written.
#[derive(Debug)]
pub enum Alpha<'a> {
    /// One mask per problem (n <= 64).
    Masks(&'a mut [u64]),
    /// `n` flags per problem.
    Flags(&'a mut [bool]),
}

impl<'a> Alpha<'a> {
    /// The first `problems` of order `n`, and the rest.
    fn split(self, problems: usize, n: usize) -> (Self, Self) {
        match self {
            Self::Masks(v) => {
                let (head, tail) = v.split_at_mut(problems);
                (Self::Masks(head), Self::Masks(tail))
            }
            Self::Flags(v) => {
                let (head, tail) = v.split_at_mut(problems * n);
                (Self::Flags(head), Self::Flags(tail))
            }
        }
    }

    /// Writes the supports of the problems from `k` on, given as masks (n <= 64).
    #[inline(always)]
    pub fn write_masks(&mut self, n: usize, k: usize, masks: &[u64]) {
        match self {
            Self::Masks(v) => v[k..k + masks.len()].copy_from_slice(masks),
            Self::Flags(v) => {
                for (flags, mask) in v[k * n..].chunks_exact_mut(n).zip(masks) {
                    for (i, flag) in flags.iter_mut().enumerate() {
                        *flag = mask >> i & 1 == 1;
                    }
                }
            }
        }
    }

    /// Writes the support of problem `k`.
    #[inline(always)]
    pub fn write(&mut self, n: usize, k: usize, is_in: impl Fn(usize) -> bool) {
        match self {
            Self::Masks(v) => v[k] = (0..n).fold(0, |mask, i| mask | u64::from(is_in(i)) << i),
            Self::Flags(v) => {
                for (i, flag) in v[k * n..(k + 1) * n].iter_mut().enumerate() {
                    *flag = is_in(i);
                }
            }
        }
    }
}

/// Results, one entry (or `n`) per problem.
#[derive(Debug)]
pub struct Output<'a> {
    /// Solutions.
    pub z: &'a mut [f64],
    /// Slacks.
    pub w: &'a mut [f64],
    /// The status as a number, in the order of its variants.
    pub status: &'a mut [u8],
    /// [`Member`](crate::member::Member) as its code.
    pub method: &'a mut [u8],
    /// Factorisations, pivots or iterations.
    pub iterations: &'a mut [u32],
    /// The scale-free residual.
    pub residual: &'a mut [f64],
    /// The natural residual in the caller's units.
    pub natural_residual: &'a mut [f64],
    /// Supports.
    pub alpha: Alpha<'a>,
}

impl Output<'_> {
    /// What a kernel accepted, for problem k; the point and its support are written already.
    #[inline(always)]
    pub fn accept(&mut self, k: usize, method: u8, iterations: u32, accepted: &Accepted) {
        self.status[k] = SOLVED;
        self.method[k] = method;
        self.iterations[k] = iterations;
        self.residual[k] = accepted.residual();
        self.natural_residual[k] = accepted.natural_residual();
    }

    /// The results of the first `problems` problems of order `n`, and the rest.
    pub fn split(self, problems: usize, n: usize) -> (Self, Self) {
        let (z, z_rest) = self.z.split_at_mut(problems * n);
        let (w, w_rest) = self.w.split_at_mut(problems * n);
        let (status, status_rest) = self.status.split_at_mut(problems);
        let (method, method_rest) = self.method.split_at_mut(problems);
        let (iterations, iterations_rest) = self.iterations.split_at_mut(problems);
        let (residual, residual_rest) = self.residual.split_at_mut(problems);
        let (natural_residual, natural_rest) = self.natural_residual.split_at_mut(problems);
        let (alpha, alpha_rest) = self.alpha.split(problems, n);
        (
            Self { z, w, status, method, iterations, residual, natural_residual, alpha },
            Self {
                z: z_rest,
                w: w_rest,
                status: status_rest,
                method: method_rest,
                iterations: iterations_rest,
                residual: residual_rest,
                natural_residual: natural_rest,
                alpha: alpha_rest,
            },
        )
    }
}
