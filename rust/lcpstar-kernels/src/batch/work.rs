//! One worker: takes chunks of problems until none is left. What the lanes leave goes to the caller.

use super::io::{Output, Problems};
use super::lanes::Lanes;
use super::task::{Asked, Task};
use crate::cutovers::{GUESS_ORDER, PAIR_ORDER};
#[cfg(target_arch = "x86_64")]
use crate::small::avx::{Ymm2, Zmm};
#[cfg(target_arch = "x86_64")]
use crate::small::lane::Pair;
use crate::small::lane::{F64x8, Lane};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Problems `first..first + output.status.len()` of a batch.
#[derive(Debug)]
pub struct Chunk<'a> {
    /// Place of its first problem.
    pub first: usize,
    /// Where their results are written.
    pub output: Output<'a>,
}

/// Solves what the lanes leave, the problems of a chunk in the list, and empties it; `false` ends the work.
pub type Rest<'r> = dyn FnMut(&mut Chunk<'_>, &mut Vec<usize>) -> bool + 'r;

/// Takes chunks from `next` until there is none.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn work<'a>(
    problems: &Problems<'_>,
    asked: &Asked<'_>,
    next: &(dyn Fn() -> Option<Chunk<'a>> + Sync),
    rest: &mut Rest<'_>,
) {
    #[cfg(target_arch = "x86_64")]
    {
        if target_cfg_f!(target_feature = "avx512f") {
            if problems.n > PAIR_ORDER {
                return run::<Zmm, 0>(problems, asked, next, rest);
            }
            return match problems.n {
                4 => run::<Pair<Zmm>, 4>(problems, asked, next, rest),
                8 => run::<Pair<Zmm>, 8>(problems, asked, next, rest),
                _ => run::<Pair<Zmm>, 0>(problems, asked, next, rest),
            };
        }
        if target_cfg_f!(target_feature = "avx2") {
            return run::<Ymm2, 0>(problems, asked, next, rest);
        }
    }
    portable(problems, asked, next, rest)
}

/// Fused products are cheap where the instruction set has them, as all of aarch64 does.
#[inline(always)]
fn portable<'a>(
    problems: &Problems<'_>,
    asked: &Asked<'_>,
    next: &(dyn Fn() -> Option<Chunk<'a>> + Sync),
    rest: &mut Rest<'_>,
) {
    const FUSED: bool = cfg!(target_arch = "aarch64");
    run::<F64x8<FUSED>, 0>(problems, asked, next, rest)
}

/// [`work`] on one kind of lane: `X` holds problems side by side; `N` is the order if known at compile time, else 0.
#[inline(always)]
pub fn run<'a, X: Lane, const N: usize>(
    problems: &Problems<'_>,
    asked: &Asked<'_>,
    next: &(dyn Fn() -> Option<Chunk<'a>> + Sync),
    rest: &mut Rest<'_>,
) {
    let n = problems.n;
    let in_lanes = asked.in_lanes && n > 0 && n <= GUESS_ORDER;
    let mut lanes = Lanes::<X>::new(if in_lanes { n } else { 0 });
    let mut waiting = Vec::new();
    while let Some(mut chunk) = next() {
        waiting.clear();
        waiting.extend(0..chunk.output.status.len());
        if in_lanes {
            let task = Task { problems, asked, first: chunk.first };
            lanes.solve::<N>(&task, &mut waiting, &mut chunk.output);
        }
        if !rest(&mut chunk, &mut waiting) {
            return;
        }
    }
}
