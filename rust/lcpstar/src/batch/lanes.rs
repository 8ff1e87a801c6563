//! Several problems side by side, one number of each in a register: loads them, tries one method after the other,
//! verifies, writes what is solved.

use super::io::{Guess, Numbers, Output, Problems};
use super::lemke_lanes::Pivots;
use super::minors::{MINORS_ORDER, enumerate};
use super::newton::{Tile, multiply, newton, refine};
use super::work::{ENUMERATE, LEMKE, NEWTON, Task};
use crate::small::lane::{BLOCK, Lane, Mask};
use crate::small::lemke::PIVOTS_PER_ROW;
use crate::small::verify::{Verdict, is_small_when_equilibrated, verify};
use crate::status::Status;

/// Most lanes of any kind.
pub(super) const MOST_LANES: usize = 16;

/// Largest order for which Lemke's method runs in lanes: above, the tableaux no longer fit the nearest cache.
const LEMKE_ORDER: usize = 24;

/// Largest order for which Newton's method, without a guess, is tried: above, it costs what Lemke's method does, and all of that
/// again where A is singular.
const NEWTON_ORDER: usize = 16;

/// Factorisations after which a lane goes on to Lemke's method.
const FACTORISATIONS: usize = 6;

/// Refinement steps at most.
const REFINEMENTS: usize = 2;

/// Memory of one thread.
pub(super) struct Lanes<X: Lane, S: Lane> {
    n: usize,
    tile: Tile<X>,
    pivots: Pivots<X>,
    /// Which block of A each lane of the tile holds.
    loaded: [usize; MOST_LANES],
    /// Problems widened to double precision.
    wide: Vec<f64>,
    singles: Option<Tile<S>>,
    /// z or w of a tile, problem after problem, and room for one block more.
    rows: Vec<f64>,
    /// What single precision found, `n` numbers for each problem of the chunk.
    points: Vec<f32>,
    failed: Vec<usize>,
    /// Whether a problem came along that is not for Newton's method.
    seen_unfit: bool,
}

/// In this order.
const PHASES: [Phase; 7] =
    [Phase::Guess, Phase::Point, Phase::Polish, Phase::Single, Phase::Enumerate, Phase::Newton, Phase::Lemke];

/// What lanes do together.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// One factorisation for the support that the caller guesses.
    Guess,
    /// The point that the caller guesses, as it is.
    Point,
    /// One factorisation for the support that single precision found.
    Polish,
    /// The point that single precision found, as it is.
    Single,
    Enumerate,
    Newton,
    Lemke,
}

/// A tile of problems and what is known of them.
struct Group<'a, X: Lane> {
    task: &'a Task<'a>,
    members: &'a [usize],
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
    iterations: [u8; MOST_LANES],
}

impl<X: Lane<Number = f64>, S: Lane<Number = f32>> Lanes<X, S> {
    /// Memory for problems of order `n`.
    #[inline(always)]
    pub fn new(n: usize, problems: &Problems<'_>) -> Self {
        let single = matches!(problems.a, Numbers::Single(_)) || matches!(problems.q, Numbers::Single(_));
        let wide = if single { X::LANES * n * (n + 1) } else { 0 };
        let both = matches!((problems.a, problems.q), (Numbers::Single(_), Numbers::Single(_)));
        Self {
            n,
            tile: Tile::new(n),
            pivots: Pivots::new(if n <= LEMKE_ORDER { n } else { 0 }),
            loaded: [usize::MAX; MOST_LANES],
            wide: vec![0.0; wide],
            singles: both.then(|| Tile::new(n)),
            rows: vec![0.0; X::LANES * n + BLOCK],
            points: Vec::new(),
            failed: Vec::new(),
            seen_unfit: false,
        }
    }

    /// Solves what it can of the problems in `waiting` and leaves the others there.
    #[inline(always)]
    pub fn solve<const N: usize>(&mut self, task: &Task<'_>, waiting: &mut Vec<usize>, output: &mut Output<'_>) {
        if self.singles.is_some() {
            self.in_single_precision::<N>(task, waiting, output.status.len());
        }
        // One loop, one copy of the machine code below.
        for phase in PHASES {
            if self.wants(phase, task) && !waiting.is_empty() {
                self.phase::<N>(phase, task, waiting, output);
            }
        }
    }

    fn wants(&self, phase: Phase, task: &Task<'_>) -> bool {
        let (n, guess, polish) = (self.n, task.settings.guess, task.settings.polish);
        match phase {
            Phase::Guess => !matches!(guess, Guess::None),
            Phase::Point => matches!(guess, Guess::Points(_)),
            Phase::Polish => self.singles.is_some() && polish,
            Phase::Single => self.singles.is_some() && !polish,
            Phase::Enumerate => n <= MINORS_ORDER,
            Phase::Newton => n > MINORS_ORDER && n <= NEWTON_ORDER,
            Phase::Lemke => n <= LEMKE_ORDER,
        }
    }

    /// Tries one method on the problems that wait, `X::LANES` at a time; those it does not solve wait on.
    #[inline(always)]
    fn phase<const N: usize>(
        &mut self,
        phase: Phase,
        task: &Task<'_>,
        waiting: &mut Vec<usize>,
        output: &mut Output<'_>,
    ) {
        self.failed.clear();
        if phase == Phase::Newton && self.seen_unfit {
            self.set_aside_unfit(task, waiting);
        }
        let mut groups = waiting.chunks(X::LANES).peekable();
        while let Some(members) = groups.next() {
            self.load::<N>(task, members);
            self.plan_ahead(phase, task, groups.peek().copied().unwrap_or_default());
            let (fit, symmetric) = self.shape::<N>();
            self.seen_unfit |= fit.not().any();
            let open = X::Mask::from_bits(u32::MAX >> (32 - members.len()));
            let mut group = Group { task, members, open, fit, symmetric };
            // Symmetric lanes and the others take turns where the factorisation differs.
            for symmetric in [true, false] {
                let lanes = self.lanes(phase, &group, symmetric);
                if lanes.any() {
                    let found = self.run::<N>(phase, &group, lanes, symmetric);
                    self.settle::<N>(phase, &mut group, &found, output);
                }
            }
            let open = group.open.bits();
            if open == 0 {
                continue;
            }
            self.failed.extend(members.iter().enumerate().filter(|&(l, _)| open >> l & 1 == 1).map(|(_, &k)| k));
        }
        std::mem::swap(waiting, &mut self.failed);
    }

    /// Newton's method wants a positive diagonal: where there are others, they are not even loaded for it.
    #[inline(always)]
    fn set_aside_unfit(&mut self, task: &Task<'_>, waiting: &mut Vec<usize>) {
        let (n, problems) = (self.n, task.problems);
        waiting.retain(|&k| {
            let block = problems.a_source.block(task.first + k) * n * n;
            let fit = match problems.a {
                Numbers::Double(a) => a[block..block + n * n].iter().step_by(n + 1).all(|&x| x > 0.0),
                Numbers::Single(a) => a[block..block + n * n].iter().step_by(n + 1).all(|&x| x > 0.0),
            };
            if !fit {
                self.failed.push(k);
            }
            fit
        });
    }

    /// The lanes whose turn it is.
    #[inline(always)]
    fn lanes(&self, phase: Phase, group: &Group<'_, X>, symmetric: bool) -> X::Mask {
        let kind = if symmetric { group.symmetric } else { group.symmetric.not() };
        match phase {
            Phase::Guess | Phase::Polish => group.open.and(kind),
            Phase::Newton => group.open.and(kind).and(group.fit),
            Phase::Point | Phase::Single | Phase::Enumerate | Phase::Lemke if symmetric => group.open,
            Phase::Point | Phase::Single | Phase::Enumerate | Phase::Lemke => X::Mask::NONE,
        }
    }

    /// Puts a point of every lane of `lanes` into the tile.
    #[inline(always)]
    fn run<const N: usize>(&mut self, phase: Phase, group: &Group<'_, X>, lanes: X::Mask, symmetric: bool) -> Found<X> {
        let (n, zero) = (self.n, X::splat(0.0));
        let mut iterations = [1; MOST_LANES];
        match phase {
            Phase::Guess | Phase::Point => self.place_guess(group),
            Phase::Polish | Phase::Single => self.place_single(group),
            _ => {
                for i in 0..n {
                    self.tile.alpha[i] = self.tile.q[i].lt(zero);
                }
            }
        }
        match phase {
            Phase::Guess | Phase::Polish | Phase::Newton => {
                let limit = if phase == Phase::Newton { FACTORISATIONS } else { 1 };
                let (iterations, lanes) = newton::<X, N>(n, &mut self.tile, lanes, symmetric, limit);
                if limit == 1 {
                    // Degenerate rows may come out a rounding error below zero: what counts is what is verified.
                    for z in &mut self.tile.z {
                        *z = z.max(zero);
                    }
                    multiply::<X, N>(n, &mut self.tile);
                }
                Found { method: NEWTON, lanes, iterations }
            }
            Phase::Point | Phase::Single => {
                multiply::<X, N>(n, &mut self.tile);
                Found { method: NEWTON, lanes, iterations }
            }
            Phase::Enumerate => {
                let (lanes, iterations) = enumerate(n, &mut self.tile);
                multiply::<X, N>(n, &mut self.tile);
                Found { method: ENUMERATE, lanes, iterations }
            }
            Phase::Lemke => {
                let limit = PIVOTS_PER_ROW * n;
                let lanes = self.pivots.solve::<N>(n, &mut self.tile, lanes, limit, &mut iterations);
                Found { method: LEMKE, lanes, iterations }
            }
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
        match task.settings.guess {
            Guess::None => {}
            Guess::Masks(masks) => {
                let guesses = places.map(|k| masks[k]);
                for i in 0..n {
                    let mut bits = 0;
                    for (l, guess) in guesses[..X::LANES].iter().enumerate() {
                        bits |= (guess >> i & 1) << l;
                    }
                    self.tile.alpha[i] = X::Mask::from_bits(bits as u32);
                }
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
                columns::<X>(Numbers::Double(z), n, &places, &mut [], &mut self.tile.z);
                for i in 0..n {
                    self.tile.alpha[i] = X::splat(0.0).lt(self.tile.z[i]);
                }
            }
        }
    }

    /// What single precision found.
    #[inline(always)]
    fn place_single(&mut self, group: &Group<'_, X>) {
        let n = self.n;
        for l in 0..X::LANES {
            let k = group.members[l.min(group.members.len() - 1)];
            for i in 0..n {
                let z = self.points[k * n + i];
                self.tile.alpha[i].set(l, z > 0.0);
                self.tile.z[i].set(l, f64::from(z).max(0.0));
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
        self.tile.ahead.rest();
        let lanes = group.open.and(found.lanes);
        let refinements = match phase {
            Phase::Point | Phase::Single | Phase::Enumerate => 0,
            _ => REFINEMENTS,
        };
        let mut refined = 0;
        let verdict = loop {
            let verdict = self.verdict::<N>(group.task.settings.tol);
            let wanting = lanes.and(verdict.solved.not());
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
        if phase != Phase::Lemke {
            for (alpha, z) in self.tile.alpha.iter_mut().zip(&self.tile.z) {
                *alpha = X::splat(0.0).lt(*z);
            }
        }
        self.write::<N>(group, found, &verdict, output);
    }

    #[inline(always)]
    fn verdict<const N: usize>(&self, tol: f64) -> Verdict<X> {
        let tile = &self.tile;
        let mut verdict = verify::<X, N>(self.n, &tile.a, &tile.q, &tile.z, &tile.w, tol);
        if verdict.unsettled.any() {
            self.equilibrate(&mut verdict, tol);
        }
        verdict
    }

    /// Decides the lanes that need the scaling of their problem, one by one.
    fn equilibrate(&self, verdict: &mut Verdict<X>, tol: f64) {
        let (n, tile) = (self.n, &self.tile);
        let lane = |v: &[X], l: usize| -> Vec<f64> { v.iter().map(|x| x.get(l)).collect() };
        for l in (0..X::LANES).filter(|&l| verdict.unsettled.get(l)) {
            let (a, q) = (lane(&tile.a[..n * n], l), lane(&tile.q[..n], l));
            let (z, w) = (lane(&tile.z[..n], l), lane(&tile.w[..n], l));
            verdict.solved.set(l, is_small_when_equilibrated(n, &a, &q, &z, &w, tol));
        }
    }

    /// Writes the results of the lanes that are verified, with the supports in alpha.
    #[inline(always)]
    fn write<const N: usize>(
        &mut self,
        group: &mut Group<'_, X>,
        found: &Found<X>,
        verdict: &Verdict<X>,
        output: &mut Output<'_>,
    ) {
        let n = if N == 0 { self.n } else { N };
        let solved = group.open.and(found.lanes).and(verdict.solved);
        group.open = group.open.and(solved.not());
        let solved = solved.bits();
        if solved == 0 {
            return;
        }
        for (source, out) in [(&self.tile.z, &mut *output.z), (&self.tile.w, &mut *output.w)] {
            // Backwards: a last block that is not whole reaches into the next row.
            for (b, columns) in source[..n].chunks(BLOCK).enumerate().rev() {
                X::store_columns(columns, &mut self.rows[BLOCK * b..], n);
            }
            for (l, k, count) in runs(group.members, solved) {
                out[k * n..(k + count) * n].copy_from_slice(&self.rows[l * n..(l + count) * n]);
            }
        }
        let (mut masks, mut iterations) = ([0_u64; MOST_LANES], [0; MOST_LANES]);
        let (mut residual, mut natural_residual) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
        for (i, alpha) in self.tile.alpha[..n].iter().enumerate() {
            let bits = alpha.bits();
            for (l, mask) in masks[..X::LANES].iter_mut().enumerate() {
                *mask |= u64::from(bits >> l & 1) << i;
            }
        }
        for l in 0..X::LANES {
            iterations[l] = u32::from(found.iterations[l]);
            residual[l] = verdict.residual.get(l);
            natural_residual[l] = verdict.natural_residual.get(l);
        }
        for (l, k, count) in runs(group.members, solved) {
            let (from, to) = (l..l + count, k..k + count);
            output.status[to.clone()].fill(Status::Solved as u8);
            output.method[to.clone()].fill(found.method);
            output.iterations[to.clone()].copy_from_slice(&iterations[from.clone()]);
            output.residual[to.clone()].copy_from_slice(&residual[from.clone()]);
            output.natural_residual[to].copy_from_slice(&natural_residual[from.clone()]);
            output.alpha.write_masks(n, k, &masks[from]);
        }
    }

    /// Copies problems into the lanes; spare lanes repeat the last one. Blocks of A that the lanes hold already stay.
    #[inline(always)]
    fn load<const N: usize>(&mut self, task: &Task<'_>, members: &[usize]) {
        let n = if N == 0 { self.n } else { N };
        let problems = task.problems;
        let (mut a_blocks, mut q_blocks) = ([0; MOST_LANES], [0; MOST_LANES]);
        for l in 0..X::LANES {
            let place = task.first + members[l.min(members.len() - 1)];
            (a_blocks[l], q_blocks[l]) = (problems.a_source.block(place), problems.q_source.block(place));
        }
        let split = (X::LANES * n * n).min(self.wide.len());
        let (wide_a, wide_q) = self.wide.split_at_mut(split);
        if a_blocks[..X::LANES] != self.loaded[..X::LANES] {
            columns::<X>(problems.a, n * n, &a_blocks, wide_a, &mut self.tile.a);
            self.loaded = a_blocks;
        }
        columns::<X>(problems.q, n, &q_blocks, wide_q, &mut self.tile.q);
    }

    /// Plans to ask for the matrices of the problems that are next.
    #[inline(always)]
    fn plan_ahead(&mut self, phase: Phase, task: &Task<'_>, members: &[usize]) {
        let (n, problems, ahead) = (self.n, task.problems, &mut self.tile.ahead);
        // Most problems take two factorisations of n columns, each of which is a step.
        let steps = if phase == Phase::Newton { 2 * n } else { n };
        ahead.clear();
        // Smaller ones come in order, and the processor sees that by itself.
        let members = if n > MINORS_ORDER { members } else { &[] };
        for &k in members {
            let block = problems.a_source.block(task.first + k);
            if block == self.loaded[0] {
                return;
            }
            match problems.a {
                Numbers::Double(a) => ahead.plan(&a[block * n * n..(block + 1) * n * n], steps),
                Numbers::Single(a) => ahead.plan(&a[block * n * n..(block + 1) * n * n], steps),
            }
        }
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

    /// Newton's method on the problems that wait in single precision, sixteen at a time; nothing is verified here.
    #[inline(always)]
    fn in_single_precision<const N: usize>(&mut self, task: &Task<'_>, waiting: &[usize], chunk: usize) {
        let (n, problems) = (self.n, task.problems);
        let (Some(tile), Numbers::Single(a), Numbers::Single(q)) = (&mut self.singles, problems.a, problems.q) else {
            return;
        };
        self.points.resize(chunk * n, 0.0);
        let zero = S::splat(0.0);
        for members in waiting.chunks(S::LANES) {
            let (mut sources, mut vectors): ([&[f32]; MOST_LANES], [&[f32]; MOST_LANES]) = Default::default();
            for l in 0..S::LANES {
                let place = task.first + members[l.min(members.len() - 1)];
                let (a_block, q_block) = (problems.a_source.block(place), problems.q_source.block(place));
                sources[l] = &a[a_block * n * n..(a_block + 1) * n * n];
                vectors[l] = &q[q_block * n..(q_block + 1) * n];
            }
            transpose::<S>(n * n, &sources, &mut tile.a);
            transpose::<S>(n, &vectors, &mut tile.q);
            for i in 0..n {
                tile.alpha[i] = tile.q[i].lt(zero);
            }
            // Without the lanes that were given up: what they hold is not theirs alone.
            let (_, lanes) = newton::<S, N>(n, tile, S::Mask::ALL, false, FACTORISATIONS);
            for z in &mut tile.z {
                *z = z.only(lanes);
            }
            let mut rows = [0.0; BLOCK * MOST_LANES];
            for (b, columns) in tile.z[..n].chunks(BLOCK).enumerate() {
                S::store_columns(columns, &mut rows, BLOCK);
                for (row, &k) in rows.chunks_exact(BLOCK).zip(members) {
                    let place = k * n + BLOCK * b;
                    self.points[place..place + columns.len()].copy_from_slice(&row[..columns.len()]);
                }
            }
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

/// Number e of block `blocks[l]` goes to lane l of `out[e]`, for `length` numbers e.
#[inline(always)]
fn columns<X: Lane<Number = f64>>(
    numbers: Numbers<'_>,
    length: usize,
    blocks: &[usize; MOST_LANES],
    wide: &mut [f64],
    out: &mut [X],
) {
    let mut sources: [&[f64]; MOST_LANES] = [&[]; MOST_LANES];
    match numbers {
        Numbers::Double(x) => {
            for l in 0..X::LANES {
                sources[l] = &x[blocks[l] * length..(blocks[l] + 1) * length];
            }
        }
        Numbers::Single(_) => {
            for l in 0..X::LANES {
                numbers.copy(blocks[l] * length, &mut wide[l * length..(l + 1) * length]);
            }
            for l in 0..X::LANES {
                sources[l] = &wide[l * length..(l + 1) * length];
            }
        }
    }
    transpose::<X>(length, &sources, out);
}

/// Number e of `sources[l]` goes to lane l of `out[e]`, for `length` numbers e.
#[inline(always)]
fn transpose<X: Lane>(length: usize, sources: &[&[X::Number]; MOST_LANES], out: &mut [X]) {
    for (b, out) in out[..length].chunks_mut(BLOCK).enumerate() {
        let mut rows = *sources;
        for row in &mut rows[..X::LANES] {
            *row = &row[BLOCK * b..];
        }
        X::load_columns(&rows[..X::LANES], out);
    }
}
