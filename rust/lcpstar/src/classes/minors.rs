//! Signs of principal minors: the classes P, P0, N, N0 and their "almost" forms.
//!
//! Schur recursion [TL00]: the minors of A that avoid index k are those of A without row and column k; those that
//! contain k are `a_kk` times those of the Schur complement `A / a_kk`. O(2^n) in all. Pivots are doubles with a
//! proved error bound; a pivot that the bound cannot tell from zero is decided in integers.

use super::budget::{Budget, Search};
use crate::exact::elimination::determinant;
use crate::exact::imatrix::{IMatrix, by_size, full, indices, of_size};
use crate::exact::int::Int;

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

/// Up to this order all subsets are tried by size, so that the witness is a smallest one.
const BY_SIZE_UP_TO: usize = 10;
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
    if n <= BY_SIZE_UP_TO || (!proper && known_by_dominance(a, rule)) {
        return Ok(None);
    }
    Recursion::new(a, rule, proper, budget).run()
}

/// All principal minor signs for n <= 20, indexed by mask (the empty minor is 1).
///
/// # Errors
/// `Stopped` by the budget.
pub fn signs(a: &IMatrix, budget: &Budget<'_>) -> Search<Vec<i32>> {
    let mut all = vec![1; 1 << a.rows()];
    for alpha in by_size(a.rows()) {
        budget.poll()?;
        all[alpha as usize] = determinant(&a.principal(&indices(alpha))).sign();
    }
    Ok(all)
}

/// Positive diagonal and strict dominance by rows or columns gives P [CPS92, sec. 3.3].
fn known_by_dominance(a: &IMatrix, rule: Rule) -> bool {
    let dominant = |a: &IMatrix| {
        (0..a.rows()).all(|i| {
            let off = (0..a.rows()).filter(|&j| j != i).fold(Int::ZERO, |sum, j| &sum + &a.at(i, j).abs());
            (a.at(i, i) - &off).sign() > 0
        })
    };
    matches!(rule, Rule::Positive | Rule::NonNegative) && (dominant(a) || dominant(&a.transpose()))
}

/// Unit roundoff with room to spare.
const UNIT: f64 = f64::EPSILON;
/// Covers underflow in the error bound.
const TINY: f64 = 1e-280;

struct Recursion<'a, 'b> {
    a: &'a IMatrix,
    rule: Rule,
    whole: Option<u64>,
    budget: &'a Budget<'b>,
    /// `levels[k]` holds the Schur complement after k pivots, with rows of length n.
    levels: Vec<Vec<f64>>,
    n: usize,
}

impl<'a, 'b> Recursion<'a, 'b> {
    fn new(a: &'a IMatrix, rule: Rule, proper: bool, budget: &'a Budget<'b>) -> Self {
        let n = a.rows();
        Self { a, rule, whole: proper.then_some(full(n)), budget, levels: vec![vec![0.0; n * n]; n + 1], n }
    }

    fn run(mut self) -> Search<Option<u64>> {
        let n = self.n;
        let (scale, doubles) = scaled_doubles(self.a);
        if !scale {
            let exact = IMatrix::clone(self.a);
            return self.exact(exact, indices(full(n)), 0, Int::ONE, 0);
        }
        self.levels[0].copy_from_slice(&doubles);
        self.budget.begin(1 << n.min(63));
        self.visit(0, 0, 0, 1, 4.0 * UNIT)
    }

    fn allows(&self, alpha: u64, sign: i32) -> bool {
        self.whole == Some(alpha) || self.rule.allows(sign)
    }

    /// Visits all subsets of `start..n` added to `chosen`; `error` bounds every entry of the level.
    fn visit(&mut self, level: usize, start: usize, chosen: u64, sign: i32, error: f64) -> Search<Option<u64>> {
        let n = self.n;
        for k in start..n {
            self.budget.step()?;
            let pivot = self.levels[level][k * n + k];
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
                let error = self.schur(level, k, pivot, error);
                let hit = self.visit(level + 1, k + 1, alpha, sign, error)?;
                if hit.is_some() {
                    return Ok(hit);
                }
            }
        }
        Ok(None)
    }

    /// Writes the Schur complement of the pivot into the next level and returns its error bound.
    fn schur(&mut self, level: usize, k: usize, pivot: f64, error: f64) -> f64 {
        let n = self.n;
        let (before, after) = self.levels.split_at_mut(level + 1);
        let (from, to) = (&before[level], &mut after[0]);
        let row = &from[k * n + k + 1..(k + 1) * n];
        let row_max = row.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let mut column_max = 0.0_f64;
        let mut entry_max = 0.0_f64;
        for i in k + 1..n {
            let c = from[i * n + k];
            column_max = column_max.max(c.abs());
            let factor = c / pivot;
            let source = &from[i * n + k + 1..(i + 1) * n];
            let target = &mut to[i * n + k + 1..(i + 1) * n];
            for ((t, s), r) in target.iter_mut().zip(source).zip(row) {
                let x = s - factor * r;
                *t = x;
                entry_max = entry_max.max(x.abs());
            }
        }
        // True entry: m - c r / p with |c|, |r|, |p| known up to `error`; then two roundings of the product and one of the difference.
        let p = pivot.abs();
        let least = p - error;
        let product = column_max * row_max / p;
        let carried = error + error * (column_max + row_max + error) / least + product * error / least;
        (carried + 2.0 * UNIT * (product + entry_max)) * (1.0 + 1e-12) + TINY
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
    fn zero_diagonal(&self, m: &IMatrix, names: &[usize], forced: u64, previous: &Int, chosen: u64) -> Search<Option<u64>> {
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
        let positions: Vec<usize> = (0..size).collect();
        for gamma in by_size(size).filter(|g| g.count_ones() > 1) {
            self.budget.poll()?;
            let inside = indices(gamma);
            let alpha = inside.iter().fold(0u64, |mask, &i| mask | 1 << names[i]);
            if forced & !alpha != 0 {
                continue;
            }
            // Sylvester: det m[gamma] = previous^(|gamma| - 1) det A[chosen + gamma].
            let power = if inside.len() % 2 == 0 { previous.sign() } else { 1 };
            let sign = determinant(&m.principal(&inside)).sign() * power;
            if !self.allows(chosen | alpha, sign) {
                return Ok(Some(chosen | alpha));
            }
        }
        debug_assert_eq!(positions.len(), size);
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

/// Entries divided by the largest: `false` when doubles cannot hold them.
fn scaled_doubles(a: &IMatrix) -> (bool, Vec<f64>) {
    let doubles: Vec<f64> = a.entries().iter().map(Int::to_f64).collect();
    let largest = doubles.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if !largest.is_finite() || largest == 0.0 {
        return (false, doubles);
    }
    (true, doubles.iter().map(|x| x / largest).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(n: usize, seed: &mut u64, spread: i64, diagonal: i64) -> IMatrix {
        IMatrix::from_fn(n, n, |i, j| {
            *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let x = ((*seed >> 33) % (2 * spread + 1) as u64) as i64 - spread;
            Int::from(if i == j { diagonal + x } else { x })
        })
    }

    /// The recursion against determinants one by one, with many zero pivots.
    #[test]
    fn recursion_agrees_with_determinants() {
        let budget = Budget::unlimited();
        let mut seed = 7;
        for round in 0..600 {
            let n = 2 + round % 5;
            let a = random(n, &mut seed, 2, (round % 3) as i64);
            let signs = signs(&a, &budget).expect("no limit");
            for rule in [Rule::Positive, Rule::NonNegative, Rule::Negative, Rule::NonPositive] {
                for proper in [false, true] {
                    let found = Recursion::new(&a, rule, proper, &budget).run().expect("no limit");
                    let broken = |&alpha: &u64| !rule.allows(signs[alpha as usize]) && !(proper && alpha == full(n));
                    match found {
                        Some(alpha) => assert!(broken(&alpha), "{a:?} {rule:?} {alpha:b}"),
                        None => assert_eq!(by_size(n).find(broken), None, "{a:?} {rule:?}"),
                    }
                    let exact = Recursion::new(&a, rule, proper, &budget).exact(a.clone(), indices(full(n)), 0, Int::ONE, 0);
                    assert_eq!(exact.expect("no limit").is_some(), found.is_some());
                }
            }
        }
    }
}
