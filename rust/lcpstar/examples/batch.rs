//! A thousand frames of one scene, each from the solution of the last call: `cargo run --release --example batch`.
#![allow(clippy::print_stdout)]

use lcpstar::prelude::*;
use std::time::Instant;

fn main() -> lcpstar::Result<()> {
    let (n, frames) = (8, 1000);
    let a: Vec<f64> = (0..n * n).map(|k| if k % (n + 1) == 0 { 4.0 } else { 1.0 / (1.0 + (k % n) as f64) }).collect();
    let q: Vec<f64> = (0..n * frames).map(|k| (k as f64 * 0.7).sin()).collect();

    let start = Instant::now();
    let batch = solve_batch(&a, &q, n, &Options::default())?;
    println!("{} problems in {:?}, all solved: {}", batch.len(), start.elapsed(), batch.all_solved());

    let guess = (0..frames).flat_map(|k| batch.z(k).to_vec()).collect();
    let again = solve_batch(&a, &q, n, &Options::default().z0(guess).threads(1))?;
    let steps = |batch: &lcpstar::Batch| (0..frames).map(|k| u64::from(batch.iterations(k))).sum::<u64>();
    println!("factorisations and pivots: {}, and {} from the solutions", steps(&batch), steps(&again));
    Ok(())
}
