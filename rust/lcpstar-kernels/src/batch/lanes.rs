//! Several problems side by side, one number of each in a register: loads them, tries one method after the other,
//! verifies, writes what is solved.

mod phase;
mod transport;
mod transpose;

use super::io::{Guess, Output};
use super::lemke_lanes::Pivots;
use super::minors::enumerate;
use super::newton::{Tile, improve_guess, multiply, newton, refine, solve_guess};
use super::task::{ENUMERATE, LEMKE, NEWTON, Task};
use crate::cutovers::{LEMKE_ORDER, MINORS_ORDER, NEWTON_ORDER};
use crate::small::lane::{BLOCK, Lane, MOST_LANES, Mask};
use crate::small::lemke::PIVOTS_PER_ROW;
use crate::small::scales::Scales;
use crate::small::verify::{Verdict, verify};
use phase::{PHASES, Phase};
use transpose::transpose;

/// Refinement steps at most.
const REFINEMENTS: usize = 2;

/// Memory of one thread.
pub(super) struct Lanes<X: Lane> {
    n: usize,
    tile: Tile<X>,
    pivots: Pivots<X>,
    scales: Scales<X>,
    /// Which block of A each lane of the tile holds.
    loaded: [usize; MOST_LANES],
    /// z or w of a tile, problem after problem, and room for one block more.
    rows: Vec<f64>,
    /// The support that Newton's method tries next, for each problem of the chunk.
    guesses: Vec<u64>,
    /// Problems that wait for another iteration of the phase.
    again: Vec<usize>,
    /// Problems that it leaves.
    left: Vec<usize>,
    /// Whether a problem came along that is not for Newton's method.
    seen_unfit: bool,
}

/// A tile of problems and what is known of them.
struct Group<'a, X: Lane> {
    task: &'a Task<'a>,
    members: &'a [usize],
    /// Of the phase, from 1 on.
    iteration: usize,
    open: X::Mask,
    /// Lanes with a positive diagonal, for which Newton's method is worth trying.
    fit: X::Mask,
    symmetric: X::Mask,
}

/// What a method found: points are in the tile.
struct Found<X: Lane> {
    method: u8,
    /// Lanes in which it stopped as it should.
    lanes: X::Mask,
    /// Lanes for which another iteration is worth trying.
    unsettled: X::Mask,
    iterations: [u8; MOST_LANES],
}

impl<X: Lane> Lanes<X> {
    /// Memory for problems of order `n`.
    #[inline(always)]
    pub fn new(n: usize) -> Self {
        let mut scales = Scales::default();
        scales.resize(n);
        Self {
            n,
            tile: Tile::new(n),
            pivots: Pivots::new(if n <= LEMKE_ORDER { n } else { 0 }),
            scales,
            loaded: [usize::MAX; MOST_LANES],
            rows: vec![0.0; X::LANES * n + BLOCK],
            guesses: Vec::new(),
            again: Vec::new(),
            left: Vec::new(),
            seen_unfit: false,
        }
    }

    /// Solves what it can of the problems in `waiting` and leaves the others there.
    #[inline(always)]
    pub fn solve<const N: usize>(&mut self, task: &Task<'_>, waiting: &mut Vec<usize>, output: &mut Output<'_>) {
        self.guesses.resize(output.status.len(), 0);
        // One loop, one copy of the machine code below.
        for phase in PHASES {
            if !self.wants(phase, task) {
                continue;
            }
            let mut iteration = 0;
            while iteration < phase.iterations() && !waiting.is_empty() {
                iteration += 1;
                self.iterate::<N>(phase, iteration, task, waiting, output);
                std::mem::swap(waiting, &mut self.again);
            }
            waiting.append(&mut self.left);
            waiting.sort_unstable();
        }
    }

    fn wants(&self, phase: Phase, task: &Task<'_>) -> bool {
        let (n, asked) = (self.n, task.asked);
        match phase {
            Phase::Guess => !matches!(asked.guess, Guess::None),
            Phase::Point => matches!(asked.guess, Guess::Points(_)),
            Phase::Enumerate => n <= MINORS_ORDER,
            Phase::Newton => n > MINORS_ORDER && n <= NEWTON_ORDER,
            Phase::Lemke => n <= LEMKE_ORDER,
        }
    }

    /// One iteration for the problems that wait, `X::LANES` at a time.
    #[inline(always)]
    fn iterate<const N: usize>(
        &mut self,
        phase: Phase,
        iteration: usize,
        task: &Task<'_>,
        waiting: &mut Vec<usize>,
        output: &mut Output<'_>,
    ) {
        self.again.clear();
        if phase.is_newton() {
            self.set_aside_unfit(task, waiting);
        }
        let mut groups = waiting.chunks(X::LANES).peekable();
        while let Some(members) = groups.next() {
            self.load::<N>(task, members);
            self.plan_prefetch(phase, task, groups.peek().copied().unwrap_or_default());
            let (fit, symmetric) = self.shape::<N>();
            self.seen_unfit |= fit.not().any();
            let open = X::Mask::from_bits(u32::MAX >> (32 - members.len()));
            let mut group = Group { task, members, iteration, open, fit, symmetric };
            let mut again = X::Mask::NONE;
            // Symmetric lanes and the others take turns where the factorisation differs.
            for symmetric in [true, false] {
                let lanes = self.lanes(phase, &group, symmetric);
                if lanes.any() {
                    let found = self.run::<N>(phase, &group, lanes, symmetric);
                    again = again.or(found.unsettled);
                    self.settle::<N>(phase, &mut group, &found, output);
                }
            }
            let (open, again) = (group.open.bits(), again.bits());
            for (l, &k) in members.iter().enumerate().filter(|(l, _)| open >> l & 1 == 1) {
                let list = if again >> l & 1 == 1 { &mut self.again } else { &mut self.left };
                list.push(k);
            }
        }
        if iteration == phase.iterations() {
            self.left.append(&mut self.again);
        }
    }

    /// Newton's method wants a positive diagonal: where there are others, they are not even loaded for it.
    #[inline(always)]
    fn set_aside_unfit(&mut self, task: &Task<'_>, waiting: &mut Vec<usize>) {
        let problems = task.problems;
        self.seen_unfit |= waiting.first().is_some_and(|k| !problems.has_positive_diagonal(task.first + k));
        if self.seen_unfit {
            let left = &mut self.left;
            waiting.retain(|&k| {
                let fit = problems.has_positive_diagonal(task.first + k);
                if !fit {
                    left.push(k);
                }
                fit
            });
        }
    }

    /// The lanes whose turn it is.
    #[inline(always)]
    fn lanes(&self, phase: Phase, group: &Group<'_, X>, symmetric: bool) -> X::Mask {
        let kind = if symmetric { group.symmetric } else { group.symmetric.not() };
        match phase {
            Phase::Guess => group.open.and(kind),
            Phase::Newton => group.open.and(kind).and(group.fit),
            Phase::Point | Phase::Enumerate | Phase::Lemke if symmetric => group.open,
            Phase::Point | Phase::Enumerate | Phase::Lemke => X::Mask::NONE,
        }
    }

    /// Puts a point of every lane of `lanes` into the tile.
    #[inline(always)]
    fn run<const N: usize>(&mut self, phase: Phase, group: &Group<'_, X>, lanes: X::Mask, symmetric: bool) -> Found<X> {
        let n = self.n;
        let found = |method, lanes, iterations| Found { method, lanes, unsettled: X::Mask::NONE, iterations };
        match phase {
            Phase::Guess => {
                self.place_guess(group);
                solve_guess::<X, N>(n, &mut self.tile, symmetric);
                found(NEWTON, lanes, [1; MOST_LANES])
            }
            Phase::Point => {
                self.place_guess(group);
                multiply::<X, N>(n, &mut self.tile);
                found(NEWTON, lanes, [1; MOST_LANES])
            }
            Phase::Newton => {
                let mut masks = [0; MOST_LANES];
                for (mask, &k) in masks.iter_mut().zip(group.members) {
                    *mask = self.guesses[k];
                }
                // Sweeps, unless an iteration or the caller's guess has led further.
                let is_first = group.iteration == 1 && matches!(group.task.asked.guess, Guess::None);
                let masks = if is_first { None } else { Some(&masks[..]) };
                let step = newton::<X, N>(n, &mut self.tile, masks, symmetric);
                let unsettled = step.unsettled.and(lanes);
                self.keep_guesses(group, unsettled);
                let iterations = [group.iteration as u8; MOST_LANES];
                Found { unsettled, ..found(NEWTON, lanes.and(step.settled), iterations) }
            }
            Phase::Enumerate => {
                let (lanes, iterations) = enumerate(n, &mut self.tile);
                multiply::<X, N>(n, &mut self.tile);
                found(ENUMERATE, lanes, iterations)
            }
            Phase::Lemke => {
                let mut iterations = [1; MOST_LANES];
                let lanes = self.pivots.solve::<N>(n, &mut self.tile, lanes, PIVOTS_PER_ROW * n, &mut iterations);
                found(LEMKE, lanes, iterations)
            }
        }
    }

    /// Keeps the guesses of these lanes for their next iteration.
    #[inline(always)]
    fn keep_guesses(&mut self, group: &Group<'_, X>, lanes: X::Mask) {
        if !lanes.any() {
            return;
        }
        let (masks, lanes) = (self.tile.masks(self.n), lanes.bits());
        for (l, &k) in group.members.iter().enumerate().filter(|(l, _)| lanes >> l & 1 == 1) {
            self.guesses[k] = masks[l];
        }
    }

    /// The guess of the caller.
    #[inline(always)]
    fn place_guess(&mut self, group: &Group<'_, X>) {
        let (n, task) = (self.n, group.task);
        let mut places = [0; MOST_LANES];
        for l in 0..X::LANES {
            places[l] = task.first + group.members[l.min(group.members.len() - 1)];
        }
        match task.asked.guess {
            Guess::None => {}
            Guess::Masks(masks) => {
                self.tile.guess(n, &places.map(|k| masks[k]));
            }
            Guess::Flags(flags) => {
                for i in 0..n {
                    let mut bits = 0;
                    for (l, k) in places[..X::LANES].iter().enumerate() {
                        bits |= u32::from(flags[k * n + i]) << l;
                    }
                    self.tile.alpha[i] = X::Mask::from_bits(bits);
                }
            }
            Guess::Points(z) => {
                transpose(z, n, &places, &mut self.tile.z);
                for i in 0..n {
                    self.tile.alpha[i] = X::splat(0.0).lt(self.tile.z[i]);
                }
            }
        }
    }

    /// Verifies what was found, refined where need be, and writes what is solved.
    #[inline(always)]
    fn settle<const N: usize>(
        &mut self,
        phase: Phase,
        group: &mut Group<'_, X>,
        found: &Found<X>,
        output: &mut Output<'_>,
    ) {
        self.tile.prefetch.rest();
        let lanes = group.open.and(found.lanes);
        let refinements = match phase {
            Phase::Point | Phase::Enumerate => 0,
            _ => REFINEMENTS,
        };
        let mut refined = 0;
        let verdict = loop {
            let verdict = self.verdict::<N>(group.task.asked.tol, lanes);
            let wanting = lanes.and(verdict.solved().not());
            if refined == refinements || !wanting.any() {
                break verdict;
            }
            refined += 1;
            if phase == Phase::Lemke {
                self.pivots.refine::<N>(self.n, &mut self.tile, wanting);
            } else {
                refine::<X, N>(self.n, &mut self.tile, wanting);
            }
        };
        let unsolved = lanes.and(verdict.solved().not());
        if phase == Phase::Guess && unsolved.any() {
            improve_guess::<X, N>(self.n, &mut self.tile);
            self.keep_guesses(group, unsolved);
        }
        if phase != Phase::Lemke {
            for (alpha, z) in self.tile.alpha.iter_mut().zip(&self.tile.z) {
                *alpha = X::splat(0.0).lt(*z);
            }
        }
        self.write::<N>(group, found, &verdict, output);
    }

    #[inline(always)]
    fn verdict<const N: usize>(&mut self, tol: f64, asked: X::Mask) -> Verdict<X> {
        let tile = &self.tile;
        verify::<X, N>(self.n, &tile.a, &tile.q, &tile.z, &tile.w, tol, &mut self.scales, asked)
    }

    /// Lanes with a positive diagonal and lanes with a symmetric matrix.
    #[inline(always)]
    fn shape<const N: usize>(&self) -> (X::Mask, X::Mask) {
        let n = if N == 0 { self.n } else { N };
        let a = &self.tile.a[..n * n];
        let (mut fit, mut symmetric) = (X::Mask::ALL, X::Mask::ALL);
        for i in 0..n {
            fit = fit.and(X::splat(0.0).lt(a[i * n + i]));
            for j in 0..i {
                symmetric = symmetric.and(a[i * n + j].eq(a[j * n + i]));
            }
        }
        (fit, symmetric)
    }
}
