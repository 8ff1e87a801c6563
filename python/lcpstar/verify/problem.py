"""LCP(q, A) as `verify` reads it: dense or sparse, doubles or exact numbers, with the equilibration done again."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..classes.exact import read_matrix, read_vector
from ..coerce import Vector, as_matrix, as_vector
from ..errors import NotFiniteError, ShapeError
from ..sparse import as_rows, is_sparse
from .exact import Integers, Matrix, Numbers, Sums, as_doubles, simplest, times_powers_of_two

_SWEEPS = 12
_NO_ENTRY = -(10**6)


@dataclass(frozen=True)
class Scaling:
    """`A' = D_r A D_c`, `q' = s D_r q`, `z = D_c z' / s`, `w = D_r^-1 w' / s`, as exponents of two."""

    rows: Integers
    columns: Integers
    q: int

    def z(self, z: Vector) -> Vector:
        """`z'` of the caller's z."""
        return times_powers_of_two(z, self.q - self.columns)

    def direction(self, z: Vector) -> Vector:
        """As `z`, without the factor s, which belongs to q."""
        return times_powers_of_two(z, -self.columns)


@dataclass(frozen=True)
class Problem:
    """A and q; `Fraction`s where an entry is no double."""

    A: Matrix
    q: Numbers

    @property
    def n(self) -> int:
        """The order."""
        return self.A.n

    def w(self, z: Numbers) -> Sums:
        """`A z + q` and `|A||z| + |q|`."""
        return self.A.times(z, self.q)

    @cached_property
    def scaling(self) -> Scaling:
        """Ruiz equilibration in the max norm, rounded to powers of two [Rui01]; `max|q'|` comes to lie in [1/2, 1)."""
        A = self.A
        entries = np.frexp(as_doubles(A.values))[1].astype(np.int64)
        r, c = np.zeros(self.n, dtype=np.int64), np.zeros(self.n, dtype=np.int64)
        for _ in range(_SWEEPS):
            sizes = entries + r[A.rows] + c[A.columns]
            steps = [_half_way(sizes, index, self.n) for index in (A.rows, A.columns)]
            r, c = r - steps[0], c - steps[1]
            if not any(step.any() for step in steps):
                break
        q = as_doubles(self.q)
        largest = np.max((np.frexp(q)[1] + r)[q != 0.0], initial=_NO_ENTRY)
        return Scaling(r, c, 0 if largest == _NO_ENTRY else -int(largest))


def _half_way(sizes: Integers, index: Integers, n: int) -> Integers:
    """Half of each row's (column's) largest exponent; nothing where it is within one of zero."""
    largest = np.full(n, _NO_ENTRY)
    np.maximum.at(largest, index, sizes)
    steps = np.sign(largest) * (np.abs(largest) // 2)
    return np.asarray(np.where((largest == _NO_ENTRY) | (np.abs(largest) <= 1), 0, steps))


def read_problem(A: Any, q: Any) -> Problem:
    """Raises for what is no problem, as `solve` does."""
    if is_sparse(A):
        starts, columns, values, _ = as_rows(A, np.zeros(A.shape[0]))
        _check_finite("A", values)
        matrix = _matrix(len(starts) - 1, np.repeat(np.arange(len(starts) - 1), np.diff(starts)), columns, values)
    elif (isinstance(A, np.ndarray) and A.dtype.kind == "f") or (isinstance(A, (list, tuple)) and not A):
        dense = as_matrix("A", A)
        _check_finite("A", dense)
        rows, columns = np.nonzero(dense)
        matrix = _matrix(len(dense), rows, columns, dense[rows, columns])
    else:
        exact = read_matrix(A)
        entries = [(i, j, x) for i, row in enumerate(exact) for j, x in enumerate(row) if x]
        rows, columns = (np.array([entry[k] for entry in entries], dtype=np.int64) for k in range(2))
        matrix = _matrix(len(exact), rows, columns, simplest([x for _, _, x in entries]))
    return Problem(matrix, _read_q(q, matrix.n))


def _matrix(n: int, rows: Integers, columns: Integers, values: Numbers) -> Matrix:
    kept = np.flatnonzero(values) if isinstance(values, np.ndarray) else np.arange(len(values))
    values = values[kept] if isinstance(values, np.ndarray) else values
    return Matrix(n, np.searchsorted(rows[kept], np.arange(n + 1)), columns[kept], values)


def _read_q(q: Any, n: int) -> Numbers:
    if isinstance(q, np.ndarray) and q.dtype.kind == "f":
        vector = as_vector("q", q)
        if len(vector) != n:
            raise ShapeError(f"q must have length {n}, got {len(vector)}")
        _check_finite("q", vector)
        return vector
    return simplest(list(read_vector(q, n)))


def _check_finite(name: str, array: Vector) -> None:
    if not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise NotFiniteError(f"{name} must be finite, got {name}{list(index)} = {array[index]}")
