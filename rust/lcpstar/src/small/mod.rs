//! One small problem at a time, without a single allocation: Lemke's method in reused memory, verified by
//! the rule of `certify`. `solve` tries it first; the batch runs it and its lanes on whole arrays of problems.
//!
//! A time limit is not looked at: the limit on pivots ends a run of order 128 within a few milliseconds.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx;
pub(crate) mod lane;
pub(crate) mod lemke;
mod tableau;
pub(crate) mod verify;

use crate::scaling::{Scaling, times_power_of_two};
#[cfg(target_arch = "x86_64")]
use avx::{Ymm2, Zmm};
use lane::{F64x8, Lane};
use lemke::Basis;
use multiversion::multiversion;
use multiversion::target::target_cfg_f;
use std::cell::RefCell;
use std::thread::LocalKey;
use tableau::Tableau;

/// Largest order that [`solve_one`] takes.
pub const TINY_ORDER: usize = 128;

/// A verified solution.
#[derive(Clone, Copy, Debug)]
pub struct TinySolution {
    /// Order.
    pub n: usize,
    z: [f64; TINY_ORDER],
    w: [f64; TINY_ORDER],
    /// Bit i: z_i is basic.
    pub alpha: u128,
    /// Pivots.
    pub iterations: usize,
    /// Bound of the scale-free residual, at most `tol`.
    pub residual: f64,
    /// Bound of the natural residual in the caller's units.
    pub natural_residual: f64,
}

impl TinySolution {
    /// The solution.
    #[must_use]
    pub fn z(&self) -> &[f64] {
        &self.z[..self.n]
    }

    /// `A z + q`.
    #[must_use]
    pub fn w(&self) -> &[f64] {
        &self.w[..self.n]
    }
}

/// What the kernel has to say about a problem.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "returned once and taken apart: a box would be an allocation")]
pub enum Answer {
    /// A verified solution.
    Solved(TinySolution),
    /// The basis on which the method ended, whose point could not be verified as it stands.
    Basis {
        /// Bit i: z_i is in it.
        alpha: u128,
        /// Pivots.
        iterations: usize,
    },
    /// Nothing.
    None,
}

/// Solves and verifies LCP(q, A) by Lemke's method, `a` row-major. O(n^2) a pivot; after the first call on a thread for
/// the largest n, nothing is allocated.
///
/// `None` says nothing about the problem (n too large, a ray, a number that is not finite, an answer that could not be
/// verified at once): ask the general solver.
#[must_use]
pub fn solve_one(n: usize, a: &[f64], q: &[f64], tol: f64) -> Option<TinySolution> {
    match solve_scaled(n, a, q, None, tol) {
        Answer::Solved(solution) => Some(solution),
        Answer::Basis { .. } | Answer::None => None,
    }
}

/// As [`solve_one`], with pivots on `D_r A D_c` where a scaling is given; its factor of q is not used. The answer is verified on
/// `a` and `q` themselves.
#[must_use]
pub fn solve_scaled(n: usize, a: &[f64], q: &[f64], scaling: Option<&Scaling>, tol: f64) -> Answer {
    if n == 0 || n > TINY_ORDER || a.len() != n * n || q.len() != n {
        return Answer::None;
    }
    let Some(scaling) = scaling else {
        return dispatch(n, a, q, Task::Solve, tol);
    };
    if scaling.rows.len() != n || scaling.columns.len() != n || !scaling.is_moderate() {
        return Answer::None;
    }
    let factors = |exponents: &[i32]| exponents.iter().map(|&e| times_power_of_two(1.0, e)).collect::<Vec<f64>>();
    let (rows, columns) = (factors(&scaling.rows), factors(&scaling.columns));
    let scaled_a: Vec<f64> = a
        .chunks_exact(n)
        .zip(&rows)
        .flat_map(|(row, r)| row.iter().zip(&columns).map(move |(x, c)| r * x * c))
        .collect();
    let scaled_q: Vec<f64> = q.iter().zip(&rows).map(|(q, r)| q * r).collect();
    match dispatch(n, &scaled_a, &scaled_q, Task::Solve, tol) {
        Answer::Solved(TinySolution { z, alpha, iterations, .. }) => {
            let z: Vec<f64> = z.iter().zip(&columns).map(|(z, c)| z * c).collect();
            match verify_point(n, a, q, &z, tol) {
                Some(solution) => Answer::Solved(TinySolution { alpha, iterations, ..solution }),
                None => Answer::Basis { alpha, iterations },
            }
        }
        unsolved => unsolved,
    }
}

/// A point that was found elsewhere, `z >= 0` with support `alpha`, verified. O(n^2), otherwise as [`solve_one`].
#[must_use]
pub fn verify_point(n: usize, a: &[f64], q: &[f64], z: &[f64], tol: f64) -> Option<TinySolution> {
    if n == 0 || n > TINY_ORDER || a.len() != n * n || q.len() != n || z.len() != n {
        return None;
    }
    match dispatch(n, a, q, Task::Verify(z), tol) {
        Answer::Solved(solution) => Some(solution),
        Answer::Basis { .. } | Answer::None => None,
    }
}

/// The basis (bit i: z_i is in it) on which Lemke's method ends on the whole tableau, and its pivots: for problems with singular
/// blocks and entries of very different sizes. O(n^2) a pivot; nothing is allocated after the first call on a thread.
#[must_use]
pub fn basis_by_tableau(n: usize, a: &[f64], q: &[f64]) -> Option<(u128, usize)> {
    if n == 0 || n > TINY_ORDER || a.len() != n * n || q.len() != n {
        return None;
    }
    run_tableau(n, a, q)
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn run_tableau(n: usize, a: &[f64], q: &[f64]) -> Option<(u128, usize)> {
    #[cfg(target_arch = "x86_64")]
    {
        if target_cfg_f!(target_feature = "avx512f") {
            thread_local!(static TABLEAU: RefCell<Tableau<Zmm>> = RefCell::default());
            return run_tableau_in(&TABLEAU, n, a, q);
        }
        if target_cfg_f!(target_feature = "avx2") {
            thread_local!(static TABLEAU: RefCell<Tableau<Ymm2>> = RefCell::default());
            return run_tableau_in(&TABLEAU, n, a, q);
        }
    }
    thread_local!(static TABLEAU: RefCell<Tableau<F64x8<{ cfg!(target_arch = "aarch64") }>>> = RefCell::default());
    run_tableau_in(&TABLEAU, n, a, q)
}

#[inline(always)]
fn run_tableau_in<X: Lane<Number = f64>>(
    home: &'static LocalKey<RefCell<Tableau<X>>>,
    n: usize,
    a: &[f64],
    q: &[f64],
) -> Option<(u128, usize)> {
    let mut tableau = home.take();
    let found = tableau.solve(n, a, q).then(|| (tableau.alpha(), tableau.pivots));
    home.set(tableau);
    found
}

/// What to do with the problem.
#[derive(Clone, Copy)]
enum Task<'a> {
    Solve,
    Verify(&'a [f64]),
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn dispatch(n: usize, a: &[f64], q: &[f64], task: Task<'_>, tol: f64) -> Answer {
    #[cfg(target_arch = "x86_64")]
    {
        if target_cfg_f!(target_feature = "avx512f") {
            thread_local!(static BASIS: RefCell<Basis<Zmm>> = RefCell::default());
            return solve_in(&BASIS, n, a, q, task, tol);
        }
        if target_cfg_f!(target_feature = "avx2") {
            thread_local!(static BASIS: RefCell<Basis<Ymm2>> = RefCell::default());
            return solve_in(&BASIS, n, a, q, task, tol);
        }
    }
    thread_local!(static BASIS: RefCell<Basis<F64x8<{ cfg!(target_arch = "aarch64") }>>> = RefCell::default());
    solve_in(&BASIS, n, a, q, task, tol)
}

/// The memory leaves its home for the time of the solve: code inside a closure would not be compiled for the
/// instruction set of `dispatch`.
#[inline(always)]
fn solve_in<X: Lane<Number = f64>>(
    home: &'static LocalKey<RefCell<Basis<X>>>,
    n: usize,
    a: &[f64],
    q: &[f64],
    task: Task<'_>,
    tol: f64,
) -> Answer {
    let (mut z, mut w) = ([0.0; TINY_ORDER], [0.0; TINY_ORDER]);
    let mut lemke = home.take();
    let judged = match task {
        Task::Solve => lemke.solve_and_verify(n, a, q, &mut w[..n], tol),
        Task::Verify(z) => lemke.verify_point(n, a, q, z, &mut w[..n], tol),
    };
    let basis = || (0..n).fold(0_u128, |mask, i| mask | u128::from(lemke.is_basic(i)) << i);
    let alpha = match task {
        Task::Solve => basis(),
        Task::Verify(z) => z.iter().enumerate().fold(0_u128, |mask, (i, &z)| mask | u128::from(z > 0.0) << i),
    };
    let Some(judged) = judged else {
        let found = matches!(task, Task::Solve) && lemke.found_basis;
        let iterations = lemke.pivots;
        home.set(lemke);
        return if found { Answer::Basis { alpha, iterations } } else { Answer::None };
    };
    for (i, z) in z[..n].iter_mut().enumerate() {
        *z = lemke.z(i);
    }
    let solution = TinySolution {
        n,
        z,
        w,
        alpha,
        iterations: if matches!(task, Task::Solve) { lemke.pivots } else { 0 },
        residual: judged.residual,
        natural_residual: judged.natural_residual,
    };
    home.set(lemke);
    Answer::Solved(solution)
}
