"""Symbols, names and predicates: `check(A, "E0s")`, `is_semimonotone_star(A)` and the command line are one thing."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from typing import Any

from ..coerce import as_seconds
from .exact import read_matrix
from .subject import Subject
from .table import CLASSES, MatrixClass, Predicate, PublicCheck, find_class
from .verdict import Verdict


def predicate(symbol: str, name: str, limit: int | None = 40) -> Callable[[Predicate], PublicCheck]:
    """Registers a predicate and returns the public function that reads A, keeps time and makes a Verdict."""

    def register(decide: Predicate) -> PublicCheck:
        @functools.wraps(decide)
        def public(A: Any, *, time_limit: float | None = None) -> Verdict:
            return check(A, symbol, time_limit=time_limit)

        public.__annotations__ = {"A": Any, "time_limit": "float | None", "return": Verdict}
        del public.__wrapped__
        CLASSES[symbol] = MatrixClass(symbol, name, decide, limit, public)
        return public

    return register


def make_subject(A: Any, time_limit: float | None) -> Subject:
    """Reads A and starts the clock."""
    limit = as_seconds("time_limit", time_limit)
    rows = read_matrix(A)
    return Subject(rows, None if limit is None else time.monotonic() + limit)


def check(A: Any, symbol: str, *, time_limit: float | None = None) -> Verdict:
    """Decide exactly whether A belongs to one class.

    Parameters
    ----------
    A : (n, n) array_like
        Integers, floats (read as the binary rationals they are), `Fraction`, or strings like `"1/3"`. Copied.
    symbol : str
        A symbol of `lcpstar.classes.CLASSES`, e.g. `"E0s"`, or `"C0(2)"`, `"C0f(2)"` (exact order k).
    time_limit : float, optional
        Seconds; when they are over, `holds` is None and `reason` says how far the search got.

    Returns
    -------
    Verdict

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError, UnknownNameError, OptionError, TooLargeError
        Subclasses of LCPError.

    Notes
    -----
    Deciding most of these classes is co-NP-hard; each `is_...` function states its cost.

    Examples
    --------
    >>> verdict = check([[0, 1, 1], [2, 0, 1], [-4, -5, 0]], "cE0s")
    >>> verdict.holds, verdict.witness.alpha, verdict.check()
    (False, (0, 1), True)
    """
    return make_subject(A, time_limit).verdict(find_class(symbol).symbol)
