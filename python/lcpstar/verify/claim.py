"""What an answer claims, read without trust: each field becomes plain numbers, or a `Check` that fails."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeVar

import numpy as np

from ..coerce import Vector
from ..result import Status
from .exact import Numbers
from .report import Check

T = TypeVar("T")
KINDS = ("solution", "infeasible", "nearly_infeasible", "ray", "not_sufficient")


@dataclass(frozen=True)
class Proof:
    """A certificate, of a known kind. `y` and `z` have length n and are `Fraction`s where it is exact."""

    kind: str
    exact: bool
    alpha: tuple[int, ...] | None
    y: Numbers | None
    z: Numbers | None
    bound: float | None

    @property
    def proves_solution(self) -> bool:
        """Whether it claims an exact solution."""
        return self.exact and self.kind == "solution"


@dataclass(frozen=True)
class Direction:
    """A ray with its starting point, finite numbers of the right length."""

    z: Vector
    z0: float
    z_hat: Vector
    z0_hat: float
    w_hat: Vector
    d: Vector


@dataclass(frozen=True)
class Claim:
    """An answer whose fields have the right types and lengths."""

    status: str
    success: bool | None
    z: Vector
    w: Vector
    residual: float
    natural_residual: float
    alpha: tuple[int, ...]
    certificate: Proof | None
    ray: Direction | None


class _MalformedError(ValueError):
    """A field is not what it must be."""


def read_claim(sol: Any, n: int) -> tuple[Claim | None, list[Check]]:
    """The claim and a check for each field; None where one is malformed."""
    reader = _Reader(n)
    claim = Claim(
        status=reader.field(sol, "status", "is a known status", _status),
        success=reader.field(sol, "success", "is True or False", _truth, optional=True),
        z=reader.field(sol, "z", "is a finite vector of length n", reader.doubles),
        w=reader.field(sol, "w", "is a finite vector of length n", reader.doubles),
        residual=reader.field(sol, "residual", "is a number", _double),
        natural_residual=reader.field(sol, "natural_residual", "is a number", _double),
        alpha=reader.field(sol, "alpha", "is an index set", reader.indices),
        certificate=reader.field(sol, "certificate", "is well formed", reader.certificate),
        ray=reader.field(sol, "ray", "is well formed", reader.ray),
    )
    return (claim if all(check.ok for check in reader.checks) else None), reader.checks


class _Reader:
    def __init__(self, n: int) -> None:
        self.n = n
        self.checks: list[Check] = []

    def field(self, owner: Any, name: str, must: str, read: Callable[[Any], T], optional: bool = False) -> T:
        """`read` of a field. Whatever goes wrong in an object that nobody vouches for is reported."""
        value: Any = None
        detail = ""
        try:
            given = getattr(owner, name, None) if optional else getattr(owner, name)
            value = None if optional and given is None else read(given)
        except Exception as error:
            detail = f"{type(error).__name__}: {error}"
        self.checks.append(Check(f"{name} {must}", not detail, detail))
        return value  # type: ignore[no-any-return]  # None only beside a failed check

    def doubles(self, value: Any) -> Vector:
        array = np.asarray(value)
        if array.dtype.kind not in "fiu" or array.shape != (self.n,):
            raise _MalformedError(f"dtype {array.dtype}, shape {array.shape}")
        array = array.astype(np.float64)
        if not np.isfinite(array).all():
            raise _MalformedError("not finite")
        return array

    def numbers(self, value: Any, exact: bool) -> Numbers:
        """Doubles, or a list of exact numbers."""
        if isinstance(value, np.ndarray) and not exact:
            return self.doubles(value)
        kinds = (int, Fraction) if exact else (int, Fraction, float)
        entries = list(value)
        if len(entries) != self.n:
            raise _MalformedError(f"length {len(entries)}")
        if wrong := [x for x in entries if not isinstance(x, kinds) or isinstance(x, bool)]:
            raise _MalformedError(f"{wrong[0]!r} is no {'exact ' if exact else ''}number")
        return [Fraction(x) for x in entries]

    def indices(self, value: Any) -> tuple[int, ...]:
        if not isinstance(value, (list, tuple, np.ndarray)):
            raise _MalformedError(f"{value!r}")
        entries = list(value)
        if not all(isinstance(i, (int, np.integer)) and not isinstance(i, bool) for i in entries):
            raise _MalformedError(f"{entries}")
        alpha = tuple(int(i) for i in entries)
        if len(set(alpha)) < len(alpha) or not all(0 <= i < self.n for i in alpha):
            raise _MalformedError(f"{alpha}")
        return alpha

    def certificate(self, value: Any) -> Proof | None:
        if value is None:
            return None
        if not isinstance(value.kind, str) or value.kind not in KINDS:
            raise _MalformedError(f"unknown kind {value.kind!r}")
        exact = _truth(value.exact)
        alpha, y, z, bound = value.alpha, value.y, value.z, getattr(value, "bound", None)
        return Proof(
            kind=str(value.kind),
            exact=exact,
            alpha=None if alpha is None else self.indices(alpha),
            y=None if y is None else self.numbers(y, exact),
            z=None if z is None else self.numbers(z, exact),
            bound=None if bound is None else _double(bound),
        )

    def ray(self, value: Any) -> Direction | None:
        if value is None:
            return None
        z, z_hat, w_hat, d = (self.doubles(x) for x in (value.z, value.z_hat, value.w_hat, value.d))
        z0, z0_hat = _double(value.z0), _double(value.z0_hat)
        if not (math.isfinite(z0) and math.isfinite(z0_hat)):
            raise _MalformedError("not finite")
        return Direction(z, z0, z_hat, z0_hat, w_hat, d)


def _status(value: Any) -> str:
    if not isinstance(value, str) or str(value) not in {status.value for status in Status}:
        raise _MalformedError(f"unknown status {value!r}")
    return str(value)


def _truth(value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise _MalformedError(f"{value!r}")
    return bool(value)


def _double(value: Any) -> float:
    if not isinstance(value, (int, float, np.number)) or isinstance(value, bool) or math.isnan(value):
        raise _MalformedError(f"{value!r}")
    return float(value)
