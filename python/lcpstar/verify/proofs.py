"""Certificates beside the point: Farkas vectors, rays, vectors that refute sufficiency."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from ..coerce import Vector
from .claim import Direction, Proof
from .exact import Numbers, Rationals, Sums, as_doubles, simplest, times_powers_of_two
from .problem import Problem
from .report import Check

#: A vector that nearly refutes feasibility has `(A'y)_j` below this part of its terms.
_NEARLY = 1e-9
#: A ray comes from linear solves in doubles, and no claim rests on it: it may be off by this part of its largest entry.
_RAY_TOL = 1e-6


def check_farkas(problem: Problem, proof: Proof) -> list[Check]:
    """`y >= 0, A'y <= 0, q'y < 0` as rational numbers: then no z >= 0 has A z + q >= 0."""
    if proof.y is None:
        return [Check("the certificate holds a Farkas vector", False)]
    columns = problem.A.transposed.times(simplest(proof.y))
    return [*_multiplier(problem, proof.y), Check("exact A'y <= 0", bool(np.all(columns.value <= 0)))]


def _multiplier(problem: Problem, y: Numbers) -> list[Check]:
    return [
        Check("exact y >= 0", all(v >= 0 for v in y)),
        Check("exact q'y < 0", Rationals.of(problem.q).dot(Rationals.of(y)) < 0),
    ]


def check_nearly_farkas(problem: Problem, proof: Proof) -> list[Check]:
    """`y >= 0, q'y < 0`, and A'y is so little positive that every feasible z has `sum(z) >= bound`.

    For `0 <= y'(A z + q) <= max_j (A'y)_j^+ sum(z) + q'y`.
    """
    if proof.y is None or proof.bound is None:
        return [Check("the certificate holds y and the bound that follows from it", False)]
    columns = problem.A.transposed.times(simplest(proof.y))
    value = Rationals.of(problem.q).dot(Rationals.of(proof.y))
    largest = _largest(problem, columns, Rationals.of(proof.y))
    finite = math.isfinite(proof.bound) and Fraction(proof.bound) * largest <= -value
    bounded = proof.bound > 0 and (finite or largest == 0)
    return [
        *_multiplier(problem, proof.y),
        Check("exact 0 < bound <= -q'y / max_j (A'y)_j", bounded, f"bound = {proof.bound:.3g}"),
        Check("A'y <= 0 to 1e-9 of its terms", bool(np.all(columns.value <= _NEARLY * columns.size))),
    ]


def _largest(problem: Problem, columns: Sums, y: Rationals) -> Fraction:
    """`max_j (A'y)_j^+`, exactly; only the columns that may hold it are looked at again."""
    rounded = np.where(columns.value > 0, columns.doubles(), -math.inf)
    top = np.max(rounded, initial=0.0)
    near = np.flatnonzero(rounded >= top * (1 - 1e-12))
    return max((problem.A.transposed.entry_of_product(j, y) for j in near.tolist()), default=Fraction(0))


def check_not_sufficient(problem: Problem, proof: Proof) -> list[Check]:
    """Exact, on the given numbers of A: column sufficiency with x = z, row sufficiency with x = y."""
    transposed = proof.z is None
    x = proof.y if transposed else proof.z
    if not proof.exact or x is None:
        return [Check("the certificate holds an exact vector that refutes sufficiency", False)]
    image = (problem.A.transposed if transposed else problem.A).times(x).value
    signs = np.sign(image) * [(v > 0) - (v < 0) for v in x]
    name = "(A' x)" if transposed else "(A x)"
    return [
        Check(f"exact x_i {name}_i <= 0 for all i", bool(np.all(signs <= 0))),
        Check(f"exact x_i {name}_i < 0 for some i", bool(np.any(signs < 0))),
    ]


def check_ray(problem: Problem, ray: Direction) -> list[Check]:
    """`w_hat = A z_hat + d z0_hat >= 0`, `z_hat >= 0` and where it starts, with room for rounding.

    The room is relative to the largest number of the equilibrated problem.
    """
    if not np.all(ray.d > 0):
        return [Check("the ray's d > 0", False)]
    scaling, A = problem.scaling, problem.A
    d = times_powers_of_two(ray.d, scaling.rows)
    w_hat = A.times(ray.z_hat, _add(np.zeros(problem.n), ray.d, ray.z0_hat))
    z_hat, z0_hat, scaled = scaling.direction(ray.z_hat), d * ray.z0_hat, w_hat.doubles(scaling.rows)
    stated = times_powers_of_two(ray.w_hat, scaling.rows)
    room_hat = _room(z_hat, z0_hat)
    w = A.times(ray.z, _add(problem.q, ray.d, ray.z0)).doubles(scaling.rows + scaling.q)
    z, z0 = scaling.z(ray.z), times_powers_of_two(d * ray.z0, scaling.q)
    room = _room(z, z0, np.ones(1))
    return [
        Check("z_hat >= 0, not zero", bool(np.all(z_hat >= -room_hat) and np.any(z_hat > room_hat))),
        Check("z0_hat >= 0", bool(np.all(z0_hat >= -room_hat))),
        Check("w_hat = A z_hat + d z0_hat", bool(np.all(np.abs(scaled - stated) <= room_hat))),
        Check("w_hat >= 0", bool(np.all(scaled >= -room_hat))),
        Check("z_hat'w_hat = 0", bool(np.all(np.minimum(z_hat, scaled) <= room_hat))),
        Check("A z + q + d z0 >= 0 where the ray starts", bool(np.all(w >= -room))),
        Check("z >= 0, z0 >= 0 where the ray starts", bool(np.all(z >= -room) and np.all(z0 >= -room))),
    ]


def _room(*numbers: Vector) -> float:
    return _RAY_TOL * float(np.max(np.abs(np.concatenate(numbers)), initial=0.0))


def _add(start: Numbers, d: Numbers, z0: float) -> Numbers:
    if isinstance(start, np.ndarray) and (z0 == 0.0 or not start.any()):
        return start + np.asarray(d) * z0
    return [Fraction(a) + Fraction(b) * Fraction(z0) for a, b in zip(start, d, strict=True)]


def check_exact_ray(problem: Problem, proof: Proof, ray: Direction) -> list[Check]:
    """With the covering vector of `ray`; the first row with z_i > 0 says what z_0 is."""
    if not isinstance(proof.z, list) or not np.all(ray.d > 0):
        return [Check("the certificate holds n exact numbers, beside a ray with d > 0", False)]
    z, d = proof.z, [Fraction(x) for x in ray.d.tolist()]
    support = [i for i in range(problem.n) if z[i] != 0]
    z0 = -problem.A.entry_of_product(support[0], Rationals.of(z)) / d[support[0]] if support else Fraction(-1)
    w = problem.A.times(z, [b * z0 for b in d]).value
    return [
        Check("exact z_hat >= 0, not zero, z0_hat >= 0", min(z, default=z0) >= 0 and z0 >= 0),
        Check("exact w_hat = A z_hat + d z0_hat >= 0", bool(np.all(w >= 0)) and z0 >= 0),
        Check("exact z_hat'w_hat = 0", not any(w[i] for i in support)),
        Check("the ray has the exact direction", _is_parallel(problem, z, ray)),
    ]


def _is_parallel(problem: Problem, z: list[Fraction], ray: Direction) -> bool:
    exact, rounded = problem.scaling.direction(as_doubles(z)), problem.scaling.direction(ray.z_hat)
    tops = [np.max(np.abs(x), initial=0.0) for x in (exact, rounded)]
    if not (0 < tops[0] < math.inf and 0 < tops[1] < math.inf):
        return False
    return bool(np.all(np.abs(exact / tops[0] - rounded / tops[1]) <= _RAY_TOL))
