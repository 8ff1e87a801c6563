"""`lcpstar bench call`: what one call of `solve` costs on this machine, by size, cold and with last step's answer."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from statistics import median

import numpy as np

from .. import problems
from ..batch import solve_batch
from ..problems import Problem
from ..solve import solve
from .families import previous_step
from .measure import clock, machine, seconds
from .report import duration

_CASES: tuple[tuple[str, Callable[[int], Problem], tuple[int, ...]], ...] = (
    ("random, unsymmetric PD", lambda n: problems.random_pd(n, 1), (2, 8, 16, 64, 256)),
    ("stack of boxes", lambda n: problems.box_stack(n // 4, seed=1), (8, 16, 64, 200)),
    ("contacts with friction", lambda n: problems.stewart_trinkle(n // 6, 1), (6, 24, 96, 240)),
)
_PASSES = 7


def run(quick: bool = False) -> str:
    """The table as text: one call cold, one call from the previous answer, one problem of a batch of 256."""
    lines = [
        machine(),
        "",
        f"{'family':<24}{'n':>5}{'cold':>10}{'warm':>10}{'in a batch of 256':>20}   answered by",
    ]
    budget = 2e-3 if quick else 2e-2
    for title, build, sizes in _CASES:
        for n in sizes[:2] if quick else sizes:
            A, q = build(n)
            z0 = solve(*previous_step(A, q, 1)).z
            calls: dict[str, Callable[[], object]] = {"cold": partial(solve, A, q), "warm": partial(solve, A, q, z0=z0)}
            if n <= 32:
                calls["batch"] = partial(solve_batch, np.repeat(A[None], 256, axis=0), np.repeat(q[None], 256, axis=0))
            times = _interleaved(calls, budget)
            batch = duration(times["batch"] / 256) if "batch" in times else ""
            cold, warm = duration(times["cold"]), duration(times["warm"])
            lines.append(f"{title:<24}{len(q):>5}{cold:>10}{warm:>10}{batch:>20}   {solve(A, q).method}")
    return "\n".join(lines)


def _interleaved(calls: dict[str, Callable[[], object]], budget: float) -> dict[str, float]:
    once = {}
    for name, call in calls.items():
        call()
        start = clock()
        call()
        once[name] = clock() - start
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(_PASSES):
        for name, call in calls.items():
            times[name].append(seconds(call, budget / _PASSES, once[name]))
    return {name: median(values) for name, values in times.items()}
