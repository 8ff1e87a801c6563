//! A batch allocates per thread, never per problem.

mod counting;

use counting::ALLOCATIONS;
use lcpstar::batch::{Alpha, Guess, Numbers, Output, Problems, Settings, Source, solve_batch};
use lcpstar::driver::Method;
use lcpstar::small;
use std::sync::atomic::Ordering;

/// Numbers in [-1, 1), reproducible.
fn numbers(count: usize) -> Vec<f64> {
    let mut rng = fastrand::Rng::with_seed(1);
    (0..count).map(|_| 2.0 * rng.f64() - 1.0).collect()
}

/// `B B'` with `rank` columns plus `shift I`, and a `q` for which `z = max(x, 0)` is a solution.
fn problems(n: usize, rank: usize, shift: f64, count: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut a, mut q) = (Vec::new(), Vec::new());
    let random = numbers(count * (n * rank + n));
    for part in random.chunks(n * rank + n) {
        let (b, x) = part.split_at(n * rank);
        let at = |i: usize, j: usize| {
            (0..rank).map(|k| b[i * rank + k] * b[j * rank + k]).sum::<f64>() + if i == j { shift } else { 0.0 }
        };
        let matrix: Vec<f64> = (0..n * n).map(|e| at(e / n, e % n)).collect();
        for i in 0..n {
            let az: f64 = (0..n).map(|j| matrix[i * n + j] * x[j].max(0.0)).sum();
            q.push((-x[i]).max(0.0) - az);
        }
        a.extend(matrix);
    }
    (a, q)
}

fn allocations(n: usize, a: &[f64], q: &[f64], count: usize, guess: Guess<'_>) -> (usize, Vec<u8>, Vec<u64>) {
    let (a, q) = (&a[..count * n * n], &q[..count * n]);
    let (mut z, mut w) = (vec![0.0; count * n], vec![0.0; count * n]);
    let (mut status, mut method, mut iterations) = (vec![9; count], vec![0; count], vec![0; count]);
    let (mut residual, mut natural, mut masks) = (vec![0.0; count], vec![0.0; count], vec![0; count]);
    let output = Output {
        z: &mut z,
        w: &mut w,
        status: &mut status,
        method: &mut method,
        iterations: &mut iterations,
        residual: &mut residual,
        natural_residual: &mut natural,
        alpha: Alpha::Masks(&mut masks),
    };
    let settings = Settings { method: &Method::Auto, tol: 1e-9, threads: 1, guess, interrupted: None };
    let (a, q) = (Numbers::Double(a), Numbers::Double(q));
    let problems = Problems { n, count, a, a_source: Source::Each, q, q_source: Source::Each };
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    assert_eq!(solve_batch(&problems, &settings, output), Ok(true));
    (ALLOCATIONS.load(Ordering::Relaxed) - before, status, masks)
}

/// One test: the counter sees every thread of the process.
#[test]
fn allocations_do_not_grow_with_the_batch() {
    for (n, rank, shift) in [(4, 4, 0.5), (8, 4, 0.0), (12, 12, 0.5), (12, 6, 0.0), (24, 12, 0.0), (40, 40, 0.5)] {
        let (a, q) = problems(n, rank, shift, 1000);
        let (few, ..) = allocations(n, &a, &q, 100, Guess::None);
        let (many, status, masks) = allocations(n, &a, &q, 1000, Guess::None);
        assert!(status.iter().all(|&s| s == 0), "n = {n}, rank {rank}: not all solved");
        assert!(many <= few + 4, "n = {n}, rank {rank}: {few} allocations for 100 problems, {many} for 1000");
        if n <= 32 && shift > 0.0 {
            let (warm, status, _) = allocations(n, &a, &q, 1000, Guess::Masks(&masks));
            assert!(status.iter().all(|&s| s == 0) && warm <= few + 4, "n = {n}: {warm} allocations warm");
        }
    }
    let (a, q) = problems(12, 12, 0.5, 100);
    let (mut z, mut w) = ([0.0; 12], [0.0; 12]);
    let mut is_solved = |k: usize| {
        let (a, q) = (&a[k * 144..(k + 1) * 144], &q[k * 12..(k + 1) * 12]);
        matches!(small::solve(a, q, 1e-9, &mut z, &mut w), small::Answer::Solved { .. })
    };
    assert!(is_solved(0));
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    let solved = (0..100).filter(|&k| is_solved(k)).count();
    assert_eq!((solved, ALLOCATIONS.load(Ordering::Relaxed) - before), (100, 0));
}
