//! One worker: takes chunks of problems until none is left.

use super::io::{Output, Problems, Settings};
use super::lane::{F64x8, Lane, Mask};
use super::lemke::{Stop, Tableau};
use super::newton::{Tile, newton, refine};
use super::verify::{Judged, verify, verify_one};
use crate::control::Control;
use crate::driver;
use crate::error::{LcpError, Result};
use crate::problem::Lcp;
use crate::status::Status;
use multiversion::multiversion;

/// Largest order for which problems share registers; above, they take turns.
pub const LANE_ORDER: usize = 32;

/// Largest order for which the tableau is tried before the general solver.
pub const TABLEAU_ORDER: usize = 192;

/// Names of the methods in [`Output::method`](super::Output::method).
pub const METHODS: [&str; 7] =
    ["newton", "lemke", "auto", "trivial", "block_pivoting", "lemke_howson", "interior_point"];
const NEWTON: u8 = 0;
const LEMKE: u8 = 1;
const AUTO: u8 = 2;

/// The place of a name of the general solver in [`METHODS`].
fn method_code(name: &str) -> u8 {
    METHODS.iter().position(|&known| known == name).map_or(AUTO, |i| i as u8)
}

/// Factorisations after which a lane goes on to Lemke's method.
const FACTORISATIONS: usize = 8;

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
    if cfg!(target_arch = "aarch64") || multiversion::target::target_cfg_f!(target_feature = "fma") {
        run::<F64x8<true>>(problems, settings, next)
    } else {
        run::<F64x8<false>>(problems, settings, next)
    }
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
        worker.left_over.clear();
        if n <= LANE_ORDER {
            match n {
                2 => worker.lanes::<2>(problems, settings, &mut chunk),
                3 => worker.lanes::<3>(problems, settings, &mut chunk),
                4 => worker.lanes::<4>(problems, settings, &mut chunk),
                6 => worker.lanes::<6>(problems, settings, &mut chunk),
                8 => worker.lanes::<8>(problems, settings, &mut chunk),
                _ => worker.lanes::<0>(problems, settings, &mut chunk),
            }
        } else {
            worker.left_over.extend(0..chunk.output.status.len());
        }
        worker.one_by_one(problems, settings, &mut chunk)?;
    }
    Ok(())
}

/// Memory of one thread.
struct Worker<X: Lane> {
    n: usize,
    tile: Tile<X>,
    tableau: Tableau,
    z: Vec<f64>,
    w: Vec<f64>,
    a: Vec<f64>,
    q: Vec<f64>,
    /// Problems of the chunk that the lanes did not solve.
    left_over: Vec<usize>,
}

impl<X: Lane<Number = f64>> Worker<X> {
    #[inline(always)]
    fn new(n: usize) -> Self {
        Self {
            n,
            tile: Tile::new(if n <= LANE_ORDER { n } else { 0 }),
            tableau: Tableau::default(),
            z: vec![0.0; n],
            w: vec![0.0; n],
            a: vec![0.0; n * n],
            q: vec![0.0; n],
            left_over: Vec::new(),
        }
    }

    /// Newton's method, `X::LANES` problems at a time; what it does not solve is left over.
    #[inline(always)]
    fn lanes<const N: usize>(&mut self, problems: &Problems<'_, f64>, settings: &Settings<'_>, chunk: &mut Chunk<'_>) {
        let n = if N == 0 { self.n } else { N };
        let count = chunk.output.status.len();
        for start in (0..count).step_by(X::LANES) {
            let members = X::LANES.min(count - start);
            self.load::<N>(problems, chunk.first + start, members);
            let (fit, symmetric) = self.shape::<N>(members);
            let mut done = X::Mask::NONE;
            for kind in [true, false] {
                let lanes = if kind { fit.and(symmetric) } else { fit.and(symmetric.not()) };
                if !lanes.any() {
                    continue;
                }
                self.guess::<N>(settings, chunk.first + start, members);
                let outcome = newton::<X, N>(n, &mut self.tile, lanes, kind, FACTORISATIONS);
                if !outcome.settled.any() {
                    continue;
                }
                let tile = &self.tile;
                let mut verdict = verify::<X, N>(n, &tile.a, &tile.q, &tile.z, &tile.w, settings.tol);
                for _ in 0..REFINEMENTS {
                    let wanting = outcome.settled.and(verdict.solved.not());
                    if !wanting.any() {
                        break;
                    }
                    refine::<X, N>(n, &mut self.tile, wanting);
                    let tile = &self.tile;
                    verdict = verify::<X, N>(n, &tile.a, &tile.q, &tile.z, &tile.w, settings.tol);
                }
                let solved = outcome.settled.and(verdict.solved);
                done = done.or(solved);
                let output = &mut chunk.output;
                for l in (0..members).filter(|&l| solved.get(l)) {
                    let k = start + l;
                    for i in 0..n {
                        output.z[k * n + i] = self.tile.z[i].get(l);
                        output.w[k * n + i] = self.tile.w[i].get(l);
                    }
                    output.status[k] = Status::Solved as u8;
                    output.method[k] = NEWTON;
                    output.iterations[k] = u32::from(outcome.iterations[l]);
                    output.residual[k] = verdict.residual.get(l);
                    output.natural_residual[k] = verdict.natural_residual.get(l);
                    output.alpha.write(n, k, |i| self.tile.alpha[i].get(l));
                }
            }
            self.left_over.extend((0..members).filter(|&l| !done.get(l)).map(|l| start + l));
        }
    }

    /// Copies problems into the lanes; spare lanes repeat the last one.
    #[inline(always)]
    fn load<const N: usize>(&mut self, problems: &Problems<'_, f64>, first: usize, members: usize) {
        let n = if N == 0 { self.n } else { N };
        for l in 0..X::LANES {
            let (a, q) = problems.get(first + l.min(members - 1));
            for (lane, &x) in self.tile.a.iter_mut().zip(&a[..n * n]) {
                lane.set(l, x);
            }
            for (lane, &x) in self.tile.q.iter_mut().zip(&q[..n]) {
                lane.set(l, x);
            }
        }
    }

    /// Lanes with a positive diagonal, for which Newton's method is worth trying, and lanes with a symmetric matrix.
    #[inline(always)]
    fn shape<const N: usize>(&self, members: usize) -> (X::Mask, X::Mask) {
        let n = if N == 0 { self.n } else { N };
        let a = &self.tile.a[..n * n];
        let (mut fit, mut symmetric) = (X::Mask::NONE, X::Mask::ALL);
        for l in 0..members {
            fit.set(l, true);
        }
        for i in 0..n {
            fit = fit.and(X::splat(0.0).lt(a[i * n + i]));
            for j in 0..i {
                symmetric = symmetric.and(a[i * n + j].eq(a[j * n + i]));
            }
        }
        (fit, symmetric)
    }

    /// The first guess of the support.
    #[inline(always)]
    fn guess<const N: usize>(&mut self, settings: &Settings<'_>, first: usize, members: usize) {
        let n = if N == 0 { self.n } else { N };
        for i in 0..n {
            self.tile.alpha[i] = self.tile.q[i].lt(X::splat(0.0));
        }
        if !matches!(settings.guess, super::Guess::None) {
            for l in 0..X::LANES {
                let k = first + l.min(members - 1);
                for i in 0..n {
                    self.tile.alpha[i].set(l, settings.guess.contains(n, k, i, false));
                }
            }
        }
    }

    /// Lemke's method for each problem left over; the general solver for what that leaves.
    #[inline(always)]
    fn one_by_one(&mut self, problems: &Problems<'_, f64>, settings: &Settings<'_>, chunk: &mut Chunk<'_>) -> Result<()> {
        let n = self.n;
        let general = driver::Settings { tol: settings.tol, ..driver::Settings::default() };
        let control = Control { interrupted: settings.interrupted, ..Control::default() };
        for &k in &self.left_over {
            let (a, q) = problems.get(chunk.first + k);
            self.a.copy_from_slice(a);
            self.q.copy_from_slice(q);
            let output = &mut chunk.output;
            let range = k * n..(k + 1) * n;
            if n <= TABLEAU_ORDER {
                let judged = by_tableau(&mut self.tableau, n, &self.a, &self.q, &mut self.z, &mut self.w, settings.tol);
                if let Some(judged) = judged {
                    output.z[range.clone()].copy_from_slice(&self.z);
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
            let solution = Lcp::new(n, self.a.clone(), self.q.clone())
                .and_then(|lcp| driver::solve(&lcp, &general, &control))
                .map_err(|error| in_batch(error, chunk.first + k))?;
            output.z[range.clone()].copy_from_slice(&solution.z);
            output.w[range].copy_from_slice(&solution.w);
            output.status[k] = solution.status as u8;
            output.method[k] = method_code(solution.method);
            output.iterations[k] = u32::try_from(solution.iterations).unwrap_or(u32::MAX);
            output.residual[k] = solution.residual;
            output.natural_residual[k] = solution.natural_residual;
            output.alpha.write(n, k, |i| solution.alpha.binary_search(&i).is_ok());
        }
        Ok(())
    }
}

/// Lemke's method, the answer refined until it is verified.
#[inline(always)]
pub(super) fn by_tableau(
    tableau: &mut Tableau,
    n: usize,
    a: &[f64],
    q: &[f64],
    z: &mut [f64],
    w: &mut [f64],
    tol: f64,
) -> Option<Judged> {
    if tableau.solve(n, a, q, 10 * n + 20) != Stop::Basis {
        return None;
    }
    tableau.solution(z);
    let mut judged = verify_one(n, a, q, z, w, tol);
    for _ in 0..REFINEMENTS {
        if judged.solved {
            break;
        }
        tableau.refine(z, w);
        judged = verify_one(n, a, q, z, w, tol);
    }
    judged.solved.then_some(judged)
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
