//! Islands and the block-triangular order.

use super::Part;
use crate::linalg::backend::DenseCholesky;
use crate::pivoting::basis::principal_block;
use crate::problem::Lcp;

/// Whether the first row and the first column have no zero: then A is one strongly connected block. O(n).
pub fn first_reaches_all(lcp: &Lcp) -> bool {
    let n = lcp.n();
    lcp.row(0)[1..].iter().all(|&a| a != 0.0) && (1..n).all(|i| lcp.row(i)[0] != 0.0)
}

/// The parts of the problem on `kept`: its islands by least index, each whole or in block-triangular order.
///
/// An island is taken apart only where every block on which others depend is a P-matrix by a sufficient test: its
/// solution is then unique whatever its q is, and the blocks after it lose no solution.
pub fn parts(lcp: &Lcp, kept: &[usize]) -> Vec<Part> {
    let blocks = strong_components(lcp, kept);
    let island = islands_of(lcp, &blocks);
    let mut parts = Vec::with_capacity(blocks.len());
    for first in 0..blocks.len() {
        if island[first] != first {
            continue;
        }
        let members: Vec<usize> = (first..blocks.len()).filter(|&b| island[b] == first).collect();
        let needed = |b: usize| members.iter().any(|&c| c > b && depends(lcp, &blocks[c], &blocks[b]));
        if members.iter().all(|&b| !needed(b) || is_surely_p(lcp, &blocks[b])) {
            parts.extend(members.iter().enumerate().map(|(k, &b)| Part { indices: blocks[b].clone(), follows: k > 0 }));
        } else {
            let mut indices: Vec<usize> = members.iter().flat_map(|&b| blocks[b].iter().copied()).collect();
            indices.sort_unstable();
            parts.push(Part { indices, follows: false });
        }
    }
    parts
}

/// Whether a row of `later` has an entry in a column of `earlier`.
fn depends(lcp: &Lcp, later: &[usize], earlier: &[usize]) -> bool {
    later.iter().any(|&i| earlier.iter().any(|&j| lcp.row(i)[j] != 0.0))
}

/// The connected components of the pattern of A + A', each sorted, by least index.
pub fn islands(lcp: &Lcp) -> Vec<Vec<usize>> {
    let single: Vec<Vec<usize>> = (0..lcp.n()).map(|i| vec![i]).collect();
    let first = islands_of(lcp, &single);
    let mut islands = vec![vec![]; lcp.n()];
    (0..lcp.n()).for_each(|i| islands[first[i]].push(i));
    islands.retain(|island| !island.is_empty());
    islands
}

/// For each block the least block of its island: union-find with the least index as root.
fn islands_of(lcp: &Lcp, blocks: &[Vec<usize>]) -> Vec<usize> {
    let mut block_of = vec![usize::MAX; lcp.n()];
    for (b, block) in blocks.iter().enumerate() {
        block.iter().for_each(|&i| block_of[i] = b);
    }
    let mut parent: Vec<usize> = (0..blocks.len()).collect();
    for (b, block) in blocks.iter().enumerate() {
        for &i in block {
            for (j, &a) in lcp.row(i).iter().enumerate() {
                if a != 0.0 && block_of[j] != usize::MAX && block_of[j] != b {
                    let (r, s) = (root(&mut parent, b), root(&mut parent, block_of[j]));
                    parent[r.max(s)] = r.min(s);
                }
            }
        }
    }
    (0..blocks.len()).map(|b| root(&mut parent, b)).collect()
}

fn root(parent: &mut [usize], mut b: usize) -> usize {
    while parent[b] != b {
        parent[b] = parent[parent[b]];
        b = parent[b];
    }
    b
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
/// in which every component comes after those it has edges to. Tarjan's algorithm with an explicit stack [Tar72]; O(n^2).
fn strong_components(lcp: &Lcp, kept: &[usize]) -> Vec<Vec<usize>> {
    const UNSEEN: usize = usize::MAX;
    let n = lcp.n();
    let mut active = vec![false; n];
    kept.iter().for_each(|&i| active[i] = true);
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
            let row = lcp.row(i);
            let mut next = None;
            for j in from..n {
                if row[j] == 0.0 || !active[j] {
                    continue;
                }
                if number[j] == UNSEEN {
                    next = Some(j);
                    break;
                }
                if is_open[j] {
                    low[i] = low[i].min(low[j]);
                }
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
        parts(&lcp, &(0..n).collect::<Vec<_>>())
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
