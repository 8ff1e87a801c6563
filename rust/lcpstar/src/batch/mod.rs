//! Many small problems: one per SIMD lane, Lemke's method in reused memory for what the lanes cannot do, and the general
//! solver for what remains. Every answer is verified; nothing is dropped.
//!
//! A problem's bits depend on its own numbers only: not on its neighbours, the order, the split of the batch or the
//! number of threads.

mod alone;
mod schedule;
mod settings;
#[cfg(test)]
mod tests;

pub use lcpstar_kernels::batch::io::{Alpha, Guess, Numbers, Output, Problems, Source};
pub use schedule::solve_batch;
pub use settings::Settings;
