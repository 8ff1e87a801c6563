//! Where nalgebra and faer cross over for factor-and-solve, and the kernels of `blocked` beside them: `cargo bench -p lcpstar-linalg --bench backend`.
#![allow(missing_docs)]

use divan::{Bencher, black_box};
use lcpstar_linalg::backend::{DenseCholesky, DenseLu};
use lcpstar_linalg::blocked::BlockFactor;
use lcpstar_linalg::square::Square;

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

/// Orders of principal blocks.
const BLOCKS: [usize; 9] = [32, 64, 128, 256, 512, 768, 1024, 1536, 2048];

fn problem(n: usize) -> Vec<f64> {
    let symmetric: Vec<f64> = matrix(n);
    (0..n * n)
        .map(|k| symmetric[k] + symmetric[k % n * n + k / n] + if k % (n + 1) == 0 { n as f64 } else { 0.0 })
        .collect()
}

#[divan::bench(args = BLOCKS)]
fn block_cholesky(bencher: Bencher<'_, '_>, n: usize) {
    let (entries, alpha, mut factor) = (problem(n), (0..n).collect::<Vec<_>>(), BlockFactor::default());
    bencher.bench_local(|| factor.cholesky(black_box(Square { n, entries: &entries }), &alpha, 0.0, 1e-14));
}

#[divan::bench(args = BLOCKS)]
fn library_cholesky(bencher: Bencher<'_, '_>, n: usize) {
    let entries = problem(n);
    bencher.bench_local(|| DenseCholesky::new(n, black_box(&entries)));
}
