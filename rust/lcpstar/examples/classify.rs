//! The example of the paper: its classes, decided exactly, and all solutions of a problem: `cargo run --example classify`.
#![allow(clippy::print_stdout)]

use std::time::Duration;

fn main() -> lcpstar::Result<()> {
    let a = [0.0, 1.0, 1.0, 2.0, 0.0, 2.0, -2.0, -5.0, 0.0];
    for (symbol, holds) in lcpstar::classify(&a, 3, Some(Duration::from_secs(10)))? {
        if holds != Some(false) {
            println!("{symbol}: {}", if holds.is_some() { "yes" } else { "undecided" });
        }
    }
    for face in lcpstar::all_solutions(&a, &[-4.0, -7.0, 10.0], None)?.into_iter().flatten() {
        println!("solution {:?}", face.vertices[0].to_f64());
    }
    Ok(())
}
