//! One small problem at a time, without a single allocation: Lemke's method in reused memory, verified by
//! the rule of `certify`. `solve` tries it first; the batch runs it and its lanes on whole arrays of problems.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx;
pub(crate) mod lane;
pub(crate) mod lemke;
pub(crate) mod verify;

#[cfg(target_arch = "x86_64")]
use avx::{Ymm2, Zmm};
use lane::{F64x8, Lane};
use lemke::Basis;
use multiversion::multiversion;
use multiversion::target::target_cfg_f;
use std::cell::RefCell;
use std::thread::LocalKey;

/// Largest order that [`solve_one`] takes.
pub const TINY_ORDER: usize = 64;

/// A verified solution.
#[derive(Clone, Copy, Debug)]
pub struct TinySolution {
    /// Order.
    pub n: usize,
    z: [f64; TINY_ORDER],
    w: [f64; TINY_ORDER],
    /// Bit i: z_i is basic.
    pub alpha: u64,
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

/// Solves and verifies LCP(q, A) by Lemke's method, `a` row-major. O(n^2) a pivot; after the first call on a thread for
/// the largest n, nothing is allocated.
///
/// `None` says nothing about the problem (n too large, a ray, a number that is not finite, an answer that could not be
/// verified at once): ask the general solver.
#[must_use]
pub fn solve_one(n: usize, a: &[f64], q: &[f64], tol: f64) -> Option<TinySolution> {
    if n == 0 || n > TINY_ORDER || a.len() != n * n || q.len() != n {
        return None;
    }
    dispatch(n, a, q, tol)
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn dispatch(n: usize, a: &[f64], q: &[f64], tol: f64) -> Option<TinySolution> {
    #[cfg(target_arch = "x86_64")]
    {
        if target_cfg_f!(target_feature = "avx512f") {
            thread_local!(static BASIS: RefCell<Basis<Zmm>> = RefCell::default());
            return solve_in(&BASIS, n, a, q, tol);
        }
        if target_cfg_f!(target_feature = "avx2") {
            thread_local!(static BASIS: RefCell<Basis<Ymm2>> = RefCell::default());
            return solve_in(&BASIS, n, a, q, tol);
        }
    }
    thread_local!(static BASIS: RefCell<Basis<F64x8<{ cfg!(target_arch = "aarch64") }>>> = RefCell::default());
    solve_in(&BASIS, n, a, q, tol)
}

/// The memory leaves its home for the time of the solve: code inside a closure would not be compiled for the
/// instruction set of `dispatch`.
#[inline(always)]
fn solve_in<X: Lane<Number = f64>>(
    home: &'static LocalKey<RefCell<Basis<X>>>,
    n: usize,
    a: &[f64],
    q: &[f64],
    tol: f64,
) -> Option<TinySolution> {
    let (mut z, mut w) = ([0.0; TINY_ORDER], [0.0; TINY_ORDER]);
    let mut basis = home.take();
    let judged = basis.solve_and_verify(n, a, q, &mut w[..n], tol);
    let Some(judged) = judged else {
        home.set(basis);
        return None;
    };
    for (i, z) in z[..n].iter_mut().enumerate() {
        *z = basis.z(i);
    }
    let solution = TinySolution {
        n,
        z,
        w,
        alpha: (0..n).fold(0, |mask, i| mask | u64::from(basis.is_basic(i)) << i),
        iterations: basis.pivots,
        residual: judged.residual,
        natural_residual: judged.natural_residual,
    };
    home.set(basis);
    Some(solution)
}
