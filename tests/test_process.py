"""Threads, signals, panics: the interpreter keeps running."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
import threading
import time

import lcpstar
import numpy as np


def slow_problem(n):
    """Murty's example: Lemke's method with d = e needs 2^n - 1 pivots."""
    A = np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)
    return A, -np.array([sum(2.0 ** (n - k) for k in range(i)) for i in range(1, n + 1)])


def test_time_limit_is_kept():
    A, q = slow_problem(30)
    options = lcpstar.LemkeOptions(d=np.ones(30))
    start = time.perf_counter()
    solution = lcpstar.solve(A, q, method="lemke", options=options, max_iterations=10**9, time_limit=0.2)
    assert time.perf_counter() - start < 0.5
    assert solution.status == "time_limit"


def test_other_threads_run_during_a_solve():
    A, q = slow_problem(30)
    options = lcpstar.LemkeOptions(d=np.ones(30))

    def work():
        lcpstar.solve(A, q, method="lemke", options=options, max_iterations=10**9, time_limit=0.5)

    thread = threading.Thread(target=work)
    thread.start()
    time.sleep(0.05)
    ticks = 0
    while thread.is_alive():
        ticks += 1
        time.sleep(0.001)
    assert ticks > 50


def test_ctrl_c_stops_a_long_solve():
    script = """
        import numpy as np, lcpstar
        n = 40
        A = np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)
        q = -np.array([sum(2.0 ** (n - k) for k in range(i)) for i in range(1, n + 1)])
        print("ready", flush=True)
        try:
            lcpstar.solve(A, q, method="lemke", options=lcpstar.LemkeOptions(d=np.ones(n)), max_iterations=10**12)
        except KeyboardInterrupt:
            print("interrupted", flush=True)
    """
    process = subprocess.Popen([sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=5)
    assert output == "interrupted\n"


def test_import_is_light():
    script = "import sys, numpy; before = set(sys.modules); import lcpstar; print(sorted(set(sys.modules) - before))"
    modules = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert "scipy" not in modules
    assert "matplotlib" not in modules
