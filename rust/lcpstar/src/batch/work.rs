//! One worker: takes chunks of problems until none is left.

use super::io::{Guess, Output, Problems, Settings};
use super::lanes::Lanes;
use crate::certify::certify;
use crate::control::Control;
use crate::driver::{self, doubt};
use crate::error::{LcpError, Result};
use crate::problem::Lcp;
use crate::scaling::Equilibrated;
use crate::small::TINY_ORDER;
#[cfg(target_arch = "x86_64")]
use crate::small::avx::{Ymm2, YmmS, Zmm, ZmmS};
use crate::small::dispatch;
#[cfg(target_arch = "x86_64")]
use crate::small::lane::Pair;
use crate::small::lane::{F32x8, F64x8, Lane};
use crate::solution::{Candidate, Solution};
use crate::status::{Status, Termination};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Largest order for which sixteen problems at a time, two chains of operations, are faster than eight.
const PAIR_ORDER: usize = 16;

/// Largest order for which a guessed support is tried in lanes.
pub(super) const GUESS_ORDER: usize = 32;

/// Largest order for which Lemke's method is tried before the general solver.
const SMALL_ORDER: usize = 192;

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
const AUTO: u8 = code("auto");

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
fn method_code(name: &str) -> u8 {
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
    let auto = matches!(settings.method, driver::Method::Auto);
    let mut worker = Worker::new(n);
    let mut lanes = Lanes::<X, S>::new(if auto && n <= GUESS_ORDER { n } else { 0 }, problems);
    while let Some(mut chunk) = next() {
        worker.waiting.clear();
        worker.waiting.extend(0..chunk.output.status.len());
        let task = Task { problems, settings, first: chunk.first };
        if auto && n > 0 && n <= GUESS_ORDER {
            lanes.solve::<N>(&task, &mut worker.waiting, &mut chunk.output);
        }
        worker.one_by_one(&task, &mut chunk.output)?;
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

/// Memory of one thread for problems that take turns.
struct Worker {
    n: usize,
    a: Vec<f64>,
    q: Vec<f64>,
    /// The basis on which the kernel ended.
    basic: Vec<bool>,
    /// Problems of the chunk that are not solved yet.
    waiting: Vec<usize>,
}

impl Worker {
    fn new(n: usize) -> Self {
        Self { n, a: vec![0.0; n * n], q: vec![0.0; n], basic: vec![false; n], waiting: Vec::new() }
    }

    /// Lemke's method for each problem that waits; the general solver for what that leaves.
    fn one_by_one(&mut self, task: &Task<'_>, output: &mut Output<'_>) -> Result<()> {
        let (n, settings) = (self.n, task.settings);
        let mut general = driver::Settings {
            method: settings.method.clone(),
            tol: settings.tol,
            z0: None,
            ..driver::Settings::default()
        };
        let by_lemke = matches!(settings.method, driver::Method::Auto) && n <= SMALL_ORDER && n > 0;
        let control = Control { interrupted: settings.interrupted, ..Control::default() };
        for &k in &self.waiting {
            let place = task.first + k;
            task.problems.copy(place, &mut self.a, &mut self.q);
            // Up to `GUESS_ORDER` the lanes have tried the guess.
            let guessed = !matches!(settings.guess, Guess::None) && (n > GUESS_ORDER || !by_lemke);
            let mut lcp = None;
            if guessed {
                let z0 = (0..n).map(|i| f64::from(u8::from(settings.guess.contains(n, place, i, false)))).collect();
                general.z0 = Some(z0);
                let given = self.problem(place)?;
                let solution = if by_lemke { driver::solve_from_guess(&given, &general) } else { None };
                if let Some(solution) = solution {
                    write(output, n, k, &solution);
                    continue;
                }
                lcp = Some(given);
            }
            // Above it, the general solver's path from the guess is the cheaper one.
            let by_kernel = by_lemke && (!guessed || n <= TINY_ORDER);
            let range = k * n..(k + 1) * n;
            let mut found_basis = None;
            if by_kernel {
                let (z, w) = (&mut output.z[range.clone()], &mut output.w[range.clone()]);
                let solve = dispatch::Task::Solve { z, basic: &mut self.basic };
                let outcome = dispatch::run(solve, &self.a, &self.q, w, settings.tol);
                if let Some(judged) = outcome.judged {
                    output.status[k] = Status::Solved as u8;
                    output.method[k] = LEMKE;
                    output.iterations[k] = outcome.pivots as u32;
                    output.residual[k] = judged.residual;
                    output.natural_residual[k] = judged.natural_residual;
                    output.alpha.write(n, k, |i| self.basic[i]);
                    continue;
                }
                found_basis = outcome.found_basis.then_some(outcome.pivots);
            }
            let lcp = lcp.map_or_else(|| self.problem(place), Ok)?;
            let unverified =
                found_basis.and_then(|pivots| self.unverified_point(&output.z[range], pivots, &lcp, settings.tol));
            let solution = match unverified {
                Some(solution) => solution,
                None => driver::solve(&lcp, &general, &control).map_err(|error| in_batch(error, place))?,
            };
            write(output, n, k, &solution);
        }
        Ok(())
    }
}

impl Worker {
    /// The problem that was copied last, from that place of the batch.
    fn problem(&self, place: usize) -> Result<Lcp> {
        Lcp::new(self.n, self.a.clone(), self.q.clone()).map_err(|error| in_batch(error, place))
    }

    /// A basis that Lemke's method found and could not verify row by row, judged on the equilibrated problem; the general
    /// solver is asked where there is doubt.
    fn unverified_point(&self, z: &[f64], pivots: usize, lcp: &Lcp, tol: f64) -> Option<Solution> {
        let problem = Equilibrated::new(lcp);
        let alpha = (0..self.n).filter(|&j| self.basic[j]).collect();
        let point = Candidate::point(problem.scaling.z_from_caller(z), Termination::ComplementaryBasis, pivots);
        let solution = certify(&problem, Candidate { alpha: Some(alpha), ..point }, METHODS[usize::from(LEMKE)], tol);
        (solution.status == Status::Solved && !doubt::misses_q(lcp, &solution)).then_some(solution)
    }
}

/// The general solver's answer to problem k of a chunk.
fn write(output: &mut Output<'_>, n: usize, k: usize, solution: &Solution) {
    let range = k * n..(k + 1) * n;
    output.z[range.clone()].copy_from_slice(&solution.z);
    output.w[range].copy_from_slice(&solution.w);
    output.status[k] = solution.status as u8;
    output.method[k] = method_code(solution.method);
    output.iterations[k] = u32::try_from(solution.iterations).unwrap_or(u32::MAX);
    output.residual[k] = solution.residual;
    output.natural_residual[k] = solution.natural_residual;
    output.alpha.write(n, k, |i| solution.alpha.contains(&i));
}

/// The error with the position in the batch before the position in the array.
fn in_batch(error: LcpError, k: usize) -> LcpError {
    match error {
        LcpError::NotFinite { name, mut index, value } => {
            index.insert(0, k);
            LcpError::NotFinite { name, index, value }
        }
        other => other,
    }
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
