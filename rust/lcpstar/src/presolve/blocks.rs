//! Islands and the block-triangular order.

use super::connected::{is_strongly_connected, reach};
use super::pattern::{Pattern, Set, indices, meet, next_common};
use crate::linalg::backend::DenseCholesky;
use crate::pivoting::basis::principal_block;
use crate::problem::Lcp;

/// A principal subproblem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its indices, increasing.
    pub indices: Vec<usize>,
    /// Whether its rows hold entries of parts before it: then its q is `q + A z` of those.
    pub follows: bool,
}

/// Whether the first row and the first column have no zero: then A is one strongly connected block. O(n).
pub fn first_reaches_all(lcp: &Lcp) -> bool {
    let n = lcp.n();
    lcp.row(0)[1..].iter().all(|&a| a != 0.0) && (1..n).all(|i| lcp.row(i)[0] != 0.0)
}

/// The parts of one island, whole or in block-triangular order.
///
/// It is taken apart only where every block on which others depend is a P-matrix by a sufficient test: its solution is
/// then unique whatever its q is, and the blocks after it lose no solution.
pub fn parts(lcp: &Lcp, pattern: &Pattern, island: &[usize]) -> Vec<Part> {
    if is_strongly_connected(pattern, island) {
        return vec![Part { indices: island.to_vec(), follows: false }];
    }
    let blocks = strong_components(pattern, island);
    let sets: Vec<Set> = blocks.iter().map(|block| pattern.set_of(block.iter().copied())).collect();
    let needed = |b: usize| blocks[b + 1..].iter().flatten().any(|&i| meet(pattern.row(i), &sets[b].0));
    if (0..blocks.len()).all(|b| !needed(b) || is_surely_p(lcp, &blocks[b])) {
        return blocks.into_iter().enumerate().map(|(k, indices)| Part { indices, follows: k > 0 }).collect();
    }
    vec![Part { indices: island.to_vec(), follows: false }]
}

/// The connected components of the pattern of A + A' on `kept`, each sorted, by least index. O(n^2 / 64).
pub fn islands(pattern: &Pattern, kept: &Set) -> Vec<Vec<usize>> {
    // What is not kept counts as seen.
    let mut seen = kept.complement();
    let mut islands = Vec::new();
    for i in indices(&kept.0) {
        if !seen.has(i) {
            let mut island = reach(i, &mut seen, |i| [pattern.row(i), pattern.column(i)]);
            island.sort_unstable();
            islands.push(island);
        }
    }
    islands
}

/// Sufficient for P: strictly diagonally dominant rows with a positive diagonal, or `A + A'` positive definite.
fn is_surely_p(lcp: &Lcp, block: &[usize]) -> bool {
    let k = block.len();
    let a = principal_block(lcp, block);
    let dominant = |i: usize| {
        let row = &a[i * k..(i + 1) * k];
        let others: f64 = row.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, x)| x.abs()).sum();
        row[i] > others * (1.0 + 1e-12)
    };
    if (0..k).all(dominant) {
        return true;
    }
    let symmetric: Vec<f64> = (0..k * k).map(|t| 0.5 * (a[t] + a[t % k * k + t / k])).collect();
    let shift = 1e-12 * (0..k).map(|i| symmetric[i * k + i].abs()).fold(0.0, f64::max);
    let mut shifted = symmetric;
    (0..k).for_each(|i| shifted[i * k + i] -= shift * k as f64);
    DenseCholesky::new(k, &shifted).is_some()
}

/// The strongly connected components of the graph with an edge from i to j where `a_ij != 0`, each sorted, in an order
/// in which every component comes after those it has edges to. Tarjan's algorithm with an explicit stack [Tar72];
/// O(n^2 / 64) and O(1) for each entry.
fn strong_components(pattern: &Pattern, kept: &[usize]) -> Vec<Vec<usize>> {
    const UNSEEN: usize = usize::MAX;
    let n = pattern.n();
    let active = pattern.set_of(kept.iter().copied());
    let (mut number, mut low) = (vec![UNSEEN; n], vec![0; n]);
    let (mut open, mut is_open) = (Vec::new(), vec![false; n]);
    let mut components = Vec::new();
    let mut count = 0;
    let mut calls: Vec<(usize, usize)> = Vec::new();
    for &start in kept {
        if number[start] != UNSEEN {
            continue;
        }
        calls.push((start, 0));
        while let Some((i, from)) = calls.pop() {
            if from == 0 && number[i] == UNSEEN {
                number[i] = count;
                low[i] = count;
                count += 1;
                open.push(i);
                is_open[i] = true;
            }
            let mut next = next_common(pattern.row(i), &active.0, from);
            while let Some(j) = next {
                if number[j] == UNSEEN {
                    break;
                }
                if is_open[j] {
                    low[i] = low[i].min(low[j]);
                }
                next = next_common(pattern.row(i), &active.0, j + 1);
            }
            if let Some(j) = next {
                // Column j is looked at again on return, when its low is known.
                calls.push((i, j));
                calls.push((j, 0));
            } else if low[i] == number[i] {
                let at = open.iter().rposition(|&k| k == i).expect("invariant: i is open");
                let mut component = open.split_off(at);
                component.iter().for_each(|&k| is_open[k] = false);
                component.sort_unstable();
                components.push(component);
            }
        }
    }
    components
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts_of(n: usize, entries: &[(usize, usize, f64)]) -> Vec<Part> {
        let mut a = vec![0.0; n * n];
        entries.iter().for_each(|&(i, j, x)| a[i * n + j] = x);
        let lcp = Lcp::new(n, a, vec![-1.0; n]).expect("valid");
        let mut pattern = Pattern::of(&lcp);
        pattern.transpose();
        islands(&pattern, &pattern.set_of(0..n)).iter().flat_map(|island| parts(&lcp, &pattern, island)).collect()
    }

    fn part(indices: &[usize], follows: bool) -> Part {
        Part { indices: indices.to_vec(), follows }
    }

    #[test]
    fn islands_by_least_index() {
        let found = parts_of(4, &[(0, 2, 1.0), (2, 0, 1.0), (1, 3, 1.0), (3, 1, 1.0)]);
        assert_eq!(found, [part(&[0, 2], false), part(&[1, 3], false)]);
    }

    #[test]
    fn a_triangle_of_p_blocks_is_solved_in_order() {
        let found = parts_of(3, &[(0, 0, 1.0), (0, 1, 5.0), (1, 1, 2.0), (1, 2, -3.0), (2, 2, 1.0)]);
        assert_eq!(found, [part(&[2], false), part(&[1], true), part(&[0], true)]);
    }

    #[test]
    fn only_the_last_block_may_have_many_solutions() {
        let edges = [(0, 0, 1.0), (0, 1, 5.0), (1, 1, -1.0)];
        assert_eq!(parts_of(2, &edges), [part(&[0, 1], false)]);
        let edges = [(0, 0, -1.0), (0, 1, 5.0), (1, 1, 1.0)];
        assert_eq!(parts_of(2, &edges), [part(&[1], false), part(&[0], true)]);
    }

    #[test]
    fn a_cycle_is_one_block() {
        let found = parts_of(3, &[(0, 1, 1.0), (1, 2, 1.0), (2, 0, 1.0)]);
        assert_eq!(found, [part(&[0, 1, 2], false)]);
    }
}
