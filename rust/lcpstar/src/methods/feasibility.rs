//! Is FEA(q, A) = {z >= 0 : A z + q >= 0} empty? A dense dual simplex method in doubles.
//!
//! Minimises `c'z` for a fixed random `c > 0`: the start `z = 0` is dual feasible whatever A and q, no phase one and no
//! artificial column are needed, and random costs make dual ties (hence cycles) improbable. It ends with a feasible
//! point or with a row `x_B = b_r + T_r x_N`, `b_r < 0`, `T_r <= 0`: a Farkas vector. [Chv83, ch. 10]
//!
//! A candidate, judged by `certify` or proved by [`exact`](crate::exact::feasibility::feasibility) from the last basis.

use crate::control::Control;
use crate::exact::feasibility::costs;
use crate::linalg::backend::DenseLu;
use crate::linalg::kernels::axpy;
use crate::problem::Lcp;
use crate::status::Termination;
use lcpstar_kernels::pivots::SPREAD;

/// Where the simplex method ended.
#[derive(Clone, Debug)]
pub struct Feasibility {
    /// What it found.
    pub verdict: Verdict,
    /// Rows whose `w` is nonbasic, and basic z's, of the last basis: as many of one as of the other.
    pub rho: Vec<usize>,
    /// Basic z's.
    pub beta: Vec<usize>,
    /// Pivots.
    pub iterations: usize,
}

/// A candidate answer.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// `z >= 0` with `A z + q >= 0` up to rounding.
    Feasible(Vec<f64>),
    /// `y >= 0`, `A'y <= 0`, `q'y < 0` up to rounding.
    Infeasible(Vec<f64>),
    /// Neither: why it stopped.
    Stopped(Termination),
}

/// Pivots between two fresh factorisations.
const REFRESH: usize = 60;
/// Slack of the ratio test in units of the costs.
const TOL_COST: f64 = 1e-9;

/// Decides feasibility of the equilibrated problem. O(n^2) a pivot, about n pivots; n^3 for each refresh.
#[must_use]
pub fn feasibility(lcp: &Lcp, control: &Control<'_>) -> Feasibility {
    let mut simplex = Simplex::new(lcp);
    let mut iterations = 0;
    let verdict = loop {
        if let Some(reason) = control.stop(iterations, 200 + 20 * lcp.n()) {
            break Verdict::Stopped(reason);
        }
        let due = simplex.age >= REFRESH;
        let Some(r) = simplex.leaving() else {
            if simplex.settled() {
                break Verdict::Feasible(simplex.point());
            }
            continue;
        };
        if due && !simplex.settled() {
            continue;
        }
        match simplex.entering(r) {
            Some(s) => simplex.exchange(r, s),
            None if simplex.settled() => break Verdict::Infeasible(simplex.farkas(r)),
            None => {}
        }
        iterations += 1;
    };
    let (rho, beta) = simplex.basis();
    Feasibility { verdict, rho, beta, iterations }
}

/// Columns j < n of the variables are z_j, the others w_{j-n}.
struct Simplex<'a> {
    lcp: &'a Lcp,
    cost: Vec<f64>,
    basic: Vec<usize>,
    nonbasic: Vec<usize>,
    /// `n + 1` rows of `n + 1`: row r reads `x_basic[r] = sum_j t[r][j] x_nonbasic[j] + t[r][n]`; the last is the cost.
    t: Vec<f64>,
    /// Pivots since the table was computed from A and q.
    age: usize,
}

impl<'a> Simplex<'a> {
    fn new(lcp: &'a Lcp) -> Self {
        let n = lcp.n();
        let cost = costs(n);
        let mut t = Vec::with_capacity((n + 1) * (n + 1));
        for i in 0..n {
            t.extend_from_slice(lcp.row(i));
            t.push(lcp.q()[i]);
        }
        t.extend_from_slice(&cost);
        t.push(0.0);
        Self { lcp, cost, basic: (n..2 * n).collect(), nonbasic: (0..n).collect(), t, age: 0 }
    }

    fn width(&self) -> usize {
        self.lcp.n() + 1
    }

    fn row(&self, r: usize) -> &[f64] {
        &self.t[r * self.width()..(r + 1) * self.width()]
    }

    /// The most negative basic variable, measured by its row.
    fn leaving(&self) -> Option<usize> {
        let n = self.lcp.n();
        let violation = |r: usize| {
            let row = self.row(r);
            let size = row[..n].iter().fold(0.0f64, |m, x| m.max(x.abs())).max(1e-300);
            row[n] / size
        };
        let candidates = (0..n).filter(|&r| self.row(r)[n] < -1e-12 && violation(r) < -1e-13);
        candidates.min_by(|&r, &s| violation(r).total_cmp(&violation(s)))
    }

    /// Dual ratio test with Harris' slack: of the nearly least ratios the largest pivot.
    fn entering(&self, r: usize) -> Option<usize> {
        let n = self.lcp.n();
        let row = &self.row(r)[..n];
        let cost = &self.row(n)[..n];
        let smallest = SPREAD * row.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let candidates = || (0..n).filter(|&j| row[j] > smallest);
        let bound = candidates().map(|j| (cost[j].max(0.0) + TOL_COST) / row[j]).min_by(f64::total_cmp)?;
        candidates().filter(|&j| cost[j].max(0.0) <= bound * row[j]).max_by(|&i, &j| row[i].total_cmp(&row[j]))
    }

    fn exchange(&mut self, r: usize, s: usize) {
        let width = self.width();
        let pivot = self.t[r * width + s];
        let mut pivot_row = self.row(r).to_vec();
        pivot_row[s] = -1.0;
        for x in &mut pivot_row {
            *x /= -pivot;
        }
        for i in 0..width {
            if i == r {
                continue;
            }
            let row = &mut self.t[i * width..(i + 1) * width];
            let factor = std::mem::take(&mut row[s]);
            if factor != 0.0 {
                axpy(factor, &pivot_row, row);
            }
        }
        self.t[r * width..(r + 1) * width].copy_from_slice(&pivot_row);
        std::mem::swap(&mut self.basic[r], &mut self.nonbasic[s]);
        self.age += 1;
    }

    /// True when the table is fresh; otherwise computes it anew from A and q and says false.
    fn settled(&mut self) -> bool {
        if self.age == 0 {
            return true;
        }
        self.age = 0;
        // A singular basis keeps the old table, as good as there is.
        self.refresh().is_none()
    }

    fn basis(&self) -> (Vec<usize>, Vec<usize>) {
        let n = self.lcp.n();
        let rho = self.nonbasic.iter().filter(|&&v| v >= n).map(|v| v - n).collect();
        let beta = self.basic.iter().copied().filter(|&v| v < n).collect();
        (rho, beta)
    }

    fn refresh(&mut self) -> Option<()> {
        let (lcp, n, width) = (self.lcp, self.lcp.n(), self.width());
        let (rho, beta) = self.basis();
        let k = rho.len();
        let block: Vec<f64> = rho.iter().flat_map(|&i| beta.iter().map(move |&j| lcp.row(i)[j])).collect();
        let lu = DenseLu::new(k, &block)?;
        // z_beta = K^-1 (w_rho - A_rho,N z_N - q_rho), in the order of the nonbasic columns.
        let mut right = vec![0.0; k * width];
        for (t, &i) in rho.iter().enumerate() {
            for (j, &v) in self.nonbasic.iter().enumerate() {
                right[t * width + j] = if v < n { -lcp.row(i)[v] } else { f64::from(u8::from(v - n == i)) };
            }
            right[t * width + n] = -lcp.q()[i];
        }
        let z = lu.solve_many(&right, width);
        let mut fresh = vec![0.0; width * width];
        for (r, &v) in self.basic.iter().enumerate() {
            let row = &mut fresh[r * width..(r + 1) * width];
            if v < n {
                let t = beta.iter().position(|&j| j == v)?;
                row.copy_from_slice(&z[t * width..(t + 1) * width]);
            } else {
                self.expand(lcp.row(v - n), lcp.q()[v - n], &beta, &z, row);
            }
        }
        self.expand(&self.cost, 0.0, &beta, &z, &mut fresh[n * width..]);
        if fresh.iter().all(|x| x.is_finite()) {
            self.t = fresh;
        }
        Some(())
    }

    /// `sum_j coefficient_j z_j + constant` in terms of the nonbasic variables.
    fn expand(&self, coefficient: &[f64], constant: f64, beta: &[usize], z: &[f64], row: &mut [f64]) {
        let (n, width) = (self.lcp.n(), self.width());
        for (x, &v) in row.iter_mut().zip(&self.nonbasic) {
            *x = if v < n { coefficient[v] } else { 0.0 };
        }
        row[n] = constant;
        for (t, &j) in beta.iter().enumerate() {
            axpy(coefficient[j], &z[t * width..(t + 1) * width], row);
        }
    }

    fn point(&self) -> Vec<f64> {
        let n = self.lcp.n();
        let mut z = vec![0.0; n];
        for (r, &v) in self.basic.iter().enumerate() {
            if v < n {
                z[v] = self.row(r)[n].max(0.0);
            }
        }
        z
    }

    /// `x_r = q'y + (A'y)'z - y'w`, so `y` is minus the coefficients of the w's, and 1 for a basic w.
    fn farkas(&self, r: usize) -> Vec<f64> {
        let n = self.lcp.n();
        let mut y = vec![0.0; n];
        for (x, &v) in self.row(r).iter().zip(&self.nonbasic) {
            if v >= n {
                y[v - n] = (-x).max(0.0);
            }
        }
        if self.basic[r] >= n {
            y[self.basic[r] - n] = 1.0;
        }
        y
    }
}

#[cfg(test)]
#[allow(clippy::panic)] // a test says what it found
mod tests {
    use super::*;
    use crate::exact::dyadic::linear_form;
    use crate::exact::farkas::{check_farkas, repair_farkas};
    use crate::exact::feasibility as exact;
    use fastrand::Rng;

    /// Every float verdict is compared with the exact one from the same basis.
    fn compare(lcp: &Lcp) -> bool {
        let found = feasibility(lcp, &Control::default());
        let exact = exact::feasibility(lcp.view(), &found.rho, &found.beta, &|| false);
        match (found.verdict, exact) {
            (Verdict::Feasible(z), exact::Feasibility::Feasible(_)) => {
                for i in 0..lcp.n() {
                    let w: f64 = lcp.row(i).iter().zip(&z).map(|(a, z)| a * z).sum::<f64>() + lcp.q()[i];
                    let size: f64 = lcp.row(i).iter().zip(&z).map(|(a, z)| (a * z).abs()).sum::<f64>() + 1.0;
                    assert!(w >= -1e-9 * size, "w = {w}");
                }
                true
            }
            (Verdict::Infeasible(y), exact::Feasibility::Infeasible(exact)) => {
                assert!(check_farkas(lcp.view(), &exact));
                let q = linear_form(lcp.q().iter().copied().zip(&exact.numerators));
                assert!(q.value < num_bigint::BigInt::from(0));
                let near = repair_farkas(lcp.view(), &y, &|| false).expect("a nondegenerate vector is repaired");
                assert!(check_farkas(lcp.view(), &near));
                false
            }
            (found, exact) => panic!("{found:?} against {exact:?}"),
        }
    }

    #[test]
    fn random_and_degenerate_problems_are_decided_as_exactly() {
        let mut draw = Rng::with_seed(17);
        let (mut yes, mut no) = (0, 0);
        for trial in 0..150 {
            let n = 1 + trial % 12;
            let integer = trial % 3 == 0;
            let mut entry = |shift: f64| {
                let x = draw.f64() - shift;
                if integer { (x * 4.0).round() } else { x }
            };
            let a: Vec<f64> = (0..n * n).map(|_| entry(0.55)).collect();
            let q: Vec<f64> = (0..n).map(|_| entry(0.6)).collect();
            let lcp = Lcp::new(n, a, q).expect("valid");
            *if compare(&lcp) { &mut yes } else { &mut no } += 1;
        }
        assert!(yes > 25 && no > 25, "{yes} {no}");
    }

    #[test]
    fn a_large_infeasible_problem_has_a_farkas_vector() {
        // A = G - G' is skew, so A'y = -A y: infeasible with y feasible for the dual by construction of q.
        let mut draw = Rng::with_seed(5);
        let n = 120;
        let g: Vec<f64> = (0..n * n).map(|_| draw.f64() - 0.9).collect();
        let lcp = Lcp::new(n, g, (0..n).map(|i| if i == 3 { -1.0 } else { 0.0 }).collect()).expect("valid");
        compare(&lcp);
    }
}
