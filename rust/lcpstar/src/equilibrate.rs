//! A problem beside its equilibrated copy, dense or sparse: what was computed once and is carried along the road.

use crate::cutovers::DENSE_UP_TO;
use crate::linalg::kernels;
use crate::problem::Lcp;
use crate::scaling::{Scaling, ZERO, are_ordinary, exponent, power_of_two, times_power_of_two};
use crate::sparse::SparseLcp;
use std::borrow::Cow;

/// What the judge reads of a problem, whatever form its matrix has.
pub trait Rows: Clone {
    /// Order.
    fn n(&self) -> usize;
    /// `q`.
    fn q(&self) -> &[f64];
    /// The entries of A that are stored.
    fn numbers(&self) -> &[f64];
    /// The entries of row i that are stored, with their columns.
    fn for_each(&self, i: usize, entry: impl FnMut(usize, f64));
    /// `w = A z + q` in twice the working precision, and `|A||z| + |q|`. One pass over A.
    fn slack(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>);
    /// The equilibration of the contract: rows and columns of A to a maximum near 1, q below 1.
    fn scaling(&self) -> Scaling;
    /// `D_r A D_c` with `s D_r q`.
    fn scaled(&self, scaling: &Scaling) -> Self;
    /// The problem with a dense A, unless that would be too large.
    fn dense(&self) -> Option<Cow<'_, Lcp>>;

    /// Entry (i, j).
    fn entry(&self, i: usize, j: usize) -> f64 {
        let mut found = 0.0;
        self.for_each(i, |k, a| {
            if k == j {
                found = a
            }
        });
        found
    }
}

impl Rows for Lcp {
    fn n(&self) -> usize {
        Self::n(self)
    }

    fn q(&self) -> &[f64] {
        Self::q(self)
    }

    fn numbers(&self) -> &[f64] {
        self.a()
    }

    fn for_each(&self, i: usize, mut entry: impl FnMut(usize, f64)) {
        self.row(i).iter().enumerate().for_each(|(j, &a)| entry(j, a));
    }

    fn slack(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        crate::residual::slack(self, z)
    }

    fn scaling(&self) -> Scaling {
        let n = self.n();
        if is_equilibrated(self) {
            return Scaling::of_exponents(vec![0; n], vec![0; n], self.q());
        }
        Scaling::ruiz(self.q(), |rows, columns, row_max, column_max| {
            for i in 0..n {
                let (row, r) = (self.row(i), rows[i]);
                row_max[i] = kernels::max_exponents(row, ZERO, columns, r, column_max).unwrap_or_else(|| {
                    row.iter().zip(&mut *column_max).for_each(|(&x, m)| *m = (*m).max(exponent(x) + r));
                    row.iter().zip(columns).map(|(&x, c)| exponent(x) + c).max().unwrap_or(ZERO)
                });
            }
        })
    }

    fn scaled(&self, scaling: &Scaling) -> Self {
        let q = scaled_q(self.q(), scaling);
        if scaling.rows.iter().chain(&scaling.columns).all(|&e| e == 0) {
            return self.with_q(q);
        }
        Self::trusted(self.n(), scaled_matrix(self, scaling), q)
    }

    fn dense(&self) -> Option<Cow<'_, Lcp>> {
        Some(Cow::Borrowed(self))
    }
}

impl Rows for SparseLcp {
    fn n(&self) -> usize {
        Self::n(self)
    }

    fn q(&self) -> &[f64] {
        Self::q(self)
    }

    fn numbers(&self) -> &[f64] {
        self.values()
    }

    fn for_each(&self, i: usize, mut entry: impl FnMut(usize, f64)) {
        let (columns, values) = self.row(i);
        columns.iter().zip(values).for_each(|(&j, &a)| entry(j, a));
    }

    fn slack(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        Self::slack(self, z)
    }

    fn scaling(&self) -> Scaling {
        let exponents: Vec<i32> = self.values().iter().map(|&a| exponent(a)).collect();
        Scaling::ruiz(self.q(), |rows, columns, row_max, column_max| {
            let mut exponents = exponents.iter();
            for i in 0..rows.len() {
                for (&j, e) in self.row(i).0.iter().zip(&mut exponents) {
                    row_max[i] = row_max[i].max(e + columns[j]);
                    column_max[j] = column_max[j].max(e + rows[i]);
                }
            }
        })
    }

    fn scaled(&self, scaling: &Scaling) -> Self {
        let entry = |i: usize, j: usize, a: f64| times_power_of_two(a, scaling.rows[i] + scaling.columns[j]);
        self.mapped(entry, scaled_q(self.q(), scaling))
    }

    fn dense(&self) -> Option<Cow<'_, Lcp>> {
        (self.n() <= DENSE_UP_TO).then(|| Cow::Owned(self.to_dense()))
    }
}

/// A problem beside its equilibrated copy.
#[derive(Clone, Debug)]
pub struct Equilibrated<'a, P = Lcp> {
    /// The caller's problem.
    pub original: &'a P,
    /// The equilibrated problem: every nonzero row and column of A has its largest entry in [1/4, 2), `max|q| < 1`.
    pub lcp: P,
    /// How the one became the other.
    pub scaling: Scaling,
    /// Whether every number of both is in [`ORDINARY`](crate::scaling::ORDINARY), or zero in both: then no product or sum of a few overflows or
    /// loses digits.
    pub is_ordinary: bool,
}

impl<'a, P: Rows> Equilibrated<'a, P> {
    /// Equilibrates `original`. A few passes over A.
    #[must_use]
    pub fn new(original: &'a P) -> Self {
        Self::with(original, original.scaling())
    }

    /// Scales `original` as told. One pass over A.
    #[must_use]
    pub fn with(original: &'a P, scaling: Scaling) -> Self {
        let lcp = original.scaled(&scaling);
        let pairs = [(original.numbers(), lcp.numbers()), (original.q(), lcp.q())];
        let is_same = std::ptr::eq(original.numbers(), lcp.numbers());
        let is_ordinary = pairs[usize::from(is_same)..].iter().all(|(x, y)| are_ordinary(y) && !vanishes(x, y))
            && pairs.iter().all(|(x, _)| are_ordinary(x));
        Self { original, lcp, scaling, is_ordinary }
    }
}

fn scaled_q(q: &[f64], scaling: &Scaling) -> Vec<f64> {
    q.iter().zip(&scaling.rows).map(|(&x, r)| times_power_of_two(x, r + scaling.q)).collect()
}

/// Whether a number became zero by underflow.
fn vanishes(original: &[f64], scaled: &[f64]) -> bool {
    original.iter().zip(scaled).fold(false, |found, (&x, &y)| found | ((x != 0.0) & (y == 0.0)))
}

/// Whether every row and column has its largest entry in [1/4, 2) already: one pass, no exponents.
fn is_equilibrated(lcp: &Lcp) -> bool {
    let n = lcp.n();
    let mut columns = vec![0.0; n];
    let near_one = |m: f64| (0.25..2.0).contains(&m);
    for i in 0..n {
        if !near_one(kernels::max_into(lcp.row(i), &mut columns)) {
            return false;
        }
    }
    columns.into_iter().all(near_one)
}

/// `D_r A D_c`.
fn scaled_matrix(lcp: &Lcp, scaling: &Scaling) -> Vec<f64> {
    let n = lcp.n();
    if scaling.is_moderate() {
        let mut a = vec![0.0; n * n];
        let factors: Vec<f64> = scaling.columns.iter().map(|&c| power_of_two(c)).collect();
        for (i, out) in a.chunks_exact_mut(n).enumerate() {
            kernels::scale_row(lcp.row(i), power_of_two(scaling.rows[i]), &factors, out);
        }
        return a;
    }
    let mut a = Vec::with_capacity(n * n);
    for (i, r) in scaling.rows.iter().enumerate() {
        a.extend(lcp.row(i).iter().zip(&scaling.columns).map(|(&x, c)| times_power_of_two(x, r + c)));
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    fn largest(x: &[f64]) -> f64 {
        x.iter().fold(0.0, |m, x| m.max(x.abs()))
    }

    #[test]
    fn rows_and_columns_reach_one_within_a_factor_of_four() {
        let a = vec![1e-10, 3e-300, 5.0, 1e8, 0.0, 2e200, 7e-9, 1.0, 0.0];
        let lcp = Lcp::new(3, a, vec![1e300, -5e-324, 0.0]).expect("finite");
        let e = Equilibrated::new(&lcp);
        for i in 0..3 {
            let column: Vec<f64> = (0..3).map(|k| e.lcp.row(k)[i]).collect();
            for m in [largest(e.lcp.row(i)), largest(&column)] {
                assert!((0.25..2.0).contains(&m), "{m}");
            }
        }
        assert!((0.5..1.0).contains(&largest(e.lcp.q())));
    }

    #[test]
    fn symmetric_stays_symmetric_and_z_round_trips() {
        let a = vec![4.0, 1e5, 0.0, 1e5, 1e12, 3.0, 0.0, 3.0, 1e-6];
        let lcp = Lcp::new(3, a, vec![-1.0, 2.0, 1e-3]).expect("finite");
        let e = Equilibrated::new(&lcp);
        assert_eq!(e.scaling.rows, e.scaling.columns);
        let z = vec![1.5, -3e-5, 1e9];
        assert_eq!(e.scaling.z_to_caller(&e.scaling.z_from_caller(&z)), z);
    }

    #[test]
    fn sparse_problems_are_scaled_as_dense_ones() {
        let mut rng = fastrand::Rng::with_seed(4);
        for _ in 0..200 {
            let n = rng.usize(1..9);
            let number = |rng: &mut fastrand::Rng| {
                if rng.bool() { 0.0 } else { times_power_of_two(rng.f64() - 0.5, rng.i32(-300..300)) }
            };
            let a = (0..n * n).map(|_| number(&mut rng)).collect();
            let q = (0..n).map(|_| number(&mut rng)).collect();
            let lcp = Lcp::new(n, a, q).expect("finite");
            assert_eq!(lcp.scaling(), SparseLcp::from_dense(&lcp).scaling());
        }
    }
}
