"""The point of an answer: its numbers measured again, and whether it solves the problem."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..coerce import Vector
from .claim import Claim, Proof
from .exact import Integers, Rationals, Sums, as_doubles, times_powers_of_two
from .problem import Problem
from .report import Check
from .tails import forgiven

_EPS = float(np.finfo(float).eps)
_LEAST = float(np.finfo(float).smallest_subnormal)
#: Exponent beyond which numbers are near overflow.
_LARGEST = 1000
#: A solution found in floating point agrees with the exact one at its basis to this part of its largest entry.
_SOLVE_TOL = 1e-9
#: On the equilibrated problem, where max|q'| < 1, no huge z makes a larger violation than this a small one.
_ABSOLUTE = 1e-6


@dataclass(frozen=True)
class Point:
    """z with `w = A z + q`, and both on the equilibrated problem; what a plain sum may be off by beside each w.

    The scaled vectors are in units of `2^unit`, which is 1 unless z' overflows.
    """

    z: Vector
    w: Sums
    off: Vector
    scaled_z: Vector
    scaled_w: Vector
    scaled_off: Vector
    unit: int

    @property
    def size(self) -> float:
        """`max(1, max|z'|)`, in that unit."""
        return float(np.max(np.abs(self.scaled_z), initial=2.0**-self.unit))

    @classmethod
    def of(cls, problem: Problem, z: Vector) -> Point:
        """Measured in exact arithmetic, rounded once."""
        scaling, w = problem.scaling, problem.w(z)
        exponents = (np.frexp(z)[1] + scaling.q - scaling.columns)[z != 0]
        unit = max(0, int(np.max(exponents, initial=0)) - _LARGEST)
        shift = scaling.rows + scaling.q - unit
        # In the units of `w.value`; `off` holds the last bit of a w that is rounded to a double, too.
        plain = (problem.A.counts + 8) * _EPS * w.size
        off = plain + times_powers_of_two(np.full(problem.n, _LEAST), -w.exponent)
        scaled_z = times_powers_of_two(z, scaling.q - scaling.columns - unit)
        return cls(z, w, off, scaled_z, w.doubles(shift), times_powers_of_two(plain, w.exponent + shift), unit)


def check_numbers(point: Point, claim: Claim, tol: float) -> list[Check]:
    """`w`, `natural_residual`, `residual` and `alpha` are those of z."""
    w, exponent = point.w.doubles(), point.w.exponent
    error = np.abs(times_powers_of_two(claim.w, -exponent) - point.w.value)
    natural = _violation(point.z, w, times_powers_of_two(point.off, exponent))
    residual = _violation(point.scaled_z, point.scaled_w, point.scaled_off) / point.size
    on_alpha = np.isin(np.arange(len(claim.z)), claim.alpha)
    outside = np.flatnonzero(~on_alpha & (claim.z > 0))
    # An exact solution with its w is looked at instead, where there is one: z may have underflowed.
    basic = on_alpha & (claim.z == 0) & (claim.certificate is None or not claim.certificate.proves_solution)
    slack = np.flatnonzero(basic & ~(np.abs(point.scaled_w) <= max(tol, _ABSOLUTE) * point.size))
    return [
        Check("z >= 0", bool(np.all(claim.z >= 0))),
        Check("w = A z + q", bool(np.all(error <= point.off) and np.all(np.isfinite(w)))),
        _between("natural_residual = max|min(z, w)|", natural, claim.natural_residual),
        _between("residual = max|min(z', w')| / max(1, max|z'|)", residual, claim.residual),
        Check("z = 0 outside alpha", not outside.size, _rows(outside)),
        Check("w = 0 on alpha where z = 0", not slack.size, _rows(slack)),
    ]


def _violation(z: Vector, w: Vector, off: Vector) -> Vector:
    """The least and the largest `max|min(z, w)|` for w that is known up to `off`; NaN if any entry is."""
    with np.errstate(invalid="ignore", over="ignore"):
        low, high = np.minimum(z, w - off), np.minimum(z, w + off)
    largest = np.maximum(np.abs(low), np.abs(high))
    least = np.where((low <= 0.0) & (high >= 0.0), 0.0, np.minimum(np.abs(low), np.abs(high)))
    return np.array([np.max(least, initial=0.0), np.max(largest, initial=0.0)])


def _between(name: str, limits: Vector, stated: float) -> Check:
    # Scaling back and forth may round the last bits.
    low, high = float(limits[0]) * (1 - 4 * _EPS), float(limits[1]) * (1 + 4 * _EPS)
    return Check(
        name, low <= stated <= high and math.isfinite(stated), f"stated {stated:.3g}, measured {low:.3g} to {high:.3g}"
    )


def check_solved(problem: Problem, point: Point, claim: Claim, tol: float) -> list[Check]:
    """The rule by which a point solves LCP(q, A): see the notes of `verify`."""
    z, w = point.z, point.w
    scaling = problem.scaling
    scaled_w = w.doubles(scaling.rows + scaling.q)
    violation = float(np.max(np.abs(np.minimum(scaling.z(z), scaled_w)), initial=0.0))
    residual = float(np.max(np.abs(np.minimum(point.scaled_z, point.scaled_w)), initial=0.0)) / point.size
    # Caller's numbers, in units of max|q|.
    q = as_doubles(problem.q)
    largest = np.max(np.abs(q), initial=0.0)
    unit = int(np.frexp(largest)[1]) if largest else 0
    smaller = np.abs(np.minimum(times_powers_of_two(z, -unit), w.doubles(-unit)))
    allowed = 10 * tol * np.ldexp(largest, -unit) + 8 * _EPS * times_powers_of_two(w.size, w.exponent - unit)
    late = np.flatnonzero(~(smaller <= allowed))
    # Each row beside its own numbers.
    wrong = np.where(z > 0, np.abs(w.value), np.maximum(-w.value, 0.0))
    alone = ~(wrong <= tol**0.5 * w.size)
    if alone.any():
        shift = w.exponent + scaling.rows + scaling.q
        alone &= ~forgiven(problem, times_powers_of_two(wrong, shift), times_powers_of_two(w.size, shift))
    return [
        Check("residual <= tol", residual <= tol, f"{residual:.3g}"),
        Check("max|min(z', w')| is small itself", violation <= max(tol, _ABSOLUTE), f"{violation:.3g}"),
        Check("|min(z, w)| is small in every row", not late.size, _rows(late)),
        Check("every row holds to its own numbers", not alone.any(), _rows(np.flatnonzero(alone))),
    ]


def _rows(found: Integers) -> str:
    return f"rows {found[:10].tolist()}" if found.size else ""


def check_exact_solution(problem: Problem, proof: Proof, alpha: Sequence[int]) -> list[Check]:
    """The certificate's z solves the problem with its basis, and w = 0 on alpha, too."""
    if not isinstance(proof.z, list) or proof.alpha is None:
        return [Check("the certificate holds n exact numbers and a basis", False)]
    z, w = proof.z, problem.w(proof.z).value
    basis = set(proof.alpha)
    return [
        Check("exact z >= 0", all(x >= 0 for x in z)),
        Check("exact w = A z + q >= 0", bool(np.all(w >= 0))),
        Check("exact z'w = 0", not any(x and v for x, v in zip(z, w, strict=True))),
        Check("w = 0 on alpha, z = 0 outside", not any(w[i] if i in basis else z[i] for i in range(problem.n))),
        Check("exact w = 0 on the answer's alpha", not any(w[i] for i in alpha)),
    ]


def check_rounded(z: Vector, exact: Sequence[Fraction]) -> Check:
    """Entry by entry, to the last bit."""
    off = [i for i, (x, y) in enumerate(zip(z.tolist(), exact, strict=True)) if abs(Fraction(x) - y) > np.spacing(x)]
    return Check("z is the exact solution rounded", not off, f"not at {off[:10]}" if off else "")


def check_basis(problem: Problem, claim: Claim) -> list[Check]:
    """Solves the equations of the basis alpha exactly: the solution z is near it."""
    alpha = list(claim.alpha)
    part = _solve(problem, alpha)
    if part is None:
        return [Check("A[alpha, alpha] is not singular", False, f"alpha = {alpha[:10]}")]
    z = [Fraction(0)] * problem.n
    for i, x in zip(alpha, part, strict=True):
        z[i] = x
    w = problem.w(z).value
    low_z = [i for i in alpha if z[i] < 0]
    low_w = np.flatnonzero(np.where(np.isin(np.arange(problem.n), alpha), 0.0, w) < 0)
    exact, given = problem.scaling.z(as_doubles(z)), problem.scaling.z(claim.z)
    near = np.abs(exact - given) <= _SOLVE_TOL * np.max(np.abs(exact), initial=0.0)
    return [
        Check("exact z >= 0 at the basis alpha", not low_z, f"z < 0 at {low_z}" if low_z else ""),
        Check("exact w >= 0 at the basis alpha", not low_w.size, _rows(low_w)),
        Check("z is the exact solution rounded", bool(np.all(near)), _rows(np.flatnonzero(~near))),
    ]


def _solve(problem: Problem, alpha: list[int]) -> list[Fraction] | None:
    """Solution of `A[alpha, alpha] x = -q[alpha]`; `None` for a singular block. Bareiss elimination [Bar68]."""
    place = {j: c for c, j in enumerate(alpha)}
    k = len(alpha)
    table: list[list[int]] = []
    for i in alpha:
        columns, values = problem.A.row(i)
        row = [Fraction(0)] * k + [-Fraction(problem.q[i])]
        for j, a in zip(columns, values, strict=True):
            if j in place:
                row[place[j]] = Fraction(a)
        table.append(list(Rationals.of(row).numerators))
    previous = 1
    for c in range(k):
        pivot = next((r for r in range(c, k) if table[r][c] != 0), None)
        if pivot is None:
            return None
        table[c], table[pivot] = table[pivot], table[c]
        top = table[c]
        for r in range(c + 1, k):
            low, factor = table[r], table[r][c]
            table[r] = [0] * (c + 1) + [(top[c] * low[j] - factor * top[j]) // previous for j in range(c + 1, k + 1)]
        previous = top[c]
    x = [Fraction(0)] * k
    for c in reversed(range(k)):
        known = sum((table[c][j] * x[j] for j in range(c + 1, k)), Fraction(0))
        x[c] = (table[c][k] - known) / table[c][c]
    return x
