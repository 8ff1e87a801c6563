"""The islands of a step, solved: small ones together in a batch, larger ones one by one."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..batch import solve_batch
from ..coerce import Vector
from ..options import MethodOptions
from ..solve import solve
from .assembly import Island

#: Islands up to this order go to `solve_batch`, alone or not, so that their bits do not depend on the company.
BATCH_ORDER = 20


@dataclass(frozen=True)
class Solving:
    """Arguments of `lcpstar.solve` for every island; `time_limit` [s] is for all LCPs of a step together."""

    method: str = "auto"
    tol: float = 1e-9
    max_iterations: int | None = None
    time_limit: float | None = None
    options: MethodOptions | None = None
    warm_start: bool = True

    @property
    def batches(self) -> bool:
        """Whether small islands may be solved in one batch."""
        return self.method == "auto" and self.max_iterations is None and self.time_limit is None


@dataclass(frozen=True, eq=False)
class Answer:
    """What is kept of an island's solution."""

    z: Vector
    success: bool
    method: str
    iterations: int
    residual: float
    natural_residual: float


def solve_islands(
    islands: Sequence[Island], guesses: Sequence[Vector | None], settings: Solving, deadline: float | None
) -> list[Answer]:
    """An answer per island; those that are not solved by the deadline (of `perf_counter`) keep the best point found."""
    answers: list[Answer | None] = [None] * len(islands)
    small = []
    for k, island in enumerate(islands):
        if not len(island.q):
            answers[k] = Answer(np.zeros(0), True, "trivial", 0, 0.0, 0.0)
        elif settings.batches and len(island.q) <= BATCH_ORDER:
            small.append(k)
    if small:
        z0 = [_guess(guesses[k], islands[k]) for k in small]
        for k, answer in zip(small, _batch([islands[k] for k in small], z0, settings.tol), strict=True):
            answers[k] = answer
    for k, island in enumerate(islands):
        if answers[k] is None:
            left = None if deadline is None else max(1e-9, deadline - time.perf_counter())
            answers[k] = _one(island, guesses[k], settings, left)
    return [answer for answer in answers if answer is not None]


def _guess(guess: Vector | None, island: Island) -> Vector:
    return np.zeros(len(island.q)) if guess is None else guess


def _batch(islands: Sequence[Island], z0: list[Vector], tol: float) -> list[Answer]:
    sols = solve_batch([(island.A, island.q) for island in islands], tol=tol, threads=1, z0=z0)
    ends = np.concatenate([[0], np.cumsum([len(island.q) for island in islands])])
    methods = sols.method
    return [
        Answer(
            sols.z[ends[k] : ends[k + 1]],
            bool(sols.success[k]),
            str(methods[k]),
            int(sols.iterations[k]),
            float(sols.residual[k]),
            float(sols.natural_residual[k]),
        )
        for k in range(len(islands))
    ]


def _one(island: Island, guess: Vector | None, settings: Solving, time_limit: float | None) -> Answer:
    s = solve(
        island.A,
        island.q,
        method=settings.method,
        tol=settings.tol,
        max_iterations=settings.max_iterations,
        time_limit=time_limit,
        z0=guess,
        options=settings.options,
    )
    return Answer(s.z, s.success, s.method, s.iterations, s.residual, s.natural_residual)
