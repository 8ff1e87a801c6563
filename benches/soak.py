"""A long run that looks for leaks, crashes and half-finished answers: `make soak` (or `python benches/soak.py CALLS`).

* memory: resident size over a million calls of every public entry point, failing calls included;
* threads: many Python threads solve at once while one of them rewrites its own arrays;
* forks: children of a process that has solved with threads solve again;
* interrupts: SIGINT at random moments of `solve`, `solve_batch`, `solutions` and `classify`: either the whole answer or
  `KeyboardInterrupt`, never a part of an answer;
* shutdown: the interpreter ends while other threads are inside a batch.

Writes `benches/record/soak.md`. Everything it starts is its own child, with a time limit.
"""

from __future__ import annotations

import os
import pathlib
import platform
import random
import resource
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np

import lcpstar

ROOT = pathlib.Path(__file__).parents[1]
PAGE = resource.getpagesize()


def resident():
    """Resident memory in bytes."""
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * PAGE


def random_problem(rng, n):
    A = rng.integers(-3, 4, (n, n)).astype(float)
    kind = rng.integers(4)
    if kind == 0:
        A = A @ A.T
    elif kind == 1:
        A = A + np.diag(np.abs(A).sum(axis=1) + 1)
    elif kind == 2:
        A = A - A.T
    return A, rng.integers(-4, 3, n).astype(float)


def check(A, q, solution):
    if solution.success:
        w = A @ solution.z + q
        size = np.abs(A) @ solution.z + np.abs(q)
        assert (np.abs(np.minimum(solution.z, w)) <= 1e-8 * np.maximum(size, 1)).all(), (A, q, solution)


METHODS = ["auto", "lemke", "principal_pivoting", "block_pivoting", "interior_point", "enumerate", "bilinear"]


def one_call(k, rng):
    """Call number k: nineteen of twenty are plain solves, the rest goes round all entry points and kinds of failure."""
    n = int(rng.integers(0, 9))
    A, q = random_problem(rng, n)
    if k % 20:
        check(A, q, lcpstar.solve(A, q))
        return 1
    match k // 20 % 10:
        case 0:
            check(A, q, lcpstar.solve(A, q, method=METHODS[k // 200 % len(METHODS)]))
        case 1:
            check(A, q, lcpstar.solve(A, q, certify="exact"))
        case 2:
            sols = lcpstar.solve_batch(np.broadcast_to(A, (16, n, n)), rng.standard_normal((16, n)), threads=2)
            assert sols.z.shape == (16, n)
        case 3:
            lcpstar.solutions(A[:4, :4], q[:4], exact=k % 40 == 0)
        case 4 if n:
            lcpstar.classes.check(A[:4, :4].astype(int), "P")
        case 5:
            try:
                lcpstar.solve(A, np.full(n + 1, np.nan))
            except lcpstar.LCPError as error:
                str(error)
        case 6:
            lcpstar.verify(A, q, lcpstar.solve(A, q, method="lemke"))
        case 7:
            repr(lcpstar.solve(A, q, method="lemke", max_iterations=1).ray)
        case 8:
            try:
                lcpstar.ppt(A, list(range(n)))
            except lcpstar.errors.SingularBlockError as error:
                str(error)
        case 9:
            lcpstar.potential_reduction(A, q, max_iterations=5, trace=True)
    return 1


def memory(calls):
    """Resident memory after the first tenth of the calls and at the end."""
    rng = np.random.default_rng(0)
    sizes = []
    start = time.process_time()
    for k in range(calls):
        one_call(k, rng)
        if (k + 1) % (calls // 10) == 0:
            sizes.append(resident())
            print(f"{k + 1:9d} calls, {sizes[-1] / 2**20:.1f} MiB", flush=True)
    growth = sizes[-1] - sizes[0]
    assert growth < 4 * 2**20, f"memory grew by {growth} bytes in {calls} calls"
    first, last, spent = sizes[0] / 2**20, sizes[-1] / 2**20, time.process_time() - start
    return [
        f"memory: {calls} calls, {first:.1f} MiB after a tenth of them, {last:.1f} MiB at the end ({spent:.0f} s CPU)"
    ]


def threads(seconds):
    """Every thread checks its own answers against a copy of its own arrays; one writes into shared arrays meanwhile."""
    A, q = random_problem(np.random.default_rng(1), 8)
    A, q = np.repeat(A[None] + 8 * np.eye(8), 500, axis=0), np.repeat(q[None], 500, axis=0)
    stop, errors, counts = time.monotonic() + seconds, [], [0] * 8

    def work(me):
        try:
            rng = np.random.default_rng(me)
            while time.monotonic() < stop:
                if me == 0:  # the shared arrays change under the other threads' feet
                    A[rng.integers(500)] *= -1
                    continue
                if me % 2:
                    for k in range(200):
                        counts[me] += one_call(k, rng)
                else:
                    sols = lcpstar.solve_batch(A, q, threads=2)
                    assert sols.z.shape == (500, 8)
                    assert np.isfinite(sols.z).all()
                    counts[me] += 500
        except BaseException as error:
            errors.append(error)
            raise

    workers = [threading.Thread(target=work, args=(me,)) for me in range(8)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert not errors
    return [f"threads: 8 Python threads, {sum(counts)} problems, one of them writing into arrays that others solve"]


def forks(count):
    """Children of a process whose thread pools have run."""
    rng = np.random.default_rng(2)
    A, q = rng.standard_normal((64, 6, 6)) + 6 * np.eye(6), rng.standard_normal((64, 6))
    expected = lcpstar.solve_batch(A, q, threads=4).z.tobytes()
    lcpstar.classify(np.eye(3, dtype=int), threads=2)
    for k in range(count):
        child = os.fork()
        if child == 0:
            code = 1
            try:
                same = lcpstar.solve_batch(A, q, threads=4).z.tobytes() == expected
                verdict = lcpstar.classify(np.eye(3, dtype=int), ["P"], threads=2)["P"]
                code = 0 if same and verdict.holds and lcpstar.solve(A[k % 64], q[k % 64]).success else 2
            finally:
                os._exit(code)
        deadline = time.monotonic() + 60
        while True:
            pid, status = os.waitpid(child, os.WNOHANG)
            if pid:
                break
            if time.monotonic() > deadline:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
                raise AssertionError("a forked child hangs")
            time.sleep(0.005)
        assert os.waitstatus_to_exitcode(status) == 0, status
    return [f"forks: {count} children of a process with thread pools, same bits in each"]


INTERRUPTED = """
    import random, signal, sys, threading, time
    import numpy as np, lcpstar
    from lcpstar.problems import murty

    rng = np.random.default_rng(int(sys.argv[1]))
    pause = random.Random(int(sys.argv[1]))
    n, count = 6, 20000
    A, q = rng.standard_normal((count, n, n)) + n * np.eye(n), rng.standard_normal((count, n))
    whole = lcpstar.solve_batch(A, q)
    assert whole.success.all()
    M, p = murty(40)
    B, b = rng.standard_normal((24, 24)), rng.standard_normal(24)
    C = rng.integers(-3, 4, (7, 7))

    def batch():
        sols = lcpstar.solve_batch(A, q)
        assert sols.success.all() and sols.z.tobytes() == whole.z.tobytes(), "a part was passed as whole"

    def lemke():
        options = lcpstar.LemkeOptions(d=np.ones(40))
        lcpstar.solve(M, p, method="lemke", options=options, max_iterations=10**12)

    def exact():
        lcpstar.solve(B, b, certify="exact")

    def faces():
        lcpstar.solutions(B, b)

    def classes():
        lcpstar.classify(C)

    interrupts = answers = 0
    for k in range(int(sys.argv[2])):
        call = [batch, lemke, exact, faces, classes][k % 5]
        timer = threading.Timer(pause.expovariate(20) + 0.002, signal.raise_signal, [signal.SIGINT])
        try:
            timer.start()
            while True:  # again and again until the signal comes
                call()
                answers += 1
        except KeyboardInterrupt:
            interrupts += 1
        timer.join()
    print(interrupts, answers)
"""

SHUTDOWN = """
    import sys, threading, time
    import numpy as np, lcpstar
    from lcpstar.problems import murty

    rng = np.random.default_rng(0)
    A, q = rng.standard_normal((100000, 8, 8)) + 8 * np.eye(8), rng.standard_normal((100000, 8))
    M, p = murty(40)

    def batch():
        while True:
            lcpstar.solve_batch(A, q, threads=2)

    def lemke():
        lcpstar.solve(M, p, method="lemke", options=lcpstar.LemkeOptions(d=np.ones(40)), max_iterations=10**12)

    for call in (batch, batch, lemke):
        threading.Thread(target=call, daemon=True).start()
    time.sleep(float(sys.argv[1]))
    print("end", flush=True)
"""


def child(script, *arguments, limit=600):
    command = [sys.executable, "-c", textwrap.dedent(script), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)


def interrupts(count, seed=0):
    run = child(INTERRUPTED, seed, count)
    assert run.returncode == 0, run.stderr
    found, answers = map(int, run.stdout.split())
    assert found == count
    return [f"interrupts: {found} of {count} SIGINTs raised KeyboardInterrupt, {answers} whole answers between them"]


def shutdowns(count, seed=0):
    pause = random.Random(seed)
    for _ in range(count):
        run = child(SHUTDOWN, pause.random() * 0.3, limit=120)
        assert run.returncode == 0, (run.returncode, run.stderr)
        assert run.stdout == "end\n"
        assert run.stderr == "", run.stderr
    return [f"shutdown: the interpreter ended {count} times while three threads were inside the core"]


def main():
    calls = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    part = max(1, calls // 20_000)
    lines = [*memory(calls), *threads(part), *forks(4 * part), *interrupts(4 * part), *shutdowns(part)]
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout
    text = [
        "# Soak run",
        "",
        f"`python benches/soak.py {calls}` at commit {commit.strip()}, {platform.platform()}, Python "
        f"{platform.python_version()}, NumPy {np.__version__}.",
        "",
        *(f"* {line}" for line in lines),
    ]
    (ROOT / "benches" / "record" / "soak.md").write_text("\n".join(text) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
