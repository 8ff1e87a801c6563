//! What may stop a method from outside: an iteration limit, a deadline, an interrupt.

use crate::status::Termination;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// Asked by every method once per iteration. Borrowed, `Sync`, no cost worth naming when nothing is set.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    /// Iterations after which the method stops; `None`: the method's own default.
    pub max_iterations: Option<usize>,
    /// When to stop.
    pub deadline: Option<Instant>,
    /// Says whether the caller wants to stop (Ctrl-C); asked at most every iteration.
    pub interrupted: Option<&'a (dyn Fn() -> bool + Sync)>,
}

impl Control<'_> {
    /// The reason to stop before iteration number `iteration` (from 0), if any; `default_limit` when none was given.
    #[must_use]
    pub fn stop(&self, iteration: usize, default_limit: usize) -> Option<Termination> {
        if iteration >= self.max_iterations.unwrap_or(default_limit) {
            return Some(Termination::IterationLimit);
        }
        self.expired()
    }

    /// The reason to stop that does not depend on counting.
    #[must_use]
    pub fn expired(&self) -> Option<Termination> {
        if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            return Some(Termination::TimeLimit);
        }
        if self.interrupted.is_some_and(|asked| asked()) {
            return Some(Termination::Interrupted);
        }
        None
    }

    /// The same deadline and interrupt with another iteration limit.
    #[must_use]
    pub fn with_max_iterations(self, max_iterations: Option<usize>) -> Self {
        Self { max_iterations, ..self }
    }
}

/// How often a thread that waits for others looks around.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Whether this is an unoptimised build, in which the kernels keep every one of their SIMD registers on the stack: megabytes.
const UNOPTIMISED: bool = cfg!(debug_assertions);

/// Stack of a thread.
const STACK: usize = if UNOPTIMISED { 64 << 20 } else { 2 << 20 };

/// Runs `work` in this thread and in `helpers` others; the result of this one comes first.
///
/// Without the feature `parallel` there are no others; an unoptimised build works in others alone, whose stacks are large. `look` is called here while the others are at work: only the thread that the caller came with can see his Ctrl-C.
pub fn in_threads<T: Send>(helpers: usize, work: impl Fn() -> T + Sync, look: impl Fn()) -> Vec<T> {
    let helpers = if cfg!(feature = "parallel") { helpers } else { 0 } + usize::from(UNOPTIMISED);
    let work = &work;
    std::thread::scope(|scope| {
        let (working, done) = channel::<()>();
        let others: Vec<_> = (0..helpers)
            .map(|_| {
                let working = working.clone();
                let thread = Builder::new().stack_size(STACK);
                let spawned = thread.spawn_scoped(scope, move || {
                    let _until_the_end = working;
                    work()
                });
                spawned.expect("the system has another thread")
            })
            .collect();
        drop(working);
        let mut results = if UNOPTIMISED { Vec::new() } else { vec![work()] };
        while done.recv_timeout(LOOK_EVERY) == Err(RecvTimeoutError::Timeout) {
            look();
        }
        for thread in others {
            match thread.join() {
                Ok(result) => results.push(result),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        results
    })
}
