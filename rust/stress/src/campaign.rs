//! Who answers which problem: chunks of problems of one attack and one order, several methods each, every answer scored.

use crate::asking::{AUTO, Outcome, RIGHT_Z0, WRONG_Z0, alone, batches, is_batch, solve, ways};
use fastrand::Rng;
use lcpstar::Status;
use lcpstar_referee::{ATTACKS, Attack, Case, Problem, Score, referee::ENUMERATED};
use std::sync::Mutex;
use std::time::Instant;

/// Problems of a chunk: more than the widest registers hold, so that batches use their lanes.
pub const CHUNK: usize = 32;

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
        let batches = batches(&problems, tol, chunk, self.way, &mut rng);
        for (k, problem) in problems.iter().enumerate().filter(|(k, _)| self.only.is_none_or(|only| only == *k)) {
            tally.problems[attack] += 1;
            let place =
                || format!("--attack {:?} --chunk {chunk} --only {k} --seed {}", ATTACKS[attack].name, self.seed);
            let mut answers: Vec<(usize, Outcome)> = vec![];
            for way in self.ways_to_ask(n, chunk, k) {
                let z0 = match way {
                    WRONG_Z0 => Some(guess[k * n..(k + 1) * n].to_vec()),
                    RIGHT_Z0 => right_guess(problem, tol),
                    _ => None,
                };
                self.enter(attack, chunk, k, way);
                answers.push((way, solve(problem, way, tol, z0)));
            }
            for batch in &batches {
                let answer = (batch.way, Outcome::Answer(batch.answers[k].clone()));
                match &batch.problems {
                    None => answers.push(answer),
                    Some(problems) => self.score(attack, &problems[k], vec![answer], tol, &place, &mut tally),
                }
            }
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

    fn ways_to_ask(&self, n: usize, chunk: u64, k: usize) -> Vec<usize> {
        match self.way {
            Some(way) if is_batch(way) => vec![],
            Some(way) => vec![way],
            None => alone(n, chunk as usize * 7 + k),
        }
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
                        infeasible_in_batch(&case, &infeasible, tol)
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

/// The answer itself as a guess.
fn right_guess(problem: &Problem, tol: f64) -> Option<Vec<f64>> {
    match solve(problem, AUTO, tol, None) {
        Outcome::Answer(answer) if answer.z.iter().all(|z| z.is_finite() && *z >= 0.0) => Some(answer.z),
        _ => None,
    }
}

/// A batch hands over no certificate: its "infeasible" is scored as that of `auto`, or else by what is known to be true.
fn infeasible_in_batch(case: &Case<'_>, known: &Option<Score>, tol: f64) -> Score {
    if let Some(score) = known {
        return score.clone();
    }
    if let Outcome::Answer(answer) = solve(case.problem, AUTO, tol, None)
        && is_refuted(answer.status)
    {
        return case.score(&answer, tol);
    }
    match case.core().n <= ENUMERATED {
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
