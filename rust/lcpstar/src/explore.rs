//! Scans of small matrices for a counterexample, in threads.

use crate::control::{Control, in_threads};
use crate::exact::classes::budget::{Budget, Search};
use crate::exact::classes::formula::Formula;
use crate::exact::classes::scan::{Space, Tally};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Matrices that a thread takes at a time.
const PER_TASK: u64 = 64;

/// Counts, among the matrices of those numbers, the ones that satisfy the hypothesis and those of them that miss the conclusion; the
/// result does not depend on the number of threads.
///
/// # Errors
/// Why `control` stopped it.
pub fn explore(
    space: &Space,
    hypothesis: &Formula,
    conclusion: &Formula,
    numbers: Range<u64>,
    threads: usize,
    control: &Control<'_>,
) -> Search<Tally> {
    let interrupted = || control.interrupted.is_some_and(|asked| asked());
    let next = AtomicU64::new(numbers.start);
    let run = || -> Search<Tally> {
        let budget = Budget::new(control.deadline, Some(&interrupted));
        let mut sum = Tally::default();
        loop {
            let from = next.fetch_add(PER_TASK, Ordering::Relaxed);
            if from >= numbers.end {
                return Ok(sum);
            }
            sum.add(space.scan(hypothesis, conclusion, from, (from + PER_TASK).min(numbers.end), &budget)?);
        }
    };
    let tasks = numbers.end.saturating_sub(numbers.start).div_ceil(PER_TASK) as usize;
    let mut sum = Tally::default();
    for tally in in_threads(threads.min(tasks).saturating_sub(1), run, || _ = interrupted()) {
        sum.add(tally?);
    }
    Ok(sum)
}
