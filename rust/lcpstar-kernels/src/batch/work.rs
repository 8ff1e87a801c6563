//! One worker: takes chunks of problems until none is left.

use super::alone::Alone;
use super::io::{Output, Problems, Settings};
use super::lanes::Lanes;
use crate::error::Result;
use crate::member::Member;
#[cfg(target_arch = "x86_64")]
use crate::small::avx::{Ymm2, Zmm};
#[cfg(target_arch = "x86_64")]
use crate::small::lane::Pair;
use crate::small::lane::{F64x8, Lane};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Largest order for which sixteen problems at a time, two chains of operations, are faster than eight.
const PAIR_ORDER: usize = 16;

/// Largest order for which a guessed support is tried in lanes.
pub(super) const GUESS_ORDER: usize = 32;

pub(super) const NEWTON: u8 = Member::Newton.code();
pub(super) const LEMKE: u8 = Member::Lemke.code();
pub(super) const ENUMERATE: u8 = Member::Enumerate.code();

/// Problems `first..first + output.status.len()` of a batch.
pub struct Chunk<'a> {
    pub first: usize,
    pub output: Output<'a>,
}

/// Takes chunks from `next` until there is none. The error, if any, is that of the first bad problem of a chunk.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn work<'a>(
    problems: &Problems<'_>,
    settings: &Settings<'_>,
    next: &(dyn Fn() -> Option<Chunk<'a>> + Sync),
) -> Result<()> {
    #[cfg(target_arch = "x86_64")]
    {
        if target_cfg_f!(target_feature = "avx512f") {
            if problems.n > PAIR_ORDER {
                return run::<Zmm, 0>(problems, settings, next);
            }
            return match problems.n {
                4 => run::<Pair<Zmm>, 4>(problems, settings, next),
                8 => run::<Pair<Zmm>, 8>(problems, settings, next),
                12 => run::<Pair<Zmm>, 12>(problems, settings, next),
                16 => run::<Pair<Zmm>, 16>(problems, settings, next),
                _ => run::<Pair<Zmm>, 0>(problems, settings, next),
            };
        }
        if target_cfg_f!(target_feature = "avx2") {
            return match problems.n {
                4 => run::<Ymm2, 4>(problems, settings, next),
                8 => run::<Ymm2, 8>(problems, settings, next),
                _ => run::<Ymm2, 0>(problems, settings, next),
            };
        }
    }
    portable(problems, settings, next)
}

/// Fused products are cheap where the instruction set has them, as all of aarch64 does.
#[inline(always)]
fn portable<'a>(
    problems: &Problems<'_>,
    settings: &Settings<'_>,
    next: &(dyn Fn() -> Option<Chunk<'a>> + Sync),
) -> Result<()> {
    const FUSED: bool = cfg!(target_arch = "aarch64");
    run::<F64x8<FUSED>, 0>(problems, settings, next)
}

/// `X` holds problems side by side; `N` is the order if known at compile time, else 0.
#[inline(always)]
pub(super) fn run<'a, X: Lane, const N: usize>(
    problems: &Problems<'_>,
    settings: &Settings<'_>,
    next: &(dyn Fn() -> Option<Chunk<'a>> + Sync),
) -> Result<()> {
    let n = problems.n;
    let in_lanes = settings.by_kernels() && n > 0 && n <= GUESS_ORDER;
    let mut lanes = Lanes::<X>::new(if in_lanes { n } else { 0 });
    let mut alone = Alone::new(problems, settings);
    let mut waiting = Vec::new();
    while let Some(mut chunk) = next() {
        waiting.clear();
        waiting.extend(0..chunk.output.status.len());
        let task = Task { problems, settings, first: chunk.first };
        if in_lanes {
            lanes.solve::<N>(&task, &mut waiting, &mut chunk.output);
        }
        alone.solve(&task, &mut waiting, &mut chunk.output)?;
    }
    Ok(())
}

/// What a worker reads.
pub(super) struct Task<'a> {
    pub problems: &'a Problems<'a>,
    pub settings: &'a Settings<'a>,
    /// Place of the chunk in the batch.
    pub first: usize,
}
