//! Who answers which problem: chunks of problems of one attack and one order, several methods each, every answer scored.

use fastrand::Rng;
use lcpstar::batch::{self, Alpha, Guess, Output, Problems, Source};
use lcpstar::driver::{self, Certify, Method};
use lcpstar::methods::enumerate;
use lcpstar::{Control, Lcp, Status};
use lcpstar_stress::attacks::{ATTACKS, Attack};
use lcpstar_stress::problem::Problem;
use lcpstar_stress::referee::{Answer, Case, Score};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Problems of a chunk: more than the widest registers hold, so that batches use their lanes.
pub const CHUNK: usize = 32;

/// Ways to ask beside the methods by name: defaults, as a batch, as a batch and alone from a wrong guess, with a proof.
pub const AUTO: usize = 0;
const BATCH: usize = 1;
const BATCH_GUESS: usize = 2;
const WRONG_Z0: usize = 3;
const EXACT: usize = 4;
const NAMED: usize = 5;

/// Names of all ways to ask.
pub fn ways() -> Vec<&'static str> {
    let mut ways = vec!["auto", "batch", "batch, wrong guess", "auto, wrong z0", "auto, exact"];
    ways.extend(Method::NAMES.iter().filter(|name| **name != "auto"));
    ways
}

/// Counts of one attack and one way.
#[derive(Clone, Copy, Debug, Default)]
pub struct Count {
    pub right: u64,
    pub nearly: u64,
    pub no: u64,
    /// Of `no`: n <= 4 and an exact solution exists.
    pub missed: u64,
    pub wrong: u64,
    pub not_finite: u64,
    pub crashed: u64,
    pub hung: u64,
}

impl Count {
    pub fn add(&mut self, o: &Self) {
        self.right += o.right;
        self.nearly += o.nearly;
        self.no += o.no;
        self.missed += o.missed;
        self.wrong += o.wrong;
        self.not_finite += o.not_finite;
        self.crashed += o.crashed;
        self.hung += o.hung;
    }

    pub fn total(&self) -> u64 {
        self.right + self.nearly + self.no + self.bad()
    }

    pub fn bad(&self) -> u64 {
        self.wrong + self.not_finite + self.crashed + self.hung
    }
}

/// What a campaign counted.
pub struct Tally {
    /// `counts[attack][way]`.
    pub counts: Vec<Vec<Count>>,
    pub problems: Vec<u64>,
    pub findings: Vec<String>,
}

impl Tally {
    pub fn new() -> Self {
        Self {
            counts: vec![vec![Count::default(); ways().len()]; ATTACKS.len()],
            problems: vec![0; ATTACKS.len()],
            findings: vec![],
        }
    }

    pub fn add(mut self, other: Self) -> Self {
        for (mine, theirs) in self.counts.iter_mut().flatten().zip(other.counts.iter().flatten()) {
            mine.add(theirs);
        }
        for (mine, theirs) in self.problems.iter_mut().zip(other.problems) {
            *mine += theirs;
        }
        self.findings.extend(other.findings);
        self
    }
}

/// Which problems are attacked, and by what.
pub struct Plan {
    pub seed: u64,
    /// Only this problem of the chunk.
    pub only: Option<usize>,
    /// Only this way of asking.
    pub way: Option<usize>,
    pub print: bool,
}

/// What is being solved at the moment, for the watchdog.
pub static CURRENT: Mutex<Vec<(Instant, String)>> = Mutex::new(Vec::new());

impl Plan {
    /// The problems of one chunk, and the tolerance they are solved to.
    fn problems(&self, attack: usize, chunk: u64) -> (Vec<Problem>, f64, Rng) {
        let mut mixer = Rng::with_seed(self.seed ^ (attack as u64) << 48 ^ chunk);
        let mut rng = Rng::with_seed(mixer.u64(..));
        let Attack { order, problem, weight, .. } = ATTACKS[attack];
        let n = order(&mut rng);
        let tol = [1e-3, 1e-6, 1e-9, 1e-9, 1e-9, 1e-12, 1e-14][rng.usize(0..7)];
        let count = if weight == 0 { 1 } else { CHUNK };
        ((0..count).map(|_| problem(&mut rng, n)).collect(), tol, rng)
    }

    /// Attacks with one chunk.
    pub fn run(&self, attack: usize, chunk: u64) -> Tally {
        let (problems, tol, mut rng) = self.problems(attack, chunk);
        let mut tally = Tally::new();
        let n = problems[0].n;
        let guess: Vec<f64> = (0..problems.len() * n).map(|_| f64::from(u8::from(rng.bool()))).collect();
        let in_batch = |way: usize, guess: Guess<'_>| -> Option<Vec<Answer>> {
            let wanted = n <= 64 && self.way.is_none_or(|only| only == way);
            wanted.then(|| solve_batch(&problems, tol, guess)).flatten()
        };
        let batches = [
            (BATCH, in_batch(BATCH, Guess::None)),
            (BATCH_GUESS, if chunk.is_multiple_of(2) { in_batch(BATCH_GUESS, Guess::Points(&guess)) } else { None }),
        ];
        for (k, problem) in problems.iter().enumerate().filter(|(k, _)| self.only.is_none_or(|only| only == *k)) {
            tally.problems[attack] += 1;
            let mut answers: Vec<(usize, Outcome)> = vec![];
            for way in self.ways_to_ask(n, chunk, k) {
                let z0 = (way == WRONG_Z0).then(|| guess[k * n..(k + 1) * n].to_vec());
                self.enter(attack, chunk, k, way);
                answers.push((way, solve(problem, way, tol, z0)));
            }
            for (way, batch) in &batches {
                if let Some(batch) = batch {
                    answers.push((*way, Outcome::Answer(batch[k].clone())));
                }
            }
            let place =
                || format!("--attack {:?} --chunk {chunk} --only {k} --seed {}", ATTACKS[attack].name, self.seed);
            self.score(attack, problem, answers, tol, &place, &mut tally);
        }
        tally
    }

    fn enter(&self, attack: usize, chunk: u64, k: usize, way: usize) {
        let thread = rayon::current_thread_index().unwrap_or(0);
        if let Ok(mut current) = CURRENT.lock() {
            if current.len() <= thread {
                current.resize(thread + 1, (Instant::now(), String::new()));
            }
            current[thread] = (Instant::now(), format!("{} {chunk} {k} {}", ATTACKS[attack].name, ways()[way]));
        }
    }

    /// Always `auto`; from a wrong guess every other time; two of the named methods in turn; the proofs of few.
    fn ways_to_ask(&self, n: usize, chunk: u64, k: usize) -> Vec<usize> {
        if let Some(way) = self.way {
            return if way == BATCH || way == BATCH_GUESS { vec![] } else { vec![way] };
        }
        let named = ways().len() - NAMED;
        let turn = chunk as usize * 7 + k;
        let mut asked = vec![AUTO];
        if n >= 1000 {
            return vec![AUTO, NAMED + turn % named];
        }
        if turn.is_multiple_of(2) {
            asked.push(WRONG_Z0);
        }
        if turn.is_multiple_of(8) && n <= 16 {
            asked.push(EXACT);
        }
        asked.push(NAMED + turn % named);
        asked.push(NAMED + (turn + 1 + turn / named) % named);
        asked.dedup();
        asked
    }

    fn score(
        &self,
        attack: usize,
        problem: &Problem,
        answers: Vec<(usize, Outcome)>,
        tol: f64,
        place: &dyn Fn() -> String,
        tally: &mut Tally,
    ) {
        let case = Case::new(problem);
        // Exact Farkas vectors first: they decide solvability for the others.
        let mut infeasible = None;
        let (no, rest): (Vec<_>, Vec<_>) = answers.into_iter().partition(|(way, outcome)| {
            matches!(outcome, Outcome::Answer(a) if a.status == Status::Infeasible) && !is_batch(*way)
        });
        for (way, outcome) in no.into_iter().chain(rest) {
            let count = &mut tally.counts[attack][way];
            let why = match outcome {
                Outcome::NotForIt => continue,
                Outcome::Crashed(why) => {
                    count.crashed += 1;
                    Some(format!("crash: {why}"))
                }
                Outcome::Hung(time) => {
                    count.hung += 1;
                    Some(format!("{:.1} s", time.as_secs_f64()))
                }
                Outcome::Answer(answer) => {
                    let score = if is_batch(way) && is_refuted(answer.status) {
                        infeasible_in_batch(&case, &infeasible)
                    } else {
                        case.score(&answer, tol)
                    };
                    if is_refuted(answer.status) && way == AUTO {
                        infeasible = Some(score.clone());
                    }
                    if self.print {
                        eprintln!("{}: {} {score:?} z = {:?}", ways()[way], answer.status.as_str(), answer.z);
                    }
                    counted(score, count, way == AUTO && problem.n <= 4, &case)
                }
            };
            if let Some(why) = why {
                let numbers = if problem.n <= 8 {
                    let rows: Vec<&[f64]> = (0..problem.n).map(|i| problem.row(i)).collect();
                    format!("\n  A = {rows:?}\n  q = {:?}", problem.q)
                } else {
                    String::new()
                };
                let n = problem.n;
                tally.findings.push(format!("{} n = {n} tol = {tol:e} {:?}: {why}{numbers}", place(), ways()[way]));
            }
        }
    }
}

fn is_refuted(status: Status) -> bool {
    matches!(status, Status::Infeasible | Status::NearlyInfeasible)
}

fn is_batch(way: usize) -> bool {
    way == BATCH || way == BATCH_GUESS
}

/// A batch hands over no certificate: its "infeasible" is scored as that of `auto`, or else by what is known to be true.
fn infeasible_in_batch(case: &Case<'_>, alone: &Option<Score>) -> Score {
    if let Some(score) = alone {
        return score.clone();
    }
    if case.refuted.get().is_some() {
        return Score::Right;
    }
    match case.problem.n <= lcpstar_stress::referee::ENUMERATED {
        true if case.is_solvable() => Score::Wrong("infeasible, but an exact solution exists".into()),
        true => Score::Right,
        false => Score::No,
    }
}

/// Adds the score; the reason where it is bad.
fn counted(score: Score, count: &mut Count, look_closer: bool, case: &Case<'_>) -> Option<String> {
    match score {
        Score::Right => count.right += 1,
        Score::RightNearly => count.nearly += 1,
        Score::No => {
            count.no += 1;
            count.missed += u64::from(look_closer && case.is_solvable());
        }
        Score::Wrong(why) => {
            count.wrong += 1;
            return Some(why);
        }
        Score::NotFinite(why) => {
            count.not_finite += 1;
            return Some(why);
        }
    }
    None
}

/// How a call ended.
enum Outcome {
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

fn solve(problem: &Problem, way: usize, tol: f64, z0: Option<Vec<f64>>) -> Outcome {
    let n = problem.n;
    let names = ways();
    let name = if way < NAMED { "auto" } else { names[way] };
    if name == "enumerate" && n > 12.min(enumerate::MAX_ORDER) {
        return Outcome::NotForIt;
    }
    let certify = if way == EXACT { Certify::Exact } else { Certify::Float };
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
        driver::solve(&lcp, &settings, &control)
    };
    match catch_unwind(AssertUnwindSafe(run)) {
        Err(_) => Outcome::Crashed("panic".into()),
        Ok(Err(error)) => Outcome::Crashed(error.to_string()),
        Ok(Ok(_)) if begun.elapsed() > patience(n) && spent() > patience(n) => Outcome::Hung(spent()),
        Ok(Ok(solution)) => Outcome::Answer(solution.into()),
    }
}

/// All problems in one call; `None` when it failed, which the single calls will show.
fn solve_batch(problems: &[Problem], tol: f64, guess: Guess<'_>) -> Option<Vec<Answer>> {
    let (count, n) = (problems.len(), problems[0].n);
    let a: Vec<f64> = problems.iter().flat_map(|p| p.a.iter().copied()).collect();
    let q: Vec<f64> = problems.iter().flat_map(|p| p.q.iter().copied()).collect();
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
    let given = Problems {
        n,
        count,
        a: batch::Numbers::Double(&a),
        a_source: Source::Each,
        q: batch::Numbers::Double(&q),
        q_source: Source::Each,
    };
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
