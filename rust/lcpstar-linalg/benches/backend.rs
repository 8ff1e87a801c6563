//! Where nalgebra and faer cross over for factor-and-solve, and the kernels of `linalg::blocked` beside them: `cargo bench -p lcpstar --bench backend`.
#![allow(missing_docs)]

use divan::{Bencher, black_box};
use lcpstar::Lcp;
use lcpstar::linalg::backend::{DenseCholesky, DenseLu};
use lcpstar::linalg::blocked::BlockFactor;

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

fn problem(n: usize) -> Lcp {
    let symmetric: Vec<f64> = matrix(n);
    let a =
        (0..n * n).map(|k| symmetric[k] + symmetric[k % n * n + k / n] + if k % (n + 1) == 0 { n as f64 } else { 0.0 });
    Lcp::new(n, a.collect(), vec![1.0; n]).expect("valid")
}

#[divan::bench(args = BLOCKS)]
fn block_lu(bencher: Bencher<'_, '_>, n: usize) {
    let (lcp, alpha, mut factor) = (problem(n), (0..n).collect::<Vec<_>>(), BlockFactor::default());
    bencher.bench_local(|| factor.lu(black_box(&lcp), &alpha));
}

#[divan::bench(args = BLOCKS)]
fn block_cholesky(bencher: Bencher<'_, '_>, n: usize) {
    let (lcp, alpha, mut factor) = (problem(n), (0..n).collect::<Vec<_>>(), BlockFactor::default());
    bencher.bench_local(|| factor.cholesky(black_box(&lcp), &alpha, 0.0, 1e-14));
}

#[divan::bench(args = BLOCKS)]
fn library_lu(bencher: Bencher<'_, '_>, n: usize) {
    let lcp = problem(n);
    bencher.bench_local(|| DenseLu::new(n, black_box(lcp.a())));
}

#[divan::bench(args = BLOCKS)]
fn library_cholesky(bencher: Bencher<'_, '_>, n: usize) {
    let lcp = problem(n);
    bencher.bench_local(|| DenseCholesky::new(n, black_box(lcp.a())));
}
