"""What exact verdicts cost: `python benches/classes.py`. Wall clock, medians; no peer decides these classes."""

from __future__ import annotations

import time

import numpy as np

import lcpstar
from harness import write_record
from lcpstar import classes

ALL_BUT_EC = [symbol for symbol in classes.CLASSES if symbol != "Ec"]


def seconds(call, repeats=1):
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def boundary_matrices(n, count):
    """Small integers: most are on the boundary of some class."""
    rng = np.random.default_rng(n)
    return [rng.integers(-2, 3, (n, n)).tolist() for _ in range(count)]


def unstructured_p_matrix(n):
    """Triangular with a positive diagonal: P, and no sufficient test short of the minors says so."""
    rng = np.random.default_rng(n)
    A = np.triu(rng.integers(-9, 10, (n, n)), 1) + np.diag(rng.integers(1, 10, n))
    return A.tolist()


def copositive_matrix(n):
    """Positive semidefinite plus nonnegative, on small integers."""
    rng = np.random.default_rng(n)
    B = rng.integers(-2, 3, (n, n // 2))
    return (B @ B.T + np.abs(rng.integers(-3, 4, (n, n)))).tolist()


def main() -> None:
    rows = []
    for n, count in ((3, 300), (4, 150)):
        matrices = boundary_matrices(n, count)
        times = [seconds(lambda A=A: lcpstar.classify(A, classes=ALL_BUT_EC)) for A in matrices]
        rows.append((f"classify, all classes but Ec, n = {n}, {count} matrices", np.median(times), max(times)))
        times = [seconds(lambda A=A: classes.check(A, "Ec")) for A in matrices[:100]]
        rows.append((f"Ec, n = {n}, 100 matrices", np.median(times), max(times)))
    for symbol, n, build in (
        ("P", 20, unstructured_p_matrix),
        ("P0", 20, unstructured_p_matrix),
        ("P", 24, unstructured_p_matrix),
        ("E0", 14, copositive_matrix),
        ("C0", 14, copositive_matrix),
    ):
        A = build(n)
        assert classes.check(A, symbol).holds
        t = seconds(lambda A=A, symbol=symbol: classes.check(A, symbol), 3)
        rows.append((f"{symbol} on small integers, n = {n}, holds", t, t))
    A = np.random.default_rng(0).random((14, 14)) - 0.1 + np.eye(14)
    t = seconds(lambda: classes.check(A, "E0"), 3)
    rows.append(("E0 on floats, n = 14", t, t))
    for claim in ("E0 & Q0 => cQ0", "Q0 => cQ0", "tE0s & v > 0 => R0 & Q"):
        t = seconds(lambda claim=claim: lcpstar.explore(claim, n=3, entries=range(-2, 3), samples=100_000, seed=1))
        rows.append((f"explore 100 000 matrices, n = 3: {claim}", t, t))
    lines = ["| what | median | worst |", "| --- | --- | --- |"]
    lines += [f"| {name} | {1e3 * median:.3g} ms | {1e3 * worst:.3g} ms |" for name, median, worst in rows]
    write_record("classes", "Exact verdicts", "python benches/classes.py", "\n".join(lines))


if __name__ == "__main__":
    main()
