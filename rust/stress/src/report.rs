//! The tables, written by the tool: right, honest "no" and wrong, per attack and per method.

use crate::asking::{AUTO, ways};
use crate::campaign::{Count, Tally};
use lcpstar_referee::{ATTACKS, Attack};
use std::fmt::Write;

fn share(part: u64, whole: u64) -> String {
    if whole == 0 { "-".into() } else { format!("{:.1}", 100.0 * part as f64 / whole as f64) }
}

fn sum<'a>(counts: impl Iterator<Item = &'a Count>) -> Count {
    counts.fold(Count::default(), |mut sum, count| {
        sum.add(count);
        sum
    })
}

const HEAD: &str = "answers | right | of these nearly | honest no | wrong | not finite | crash | hang |";

fn row(count: &Count) -> String {
    format!(
        "{} | {} % | {} | {} % | {} | {} | {} | {} |",
        count.total(),
        share(count.right + count.nearly, count.total()),
        count.nearly,
        share(count.no, count.total()),
        count.wrong,
        count.not_finite,
        count.crashed,
        count.hung
    )
}

/// One line: what the whole campaign found.
pub fn summary(tally: &Tally) -> String {
    let all = sum(tally.counts.iter().flatten());
    format!(
        "{} problems, {} answers: {} wrong, {} crashes, {} hangs, {} with NaN or infinity",
        tally.problems.iter().sum::<u64>(),
        all.total(),
        all.wrong,
        all.crashed,
        all.hung,
        all.not_finite
    )
}

/// Per attack, per method, and the share of right answers for every pair of them.
pub fn tables(tally: &Tally) -> String {
    let ways = ways();
    let mut text = String::new();
    let _ = writeln!(text, "## Per attack\n\n| attack | what | problems | {HEAD}\n| --- | --- |{}", " --- |".repeat(9));
    for (a, attack) in ATTACKS.iter().enumerate() {
        let count = sum(tally.counts[a].iter());
        let _ = writeln!(text, "| {} | {} | {} | {}", attack.name, attack.about, tally.problems[a], row(&count));
    }
    let _ = writeln!(text, "\n## Per method\n\n| asked | {HEAD}\n| --- |{}", " --- |".repeat(8));
    for (m, way) in ways.iter().enumerate() {
        let count = sum(tally.counts.iter().map(|counts| &counts[m]));
        let _ = writeln!(text, "| {way} | {}", row(&count));
    }
    let cell = |count: &Count| match (count.total(), count.bad()) {
        (0, _) => "-".to_owned(),
        (total, 0) => share(count.right + count.nearly, total),
        (total, bad) => format!("{} ({bad} bad)", share(count.right + count.nearly, total)),
    };
    let _ = writeln!(
        text,
        "\n## Right answers in per cent\n\nThe rest are honest statuses other than \"solved\" and \"infeasible\", but for those named bad.\n\n| attack | {} |\n| --- |{}",
        ways.join(" | "),
        " --- |".repeat(ways.len())
    );
    for (a, attack) in ATTACKS.iter().enumerate() {
        let cells: Vec<String> = tally.counts[a].iter().map(cell).collect();
        let _ = writeln!(text, "| {} | {} |", attack.name, cells.join(" | "));
    }
    text
}

/// How many problems of order <= 4 `auto` left without an answer though an exact solution exists, per attack.
pub fn missed(tally: &Tally) -> String {
    let line = |(a, attack): (usize, &Attack)| {
        let missed = tally.counts[a][AUTO].missed;
        (missed > 0).then(|| format!("{} {missed}", attack.name))
    };
    let lines: Vec<String> = ATTACKS.iter().enumerate().filter_map(line).collect();
    if lines.is_empty() { "none".into() } else { lines.join(", ") }
}
