"""What one call of `lcpstar.solve` costs from Python, beside QuantEcon's `lcp_lemke`, one of `solve_batch` for a few
problems, and how calls in two threads scale: `python benches/call.py`."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

import lcpstar
from harness import residual, seconds_per_call, write_record
from lcpstar.problems import random_pd, random_spd
from peers import available


def elapsed(work: Callable[[], None], threads: int) -> float:
    """Wall clock while each of so many threads does the work once."""
    workers = [threading.Thread(target=work) for _ in range(threads)]
    start = time.perf_counter()
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return time.perf_counter() - start


def scaling(work: Callable[[], None]) -> float:
    """Work per second of two threads by that of one; the median of seven."""
    work()
    return float(np.median([2 * elapsed(work, 1) / elapsed(work, 2) for _ in range(7)]))


def two_threads() -> tuple[str, list[dict[str, float | int]]]:
    lines = ["| random_pd, n | two threads by one |", "| --- | --- |"]
    data = []
    for n, calls in ((16, 20_000), (32, 10_000), (64, 4000), (128, 1000), (200, 500), (500, 40)):
        A, q = random_pd(n, seed=1)

        def work(A=A, q=q, calls=calls):
            for _ in range(calls):
                lcpstar.solve(A, q)

        data.append({"n": n, "scaling": scaling(work)})
        lines.append(f"| {n} | {data[-1]['scaling']:.2f} |")
    return "\n".join(lines), data


def small_batches() -> tuple[str, list[dict[str, object]]]:
    """What one call of `solve_batch` costs for a few problems, threads as by default."""
    lines = ["| random_pd, n | problems | solve_batch | with `out=` | as many calls of solve |"]
    lines.append("| --- | --- | --- | --- | --- |")
    data: list[dict[str, object]] = []
    for n in (4, 8, 12):
        for count in (1, 16, 128):
            problems = [random_pd(n, seed=seed) for seed in range(count)]
            A, q = (np.stack(arrays) for arrays in zip(*problems, strict=True))
            sols = lcpstar.solve_batch(A, q)
            assert sols.success.all()
            times = seconds_per_call(
                {
                    "batch": lambda A=A, q=q: lcpstar.solve_batch(A, q),
                    "out": lambda A=A, q=q, sols=sols: lcpstar.solve_batch(A, q, out=sols),
                    "calls": lambda problems=problems: [lcpstar.solve(A, q) for A, q in problems],
                }
            )
            lines.append(f"| {n} | {count} | " + " | ".join(f"{1e6 * t:.1f} us" for t in times.values()) + " |")
            data.append({"n": n, "count": count, "times": times})
    return "\n".join(lines), data


def main() -> None:
    peers = available(["quantecon"])
    lines = ["| problem | n | lcpstar.solve | quantecon lcp_lemke | ratio |", "| --- | --- | --- | --- | --- |"]
    data = []
    for family in (random_pd, random_spd):
        for n in (1, 2, 4, 8, 12, 16):
            A, q = family(n, seed=1)
            assert residual(A, q, lcpstar.solve(A, q).z) < 1e-9
            calls = {"lcpstar": lambda A=A, q=q: lcpstar.solve(A, q)}
            calls |= {name: lambda A=A, q=q, peer=peer: peer(A, q) for name, (peer, _) in peers.items()}
            times = seconds_per_call(calls)
            beside = times.get("quantecon", float("nan"))
            ours = times["lcpstar"]
            lines.append(
                f"| {family.__name__} | {n} | {1e6 * ours:.2f} us | {1e6 * beside:.2f} us | {beside / ours:.2f} |"
            )
            data.append({"family": family.__name__, "n": n, "times": times})
    batches, batch_data = small_batches()
    threads, thread_data = two_threads()
    body = (
        "\n".join(lines) + f"\n\n## Small batches\n\n{batches}" + "\n\n## Two threads of one interpreter\n\n"
        "Wall clock, on two cores. Up to n = 16 a call holds the interpreter's lock: it takes less time than handing "
        f"the lock over would; `solve_batch` is for those.\n\n{threads}"
    )
    records = {"calls": data, "batches": batch_data, "threads": thread_data}
    write_record("call", "One call of solve", "python benches/call.py", body, records)


if __name__ == "__main__":
    main()
