"""What `verify` says: one `Check` for each statement, and the `Report` of them all."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One statement and whether it holds."""

    name: str
    ok: bool
    detail: str = ""


@dataclass(frozen=True)
class Report:
    """The outcome of `verify`: true when every check holds. `exact`: the conclusion was proved in rational numbers."""

    checks: tuple[Check, ...]
    exact: bool

    def __bool__(self) -> bool:
        return all(check.ok for check in self.checks)

    @property
    def failures(self) -> list[Check]:
        """The checks that do not hold."""
        return [check for check in self.checks if not check.ok]

    def __str__(self) -> str:
        lines = [f"{'ok  ' if c.ok else 'FAIL'} {c.name}{': ' + c.detail if c.detail else ''}" for c in self.checks]
        kind = "in rational arithmetic" if self.exact else "in floating point"
        return "\n".join([f"{'verified' if self else 'NOT verified'} {kind}", *lines])
