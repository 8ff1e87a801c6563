"""Batches beside QuantEcon's `lcp_lemke` in a numba-compiled loop: `python benches/batch.py --count 100000`.

One thread, medians of processor time, the calls taking turns; NumPy's sum of all entries of A tells what reading them
takes. Also single precision, one A with many q, and the published batches of contact problems beside Drake and Siconos
where they are installed.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys
import time
from pathlib import Path
from statistics import median

import numpy as np

import lcpstar
from families_batch import FAMILIES
from harness import write_record
from peers import available


def quantecon_loop():
    """`(A, q) -> (z, solved)` without a Python step per problem; all memory is used again, nothing verified."""
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

    points: dict[tuple[int, ...], np.ndarray] = {}

    def run(A, q):
        n = q.shape[1]
        if q.shape not in points:
            points[q.shape] = np.empty_like(q)
        z = points[q.shape]
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


def drake_loop():
    """Drake's MobyLCP as Python reaches it: a program is built for each problem, which takes longer than the solve."""
    peers = available(["drake-moby"])
    if not peers:
        raise ImportError
    solve, _ = peers["drake-moby"]

    def run(A, q):
        z = np.zeros_like(q)
        for k in range(len(q)):
            answer = solve(A[k], q[k])
            if answer is not None:
                z[k] = answer
        return z, None

    return run


def siconos_loop():
    """Siconos' Lemke, one call a problem."""
    import siconos.numerics as sn

    def run(A, q):
        z = np.zeros_like(q)
        options = sn.SolverOptions(sn.SICONOS_LCP_LEMKE)
        for k in range(len(q)):
            w = np.zeros(q.shape[1])
            sn.linearComplementarity_driver(sn.LCP(A[k], q[k]), z[k], w, options)
        return z, None

    return run


def available_loops():
    """The peers that are installed, by name."""
    loops = {}
    for name, make in (("quantecon", quantecon_loop), ("drake", drake_loop), ("siconos", siconos_loop)):
        try:
            loops[name] = make()
        except ImportError:
            print(f"{name} is not installed")
    return loops


def right(A, q, z):
    """Which points solve their problems, by one yardstick for all."""
    w = (A @ z[..., None])[..., 0] + q
    return np.abs(np.minimum(z, w)).max(axis=1) <= 1e-8 * np.maximum(np.abs(q).max(axis=1), 1e-300)


def check(A, q, sols):
    """Every problem solved, and verified here once more."""
    assert sols.success.all(), sols
    w = (A @ sols.z[..., None])[..., 0] + q
    scale = (np.abs(A) @ sols.z[..., None])[..., 0] + np.abs(q)
    assert (np.abs(np.minimum(sols.z, w)) <= 1e-8 * np.abs(q).max(axis=1, keepdims=True) + 1e-14 * scale).all()


def synthetic(peer, count, repeats):
    lines = [
        "| family | n | cold, M/s | warm, M/s | warm/cold | cold without `out=`, M/s | `A.sum()`, M/s "
        "| quantecon loop, M/s | cold/quantecon | quantecon: success |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    data = []
    for name, family in FAMILIES.items():
        for n in (6, 12, 18, 24, 30) if name == "stewart_trinkle" else (4, 8, 12, 16, 32):
            k = min(count, 400_000_000 // (8 * n * n))
            A, q = family(k, n)
            sols = lcpstar.solve_batch(A, q, threads=1)
            check(A, q, sols)
            calls = {
                "cold": lambda A=A, q=q, sols=sols: lcpstar.solve_batch(A, q, threads=1, out=sols),
                "warm": lambda A=A, q=q, sols=sols: lcpstar.solve_batch(A, q, threads=1, alpha0=sols.alpha, out=sols),
                "fresh": lambda A=A, q=q: lcpstar.solve_batch(A, q, threads=1),
                "sum": A.sum,
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
                f"| {rate['fresh']:.3f} | {rate['sum']:.1f} "
                f"| {beside:.3f} | {rate['cold'] / beside:.1f} | {100 * claimed:.2f} % |"
            )
            print(lines[-1], flush=True)
            data.append({"family": name, "n": n, "count": k, "rate": rate})
    return lines, data


def variants(count, repeats):
    """Single precision beside double, and one A with many q beside as many copies of it."""
    lines = ["| family | n | float64, M/s | float32, M/s |", "| --- | --- | --- | --- |"]
    more = ["| family | n | many A, M/s | one A, M/s | ratio |", "| --- | --- | --- | --- | --- |"]
    data = []
    for n in (4, 8, 12, 16, 32):
        k = min(count, 400_000_000 // (8 * n * n))
        A, q = FAMILIES["random_spd"](k, n)
        single, vector = A.astype(np.float32), q.astype(np.float32)
        check(single.astype(float), vector.astype(float), lcpstar.solve_batch(single, vector, threads=1))
        same = np.broadcast_to(A[0], A.shape)
        copies = np.ascontiguousarray(same)
        times = seconds(
            {
                "double": lambda A=A, q=q: lcpstar.solve_batch(A, q, threads=1),
                "single": lambda A=single, q=vector: lcpstar.solve_batch(A, q, threads=1),
                "copies": lambda A=copies, q=q: lcpstar.solve_batch(A, q, threads=1),
                "one": lambda A=A[0], q=q: lcpstar.solve_batch(A, q, threads=1),
            },
            repeats,
        )
        rate = {key: k / t / 1e6 for key, t in times.items()}
        lines.append(f"| random_spd | {n} | {rate['double']:.3f} | {rate['single']:.3f} |")
        more.append(
            f"| random_spd | {n} | {rate['copies']:.3f} | {rate['one']:.3f} | {rate['one'] / rate['copies']:.1f} |"
        )
        print(lines[-1], more[-1], flush=True)
        data.append({"variants": "random_spd", "n": n, "count": k, "rate": rate})
    return [*lines, "", *more], data


def corpus_batches(loops, repeats):
    """The published batches of contact problems."""
    folder = os.environ.get("LCPSTAR_CORPUS")
    if not folder:
        return [], []
    names = list(loops)
    lines = [
        "| batch | n | problems | lcpstar, us a problem | warm, us | " + " | ".join(f"{p}, us (right)" for p in names)
    ]
    lines[0] += " | " + " | ".join(f"{p}/lcpstar" for p in names) + " |"
    lines.append("| --- " * (5 + 2 * len(names)) + "|")
    data = []
    for path in sorted(Path(folder).glob("batch_*.npz")):
        file = np.load(path)
        A, q = np.ascontiguousarray(file["A"]), np.ascontiguousarray(file["q"])
        sols = lcpstar.solve_batch(A, q, threads=1)
        check(A, q, sols)
        calls = {
            "lcpstar": lambda A=A, q=q: lcpstar.solve_batch(A, q, threads=1),
            "warm": lambda A=A, q=q, alpha=sols.alpha: lcpstar.solve_batch(A, q, threads=1, alpha0=alpha),
        }
        share = {}
        for name, loop in loops.items():
            share[name] = 100 * right(A, q, loop(A, q)[0]).mean()
            calls[name] = lambda A=A, q=q, loop=loop: loop(A, q)
        times = {key: 1e6 * t / len(q) for key, t in seconds(calls, repeats).items()}
        ours = times["lcpstar"]
        row = [path.stem, str(q.shape[1]), str(len(q)), f"{ours:.2f}", f"{times['warm']:.2f}"]
        row += [f"{times[name]:.2f} ({share[name]:.0f} %)" for name in names]
        row += [f"{times[name] / ours:.1f}" for name in names]
        lines.append("| " + " | ".join(row) + " |")
        print(lines[-1], flush=True)
        data.append({"batch": path.stem, "times": times, "right": share})
    return lines, data


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    loops = available_loops()
    lines, data = synthetic(loops.get("quantecon"), options.count, options.repeats)
    kinds, kinds_data = variants(options.count, options.repeats)
    more, corpus = corpus_batches(loops, 10 * options.repeats)
    text = "\n".join([*lines, "", *kinds, "", *more])
    write_record(
        "batch",
        "Batches of small problems, one thread, processor time",
        shlex.join(["python", "benches/batch.py", *sys.argv[1:]]),
        text,
        [*data, *kinds_data, *corpus],
    )


if __name__ == "__main__":
    main()
