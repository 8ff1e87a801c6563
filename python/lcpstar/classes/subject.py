"""The matrix under examination: exact entries, the compiled kernel on their integer multiple, what is known."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cached_property
from typing import Any

from .._core import IntegerMatrix
from ..errors import TooLargeError
from .exact import IndexSet, Rows, pivot_transform, principal, subsets, transpose
from .table import find_class
from .verdict import Cost, Finding, Verdict


class UndecidedError(Exception):
    """An answer rests on a class that the budget left open; carries the reason and how far the search got."""


class Subject:
    """A square rational matrix with memory: kernels and verdicts are computed once.

    Every class keeps its verdict when A is multiplied by a positive number, so the kernels work on integers.
    """

    def __init__(
        self,
        rows: Rows | Callable[[], Rows],
        deadline: float | None = None,
        kernel: IntegerMatrix | None = None,
        scale: int | None = None,
        order: int | None = None,
    ):
        self._given = rows
        self._kernel = kernel
        self._scale = scale
        self._order = order
        self.deadline = deadline
        self.verdicts: dict[str, Verdict] = {}
        self._facts: dict[tuple[Any, ...], Any] = {}
        self._parts: dict[IndexSet | str, Subject] = {}
        self._transforms: list[tuple[IndexSet, Subject]] | None = None

    @cached_property
    def rows(self) -> Rows:
        """Exact entries."""
        return self._given() if callable(self._given) else self._given

    @cached_property
    def n(self) -> int:
        """The order."""
        return len(self.rows) if self._order is None else self._order

    @cached_property
    def scale(self) -> int:
        """The kernel holds this times A."""
        return math.lcm(*(x.denominator for row in self.rows for x in row)) if self._scale is None else self._scale

    @cached_property
    def kernel(self) -> IntegerMatrix:
        """`scale` times A in the compiled core."""
        if self._kernel is not None:
            return self._kernel
        scale = self.scale
        return IntegerMatrix(self.n, [x.numerator * (scale // x.denominator) for row in self.rows for x in row])

    def ask(self, question: str, *arguments: Any) -> Any:
        """A kernel's answer, remembered. Raises TimeoutError(done, total) when the budget is spent."""
        key = (question, *arguments)
        if key not in self._facts:
            left = None if self.deadline is None else max(0.0, self.deadline - time.monotonic())
            self._facts[key] = getattr(self.kernel, question)(*arguments, time_limit=left)
        return self._facts[key]

    def poll(self, done: int, total: int) -> None:
        """Called in loops over parts, each of which may be too small to look at the clock."""
        if self.deadline is not None and time.monotonic() > self.deadline:
            raise TimeoutError(done, total)

    def verdict(self, symbol: str) -> Verdict:
        """The verdict for another class, remembered."""
        if symbol not in self.verdicts:
            self.verdicts[symbol] = _evaluate(self, symbol)
        return self.verdicts[symbol]

    def decided(self, symbol: str) -> Verdict:
        """As `verdict`, but one that is True or False; `UndecidedError` when the budget does not reach that far."""
        verdict = self.verdict(symbol)
        if verdict.holds is None:
            raise UndecidedError(f"{symbol} is open: {verdict.reason}", verdict.cost)
        return verdict

    def principal(self, alpha: IndexSet) -> Subject:
        """A[alpha, alpha] as a subject."""
        if len(alpha) == self.n:
            return self
        if alpha not in self._parts:
            kernel = self.kernel.principal(list(alpha))
            self._parts[alpha] = Subject(
                lambda: principal(self.rows, alpha), self.deadline, kernel, self.scale, len(alpha)
            )
        return self._parts[alpha]

    def principals(self) -> Iterator[tuple[IndexSet, Subject]]:
        """All principal submatrices, smaller ones first."""
        for done, alpha in enumerate(subsets(self.n)):
            self.poll(done, 2**self.n - 1)
            yield alpha, self.principal(alpha)

    def transforms(self) -> list[tuple[IndexSet, Subject]]:
        """All legitimate principal pivot transforms M up to scaling DMD by a positive diagonal D; A itself first.

        Verdicts carry over to M; witnesses do only when `scale` is 1 (see `transform`).
        """
        if self._transforms is None:
            self._transforms = [
                (tuple(alpha), self._transformed(kernel) if alpha else self) for alpha, kernel in self.ask("transforms")
            ]
        return self._transforms

    def _transformed(self, kernel: IntegerMatrix) -> Subject:
        n = self.n

        def rows() -> Rows:
            entries = kernel.entries()
            return tuple(tuple(Fraction(v) for v in entries[i * n : (i + 1) * n]) for i in range(n))

        return Subject(rows, self.deadline, kernel, 1, n)

    def transform(self, alpha: IndexSet, scaled: Subject) -> Subject:
        """The transform on alpha up to a positive number: witnesses carry over. `scaled` is from `transforms`."""
        if self.scale == 1 or not alpha:
            return scaled
        M = pivot_transform(self.rows, alpha)
        assert M is not None
        return Subject(M, self.deadline)

    @property
    def transposed(self) -> Subject:
        """A' as a subject."""
        if "transpose" not in self._parts:
            self._parts["transpose"] = Subject(
                lambda: transpose(self.rows), self.deadline, self.kernel.transpose(), self.scale, self.n
            )
        return self._parts["transpose"]


def _evaluate(subject: Subject, symbol: str) -> Verdict:
    """The verdict of one class on a subject; a spent budget makes it undecided."""
    which = find_class(symbol)
    if which.limit is not None and subject.n > which.limit:
        raise TooLargeError(f"class {which.symbol} takes n <= {which.limit}, got n = {subject.n}")
    start = time.perf_counter()
    done = total = 0
    try:
        finding = which.decide(subject)
    except TimeoutError as stopped:
        done, total = (*stopped.args, 0, 0)[:2]
        how_far = f" after {done} of {total} index sets of the last search" if total else ""
        finding = Finding(None, f"the time limit passed{how_far}")
    except UndecidedError as left_open:
        reason, inner = left_open.args
        finding, done, total = Finding(None, reason), inner.done, inner.total
    cost = Cost(time.perf_counter() - start, done, total)
    return Verdict(
        finding.holds,
        which.symbol,
        which.name,
        finding.witness,
        cost,
        subject.rows,
        finding.reason,
        finding.certificate,
    )
