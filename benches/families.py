"""`lcpstar.solve` per call beside its peers, family by family: `python benches/families.py [FAMILY ...]`."""

from __future__ import annotations

import sys

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


def measure(build, size, symmetric, peers):
    """Median seconds of each solver that solves every instance, and how many the others solve."""
    instances = [build(size, seed) for seed in range(SEEDS)]
    solvers = {"lcpstar": lambda A, q: lcpstar.solve(A, q).z}
    solvers |= {name: peer for name, (peer, needs) in peers.items() if symmetric or not needs}
    solved = {
        name: sum(residual(A, q, solver(A, q)) <= ACCEPTED for A, q in instances) for name, solver in solvers.items()
    }
    calls = {
        name: (lambda solver=solvers[name]: [solver(A, q) for A, q in instances])
        for name in solvers
        if solved[name] == SEEDS
    }
    times = {name: t / SEEDS for name, t in seconds_per_call(calls).items()}
    return len(instances[0][1]), solved, times


def main(names: list[str]) -> None:
    peers = available()
    head = "family | n | lcpstar | fastest peer that solves all | ratio | quantecon / lcpstar | solved by others"
    lines = [f"| {head} |", "| --- | --- | --- | --- | --- | --- | --- |"]
    data = []
    for family in names or FAMILIES:
        build, sizes, symmetric = FAMILIES[family]
        for size in sizes:
            n, solved, times = measure(build, size, symmetric, peers)
            ours = times.pop("lcpstar", float("nan"))
            best = min(times, key=times.get, default=None)
            ratio = f"{times[best] / ours:.1f}" if best else "only one"
            beside = f"{times['quantecon'] / ours:.1f}" if "quantecon" in times else "fails"
            failed = ", ".join(f"{name} {k}/{SEEDS}" for name, k in solved.items() if k < SEEDS)
            rival = f"{best} {1e6 * times[best]:.1f} us" if best else "none"
            lines.append(f"| {family} | {n} | {1e6 * ours:.1f} us | {rival} | {ratio} | {beside} | {failed} |")
            print(lines[-1], flush=True)
            data.append({"family": family, "n": n, "lcpstar": ours, "peers": times, "solved": solved})
    if not names:
        write_record("families", "solve per call, beside peers", "python benches/families.py", "\n".join(lines), data)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main(sys.argv[1:])
