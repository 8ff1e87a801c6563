//! The kernel compiled for each instruction set, and the memory of each thread for it.

#[cfg(target_arch = "x86_64")]
use super::avx::{Ymm2, Zmm};
use super::lane::{F64x8, Lane};
use super::lemke::{Lemke, Outcome};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;
use std::cell::RefCell;
use std::thread::LocalKey;

/// What to do with a problem.
pub enum Task<'a> {
    /// Lemke's method; its point and whether each z_j is basic are written, n of each.
    Solve { z: &'a mut [f64], basic: &'a mut [bool] },
    /// The verdict on a point `z >= 0`.
    Verify { z: &'a [f64] },
}

/// Does the task for the row-major `a` and writes `w = A z + q`. After the first call on a thread for the largest order, nothing
/// is allocated.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn run(task: Task<'_>, a: &[f64], q: &[f64], w: &mut [f64], tol: f64) -> Outcome {
    #[cfg(target_arch = "x86_64")]
    {
        if target_cfg_f!(target_feature = "avx512f") {
            thread_local!(static LEMKE: RefCell<Lemke<Zmm>> = RefCell::default());
            return run_in(&LEMKE, task, a, q, w, tol);
        }
        if target_cfg_f!(target_feature = "avx2") {
            thread_local!(static LEMKE: RefCell<Lemke<Ymm2>> = RefCell::default());
            return run_in(&LEMKE, task, a, q, w, tol);
        }
    }
    thread_local!(static LEMKE: RefCell<Lemke<F64x8<{ cfg!(target_arch = "aarch64") }>>> = RefCell::default());
    run_in(&LEMKE, task, a, q, w, tol)
}

/// The memory leaves its home for the time of the run: code inside a closure would not be compiled for the instruction set of
/// [`run`].
#[inline(always)]
fn run_in<X: Lane<Number = f64>>(
    home: &'static LocalKey<RefCell<Lemke<X>>>,
    task: Task<'_>,
    a: &[f64],
    q: &[f64],
    w: &mut [f64],
    tol: f64,
) -> Outcome {
    let mut lemke = home.take();
    let outcome = match task {
        Task::Solve { z, basic } => {
            let outcome = lemke.solve_and_verify(a, q, w, tol);
            if outcome.found_basis {
                for (j, (z, basic)) in z.iter_mut().zip(basic).enumerate() {
                    (*z, *basic) = (lemke.z(j), lemke.is_basic(j));
                }
            }
            outcome
        }
        Task::Verify { z } => {
            let judged = lemke.verify_point(a, q, z, w, tol);
            Outcome { judged, found_basis: false, pivots: 0 }
        }
    };
    home.set(lemke);
    outcome
}
