//! Attacks on lcpstar's answers, and the exact referee that scores them: it shares no arithmetic with the library.

pub mod attacks;
mod exact;
pub mod problem;
pub mod referee;
mod solvable;
