//! The ways to ask: one problem with every method, dense or sparse, with right and wrong guesses, with a proof; and batches.

use fastrand::Rng;
use lcpstar::batch::{self, Alpha, Guess, Numbers, Output, Problems, Source};
use lcpstar::driver::{self, Certify, Method, SPARSE_METHODS};
use lcpstar::methods::enumerate;
use lcpstar::small::TINY_ORDER;
use lcpstar::{Control, Lcp, SparseLcp, Status};
use lcpstar_referee::{Answer, Problem};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Places of the ways that are no method by name.
pub const AUTO: usize = 0;
pub const WRONG_Z0: usize = 1;
pub const RIGHT_Z0: usize = 2;
pub const EXACT: usize = 3;
const BATCH: usize = 4;
const BATCH_WRONG: usize = 5;
const BATCH_RIGHT: usize = 6;
const BATCH_SINGLE: usize = 7;
const BATCH_ONE_A: usize = 8;
const SPARSE_EXACT: usize = 9;
const SPARSE: usize = 10;
const NAMED: usize = SPARSE + SPARSE_METHODS.len();

static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let first = [
        "auto",
        "auto, wrong z0",
        "auto, right z0",
        "auto, exact",
        "batch",
        "batch, wrong guess",
        "batch, right guess",
        "batch, float32",
        "batch, one A",
        "sparse, exact",
    ];
    let sparse = SPARSE_METHODS.iter().map(|name| format!("sparse, {name}"));
    let named = Method::NAMES.iter().filter(|name| **name != "auto").map(|name| (*name).to_owned());
    first.into_iter().map(str::to_owned).chain(sparse).chain(named).collect()
});

/// Names of all ways to ask.
pub fn ways() -> &'static [String] {
    &NAMES
}

pub fn is_batch(way: usize) -> bool {
    (BATCH..=BATCH_ONE_A).contains(&way)
}

/// The ways to ask about one problem alone: always `auto`; from a wrong guess every other time, from a right one every
/// fourth; two of the named methods in turn; the proofs of few. Where the sparse road makes no dense copy, its methods instead.
pub fn alone(n: usize, turn: usize) -> Vec<usize> {
    let named = NAMES.len() - NAMED;
    let sparse = |k: usize| SPARSE + k % SPARSE_METHODS.len();
    if n >= 1000 {
        return vec![AUTO, NAMED + turn % named, sparse(turn)];
    }
    let mut asked = vec![AUTO];
    if turn.is_multiple_of(2) {
        asked.push(WRONG_Z0);
    }
    if turn % 4 == 1 {
        asked.push(RIGHT_Z0);
    }
    if turn.is_multiple_of(8) && n <= 16 {
        asked.push(EXACT);
    }
    if n > TINY_ORDER {
        asked.extend([SPARSE, sparse(1 + turn % (SPARSE_METHODS.len() - 1)), sparse(turn / 3)]);
        if turn.is_multiple_of(8) {
            asked.push(SPARSE_EXACT);
        }
    } else {
        asked.extend([NAMED + turn % named, NAMED + (turn + 1 + turn / named) % named]);
        if turn % 16 == 3 {
            asked.push(sparse(turn / 16));
        }
    }
    asked.sort_unstable();
    asked.dedup();
    asked
}

/// How a call ended.
pub enum Outcome {
    Answer(Answer),
    Crashed(String),
    Hung(Duration),
    /// The method refuses problems of this size.
    NotForIt,
}

/// Processor time of this thread, where the system tells: a machine shared with others stops a thread for minutes.
fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(Duration::from_nanos(text.split_whitespace().next()?.parse().ok()?))
}

/// No call may take more processor time.
fn patience(n: usize) -> Duration {
    Duration::from_secs(if n >= 1000 { 240 } else { 30 })
}

/// Asks about one problem alone.
pub fn solve(problem: &Problem, way: usize, tol: f64, z0: Option<Vec<f64>>) -> Outcome {
    let n = problem.n;
    let is_sparse = (SPARSE_EXACT..NAMED).contains(&way);
    let name = match way {
        NAMED.. => NAMES[way].as_str(),
        SPARSE.. => SPARSE_METHODS[way - SPARSE],
        _ => "auto",
    };
    if name == "enumerate" && n > 12.min(enumerate::MAX_ORDER) {
        return Outcome::NotForIt;
    }
    let certify = if way == EXACT || way == SPARSE_EXACT { Certify::Exact } else { Certify::Float };
    let (begun, before) = (Instant::now(), processor_time());
    let spent = || match (before, processor_time()) {
        (Some(before), Some(now)) => now - before,
        _ => begun.elapsed(),
    };
    // Small problems must end by themselves.
    let deadline = (n > 16).then(|| begun + patience(n) / 4);
    let control = Control { deadline, ..Control::default() };
    let run = || {
        let lcp = Lcp::new(n, problem.a.clone(), problem.q.clone())?;
        let settings = driver::Settings { method: Method::from_name(name)?, tol, z0, certify };
        if is_sparse {
            return driver::solve_sparse(&SparseLcp::from_dense(&lcp), &settings, &control);
        }
        driver::solve(&lcp, &settings, &control)
    };
    match catch_unwind(AssertUnwindSafe(run)) {
        Err(_) => Outcome::Crashed("panic".into()),
        Ok(Err(error)) => Outcome::Crashed(error.to_string()),
        Ok(Ok(_)) if begun.elapsed() > patience(n) && spent() > patience(n) => Outcome::Hung(spent()),
        Ok(Ok(solution)) => Outcome::Answer(solution.into()),
    }
}

/// One batch: its way, what it was asked where that is not the chunk itself, and the answers.
pub struct Batch {
    pub way: usize,
    pub problems: Option<Vec<Problem>>,
    pub answers: Vec<Answer>,
}

/// A chunk of problems of one order as batches; those that failed are left out, which the single calls will show.
pub fn batches(problems: &[Problem], tol: f64, turn: u64, only: Option<usize>, rng: &mut Rng) -> Vec<Batch> {
    let n = problems[0].n;
    if n > 64 || only.is_some_and(|way| !is_batch(way)) {
        return vec![];
    }
    let whole = |way, guess: Guess<'_>| {
        let (a, q) = flat(problems);
        let answers =
            solve_batch([problems.len(), n], (Numbers::Double(&a), Source::Each), Numbers::Double(&q), tol, guess)?;
        Some(Batch { way, problems: None, answers })
    };
    let wrong: Vec<f64> = (0..problems.len() * n).map(|_| f64::from(u8::from(rng.bool()))).collect();
    let turns = |way: usize| match way {
        BATCH => true,
        BATCH_WRONG => turn.is_multiple_of(2),
        BATCH_SINGLE => turn % 2 == 1,
        BATCH_ONE_A => turn % 4 == 1,
        _ => turn % 4 == 3,
    };
    let batch = |way: usize| match way {
        BATCH => whole(way, Guess::None),
        BATCH_WRONG => whole(way, Guess::Points(&wrong)),
        BATCH_RIGHT => {
            let first = whole(way, Guess::None)?;
            let right: Vec<f64> = first.answers.iter().flat_map(|answer| answer.z.iter().copied()).collect();
            whole(way, Guess::Points(&right))
        }
        BATCH_SINGLE => in_single_precision(problems, tol),
        _ => with_one_matrix(problems, tol),
    };
    (BATCH..=BATCH_ONE_A).filter(|&way| only.map_or_else(|| turns(way), |only| way == only)).filter_map(batch).collect()
}

fn flat(problems: &[Problem]) -> (Vec<f64>, Vec<f64>) {
    let a = problems.iter().flat_map(|p| p.a.iter().copied()).collect();
    (a, problems.iter().flat_map(|p| p.q.iter().copied()).collect())
}

/// The problems rounded to float32, which the solver must take for the doubles that they equal.
fn in_single_precision(problems: &[Problem], tol: f64) -> Option<Batch> {
    let single = |v: Vec<f64>| -> Vec<f32> { v.iter().map(|&x| (x as f32).clamp(f32::MIN, f32::MAX)).collect() };
    let (a, q) = flat(problems);
    let (a, q) = (single(a), single(q));
    let n = problems[0].n;
    let double = |v: &[f32]| v.iter().map(|&x| f64::from(x)).collect();
    let rounded =
        |k: usize| Problem { n, a: double(&a[k * n * n..(k + 1) * n * n]), q: double(&q[k * n..(k + 1) * n]) };
    let answers =
        solve_batch([problems.len(), n], (Numbers::Single(&a), Source::Each), Numbers::Single(&q), tol, Guess::None)?;
    Some(Batch { way: BATCH_SINGLE, problems: Some((0..problems.len()).map(rounded).collect()), answers })
}

/// The first matrix with every q.
fn with_one_matrix(problems: &[Problem], tol: f64) -> Option<Batch> {
    let (n, a) = (problems[0].n, &problems[0].a);
    let (_, q) = flat(problems);
    let answers =
        solve_batch([problems.len(), n], (Numbers::Double(a), Source::One), Numbers::Double(&q), tol, Guess::None)?;
    let shared = problems.iter().map(|p| Problem { n, a: a.clone(), q: p.q.clone() }).collect();
    Some(Batch { way: BATCH_ONE_A, problems: Some(shared), answers })
}

/// All problems in one call; `None` when it failed.
fn solve_batch(
    [count, n]: [usize; 2],
    (a, a_source): (Numbers<'_>, Source<'_>),
    q: Numbers<'_>,
    tol: f64,
    guess: Guess<'_>,
) -> Option<Vec<Answer>> {
    let (mut z, mut w) = (vec![0.0; count * n], vec![0.0; count * n]);
    let (mut status, mut method, mut iterations) = (vec![0; count], vec![0; count], vec![0; count]);
    let (mut residual, mut natural) = (vec![0.0; count], vec![0.0; count]);
    let mut alpha = vec![false; count * n];
    let output = Output {
        z: &mut z,
        w: &mut w,
        status: &mut status,
        method: &mut method,
        iterations: &mut iterations,
        residual: &mut residual,
        natural_residual: &mut natural,
        alpha: Alpha::Flags(&mut alpha),
    };
    let given = Problems { n, count, a, a_source, q, q_source: Source::Each };
    let settings = batch::Settings { method: &Method::Auto, tol, threads: 1, guess, interrupted: None };
    let run = || batch::solve_batch(&given, &settings, output);
    catch_unwind(AssertUnwindSafe(run)).ok()?.ok()?;
    let answer = |k: usize| Answer {
        status: Status::ALL[usize::from(status[k])],
        z: z[k * n..(k + 1) * n].to_vec(),
        w: w[k * n..(k + 1) * n].to_vec(),
        residual: residual[k],
        natural_residual: natural[k],
        certificate: None,
    };
    Some((0..count).map(answer).collect())
}
