//! The kernels for small problems under Miri. Every operation of every kind of lanes is compared with plain numbers, at every
//! length, and small problems are solved.

#[cfg(test)]
mod tests {
    use lcpstar_kernels::small::lane::{BLOCK, F64x8, Lane, Mask};
    use lcpstar_kernels::small::{Answer, solve};

    const X: [f64; 8] = [0.0, -1.5, 3.0, 1e300, -0.0, 5e-324, 7.25, -2.0];
    const Y: [f64; 8] = [1.0, -1.5, -3.0, 1e-300, 0.0, 2.0, 0.5, f64::INFINITY];

    fn numbers<L: Lane>(x: L) -> [f64; 8] {
        std::array::from_fn(|l| x.get(l))
    }

    fn compare<L: Lane>() {
        for length in 0..=8 {
            let x = L::from_slice(&X[..length]);
            assert_eq!(numbers(x), std::array::from_fn(|l| if l < length { X[l] } else { 0.0 }));
        }
        let (x, y) = (L::from_slice(&X), L::from_slice(&Y));
        let each = |f: &dyn Fn(f64, f64) -> f64| -> [f64; 8] { std::array::from_fn(|l| f(X[l], Y[l])) };
        assert_eq!(numbers(x.add(y)), each(&|a, b| a + b));
        assert_eq!(numbers(x.sub(y)), each(&|a, b| a - b));
        assert_eq!(numbers(x.mul(y)), each(&|a, b| a * b));
        assert_eq!(numbers(x.abs()), each(&|a, _| a.abs()));
        assert_eq!(numbers(x.max(y)), each(&|a, b| if a > b { a } else { b }));
        assert_eq!(numbers(x.min(y)), each(&|a, b| if a < b { a } else { b }));
        let (less, equal) = (x.lt(y), x.eq(y));
        for l in 0..8 {
            assert_eq!(less.get(l), X[l] < Y[l]);
            assert_eq!(equal.get(l), X[l] == Y[l]);
            assert_eq!(x.le(y).get(l), X[l] <= Y[l]);
            assert_eq!(less.or(equal).get(l), X[l] <= Y[l]);
            assert_eq!(less.and(equal.not()).get(l), X[l] < Y[l]);
        }
        assert_eq!(numbers(x.only(less)), std::array::from_fn(|l| if X[l] < Y[l] { X[l] } else { 0.0 }));
        let mut changed = x;
        changed.set(3, 42.0);
        assert_eq!(changed.get(3), 42.0);
        let mut mask = L::Mask::NONE;
        mask.set(5, true);
        assert_eq!(mask.bits(), 1 << 5);
        assert!(mask.any() && !L::Mask::NONE.any() && L::Mask::ALL.get(7));
    }

    /// Rows of every length beside every number of columns, and places from the first to the last.
    fn compare_moves<L: Lane>() {
        for columns in 0..=BLOCK {
            let rows: Vec<Vec<f64>> = (0..8).map(|l| (0..columns).map(|k| (10 * l + k) as f64).collect()).collect();
            let views: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
            let mut out = vec![L::splat(-1.0); columns];
            L::load_columns(&views, 0, &mut out);
            for (k, column) in out.iter().enumerate() {
                assert_eq!(numbers(*column), std::array::from_fn(|l| (10 * l + k) as f64));
            }
            let mut back = vec![0.0; 7 * columns + BLOCK];
            L::store_columns(&out, &mut back, columns);
            assert_eq!(back[..8 * columns], rows.concat());
        }
        for count in [1, 2, 9] {
            let table: Vec<L> = (0..count).map(|i| L::splat(i as f64)).collect();
            let at = L::from_slice(&[0.0, 1.0, 8.0, -3.0, 1e9, f64::NAN, 0.5, 2.0]);
            let found = numbers(L::pick(&table, at.index(count, 1)));
            assert!(found.iter().all(|x| *x >= 0.0 && *x < count as f64), "{found:?}");
        }
    }

    #[test]
    fn moves() {
        compare_moves::<F64x8<true>>();
        #[cfg(target_feature = "avx2")]
        compare_moves::<lcpstar_kernels::small::avx::Ymm2>();
        #[cfg(target_feature = "avx512f")]
        compare_moves::<lcpstar_kernels::small::avx::Zmm>();
    }

    #[test]
    fn portable_lanes() {
        compare::<F64x8<true>>();
    }

    #[test]
    #[cfg(target_feature = "avx2")]
    fn lanes_of_avx2() {
        compare::<lcpstar_kernels::small::avx::Ymm2>();
    }

    #[test]
    #[cfg(target_feature = "avx512f")]
    fn lanes_of_avx512() {
        compare::<lcpstar_kernels::small::avx::Zmm>();
    }

    /// Orders on both sides of the width of a register; the kernel that the features of the machine choose.
    #[test]
    fn small_problems() {
        for n in [1, 2, 3, 7, 8, 9, 16, 17] {
            let a: Vec<f64> = (0..n * n).map(|k| if k / n.max(1) == k % n.max(1) { 4.0 } else { -0.1 }).collect();
            let q: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { -1.0 } else { 2.0 }).collect();
            let (mut z, mut w) = (vec![0.0; n], vec![0.0; n]);
            assert!(matches!(solve(&a, &q, 1e-9, &mut z, &mut w), Answer::Solved { .. }), "n = {n}: not solved");
            for i in 0..n {
                let w = q[i] + (0..n).map(|j| a[i * n + j] * z[j]).sum::<f64>();
                assert!(z[i] >= 0.0 && w > -1e-12 && (z[i] * w).abs() < 1e-9);
            }
        }
        assert!(matches!(solve(&[-1.0], &[-1.0], 1e-9, &mut [0.0], &mut [0.0]), Answer::None));
    }
}
