//! Proofs that no z >= 0 has `A z + q >= 0`, or none of moderate size.
//!
//! Exactly, `y >= 0`, `A'y <= 0` and `q'y < 0` are a proof: `0 <= y'(A z + q) <= q'y < 0`. Where `delta = max_j (A'y)_j` is positive,
//! every feasible z has `0 <= delta sum(z) + q'y`, so that `sum(z) >= -q'y / delta`.

use crate::cutovers::REPAIR_UP_TO;
use crate::equilibrate::{Equilibrated, Rows};
use crate::exact::dyadic::{RationalVec, Scaled, linear_form};
use crate::exact::farkas::{check_farkas, repair_farkas};
use crate::linalg::dd::{two_prod, two_sum};
use crate::linalg::kernels::max_abs;
use crate::problem::Lcp;
use crate::scaling::{are_ordinary, exponent, times_power_of_two};
use num_traits::{Signed, ToPrimitive};

/// What was proved of FEA(q, A).
#[derive(Clone, Debug, PartialEq)]
pub enum Refutation {
    /// It is empty.
    Exact(Farkas),
    /// It holds no z of moderate size.
    Nearly(Nearly),
}

/// An exact Farkas vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Farkas(RationalVec);

impl Farkas {
    /// `y` if it is one, checked in rational numbers. O(n^2) operations on long integers.
    pub fn new(lcp: &Lcp, y: RationalVec) -> Option<Self> {
        check_farkas(lcp.view(), &y).then_some(Self(y))
    }

    /// The vector.
    #[must_use]
    pub fn into_vector(self) -> RationalVec {
        self.0
    }
}

/// A vector whose `A'y` exceeds 0 by no more than rounding, and the bound that follows.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearly {
    y: Vec<f64>,
    bound: f64,
}

impl Nearly {
    /// The vector and the bound.
    #[must_use]
    pub fn into_parts(self) -> (Vec<f64>, f64) {
        (self.y, self.bound)
    }
}

/// In equilibrated units no smaller bound is worth a statement.
const LARGE: f64 = 1e10;

/// Bits to which the entries of a candidate are rounded, beside the largest: what elimination left of a vector of small integers
/// becomes one again.
const ROUNDINGS: [i32; 3] = [44, 32, 20];

/// The best proof that comes from the multipliers `y` of the rows of the equilibrated problem: as they are, rounded to few bits, or
/// repaired. O(n^2); a repair costs an exact solve.
#[must_use]
pub fn refute<P: Rows>(problem: &Equilibrated<'_, P>, y: &[f64], stop: &dyn Fn() -> bool) -> Option<Refutation> {
    let y = to_caller(problem, y)?;
    let near = nearly(problem, &y)?;
    let rounded = ROUNDINGS.iter().map(|&bits| rounded(&y, bits));
    for y in std::iter::once(y.clone()).chain(rounded) {
        if is_farkas(problem.original, &y) {
            return Some(Refutation::Exact(Farkas(RationalVec::from_f64(&y))));
        }
    }
    let repaired = (y.len() <= REPAIR_UP_TO).then(|| problem.original.dense()).flatten();
    let repaired = repaired.and_then(|lcp| Farkas::new(&lcp, repair_farkas(lcp.view(), &y, stop)?));
    Some(repaired.map_or(Refutation::Nearly(near), Refutation::Exact))
}

/// Multipliers in the caller's units, `D_r y`, the largest entry near 1; negative ones are cut off.
fn to_caller<P: Rows>(problem: &Equilibrated<'_, P>, y: &[f64]) -> Option<Vec<f64>> {
    let rows = &problem.scaling.rows;
    if !max_abs(y).is_finite() || y.iter().any(|y| y.is_nan()) {
        return None;
    }
    let top = y.iter().zip(rows).filter(|(y, _)| **y > 0.0).map(|(&y, r)| exponent(y) + r).max()?;
    Some(y.iter().zip(rows).map(|(&y, r)| times_power_of_two(y.max(0.0), r - top)).collect())
}

/// Entries of y to `bits` bits below its largest.
fn rounded(y: &[f64], bits: i32) -> Vec<f64> {
    y.iter().map(|&y| times_power_of_two(times_power_of_two(y, bits).round(), -bits)).collect()
}

/// Sums `A'y` and `q'y`, each with a bound of its error and the sum of its terms' sizes.
struct Sums {
    columns: Vec<[f64; 3]>,
    q: [f64; 3],
}

impl Sums {
    /// Dot2 of [ORO05] in every column, row after row; right where no product under- or overflows.
    fn new<P: Rows>(lcp: &P, y: &[f64]) -> Self {
        let mut sums = vec![[0.0_f64; 3]; lcp.n()];
        let mut q = [0.0_f64; 3];
        let add = |[sum, error, size]: &mut [f64; 3], a: f64, y: f64| {
            let (p, e) = two_prod(a, y);
            let (s, f) = two_sum(*sum, p);
            (*sum, *error, *size) = (s, *error + (e + f), *size + p.abs());
        };
        for (i, &y) in y.iter().enumerate().filter(|(_, y)| **y > 0.0) {
            lcp.for_each(i, |j, a| add(&mut sums[j], a, y));
            add(&mut q, lcp.q()[i], y);
        }
        let terms = y.len() as f64 + 1.0;
        let close = |[sum, error, size]: [f64; 3]| {
            let value = sum + error;
            let rounding = f64::EPSILON * value.abs() + (terms * f64::EPSILON).powi(2) * size;
            [value, rounding + terms * f64::MIN_POSITIVE, size]
        };
        Self { columns: sums.into_iter().map(close).collect(), q: close(q) }
    }
}

/// Whether the doubles y are an exact Farkas vector: sums that rounding leaves open are taken in integers.
fn is_farkas<P: Rows>(lcp: &P, y: &[f64]) -> bool {
    let mut open: Vec<usize> = (0..lcp.n()).collect();
    let mut is_q_open = true;
    if [lcp.numbers(), lcp.q(), y].into_iter().all(are_ordinary) {
        let sums = Sums::new(lcp, y);
        if sums.q[0] > sums.q[1] || sums.columns.iter().any(|[sum, error, _]| sum > error) {
            return false;
        }
        is_q_open = sums.q[0] >= -sums.q[1];
        // A column without a term is zero exactly.
        open.retain(|&j| sums.columns[j][0] >= -sums.columns[j][1] && sums.columns[j][2] > 0.0);
    }
    let exact = RationalVec::from_f64(y);
    let sign =
        |terms: &[(f64, usize)]| linear_form(terms.iter().map(|&(a, i)| (a, &exact.numerators[i]))).value.signum();
    let support: Vec<usize> = (0..y.len()).filter(|&i| y[i] > 0.0).collect();
    if is_q_open && !sign(&support.iter().map(|&i| (lcp.q()[i], i)).collect::<Vec<_>>()).is_negative() {
        return false;
    }
    let mut place = vec![usize::MAX; lcp.n()];
    open.iter().enumerate().for_each(|(k, &j)| place[j] = k);
    let mut terms = vec![Vec::new(); open.len()];
    for &i in &support {
        lcp.for_each(i, |j, a| {
            if let Some(terms) = terms.get_mut(place[j]) {
                terms.push((a, i));
            }
        });
    }
    !terms.iter().any(|terms| sign(terms).is_positive())
}

/// The bound that the doubles y prove, where it is large and `A'y` exceeds 0 by rounding of its own sums only.
fn nearly<P: Rows>(problem: &Equilibrated<'_, P>, y: &[f64]) -> Option<Nearly> {
    if !problem.is_ordinary || !are_ordinary(y) {
        return nearly_in_integers(problem, y);
    }
    let sums = Sums::new(problem.original, y);
    let least = -(sums.q[0] + sums.q[1]);
    let is_rounding = |[sum, error, size]: &[f64; 3]| sum - error <= 64.0 * f64::EPSILON * size;
    if least <= 64.0 * f64::EPSILON * sums.q[2] || !sums.columns.iter().all(is_rounding) {
        return None;
    }
    let excess = |j: usize| (sums.columns[j][0] + sums.columns[j][1]).max(0.0);
    let delta = (0..y.len()).map(excess).fold(0.0, f64::max);
    // In equilibrated units: z' = s D_c^-1 z.
    let scaled = |j: usize| times_power_of_two(excess(j), problem.scaling.columns[j]);
    let largest = (0..y.len()).map(scaled).fold(0.0, f64::max);
    let is_large = largest * LARGE <= times_power_of_two(least, problem.scaling.q);
    // Three roundings, none of them upwards by more than eps / 2.
    let bound = (least / delta) * (1.0 - 4.0 * f64::EPSILON);
    is_large.then(|| Nearly { y: y.to_vec(), bound: bound.min(f64::MAX) })
}

/// As [`nearly`] where products of doubles may overflow or underflow.
fn nearly_in_integers<P: Rows>(problem: &Equilibrated<'_, P>, y: &[f64]) -> Option<Nearly> {
    let lcp = problem.original.dense()?;
    let exact = RationalVec::from_f64(y);
    let sum = |terms: &mut dyn Iterator<Item = f64>| {
        let terms: Vec<f64> = terms.collect();
        linear_form(terms.into_iter().zip(&exact.numerators))
    };
    let q = sum(&mut lcp.q().iter().copied());
    if !q.value.is_negative() {
        return None;
    }
    // -q'y / (A'y)_j as a double with its exponent apart; `None` where (A'y)_j <= 0.
    let ratio = |j: usize| -> Option<Option<(f64, i64)>> {
        let column = sum(&mut (0..y.len()).map(|i| lcp.row(i)[j]));
        if !column.value.is_positive() {
            return Some(None);
        }
        let size = sum(&mut (0..y.len()).map(|i| lcp.row(i)[j].abs()));
        let (part, e) = quotient(&column, &size);
        if times_power_of_two(part, e.clamp(-4000, 4000) as i32) > 64.0 * f64::EPSILON {
            return None;
        }
        let negated = Scaled { value: -&q.value, exponent: q.exponent };
        Some(Some(quotient(&negated, &column)))
    };
    let mut bound = f64::MAX;
    for j in 0..y.len() {
        if let Some((r, e)) = ratio(j)? {
            let scaled = e - i64::from(problem.scaling.columns[j]) + i64::from(problem.scaling.q);
            if times_power_of_two(r, scaled.clamp(-4000, 4000) as i32) < LARGE {
                return None;
            }
            bound = bound.min(times_power_of_two(r * (1.0 - 4.0 * f64::EPSILON), e.clamp(-4000, 4000) as i32));
        }
    }
    Some(Nearly { y: y.to_vec(), bound })
}

/// `x / y` for positive x, y: a double, rounded down, and a power of two.
fn quotient(x: &Scaled, y: &Scaled) -> (f64, i64) {
    let shift = 64 + y.value.bits() as i64 - x.value.bits() as i64;
    let numerator = if shift >= 0 { &x.value << shift } else { &x.value >> -shift };
    let value = (numerator / &y.value).to_f64().unwrap_or(0.0);
    (value * (1.0 - f64::EPSILON), x.exponent - y.exponent - shift)
}
