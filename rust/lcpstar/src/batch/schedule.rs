//! Hands chunks of a batch to threads.

use super::alone::Alone;
use super::{Output, Problems, Settings};
use crate::control::in_threads;
use crate::error::{LcpError, Result};
use lcpstar_kernels::batch::work::{Chunk, work};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Numbers of `A` in one chunk, about: enough to make taking a chunk cheap, few enough to share the work evenly.
const CHUNK_NUMBERS: usize = 16_384;

/// Solves every problem and verifies every answer; results do not depend on the number of threads.
///
/// Memory per thread only, O(n^2); time per problem O(n^3) times a few. Returns `false` if interrupted, with the
/// remaining problems untouched.
///
/// # Errors
/// `NotFinite` names the first problem with a NaN or an infinity; `OutOfRange` for `tol`.
pub fn solve_batch(problems: &Problems<'_>, settings: &Settings<'_>, output: Output<'_>) -> Result<bool> {
    if !(settings.tol > 0.0 && settings.tol < 1.0) {
        return Err(LcpError::OutOfRange { name: "tol", value: settings.tol, rule: "in (0, 1)" });
    }
    let n = problems.n;
    let size = (CHUNK_NUMBERS / (n * n).max(1)).clamp(1, 1024).next_multiple_of(16);
    let chunks = problems.count.div_ceil(size);
    let mut rest = Some(output);
    let mut first = 0;
    let queue = Mutex::new(std::iter::from_fn(move || {
        let output = rest.take().filter(|_| first < problems.count)?;
        let problems_here = size.min(problems.count - first);
        let (head, tail) = output.split(problems_here, n);
        rest = Some(tail);
        first += problems_here;
        Some(Chunk { first: first - problems_here, output: head })
    }));
    let stopped = AtomicBool::new(false);
    let look = || {
        if settings.interrupted.is_some_and(|asked| asked()) {
            stopped.store(true, Ordering::Relaxed);
        }
    };
    let next = || {
        look();
        if stopped.load(Ordering::Relaxed) {
            return None;
        }
        queue.lock().unwrap_or_else(PoisonError::into_inner).next()
    };
    let threads = match settings.threads {
        0 if chunks > 1 => cores(),
        threads => threads.max(1),
    };
    let helpers = threads.min(chunks).saturating_sub(1);
    let run = || {
        let (mut alone, mut result) = (Alone::new(problems, settings), Ok(()));
        work(problems, &settings.asked(), &next, &mut |chunk, waiting| {
            result = alone.solve(chunk, waiting);
            result.is_ok()
        });
        if result.is_err() {
            stopped.store(true, Ordering::Relaxed);
        }
        result
    };
    in_threads(helpers, run, look).into_iter().fold(Ok(()), earlier)?;
    Ok(!stopped.load(Ordering::Relaxed))
}

/// Cores for this process. The system is asked once: it takes longer to answer than a small batch takes.
fn cores() -> usize {
    static CORES: OnceLock<usize> = OnceLock::new();
    *CORES.get_or_init(|| std::thread::available_parallelism().map_or(1, usize::from))
}

/// The error of the problem that comes first in the batch. Chunks are taken in order, so every problem before it was
/// looked at: the same error is reported whatever the number of threads.
fn earlier(a: Result<()>, b: Result<()>) -> Result<()> {
    let place = |error: &LcpError| match error {
        LcpError::NotFinite { index, .. } => index.first().copied().unwrap_or(0),
        _ => 0,
    };
    match (a, b) {
        (Err(a), Err(b)) => Err(if place(&b) < place(&a) { b } else { a }),
        (Err(error), Ok(())) | (Ok(()), Err(error)) => Err(error),
        (Ok(()), Ok(())) => Ok(()),
    }
}
