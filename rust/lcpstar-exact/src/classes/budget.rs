//! How long an exponential search may go on.

use std::cell::Cell;
use std::time::{Duration, Instant};

/// Why a search stopped before it was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// The time limit passed.
    TimeLimit,
    /// The caller asked to stop (Ctrl-C).
    Cancelled,
}

/// `Result` of a search that may be stopped.
pub type Search<T> = Result<T, Stopped>;

/// How often the clock and the caller are asked.
const POLL_EVERY: u32 = 64;
/// How often the caller is asked, which may be slow.
const ASK_EVERY: Duration = Duration::from_millis(40);

/// A time limit, a way to cancel, and a count of what was done. One per thread.
pub struct Budget<'a> {
    deadline: Option<Instant>,
    cancelled: Option<&'a dyn Fn() -> bool>,
    asked: Cell<Instant>,
    ticks: Cell<u32>,
    progress: Cell<(u64, u64)>,
}

impl<'a> Budget<'a> {
    /// No limit.
    #[must_use]
    pub fn unlimited() -> Self {
        Self::new(None, None)
    }

    /// With a deadline and a question that returns `true` when the caller wants to stop.
    #[must_use]
    pub fn new(deadline: Option<Instant>, cancelled: Option<&'a dyn Fn() -> bool>) -> Self {
        let asked = Cell::new(Instant::now());
        Self { deadline, cancelled, asked, ticks: Cell::new(0), progress: Cell::new((0, 0)) }
    }

    /// Called in the inner loop of every search.
    ///
    /// # Errors
    /// [`Stopped`] when the time is over or the caller wants to stop.
    #[inline]
    pub fn poll(&self) -> Search<()> {
        let ticks = self.ticks.get().wrapping_add(1);
        self.ticks.set(ticks);
        if ticks.is_multiple_of(POLL_EVERY) { self.ask() } else { Ok(()) }
    }

    /// As [`Budget::poll`], for a loop whose single steps take milliseconds.
    ///
    /// # Errors
    /// As [`Budget::poll`].
    pub fn poll_each(&self) -> Search<()> {
        self.ask()
    }

    /// Says how much there is to do, for the report of a stopped search.
    pub fn begin(&self, total: u64) {
        self.progress.set((0, total));
    }

    /// One part is done.
    ///
    /// # Errors
    /// As [`Budget::poll`].
    #[inline]
    pub fn step(&self) -> Search<()> {
        let (done, total) = self.progress.get();
        self.progress.set((done + 1, total));
        self.poll()
    }

    /// Parts done and parts in all of the last search.
    #[must_use]
    pub fn progress(&self) -> (u64, u64) {
        self.progress.get()
    }

    #[cold]
    fn ask(&self) -> Search<()> {
        if self.deadline.is_none() && self.cancelled.is_none() {
            return Ok(());
        }
        let now = Instant::now();
        if self.deadline.is_some_and(|deadline| now >= deadline) {
            return Err(Stopped::TimeLimit);
        }
        if let Some(cancelled) = self.cancelled
            && now.duration_since(self.asked.get()) >= ASK_EVERY
        {
            self.asked.set(now);
            if cancelled() {
                return Err(Stopped::Cancelled);
            }
        }
        Ok(())
    }
}
