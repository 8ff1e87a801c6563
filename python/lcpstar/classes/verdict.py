"""The answer to "is A in this class?"."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

from .evidence import is_matrix, is_plain, proves, refutes
from .exact import Rows


@dataclass(frozen=True)
class Cost:
    """What a verdict took: seconds, and for an undecided one how far the search got."""

    seconds: float
    done: int = 0
    total: int = 0


@dataclass(frozen=True)
class Finding:
    """What a predicate returns: `holds`, and why. `reason` may be a function and `certificate` a partial one."""

    holds: bool | None
    reason: str | Callable[[], str]
    witness: Any = None
    certificate: Any = None


@dataclass(frozen=True, eq=False)
class Verdict:
    """An exact statement about the given numbers.

    `holds` is True, False, or None (undecided within the budget; `reason` says how far it got). `witness` refutes
    membership, `certificate` proves it where a compact proof exists; both are exact. `reason` is one sentence.
    """

    holds: bool | None
    symbol: str
    name: str
    witness: Any
    cost: Cost
    matrix: Rows = field(repr=False)
    _reason: str | Callable[[], str] = field(repr=False)
    _certificate: Any = field(repr=False)

    @cached_property
    def certificate(self) -> Any:
        """The proof of membership, made when somebody asks; None if there is no compact one."""
        return self._certificate() if isinstance(self._certificate, partial) else self._certificate

    @property
    def reason(self) -> str:
        """One sentence that a mathematician accepts."""
        return self._reason if isinstance(self._reason, str) else self._reason()

    def check(self) -> bool | None:
        """Re-check from the matrix alone, without the compiled core, that witness or certificate prove this verdict.

        Its claim must be true of `matrix`, and must say by the definition of the class `symbol`, or by the proved
        inclusions, what `holds` says.

        Returns
        -------
        bool or None
            True if it proves the verdict, None if there is nothing to check (undecided, or True without a compact
            certificate: then `reason` names the theorem or the finite test). False would be a bug: please report it.
        """
        evidence = self.certificate if self.holds else self.witness
        if self.holds is None or (self.holds is True and evidence is None):
            return None
        try:
            plain = is_matrix(self.matrix) and is_plain(evidence, Verdict)
            return plain and (proves if self.holds else refutes)(evidence, self.matrix, self.symbol)
        except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError):
            return False  # vectors of the wrong length, indices out of range, None in the place of a number

    def __bool__(self) -> bool:
        if self.holds is None:
            raise ValueError(f"{self.symbol} is undecided ({self.reason}): test `verdict.holds is None`")
        return self.holds

    def __str__(self) -> str:
        word = {True: "in", False: "not in", None: "undecided:"}[self.holds]
        return f"{word} {self.symbol} ({self.name}): {self.reason}"
