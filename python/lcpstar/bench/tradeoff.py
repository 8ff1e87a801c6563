"""`lcpstar bench tradeoff`: every method at every tolerance on every family, time against the accuracy achieved."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from statistics import median

from .._core import Solution
from ..coerce import Matrix, Vector
from ..solve import solve
from . import families
from .families import Group
from .measure import Yardstick, clock, seconds
from .methods import Entry
from .table import Row

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14)
QUICK_TOLERANCES = (1e-2, 1e-6, 1e-12)
WARM_TOLERANCES = (1e-1, 1e-3, 1e-6, 1e-12)
CORPUS_TOLERANCES = (1e-1, 1e-3, 1e-6, 1e-10, 1e-12)
PROOF_TOLERANCES = (1e-10,)  # a proof does not depend on it
SWEEP_TOLERANCES = (1e-8,)
STARTS = ("cold", "warm")

_TIME_LIMIT = 0.25  # seconds for one solve of the grid
_SWEEP_TIME_LIMIT = 0.1  # seconds for one solve of a success map
_PASSES = 5
_PASS_BUDGET = 1.5e-3  # seconds of repeated calls for one instance in one pass
_TOO_SLOW_TO_REPEAT = 0.05


@dataclass
class _Case:
    """One instance with what a method may start from and what judges it."""

    A: Matrix
    q: Vector
    z0: Vector | None
    yardstick: Yardstick


@dataclass
class _Cell:
    """A method at a tolerance: its answers on each case, and times per pass."""

    entry: Entry
    tol: float
    time_limit: float | None
    solutions: list[Solution] = field(default_factory=list)
    once: list[float] = field(default_factory=list)
    passes: list[list[float]] = field(default_factory=list)

    def run(self, cases: Sequence[_Case]) -> None:
        for case in cases:
            call = self.entry.call(case.A, case.q, self.tol, self.time_limit, case.z0)
            start = clock()
            self.solutions.append(call())
            self.once.append(clock() - start)
            self.passes.append([])

    def repeat(self, cases: Sequence[_Case]) -> None:
        for case, once, passes in zip(cases, self.once, self.passes, strict=True):
            if once <= _TOO_SLOW_TO_REPEAT:
                call = self.entry.call(case.A, case.q, self.tol, self.time_limit, case.z0)
                passes.append(seconds(call, _PASS_BUDGET, once))

    @property
    def hopeless(self) -> bool:
        """Slow and solved nowhere: a tighter tolerance can only be slower."""
        return max(self.once) > _TOO_SLOW_TO_REPEAT and not any(solution.success for solution in self.solutions)

    def row(self, family: str, group: Group, start: str, cases: Sequence[_Case]) -> Row:
        times = [median(passes) if passes else once for passes, once in zip(self.passes, self.once, strict=True)]
        answers = list(zip(cases, self.solutions, strict=True))
        return Row(
            family=family,
            problem=group.problem,
            n=group.n,
            parameter=group.parameter,
            method=self.entry.name,
            start=start,
            tol=self.tol,
            instances=len(cases),
            solved=sum(solution.success for solution in self.solutions),
            seconds=median(times),
            residual=max(case.yardstick.residual(solution.z) for case, solution in answers),
            stated=max(solution.residual for solution in self.solutions),
            iterations=int(median(solution.iterations for solution in self.solutions)),
            status=str(next((s.status for s in self.solutions if not s.success), self.solutions[0].status)),
            answered_by=self.solutions[0].method,
        )


def run(
    names: Sequence[str], entries: Sequence[Entry], quick: bool = False, budget: float = 480.0, progress: bool = False
) -> Iterator[Row]:
    """Measure; yields the rows group by group.

    Every cell is run once; then all cells of a group are timed again in turns, up to five times, while the group's
    share of `budget` seconds lasts. A method that is slow and solves nothing at one tolerance is not tried at tighter
    ones. Single methods get a time limit; auto gets none, because it chooses by it.
    """
    todo = [
        (name, group, start)
        for name in names
        for group in families.groups(name, quick)
        for start in (STARTS[:1] if name in families.COLD_ONLY else STARTS)
    ]
    begin = time.monotonic()
    for index, (name, group, start) in enumerate(todo):
        left = begin + budget - time.monotonic()
        share = max(0.0, left) / (len(todo) - index)
        if progress:
            line = f"{index + 1}/{len(todo)} {name} {group.problem} {start}, {time.monotonic() - begin:.0f} s"
            print(line, file=sys.stderr, flush=True)
        yield from _measure(name, group, start, entries, quick, share)


def _measure(name: str, group: Group, start: str, entries: Sequence[Entry], quick: bool, share: float) -> list[Row]:
    deadline = time.monotonic() + share
    cases = [_case(A, q, start, seed) for seed, (A, q) in enumerate(group.instances)]
    sweep = name in families.SWEEPS
    tolerances = _tolerances(name, start, quick)
    cells: list[_Cell] = []
    for entry in entries:
        if entry.rung != "float64" and start == "warm":
            continue
        limit = None if entry.kind == "auto" else _SWEEP_TIME_LIMIT if sweep else _TIME_LIMIT
        for tol in tolerances if entry.rung != "exact" else PROOF_TOLERANCES:
            cell = _Cell(entry, tol, limit)
            cell.run(cases)
            cells.append(cell)
            if cell.hopeless:
                break
    for _ in range(_PASSES):
        for cell in cells:
            if time.monotonic() > deadline:
                break
            cell.repeat(cases)
    return [cell.row(name, group, start, cases) for cell in cells]


def _tolerances(name: str, start: str, quick: bool) -> tuple[float, ...]:
    if name in families.SWEEPS:
        return SWEEP_TOLERANCES
    if quick:
        return QUICK_TOLERANCES
    if start == "warm":
        return WARM_TOLERANCES
    return CORPUS_TOLERANCES if name == families.CORPUS_CONTACT else TOLERANCES


def _case(A: Matrix, q: Vector, start: str, seed: int) -> _Case:
    z0 = None
    if start == "warm":
        before = families.previous_step(A, q, seed)
        z0 = solve(*before).z
    return _Case(A, q, z0, Yardstick(A, q))
