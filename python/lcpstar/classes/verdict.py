"""The answer to "is A in this class?"."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from .exact import Rows


@dataclass(frozen=True)
class Cost:
    """What a verdict took: seconds, and for an undecided one how far the search got."""

    seconds: float
    done: int = 0
    total: int = 0


@dataclass(frozen=True)
class Finding:
    """What a predicate returns: `holds`, and why. `reason` may be a function, called when somebody asks."""

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
    certificate: Any
    cost: Cost
    matrix: Rows = field(repr=False)
    _reason: str | Callable[[], str] = field(repr=False)

    @property
    def reason(self) -> str:
        """One sentence that a mathematician accepts."""
        return self._reason if isinstance(self._reason, str) else self._reason()

    def check(self) -> bool | None:
        """Re-check the witness or the certificate from the matrix alone, without the compiled core.

        Returns
        -------
        bool or None
            True if it proves the verdict, None if there is nothing to check (undecided, or True without a compact
            certificate: then `reason` names the theorem or the finite test). False would be a bug: please report it.
        """
        if self.holds is False:
            return bool(self.witness.refutes(self.matrix))
        if self.holds and self.certificate is not None:
            return bool(self.certificate.proves(self.matrix))
        return None

    def __bool__(self) -> bool:
        if self.holds is None:
            raise ValueError(f"{self.symbol} is undecided ({self.reason}): test `verdict.holds is None`")
        return self.holds

    def __str__(self) -> str:
        word = {True: "in", False: "not in", None: "undecided:"}[self.holds]
        return f"{word} {self.symbol} ({self.name}): {self.reason}"
