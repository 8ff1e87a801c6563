//! What a Rust program waits for: `make bench-rust`.
#![allow(missing_docs)]

use divan::{Bencher, black_box};
use lcpstar::classes::class::Class;
use lcpstar::classes::formula::Formula;
use lcpstar::classes::scan::Space;
use lcpstar::{Certify, Control, Method, Options, all_solutions, is_in_class, ppt, solve, solve_batch, solve_sparse};

fn main() {
    divan::main();
}

/// `A = B B' / n + I + (U - U')`, positive definite, and q of both signs.
fn problem(n: usize) -> (Vec<f64>, Vec<f64>) {
    let mut rng = fastrand::Rng::with_seed(n as u64);
    let mut draw = |count: usize| -> Vec<f64> { (0..count).map(|_| 2.0 * rng.f64() - 1.0).collect() };
    let (b, u, q) = (draw(n * n), draw(n * n), draw(n));
    let dot = |i: usize, j: usize| (0..n).map(|k| b[i * n + k] * b[j * n + k]).sum::<f64>();
    let entry = |i: usize, j: usize| dot(i, j) / n as f64 + f64::from(u8::from(i == j)) + u[i * n + j] - u[j * n + i];
    ((0..n * n).map(|at| entry(at / n, at % n)).collect(), q)
}

/// The obstacle problem on a line.
fn line(n: usize) -> lcpstar::SparseLcp {
    let mut dense = vec![0.0; n * n];
    for i in 0..n {
        dense[i * n + i] = 2.0;
        if i > 0 {
            dense[i * n + i - 1] = -1.0;
            dense[(i - 1) * n + i] = -1.0;
        }
    }
    let q = (0..n).map(|i| (7.0 * i as f64 / n as f64).sin()).collect();
    lcpstar::SparseLcp::from_dense(&lcpstar::Lcp::new(n, dense, q).expect("valid"))
}

#[divan::bench(args = [4, 8, 16, 32, 64, 128, 250, 500, 1000])]
fn solve_dense(bencher: Bencher<'_, '_>, n: usize) {
    let ((a, q), options) = (problem(n), Options::default());
    bencher.bench(|| solve(black_box(&a), &q, &options));
}

#[divan::bench(args = [500, 2000])]
fn solve_tridiagonal(bencher: Bencher<'_, '_>, n: usize) {
    let (lcp, options) = (line(n), Options::default());
    bencher.bench(|| solve_sparse(black_box(&lcp), &options));
}

/// 1000 problems with one A.
#[divan::bench(args = [4, 8, 16, 32, 64])]
fn batch_of_1000(bencher: Bencher<'_, '_>, n: usize) {
    let ((a, _), options) = (problem(n), Options::default().threads(1));
    let mut rng = fastrand::Rng::with_seed(1);
    let q: Vec<f64> = (0..1000 * n).map(|_| 2.0 * rng.f64() - 1.0).collect();
    bencher.bench(|| solve_batch(black_box(&a), &q, n, &options));
}

#[divan::bench(args = [8, 32, 128, 500])]
fn pivot_transform(bencher: Bencher<'_, '_>, n: usize) {
    let ((a, q), alpha) = (problem(n), (0..n / 2).collect::<Vec<_>>());
    bencher.bench(|| ppt(black_box(&a), &q, &alpha));
}

/// One iteration, with the factorisation that it needs and the judge of its point.
#[divan::bench(args = [32, 128, 500])]
fn interior_point_iteration(bencher: Bencher<'_, '_>, n: usize) {
    let (a, q) = problem(n);
    let method =
        Method::InteriorPoint(lcpstar::methods::interior_point::Settings { finish: false, ..Default::default() });
    let options = Options::default().method(method).max_iterations(1);
    bencher.bench(|| solve(black_box(&a), &q, &options));
}

#[divan::bench(args = [8, 32, 64, 128])]
fn exact_proof(bencher: Bencher<'_, '_>, n: usize) {
    let ((a, q), options) = (problem(n), Options::default().certify(Certify::Exact));
    bencher.bench(|| solve(black_box(&a), &q, &options));
}

/// A triangle with ones on its diagonal: a P-matrix without help from a bound on rows or a form, so that every index set is looked at.
fn integers(n: usize) -> Vec<f64> {
    let entry = |i: usize, j: usize| f64::from((7 * i + 3 * j) as u32 % 11) - 5.0;
    (0..n * n)
        .map(|at| (at / n, at % n))
        .map(|(i, j)| if i > j { entry(i, j) } else { f64::from(u8::from(i == j)) })
        .collect()
}

#[divan::bench(args = [8, 12, 16, 20])]
fn is_p(bencher: Bencher<'_, '_>, n: usize) {
    let a = integers(n);
    bencher.bench(|| is_in_class(black_box(&a), n, "P", None));
}

#[divan::bench(args = [8, 12, 16])]
fn is_e0(bencher: Bencher<'_, '_>, n: usize) {
    let a = integers(n);
    bencher.bench(|| is_in_class(black_box(&a), n, "E0", None));
}

/// P => Q on 3 x 3 matrices with entries -1, 0, 1.
#[divan::bench]
fn explore(bencher: Bencher<'_, '_>) {
    let space = Space { n: 3, entries: vec![0, 1, -1], up_to_permutation: true, seed: None };
    let (p, q) = (Formula::In(Class::P), Formula::In(Class::Q));
    bencher.bench(|| lcpstar::explore::explore(black_box(&space), &p, &q, 0..19_683, 1, &Control::default()));
}

#[divan::bench(args = [4, 8, 12])]
fn all_faces(bencher: Bencher<'_, '_>, n: usize) {
    let (a, q) = problem(n);
    bencher.bench(|| all_solutions(black_box(&a), &q, None));
}
