//! The kernel compiled for each instruction set, and the memory of each thread for it.

#[cfg(target_arch = "x86_64")]
use super::avx::{Ymm2, Zmm};
use super::lane::{F64x8, Lane};
use super::lemke::{Lemke, Outcome};
use super::prefetch::Prefetch;
use multiversion::multiversion;
use multiversion::target::target_cfg_f;
use std::cell::Cell;
use std::thread::LocalKey;

/// What to do with a problem.
pub enum Task<'a> {
    /// Lemke's method; its point and whether each z_j is basic are written, n of each. Asks for memory by `prefetch` beside each pivot.
    Solve {
        /// The point.
        z: &'a mut [f64],
        /// Whether z_j is basic.
        basic: &'a mut [bool],
        /// Memory that is needed next.
        prefetch: &'a mut Prefetch,
    },
    /// The verdict on a point `z >= 0`.
    Verify {
        /// The point.
        z: &'a [f64],
    },
}

/// Where the memory of a thread rests.
type Home<X> = Cell<Option<Box<Lemke<X>>>>;

/// Does the task for the row-major `a` and writes `w = A z + q`. After the first call on a thread for the largest order, nothing
/// is allocated.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn run(task: Task<'_>, a: &[f64], q: &[f64], w: &mut [f64], tol: f64) -> Outcome {
    #[cfg(target_arch = "x86_64")]
    {
        if target_cfg_f!(target_feature = "avx512f") {
            thread_local!(static LEMKE: Home<Zmm> = Home::default());
            return run_in(&LEMKE, task, a, q, w, tol);
        }
        if target_cfg_f!(target_feature = "avx2") {
            thread_local!(static LEMKE: Home<Ymm2> = Home::default());
            return run_in(&LEMKE, task, a, q, w, tol);
        }
    }
    thread_local!(static LEMKE: Home<F64x8<{ cfg!(target_arch = "aarch64") }>> = Home::default());
    run_in(&LEMKE, task, a, q, w, tol)
}

/// The memory leaves its home for the time of the run: code inside a closure would not be compiled for the instruction set of
/// [`run`].
#[inline(always)]
fn run_in<X: Lane>(
    home: &'static LocalKey<Home<X>>,
    task: Task<'_>,
    a: &[f64],
    q: &[f64],
    w: &mut [f64],
    tol: f64,
) -> Outcome {
    let mut lemke = home.take().unwrap_or_default();
    let outcome = match task {
        Task::Solve { z, basic, prefetch } => {
            let outcome = lemke.solve_and_verify(a, q, w, tol, prefetch);
            if outcome.found_basis {
                z.fill(0.0);
                basic.fill(false);
                for j in lemke.basis() {
                    (z[j], basic[j]) = (lemke.z(j), true);
                }
            }
            outcome
        }
        Task::Verify { z } => {
            let accepted = lemke.verify_point(a, q, z, w, tol);
            Outcome { accepted, found_basis: false, pivots: 0 }
        }
    };
    home.set(Some(lemke));
    outcome
}
