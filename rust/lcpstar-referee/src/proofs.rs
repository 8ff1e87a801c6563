//! Certificates before the referee: exact solutions, Farkas vectors, bounds, vectors against sufficiency.

use crate::exact::{Wide, integer_form, parts, sign, wide_sum};
use crate::problems::Problem;
use lcpstar::exact::dyadic::RationalVec;
use lcpstar::scaling::Scaling;
use num_bigint::BigInt;
use num_traits::Signed;
use std::iter::once;

impl Problem {
    /// "Nearly infeasible" needs a bound that is rigorous and large: `0 <= y'(A z + q) <= max(A'y) sum(z) + q'y`.
    pub(crate) fn nearly_refuted(&self, scaling: &Scaling, y: &[f64], bound: f64) -> Result<(), String> {
        let n = self.n;
        if y.len() != n || y.iter().any(|y| !y.is_finite() || *y < 0.0) || !bound.is_finite() {
            return Err("y or the bound is no nonnegative number".into());
        }
        let qy = wide_sum(self.q.iter().copied().zip(y.iter().copied()));
        if !qy.neg().is_positive() {
            return Err(format!("q'y = {:e} is not negative", qy.to_f64()));
        }
        for j in 0..n {
            let terms = (0..n).map(|i| (self.a[i * n + j], y[i]));
            let sum = wide_sum(terms.clone());
            if !sum.is_positive() {
                continue;
            }
            let size = wide_sum(terms.map(|(a, y)| (a.abs(), y)));
            if !sum.at_most(Wide::new(65.0 * f64::EPSILON).times(size)) {
                return Err(format!("(A'y)_{j} = {:e} is not rounding", sum.to_f64()));
            }
            if !sum.times(Wide::new(bound)).at_most(qy.neg()) {
                return Err(format!("the bound {bound:e} is not rigorous in column {j}"));
            }
            let scaled = sum.shifted(i64::from(scaling.columns[j]));
            if !scaled.times(Wide::new(0.99e10)).at_most(qy.neg().shifted(i64::from(scaling.q))) {
                return Err(format!("(A'y)_{j} = {:e} rules out too little", sum.to_f64()));
            }
        }
        Ok(())
    }

    /// `z >= 0, A z + q >= 0, z'(A z + q) = 0` exactly.
    ///
    /// # Errors
    /// What does not hold.
    pub fn exact_solution(&self, z: &RationalVec) -> Result<(), String> {
        if z.numerators.len() != self.n || !z.denominator.is_positive() {
            return Err("the exact solution is malformed".into());
        }
        for i in 0..self.n {
            let terms = self.row(i).iter().copied().zip(&z.numerators);
            let w = sign(&integer_form(terms.chain(once((self.q[i], &z.denominator)))));
            let z = sign(&z.numerators[i]);
            if z < 0 || w < 0 || z * w != 0 {
                return Err(format!("the exact solution is none: signs {z}, {w} in pair {i}"));
            }
        }
        Ok(())
    }

    /// `r >= 0, A r >= 0, r'A r = 0` exactly: a direction in which the solution set may go on.
    ///
    /// # Errors
    /// What does not hold.
    pub fn exact_direction(&self, r: &RationalVec) -> Result<(), String> {
        let homogeneous = Problem { q: vec![0.0; self.n], ..self.clone() };
        homogeneous.exact_solution(r)
    }

    /// `x_i (B x)_i <= 0` for all i, `< 0` for one; B is A or A'.
    pub(crate) fn not_sufficient(&self, x: &RationalVec, transposed: bool) -> Result<(), String> {
        let Problem { n, a, .. } = self;
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

    /// `y >= 0, A'y <= 0, q'y < 0` exactly.
    pub(crate) fn exact_farkas(&self, y: &RationalVec) -> Result<(), String> {
        let n = self.n;
        let form = |column: &dyn Fn(usize) -> f64| {
            let terms: Vec<(f64, &BigInt)> = (0..n).map(|i| (column(i), &y.numerators[i])).collect();
            sign(&integer_form(terms.into_iter()))
        };
        let good = y.numerators.iter().all(|y| sign(y) >= 0)
            && (0..n).all(|j| form(&|i| self.a[i * n + j]) <= 0)
            && form(&|i| self.q[i]) < 0;
        if !good {
            return Err("the exact Farkas vector is none".into());
        }
        Ok(())
    }
}

/// Whether each z_i is the double nearest to the exact one: no further than half a unit in the last place.
pub(crate) fn is_rounded(z: &[f64], exact: &RationalVec) -> Result<(), String> {
    const LOWEST: i64 = 1075;
    for (i, (&z, numerator)) in z.iter().zip(&exact.numerators).enumerate() {
        let (mantissa, exponent) = parts(z);
        let stated = (BigInt::from(mantissa) << (exponent + LOWEST)) * &exact.denominator;
        let off = (stated - (numerator << LOWEST)).abs();
        if off > (numerator.abs() << (LOWEST - 53)) + &exact.denominator {
            return Err(format!("z[{i}] = {z:e} is not the proved one, rounded"));
        }
    }
    Ok(())
}
