//! Where nalgebra and faer cross over for factor-and-solve: `cargo bench -p lcpstar --bench backend`.
#![allow(missing_docs)]

use divan::{Bencher, black_box};
use lcpstar::linalg::backend::DenseLu;

const ORDERS: [usize; 9] = [4, 8, 12, 16, 24, 32, 48, 64, 128];

fn main() {
    divan::main();
}

/// Full, diagonally shifted, reproducible.
fn matrix(n: usize) -> Vec<f64> {
    (0..n * n).map(|k| ((k * 7919 % 101) as f64) / 50.0 - 1.0 + if k % (n + 1) == 0 { 3.0 } else { 0.0 }).collect()
}

#[divan::bench(args = ORDERS)]
fn nalgebra(bencher: Bencher<'_, '_>, n: usize) {
    let (a, b) = (matrix(n), vec![1.0; n]);
    bencher.bench(|| DenseLu::small(n, black_box(&a)).map(|lu| lu.solve(&b)));
}

#[divan::bench(args = ORDERS)]
fn faer(bencher: Bencher<'_, '_>, n: usize) {
    let (a, b) = (matrix(n), vec![1.0; n]);
    bencher.bench(|| DenseLu::large(n, black_box(&a)).map(|lu| lu.solve(&b)));
}
