//! Factorisations that an iteration changes: of `A[alpha, alpha]`, and of `A + diag(d)`.

use crate::linalg::backend::{DenseCholesky, DenseLu, ShiftedFactor, SparseFactor, Structure};
use crate::problem::Lcp;
use crate::sparse::SparseLcp;

/// One factorisation at a time; a new one replaces the last. Each allocates what it needs.
pub trait Factors {
    /// Factors `A[alpha, alpha] + shift I`. `false` when that fails, or when `stop` says so before it begins.
    fn on_support(&mut self, alpha: &[usize], shift: f64, stop: &dyn Fn() -> bool) -> bool;
    /// Factors `A + diag(d)`. `false` as there.
    fn shifted(&mut self, d: &[f64], stop: &dyn Fn() -> bool) -> bool;
    /// Replaces `x`, of full length, by the solution; off the support `x` is ignored and becomes 0.
    fn solve(&mut self, x: &mut [f64]);
}

/// Cholesky of a symmetric A where it exists, LU otherwise.
pub struct DenseFactors<'a> {
    lcp: &'a Lcp,
    symmetric: bool,
    whole: Option<ShiftedFactor>,
    block: Option<Block>,
    /// Whether the last factorisation is that of a block.
    on_block: bool,
}

struct Block {
    alpha: Vec<usize>,
    factor: BlockFactor,
}

enum BlockFactor {
    Cholesky(DenseCholesky),
    Lu(DenseLu),
}

impl<'a> DenseFactors<'a> {
    /// Nothing is factored yet.
    #[must_use]
    pub fn new(lcp: &'a Lcp, symmetric: bool) -> Self {
        Self { lcp, symmetric, whole: None, block: None, on_block: true }
    }
}

impl Factors for DenseFactors<'_> {
    fn on_support(&mut self, alpha: &[usize], shift: f64, stop: &dyn Fn() -> bool) -> bool {
        if stop() {
            return false;
        }
        let m = alpha.len();
        let mut rows = crate::pivoting::basis::principal_block(self.lcp, alpha);
        (0..m).for_each(|k| rows[k * m + k] += shift);
        let cholesky = if self.symmetric { DenseCholesky::new(m, &rows).map(BlockFactor::Cholesky) } else { None };
        let factor = cholesky.or_else(|| DenseLu::new(m, &rows).map(BlockFactor::Lu));
        self.on_block = true;
        self.block = factor.map(|factor| Block { alpha: alpha.to_vec(), factor });
        self.block.is_some()
    }

    fn shifted(&mut self, d: &[f64], stop: &dyn Fn() -> bool) -> bool {
        if stop() {
            return false;
        }
        let (n, a) = (self.lcp.n(), self.lcp.a());
        self.on_block = false;
        self.whole.get_or_insert_with(|| ShiftedFactor::new(n, Structure::of(n, a))).factor(a, d)
    }

    fn solve(&mut self, x: &mut [f64]) {
        match (&mut self.whole, &self.block) {
            (Some(whole), _) if !self.on_block => whole.solve(x),
            (_, Some(block)) => {
                let rhs: Vec<f64> = block.alpha.iter().map(|&i| x[i]).collect();
                let part = match &block.factor {
                    BlockFactor::Cholesky(factor) => factor.solve(&rhs),
                    BlockFactor::Lu(factor) => factor.solve(&rhs),
                };
                x.fill(0.0);
                block.alpha.iter().zip(part).for_each(|(&i, part)| x[i] = part);
            }
            _ => x.fill(f64::NAN),
        }
    }
}

/// Sparse Cholesky of a symmetric A where it exists, LU otherwise; each ordering is found once, when it is first needed.
pub struct SparseFactors {
    n: usize,
    entries: Vec<(usize, usize, f64)>,
    symmetric: bool,
    cholesky: Option<SparseFactor>,
    lu: Option<SparseFactor>,
    by_lu: bool,
    d: Vec<f64>,
    outside: Vec<bool>,
    restricted: bool,
}

/// On the diagonal of a pair outside the support: its row and column no longer matter to the digits of the others.
const OUTSIDE: f64 = 1e40;

impl SparseFactors {
    /// Nothing is factored yet.
    #[must_use]
    pub fn new(lcp: &SparseLcp, symmetric: bool) -> Self {
        let n = lcp.n();
        let entries: Vec<_> =
            (0..n).flat_map(|i| lcp.row(i).0.iter().zip(lcp.row(i).1).map(move |(&j, &a)| (i, j, a))).collect();
        let (d, outside) = (vec![0.0; n], vec![false; n]);
        Self { n, entries, symmetric, cholesky: None, lu: None, by_lu: false, d, outside, restricted: false }
    }

    fn factor(&mut self, stop: &dyn Fn() -> bool) -> bool {
        for (factor, is_cholesky) in [(&mut self.cholesky, true), (&mut self.lu, false)] {
            if is_cholesky && !self.symmetric {
                continue;
            }
            self.by_lu = !is_cholesky;
            if factor.is_none() && !stop() {
                *factor = SparseFactor::new(self.n, &self.entries, is_cholesky);
            }
            if stop() {
                return false;
            }
            if factor.as_mut().is_some_and(|factor| factor.factor(&self.d)) {
                return true;
            }
        }
        false
    }
}

impl Factors for SparseFactors {
    fn on_support(&mut self, alpha: &[usize], shift: f64, stop: &dyn Fn() -> bool) -> bool {
        self.d.fill(OUTSIDE);
        self.outside.fill(true);
        for &i in alpha {
            self.d[i] = shift;
            self.outside[i] = false;
        }
        self.restricted = true;
        self.factor(stop)
    }

    fn shifted(&mut self, d: &[f64], stop: &dyn Fn() -> bool) -> bool {
        self.d.copy_from_slice(d);
        self.restricted = false;
        self.factor(stop)
    }

    fn solve(&mut self, x: &mut [f64]) {
        let clear = |x: &mut [f64], outside: &[bool]| {
            x.iter_mut().zip(outside).filter(|(_, out)| **out).for_each(|(x, _)| *x = 0.0);
        };
        if self.restricted {
            clear(x, &self.outside);
        }
        match if self.by_lu { &self.lu } else { &self.cholesky } {
            Some(factor) => factor.solve(x),
            None => x.fill(f64::NAN),
        }
        if self.restricted {
            clear(x, &self.outside);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::matrix::tests::sparse;
    use super::super::{Dense, Matrix, Sparse};
    use super::*;

    #[test]
    fn each_factorisation_solves_its_system() {
        let n = 9;
        for skew in [0.0, 0.5] {
            let entry = |i: usize, j: usize| match i.abs_diff(j) {
                0 => 3.0,
                1 => {
                    if i < j {
                        -1.0 + skew
                    } else {
                        -1.0 - skew
                    }
                }
                _ => 0.0,
            };
            let lcp = Lcp::new(n, (0..n * n).map(|k| entry(k / n, k % n)).collect(), vec![1.0; n]).expect("valid");
            let copy = sparse(&lcp);
            let (dense, sparse) = (Dense::new(&lcp), Sparse::new(&copy));
            for mut factors in [dense.factors(), sparse.factors()] {
                let alpha = [1, 2, 4, 8];
                let x: Vec<f64> = (0..n).map(|i| if alpha.contains(&i) { 1.0 + i as f64 } else { 0.0 }).collect();
                let mut b = vec![0.0; n];
                dense.multiply(&x, &mut b);
                assert!(factors.on_support(&alpha, 0.0, &|| false));
                factors.solve(&mut b);
                assert!(b.iter().zip(&x).all(|(b, x)| (b - x).abs() < 1e-12), "{b:?}");
                let d: Vec<f64> = (0..n).map(|i| i as f64).collect();
                dense.multiply(&x, &mut b);
                b.iter_mut().zip(&d).zip(&x).for_each(|((b, d), x)| *b += d * x);
                assert!(factors.shifted(&d, &|| false));
                factors.solve(&mut b);
                assert!(b.iter().zip(&x).all(|(b, x)| (b - x).abs() < 1e-12), "{b:?}");
            }
        }
    }
}
