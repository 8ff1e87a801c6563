//! The pivot loop of Lemke's method and the dense interior point loop do not allocate: more iterations, the same number of
//! allocations.

mod counting;

use counting::ALLOCATIONS;
use lcpstar::methods::interior_point::{self, interior_point};
use lcpstar::methods::lemke::{Settings, lemke};
use lcpstar::{Control, Lcp, Termination};
use std::sync::atomic::Ordering;

/// Murty's matrix: 2^n - 1 pivots with d = e. [Mur78]
fn murty(n: usize) -> Lcp {
    let entry = |i: usize, j: usize| if i == j { 1.0 } else { 2.0 * f64::from(u8::from(j < i)) };
    let a = (0..n * n).map(|k| entry(k / n, k % n)).collect();
    let q = (1..=n).map(|i| -(0..i).map(|k| 2f64.powi((n - k) as i32)).sum::<f64>()).collect();
    Lcp::new(n, a, q).expect("valid")
}

/// Pivots and allocations of one run that stops after `limit` pivots.
fn run(lcp: &Lcp, limit: usize) -> (usize, usize) {
    let control = Control { max_iterations: Some(limit), ..Control::default() };
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    let found = lemke::<f64>(lcp, &Settings::default(), &control);
    let allocations = ALLOCATIONS.load(Ordering::Relaxed) - before;
    assert_eq!(found.termination, Termination::IterationLimit);
    (found.iterations, allocations)
}

/// `B B' + I` with small integers in B, plus `skew` times a skew matrix.
fn definite(n: usize, skew: f64) -> Lcp {
    let b = |i: usize, k: usize| ((i * 7 + k * 13 + i * k) % 11) as f64 - 5.0;
    let entry = |i: usize, j: usize| {
        let product: f64 = (0..n).map(|k| b(i, k) * b(j, k)).sum();
        product + f64::from(u8::from(i == j)) + skew * (b(i, j) - b(j, i))
    };
    let a = (0..n * n).map(|ij| entry(ij / n, ij % n)).collect();
    Lcp::new(n, a, (0..n).map(|i| ((i * 5) % 7) as f64 - 4.0).collect()).expect("valid")
}

/// Iterations and allocations of the interior point method without finish, which stops after `limit` iterations.
fn run_interior(lcp: &Lcp, limit: usize) -> (usize, usize) {
    let control = Control { max_iterations: Some(limit), ..Control::default() };
    let settings = interior_point::Settings { tol: f64::MIN_POSITIVE, finish: false, z0: None };
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    let found = interior_point(lcp, &settings, &control);
    (found.iterations, ALLOCATIONS.load(Ordering::Relaxed) - before)
}

/// One test: the counter is shared by the threads of the test harness.
#[test]
fn iterations_scale_and_allocations_do_not() {
    for lcp in [definite(30, 0.0), definite(30, 0.5)] {
        run_interior(&lcp, 1);
        let (few, many) = (run_interior(&lcp, 2), run_interior(&lcp, 9));
        assert_eq!((few.0, many.0), (2, 9));
        assert_eq!(many.1, few.1, "allocations of 9 and of 2 iterations");
    }
    pivots_scale_and_allocations_do_not();
}

fn pivots_scale_and_allocations_do_not() {
    let lcp = murty(16);
    run(&lcp, 1);
    let (few, many) = (run(&lcp, 10), run(&lcp, 10_000));
    assert_eq!((few.0, many.0), (10, 10_000));
    assert!(few.1 > 0, "the counter counts");
    assert!(many.1 <= few.1 + 4, "{} allocations for 10 pivots, {} for 10 000", few.1, many.1);
}
