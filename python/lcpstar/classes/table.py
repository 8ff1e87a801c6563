"""The table of classes: symbol, name, predicate, limit; other spellings; the order in which they are listed."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from ..coerce import as_text
from ..errors import UnknownNameError
from .verdict import Finding, Verdict

Predicate = Callable[[Any], Finding]  # of a Subject


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

# Classes with a number: `C0(k)` and `C0f(k)`, from the symbol before the parenthesis.
FAMILIES: dict[str, Callable[[int], MatrixClass]] = {}

# The order of the paper, in which everything is listed.
_ORDER = (
    *("PD", "PSD", "CSU", "RSU", "SU", "P", "P0", "N", "N0", "C0", "C", "C0+", "C0*", "E0", "E", "L2", "L", "PM"),
    *("PSBD", "C0f", "E0f", "almost-P0", "almost-P", "almost-N0", "almost-N", "almost-C0", "almost-E", "almost-C0f"),
    *("Z", "K0", "Ec", "R", "R0", "Qb", "Q", "Q0", "cQ", "cQ0", "E0s", "cE0s", "tE0s", "ctE0s", "++"),
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


def find_class(symbol: str, argument: str = "symbol") -> MatrixClass:
    """The class of a symbol or of another spelling of it; `C0(k)` and `C0f(k)` for every k >= 0."""
    symbol = ALIASES.get(as_text(argument, symbol), symbol)
    if symbol in CLASSES:
        return CLASSES[symbol]
    match = _EXACT_ORDER.fullmatch(symbol.replace(" ", ""))
    if match:
        return FAMILIES[match[1]](int(match[2]))
    raise UnknownNameError(f"{argument} must be one of {', '.join(CLASSES)}, C0(k), C0f(k), got {symbol!r}")
