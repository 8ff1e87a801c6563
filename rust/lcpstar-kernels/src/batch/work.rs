//! One worker: takes chunks of problems until none is left.

use super::alone::Alone;
use super::io::{Output, Problems, Settings};
use super::lanes::Lanes;
use crate::driver;
use crate::error::Result;
#[cfg(target_arch = "x86_64")]
use crate::small::avx::{Ymm2, YmmS, Zmm, ZmmS};
#[cfg(target_arch = "x86_64")]
use crate::small::lane::Pair;
use crate::small::lane::{F32x8, F64x8, Lane};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Largest order for which sixteen problems at a time, two chains of operations, are faster than eight.
const PAIR_ORDER: usize = 16;

/// Largest order for which a guessed support is tried in lanes.
pub(super) const GUESS_ORDER: usize = 32;

const COUNT: usize = driver::Method::NAMES.len() + driver::MEMBERS.len();

/// Names of the methods in [`Output::method`](super::Output::method): all that a result may bear.
pub const METHODS: [&str; COUNT] = {
    let mut all = [""; COUNT];
    let (methods, members) = all.split_at_mut(driver::Method::NAMES.len());
    methods.copy_from_slice(driver::Method::NAMES);
    members.copy_from_slice(driver::MEMBERS);
    all
};
pub(super) const NEWTON: u8 = code("newton");
pub(super) const LEMKE: u8 = code("lemke");
pub(super) const ENUMERATE: u8 = code("enumerate");
pub(super) const AUTO: u8 = code("auto");

/// The place of a name in [`METHODS`]; one that is not there stops the compiler.
const fn code(name: &str) -> u8 {
    let mut i = 0;
    while !is_same(METHODS[i].as_bytes(), name.as_bytes()) {
        i += 1;
    }
    i as u8
}

const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

/// The place of a name of the general solver in [`METHODS`].
pub(super) fn method_code(name: &str) -> u8 {
    METHODS.iter().position(|&known| known == name).map_or(AUTO, |i| i as u8)
}

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
                return run::<Zmm, YmmS, 0>(problems, settings, next);
            }
            return match problems.n {
                4 => run::<Pair<Zmm>, ZmmS, 4>(problems, settings, next),
                8 => run::<Pair<Zmm>, ZmmS, 8>(problems, settings, next),
                12 => run::<Pair<Zmm>, ZmmS, 12>(problems, settings, next),
                16 => run::<Pair<Zmm>, ZmmS, 16>(problems, settings, next),
                _ => run::<Pair<Zmm>, ZmmS, 0>(problems, settings, next),
            };
        }
        if target_cfg_f!(target_feature = "avx2") {
            return match problems.n {
                4 => run::<Ymm2, YmmS, 4>(problems, settings, next),
                8 => run::<Ymm2, YmmS, 8>(problems, settings, next),
                _ => run::<Ymm2, YmmS, 0>(problems, settings, next),
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
    run::<F64x8<FUSED>, F32x8<FUSED>, 0>(problems, settings, next)
}

/// `X` holds problems side by side, `S` as many in single precision; `N` is the order if known at compile time, else 0.
#[inline(always)]
pub(super) fn run<'a, X: Lane<Number = f64>, S: Lane<Number = f32>, const N: usize>(
    problems: &Problems<'_>,
    settings: &Settings<'_>,
    next: &(dyn Fn() -> Option<Chunk<'a>> + Sync),
) -> Result<()> {
    let n = problems.n;
    let in_lanes = settings.by_kernels() && n > 0 && n <= GUESS_ORDER;
    let mut lanes = Lanes::<X, S>::new(if in_lanes { n } else { 0 }, problems);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_member_of_the_portfolio_has_a_name_in_a_batch() {
        let source = concat!(include_str!("../driver/portfolio.rs"), include_str!("../driver/prove.rs"));
        let names: Vec<&str> = source.split("race.run(\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert!(names.len() > 9, "{names:?}");
        for name in names {
            assert_eq!(METHODS[usize::from(method_code(name))], name);
        }
        for (i, name) in METHODS.iter().enumerate() {
            assert_eq!(usize::from(method_code(name)), i, "{name} is listed twice");
        }
    }
}
