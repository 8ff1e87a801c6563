//! What is right, an honest "no", or wrong: every claim is recomputed in exact arithmetic on the given binary numbers.
//!
//! Whatever the status, the stated w and residuals are those of the stated z, to rounding.
//!
//! "Solved" is right when the documented contract holds exactly:
//! * z is finite and nonnegative;
//! * in the caller's units `|min(z, w)|_i <= 10 tol max|q| + 8 eps (|A||z| + |q|)_i` in every row;
//! * on the equilibrated problem `max|min(z', w')| <= tol max(1, max|z'|)`, and `<= max(tol, 1e-6)`. The scaling is the
//!   library's, since it is part of the definition, checked to be one: powers of two, every nonzero row and column with
//!   its largest entry in [1/4, 2).
//!
//! Instead of the last two an exact certificate may prove the solution that z is, each entry rounded to the nearest double.
//! It is wrong, too, when the problem has no exact solution at all (decided where its `solvable::core` has order
//! [`ENUMERATED`] at most by trying every support, for any n by another method's exact Farkas vector) unless it is nearly solvable: unless some `(A + E, q + e)`
//! with `|E| <= omega |A|`, `|e| <= omega |q|`, entry by entry, zeros kept, `omega = sqrt(tol)`, is solved by the point exactly.
//!
//! "Infeasible" is right when `y >= 0`, `q'y < 0`, and `A'y <= 0` exactly. "Nearly infeasible" is right when `A'y` exceeds 0 by
//! rounding of its own sums and no z >= 0 with `A z + q >= 0` has a sum below the stated bound, which is 1e10 at least in
//! equilibrated units. A certificate that says it is exact must be exact.

use crate::exact::{Wide, is_rounded, parts, wide_sum};
use crate::problems::Problem;
use crate::solvable;
use lcpstar::equilibrate::Rows as _;
use lcpstar::scaling::Scaling;
use lcpstar::{Certificate, Lcp, Solution, Status};
use std::cell::OnceCell;
use std::iter::once;

/// Largest order at which every support is tried.
pub const ENUMERATED: usize = 5;

/// What was said about a problem.
#[derive(Clone, Debug)]
pub struct Answer {
    pub status: Status,
    pub z: Vec<f64>,
    pub w: Vec<f64>,
    pub residual: f64,
    pub natural_residual: f64,
    pub certificate: Option<Certificate>,
}

impl From<Solution> for Answer {
    fn from(s: Solution) -> Self {
        Self {
            status: s.status(),
            z: s.z().to_vec(),
            w: s.w().to_vec(),
            residual: s.residual(),
            natural_residual: s.natural_residual(),
            certificate: s.certificate().cloned(),
        }
    }
}

/// The score of one answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Score {
    Right,
    /// Within `tol` of a problem that it solves, but the given one has no solution.
    RightNearly,
    No,
    Wrong(String),
    NotFinite(String),
}

/// One problem before the referee: what is known about it is found out once.
pub struct Case<'a> {
    pub problem: &'a Problem,
    scaling: OnceCell<Result<Scaling, String>>,
    core: OnceCell<Problem>,
    solvable: OnceCell<bool>,
    /// An exact Farkas vector was seen.
    pub refuted: OnceCell<()>,
}

/// Exact rows of one point.
struct Rows {
    w: Vec<Wide>,
    /// `|A||z| + |q|`.
    m: Vec<Wide>,
}

impl<'a> Case<'a> {
    pub fn new(problem: &'a Problem) -> Self {
        Self {
            problem,
            scaling: OnceCell::new(),
            core: OnceCell::new(),
            solvable: OnceCell::new(),
            refuted: OnceCell::new(),
        }
    }

    /// Scores `answer`, which was given for the tolerance `tol`.
    pub fn score(&self, answer: &Answer, tol: f64) -> Score {
        let numbers = answer.z.iter().chain(&answer.w).chain([&answer.residual, &answer.natural_residual]);
        if answer.z.len() != self.problem.n || answer.w.len() != self.problem.n {
            return Score::Wrong("z or w has the wrong length".into());
        }
        if let Some(x) = numbers.clone().find(|x| !x.is_finite()) {
            return Score::NotFinite(format!("{x} in the result ({})", answer.status.as_str()));
        }
        if let Err(why) = self.certificate(answer).and_then(|()| self.numbers(answer)) {
            return Score::Wrong(why);
        }
        let verdict = match answer.status {
            Status::Solved => self.solved(answer, tol),
            Status::Infeasible | Status::NearlyInfeasible => self.against(answer),
            _ => return Score::No,
        };
        match verdict {
            Ok(true) => Score::Right,
            Ok(false) => Score::RightNearly,
            Err(why) => Score::Wrong(why),
        }
    }

    fn rows(&self, z: &[f64]) -> Rows {
        let (w, m) = (0..self.problem.n)
            .map(|i| {
                let (row, q) = (self.problem.row(i), self.problem.q[i]);
                let terms = row
                    .iter()
                    .copied()
                    .zip(z.iter().copied())
                    .filter(|t| t.0 != 0.0 && t.1 != 0.0)
                    .chain(once((q, 1.0)));
                let sizes = terms.clone().map(|(x, y)| (x.abs(), y.abs()));
                (wide_sum(terms), wide_sum(sizes))
            })
            .unzip();
        Rows { w, m }
    }

    /// The stated w and residuals are those of z: w to the rounding of a plain sum, the residuals as far as w.
    fn numbers(&self, answer: &Answer) -> Result<(), String> {
        let n = self.problem.n;
        let rows = self.rows(&answer.z);
        let scaling = self.scaling()?;
        let eps = Wide::new(f64::EPSILON);
        let plain = Wide::new((n as f64 + 2.0) * f64::EPSILON / 2.0);
        let tiny = Wide::new(16.0 * f64::MIN_POSITIVE);
        let (mut natural, mut violation) = ([Wide::ZERO; 2], [Wide::ZERO; 2]);
        let mut largest = Wide::ONE;
        for i in 0..n {
            let (z, w) = (Wide::new(answer.z[i]), rows.w[i]);
            let room = eps.times(w.abs()).plus(plain.times(rows.m[i])).plus(tiny);
            if !w.plus(Wide::new(answer.w[i]).neg()).abs().at_most(room) {
                return Err(format!("row {i}: w = {:e} stated, {:e} exact", answer.w[i], w.to_f64()));
            }
            let (of_z, of_w) = (i64::from(scaling.q - scaling.columns[i]), i64::from(scaling.q + scaling.rows[i]));
            let zs = z.shifted(of_z);
            let scaled = zs.min(w.shifted(of_w)).abs();
            natural = [natural[0].max(z.min(w).abs()), natural[1].max(room)];
            violation = [violation[0].max(scaled), violation[1].max(room.shifted(of_w))];
            largest = largest.max(zs.abs());
        }
        let residual = violation.map(|v| v.over(largest));
        for (name, stated, [exact, room]) in
            [("natural_residual", answer.natural_residual, natural), ("residual", answer.residual, residual)]
        {
            let room = room.plus(exact.times(Wide::new(1e-9))).plus(tiny);
            if !exact.plus(Wide::new(stated).neg()).abs().at_most(room) {
                return Err(format!("{name} = {stated:e} stated, {:e} exact", exact.to_f64()));
            }
        }
        Ok(())
    }

    /// `Ok(true)`: right. `Ok(false)`: right for a problem within `tol` of this one, which has no solution itself.
    fn solved(&self, answer: &Answer, tol: f64) -> Result<bool, String> {
        let n = self.problem.n;
        if let Some(i) = answer.z.iter().position(|&x| x < 0.0) {
            return Err(format!("z[{i}] = {} is negative", answer.z[i]));
        }
        if let Some(Certificate::Solution { exact: Some(exact), .. }) = &answer.certificate {
            return is_rounded(&answer.z, exact).map(|()| true);
        }
        let z: Vec<Wide> = answer.z.iter().map(|&x| Wide::new(x)).collect();
        let rows = self.rows(&answer.z);
        let largest_q = Wide::new(self.problem.q.iter().fold(0.0, |m: f64, x| m.max(x.abs())));
        let allowed = Wide::new(10.0).times(Wide::new(tol)).times(largest_q);
        for i in 0..n {
            let violation = z[i].min(rows.w[i]).abs();
            if !violation.at_most(allowed.plus(Wide::new(8.0 * f64::EPSILON).times(rows.m[i]))) {
                return Err(format!("row {i}: |min(z, w)| = {:.3e} too large", violation.to_f64()));
            }
        }
        let scaling = self.scaling()?;
        let zs: Vec<Wide> = (0..n).map(|i| z[i].shifted(i64::from(scaling.q - scaling.columns[i]))).collect();
        let to_w = |i: usize| i64::from(scaling.q + scaling.rows[i]);
        let violation = (0..n).map(|i| zs[i].min(rows.w[i].shifted(to_w(i))).abs()).fold(Wide::ZERO, Wide::max);
        let residual = violation.over(zs.iter().fold(Wide::ONE, |m, z| m.max(*z)));
        if !residual.at_most(Wide::new(tol)) || !violation.at_most(Wide::new(tol.max(1e-6))) {
            let (r, v) = (residual.to_f64(), violation.to_f64());
            return Err(format!("equilibrated residual {r:.3e}, violation {v:.3e}"));
        }
        self.near_solvable(answer, &rows, &zs, to_w, tol)
    }

    fn near_solvable(
        &self,
        answer: &Answer,
        rows: &Rows,
        zs: &[Wide],
        to_w: impl Fn(usize) -> i64,
        tol: f64,
    ) -> Result<bool, String> {
        let n = self.problem.n;
        let inside: Vec<bool> = (0..n).map(|i| rows.w[i].shifted(to_w(i)).cmp(zs[i]).is_lt()).collect();
        if self.refuted.get().is_none() && self.core().n > ENUMERATED {
            return Ok(true);
        }
        let support = || -> Vec<usize> { (0..n).filter(|&i| inside[i] && answer.z[i] > 0.0).collect() };
        let found = || n <= ENUMERATED && solvable::support_solves(self.problem, &support());
        if self.refuted.get().is_none() && (found() || self.is_solvable()) {
            return Ok(true);
        }
        // The point itself, or with z_i = 0 where z_i is the smaller of its pair.
        let cleaned: Vec<f64> = (0..n).map(|i| if inside[i] { answer.z[i] } else { 0.0 }).collect();
        let rows_cleaned = self.rows(&cleaned);
        let distance = distance(&answer.z, rows).min(distance(&cleaned, &rows_cleaned));
        if distance.at_most(Wide::new(1.000_001 * tol.sqrt())) {
            Ok(false)
        } else {
            Err(format!(
                "no solution exists, and the point is {:.1e} away from any problem it solves",
                distance.to_f64()
            ))
        }
    }

    /// Whether it has an exact solution; for a core of order [`ENUMERATED`] at most.
    pub fn is_solvable(&self) -> bool {
        *self.solvable.get_or_init(|| solvable::is_solvable(self.core()))
    }

    /// The part of the problem that decides whether it has a solution.
    pub fn core(&self) -> &Problem {
        self.core.get_or_init(|| solvable::core(self.problem))
    }

    /// The library's scaling, once it is seen to be an equilibration.
    pub(crate) fn scaling(&self) -> Result<&Scaling, String> {
        let check = || {
            let Problem { n, a, q } = self.problem.clone();
            let lcp = Lcp::new(n, a, q).map_err(|e| e.to_string())?;
            let scaling = lcp.scaling();
            let exponent = |x: f64, e: i32| {
                let (m, f) = parts(x);
                (m != 0).then(|| f + 63 - i64::from(m.unsigned_abs().leading_zeros()) + i64::from(e))
            };
            let a = |i: usize, j: usize| exponent(lcp.row(i)[j], scaling.rows[i] + scaling.columns[j]);
            for i in 0..n {
                for largest in [(0..n).filter_map(|j| a(i, j)).max(), (0..n).filter_map(|j| a(j, i)).max()] {
                    if largest.is_some_and(|e| !(-2..=0).contains(&e)) {
                        return Err(format!("row or column {i} is not equilibrated: 2^{largest:?}"));
                    }
                }
            }
            let q = (0..n).filter_map(|i| exponent(lcp.q()[i], scaling.rows[i] + scaling.q)).max();
            if q.is_some_and(|e| e != -1) {
                return Err(format!("q is not equilibrated: 2^{q:?}"));
            }
            Ok(scaling)
        };
        self.scaling.get_or_init(check).as_ref().map_err(Clone::clone)
    }
}

/// The least omega such that `|E| <= omega |A|`, `|e| <= omega |q|` and z solves LCP(q + e, A + E) exactly: row by row
/// `|w_i|` (where `z_i > 0`) or `max(-w_i, 0)` over `(|A||z| + |q|)_i`. [Oettli and Prager]
fn distance(z: &[f64], rows: &Rows) -> Wide {
    let row = |i: usize| {
        let w = rows.w[i];
        let missing = if z[i] > 0.0 { w.abs() } else { w.neg().max(Wide::ZERO) };
        if missing.is_zero() { Wide::ZERO } else { missing.over(rows.m[i]) }
    };
    (0..z.len()).map(row).fold(Wide::ZERO, Wide::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lcpstar::exact::dyadic::RationalVec;

    fn said(status: Status, z: &[f64], w: &[f64], residual: f64) -> Answer {
        let natural_residual = z.iter().zip(w).map(|(z, w)| z.min(*w).abs()).fold(0.0, f64::max);
        Answer { status, z: z.to_vec(), w: w.to_vec(), residual, natural_residual, certificate: None }
    }

    #[test]
    fn a_liar_is_caught() {
        let problem = Problem { n: 1, a: vec![2.0], q: vec![-1.0] };
        let case = Case::new(&problem);
        let score = |z: f64, w: f64| case.score(&said(Status::Solved, &[z], &[w], 0.0), 1e-9);
        assert_eq!(score(0.5, 0.0), Score::Right);
        assert!(matches!(score(0.5 + 1e-6, 2e-6), Score::Wrong(_)));
        assert!(matches!(score(0.5, 0.1), Score::Wrong(_)));
        assert!(matches!(score(-0.5, 0.0), Score::Wrong(_)));
        assert!(matches!(score(f64::NAN, 0.0), Score::NotFinite(_)));
        assert_eq!(case.score(&said(Status::SecondaryRay, &[0.0], &[-1.0], 0.5), 1e-9), Score::No);
        assert!(matches!(case.score(&said(Status::SecondaryRay, &[0.0], &[-1.0], 1.0), 1e-9), Score::Wrong(_)));
    }

    #[test]
    fn nearly_solvable_is_told_from_not_solvable() {
        // w = -1e-12 with z = 0 and nothing to push it: no solution; w = 0 would do.
        let unsolvable = Problem { n: 2, a: vec![1.0, 0.0, -1.0, 0.0], q: vec![-1.0, 1.0 - 1e-12] };
        let residual = 0.5 * (1.0 - (1.0 - 1e-12));
        let said_of = said(Status::Solved, &[1.0, 0.0], &[0.0, -1e-12], residual);
        let answer = |tol| Case::new(&unsolvable).score(&said_of, tol);
        assert_eq!(answer(1e-9), Score::RightNearly);
        assert!(matches!(answer(1e-26), Score::Wrong(_)));
        // The same with a row so small that only its own numbers show the error.
        let hidden = Problem { n: 2, a: vec![1.0, 1.0, -1e-12, 0.0], q: vec![-1.0, 0.0] };
        assert!(matches!(
            Case::new(&hidden).score(&said(Status::Solved, &[1.0, 0.0], &[0.0, -1e-12], 1e-11), 1e-9),
            Score::Wrong(_)
        ));
    }

    #[test]
    fn a_farkas_vector_is_recomputed() {
        let problem = Problem { n: 2, a: vec![1.0, -1.0, -1.0, 1.0], q: vec![-1.0, -1.0] };
        let score = |y: [f64; 2]| {
            let certificate = Some(Certificate::Infeasible { y: RationalVec::from_f64(&y) });
            let answer = Answer { certificate, ..said(Status::Infeasible, &[0.0; 2], &[-1.0; 2], 0.5) };
            Case::new(&problem).score(&answer, 1e-9)
        };
        assert_eq!(score([1.0, 1.0]), Score::Right);
        assert!(matches!(score([1.0, 0.999]), Score::Wrong(_)));
        assert!(matches!(score([-1.0, 1.0]), Score::Wrong(_)));
    }
}
