//! What every answer must satisfy, in exact arithmetic on the numbers that were given.

use crate::exact::{Dyadic, form, power_of_two};
use crate::input::Problem;
use lcpstar::exact::dyadic::RationalVec;
use lcpstar::scaling::Equilibrated;
use lcpstar::{Certificate, Lcp, Solution, Status};
use std::cmp::Ordering;

const EPS: f64 = f64::EPSILON;

/// The limits a call was given.
pub struct Limits {
    pub max_iterations: Option<usize>,
    pub may_run_out_of_time: bool,
    pub exact: bool,
}

pub fn check(problem: &Problem, solution: &Solution, tol: f64, limits: &Limits) {
    let n = problem.n;
    assert_eq!((solution.z.len(), solution.w.len()), (n, n), "lengths");
    no_nan(solution);
    assert!(solution.alpha.iter().all(|&i| i < n), "alpha {:?}", solution.alpha);
    assert!(!solution.message.is_empty());
    if let Some(limit) = limits.max_iterations
        && !limits.exact
    {
        assert!(solution.iterations <= limit, "{} iterations of {limit} in {}", solution.iterations, solution.method);
    }
    match solution.status {
        Status::Solved => {
            check_point(problem, &solution.z, &solution.w, solution.natural_residual, tol);
            check_residual(problem, &solution.z, solution.residual, tol, limits.exact);
        }
        Status::Infeasible => check_infeasible(problem, solution),
        Status::SecondaryRay => assert!(solution.ray.is_some(), "a ray without a ray"),
        Status::MaxIterations | Status::NumericalBreakdown => {}
        Status::TimeLimit => assert!(limits.may_run_out_of_time, "nobody set a time limit"),
    }
    check_certificate(problem, solution);
}

/// As [`check`], for sparse problems, whose residual is that of `D A D`.
pub fn check_sparse(problem: &Problem, solution: &Solution, tol: f64) {
    no_nan(solution);
    if solution.status == Status::Solved {
        check_point(problem, &solution.z, &solution.w, solution.natural_residual, tol);
    }
    check_certificate(problem, solution);
}

fn no_nan(solution: &Solution) {
    assert!(solution.z.iter().all(|z| z.is_finite() && *z >= 0.0), "z = {:?}", solution.z);
    assert!(!solution.w.iter().any(|w| w.is_nan()), "w = {:?}", solution.w);
    assert!(!solution.residual.is_nan() && !solution.natural_residual.is_nan(), "residual");
    if let Some(ray) = &solution.ray {
        let numbers = ray.z.iter().chain(&ray.z_hat).chain(&ray.w_hat).chain(&ray.d).chain([&ray.z0, &ray.z0_hat]);
        assert!(!numbers.clone().any(|x| x.is_nan()), "{ray:?}");
    }
}

/// `w = A z + q` to rounding, and in every row `|min(z, w)| <= 10 tol max|q| + 8 eps (|A||z| + |q|)`.
pub fn check_point(problem: &Problem, z: &[f64], w: &[f64], natural_residual: f64, tol: f64) {
    let n = problem.n;
    let exact_z: Vec<Dyadic> = z.iter().map(|&x| Dyadic::new(x)).collect();
    let largest_q = problem.q.iter().fold(0.0, |m: f64, q| m.max(q.abs()));
    let allowed = Dyadic::new(10.0 * tol).times(&Dyadic::new(largest_q));
    let tiny = Dyadic::new(f64::MIN_POSITIVE).times_power_of_two(8);
    let mut natural = Dyadic::zero();
    let mut rounding = tiny.clone();
    for i in 0..n {
        let row = &problem.a[i * n..(i + 1) * n];
        let exact_w = form(row, &exact_z, &Dyadic::new(problem.q[i]));
        let size = row
            .iter()
            .zip(&exact_z)
            .fold(Dyadic::new(problem.q[i]).abs(), |m, (&a, z)| m.plus(&Dyadic::new(a).times(z).abs()));
        let smallest = exact_z[i].min(&exact_w).abs();
        let limit = allowed.plus(&size.times(&Dyadic::new(9.0 * EPS))).plus(&tiny);
        assert!(
            smallest.at_most(&limit),
            "row {i}: |min(z, w)| = {:e}, allowed {:e}, z = {z:?}",
            smallest.about(),
            limit.about()
        );
        let error = size.times(&Dyadic::new((n as f64 + 4.0) * EPS)).plus(&tiny);
        let overflow = exact_w.abs().plus(&error).at_most(&Dyadic::new(f64::MAX));
        if overflow || w[i].is_finite() {
            assert!(w[i].is_finite(), "w[{i}] = {} is {:e}", w[i], exact_w.about());
            assert!(
                exact_w.minus(&Dyadic::new(w[i])).abs().at_most(&error),
                "w[{i}] = {:e} is {:e}",
                w[i],
                exact_w.about()
            );
        }
        rounding = rounding.max(&error);
        natural = natural.max(&smallest);
    }
    if natural_residual.is_finite() {
        let stated = Dyadic::new(natural_residual).plus(&rounding);
        assert!(natural.at_most(&stated), "natural residual {:e}, stated {natural_residual:e}", natural.about());
    }
}

/// The scale-free residual, exactly, on the problem equilibrated by powers of two.
fn check_residual(problem: &Problem, z: &[f64], stated: f64, tol: f64, proved: bool) {
    assert!(stated <= tol || proved, "solved with residual {stated:e} > tol {tol:e}");
    let lcp = Lcp::new(problem.n, problem.a.clone(), problem.q.clone()).expect("finite");
    let scaling = Equilibrated::new(&lcp).scaling;
    let n = problem.n;
    let exact_z: Vec<Dyadic> = z.iter().map(|&x| Dyadic::new(x)).collect();
    let mut largest = power_of_two(0);
    let mut worst = Dyadic::zero();
    for i in 0..n {
        let w = form(&problem.a[i * n..(i + 1) * n], &exact_z, &Dyadic::new(problem.q[i]));
        let w = w.times_power_of_two(i64::from(scaling.rows[i]) + i64::from(scaling.q));
        let z = exact_z[i].times_power_of_two(i64::from(scaling.q) - i64::from(scaling.columns[i]));
        largest = largest.max(&z);
        worst = worst.max(&z.min(&w).abs());
    }
    // Rounding of z itself: 8 eps covers what the caller's units may have cost a subnormal z.
    let limit = largest.times(&Dyadic::new(tol * 1.0001 + if proved { 64.0 * n as f64 * EPS } else { 8.0 * EPS }));
    assert!(worst.at_most(&limit), "residual {:e} of {:e}, tol {tol:e}", worst.about(), largest.about());
    let absolute = tol.max(1e-6) * 1.0001;
    assert!(proved || worst.at_most(&Dyadic::new(absolute)), "absolute residual {:e}", worst.about());
}

/// `y >= 0, q'y < 0, A'y <= 0`, exactly or within the documented rounding: any feasible z would have norm above 10^10.
fn check_infeasible(problem: &Problem, solution: &Solution) {
    let Some(Certificate::Infeasible { y, exact }) = &solution.certificate else { panic!("infeasible without proof") };
    if exact.is_some() {
        return; // see check_certificate
    }
    let n = problem.n;
    assert!(y.iter().all(|y| y.is_finite() && *y >= 0.0), "y = {y:?}");
    let lcp = Lcp::new(n, problem.a.clone(), problem.q.clone()).expect("finite");
    let scaling = Equilibrated::new(&lcp).scaling;
    let exact_y: Vec<Dyadic> = y.iter().map(|&y| Dyadic::new(y)).collect();
    let value = form(&problem.q, &exact_y, &Dyadic::zero());
    assert_eq!(value.sign(), Ordering::Less, "q'y = {:e}", value.about());
    let value = value.abs().times_power_of_two(i64::from(scaling.q));
    for j in 0..n {
        let column: Vec<f64> = (0..n).map(|i| problem.a[i * n + j]).collect();
        let sum = form(&column, &exact_y, &Dyadic::zero());
        if sum.sign() == Ordering::Greater {
            let sum = sum.times_power_of_two(i64::from(scaling.columns[j]));
            let bound = sum.times(&Dyadic::new(0.99e10));
            assert!(bound.at_most(&value), "(A'y)[{j}] = {:e} against q'y = -{:e}", sum.about(), value.about());
        }
    }
}

fn check_certificate(problem: &Problem, solution: &Solution) {
    match &solution.certificate {
        Some(Certificate::Solution { exact: Some(z), .. }) => {
            assert!(matches!(solution.status, Status::Solved | Status::NumericalBreakdown)); // its rounding may miss tol
            assert!(solves_exactly(problem, z), "the exact certificate is no solution");
        }
        Some(Certificate::Infeasible { exact: Some(y), .. }) => {
            assert_eq!(solution.status, Status::Infeasible);
            assert!(is_farkas(problem, y), "the exact certificate is no Farkas vector");
        }
        Some(Certificate::NotSufficient(found)) => assert!(refutes_sufficiency(problem, &found.x, found.transposed)),
        _ => {}
    }
}

fn numbers(v: &RationalVec) -> Vec<Dyadic> {
    assert_eq!(Dyadic::integer(&v.denominator).sign(), Ordering::Greater, "denominator");
    v.numerators.iter().map(Dyadic::integer).collect()
}

/// `z >= 0, w >= 0, z'w = 0`, times the denominator.
pub fn solves_exactly(problem: &Problem, z: &RationalVec) -> bool {
    let (n, x, t) = (problem.n, numbers(z), Dyadic::integer(&z.denominator));
    x.len() == n
        && (0..n).all(|i| {
            let w = form(&problem.a[i * n..(i + 1) * n], &x, &Dyadic::new(problem.q[i]).times(&t));
            x[i].sign() != Ordering::Less && w.sign() != Ordering::Less && (x[i].is_zero() || w.is_zero())
        })
}

/// A direction that stays in the solution set: `r >= 0, A r >= 0, r'A r = 0`.
pub fn is_direction(problem: &Problem, r: &RationalVec) -> bool {
    let (n, x) = (problem.n, numbers(r));
    (0..n).all(|i| {
        let w = form(&problem.a[i * n..(i + 1) * n], &x, &Dyadic::zero());
        x[i].sign() != Ordering::Less && w.sign() != Ordering::Less && (x[i].is_zero() || w.is_zero())
    })
}

fn is_farkas(problem: &Problem, y: &RationalVec) -> bool {
    let (n, y) = (problem.n, numbers(y));
    let column = |j: usize| (0..n).map(|i| problem.a[i * n + j]).collect::<Vec<_>>();
    y.len() == n
        && y.iter().all(|y| y.sign() != Ordering::Less)
        && form(&problem.q, &y, &Dyadic::zero()).sign() == Ordering::Less
        && (0..n).all(|j| form(&column(j), &y, &Dyadic::zero()).sign() != Ordering::Greater)
}

fn refutes_sufficiency(problem: &Problem, x: &RationalVec, transposed: bool) -> bool {
    let (n, x) = (problem.n, numbers(x));
    let row = |i: usize| -> Vec<f64> {
        (0..n).map(|j| if transposed { problem.a[j * n + i] } else { problem.a[i * n + j] }).collect()
    };
    let signs: Vec<Ordering> = (0..n).map(|i| x[i].times(&form(&row(i), &x, &Dyadic::zero())).sign()).collect();
    !signs.contains(&Ordering::Greater) && signs.contains(&Ordering::Less)
}
