//! Scans of all, or of random, small integer matrices for a counterexample to `hypothesis => conclusion`.

use super::budget::{Budget, Search};
use super::class::Facts;
use super::formula::Formula;
use crate::imatrix::IMatrix;
use crate::int::Int;

/// Which matrices are scanned.
#[derive(Clone, Debug)]
pub struct Space {
    /// The order.
    pub n: usize,
    /// The entries, in the order in which they are tried.
    pub entries: Vec<i64>,
    /// Skip a matrix unless it is the first of its class under permutation similarity.
    pub up_to_permutation: bool,
    /// `Some(seed)`: matrix number k is drawn at random from (seed, k); `None`: it is the k-th of all.
    pub seed: Option<u64>,
}

/// What a scan of a range of numbers found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Matrices looked at, after skipping permuted copies.
    pub scanned: u64,
    /// Those that satisfy the hypothesis.
    pub hypothesis: u64,
    /// Those that satisfy it and not the conclusion.
    pub failed: u64,
    /// The failure of least entry sum in absolute value, earliest first.
    pub smallest: Option<(u64, Vec<i64>)>,
}

impl Tally {
    /// Adds the tally of another range.
    pub fn add(&mut self, other: Self) {
        self.scanned += other.scanned;
        self.hypothesis += other.hypothesis;
        self.failed += other.failed;
        if let Some((number, a)) = other.smallest
            && self.smallest.as_ref().is_none_or(|(k, b)| (size(&a), number) < (size(b), *k))
        {
            self.smallest = Some((number, a));
        }
    }
}

fn size(a: &[i64]) -> u64 {
    a.iter().map(|x| x.unsigned_abs()).sum()
}

impl Space {
    /// Matrix number `k`, row-major.
    #[must_use]
    pub fn matrix(&self, k: u64) -> Vec<i64> {
        let count = self.entries.len() as u64;
        let mut state = self.seed.map(|seed| mix(seed ^ mix(k)));
        let mut rest = k;
        (0..self.n * self.n)
            .map(|_| {
                let digit = match &mut state {
                    Some(state) => {
                        *state = mix(*state);
                        *state % count
                    }
                    None => {
                        let digit = rest % count;
                        rest /= count;
                        digit
                    }
                };
                self.entries[digit as usize]
            })
            .collect()
    }

    /// Scans the matrices `from..to`.
    ///
    /// # Errors
    /// `Stopped` by the budget.
    pub fn scan(
        &self,
        hypothesis: &Formula,
        conclusion: &Formula,
        from: u64,
        to: u64,
        b: &Budget<'_>,
    ) -> Search<Tally> {
        let permutations = if self.up_to_permutation { permutations(self.n) } else { Vec::new() };
        let mut tally = Tally::default();
        for k in from..to {
            b.poll()?;
            let a = self.matrix(k);
            if !is_first(&a, self.n, &permutations) {
                continue;
            }
            tally.scanned += 1;
            let facts = Facts::new(IMatrix::from_fn(self.n, self.n, |i, j| Int::from(a[i * self.n + j])));
            if !hypothesis.holds(&facts, b)? {
                continue;
            }
            tally.hypothesis += 1;
            if !conclusion.holds(&facts, b)? {
                tally.add(Tally { failed: 1, smallest: Some((k, a)), ..Tally::default() });
            }
        }
        Ok(tally)
    }
}

/// SplitMix64's finaliser.
fn mix(x: u64) -> u64 {
    let mut z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Whether no permuted copy comes before `a`.
fn is_first(a: &[i64], n: usize, permutations: &[Vec<usize>]) -> bool {
    permutations.iter().all(|p| {
        for i in 0..n {
            for j in 0..n {
                let permuted = a[p[i] * n + p[j]];
                if permuted != a[i * n + j] {
                    return a[i * n + j] < permuted;
                }
            }
        }
        true
    })
}

/// All permutations of `0..n` but the identity.
fn permutations(n: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..n {
        all = all
            .into_iter()
            .flat_map(|p: Vec<usize>| {
                (0..n).filter(|i| !p.contains(i)).map(|i| [p.clone(), vec![i]].concat()).collect::<Vec<_>>()
            })
            .collect();
    }
    all.into_iter().skip(1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classes::class::Class;

    /// 2 x 2 matrices with entries -1, 0, 1: 81, and 45 up to exchanging the indices (Burnside: (81 + 9) / 2).
    #[test]
    fn counts_up_to_permutation() {
        let mut space = Space { n: 2, entries: vec![-1, 0, 1], up_to_permutation: true, seed: None };
        let (p, p0) = (Formula::In(Class::P), Formula::In(Class::P0));
        let b = Budget::unlimited();
        let tally = space.scan(&p, &p0, 0, 81, &b).expect("no limit");
        assert_eq!((tally.scanned, tally.failed), (45, 0));
        space.up_to_permutation = false;
        let both = space.scan(&p0, &p, 0, 81, &b).expect("no limit");
        assert_eq!(both.scanned, 81);
        assert_eq!(both.smallest.expect("0 is P0, not P").1, vec![0; 4]);
    }
}
