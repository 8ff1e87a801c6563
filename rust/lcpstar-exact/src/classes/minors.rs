//! Signs of principal minors: the classes P, P0, N, N0 and their "almost" forms.
//!
//! Schur recursion [TL00]: the minors of A that avoid index k are those of A without row and column k; those that
//! contain k are `a_kk` times those of the Schur complement `A / a_kk`. O(2^n) in all. Pivots are doubles with a
//! proved error bound; a pivot that the bound cannot tell from zero is decided in integers.

use super::budget::{Budget, Search};
use super::dominance::is_known;
use crate::cutovers::BY_SIZE_UP_TO;
use crate::elimination::determinant;
use crate::imatrix::{IMatrix, by_size, full, indices, of_size};
use crate::int::Int;

/// What the sign of each principal minor must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// P.
    Positive,
    /// P0.
    NonNegative,
    /// N.
    Negative,
    /// N0.
    NonPositive,
}

impl Rule {
    fn allows(self, sign: i32) -> bool {
        match self {
            Self::Positive => sign > 0,
            Self::NonNegative => sign >= 0,
            Self::Negative => sign < 0,
            Self::NonPositive => sign <= 0,
        }
    }
}

/// Beyond it, minors of these orders come first.
const SMALL_ORDER: usize = 3;

/// An index set whose principal minor breaks the rule; with `proper` the whole set is not asked for.
///
/// # Errors
/// `Stopped` by the budget.
pub fn first_violation(a: &IMatrix, rule: Rule, proper: bool, budget: &Budget<'_>) -> Search<Option<u64>> {
    let n = a.rows();
    let last = if proper { n.saturating_sub(1) } else { n };
    let listed = if n <= BY_SIZE_UP_TO { last } else { SMALL_ORDER };
    for alpha in (1..=listed).flat_map(|size| of_size(n, size)) {
        budget.poll()?;
        if !rule.allows(determinant(&a.principal(&indices(alpha))).sign()) {
            return Ok(Some(alpha));
        }
    }
    let known = match rule {
        Rule::Positive => is_known(a, true, budget)?,
        Rule::NonNegative => is_known(a, false, budget)?,
        Rule::Negative | Rule::NonPositive => false,
    };
    if n <= BY_SIZE_UP_TO || known {
        return Ok(None);
    }
    Recursion::new(a, rule, proper, budget).run()
}

/// Unit roundoff with room to spare.
const UNIT: f64 = f64::EPSILON;
/// Covers the rounding of the bounds themselves: a few operations on positive numbers.
const ROOM: f64 = 1.0 + 1e-12;
/// Covers underflow in the error bound.
const TINY: f64 = 1e-280;

struct Recursion<'a, 'b> {
    a: &'a IMatrix,
    rule: Rule,
    whole: Option<u64>,
    budget: &'a Budget<'b>,
    /// `levels[k]` holds the Schur complement after k pivots.
    levels: Vec<Level>,
    n: usize,
}

/// A matrix in doubles, rows of length n, and a bound of the error of each entry.
#[derive(Clone)]
struct Level {
    values: Vec<f64>,
    errors: Vec<f64>,
}

impl<'a, 'b> Recursion<'a, 'b> {
    fn new(a: &'a IMatrix, rule: Rule, proper: bool, budget: &'a Budget<'b>) -> Self {
        let n = a.rows();
        let level = Level { values: vec![0.0; n * n], errors: vec![0.0; n * n] };
        Self { a, rule, whole: proper.then_some(full(n)), budget, levels: vec![level; n + 1], n }
    }

    fn run(mut self) -> Search<Option<u64>> {
        let n = self.n;
        let (scale, doubles) = scaled_doubles(self.a);
        if !scale {
            let exact = IMatrix::clone(self.a);
            return self.exact(exact, indices(full(n)), 0, Int::ONE, 0);
        }
        for (error, x) in self.levels[0].errors.iter_mut().zip(&doubles) {
            *error = if *x == 0.0 { 0.0 } else { 4.0 * UNIT * x.abs() + TINY };
        }
        self.levels[0].values = doubles;
        self.budget.begin(1 << n.min(63));
        self.visit(0, 0, 0, 1)
    }

    fn allows(&self, alpha: u64, sign: i32) -> bool {
        self.whole == Some(alpha) || self.rule.allows(sign)
    }

    /// Visits all subsets of `start..n` added to `chosen`.
    fn visit(&mut self, level: usize, start: usize, chosen: u64, sign: i32) -> Search<Option<u64>> {
        let n = self.n;
        for k in start..n {
            self.budget.step()?;
            let (pivot, error) = (self.levels[level].values[k * n + k], self.levels[level].errors[k * n + k]);
            let alpha = chosen | 1 << k;
            if pivot.abs() <= error {
                let hit = self.undecided(k, chosen)?;
                if hit.is_some() {
                    return Ok(hit);
                }
                continue;
            }
            let sign = if pivot > 0.0 { sign } else { -sign };
            if !self.allows(alpha, sign) {
                return Ok(Some(alpha));
            }
            if k + 1 < n {
                self.schur(level, k);
                let hit = self.visit(level + 1, k + 1, alpha, sign)?;
                if hit.is_some() {
                    return Ok(hit);
                }
            }
        }
        Ok(None)
    }

    /// Writes the Schur complement of the pivot into the next level, with its error bounds.
    ///
    /// The true factor is `f + df` with `|df| <= (e_c + |f| e_p) / (|p| - e_p) + UNIT |f|`; the true entry
    /// `m - (f + df)(r + dr)` then differs from `m - f r` by at most `e_m + |f| e_r + |df| (|r| + e_r)`, and rounding adds
    /// one unit each of the product and of the difference. A row with `c = 0` exactly is copied as it is.
    fn schur(&mut self, level: usize, k: usize) {
        let n = self.n;
        let (before, after) = self.levels.split_at_mut(level + 1);
        let (from, to) = (&before[level], &mut after[0]);
        let (pivot, e_pivot) = (from.values[k * n + k], from.errors[k * n + k]);
        let (r, e_r) = (&from.values[k * n + k + 1..(k + 1) * n], &from.errors[k * n + k + 1..(k + 1) * n]);
        let least = pivot.abs() - e_pivot;
        for i in k + 1..n {
            let (c, e_c) = (from.values[i * n + k], from.errors[i * n + k]);
            let entries = i * n + k + 1..(i + 1) * n;
            let (m, e_m) = (&from.values[entries.clone()], &from.errors[entries.clone()]);
            let (x, e_x) = (&mut to.values[entries.clone()], &mut to.errors[entries]);
            if c == 0.0 && e_c == 0.0 {
                x.copy_from_slice(m);
                e_x.copy_from_slice(e_m);
                continue;
            }
            let f = c / pivot;
            let size = f.abs();
            let df = ((e_c + size * e_pivot) / least + UNIT * size) * ROOM;
            for j in 0..x.len() {
                let product = f * r[j];
                x[j] = m[j] - product;
                let carried = e_m[j] + size * e_r[j] + df * (r[j].abs() + e_r[j]);
                e_x[j] = (carried + UNIT * (product.abs() + x[j].abs())) * ROOM + TINY;
            }
        }
    }

    /// The pivot `k` on top of `chosen` may be zero: integers decide it and everything below it.
    fn undecided(&mut self, k: usize, chosen: u64) -> Search<Option<u64>> {
        let mut order = Vec::new();
        let mut matrix = self.a.clone();
        let mut previous = Int::ONE;
        let mut left: Vec<usize> = (0..self.n).collect();
        for index in indices(chosen) {
            let position = left.iter().position(|&i| i == index).unwrap_or_default();
            (matrix, previous) = bareiss(&matrix, position, &previous);
            left.remove(position);
            order.push(index);
        }
        let keep: Vec<usize> = (0..left.len()).filter(|&i| left[i] >= k).collect();
        let names = keep.iter().map(|&i| left[i]).collect();
        self.exact(matrix.principal(&keep), names, 1 << k, previous, chosen)
    }

    /// All sets `chosen + gamma` with `forced <= gamma <= names`, gamma nonempty; entry (i, j) of `m` is
    /// `det A[chosen + i, chosen + j]` and `previous = det A[chosen, chosen] != 0`.
    fn exact(&self, m: IMatrix, names: Vec<usize>, forced: u64, previous: Int, chosen: u64) -> Search<Option<u64>> {
        self.budget.poll()?;
        let size = names.len();
        if size == 0 {
            return Ok(None);
        }
        let bit = |i: usize| 1u64 << names[i];
        let Some(i) = (0..size).find(|&i| !m.at(i, i).is_zero()) else {
            return self.zero_diagonal(&m, &names, forced, &previous, chosen);
        };
        let alpha = chosen | bit(i);
        if forced & !bit(i) == 0 && !self.allows(alpha, m.at(i, i).sign()) {
            return Ok(Some(alpha));
        }
        let rest: Vec<usize> = (0..size).filter(|&j| j != i).collect();
        let rest_names: Vec<usize> = rest.iter().map(|&j| names[j]).collect();
        let (next, pivot) = bareiss(&m, i, &previous);
        let hit = self.exact(next, rest_names.clone(), forced & !bit(i), pivot, alpha)?;
        if hit.is_some() || forced & bit(i) != 0 {
            return Ok(hit);
        }
        self.exact(m.principal(&rest), rest_names, forced, previous, chosen)
    }

    /// As `exact` when every diagonal entry of `m` is zero.
    fn zero_diagonal(
        &self,
        m: &IMatrix,
        names: &[usize],
        forced: u64,
        previous: &Int,
        chosen: u64,
    ) -> Search<Option<u64>> {
        let size = names.len();
        for i in 0..size {
            let alpha = chosen | 1 << names[i];
            if forced & !(1 << names[i]) == 0 && !self.allows(alpha, 0) {
                return Ok(Some(alpha));
            }
        }
        if m.is_zero() && self.rule.allows(0) {
            return Ok(None);
        }
        for gamma in by_size(size).filter(|g| g.count_ones() > 1) {
            self.budget.poll()?;
            let inside = indices(gamma);
            let alpha = inside.iter().fold(0u64, |mask, &i| mask | 1 << names[i]);
            if forced & !alpha != 0 {
                continue;
            }
            // Sylvester: det m[gamma] = previous^(|gamma| - 1) det A[chosen + gamma].
            let power = if inside.len().is_multiple_of(2) { previous.sign() } else { 1 };
            let sign = determinant(&m.principal(&inside)).sign() * power;
            if !self.allows(chosen | alpha, sign) {
                return Ok(Some(chosen | alpha));
            }
        }
        Ok(None)
    }
}

/// One principal step of fraction-free elimination on `k`: the smaller matrix and the new common divisor.
fn bareiss(m: &IMatrix, k: usize, previous: &Int) -> (IMatrix, Int) {
    let rest: Vec<usize> = (0..m.rows()).filter(|&i| i != k).collect();
    let pivot = m.at(k, k).clone();
    let next = IMatrix::from_fn(rest.len(), rest.len(), |i, j| {
        let (i, j) = (rest[i], rest[j]);
        Int::cross(&pivot, m.at(i, j), m.at(i, k), m.at(k, j), previous)
    });
    (next, pivot)
}

/// Columns divided by their diagonal entry, or by their largest where that is zero: a positive scaling keeps all signs.
/// `false` when doubles cannot hold them.
fn scaled_doubles(a: &IMatrix) -> (bool, Vec<f64>) {
    let n = a.rows();
    let mut doubles: Vec<f64> = a.entries().iter().map(Int::to_f64).collect();
    for j in 0..n {
        let largest = (0..n).fold(0.0_f64, |m, i| m.max(doubles[i * n + j].abs()));
        let diagonal = doubles[j * n + j].abs();
        let scale = if diagonal > 0.0 { diagonal } else { largest.max(f64::MIN_POSITIVE) };
        (0..n).for_each(|i| doubles[i * n + j] /= scale);
    }
    (doubles.iter().all(|x| x.is_finite()), doubles)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All principal minor signs, indexed by mask; the empty minor is 1.
    fn signs(a: &IMatrix) -> Vec<i32> {
        let mut all = vec![1; 1 << a.rows()];
        for alpha in by_size(a.rows()) {
            all[alpha as usize] = determinant(&a.principal(&indices(alpha))).sign();
        }
        all
    }

    fn random(n: usize, rng: &mut fastrand::Rng, spread: i64, diagonal: i64) -> IMatrix {
        IMatrix::from_fn(n, n, |i, j| {
            let x = rng.i64(-spread..=spread);
            Int::from(if i == j { diagonal + x } else { x })
        })
    }

    /// The recursion against determinants one by one, with many zero pivots.
    #[test]
    fn recursion_agrees_with_determinants() {
        let budget = Budget::unlimited();
        let mut rng = fastrand::Rng::with_seed(7);
        for round in 0..600 {
            let n = 2 + round % 5;
            let a = random(n, &mut rng, 2, (round % 3) as i64);
            let signs = signs(&a);
            for rule in [Rule::Positive, Rule::NonNegative, Rule::Negative, Rule::NonPositive] {
                for proper in [false, true] {
                    let found = Recursion::new(&a, rule, proper, &budget).run().expect("no limit");
                    let broken = |&alpha: &u64| !(rule.allows(signs[alpha as usize]) || proper && alpha == full(n));
                    match found {
                        Some(alpha) => assert!(broken(&alpha), "{a:?} {rule:?} {alpha:b}"),
                        None => assert_eq!(by_size(n).find(broken), None, "{a:?} {rule:?}"),
                    }
                    let exact =
                        Recursion::new(&a, rule, proper, &budget).exact(a.clone(), indices(full(n)), 0, Int::ONE, 0);
                    assert_eq!(exact.expect("no limit").is_some(), found.is_some());
                }
            }
        }
    }
}
