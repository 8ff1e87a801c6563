"""What a solve returns, beside `Solution` itself, which is compiled."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

from .coerce import Vector


class Status(str, Enum):
    """The outcome of a solve; compares equal to its value, so `sol.status == "solved"` works."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    NEARLY_INFEASIBLE = "nearly_infeasible"
    SECONDARY_RAY = "secondary_ray"
    MAX_ITERATIONS = "max_iterations"
    TIME_LIMIT = "time_limit"
    NUMERICAL_BREAKDOWN = "numerical_breakdown"

    def __str__(self) -> str:
        """Return the bare value."""
        return self.value


@dataclass(frozen=True, eq=False)
class Certificate:
    """Why a status may be believed.

    `kind` is "solution" (`alpha`, the complementary basis, reproduces z), "infeasible" (`y >= 0, A'y <= 0, q'y < 0`,
    exactly, whether y holds doubles or `Fraction`s), "nearly_infeasible" (no z >= 0 with `sum(z) < bound` is feasible:
    `y >= 0`, `q'y < 0`, `bound <= -q'y / max_j (A'y)_j`, rigorously), "ray" or "not_sufficient" (`x_i (A x)_i <= 0` for
    all i and `< 0` for some i with x = `z`, or the same of A' with x = `y`). `exact` says whether it was found in
    rational arithmetic; then `z` or `y` holds `Fraction`s.
    """

    kind: str
    exact: bool = False
    alpha: list[int] | None = None
    y: Vector | list[Fraction] | None = None
    z: list[Fraction] | None = None
    bound: float | None = None


@dataclass(frozen=True, eq=False)
class Ray:
    """A secondary ray of Lemke's method: `z + t z_hat`, `z0 + t z0_hat` stay almost complementary for all t >= 0.

    `w_hat = A z_hat + d z0_hat >= 0`, `z_hat >= 0` is not zero, and `d` is the covering vector.
    """

    z: Vector
    z0: float
    z_hat: Vector
    z0_hat: float
    w_hat: Vector
    d: Vector


def _fractions(numerators: list[int], denominator: int) -> list[Fraction]:
    return [Fraction(numerator, denominator) for numerator in numerators]


#: What a pickle of a `Solution` holds.
_FIELDS = (
    "z",
    "w",
    "status",
    "method",
    "iterations",
    "residual",
    "natural_residual",
    "alpha",
    "certificate",
    "ray",
    "pieces",
    "message",
    "time",
    "trace",
)


def _reduce(solution: Any) -> tuple[Any, ...]:
    return _rebuild, (tuple(getattr(solution, field) for field in _FIELDS),)


def _rebuild(values: tuple[Any, ...]) -> Any:
    """A `Solution` from its fields: a claim, as every pickle is; `lcpstar.verify` recomputes it."""
    from ._core import Solution

    return Solution._restore(SimpleNamespace(**dict(zip(_FIELDS, values, strict=True))))
