"""Batches beside QuantEcon's `lcp_lemke` in a numba-compiled loop: `python benches/batch.py`.

One thread, medians of processor time.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from statistics import median

import numpy as np

import lcpstar
from families_batch import FAMILIES
from harness import write_record


def quantecon_loop():
    """`(A, q) -> (z, solved)` without a Python step per problem; memory reused, no verification."""
    import numba
    from quantecon.optimize import lcp_lemke
    from quantecon.optimize.linprog_simplex import PivOptions

    options = PivOptions()

    @numba.njit
    def loop(A, q, d, tableau, basis, z):
        solved = 0
        for k in range(len(A)):
            solved += lcp_lemke(A[k], q[k], d, 1_000_000, options, tableau, basis, z[k]).success
        return solved

    def run(A, q):
        n = q.shape[1]
        z = np.empty_like(q)
        return z, loop(A, q, np.ones(n), np.empty((n, 2 * n + 2)), np.empty(n, np.int_), z)

    return run


def seconds(calls, repeats):
    """Median processor time of the calling thread for each call, the calls taking turns."""
    times = {name: [] for name in calls}
    for _ in range(repeats):
        for name, call in calls.items():
            start = time.thread_time()
            call()
            times[name].append(time.thread_time() - start)
    return {name: median(t) for name, t in times.items()}


def check(A, q, sols):
    """Every problem solved, and verified here once more."""
    assert sols.success.all(), sols
    w = (A @ sols.z[..., None])[..., 0] + q
    scale = (np.abs(A) @ sols.z[..., None])[..., 0] + np.abs(q)
    assert (np.abs(np.minimum(sols.z, w)) <= 1e-8 * np.abs(q).max(axis=1, keepdims=True) + 1e-14 * scale).all()


def synthetic(peer, count, repeats):
    lines = [
        "| family | n | cold, M/s | warm, M/s | warm/cold | quantecon loop, M/s | cold/quantecon "
        "| quantecon: success |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    data = []
    for name, family in FAMILIES.items():
        for n in (6, 12, 18, 24, 30) if name == "stewart_trinkle" else (4, 8, 12, 16, 32):
            k = min(count, 400_000_000 // (8 * n * n))
            A, q = family(k, n)
            sols = lcpstar.solve_batch(A, q, threads=1)
            check(A, q, sols)
            calls = {
                "cold": lambda A=A, q=q: lcpstar.solve_batch(A, q, threads=1),
                "warm": lambda A=A, q=q, alpha=sols.alpha: lcpstar.solve_batch(A, q, threads=1, alpha0=alpha),
            }
            claimed = float("nan")
            if peer:
                claimed = peer(A, q)[1] / k
                calls["quantecon"] = lambda A=A, q=q: peer(A, q)
            times = seconds(calls, repeats)
            rate = {key: k / t / 1e6 for key, t in times.items()}
            beside = rate.get("quantecon", float("nan"))
            lines.append(
                f"| {name} | {n} | {rate['cold']:.3f} | {rate['warm']:.3f} | {rate['warm'] / rate['cold']:.1f} "
                f"| {beside:.3f} | {rate['cold'] / beside:.1f} | {100 * claimed:.2f} % |"
            )
            print(lines[-1], flush=True)
            data.append({"family": name, "n": n, "count": k, "rate": rate})
    return lines, data


def corpus_batches(peer, repeats):
    """The published batches of contact problems."""
    folder = os.environ.get("LCPSTAR_CORPUS")
    if not folder:
        return [], []
    lines = ["| batch | n | problems | lcpstar, us a problem | quantecon loop, us | ratio | quantecon right |"]
    lines.append("| --- | --- | --- | --- | --- | --- | --- |")
    data = []
    for path in sorted(Path(folder).glob("batch_*.npz")):
        file = np.load(path)
        A, q = np.ascontiguousarray(file["A"]), np.ascontiguousarray(file["q"])
        sols = lcpstar.solve_batch(A, q, threads=1)
        check(A, q, sols)
        calls = {"lcpstar": lambda A=A, q=q: lcpstar.solve_batch(A, q, threads=1)}
        right = float("nan")
        if peer:
            z, _ = peer(A, q)
            w = (A @ z[..., None])[..., 0] + q
            right = np.mean(np.abs(np.minimum(z, w)).max(axis=1) <= 1e-8 * np.abs(q).max(axis=1))
            calls["quantecon"] = lambda A=A, q=q: peer(A, q)
        times = {key: 1e6 * t / len(q) for key, t in seconds(calls, repeats).items()}
        beside = times.get("quantecon", float("nan"))
        ours = times["lcpstar"]
        lines.append(
            f"| {path.stem} | {q.shape[1]} | {len(q)} | {ours:.2f} | {beside:.2f} | {beside / ours:.1f} "
            f"| {100 * right:.0f} % |"
        )
        print(lines[-1], flush=True)
        data.append({"batch": path.stem, "times": times})
    return lines, data


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    try:
        peer = quantecon_loop()
    except ImportError:
        peer = None
    lines, data = synthetic(peer, options.count, options.repeats)
    more, corpus = corpus_batches(peer, options.repeats)
    text = "\n".join([*lines, "", *more])
    write_record(
        "batch",
        "Batches of small problems, one thread, processor time",
        "python benches/batch.py",
        text,
        [*data, *corpus],
    )


if __name__ == "__main__":
    main()
