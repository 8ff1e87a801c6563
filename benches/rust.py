"""The core without Python, by divan: `make bench-rust`; beside another commit: `make bench-rust AGAINST=COMMIT`."""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import statistics
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
UNITS = {"ps": 1e-12, "ns": 1e-9, "µs": 1e-6, "ms": 1e-3, "s": 1.0}


def output(*command: str, cwd: Path = ROOT, target: Path = ROOT / "target") -> str:
    environment = os.environ | {"CARGO_TARGET_DIR": str(target)}
    return subprocess.run(command, cwd=cwd, env=environment, check=True, text=True, stdout=subprocess.PIPE).stdout


def build(tree: Path, target: Path) -> str:
    """The program that measures that tree. Two trees need two targets: their files have the same names."""
    command = ("cargo", "bench", "-p", "lcpstar", "--bench", "core", "--no-run", "--message-format=json")
    messages = [json.loads(line) for line in output(*command, cwd=tree, target=target).splitlines()]
    return next(m["executable"] for m in messages if m.get("executable"))


def measure(program: str, names: list[str]) -> dict[str, float]:
    """Median seconds by benchmark, `"name n"`."""
    times, group = {}, ""
    for line in output(program, "--bench", "--min-time", "0.2", "--max-time", "1", *names).splitlines():
        if not (found := re.match(r"(│  |   )?[├╰]─ (\S+)(.*)", line)):
            continue
        indent, name, rest = found.groups()
        group = group if indent else name
        columns = rest.split("│")
        if len(columns) > 2 and columns[2].strip():
            value, unit = columns[2].split()
            times[f"{group} {name}" if indent else name] = float(value) * UNITS[unit]
    return times


def in_turns(programs: list[str], names: list[str], rounds: int) -> list[dict[str, float]]:
    """The median of some runs of each program."""
    runs = [[measure(program, names) for program in programs] for _ in range(rounds)]
    return [
        {name: statistics.median(run[i][name] for run in runs) for name in runs[0][i]} for i in range(len(programs))
    ]


def text(seconds: float) -> str:
    unit = next(u for u in ("s", "ms", "µs", "ns") if seconds >= UNITS[u] or u == "ns")
    return f"{seconds / UNITS[unit]:.3g} {unit}"


def machine() -> str:
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    model = next((line.split(":")[1].strip() for line in lines if "model name" in line), platform.processor())
    return f"{model}, {platform.system()}, {output('rustc', '--version').split(' (')[0]}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="only benchmarks whose name contains one of these")
    parser.add_argument("--against", metavar="COMMIT", help="print ratios to that commit, write nothing")
    parser.add_argument("--rounds", type=int, default=3, help="runs of each, in turns")
    given = parser.parse_args()
    here = build(ROOT, ROOT / "target")
    if given.against:
        tree = ROOT / "target" / "against"
        output("git", "worktree", "add", "--force", "--detach", str(tree), given.against)
        try:
            other, this = in_turns([build(tree, ROOT / "target" / "against-build"), here], given.names, given.rounds)
        finally:
            output("git", "worktree", "remove", "--force", str(tree))
        print(f"| benchmark | {given.against} | here | faster by |\n| --- | --- | --- | --- |")
        for name in (name for name in this if name in other):
            print(f"| {name} | {text(other[name])} | {text(this[name])} | {other[name] / this[name]:.2f} |")
        return
    (times,) = in_turns([here], given.names, given.rounds)
    rows = "".join(f"| {name} | {text(seconds)} |\n" for name, seconds in times.items())
    commit = output("git", "rev-parse", "--short", "HEAD").strip()
    record = f"""# The core, from Rust

Machine: {machine()}; commit {commit}. One thread. Command: `make bench-rust`.
`make bench-rust AGAINST=COMMIT` compares two commits. The benchmarks are `rust/lcpstar/benches/core.rs`; the number is
the order. Shared machine: medians of medians, anything below 1.5x is a tie.

| benchmark | median |
| --- | --- |
{rows}"""
    print(record)
    if not given.names:
        (ROOT / "benches" / "record" / "rust.md").write_text(record)


if __name__ == "__main__":
    main()
