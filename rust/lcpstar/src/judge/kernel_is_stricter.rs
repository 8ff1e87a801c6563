//! What the kernels accept, the judge accepts, and the residuals are the same: on points near solutions, in any units, with the
//! errors that each test of the rule is there for.

use super::judge;
use crate::equilibrate::Equilibrated;
use crate::member::Member;
use crate::problem::Lcp;
use crate::residual::{equilibrated_residual, natural_residual};
use crate::scaling::times_power_of_two;
use crate::small::lane::{F64x8, Lane, Mask};
use crate::small::scales::Scales;
use crate::small::verify::verify;
use crate::small::verify_point;
use crate::solution::{Candidate, Solution};
use crate::status::Termination;
use fastrand::Rng;

type Lanes = F64x8<{ cfg!(target_arch = "aarch64") }>;

struct Point {
    a: Vec<f64>,
    q: Vec<f64>,
    z: Vec<f64>,
}

/// LCP(q, A) with a planted solution, and a point off it.
fn point_near_a_solution(rng: &mut Rng, n: usize) -> Point {
    let entry = |rng: &mut Rng| if rng.u8(0..4) == 0 { 0.0 } else { f64::from(rng.i8(-3..4)) + 0.1 * rng.f64() };
    let mut a: Vec<f64> = (0..n * n).map(|_| entry(rng)).collect();
    let mut z: Vec<f64> = (0..n).map(|_| (4.0 * rng.f64() - 2.0).max(0.0)).collect();
    if rng.bool() {
        let large = 10_f64.powi(rng.i32(0..14));
        z.iter_mut().for_each(|z| *z *= large);
    }
    let mut q: Vec<f64> = (0..n)
        .map(|i| {
            let sum: f64 = (0..n).map(|j| a[i * n + j] * z[j]).sum();
            let w = if z[i] > 0.0 || rng.bool() { 0.0 } else { rng.f64() };
            w - sum
        })
        .collect();
    disturb(rng, &mut q, &mut z);
    let spread = rng.i32(1..60);
    let (rows, columns): (Vec<i32>, Vec<i32>) =
        (0..n).map(|_| (rng.i32(-spread..spread), rng.i32(-spread..spread))).unzip();
    let size = rng.i32(-40..40);
    for i in 0..n {
        q[i] = times_power_of_two(q[i], rows[i] + size);
        z[i] = times_power_of_two(z[i], size - columns[i]);
        for j in 0..n {
            a[i * n + j] = times_power_of_two(a[i * n + j], rows[i] + columns[j]);
        }
    }
    Point { a, q, z }
}

/// An error in q or z, of any size, in one place or everywhere; or none.
fn disturb(rng: &mut Rng, q: &mut [f64], z: &mut [f64]) {
    let k = rng.usize(0..q.len());
    let error = 10_f64.powf(-17.0 * rng.f64());
    let largest = q.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    match rng.u8(0..6) {
        0 => q[k] -= error * largest,
        1 => q[k] *= 1.0 + error,
        2 => z[k] *= 1.0 + error,
        3 => z.iter_mut().for_each(|z| *z *= 1.0 + error * (rng.f64() - 0.5)),
        4 => z[k] += error,
        _ => {}
    }
}

fn judged(n: usize, point: &Point, tol: f64) -> Solution {
    let lcp = Lcp::new(n, point.a.clone(), point.q.clone()).expect("finite");
    let problem = Equilibrated::new(&lcp);
    let z = problem.scaling.z_from_caller(&point.z);
    judge(&problem, Candidate::point(z, Termination::Converged, 0), Member::Auto, tol)
}

/// Both residuals of the point, in double-doubles, with the rounding of plain sums.
fn residuals(n: usize, point: &Point) -> [(f64, f64); 2] {
    let lcp = Lcp::new(n, point.a.clone(), point.q.clone()).expect("finite");
    let problem = Equilibrated::new(&lcp);
    let rounding = |m: &[f64]| (n as f64 + 2.0) * f64::EPSILON * m.iter().fold(0.0, |a: f64, &b| a.max(b));
    let z = problem.scaling.z_from_caller(&point.z);
    let (scaled_w, scaled_m) = crate::residual::slack(&problem.lcp, &z);
    let (w, m) = crate::residual::slack(&lcp, &point.z);
    let largest = z.iter().fold(1.0, |a: f64, &b| a.max(b));
    [
        (equilibrated_residual(&z, &scaled_w), rounding(&scaled_m) / largest),
        (natural_residual(&point.z, &w), rounding(&m)),
    ]
}

#[test]
fn what_is_accepted_is_certified() {
    let mut rng = Rng::with_seed(20);
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..4000 {
        let n = rng.usize(1..12);
        let tol = 10_f64.powi(-rng.i32(3..14));
        let points: Vec<Point> = (0..8).map(|_| point_near_a_solution(&mut rng, n)).collect();
        let lanes = |of: fn(&Point) -> &[f64], count: usize| -> Vec<Lanes> {
            (0..count).map(|i| Lanes::from_slice(&points.iter().map(|p| of(p)[i]).collect::<Vec<f64>>())).collect()
        };
        let (a, q, z) = (lanes(|p| &p.a, n * n), lanes(|p| &p.q, n), lanes(|p| &p.z, n));
        let w: Vec<Lanes> = (0..n).map(|i| (0..n).fold(q[i], |sum, j| sum.add_product(a[i * n + j], z[j]))).collect();
        let mut scales = Scales::default();
        scales.resize(n);
        let verdict = verify::<Lanes, 0>(n, &a, &q, &z, &w, tol, &mut scales, Mask::ALL);
        for (l, point) in points.iter().enumerate() {
            let alone = verify_point(&point.a, &point.q, tol, &point.z, &mut vec![0.0; n]);
            *(if alone.is_some() { &mut accepted } else { &mut refused }) += 1;
            for found in [verdict.accepted(l), alone].into_iter().flatten() {
                assert!(judged(n, point, tol).is_solved(), "tol {tol:e}, {:?} {:?} {:?}", point.a, point.q, point.z);
                let stated = [found.residual(), found.natural_residual()];
                for (stated, (measured, rounding)) in stated.into_iter().zip(residuals(n, point)) {
                    assert!((stated - measured).abs() <= rounding, "{stated:e} {measured:e} {rounding:e}");
                }
            }
        }
    }
    assert!(accepted > 4000 && refused > 4000, "{accepted} {refused}");
}
