"""`lcpstar.solve` per call beside its peers, family by family: `python benches/families.py [FAMILY ...]`."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import lcpstar
from harness import residual, seconds_per_call, write_record
from lcpstar import problems
from peers import available

SEEDS = 3
#: name -> (builder(size, seed), sizes, symmetric positive semidefinite)
FAMILIES = {
    "random_pd": (problems.random_pd, [4, 16, 32, 64, 128, 256, 512, 1000], False),
    "random_spd": (problems.random_spd, [8, 32, 64, 128, 256, 512, 1000], True),
    "psd_half_rank": (problems.psd_half_rank, [8, 32, 128, 256, 512], True),
    "psd_half_rank_skew": (lambda n, s: problems.psd_half_rank(n, s, skew=0.5), [8, 32, 128, 256], False),
    "box_stack": (lambda k, s: problems.box_stack(k, 1.0, seed=s), [3, 8, 16, 50], True),
    "box_stack_1e6": (lambda k, s: problems.box_stack(k, 1e6, seed=s), [3, 8, 16, 50], True),
    "sphere_pile": (lambda k, s: problems.sphere_pile(k, 1.0, s), [8, 32, 100, 250], True),
    "sphere_pile_1e6": (lambda k, s: problems.sphere_pile(k, 1e6, s), [8, 32, 100, 250], True),
    "stewart_trinkle": (problems.stewart_trinkle, [1, 2, 4, 8, 16, 30, 60], False),
    "bimatrix": (problems.bimatrix, [5, 10, 25, 50], False),
    "murty": (lambda n, s: problems.murty(n), [8, 20], False),
    "fathi": (lambda n, s: problems.fathi(n), [8, 20], True),
    "degenerate": (problems.degenerate, [16, 64, 128, 256], True),
    "badly_scaled": (problems.badly_scaled, [16, 32, 64, 128], False),
}
ACCEPTED = 1e-6
#: What is written under the table.
NOTES = Path(__file__).parent / "families_notes.md"
#: A peer that needs longer for one call is not asked for the larger problems of the family.
PATIENCE = 0.15
#: Those that the targets name are measured all the same.
MEASURED_ANYWAY = {"lcpstar", "quantecon", "mju_boxQP"}
#: Peers for one family only.
ONLY = {"quantecon-lh": "bimatrix"}


def tried(solvers, instances):
    """How many instances each solver solves, and which solvers are too slow to be asked again."""
    solved, slow = {}, set()
    for name, solver in solvers.items():
        solver(*instances[0])  # compiles what is compiled at the first call
        answers = []
        for A, q in instances:
            start = time.thread_time()
            answers.append(solver(A, q))
            if time.thread_time() - start > PATIENCE and name not in MEASURED_ANYWAY:
                slow.add(name)
                break
        solved[name] = sum(residual(A, q, z) <= ACCEPTED for (A, q), z in zip(instances, answers, strict=False))
    return solved, slow


def measure(instances, solvers):
    """Median seconds of each solver that solves every instance, how many each solves, and which are too slow."""
    solved, slow = tried(solvers, instances)
    calls = {
        name: (lambda solver=solvers[name]: [solver(A, q) for A, q in instances])
        for name in solvers
        if solved[name] == SEEDS and name not in slow
    }
    times = {name: t / SEEDS for name, t in seconds_per_call(calls, 0.1, clock=time.thread_time).items()}
    return {name: k for name, k in solved.items() if name not in slow}, times, slow


def row(family, n, solved, times, dropped):
    """One line of the table."""
    peers = {name: t for name, t in times.items() if name != "lcpstar"}
    ours = times.get("lcpstar", float("nan"))
    best = min(peers, key=peers.get, default=None)
    ratio = f"{peers[best] / ours:.1f}" if best else "only one"
    rival = f"{best} {1e6 * peers[best]:.1f} us" if best else "none"
    beside = f"{peers['quantecon'] / ours:.1f}" if "quantecon" in peers else "fails"
    box = f"{peers['mju_boxQP'] / ours:.1f}" if "mju_boxQP" in peers else ""
    failed = [f"{name} {k}/{SEEDS}" for name, k in solved.items() if k < SEEDS]
    failed += [f"{name} too slow" for name in sorted(dropped) if name not in solved]
    return f"| {family} | {n} | {1e6 * ours:.1f} us | {rival} | {ratio} | {beside} | {box} | {', '.join(failed)} |"


def main(names: list[str]) -> None:
    peers = available()
    head = "family | n | lcpstar | fastest peer that solves all | ratio | quantecon | mju_boxQP | solved by others"
    lines = [f"| {head} |", "| --- " * 8 + "|"]
    data = []
    for family in names or FAMILIES:
        build, sizes, symmetric = FAMILIES[family]
        solvers = {"lcpstar": lambda A, q: lcpstar.solve(A, q).z}
        solvers |= {
            name: peer
            for name, (peer, needs) in peers.items()
            if (symmetric or not needs) and ONLY.get(name, family) == family
        }
        dropped: set[str] = set()
        for size in sizes:
            instances = [build(size, seed) for seed in range(SEEDS)]
            n = len(instances[0][1])
            solved, times, slow = measure(instances, {k: v for k, v in solvers.items() if k not in dropped})
            dropped |= slow
            lines.append(row(family, n, solved, times, dropped))
            print(lines[-1], flush=True)
            data.append({"family": family, "n": n, "times": times, "solved": solved, "too_slow": sorted(dropped)})
    if not names:
        lines.append(
            "\nProcessor time of one thread. Columns quantecon and mju_boxQP: their time over that of lcpstar.\n"
        )
        lines.append(NOTES.read_text(encoding="utf-8").strip())
        write_record("families", "solve per call, beside peers", "python benches/families.py", "\n".join(lines), data)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main(sys.argv[1:])
