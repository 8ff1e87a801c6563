//! What the lanes leave, one problem at a time: from the caller's guess, by Lemke's method in memory that is used again, by the
//! general solver.

use super::{Guess, Output, Problems, Settings};
use crate::control::Control;
use crate::cutovers::LEMKE_ALONE_UP_TO;
use crate::driver::{self, doubt};
use crate::equilibrate::Equilibrated;
use crate::error::{LcpError, Result};
use crate::judge::judge;
use crate::member::Member;
use crate::problem::Lcp;
use crate::small::TINY_ORDER;
use crate::small::dispatch;
use crate::small::prefetch::Prefetch;
use crate::solution::{Candidate, Solution};
use crate::status::Termination;
use lcpstar_kernels::batch::task::LEMKE;
use lcpstar_kernels::batch::work::Chunk;
use lcpstar_kernels::cutovers::GUESS_ORDER;

/// Memory of one thread.
pub(super) struct Alone<'a> {
    problems: &'a Problems<'a>,
    settings: &'a Settings<'a>,
    /// A problem, copied: what is solved is what is judged, whatever becomes of the caller's arrays meanwhile.
    a: Vec<f64>,
    q: Vec<f64>,
    /// Whether z_j is in the basis on which Lemke's method ended.
    basic: Vec<bool>,
    general: driver::Settings,
    control: Control<'a>,
    prefetch: Prefetch,
    /// Problems that a method leaves.
    left: Vec<usize>,
}

impl<'a> Alone<'a> {
    pub fn new(problems: &'a Problems<'a>, settings: &'a Settings<'a>) -> Self {
        let general = driver::Settings {
            method: settings.method.clone(),
            tol: settings.tol,
            z0: None,
            ..driver::Settings::default()
        };
        let control = Control { interrupted: settings.interrupted, ..Control::default() };
        Self {
            problems,
            settings,
            a: Vec::new(),
            q: Vec::new(),
            basic: vec![false; problems.n],
            general,
            control,
            prefetch: Prefetch::default(),
            left: Vec::new(),
        }
    }

    /// Solves the problems in `waiting`.
    pub fn solve(&mut self, chunk: &mut Chunk<'_>, waiting: &mut Vec<usize>) -> Result<()> {
        let (n, settings) = (self.problems.n, self.settings);
        // Up to `GUESS_ORDER` the lanes have tried the guess.
        let by_kernels = settings.by_kernels() && n > 0 && n <= LEMKE_ALONE_UP_TO;
        let guessed = !matches!(settings.guess, Guess::None) && (n > GUESS_ORDER || !by_kernels);
        if guessed && by_kernels {
            self.by_guess(chunk, waiting)?;
        }
        // Above it, the general solver's path from the guess is the cheaper one.
        if by_kernels && (!guessed || n <= TINY_ORDER) {
            self.by_lemke(chunk, waiting);
        }
        for &k in &*waiting {
            let place = chunk.first + k;
            self.general.z0 = if guessed { Some(point(n, settings.guess, place)) } else { None };
            let lcp = problem(self.problems, place)?;
            let solution = driver::solve(&lcp, &self.general, &self.control).map_err(|error| in_batch(error, place))?;
            write(&mut chunk.output, n, k, &solution);
        }
        Ok(())
    }

    /// The supports that the caller guesses, for each problem that waits.
    fn by_guess(&mut self, chunk: &mut Chunk<'_>, waiting: &mut Vec<usize>) -> Result<()> {
        let n = self.problems.n;
        for k in waiting.drain(..) {
            let place = chunk.first + k;
            self.general.z0 = Some(point(n, self.settings.guess, place));
            match driver::solve_from_guess(&problem(self.problems, place)?, &self.general) {
                Some(solution) => write(&mut chunk.output, n, k, &solution),
                None => self.left.push(k),
            }
        }
        waiting.append(&mut self.left);
        Ok(())
    }

    /// Lemke's method for each problem that waits.
    fn by_lemke(&mut self, chunk: &mut Chunk<'_>, waiting: &mut Vec<usize>) {
        let (n, problems, tol, output) = (self.problems.n, self.problems, self.settings.tol, &mut chunk.output);
        for (i, &k) in waiting.iter().enumerate() {
            let (place, range) = (chunk.first + k, k * n..(k + 1) * n);
            self.prefetch.clear();
            if let Some(next) = waiting.get(i + 1) {
                problems.plan(&mut self.prefetch, chunk.first + next, n.div_ceil(2));
            }
            problems.copy(place, &mut self.a, &mut self.q);
            let (a, q) = (&self.a[..], &self.q[..]);
            let (z, w) = (&mut output.z[range.clone()], &mut output.w[range.clone()]);
            let solve = dispatch::Task::Solve { z, basic: &mut self.basic, prefetch: &mut self.prefetch };
            let outcome = dispatch::run(solve, a, q, w, tol);
            self.prefetch.rest();
            if let Some(accepted) = outcome.accepted {
                output.accept(k, LEMKE, outcome.pivots as u32, &accepted);
                output.alpha.write(n, k, |i| self.basic[i]);
                continue;
            }
            let basis = outcome.found_basis.then_some(&self.basic);
            match basis.and_then(|basic| unverified(a, q, &output.z[range], basic, outcome.pivots, tol)) {
                Some(solution) => write(output, n, k, &solution),
                None => self.left.push(k),
            }
        }
        waiting.clear();
        waiting.append(&mut self.left);
    }
}

/// A basis that Lemke's method found and could not verify row by row, judged on the equilibrated problem; none where there is
/// doubt.
#[cold]
fn unverified(a: &[f64], q: &[f64], z: &[f64], basic: &[bool], pivots: usize, tol: f64) -> Option<Solution> {
    let n = q.len();
    let lcp = Lcp::new(n, a.to_vec(), q.to_vec()).ok()?;
    let problem = Equilibrated::new(&lcp);
    let alpha = (0..n).filter(|&j| basic[j]).collect();
    let point = Candidate::point(problem.scaling.z_from_caller(z), Termination::ComplementaryBasis, pivots);
    let solution = judge(&problem, Candidate { alpha: Some(alpha), ..point }, Member::Lemke, tol);
    (solution.is_solved() && !doubt::misses_q(&lcp, &solution)).then_some(solution)
}

/// A problem of the batch for the general solver.
fn problem(problems: &Problems<'_>, place: usize) -> Result<Lcp> {
    let (mut a, mut q) = (Vec::new(), Vec::new());
    problems.copy(place, &mut a, &mut q);
    Lcp::new(problems.n, a, q).map_err(|error| in_batch(error, place))
}

/// A point with the support that is guessed.
fn point(n: usize, guess: Guess<'_>, place: usize) -> Vec<f64> {
    (0..n).map(|i| f64::from(u8::from(guess.contains(n, place, i, false)))).collect()
}

/// The general solver's answer to problem k of a chunk.
fn write(output: &mut Output<'_>, n: usize, k: usize, solution: &Solution) {
    let range = k * n..(k + 1) * n;
    output.z[range.clone()].copy_from_slice(&solution.z);
    output.w[range].copy_from_slice(&solution.w);
    output.status[k] = solution.status() as u8;
    output.method[k] = solution.method.code();
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
