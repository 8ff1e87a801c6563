"""Symbols, names and predicates: `check(A, "E0s")`, `is_semimonotone_star(A)` and the command line are one thing."""

from __future__ import annotations

import functools
import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from ..coerce import as_seconds, as_text
from ..errors import TooLargeError, UnknownNameError
from .exact import read_matrix
from .subject import Subject, UndecidedError
from .verdict import Cost, Finding, Verdict

Predicate = Callable[[Subject], Finding]


@dataclass(frozen=True)
class MatrixClass:
    """A class: its symbol, its name, its predicate, and the largest order the exponential search is offered for."""

    symbol: str
    name: str
    decide: Predicate
    limit: int | None
    check: PublicCheck


class PublicCheck(Protocol):
    """`is_...(A, time_limit=None) -> Verdict`."""

    def __call__(self, A: Any, *, time_limit: float | None = None) -> Verdict:
        """Decide membership of A."""
        ...


CLASSES: dict[str, MatrixClass] = {}

# The order of the paper, in which everything is listed.
_ORDER = (
    *(
        "PD",
        "PSD",
        "CSU",
        "RSU",
        "SU",
        "P",
        "P0",
        "N",
        "N0",
        "C0",
        "C",
        "C0+",
        "C0*",
        "E0",
        "E",
        "L2",
        "L",
        "PM",
        "PSBD",
    ),
    *("C0f", "E0f", "almost-P0", "almost-P", "almost-N0", "almost-N", "almost-C0", "almost-E", "almost-C0f", "Z", "K0"),
    *("Ec", "R", "R0", "Qb", "Q", "Q0", "cQ", "cQ0", "E0s", "cE0s", "tE0s", "ctE0s", "++"),
)


def list_in_order() -> None:
    """Sorts `CLASSES` once all predicates are registered."""
    for symbol in _ORDER:
        CLASSES[symbol] = CLASSES.pop(symbol)


# Other spellings in use; the paper's notation is on the left of each comment.
ALIASES = {
    "column sufficient": "CSU",
    "row sufficient": "RSU",
    "sufficient": "SU",
    "C0star": "C0*",
    "C0plus": "C0+",
    "C0^*": "C0*",
    "C0^+": "C0+",
    "C0^f": "C0f",
    "E0^f": "E0f",
    "E0^s": "E0s",
    "t-E0s": "tE0s",
    "~E0s": "tE0s",
    "completely Q": "cQ",
    "completely Q0": "cQ0",
    "(++)": "++",
    "E_c": "Ec",
    "Q_b": "Qb",
    "E1": "L2",
    "M0": "K0",
}
_EXACT_ORDER = re.compile(r"(C0f?)\((?:k=)?(\d+)\)")


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


def find_class(symbol: str, argument: str = "symbol") -> MatrixClass:
    """The class of a symbol or of another spelling of it; `C0(k)` and `C0f(k)` for every k >= 0."""
    symbol = ALIASES.get(as_text(argument, symbol), symbol)
    if symbol in CLASSES:
        return CLASSES[symbol]
    match = _EXACT_ORDER.fullmatch(symbol.replace(" ", ""))
    if match:
        from .quadratic import exact_order_class

        return exact_order_class(match[1], int(match[2]))
    raise UnknownNameError(f"{argument} must be one of {', '.join(CLASSES)}, C0(k), C0f(k), got {symbol!r}")


def evaluate(subject: Subject, symbol: str) -> Verdict:
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
