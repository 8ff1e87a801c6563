//! The functions on slices beside the ones that they stand for.
#![allow(missing_docs)]

use lcpstar::prelude::*;
use lcpstar::{Certify, LcpError, classify, is_in_class, ppt};
use std::time::Duration;

#[test]
fn a_batch_is_as_many_calls_of_solve() {
    let mut rng = fastrand::Rng::with_seed(7);
    for n in [1, 3, 9, 20] {
        let a: Vec<f64> =
            (0..10 * n * n).map(|k| 2.0 * rng.f64() - 1.0 + f64::from(u8::from(k % (n * n) % (n + 1) == 0))).collect();
        let q: Vec<f64> = (0..10 * n).map(|_| 2.0 * rng.f64() - 1.0).collect();
        let batch = solve_batch(&a, &q, n, &Options::default()).expect("valid");
        for k in 0..10 {
            let alone =
                solve(&a[k * n * n..(k + 1) * n * n], &q[k * n..(k + 1) * n], &Options::default()).expect("valid");
            assert_eq!(batch.status(k), alone.status(), "n = {n}, k = {k}");
            for i in 0..n {
                let at = |j: usize| a[(k * n + i) * n + j] * batch.z(k)[j];
                let w = q[k * n + i] + (0..n).map(at).sum::<f64>();
                assert!((batch.w(k)[i] - w).abs() <= 1e-12 * (1.0 + w.abs()), "n = {n}, k = {k}");
            }
            if batch.status(k) == Status::Solved {
                assert!(batch.natural_residual(k) < 1e-8);
                assert!((0..n).all(|i| batch.z(k)[i] <= 0.0 || batch.alpha(k).any(|j| j == i)));
            }
        }
    }
}

#[test]
fn a_batch_refuses_what_it_would_not_heed() {
    let (a, q) = ([1.0], [-1.0, 1.0]);
    for (options, name) in [
        (Options::default().certify(Certify::Exact), "certify"),
        (Options::default().max_iterations(3), "max_iterations"),
        (Options::default().time_limit(Duration::from_secs(1)), "time_limit"),
    ] {
        assert_eq!(solve_batch(&a, &q, 1, &options).err(), Some(LcpError::NotTaken { name, by: "solve_batch" }));
    }
}

#[test]
fn wrong_lengths_are_named() {
    let wrong = |name, expected, found| Some(LcpError::WrongLength { name, expected, found });
    let options = Options::default();
    assert_eq!(solve(&[1.0, 2.0], &[1.0], &options).err(), wrong("A", 1, 2));
    assert_eq!(solve_batch(&[1.0; 4], &[1.0; 3], 2, &options).err(), wrong("q", 2, 3));
    assert_eq!(solve_batch(&[1.0; 8], &[1.0; 6], 2, &options).err(), wrong("A", 12, 8));
    assert_eq!(solve_batch(&[1.0; 4], &[1.0; 4], 2, &options.clone().z0(vec![1.0])).err(), wrong("z0", 4, 1));
    assert_eq!(solve_batch(&[], &[1.0], 0, &options).err(), wrong("q", 0, 1));
    assert!(solve_batch(&[], &[], 0, &options).expect("no problem").is_empty());
    assert_eq!(is_in_class(&[1.0; 3], 2, "P", None).err(), wrong("A", 4, 3));
    assert!(matches!(is_in_class(&[1.0], 1, "p", None), Err(LcpError::UnknownName { .. })));
    assert!(matches!(classify(&[], 0, None), Err(LcpError::OutOfRange { .. })));
    assert!(matches!(classify(&[f64::NAN], 1, None), Err(LcpError::NotFinite { .. })));
    assert!(matches!(ppt(&[0.0], &[1.0], &[0]), Err(LcpError::SingularBlock { .. })));
}

#[test]
fn classes_are_decided_on_the_doubles_themselves() {
    // det = 1 - (1 +- eps)^2: one unit in the last place decides, and so it does at both ends of the range.
    for scale in [1.0, 1e300, 1e-300] {
        for (off, expected) in [(1.0 - f64::EPSILON, true), (1.0, false)] {
            let a = [scale, off * scale, off * scale, scale];
            assert_eq!(is_in_class(&a, 2, "P", None), Ok(Some(expected)), "{scale} {off}");
        }
    }
}

#[test]
fn a_search_that_runs_out_of_time_says_nothing() {
    let n = 26;
    let a: Vec<f64> =
        (0..n * n).map(|k| if k % (n + 1) == 0 { 1.0 } else { f64::from(u8::from(k % n > k / n)) * 7.0 }).collect();
    assert_eq!(is_in_class(&a, n, "E0", Some(Duration::from_millis(1))), Ok(None));
}

/// The README shows the crate that `make test-rust` runs.
#[test]
fn the_readme_shows_the_crate_outside_the_workspace() {
    let (readme, program) = (include_str!("../README.md"), include_str!("../../../examples/rust-crate/src/main.rs"));
    assert!(readme.contains(program));
    assert!(program.lines().count() <= 10);
}
