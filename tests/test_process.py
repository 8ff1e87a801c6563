"""Threads, signals, panics: the interpreter keeps running."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np

import lcpstar
from lcpstar.problems import murty


def test_time_limit_is_kept():
    A, q = murty(30)
    options = lcpstar.LemkeOptions(d=np.ones(30))
    start = time.perf_counter()
    solution = lcpstar.solve(A, q, method="lemke", options=options, max_iterations=10**9, time_limit=0.2)
    assert time.perf_counter() - start < 0.5
    assert solution.status == "time_limit"


def test_other_threads_run_during_a_solve():
    A, q = murty(30)
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
        import signal, numpy as np, lcpstar
        from lcpstar.problems import murty
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
        n = 40
        A, q = murty(n)
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
