"""Timing that can be compared: interleaved repetitions in one process, medians, every answer checked."""

from __future__ import annotations

import json
import platform
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import lcpstar

RECORD = Path(__file__).parent / "record"


def seconds_per_call(
    calls: dict[str, Callable[[], object]],
    budget: float = 0.3,
    rounds: int = 7,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, float]:
    """Median seconds per call of each, measured in turns; `budget` seconds for each.

    `clock=time.thread_time` counts what this thread computes: the same on a busy machine, for calls of one thread.
    """
    repeats, left = {}, {}
    for name, call in calls.items():
        call()
        start = clock()
        call()
        once = max(clock() - start, 1e-7)
        repeats[name] = max(1, min(20_000, int(budget / (rounds + 2) / once)))
        left[name] = max(1, min(rounds, int(2 * budget / once)))
    times: dict[str, list[float]] = {name: [] for name in calls}
    for turn in range(rounds):
        for name, call in calls.items():
            if turn < left[name]:
                start = clock()
                for _ in range(repeats[name]):
                    call()
                times[name].append((clock() - start) / repeats[name])
    return {name: float(np.median(t)) for name, t in times.items()}


def residual(A, q, z) -> float:
    """`max |min(z', w')| / max(1, max|z'|)` on a problem equilibrated in the max norm: the same yardstick for all."""
    if z is None or not np.all(np.isfinite(z)):
        return np.inf
    rows, columns = np.ones(len(q)), np.ones(len(q))
    for _ in range(20):
        B = rows[:, None] * np.abs(A) * columns
        rows /= np.sqrt(np.maximum(B.max(axis=1), 1e-300))
        columns /= np.sqrt(np.maximum(B.max(axis=0), 1e-300))
    scale = 1 / max(np.abs(rows * q).max(), 1e-300)
    u = scale * z / columns
    v = scale * rows * (A @ z + q)
    return float(np.abs(np.minimum(u, v)).max() / max(1.0, np.abs(u).max()))


def environment(command: str) -> str:
    """Where and how a record was made."""
    model = next(
        (line.split(":")[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines() if "model name" in line),
        platform.processor(),
    )
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout
    return (
        f"Machine: {model}, {platform.system()}, Python {sys.version.split()[0]}, NumPy {np.__version__}, "
        f"lcpstar {lcpstar.__version__} at commit {commit.strip() or 'unknown'}. One thread. Command: `{command}`.\n"
        "Shared machine: read ratios, not single times; anything below 1.5x is a tie."
    )


def write_record(name: str, title: str, command: str, body: str, data: object | None = None) -> None:
    """`benches/record/NAME.md`, and `.json` when there is data."""
    RECORD.mkdir(exist_ok=True)
    (RECORD / f"{name}.md").write_text(f"# {title}\n\n{environment(command)}\n\n{body}\n", encoding="utf-8")
    if data is not None:
        (RECORD / f"{name}.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    print(f"# {title}\n\n{body}\n")
