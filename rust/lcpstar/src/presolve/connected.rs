//! Whether a problem is one part, by sets of indices in machine words.

use crate::problem::Lcp;

/// Indices in a word.
const WORD: usize = 64;

/// Whether no row can be dropped and the graph with an edge from i to j where `a_ij != 0` is strongly connected. O(n^2).
pub fn is_one_part(lcp: &Lcp) -> bool {
    let n = lcp.n();
    let words = n.div_ceil(WORD);
    let mut edges = vec![0_u64; n * words];
    for (i, edges) in edges.chunks_exact_mut(words).enumerate() {
        let mut negative = 0;
        for (edges, entries) in edges.iter_mut().zip(lcp.row(i).chunks(WORD)) {
            for (j, &a) in entries.iter().enumerate() {
                *edges |= u64::from(a != 0.0) << j;
                negative |= u64::from(a < 0.0);
            }
        }
        let candidate = lcp.q()[i] > 0.0 || (lcp.q()[i] == 0.0 && lcp.row(i)[i] > 0.0);
        if candidate && negative == 0 {
            return false;
        }
    }
    // From index 0 along the edges, and to it against them, until nothing is new.
    let (mut from, mut to) = (vec![0_u64; words], vec![0_u64; words]);
    (from[0], to[0]) = (1, 1);
    let has = |set: &[u64], i: usize| set[i / WORD] >> (i % WORD) & 1 == 1;
    loop {
        let mut new = false;
        for (i, edges) in edges.chunks_exact(words).enumerate() {
            if has(&from, i) {
                for (from, edges) in from.iter_mut().zip(edges) {
                    new |= *edges & !*from != 0;
                    *from |= edges;
                }
            }
            if !has(&to, i) && edges.iter().zip(&to).any(|(edges, to)| edges & to != 0) {
                new = true;
                to[i / WORD] |= 1 << (i % WORD);
            }
        }
        if !new {
            return (0..n).all(|i| has(&from, i) && has(&to, i));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_part(n: usize, entries: &[(usize, usize)]) -> bool {
        let mut a = vec![0.0; n * n];
        entries.iter().for_each(|&(i, j)| a[i * n + j] = -1.0);
        is_one_part(&Lcp::new(n, a, vec![1.0; n]).expect("valid"))
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
    fn a_row_that_can_be_dropped_is_seen() {
        let lcp = Lcp::new(2, vec![1.0, 1.0, -1.0, 1.0], vec![1.0, -1.0]).expect("valid");
        assert!(!is_one_part(&lcp));
    }
}
