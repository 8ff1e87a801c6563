//! What the fast verdicts accept, `certify` accepts: on points near solutions, in any units, with the errors that each view of
//! the verdict is there for.

use super::certify;
use crate::problem::Lcp;
use crate::scaling::{Equilibrated, times_power_of_two};
use crate::small::lane::{F64x8, Lane, Mask};
use crate::small::verify::verify;
use crate::small::verify_point;
use crate::solution::Candidate;
use crate::status::{Status, Termination};
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

fn is_certified(n: usize, point: &Point, tol: f64) -> bool {
    let lcp = Lcp::new(n, point.a.clone(), point.q.clone()).expect("finite");
    let problem = Equilibrated::new(&lcp);
    let z = problem.scaling.z_from_caller(&point.z);
    let candidate = Candidate::point(z, Termination::Converged, 0);
    certify(&problem, candidate, "test", tol).status == Status::Solved
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
        let verdict = verify::<Lanes, 0>(n, &a, &q, &z, &w, tol);
        for (l, point) in points.iter().enumerate() {
            let alone = verify_point(&point.a, &point.q, tol, &point.z, &mut vec![0.0; n]);
            let certified = is_certified(n, point, tol);
            assert!(
                certified || !verdict.solved.get(l),
                "lane: tol {tol:e}, {:?} {:?} {:?}",
                point.a,
                point.q,
                point.z
            );
            assert!(certified || alone.is_none(), "alone: tol {tol:e}, {:?} {:?} {:?}", point.a, point.q, point.z);
            *(if alone.is_some() { &mut accepted } else { &mut refused }) += 1;
        }
    }
    assert!(accepted > 4000 && refused > 4000, "{accepted} {refused}");
}
