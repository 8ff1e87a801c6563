//! Is FEA(q, A) empty? Exact pivoting from a basis that floating point proposed, with a proof either way.
//!
//! As in [`repair`](super::repair) no tableau is kept: every pivot solves p-adically with a square block of A.

use super::dyadic::{RationalVec, Scaled, linear_form};
use super::padic::{Block, Unsolved};
use crate::problem::Problem;
use crate::var::Var;
use num_bigint::BigInt;
use num_traits::{Signed, Zero};

/// Whether FEA(q, A) is empty, with a proof either way.
#[derive(Clone, Debug)]
pub enum Feasibility {
    /// `z >= 0`, `A z + q >= 0`.
    Feasible(RationalVec),
    /// A Farkas vector: `y >= 0`, `A'y <= 0`, `q'y < 0`.
    Infeasible(RationalVec),
    /// `stop` said so.
    Interrupted,
}

/// Costs of the feasibility problem: fixed, positive and without relations, so that dual ties are improbable.
#[must_use]
pub fn costs(n: usize) -> Vec<f64> {
    (0..n as u64)
        .map(|j| {
            let hash = (j + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d;
            1.0 + (hash.wrapping_mul(0xd129_0d3b_3b2f_a6ad) >> 11) as f64 / (1u64 << 53) as f64
        })
        .collect()
}

/// Decides `{z >= 0, A z + q >= 0}` by exact pivoting from the basis with the z's `beta` basic and the w's of `rho`
/// nonbasic, `|rho| = |beta|`; a singular start falls back to z = 0.
///
/// Dual simplex steps for [`costs`], from the last basis of a floating-point simplex usually none or a few; after
/// `20 + 2 n` of them least-index (criss-cross) steps, which are finite from any basis. Every verdict is exact. Three
/// p-adic solves a pivot. Call it on the equilibrated problem, in which the costs are of one size.
#[must_use]
pub fn feasibility(lcp: Problem<'_>, rho: &[usize], beta: &[usize], stop: &dyn Fn() -> bool) -> Feasibility {
    let mut state = Crisscross { lcp, rho: rho.to_vec(), beta: beta.to_vec(), cost: costs(lcp.n()) };
    let mut pivots = 0;
    loop {
        match state.step(pivots < 20 + 2 * lcp.n(), stop) {
            Ok(Some(verdict)) => return verdict,
            Ok(None) => pivots += 1,
            Err(Unsolved::Singular) if !state.rho.is_empty() => {
                (state.rho, state.beta) = (vec![], vec![]);
            }
            Err(_) => return Feasibility::Interrupted,
        }
    }
}

struct Crisscross<'a> {
    lcp: Problem<'a>,
    rho: Vec<usize>,
    beta: Vec<usize>,
    cost: Vec<f64>,
}

impl Crisscross<'_> {
    /// One pivot, or the verdict. Variables are numbered z_0.., then w_0..; a dual simplex step takes the most negative
    /// basic variable and the least ratio, another step the least index for both.
    fn step(&mut self, dual_simplex: bool, stop: &dyn Fn() -> bool) -> Result<Option<Feasibility>, Unsolved> {
        let (lcp, n, k) = (self.lcp, self.lcp.n(), self.rho.len());
        let block = Block::new(k, |i, j| lcp.row(self.rho[i])[self.beta[j]], stop)?;
        let z = block.solve(&scaled(self.rho.iter().map(|&i| -lcp.q()[i])), stop)?;
        let Some(leaving) = self.leaving(&z, dual_simplex) else {
            let mut numerators = vec![BigInt::zero(); n];
            for (&j, v) in self.beta.iter().zip(z.numerators) {
                numerators[j] = v;
            }
            return Ok(Some(Feasibility::Feasible(RationalVec { numerators, denominator: z.denominator })));
        };
        // The row of the leaving variable: x = q'y + (A'y)_N z_N - y_rho w_rho, from one transposed solve.
        let transposed = Block::new(k, |i, j| lcp.row(self.rho[j])[self.beta[i]], stop)?;
        let rhs = self.beta.iter().map(|&j| match leaving {
            Var::W(i) => lcp.row(i)[j],
            Var::Z(i) => f64::from(u8::from(i == j)),
            Var::Z0 => 0.0,
        });
        let solved = transposed.solve(&scaled(rhs), stop)?;
        let mut y = vec![BigInt::zero(); n];
        for (&i, v) in self.rho.iter().zip(&solved.numerators) {
            y[i] = -v;
        }
        if let Var::W(i) = leaving {
            y[i] = solved.denominator.clone();
        }
        let column = |j: usize| linear_form((0..n).map(|i| (lcp.row(i)[j], &y[i])));
        let rising_z = (0..n).filter(|j| !self.beta.contains(j)).map(|j| (Var::Z(j), column(j)));
        let rising_w = self.rho.iter().map(|&i| (Var::W(i), Scaled { value: -&y[i], exponent: 0 }));
        let rising: Vec<(Var, Scaled)> = rising_z.chain(rising_w).filter(|(_, x)| x.value.is_positive()).collect();
        let entering = if dual_simplex {
            let reduced = self.reduced_costs(&transposed, stop)?;
            let ratio = |(m, x): &(Var, Scaled)| {
                let x = RationalVec::from_scaled(vec![x.clone()], solved.denominator.clone()).to_f64()[0];
                let cost = match *m {
                    Var::Z(j) => reduced[j],
                    Var::W(i) => reduced[n + i],
                    Var::Z0 => 0.0,
                };
                cost.max(0.0) / x
            };
            rising.iter().map(|r| (r.0, ratio(r))).min_by(|a, b| a.1.total_cmp(&b.1)).map(|r| r.0)
        } else {
            rising.iter().map(|r| r.0).min_by_key(|&m| index(m, n))
        };
        match entering {
            None => {
                let y = RationalVec { numerators: y, denominator: solved.denominator };
                return Ok(Some(Feasibility::Infeasible(y)));
            }
            Some(Var::Z(j)) => self.beta.push(j),
            Some(Var::W(i)) => self.rho.retain(|&r| r != i),
            Some(Var::Z0) => {}
        }
        match leaving {
            Var::Z(j) => self.beta.retain(|&b| b != j),
            Var::W(i) => self.rho.push(i),
            Var::Z0 => {}
        }
        Ok(None)
    }

    /// A negative basic variable: the most negative one, or that of least index.
    fn leaving(&self, z: &RationalVec, most_negative: bool) -> Option<Var> {
        let (lcp, n) = (self.lcp, self.lcp.n());
        let basic_z =
            self.beta.iter().zip(&z.numerators).map(|(&j, v)| (Var::Z(j), Scaled { value: v.clone(), exponent: 0 }));
        let basic_w = (0..n).filter(|i| !self.rho.contains(i)).map(|i| {
            let terms = self.beta.iter().zip(&z.numerators).map(|(&j, v)| (lcp.row(i)[j], v));
            (Var::W(i), linear_form(terms.chain(std::iter::once((lcp.q()[i], &z.denominator)))))
        });
        let negative = basic_z.chain(basic_w).filter(|(_, x)| x.value.is_negative());
        if most_negative {
            let size = |x: Scaled| RationalVec::from_scaled(vec![x], z.denominator.clone()).to_f64()[0];
            negative.map(|(m, x)| (m, size(x))).min_by(|a, b| a.1.total_cmp(&b.1)).map(|r| r.0)
        } else {
            negative.map(|r| r.0).min_by_key(|&m| index(m, n))
        }
    }

    /// Reduced costs of the nonbasic variables, rounded: z's, then w's.
    fn reduced_costs(&self, transposed: &Block, stop: &dyn Fn() -> bool) -> Result<Vec<f64>, Unsolved> {
        let n = self.lcp.n();
        let u = transposed.solve(&scaled(self.beta.iter().map(|&j| self.cost[j])), stop)?;
        let mut reduced = vec![0.0; 2 * n];
        for (&i, x) in self.rho.iter().zip(u.to_f64()) {
            reduced[n + i] = x;
        }
        for j in (0..n).filter(|j| !self.beta.contains(j)) {
            let terms = self.rho.iter().zip(&u.numerators).map(|(&i, v)| (-self.lcp.row(i)[j], v));
            let cost = linear_form(terms.chain(std::iter::once((self.cost[j], &u.denominator))));
            reduced[j] = RationalVec::from_scaled(vec![cost], u.denominator.clone()).to_f64()[0];
        }
        Ok(reduced)
    }
}

fn scaled(values: impl Iterator<Item = f64>) -> Vec<Scaled> {
    values.map(Scaled::from_f64).collect()
}

/// The place of a variable in the order of least-index rules.
fn index(member: Var, n: usize) -> usize {
    match member {
        Var::Z(j) => j,
        Var::W(i) => n + i,
        Var::Z0 => 2 * n,
    }
}

#[cfg(test)]
#[allow(clippy::panic)] // a test says what it found
mod tests {
    use super::super::farkas::check_farkas;
    use super::*;
    use fastrand::Rng;

    fn never() -> bool {
        false
    }

    #[test]
    fn feasibility_is_proved_either_way() {
        let mut draw = Rng::with_seed(5);
        let (mut yes, mut no) = (0, 0);
        for n in [1, 2, 4, 6] {
            for _ in 0..80 {
                let a: Vec<f64> = (0..n * n).map(|_| f64::from(draw.u32(..5)) - 3.0).collect();
                let q: Vec<f64> = (0..n).map(|_| f64::from(draw.u32(..5)) - 3.0).collect();
                let lcp = Problem::new(&a, &q);
                match feasibility(lcp, &[], &[], &never) {
                    Feasibility::Feasible(z) => {
                        assert!(z.numerators.iter().all(|x| !x.is_negative()));
                        for i in 0..n {
                            let row = lcp.row(i).iter().copied().zip(&z.numerators);
                            let w = linear_form(row.chain(std::iter::once((lcp.q()[i], &z.denominator))));
                            assert!(!w.value.is_negative());
                        }
                        yes += 1;
                    }
                    Feasibility::Infeasible(y) => {
                        assert!(check_farkas(lcp, &y));
                        no += 1;
                    }
                    Feasibility::Interrupted => panic!("not asked to stop"),
                }
            }
        }
        assert!(yes > 50 && no > 50, "{yes} {no}");
    }
}
