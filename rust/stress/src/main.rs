//! `lcpstar-stress`: a campaign that tries to make lcpstar lie. Problems from every corner of the range of doubles go to
//! every method; an exact referee that shares no code with the solver scores each answer.

mod asking;
mod campaign;
mod report;

use asking::ways;
use campaign::{CHUNK, CURRENT, Plan, Tally};
use lcpstar_referee::ATTACKS;
use lexopt::prelude::*;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

const USAGE: &str = "\
Usage: lcpstar-stress [--count N] [--large N] [--seed S] [--threads T] [--attack NAME] [--way NAME]
                      [--chunk C [--only K] [--print]] [--record FOLDER]
  --count    problems, about (default 20000), shared among the attacks by weight
  --large    problems of order 1000 (default 0)
  --attack   only this attack;  --way: only this method or way of asking
  --chunk    only this chunk of the attack;  --only: this problem of it;  --print: every answer
  --record   write docs/stress.md and benches/record/stress.md below FOLDER
Findings are printed and kept in target/stress-findings.txt. Exit status 1 if there is one.";

struct Arguments {
    plan: Plan,
    count: u64,
    large: u64,
    threads: usize,
    attack: Option<usize>,
    chunk: Option<u64>,
    record: Option<PathBuf>,
}

fn arguments() -> Result<Option<Arguments>, lexopt::Error> {
    let plan = Plan { seed: 1, only: None, way: None, print: false };
    let mut given = Arguments { plan, count: 20_000, large: 0, threads: 2, attack: None, chunk: None, record: None };
    let mut parser = lexopt::Parser::from_env();
    while let Some(argument) = parser.next()? {
        match argument {
            Long("count") => given.count = parser.value()?.parse()?,
            Long("large") => given.large = parser.value()?.parse()?,
            Long("seed") => given.plan.seed = parser.value()?.parse()?,
            Long("threads") => given.threads = parser.value()?.parse()?,
            Long("attack") => {
                let name = parser.value()?.string()?;
                let place = ATTACKS.iter().position(|attack| attack.name == name);
                given.attack = Some(place.ok_or_else(|| format!("no attack {name:?}"))?);
            }
            Long("way") => {
                let name = parser.value()?.string()?;
                given.plan.way =
                    Some(ways().iter().position(|way| *way == name).ok_or_else(|| format!("no way {name:?}"))?);
            }
            Long("chunk") => given.chunk = Some(parser.value()?.parse()?),
            Long("only") => given.plan.only = Some(parser.value()?.parse()?),
            Long("print") => given.plan.print = true,
            Long("record") => given.record = Some(parser.value()?.into()),
            Long("help") => return Ok(None),
            _ => return Err(argument.unexpected()),
        }
    }
    Ok(Some(given))
}

/// Pairs of attack and chunk.
fn chunks(given: &Arguments) -> Vec<(usize, u64)> {
    let weights: usize = ATTACKS.iter().map(|attack| attack.weight).sum();
    let mut all = vec![];
    for (a, attack) in ATTACKS.iter().enumerate().filter(|(a, _)| given.attack.is_none_or(|only| only == *a)) {
        let of_attack = match (attack.weight, given.attack) {
            (0, _) => given.large,
            (_, Some(_)) => given.count.div_ceil(CHUNK as u64),
            (weight, None) => (given.count * weight as u64).div_ceil((weights * CHUNK) as u64),
        };
        match given.chunk {
            Some(chunk) => all.push((a, chunk)),
            None => all.extend((0..of_attack).map(|chunk| (a, chunk))),
        }
    }
    // Every part of the campaign sees every attack.
    fastrand::Rng::with_seed(0).shuffle(&mut all);
    all
}

/// Names what has been running for a minute, every minute.
fn watch() {
    loop {
        std::thread::sleep(Duration::from_secs(60));
        if let Ok(current) = CURRENT.lock() {
            for (since, what) in current.iter().filter(|(since, _)| since.elapsed().as_secs() > 60) {
                eprintln!("for {} s: {what}", since.elapsed().as_secs());
            }
        }
    }
}

fn main() -> ExitCode {
    let given = match arguments() {
        Ok(Some(given)) => given,
        Ok(None) => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            eprintln!("{error}\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    std::panic::set_hook(Box::new(|_| ()));
    std::thread::spawn(watch);
    let (begun, commit) = (Instant::now(), commit());
    let chunks = chunks(&given);
    let done = AtomicU64::new(0);
    let attacked = |&(attack, chunk): &(usize, u64)| {
        let tally = given.plan.run(attack, chunk);
        for finding in tally.findings.iter().take(3) {
            eprintln!("{finding}");
        }
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if done.is_multiple_of(1000) {
            eprintln!("{done} of {} chunks, {:.0} s", chunks.len(), begun.elapsed().as_secs_f64());
        }
        tally
    };
    let run = || chunks.par_iter().map(attacked).reduce(Tally::new, Tally::add);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(given.threads).build();
    let tally = match pool {
        Ok(pool) => pool.install(run),
        Err(_) => run(),
    };
    let seconds = begun.elapsed().as_secs_f64();
    println!("{}\n{} in {seconds:.0} s", report::tables(&tally), report::summary(&tally));
    println!("no answer though solvable (auto, n <= 4): {}", report::missed(&tally));
    let findings = Path::new("target/stress-findings.txt");
    if let Err(error) = std::fs::write(findings, tally.findings.join("\n")) {
        eprintln!("{}: {error}", findings.display());
    }
    if let Some(folder) = &given.record
        && let Err(error) = record(folder, &given, &tally, &commit, seconds)
    {
        eprintln!("{}: {error}", folder.display());
        return ExitCode::from(2);
    }
    if tally.findings.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn record(folder: &Path, given: &Arguments, tally: &Tally, commit: &str, seconds: f64) -> std::io::Result<()> {
    let command = format!(
        "make stress-record STRESS=\"--count {} --large {} --seed {}\"",
        given.count, given.large, given.plan.seed
    );
    let (summary, tables, missed) = (report::summary(tally), report::tables(tally), report::missed(tally));
    let record = format!(
        "# Stress campaign\n\nMachine: {}, {} threads. lcpstar {} at commit {}. Command: `{command}`. {seconds:.0} s, the referee's \
         time included, on a shared machine.\n\n{summary}.\n\nNo answer of `auto` though an exact solution exists (n <= 4, every \
         such problem tried): {missed}.\n\n{tables}",
        processor(),
        given.threads,
        env!("CARGO_PKG_VERSION"),
        commit,
    );
    std::fs::write(folder.join("benches/record/stress.md"), record)?;
    let docs =
        format!("{}\n{summary} (seed {}, `{command}`).\n\n{tables}", include_str!("preface.md"), given.plan.seed);
    std::fs::write(folder.join("docs/stress.md"), docs)
}

fn commit() -> String {
    let output = Command::new("git").args(["describe", "--always", "--dirty"]).output();
    output.ok().and_then(|o| String::from_utf8(o.stdout).ok()).map_or_else(|| "unknown".into(), |s| s.trim().to_owned())
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("model name"));
    line.map_or_else(|| std::env::consts::ARCH.into(), |line| line.trim_start_matches([' ', '\t', ':']).to_owned())
}
