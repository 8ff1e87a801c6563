//! Certificates before the referee: exact solutions, Farkas vectors, bounds, vectors against sufficiency.

use crate::exact::{Wide, integer_form, sign, wide_sum};
use crate::problems::Problem;
use crate::referee::{Answer, Case};
use lcpstar::exact::dyadic::RationalVec;
use lcpstar::{Certificate, Status};
use num_bigint::BigInt;
use std::iter::once;

impl Case<'_> {
    pub(crate) fn against(&self, answer: &Answer) -> Result<bool, String> {
        if answer.status == Status::Infeasible { Self::infeasible(answer) } else { self.nearly_infeasible(answer) }
    }

    /// "Infeasible" needs an exact Farkas vector, which [`Case::certificate`] has checked.
    fn infeasible(answer: &Answer) -> Result<bool, String> {
        match &answer.certificate {
            Some(Certificate::Infeasible { .. }) => Ok(true),
            _ => Err("infeasible without an exact certificate".into()),
        }
    }

    /// "Nearly infeasible" needs a bound that is rigorous and large: `0 <= y'(A z + q) <= max(A'y) sum(z) + q'y`.
    fn nearly_infeasible(&self, answer: &Answer) -> Result<bool, String> {
        let Some(Certificate::NearlyInfeasible { y, bound }) = &answer.certificate else {
            return Err("nearly infeasible without its certificate".into());
        };
        let n = self.problem.n;
        if y.len() != n || y.iter().any(|y| !y.is_finite() || *y < 0.0) || !bound.is_finite() {
            return Err("y or the bound is no nonnegative number".into());
        }
        let qy = wide_sum(self.problem.q.iter().copied().zip(y.iter().copied()));
        if !qy.neg().is_positive() {
            return Err(format!("q'y = {:e} is not negative", qy.to_f64()));
        }
        let scaling = self.scaling()?;
        for j in 0..n {
            let terms = (0..n).map(|i| (self.problem.a[i * n + j], y[i]));
            let sum = wide_sum(terms.clone());
            if !sum.is_positive() {
                continue;
            }
            let size = wide_sum(terms.map(|(a, y)| (a.abs(), y)));
            if !sum.at_most(Wide::new(65.0 * f64::EPSILON).times(size)) {
                return Err(format!("(A'y)_{j} = {:e} is not rounding", sum.to_f64()));
            }
            if !sum.times(Wide::new(*bound)).at_most(qy.neg()) {
                return Err(format!("the bound {bound:e} is not rigorous in column {j}"));
            }
            let scaled = sum.shifted(i64::from(scaling.columns[j]));
            if !scaled.times(Wide::new(0.99e10)).at_most(qy.neg().shifted(i64::from(scaling.q))) {
                return Err(format!("(A'y)_{j} = {:e} rules out too little", sum.to_f64()));
            }
        }
        Ok(true)
    }

    /// Whether a certificate that holds exact numbers is what it says, and fits the status.
    pub(crate) fn certificate(&self, answer: &Answer) -> Result<(), String> {
        let said = answer.status;
        match &answer.certificate {
            Some(Certificate::Solution { exact: Some(z), .. }) => {
                fits(matches!(said, Status::Solved | Status::NumericalBreakdown))?;
                self.exact_solution(z)
            }
            Some(Certificate::Infeasible { y }) => {
                fits(said == Status::Infeasible)?;
                self.exact_farkas(y)
            }
            Some(Certificate::NearlyInfeasible { .. }) => fits(said == Status::NearlyInfeasible),
            Some(Certificate::NotSufficient(found)) => {
                fits(said != Status::Solved)?;
                self.not_sufficient(&found.x, found.transposed)
            }
            _ => Ok(()),
        }
    }

    /// `z >= 0, A z + q >= 0, z'(A z + q) = 0` exactly.
    pub fn exact_solution(&self, z: &RationalVec) -> Result<(), String> {
        for i in 0..self.problem.n {
            let terms = self.problem.row(i).iter().copied().zip(&z.numerators);
            let w = sign(&integer_form(terms.chain(once((self.problem.q[i], &z.denominator)))));
            let z = sign(&z.numerators[i]);
            if z < 0 || w < 0 || z * w != 0 {
                return Err(format!("the exact solution is none: signs {z}, {w} in pair {i}"));
            }
        }
        Ok(())
    }

    /// `r >= 0, A r >= 0, r'A r = 0` exactly: a direction in which the solution set may go on.
    pub fn exact_direction(&self, r: &RationalVec) -> Result<(), String> {
        let homogeneous = Problem { q: vec![0.0; self.problem.n], ..self.problem.clone() };
        Case::new(&homogeneous).exact_solution(r)
    }

    /// `x_i (B x)_i <= 0` for all i, `< 0` for one; B is A or A'.
    fn not_sufficient(&self, x: &RationalVec, transposed: bool) -> Result<(), String> {
        let Problem { n, a, .. } = self.problem;
        let entry = |i: usize, j: usize| if transposed { a[j * n + i] } else { a[i * n + j] };
        let product = |i: usize| {
            let terms: Vec<(f64, &BigInt)> = (0..*n).map(|j| (entry(i, j), &x.numerators[j])).collect();
            sign(&x.numerators[i]) * sign(&integer_form(terms.into_iter()))
        };
        let products: Vec<i32> = (0..*n).map(product).collect();
        if products.contains(&1) || !products.contains(&-1) {
            return Err(format!("the vector against sufficiency has the products {products:?}"));
        }
        Ok(())
    }

    fn exact_farkas(&self, y: &RationalVec) -> Result<(), String> {
        let n = self.problem.n;
        let form = |column: &dyn Fn(usize) -> f64| {
            let terms: Vec<(f64, &BigInt)> = (0..n).map(|i| (column(i), &y.numerators[i])).collect();
            sign(&integer_form(terms.into_iter()))
        };
        let good = y.numerators.iter().all(|y| sign(y) >= 0)
            && (0..n).all(|j| form(&|i| self.problem.a[i * n + j]) <= 0)
            && form(&|i| self.problem.q[i]) < 0;
        if !good {
            return Err("the exact Farkas vector is none".into());
        }
        let _ = self.refuted.set(());
        Ok(())
    }
}

fn fits(it_does: bool) -> Result<(), String> {
    if it_does { Ok(()) } else { Err("the certificate does not fit the status".into()) }
}
