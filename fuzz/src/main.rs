//! One fuzz target: the first byte chooses a public entry point of the core, the rest its problem and options. Every
//! answer is judged by `oracle` in exact arithmetic. A panic, a failed check, a NaN or a call that does not end is a finding.

#![no_main]

mod calls;
mod classes;
mod input;
mod options;
mod oracle;
mod show;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut bytes = input::Bytes::new(data);
    match bytes.below(12) {
        0..=4 => calls::solve(&mut bytes),
        5 => calls::prove(&mut bytes),
        6 | 7 => calls::batch(&mut bytes),
        8 => calls::sparse(&mut bytes),
        9 => calls::solution_set(&mut bytes),
        10 => calls::transform(&mut bytes),
        _ => classes::classes(&mut bytes),
    }
});
