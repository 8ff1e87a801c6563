//! Exact pivoting from a basis that floating point proposed: Lemke's path.
//!
//! No tableau is kept. The basis is a square block of `[A | d]` of the size of the basic z's; every pivot solves
//! with it p-adically, so numbers never grow from pivot to pivot.

use super::dyadic::{RationalVec, Scaled, linear_form};
use super::padic::{Block, Unsolved, independent_rows_and_columns};
use super::proof::{ExactSolution, ProofOutcome, prove_solution};
use super::ray::ExactRay;
use crate::problem::Problem;
use crate::var::Var;
use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};
use std::cmp::Ordering;

/// How exact pivoting ended.
#[derive(Clone, Debug)]
pub enum Repaired {
    /// A proved solution, and the pivots it took.
    Solved(ExactSolution, usize),
    /// No solution on the path from the proposed basis, and the path from z = 0 with covering vector d = e ended on
    /// this secondary ray.
    Ray(ExactRay),
    /// `stop` said so.
    Interrupted,
}

/// Lemke's method in exact arithmetic, with the exact lexicographic rule, on the principal transform at `alpha`
/// with covering vector e there. When `alpha` solves the problem no pivot is made; when it is wrong in a few signs
/// a few pivots repair it. A singular start is cut down to independent rows; where that path ends on a ray, Lemke's
/// own path from z = 0 is followed.
///
/// Cost: one factorisation modulo a prime and two p-adic solves a pivot, more only on exact ties.
#[must_use]
pub fn repair(lcp: Problem<'_>, alpha: &[usize], stop: &dyn Fn() -> bool) -> Repaired {
    let k = alpha.len();
    let order: Vec<usize> = (0..k).collect();
    let (rows, _) = independent_rows_and_columns(k, k, |i, j| lcp.row(alpha[i])[alpha[j]], &order, stop);
    let cut: Vec<usize> = rows.iter().map(|&r| alpha[r]).collect();
    match Path::new(lcp, &cut).follow(stop) {
        Err(Unsolved::Interrupted) => Repaired::Interrupted,
        Ok(outcome @ (Repaired::Solved(..) | Repaired::Interrupted)) => outcome,
        Ok(Repaired::Ray(..)) | Err(Unsolved::Singular) => {
            Path::new(lcp, &[]).follow(stop).unwrap_or(Repaired::Interrupted)
        }
    }
}

/// The proof of an answer with basis `alpha`: [`prove_solution`] where the basis is right, [`repair`] where it is not.
#[must_use]
pub fn prove(lcp: Problem<'_>, alpha: &[usize], stop: &dyn Fn() -> bool) -> Repaired {
    match prove_solution(lcp, alpha, stop) {
        ProofOutcome::Proved(solution) => Repaired::Solved(solution, 0),
        ProofOutcome::Interrupted => Repaired::Interrupted,
        _ => repair(lcp, alpha, stop),
    }
}

/// Values of the basic variables over one positive denominator.
struct Values {
    z: Vec<BigInt>,
    z0: BigInt,
    w: Vec<BigInt>,
}

struct Path<'a> {
    lcp: Problem<'a>,
    /// The start: `d = C g`, C its complementary matrix and g = e, exactly.
    start: Vec<bool>,
    /// d as an unevaluated sum of double vectors.
    d: Vec<Vec<f64>>,
    /// Basic z's; rows whose w is nonbasic; whether z_0 is basic.
    beta: Vec<usize>,
    rho: Vec<usize>,
    with_z0: bool,
}

impl<'a> Path<'a> {
    fn new(lcp: Problem<'a>, alpha: &[usize]) -> Self {
        let n = lcp.n();
        let mut start = vec![false; n];
        for &i in alpha {
            start[i] = true;
        }
        let d = covering_vector(lcp, alpha, &start);
        Self { lcp, start, d, beta: alpha.to_vec(), rho: alpha.to_vec(), with_z0: false }
    }

    fn follow(mut self, stop: &dyn Fn() -> bool) -> Result<Repaired, Unsolved> {
        let block = self.block(stop)?;
        let x = self.basic(&block, &Column::Q, stop)?;
        let Some(worst) = self.first_leaving(&x) else {
            return Ok(Repaired::Solved(self.solution(&x.0, x.1), 0));
        };
        self.with_z0 = true;
        let mut left = if self.start[worst] { Var::Z(worst) } else { Var::W(worst) };
        self.drop_basic(left);
        let mut pivots = 1;
        while let Some(driving) = left.complement() {
            let block = self.block(stop)?;
            let (x, _) = self.basic(&block, &Column::Q, stop)?;
            let (direction, denominator) = self.basic(&block, &Column::Of(driving), stop)?;
            let Some(blocking) = self.blocking(&block, &x, &direction, stop)? else {
                return Ok(self.ray(direction, denominator, driving));
            };
            self.drop_basic(blocking);
            match driving {
                Var::Z(i) => self.beta.push(i),
                Var::W(i) => self.rho.retain(|&r| r != i),
                Var::Z0 => {}
            }
            pivots += 1;
            left = blocking;
        }
        let (x, denominator) = self.basic(&self.block(stop)?, &Column::Q, stop)?;
        Ok(Repaired::Solved(self.solution(&x, denominator), pivots))
    }

    fn drop_basic(&mut self, member: Var) {
        match member {
            Var::W(i) => self.rho.push(i),
            Var::Z(i) => self.beta.retain(|&j| j != i),
            Var::Z0 => self.with_z0 = false,
        }
    }

    /// `[A_rho,beta | d]`; the parts of d are columns of their own, tied together by rows `part_1 - part_t = 0`.
    fn block(&self, stop: &dyn Fn() -> bool) -> Result<Block, Unsolved> {
        let (k, r) = (self.beta.len(), self.rho.len());
        let order = k + if self.with_z0 { self.d.len() } else { 0 };
        Block::new(
            order,
            |i, j| {
                if i < r {
                    if j < k { self.lcp.row(self.rho[i])[self.beta[j]] } else { self.d[j - k][self.rho[i]] }
                } else if j == k {
                    1.0
                } else if j == k + 1 + (i - r) {
                    -1.0
                } else {
                    0.0
                }
            },
            stop,
        )
    }

    /// The basic variables for the right-hand side q, the perturbation q^(j), or the direction of a driving
    /// variable; and their denominator.
    fn basic(&self, block: &Block, column: &Column, stop: &dyn Fn() -> bool) -> Result<(Values, BigInt), Unsolved> {
        let n = self.lcp.n();
        let k = self.beta.len();
        // Every column is a vector of doubles c in w = A z + d z_0 + c.
        let c = |i: usize| match *column {
            Column::Q => self.lcp.q()[i],
            Column::Of(Var::Z(s)) => self.lcp.row(i)[s],
            Column::Of(Var::W(s)) => -f64::from(u8::from(i == s)),
            Column::Of(Var::Z0) => self.d.iter().map(|part| part[i]).sum(),
            Column::Perturbation(j) if self.start[j] => -self.lcp.row(i)[j],
            Column::Perturbation(j) => f64::from(u8::from(i == j)),
        };
        let mut rhs: Vec<Scaled> = self.rho.iter().map(|&i| Scaled::from_f64(-c(i))).collect();
        let order = k + if self.with_z0 { self.d.len() } else { 0 };
        rhs.resize_with(order, || Scaled::from_f64(0.0));
        let solved = block.solve(&rhs, stop)?;
        let parts = if self.with_z0 { self.d.len() } else { 0 };
        let mut basic_w = vec![true; n];
        for &i in &self.rho {
            basic_w[i] = false;
        }
        let mut out: Vec<Scaled> = solved.numerators.iter().map(|v| Scaled { value: v.clone(), exponent: 0 }).collect();
        out.truncate(k + parts.min(1));
        if parts == 0 {
            out.push(Scaled::from_f64(0.0));
        }
        for i in 0..n {
            out.push(if basic_w[i] {
                let z = self.beta.iter().zip(&solved.numerators).map(|(&j, v)| (self.lcp.row(i)[j], v));
                let z0 = self.d.iter().take(parts).map(|part| (part[i], &solved.numerators[k]));
                linear_form(z.chain(z0).chain(std::iter::once((c(i), &solved.denominator))))
            } else {
                Scaled::from_f64(0.0)
            });
        }
        let mut all = RationalVec::from_scaled(out, solved.denominator);
        let w = all.numerators.split_off(k + 1);
        let z0 = all.numerators.pop().unwrap_or_default();
        Ok((Values { z: all.numerators, z0, w }, all.denominator))
    }

    /// The lexicographically most negative row of the start; `None` when there is no negative one.
    fn first_leaving(&self, (x, _): &(Values, BigInt)) -> Option<usize> {
        let value = |i: usize| match self.beta.iter().position(|&j| j == i) {
            Some(t) => &x.z[t],
            None => &x.w[i],
        };
        // Row i is perturbed by eps^(i+1): of equal rows the last is the least.
        let least = (0..self.lcp.n()).reduce(|best, i| if value(i) <= value(best) { i } else { best })?;
        value(least).is_negative().then_some(least)
    }

    fn basic_members(&self) -> Vec<Var> {
        let mut members: Vec<Var> = self.beta.iter().map(|&j| Var::Z(j)).collect();
        members.push(Var::Z0);
        members.extend((0..self.lcp.n()).filter(|i| !self.rho.contains(i)).map(Var::W));
        members
    }

    fn value<'v>(&self, x: &'v Values, member: Var) -> &'v BigInt {
        match member {
            Var::W(i) => &x.w[i],
            Var::Z0 => &x.z0,
            Var::Z(i) => {
                let t = self.beta.iter().position(|&j| j == i).expect("invariant: z_i is basic");
                &x.z[t]
            }
        }
    }

    /// The lexicographic minimum ratio over the decreasing basic variables; z_0 wins a tie.
    fn blocking(
        &self,
        block: &Block,
        x: &Values,
        direction: &Values,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Var>, Unsolved> {
        let falling: Vec<Var> =
            self.basic_members().into_iter().filter(|&m| self.value(direction, m).is_negative()).collect();
        let mut tied = self.least_ratios(&falling, x, direction);
        let mut j = 0;
        while tied.len() > 1 && !tied.contains(&Var::Z0) && j < self.lcp.n() {
            let (perturbed, _) = self.basic(block, &Column::Perturbation(j), stop)?;
            tied = self.least_ratios(&tied, &perturbed, direction);
            j += 1;
        }
        Ok(if tied.contains(&Var::Z0) { Some(Var::Z0) } else { tied.first().copied() })
    }

    /// The members with the least `x / -direction`.
    fn least_ratios(&self, members: &[Var], x: &Values, direction: &Values) -> Vec<Var> {
        let mut tied: Vec<Var> = Vec::new();
        for &m in members {
            let order = tied.first().map_or(Ordering::Less, |&best| {
                // Both directions are negative: x_m / -d_m < x_b / -d_b  iff  x_m d_b > x_b d_m.
                let left = self.value(x, m) * self.value(direction, best);
                let right = self.value(x, best) * self.value(direction, m);
                right.cmp(&left)
            });
            match order {
                Ordering::Less => tied = vec![m],
                Ordering::Equal => tied.push(m),
                Ordering::Greater => {}
            }
        }
        tied
    }

    fn solution(&self, x: &Values, denominator: BigInt) -> ExactSolution {
        let mut numerators = vec![BigInt::zero(); self.lcp.n()];
        for (&j, v) in self.beta.iter().zip(&x.z) {
            numerators[j] = v.clone();
        }
        let mut alpha = self.beta.clone();
        alpha.sort_unstable();
        ExactSolution { alpha, z: RationalVec { numerators, denominator } }
    }

    fn ray(&self, direction: Values, denominator: BigInt, driving: Var) -> Repaired {
        let mut numerators = vec![BigInt::zero(); self.lcp.n()];
        for (&j, v) in self.beta.iter().zip(&direction.z) {
            numerators[j] = v.clone();
        }
        if let Var::Z(s) = driving {
            numerators[s] = denominator.clone();
        }
        Repaired::Ray(ExactRay { z: RationalVec { numerators, denominator }, z0: direction.z0 })
    }
}

enum Column {
    Q,
    Of(Var),
    Perturbation(usize),
}

/// `C e` as an unevaluated sum of vectors of doubles; a sum that no double can hold is one of several large ones.
fn covering_vector(lcp: Problem<'_>, alpha: &[usize], start: &[bool]) -> Vec<Vec<f64>> {
    let n = lcp.n();
    let one = BigInt::from(1);
    let mut parts: Vec<Vec<f64>> = Vec::new();
    for i in 0..n {
        let terms = alpha.iter().map(|&j| (-lcp.row(i)[j], &one));
        let mut rest = linear_form(terms.chain(std::iter::once((f64::from(u8::from(!start[i])), &one))));
        let mut t = 0;
        while !rest.value.is_zero() {
            let drop = rest.value.bits().saturating_sub(53).min((LARGEST_EXPONENT - rest.exponent).max(0) as u64);
            let top = (rest.value.magnitude() >> drop).to_i64().unwrap_or(i64::MAX).min((1 << 53) - 1);
            let top = if rest.value.is_negative() { -top } else { top };
            if parts.len() == t {
                parts.push(vec![0.0; n]);
            }
            parts[t][i] = power_of_two(top as f64, drop as i64 + rest.exponent);
            rest.value -= BigInt::from(top) << drop;
            t += 1;
        }
    }
    if parts.is_empty() {
        parts.push(vec![0.0; n]);
    }
    parts
}

/// `f64::MAX` is `(2^53 - 1) 2^971`.
const LARGEST_EXPONENT: i64 = 971;

/// `x 2^e`, exact for the parts of sums of doubles.
fn power_of_two(x: f64, e: i64) -> f64 {
    let half = (e / 2) as i32;
    x * 2f64.powi(half) * 2f64.powi(e as i32 - half)
}

#[cfg(test)]
#[allow(clippy::panic)] // a test says what it found
mod tests {
    use super::super::proof::check_solution;
    use super::super::ray::check_ray;
    use super::*;
    use fastrand::Rng;

    fn never() -> bool {
        false
    }

    #[test]
    fn every_start_of_degenerate_integer_problems_ends_in_a_proof() {
        let mut draw = Rng::with_seed(3);
        let (mut solved, mut rays) = (0, 0);
        for n in [1, 2, 3, 4, 5] {
            for _ in 0..60 {
                let a: Vec<f64> = (0..n * n).map(|_| f64::from(draw.u32(..4)) - 1.0).collect();
                let q: Vec<f64> = (0..n).map(|_| f64::from(draw.u32(..4)) - 2.0).collect();
                let lcp = Problem::new(&a, &q);
                let alpha: Vec<usize> = (0..n).filter(|_| draw.bool()).collect();
                match repair(lcp, &alpha, &never) {
                    Repaired::Solved(s, pivots) => {
                        assert!(check_solution(lcp, &s.z) && pivots < 100);
                        solved += 1;
                    }
                    Repaired::Ray(ray) => {
                        assert!(check_ray(lcp, &vec![1.0; n], &ray));
                        rays += 1;
                    }
                    Repaired::Interrupted => panic!("not asked to stop"),
                }
            }
        }
        assert!(solved > 100 && rays > 20, "{solved} {rays}");
    }

    #[test]
    fn positive_definite_problems_are_solved_from_any_start() {
        let mut draw = Rng::with_seed(11);
        for n in [3, 8, 15] {
            let b: Vec<f64> = (0..n * n).map(|_| f64::from(draw.u32(..1000)) / 7.0 - 70.0).collect();
            let a: Vec<f64> = (0..n * n)
                .map(|ij| {
                    (0..n).map(|k| b[ij / n * n + k] * b[ij % n * n + k]).sum::<f64>() + f64::from(ij / n == ij % n)
                })
                .collect();
            let q: Vec<f64> = (0..n).map(|_| f64::from(draw.u32(..1000)) / 3.0 - 200.0).collect();
            let lcp = Problem::new(&a, &q);
            let alpha: Vec<usize> = (0..n).filter(|_| draw.bool()).collect();
            let Repaired::Solved(s, _) = repair(lcp, &alpha, &never) else { panic!("a ray on a P-matrix") };
            assert!(check_solution(lcp, &s.z));
            let Repaired::Solved(again, pivots) = repair(lcp, &s.alpha, &never) else { panic!("solved before") };
            assert_eq!((pivots, again.alpha), (0, s.alpha));
        }
    }

    /// The covering vector of a start may overflow: a path that followed its rounding went round in circles.
    #[test]
    fn a_covering_vector_beyond_the_doubles() {
        let (o, m) = (0.0, f64::MAX);
        #[rustfmt::skip]
        let a = [
            3.0, m, -m, o, o, -3.0,
            -3.0, 3.0, 3.0, -m, o, m,
            m, -3.0, -m, 3.0, -m, -m,
            3.0, 3.0, -m, o, 3.0, -3.0,
            m, 3.0, o, 3.0, m, 3.0,
            -3.0, -m, m, -m, o, m,
        ];
        let q = [-3.0, -3.0, -m, -m, -m, m];
        let lcp = Problem::new(&a, &q);
        for alpha in (0..64usize).step_by(7).map(|mask| (0..6).filter(|i| mask >> i & 1 == 1).collect::<Vec<_>>()) {
            let start: Vec<bool> = (0..6).map(|i| alpha.contains(&i)).collect();
            assert!(covering_vector(lcp, &alpha, &start).iter().flatten().all(|x| x.is_finite()));
            let asked = std::cell::Cell::new(0);
            let impatient = || asked.replace(asked.get() + 1) > 20_000;
            assert!(!matches!(repair(lcp, &alpha, &impatient), Repaired::Interrupted), "{alpha:?}");
        }
    }
}
