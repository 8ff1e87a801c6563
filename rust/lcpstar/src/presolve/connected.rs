//! Whether a problem is one part.

use super::pattern::{Pattern, Set, indices};

/// Whether the graph on `island` with an edge from i to j where `a_ij != 0` is strongly connected. O(n^2 / 64).
pub fn is_strongly_connected(pattern: &Pattern, island: &[usize]) -> bool {
    let forward = |i| [pattern.row(i), &[]];
    let backward = |i| [pattern.column(i), &[]];
    reaches_all(pattern, island, forward) && reaches_all(pattern, island, backward)
}

/// Whether all of `island` is reached from its first index.
fn reaches_all<'a>(pattern: &'a Pattern, island: &[usize], edges: impl Fn(usize) -> [&'a [u64]; 2]) -> bool {
    // What is not of the island counts as seen.
    let mut seen = pattern.set_of(island.iter().copied()).complement();
    island.first().is_none_or(|&start| reach(start, &mut seen, edges).len() == island.len())
}

/// The indices reached from `start` by edges that were not `seen` before, itself the first.
pub fn reach<'a>(start: usize, seen: &mut Set, edges: impl Fn(usize) -> [&'a [u64]; 2]) -> Vec<usize> {
    let mut found = Vec::with_capacity(64 * seen.0.len());
    found.push(start);
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
        is_strongly_connected(&pattern, &(0..n).collect::<Vec<_>>())
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

    #[test]
    fn a_part_of_the_graph_is_looked_at_alone() {
        let mut a = vec![0.0; 25];
        // 1 -> 3 -> 4 -> 1, and 0 and 2 between 1 and 3.
        [(1, 3), (3, 4), (4, 1), (1, 0), (0, 2), (2, 3)].iter().for_each(|&(i, j)| a[i * 5 + j] = 1.0);
        let mut pattern = Pattern::of(&Lcp::new(5, a, vec![1.0; 5]).expect("valid"));
        pattern.transpose();
        assert!(is_strongly_connected(&pattern, &[1, 3, 4]) && is_strongly_connected(&pattern, &[0, 1, 2, 3, 4]));
        assert!(!is_strongly_connected(&pattern, &[1, 3]) && !is_strongly_connected(&pattern, &[0, 1, 2]));
    }
}
