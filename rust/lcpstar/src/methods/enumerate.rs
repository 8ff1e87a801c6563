//! Support enumeration: every index set, small ones first, until one solves. For small n and any matrix.

use crate::control::Control;
use crate::pivoting::basis;
use crate::problem::Lcp;
use crate::solution::Candidate;
use crate::status::Termination;

/// Orders above this are refused: 2^n index sets.
pub const MAX_ORDER: usize = 24;

/// A basic point whose worst entry is above minus this fraction of its scale is taken at once.
const TOL_SIGN: f64 = 1e-12;

/// The first index set, by size and then lexicographically, whose basic point solves LCP(q, A); the least violated one
/// with `Breakdown` when none does. Always finds a solution that has a nonsingular complementary basis.
///
/// O(2^n n^3) at worst; n <= [`MAX_ORDER`], otherwise `Breakdown`. Iterations are index sets tried.
#[must_use]
pub fn enumerate(lcp: &Lcp, control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    if n > MAX_ORDER {
        return Candidate::point(vec![0.0; n], Termination::Breakdown("enumerate takes n <= 24"), 0);
    }
    let mut best: (f64, Vec<f64>, Vec<usize>) = (f64::NEG_INFINITY, vec![0.0; n], vec![]);
    let mut tried = 0;
    for size in 0..=n {
        for alpha in IndexSets::new(n, size) {
            if let Some(reason) = control.stop(tried, usize::MAX) {
                return Candidate { alpha: Some(best.2), ..Candidate::point(best.1, reason, tried) };
            }
            tried += 1;
            let Some(z) = basis::basic_point(lcp, &alpha) else { continue };
            let worst = worst_sign(lcp, &z, &alpha);
            if worst > best.0 {
                best = (worst, z, alpha);
            }
            if best.0 >= -TOL_SIGN {
                let (_, z, alpha) = best;
                return Candidate { alpha: Some(alpha), ..Candidate::point(z, Termination::ComplementaryBasis, tried) };
            }
        }
    }
    let reason = Termination::Breakdown("no index set solves the problem");
    Candidate { alpha: Some(best.2), ..Candidate::point(best.1, reason, tried) }
}

/// The least `z_i` on alpha and `w_i` outside, each relative to the size of its terms; NaN counts as minus infinity.
fn worst_sign(lcp: &Lcp, z: &[f64], alpha: &[usize]) -> f64 {
    let largest = z.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let mut worst = f64::INFINITY;
    let mut in_alpha = alpha.iter().copied().peekable();
    for i in 0..lcp.n() {
        let relative = if in_alpha.next_if_eq(&i).is_some() {
            z[i] / largest.max(f64::MIN_POSITIVE)
        } else {
            let (mut w, mut size) = (lcp.q()[i], lcp.q()[i].abs());
            for &j in alpha {
                w += lcp.row(i)[j] * z[j];
                size += (lcp.row(i)[j] * z[j]).abs();
            }
            w / size.max(f64::MIN_POSITIVE)
        };
        if relative.is_nan() {
            return f64::NEG_INFINITY;
        }
        worst = worst.min(relative);
    }
    worst
}

/// The subsets of `0..n` with `size` elements, in lexicographic order.
struct IndexSets {
    n: usize,
    next: Option<Vec<usize>>,
}

impl IndexSets {
    fn new(n: usize, size: usize) -> Self {
        Self { n, next: (size <= n).then(|| (0..size).collect()) }
    }
}

impl Iterator for IndexSets {
    type Item = Vec<usize>;

    fn next(&mut self) -> Option<Vec<usize>> {
        let current = self.next.take()?;
        let size = current.len();
        if let Some(t) = (0..size).rev().find(|&t| current[t] < self.n - size + t) {
            let mut following = current.clone();
            let first = following[t] + 1;
            for (s, x) in following[t..].iter_mut().enumerate() {
                *x = first + s;
            }
            self.next = Some(following);
        }
        Some(current)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_sets_are_complete_and_ordered() {
        let all: Vec<Vec<usize>> = IndexSets::new(4, 2).collect();
        assert_eq!(all, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
        assert_eq!(IndexSets::new(3, 0).count(), 1);
        assert_eq!((0..=6).map(|k| IndexSets::new(6, k).count()).sum::<usize>(), 64);
    }

    #[test]
    fn the_smallest_support_is_found() {
        let (a, q) = ([0.0, 1.0, 1.0, 2.0, 0.0, 2.0, -2.0, -5.0, 0.0], [-4.0, -7.0, 10.0]);
        let lcp = Lcp::new(3, a.to_vec(), q.to_vec()).expect("valid");
        let found = enumerate(&lcp, &Control::default());
        assert_eq!(found.termination, Termination::ComplementaryBasis);
        assert_eq!(found.alpha.expect("a basis"), [0, 2]);
        assert_eq!(found.z, [5.0, 0.0, 4.0]);
    }

    #[test]
    fn no_solution_is_no_basis() {
        let lcp = Lcp::new(2, vec![-1.0, 0.0, 0.0, 1.0], vec![-1.0, -1.0]).expect("valid");
        assert!(matches!(enumerate(&lcp, &Control::default()).termination, Termination::Breakdown(_)));
    }
}
