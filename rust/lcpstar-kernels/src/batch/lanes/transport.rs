//! Problems into the lanes, results out of them.

use super::transpose::columns;
use super::{Found, Group, Lanes, Phase};
use crate::batch::io::Output;
use crate::batch::task::Task;
use crate::cutovers::MINORS_ORDER;
use crate::small::lane::{BLOCK, Lane, MOST_LANES, Mask};
use crate::small::verify::Verdict;

impl<X: Lane> Lanes<X> {
    /// Copies problems into the lanes; spare lanes repeat the last one. Blocks of A that the lanes hold already stay.
    #[inline(always)]
    pub(super) fn load<const N: usize>(&mut self, task: &Task<'_>, members: &[usize]) {
        let n = if N == 0 { self.n } else { N };
        let problems = task.problems;
        let (mut a_blocks, mut q_blocks) = ([0; MOST_LANES], [0; MOST_LANES]);
        for l in 0..X::LANES {
            let place = task.first + members[l.min(members.len() - 1)];
            (a_blocks[l], q_blocks[l]) = (problems.a_source.block(place), problems.q_source.block(place));
        }
        self.scales.forget();
        let tile = &mut self.tile;
        if a_blocks[..X::LANES] != self.loaded[..X::LANES] {
            columns(problems.a, n * n, &a_blocks, &mut tile.a);
            self.loaded = a_blocks;
        }
        columns(problems.q, n, &q_blocks, &mut tile.q);
    }

    /// Plans to ask for the matrices of the problems that are next.
    #[inline(always)]
    pub(super) fn plan_prefetch(&mut self, phase: Phase, task: &Task<'_>, members: &[usize]) {
        let (n, problems, prefetch) = (self.n, task.problems, &mut self.tile.prefetch);
        // A factorisation has a step for each column; sweeps have more.
        let steps = if phase.is_newton() { 2 * n } else { n };
        prefetch.clear();
        // Smaller ones come in order, and the processor sees that by itself.
        let members = if n > MINORS_ORDER { members } else { &[] };
        for &k in members {
            let block = problems.a_source.block(task.first + k);
            if block == self.loaded[0] {
                return;
            }
            problems.plan(prefetch, task.first + k, steps);
        }
    }

    /// Writes the results of the lanes that are verified, with the supports in alpha.
    #[inline(always)]
    pub(super) fn write<const N: usize>(
        &mut self,
        group: &mut Group<'_, X>,
        found: &Found<X>,
        verdict: &Verdict<X>,
        output: &mut Output<'_>,
    ) {
        let n = if N == 0 { self.n } else { N };
        let solved = group.open.and(found.lanes).and(verdict.solved());
        group.open = group.open.and(solved.not());
        let solved = solved.bits();
        if solved == 0 {
            return;
        }
        for (source, out) in [(&self.tile.z, &mut *output.z), (&self.tile.w, &mut *output.w)] {
            let (blocks, rest) = source[..n].as_chunks::<BLOCK>();
            // Backwards: a last block that is not whole reaches into the next row.
            if !rest.is_empty() {
                X::store_columns(rest, &mut self.rows[n - rest.len()..], n);
            }
            for (b, columns) in blocks.iter().enumerate().rev() {
                X::store_columns(columns, &mut self.rows[BLOCK * b..], n);
            }
            for (l, k, count) in runs(group.members, solved) {
                out[k * n..(k + count) * n].copy_from_slice(&self.rows[l * n..(l + count) * n]);
            }
        }
        let masks = self.tile.masks(n);
        for (l, k, count) in runs(group.members, solved) {
            for (l, k) in (l..l + count).zip(k..) {
                if let Some(accepted) = verdict.accepted(l) {
                    output.accept(k, found.method, u32::from(found.iterations[l]), &accepted);
                }
            }
            output.alpha.write_masks(n, k, &masks[l..l + count]);
        }
    }
}

/// Lanes of `solved` whose problems follow each other: the first lane, its problem, and how many.
#[inline(always)]
fn runs(members: &[usize], solved: u32) -> impl Iterator<Item = (usize, usize, usize)> {
    let is_solved = move |l: usize| l < members.len() && solved >> l & 1 == 1;
    let mut l = 0;
    std::iter::from_fn(move || {
        while l < members.len() && !is_solved(l) {
            l += 1;
        }
        let (first, k) = (l, *members.get(l)?);
        while is_solved(l) && members[l] == k + (l - first) {
            l += 1;
        }
        Some((first, k, l - first))
    })
}
