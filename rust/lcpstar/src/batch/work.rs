//! One worker: takes chunks of problems until none is left.

use super::io::{Guess, Output, Problems, Settings};
use super::lemke_lanes::Pivots;
use super::newton::{Tile, multiply, newton, refine};
use crate::certify::certify;
use crate::control::Control;
use crate::driver;
use crate::error::{LcpError, Result};
use crate::problem::Lcp;
use crate::scaling::Equilibrated;
#[cfg(target_arch = "x86_64")]
use crate::small::avx::{Ymm2, Zmm};
use crate::small::lane::{F64x8, Lane, Mask};
use crate::small::lemke::{PIVOTS_PER_ROW, Tableau};
use crate::small::verify::{Verdict, is_small_when_equilibrated, verify};
use crate::solution::{Candidate, Solution};
use crate::status::{Status, Termination};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Largest order for which problems share registers; above, they take turns.
const LANE_ORDER: usize = 20;

/// Largest order for which a guessed support is tried in lanes.
const GUESS_ORDER: usize = 32;

/// Largest order for which the tableau is tried before the general solver.
const TABLEAU_ORDER: usize = 192;

/// Names of the methods in [`Output::method`](super::Output::method).
pub const METHODS: &[&str] = &[
    "newton",
    "lemke",
    "auto",
    "trivial",
    "warm_start",
    "block_pivoting",
    "lemke_howson",
    "lemke_double_double",
    "lemke_random_d",
    "lemke_warm",
    "potential_reduction",
    "interior_point",
    "feasibility",
    "bilinear",
    "exact_lemke",
    "principal_pivoting",
    "chandrasekaran",
    "enumerate",
    "islands",
    "pgs",
    "pgs_sm",
    "nncg",
    "apgd",
    "admm",
];
const NEWTON: u8 = 0;
const LEMKE: u8 = 1;
const AUTO: u8 = 2;

/// The place of a name of the general solver in [`METHODS`].
fn method_code(name: &str) -> u8 {
    METHODS.iter().position(|&known| known == name).map_or(AUTO, |i| i as u8)
}

/// Factorisations after which a lane goes on to Lemke's method.
const FACTORISATIONS: usize = 6;

/// Refinement steps at most.
const REFINEMENTS: usize = 2;

/// Problems `first..first + output.status.len()` of a batch.
pub struct Chunk<'a> {
    pub first: usize,
    pub output: Output<'a>,
}

/// Takes chunks from `next` until there is none. The error, if any, is that of the first bad problem of a chunk.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn work<'a>(
    problems: &Problems<'_, f64>,
    settings: &Settings<'_>,
    next: &(dyn Fn() -> Option<Chunk<'a>> + Sync),
) -> Result<()> {
    #[cfg(target_arch = "x86_64")]
    {
        if target_cfg_f!(target_feature = "avx512f") {
            return run::<Zmm>(problems, settings, next);
        }
        if target_cfg_f!(target_feature = "avx2") {
            return run::<Ymm2>(problems, settings, next);
        }
    }
    // Fused products are cheap where the instruction set has them, as all of aarch64 does.
    run::<F64x8<{ cfg!(target_arch = "aarch64") }>>(problems, settings, next)
}

#[inline(always)]
fn run<'a, X: Lane<Number = f64>>(
    problems: &Problems<'_, f64>,
    settings: &Settings<'_>,
    next: &(dyn Fn() -> Option<Chunk<'a>> + Sync),
) -> Result<()> {
    let n = problems.n;
    let mut worker = Worker::<X>::new(n);
    while let Some(mut chunk) = next() {
        worker.waiting.clear();
        worker.waiting.extend(0..chunk.output.status.len());
        let task = Task { problems, settings, first: chunk.first };
        match n {
            4 => worker.in_lanes::<4>(&task, &mut chunk.output),
            8 => worker.in_lanes::<8>(&task, &mut chunk.output),
            _ => worker.in_lanes::<0>(&task, &mut chunk.output),
        }
        worker.one_by_one(&task, &mut chunk.output)?;
    }
    Ok(())
}

/// What a worker reads.
struct Task<'a> {
    problems: &'a Problems<'a, f64>,
    settings: &'a Settings<'a>,
    /// Place of the chunk in the batch.
    first: usize,
}

/// Memory of one thread.
struct Worker<X: Lane> {
    n: usize,
    tile: Tile<X>,
    pivots: Pivots<X>,
    tableau: Tableau<X>,
    w: Vec<f64>,
    a: Vec<f64>,
    q: Vec<f64>,
    /// Problems of the chunk that are not solved yet, and room for the next such list.
    waiting: Vec<usize>,
    failed: Vec<usize>,
}

impl<X: Lane<Number = f64>> Worker<X> {
    #[inline(always)]
    fn new(n: usize) -> Self {
        let lanes = if n <= GUESS_ORDER { n } else { 0 };
        Self {
            n,
            tile: Tile::new(lanes),
            pivots: Pivots::new(lanes),
            tableau: Tableau::default(),
            w: vec![0.0; n],
            a: vec![0.0; n * n],
            q: vec![0.0; n],
            waiting: Vec::new(),
            failed: Vec::new(),
        }
    }

    /// What problems side by side can do: the guess, then Newton's method, then Lemke's.
    #[inline(always)]
    fn in_lanes<const N: usize>(&mut self, task: &Task<'_>, output: &mut Output<'_>) {
        let n = self.n;
        if n == 0 || !matches!(task.settings.method, driver::Method::Auto) {
            return;
        }
        if n <= GUESS_ORDER && !matches!(task.settings.guess, Guess::None) {
            self.phase::<N>(Phase::Guess, task, output);
        }
        if n <= LANE_ORDER {
            self.phase::<N>(Phase::Newton, task, output);
            self.phase::<N>(Phase::Lemke, task, output);
        }
    }

    /// Tries one method on the problems that wait, `X::LANES` at a time; those it does not solve wait on.
    #[inline(always)]
    fn phase<const N: usize>(&mut self, phase: Phase, task: &Task<'_>, output: &mut Output<'_>) {
        let (waiting, tol) = (std::mem::take(&mut self.waiting), task.settings.tol);
        self.failed.clear();
        for members in waiting.chunks(X::LANES) {
            self.load::<N>(task, members);
            let (fit, symmetric) = self.shape::<N>(members.len());
            let mut open = lanes_of::<X>(members.len());
            match phase {
                Phase::Guess => {
                    for (lanes, kind) in [(symmetric, true), (symmetric.not(), false)] {
                        let lanes = open.and(lanes);
                        self.newton::<N>(Some(task), members, lanes, kind, 1, tol, &mut open, output);
                    }
                }
                Phase::Newton => {
                    for (lanes, kind) in [(symmetric, true), (symmetric.not(), false)] {
                        let lanes = open.and(fit).and(lanes);
                        self.newton::<N>(None, members, lanes, kind, FACTORISATIONS, tol, &mut open, output);
                    }
                }
                Phase::Lemke => self.lemke::<N>(members, tol, &mut open, output),
            }
            self.failed.extend(members.iter().enumerate().filter(|&(l, _)| open.get(l)).map(|(_, &k)| k));
        }
        self.waiting = waiting;
        std::mem::swap(&mut self.waiting, &mut self.failed);
    }

    /// Newton's method on `lanes`, from the guess of the task or else from the rows with `q_i < 0`.
    #[inline(always)]
    fn newton<const N: usize>(
        &mut self,
        guess: Option<&Task<'_>>,
        members: &[usize],
        lanes: X::Mask,
        symmetric: bool,
        limit: usize,
        tol: f64,
        open: &mut X::Mask,
        output: &mut Output<'_>,
    ) {
        if !lanes.any() {
            return;
        }
        let n = if N == 0 { self.n } else { N };
        let zero = X::splat(0.0);
        for i in 0..n {
            self.tile.alpha[i] = self.tile.q[i].lt(zero);
        }
        if let Some(task) = guess {
            for l in 0..X::LANES {
                let k = task.first + members[l.min(members.len() - 1)];
                for i in 0..n {
                    self.tile.alpha[i].set(l, task.settings.guess.contains(n, k, i, false));
                }
            }
        }
        let iterations = newton::<X, N>(n, &mut self.tile, lanes, symmetric, limit);
        if guess.is_some() {
            // Degenerate rows may come out a rounding error below zero: what counts is what is verified.
            for z in &mut self.tile.z {
                *z = z.max(zero);
            }
            multiply::<X, N>(n, &mut self.tile);
        }
        let mut verdict = self.verdict::<N>(tol);
        for _ in 0..REFINEMENTS {
            let wanting = lanes.and(verdict.solved.not());
            if !wanting.any() {
                break;
            }
            refine::<X, N>(n, &mut self.tile, wanting);
            verdict = self.verdict::<N>(tol);
        }
        let solved = lanes.and(verdict.solved);
        for i in 0..n {
            self.tile.alpha[i] = zero.lt(self.tile.z[i]);
        }
        self.write::<N>(NEWTON, members, solved, &iterations, &verdict, output);
        *open = open.and(solved.not());
    }

    /// Lemke's method on the lanes that are open.
    #[inline(always)]
    fn lemke<const N: usize>(&mut self, members: &[usize], tol: f64, open: &mut X::Mask, output: &mut Output<'_>) {
        let n = if N == 0 { self.n } else { N };
        let mut pivots = [0; 16];
        let finished = self.pivots.solve::<N>(n, &mut self.tile, *open, PIVOTS_PER_ROW * n, &mut pivots);
        multiply::<X, N>(n, &mut self.tile);
        let verdict = self.verdict::<N>(tol);
        let solved = finished.and(verdict.solved);
        self.write::<N>(LEMKE, members, solved, &pivots, &verdict, output);
        *open = open.and(solved.not());
    }

    #[inline(always)]
    fn verdict<const N: usize>(&self, tol: f64) -> Verdict<X> {
        let tile = &self.tile;
        let mut verdict = verify::<X, N>(self.n, &tile.a, &tile.q, &tile.z, &tile.w, tol);
        if verdict.unsettled.any() {
            self.settle(&mut verdict, tol);
        }
        verdict
    }

    /// Decides the lanes that need the scaling of their problem, one by one.
    fn settle(&self, verdict: &mut Verdict<X>, tol: f64) {
        let (n, tile) = (self.n, &self.tile);
        let lane = |v: &[X], l: usize| -> Vec<f64> { v.iter().map(|x| x.get(l)).collect() };
        for l in (0..X::LANES).filter(|&l| verdict.unsettled.get(l)) {
            let (a, q) = (lane(&tile.a[..n * n], l), lane(&tile.q[..n], l));
            let (z, w) = (lane(&tile.z[..n], l), lane(&tile.w[..n], l));
            verdict.solved.set(l, is_small_when_equilibrated(n, &a, &q, &z, &w, tol));
        }
    }

    /// Writes the results of the lanes that are solved.
    #[inline(always)]
    fn write<const N: usize>(
        &self,
        method: u8,
        members: &[usize],
        solved: X::Mask,
        iterations: &[u8; 16],
        verdict: &Verdict<X>,
        output: &mut Output<'_>,
    ) {
        let n = if N == 0 { self.n } else { N };
        for (l, &k) in members.iter().enumerate().filter(|&(l, _)| solved.get(l)) {
            for i in 0..n {
                output.z[k * n + i] = self.tile.z[i].get(l);
                output.w[k * n + i] = self.tile.w[i].get(l);
            }
            output.status[k] = Status::Solved as u8;
            output.method[k] = method;
            output.iterations[k] = u32::from(iterations[l]);
            output.residual[k] = verdict.residual.get(l);
            output.natural_residual[k] = verdict.natural_residual.get(l);
            output.alpha.write(n, k, |i| self.tile.alpha[i].get(l));
        }
    }

    /// Copies problems into the lanes, eight numbers of each at a time; spare lanes repeat the last one.
    #[inline(always)]
    fn load<const N: usize>(&mut self, task: &Task<'_>, members: &[usize]) {
        let n = if N == 0 { self.n } else { N };
        let mut sources: [(&[f64], &[f64]); 16] = [(&[], &[]); 16];
        for l in 0..X::LANES {
            let (a, q) = task.problems.get(task.first + members[l.min(members.len() - 1)]);
            sources[l] = (&a[..n * n], &q[..n]);
        }
        for (b, block) in self.tile.a[..n * n].chunks_mut(8).enumerate() {
            for l in 0..X::LANES {
                for (lane, &x) in block.iter_mut().zip(&sources[l].0[8 * b..]) {
                    lane.set(l, x);
                }
            }
        }
        for l in 0..X::LANES {
            for (lane, &x) in self.tile.q[..n].iter_mut().zip(sources[l].1) {
                lane.set(l, x);
            }
        }
    }

    /// Lanes with a positive diagonal, for which Newton's method is worth trying, and lanes with a symmetric matrix.
    #[inline(always)]
    fn shape<const N: usize>(&self, members: usize) -> (X::Mask, X::Mask) {
        let n = if N == 0 { self.n } else { N };
        let a = &self.tile.a[..n * n];
        let (mut fit, mut symmetric) = (lanes_of::<X>(members), X::Mask::ALL);
        for i in 0..n {
            fit = fit.and(X::splat(0.0).lt(a[i * n + i]));
            for j in 0..i {
                symmetric = symmetric.and(a[i * n + j].eq(a[j * n + i]));
            }
        }
        (fit, symmetric)
    }

    /// Lemke's method for each problem that waits; the general solver for what that leaves.
    #[inline(always)]
    fn one_by_one(&mut self, task: &Task<'_>, output: &mut Output<'_>) -> Result<()> {
        let (n, settings) = (self.n, task.settings);
        let mut general = driver::Settings {
            method: settings.method.clone(),
            tol: settings.tol,
            z0: None,
            ..driver::Settings::default()
        };
        let by_tableau = matches!(settings.method, driver::Method::Auto) && n <= TABLEAU_ORDER && n > 0;
        let control = Control { interrupted: settings.interrupted, ..Control::default() };
        for &k in &self.waiting {
            let place = task.first + k;
            let (a, q) = task.problems.get(place);
            self.a.copy_from_slice(a);
            self.q.copy_from_slice(q);
            let range = k * n..(k + 1) * n;
            let guessed = !matches!(settings.guess, Guess::None);
            if guessed && (n > GUESS_ORDER || !by_tableau) {
                let z0 = (0..n).map(|i| f64::from(u8::from(settings.guess.contains(n, place, i, false)))).collect();
                general.z0 = Some(z0);
            } else if by_tableau {
                let judged = self.tableau.solve_and_verify(n, &self.a, &self.q, &mut self.w, settings.tol);
                if let Some(judged) = judged {
                    for i in 0..n {
                        output.z[k * n + i] = self.tableau.z(i);
                    }
                    output.w[range].copy_from_slice(&self.w);
                    output.status[k] = Status::Solved as u8;
                    output.method[k] = LEMKE;
                    output.iterations[k] = self.tableau.pivots as u32;
                    output.residual[k] = judged.residual;
                    output.natural_residual[k] = judged.natural_residual;
                    output.alpha.write(n, k, |i| self.tableau.is_basic(i));
                    continue;
                }
            }
            let lcp = Lcp::new(n, self.a.clone(), self.q.clone()).map_err(|error| in_batch(error, place))?;
            let solution = match self.tableau_point(by_tableau && !guessed, &lcp, settings.tol) {
                Some(solution) => solution,
                None => driver::solve(&lcp, &general, &control).map_err(|error| in_batch(error, place))?,
            };
            output.z[range.clone()].copy_from_slice(&solution.z);
            output.w[range].copy_from_slice(&solution.w);
            output.status[k] = solution.status as u8;
            output.method[k] = method_code(solution.method);
            output.iterations[k] = u32::try_from(solution.iterations).unwrap_or(u32::MAX);
            output.residual[k] = solution.residual;
            output.natural_residual[k] = solution.natural_residual;
            output.alpha.write(n, k, |i| solution.alpha.contains(&i));
        }
        Ok(())
    }
}

impl<X: Lane<Number = f64>> Worker<X> {
    /// A basis that the tableau found and could not verify row by row, judged on the equilibrated problem.
    fn tableau_point(&self, tried: bool, lcp: &Lcp, tol: f64) -> Option<Solution> {
        if !tried || !self.tableau.found_basis {
            return None;
        }
        let problem = Equilibrated::new(lcp);
        let z: Vec<f64> = (0..self.n).map(|j| self.tableau.z(j)).collect();
        let alpha = (0..self.n).filter(|&j| self.tableau.is_basic(j)).collect();
        let point =
            Candidate::point(problem.scaling.z_from_caller(&z), Termination::ComplementaryBasis, self.tableau.pivots);
        let solution = certify(&problem, Candidate { alpha: Some(alpha), ..point }, METHODS[usize::from(LEMKE)], tol);
        (solution.status == Status::Solved).then_some(solution)
    }
}

/// What lanes do together.
#[derive(Clone, Copy)]
enum Phase {
    Guess,
    Newton,
    Lemke,
}

/// The first `members` lanes.
#[inline(always)]
fn lanes_of<X: Lane>(members: usize) -> X::Mask {
    let mut lanes = X::Mask::NONE;
    for l in 0..members {
        lanes.set(l, true);
    }
    lanes
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
