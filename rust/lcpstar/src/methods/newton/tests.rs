use super::*;
use crate::iterative::{Dense, Sparse};
use crate::problem::Lcp;
use crate::sparse::SparseLcp;

fn solve(lcp: &Lcp, z0: Option<&[f64]>) -> Candidate {
    let goal = Goal::plain(1e-10, lcp.q());
    newton(&Dense::new(lcp), &goal, &Settings::default(), z0, &Control::default())
}

/// The ring of [BG12]: a P-matrix on which the active set method alone visits three sets for ever.
fn ring() -> Lcp {
    Lcp::new(3, vec![1.0, 0.0, 2.0, 2.0, 1.0, 0.0, 0.0, 2.0, 1.0], vec![-1.0; 3]).expect("valid")
}

#[test]
fn the_cycle_of_the_active_set_method_is_left() {
    let lcp = ring();
    let found = solve(&lcp, Some(&[1.0, 0.0, 0.0]));
    assert_eq!(found.termination, Termination::Converged);
    assert!(found.z.iter().all(|z| (z - 1.0 / 3.0).abs() < 1e-10), "{:?}", found.z);
}

#[test]
fn without_the_safeguard_it_would_cycle() {
    let lcp = ring();
    let matrix = Dense::new(&lcp);
    let goal = Goal::plain(1e-10, lcp.q());
    let mut best = Incumbent::new(&goal, 3);
    let (z, w) = start(&matrix, Some(&[1.0, 0.0, 0.0]));
    let control = Control::default();
    let mut active = ActiveSet::new(Support::new(&matrix, &control), z, w, usize::MAX);
    assert!((0..50).all(|_| matches!(active.advance(&matrix, &mut best), Step::Settling)));
}

#[test]
fn a_nearly_right_start_takes_one_factorisation() {
    let n = 40;
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 2.1,
        1 => -1.0,
        _ => 0.0,
    };
    let a = (0..n * n).map(|k| entry(k / n, k % n)).collect();
    let lcp = Lcp::new(n, a, (0..n).map(|i| ((i * 7) % 11) as f64 / 6.0 - 0.8).collect()).expect("valid");
    let cold = solve(&lcp, None);
    assert_eq!(cold.termination, Termination::Converged);
    let near: Vec<f64> = cold.z.iter().map(|z| z * 1.01).collect();
    assert_eq!(solve(&lcp, Some(&near)).iterations, 1);
}

#[test]
fn a_singular_matrix_is_solved() {
    let lcp = Lcp::new(2, vec![1.0, 1.0, 1.0, 1.0], vec![-2.0, -2.0]).expect("valid");
    assert_eq!(solve(&lcp, None).termination, Termination::Converged);
}

#[test]
fn no_solution_is_a_breakdown_or_a_limit() {
    let lcp = Lcp::new(2, vec![1.0, -1.0, -1.0, 1.0], vec![-1.0, -1.0]).expect("valid");
    let found = solve(&lcp, None);
    assert!(matches!(found.termination, Termination::Breakdown(_) | Termination::IterationLimit), "{found:?}");
    assert!(found.z.iter().all(|z| z.is_finite() && *z >= 0.0));
}

/// A string of `n` points over an obstacle: the free boundary moves far from a cold start.
fn obstacle(n: usize) -> SparseLcp {
    let (mut starts, mut columns, mut values) = (vec![0], vec![], vec![]);
    for i in 0..n {
        for j in i.saturating_sub(1)..(i + 2).min(n) {
            columns.push(j);
            values.push(if i == j { 1.0 } else { -0.5 });
        }
        starts.push(columns.len());
    }
    let h = 1.0 / (n + 1) as f64;
    let height = |i: usize| {
        let x = (i + 1) as f64 * h;
        if i == n { 0.0 } else { (0.2 - 2.0 * (x - 0.5) * (x - 0.5)).max(-0.5) + 0.05 * (20.0 * x).sin() }
    };
    let curvature = |i: usize| height(i) - 0.5 * (if i > 0 { height(i - 1) } else { 0.0 } + height(i + 1));
    let q: Vec<f64> = (0..n).map(|i| if i + 1 == n { 1.0 } else { curvature(i) / (h * h) + 1.0 }).collect();
    let largest = crate::linalg::kernels::max_abs(&q);
    SparseLcp::new(starts, columns, values, q.iter().map(|q| q / largest).collect()).expect("valid")
}

#[test]
fn iterations_grow_slowly_with_the_grid() {
    for n in [100, 1000, 10_000] {
        let lcp = obstacle(n);
        let goal = Goal::plain(1e-9, lcp.q());
        let found = newton(&Sparse::new(&lcp), &goal, &Settings::default(), None, &Control::default());
        assert_eq!(found.termination, Termination::Converged, "{n}");
        assert!(found.iterations <= 80, "{n}: {}", found.iterations);
    }
}
