//! Whether a problem is one part.

use super::pattern::{Pattern, Set, indices};

/// Whether the graph with an edge from i to j where `a_ij != 0` is strongly connected. O(n^2 / 64).
pub fn is_strongly_connected(pattern: &Pattern) -> bool {
    reached(pattern, |i| [pattern.row(i), &[]]) && reached(pattern, |i| [pattern.column(i), &[]])
}

/// Whether all indices are reached from index 0.
fn reached<'a>(pattern: &'a Pattern, edges: impl Fn(usize) -> [&'a [u64]; 2]) -> bool {
    let mut seen = pattern.empty();
    reach(0, &mut seen, edges).len() == pattern.n()
}

/// The indices reached from `start` by edges that were not `seen` before, itself the first.
pub fn reach<'a>(start: usize, seen: &mut Set, edges: impl Fn(usize) -> [&'a [u64]; 2]) -> Vec<usize> {
    let mut found = vec![start];
    seen.insert(start);
    let mut next = 0;
    while let Some(&i) = found.get(next) {
        next += 1;
        for edges in edges(i) {
            for (k, (word, seen)) in edges.iter().zip(&mut seen.0).enumerate() {
                let new = word & !*seen;
                *seen |= new;
                found.extend(indices(&[new]).map(|bit| 64 * k + bit));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Lcp;

    fn one_part(n: usize, entries: &[(usize, usize)]) -> bool {
        let mut a = vec![0.0; n * n];
        entries.iter().for_each(|&(i, j)| a[i * n + j] = -1.0);
        let mut pattern = Pattern::of(&Lcp::new(n, a, vec![1.0; n]).expect("valid"));
        pattern.transpose();
        is_strongly_connected(&pattern)
    }

    #[test]
    fn cycles_are_one_part_and_trees_are_not() {
        assert!(one_part(3, &[(0, 1), (1, 2), (2, 0)]));
        for n in [64, 65, 130] {
            let ring: Vec<_> = (0..n).map(|i| (i, (i + n - 1) % n)).collect();
            assert!(one_part(n, &ring));
            assert!(!one_part(n, &ring[1..].iter().copied().chain([(0, 0)]).collect::<Vec<_>>()));
        }
        assert!(!one_part(3, &[(0, 1), (1, 0), (1, 2), (2, 2)]));
        assert!(!one_part(3, &[(0, 1), (1, 0), (2, 0)]));
        assert!(!one_part(4, &[(0, 1), (1, 0), (2, 3), (3, 2)]));
    }
}
