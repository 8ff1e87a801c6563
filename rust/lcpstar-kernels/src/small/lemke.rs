//! Lemke's method for one problem in memory that is used again: the survivor of singular, copositive and unsymmetric
//! problems behind the lane kernels. [CPS92, sec. 4.4]
//!
//! With a covering vector that hardly ever leads through degenerate bases, see [`covering`](super::covering); among tied rows
//! that of z_0 wins, then the largest pivot.

use super::covering::Covering;
use super::lane::Lane;
use super::prefetch::Prefetch;
use super::ratio::{first_to_reach_zero, last_to_become_nonnegative};
use super::scales::Scales;
use super::tableau::{Tableau, WIDTH, at, put};
use super::verify::{Accepted, verify_one};
use crate::cutovers::PATIENT_UP_TO;

/// What came of a run.
#[derive(Clone, Copy)]
pub struct Outcome {
    /// The point solves the problem.
    pub accepted: Option<Accepted>,
    /// The method ended with a complementary basis, and the point is its.
    pub found_basis: bool,
    /// Pivots made.
    pub pivots: usize,
}

/// How the method stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    /// z_0 left: the basis is complementary.
    Basis,
    /// No blocking row.
    Ray,
    /// Too many pivots, or a number that is not finite.
    Limit,
}

/// Refinement steps at most.
const REFINEMENTS: usize = 2;

/// Pivots per row of the problem after which the method gives up.
pub const PIVOTS_PER_ROW: usize = 10;

/// A sum smaller than this part of its terms' magnitudes is rounding error.
pub const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A correction that leaves less than this part of a value shows that the value was rounding error.
pub const CANCELLED: f64 = 1e-8;

/// A run of the method and its answer; the memory grows to the largest problem it has seen. Vectors of numbers are padded.
pub struct Lemke<X: Lane> {
    n: usize,
    tableau: Tableau<X>,
    ratio: Vec<X>,
    step: Vec<X>,
    z: Vec<X>,
    sums: Vec<[X; 2]>,
    scales: Scales<X>,
    /// Pivots of the last run.
    pivots: usize,
}

impl<X: Lane> Default for Lemke<X> {
    fn default() -> Self {
        Self {
            n: 0,
            tableau: Tableau::default(),
            ratio: Vec::new(),
            step: Vec::new(),
            z: Vec::new(),
            sums: Vec::new(),
            scales: Scales::default(),
            pivots: 0,
        }
    }
}

impl<X: Lane> Lemke<X> {
    /// Runs the method and refines the answer until it is verified; `w = A z + q` as computed. Asks for memory by `prefetch` beside each pivot.
    #[inline(always)]
    pub fn solve_and_verify(
        &mut self,
        a: &[f64],
        q: &[f64],
        w: &mut [f64],
        tol: f64,
        prefetch: &mut Prefetch,
    ) -> Outcome {
        self.resize(q.len());
        self.pivots = 0;
        let mut stop = Stop::Ray;
        for covering in [Covering::Spread, Covering::Ones] {
            stop = self.solve(a, q, covering, prefetch);
            if stop == Stop::Basis {
                break;
            }
        }
        let found_basis = stop == Stop::Basis;
        let accepted = if found_basis { self.refined(a, q, w, tol) } else { None };
        Outcome { accepted, found_basis, pivots: self.pivots }
    }

    /// Judges a point `z >= 0` that was found elsewhere; `w = A z + q` as computed. O(n^2).
    #[inline(always)]
    pub fn verify_point(&mut self, a: &[f64], q: &[f64], z: &[f64], w: &mut [f64], tol: f64) -> Option<Accepted> {
        self.resize(q.len());
        for (x, z) in self.z.iter_mut().zip(z.chunks(WIDTH)) {
            *x = X::from_slice(z);
        }
        self.judge(a, q, w, tol)
    }

    #[inline(always)]
    fn judge(&mut self, a: &[f64], q: &[f64], w: &mut [f64], tol: f64) -> Option<Accepted> {
        verify_one(a, q, &self.z, &mut self.sums, w, tol, &mut self.scales)
    }

    /// Memory for problems of order n.
    #[inline(always)]
    fn resize(&mut self, n: usize) {
        if n != self.n {
            let (width, zero) = (n.div_ceil(WIDTH), X::splat(0.0));
            self.n = n;
            for v in [&mut self.ratio, &mut self.step, &mut self.z] {
                v.resize(width, zero);
            }
            self.sums.resize(width, [zero; 2]);
            self.scales.resize(width);
        }
        self.scales.forget();
    }

    /// Runs the method. O(n^2) a pivot.
    #[inline(always)]
    fn solve(&mut self, a: &[f64], q: &[f64], covering: Covering, prefetch: &mut Prefetch) -> Stop {
        if !self.tableau.load(a, q, covering) {
            return Stop::Limit;
        }
        let (covering, values) = (self.tableau.covering(), self.tableau.values::<0>());
        let Some(row) = last_to_become_nonnegative(covering, values, &mut self.ratio) else {
            return Stop::Basis;
        };
        // The compiler is told how wide columns are.
        match self.n.div_ceil(WIDTH) {
            1 => self.pivot::<1>(row, prefetch),
            2 => self.pivot::<2>(row, prefetch),
            3 => self.pivot::<3>(row, prefetch),
            4 => self.pivot::<4>(row, prefetch),
            _ => self.pivot::<0>(row, prefetch),
        }
    }

    /// z_0 drives, blocked by `row`; then the complement of what left, until that is z_0. `W` vectors per column, 0 if not known.
    #[inline(always)]
    fn pivot<const W: usize>(&mut self, mut row: usize, prefetch: &mut Prefetch) -> Stop {
        let (n, tableau) = (self.n, &mut self.tableau);
        let (z0, limit) = (2 * n, self.pivots + PIVOTS_PER_ROW * n.min(PATIENT_UP_TO));
        tableau.drive::<W>(z0);
        loop {
            let leaving = tableau.exchange::<W>(row);
            prefetch.step();
            self.pivots += 1;
            if leaving == z0 {
                return Stop::Basis;
            }
            if self.pivots >= limit {
                return Stop::Limit;
            }
            tableau.drive::<W>(if leaving < n { leaving + n } else { leaving - n });
            let (column, values) = (tableau.driving_column::<W>(), tableau.values::<W>());
            match first_to_reach_zero(column, values, &mut self.ratio, tableau.row_of(z0)) {
                Some(blocking) => row = blocking,
                None => return Stop::Ray,
            }
        }
    }

    /// Puts the basic z's in place, negative rounding set to zero, and judges them; `w = A z + q` as computed.
    #[inline(always)]
    fn refined(&mut self, a: &[f64], q: &[f64], w: &mut [f64], tol: f64) -> Option<Accepted> {
        self.z.fill(X::splat(0.0));
        for (i, j) in self.tableau.basic_z() {
            put(&mut self.z, j, at(self.tableau.values::<0>(), i).max(0.0));
        }
        let mut accepted = self.judge(a, q, w, tol);
        for _ in 0..REFINEMENTS {
            if accepted.is_some() {
                break;
            }
            self.refine(q, w);
            accepted = self.judge(a, q, w, tol);
        }
        accepted
    }

    /// `z_a -= A_aa^-1 w_a`; what is rounding error beside the terms of `A_aa^-1 q_a` becomes zero.
    #[inline(always)]
    fn refine(&mut self, q: &[f64], w: &[f64]) {
        let (step, size) = (&mut self.step, &mut self.ratio);
        self.tableau.times_inverse(w, q, step, size);
        for (i, j) in self.tableau.basic_z() {
            let old = at(&self.z, j);
            let new = old - at(step, i);
            let least = (CANCELLED * old).max(ROUNDING * at(size, i));
            put(&mut self.z, j, if new > least { new } else { 0.0 });
        }
    }

    /// z_j.
    #[inline(always)]
    pub fn z(&self, j: usize) -> f64 {
        at(&self.z, j)
    }

    /// The j with z_j basic.
    #[inline(always)]
    pub fn basis(&self) -> impl Iterator<Item = usize> {
        self.tableau.basic_z().map(|(_, j)| j)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Answer, solve};

    fn solved(a: &[f64], q: &[f64], z: &mut [f64], w: &mut [f64]) -> Option<(u128, usize)> {
        match solve(a, q, 1e-9, z, w) {
            Answer::Solved { alpha, iterations, .. } => Some((alpha, iterations)),
            Answer::Basis { .. } | Answer::None => None,
        }
    }

    /// Problems with one solution, at orders on both sides of every width of a column.
    #[test]
    fn few_pivots_to_the_solution_of_a_p_matrix() {
        // Reproducible, between -1/2 and 1/2.
        let noise = |k: usize| (k * 7919 % 101) as f64 / 101.0 - 0.5;
        for n in [1, 2, 3, 7, 8, 9, 16, 31, 33, 40, 48, 56, 64, 65, 128] {
            let a: Vec<f64> = (0..n * n).map(|e| noise(e) + if e / n == e % n { n as f64 } else { 0.0 }).collect();
            let q: Vec<f64> = (0..n).map(|i| noise(3 * i + 1) - 0.2).collect();
            let (mut z, mut w) = (vec![0.0; n], vec![0.0; n]);
            let (alpha, pivots) = solved(&a, &q, &mut z, &mut w).expect("diagonally dominant");
            for i in 0..n {
                let w = q[i] + (0..n).map(|j| a[i * n + j] * z[j]).sum::<f64>();
                assert!(z[i].min(w).abs() < 1e-13, "n = {n}, row {i}: z {}, w {w}", z[i]);
                assert_eq!(alpha >> i & 1 == 1, z[i] > 0.0, "n = {n}, row {i}");
            }
            assert!(pivots <= 2 * n, "n = {n}: {pivots} pivots");
        }
    }

    #[test]
    fn a_ray_and_a_trivial_problem() {
        assert!(matches!(solve(&[-1.0], &[-1.0], 1e-9, &mut [0.0], &mut [0.0]), Answer::None));
        let (mut z, mut w) = ([7.0; 2], [7.0; 2]);
        let found = solved(&[0.0; 4], &[1.0, 0.0], &mut z, &mut w).expect("q >= 0");
        assert_eq!((found, z, w), ((0, 0), [0.0; 2], [1.0, 0.0]));
    }
}
