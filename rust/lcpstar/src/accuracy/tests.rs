use super::*;

fn measured(a: &[f64], q: &[f64], z: &[f64]) -> Accuracy {
    accuracy(&Lcp::new(q.len(), a.to_vec(), q.to_vec()).expect("valid"), z, &Control::default()).expect("valid")
}

#[test]
fn an_m_matrix_by_hand() {
    // z* = (2, 2). At (1, 2): w = (-2, 1), b = |min(2 z, w)| = (2, 1), <A>^-1 b = (5/3, 4/3).
    let (a, q, z) = ([2.0, -1.0, -1.0, 2.0], [-2.0, -2.0], [1.0, 2.0]);
    let lcp = Lcp::new(2, a.to_vec(), q.to_vec()).expect("valid");
    let by_comparison =
        bound::comparison(&Equilibrated::new(&lcp), &point(&lcp, &z), &Control::default()).value.expect("an M-matrix");
    assert!((by_comparison - 5.0 / 3.0).abs() < 1e-5, "{by_comparison}");
    let found = measured(&a, &q, &z);
    assert!((1.0..=by_comparison).contains(&found.error_bound.expect("an M-matrix")));
    assert_eq!((found.natural_residual, found.backward_error), (2.0, 2.0 / 6.0));
}

#[test]
fn definite_and_not_h() {
    // <A> is singular: row sums 0; A itself is positive definite. z* = (1, 1, 1).
    let a = [1.0, 0.6, 0.6, 0.6, 1.0, 0.6, 0.6, 0.6, 1.0];
    let found = measured(&a, &[-2.2; 3], &[1.0, 1.0, 0.999]);
    let bound = found.error_bound.expect("positive definite");
    assert!((1e-3..2e-2).contains(&bound), "{bound}");
    assert!(found.bound_reason.contains("positive definite"));
}

#[test]
fn no_bound_without_uniqueness() {
    for a in [[1.0, 1.0, 1.0, 1.0], [0.0, 1.0, 1.0, 0.0], [1.0, -1.0, -1.0, 1.0]] {
        let found = measured(&a, &[-1.0, -1.0], &[1.0, 1.0]);
        assert_eq!((found.error_bound, found.bound_reason), (None, bound::NONE), "{a:?}");
    }
}

#[test]
fn negative_z_has_no_backward_error() {
    assert_eq!(measured(&[1.0], &[1.0], &[-0.5]).backward_error, f64::INFINITY);
    assert_eq!(measured(&[1.0], &[1.0], &[0.0]).backward_error, 0.0);
    assert_eq!(measured(&[1.0], &[1.0], &[0.0]).error_bound, Some(0.0));
}

#[test]
fn sparse_and_dense_agree() {
    let n = 30;
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 2.5,
        1 => {
            if i < j {
                -1.0
            } else {
                1.2
            }
        }
        _ => 0.0,
    };
    let a: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
    let q: Vec<f64> = (0..n).map(|i| ((i * 7) % 11) as f64 - 6.0).collect();
    let lcp = Lcp::new(n, a, q).expect("valid");
    let sparse = crate::iterative::matrix::tests::sparse(&lcp);
    let z: Vec<f64> = (0..n).map(|i| (i % 4) as f64).collect();
    let (dense, sparse) =
        (measured(lcp.a(), lcp.q(), &z), accuracy_sparse(&sparse, &z, &Control::default()).expect("valid"));
    assert_eq!(dense.backward_error, sparse.backward_error);
    let (a, b) = (dense.error_bound.expect("H+"), sparse.error_bound.expect("H+"));
    assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
}
