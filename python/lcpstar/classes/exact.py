"""Exact rational arithmetic for reading matrices and for checking witnesses: plain `Fraction`, a few lines each.

Nothing here calls the compiled core, so that `Verdict.check()` is independent of the kernel that found the witness.
"""

from __future__ import annotations

import itertools
import math
import numbers
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from ..errors import DTypeError, NotFiniteError, ShapeError
from ..sparse import as_dense, is_sparse

Rows: TypeAlias = tuple[tuple[Fraction, ...], ...]
Vector: TypeAlias = tuple[Fraction, ...]
IndexSet: TypeAlias = tuple[int, ...]


def read_number(value: object, where: str) -> Fraction:
    """One entry as the rational it is; a float is the binary rational it stores."""
    if isinstance(value, Fraction):
        return value
    if isinstance(value, (bool, np.bool_)):
        return Fraction(int(value))
    if isinstance(value, (int, np.integer)):
        return Fraction(int(value))
    if isinstance(value, (float, np.floating)):
        if not math.isfinite(value):
            raise NotFiniteError(f"{where.split('[')[0]} must be finite, got {where} = {value}")
        return Fraction(*value.as_integer_ratio())
    if isinstance(value, str):
        return _read_text(value, where)
    if isinstance(value, numbers.Rational):
        return Fraction(int(value.numerator), int(value.denominator))
    raise DTypeError(f"{where} must be a real number, got {value!r} of type {type(value).__name__}")


#: Longest number in text, and largest exponent of ten: "1e999999999" is 14 characters and 400 megabytes.
MAX_DIGITS = 4_000


def _read_text(value: str, where: str) -> Fraction:
    text = value.strip()
    shown = repr(text if len(text) <= 40 else text[:40] + "...")
    exponent = text.lower().partition("e")[2]
    if len(text) > MAX_DIGITS or (exponent.lstrip("+-").isdigit() and abs(int(exponent)) > MAX_DIGITS):
        raise DTypeError(f"{where} must be a number of at most {MAX_DIGITS} digits, got {shown}")
    try:
        if "_" in text or not text.isascii():  # Python takes 1_0 for 10, and digits of other scripts
            raise ValueError
        return Fraction(text)
    except (ValueError, ZeroDivisionError):
        raise DTypeError(f"{where} must be a number such as '1/3', got {shown}") from None


def read_matrix(A: object, name: str = "A") -> Rows:
    """A square matrix of order n >= 1 from nested sequences, or a dense or sparse array of any real dtype."""
    if is_sparse(A):
        A = as_dense(A)
    if isinstance(A, np.ndarray):
        if A.ndim != 2:
            raise ShapeError(f"{name} must have 2 dimensions, got {A.ndim}")
        if A.dtype.kind == "c":
            raise DTypeError(f"{name} must be real, got dtype {A.dtype}")
        rows: list[Any] = list(np.asarray(A) if isinstance(A, np.matrix) else A)  # a row of np.matrix is a matrix
    else:
        rows = _sequence(A, name)
    n = len(rows)
    if n == 0:
        raise ShapeError(f"{name} must have order at least 1, got order 0")
    table = []
    for i, row in enumerate(rows):
        entries = list(row) if isinstance(row, np.ndarray) else _sequence(row, f"{name}[{i}]")
        if len(entries) != n:
            raise ShapeError(f"{name} must be square, got {n} rows and {len(entries)} entries in row {i}")
        table.append(tuple(read_number(x, f"{name}[{i}, {j}]") for j, x in enumerate(entries)))
    return tuple(table)


def read_vector(q: object, n: int, name: str = "q") -> Vector:
    """A vector of length n."""
    if isinstance(q, np.ndarray) and q.ndim != 1:
        raise ShapeError(f"{name} must have 1 dimension, got {q.ndim}")
    entries = list(q) if isinstance(q, np.ndarray) else _sequence(q, name)
    if len(entries) != n:
        raise ShapeError(f"{name} must have length {n}, got {len(entries)}")
    return tuple(read_number(x, f"{name}[{i}]") for i, x in enumerate(entries))


def _sequence(value: object, name: str) -> list[Any]:
    if hasattr(value, "__array__") and not isinstance(value, (str, bytes)):
        value = np.asarray(value)
        if value.ndim:
            return list(value)
    if isinstance(value, (str, bytes, np.ndarray)) or not isinstance(value, Iterable):
        raise ShapeError(f"{name} must be a sequence, got {value!r}")
    return list(value)


def subsets(n: int) -> Iterator[IndexSet]:
    """The nonempty subsets of 0..n-1, smaller ones first."""
    for size in range(1, n + 1):
        yield from itertools.combinations(range(n), size)


def principal(A: Rows, alpha: Sequence[int]) -> Rows:
    """A[alpha, alpha]."""
    return tuple(tuple(A[i][j] for j in alpha) for i in alpha)


def transpose(A: Rows) -> Rows:
    """A'."""
    return tuple(zip(*A, strict=True))


def times(A: Rows, x: Sequence[Fraction | int]) -> Vector:
    """A x."""
    return tuple(dot(row, x) for row in A)


def dot(x: Sequence[Fraction | int], y: Sequence[Fraction | int]) -> Fraction:
    """x'y."""
    return sum((Fraction(a) * b for a, b in zip(x, y, strict=True) if a and b), Fraction(0))


def solve(A: Rows, b: Sequence[Fraction | int]) -> Vector | None:
    """The solution of A x = b, or None if A is singular."""
    n = len(A)
    m = [[*map(Fraction, row), Fraction(value)] for row, value in zip(A, b, strict=True)]
    for c in range(n):
        pivot = next((i for i in range(c, n) if m[i][c]), None)
        if pivot is None:
            return None
        m[c], m[pivot] = m[pivot], m[c]
        for i in range(n):
            if i != c and m[i][c]:
                factor = m[i][c] / m[c][c]
                m[i] = [x - factor * y for x, y in zip(m[i], m[c], strict=True)]
    return tuple(m[i][n] / m[i][i] for i in range(n))


def determinant(A: Rows) -> Fraction:
    """det A."""
    m = [list(map(Fraction, row)) for row in A]
    n, det = len(m), Fraction(1)
    for c in range(n):
        pivot = next((i for i in range(c, n) if m[i][c]), None)
        if pivot is None:
            return Fraction(0)
        if pivot != c:
            m[c], m[pivot], det = m[pivot], m[c], -det
        det *= m[c][c]
        for i in range(c + 1, n):
            if m[i][c]:
                factor = m[i][c] / m[c][c]
                m[i] = [x - factor * y for x, y in zip(m[i], m[c], strict=True)]
    return det


def pivot_transform(A: Rows, alpha: Sequence[int]) -> Rows | None:
    """The principal pivot transform of A on alpha, one elementary exchange of w_i and z_i as a linear map each.

    Column j of the transform is the vector (z_alpha, w_rest) for (w_alpha, z_rest) = e_j.
    """
    n, inside = len(A), set(alpha)
    system = tuple(tuple(A[i][j] if j in inside else Fraction(-(i == j)) for j in range(n)) for i in range(n))
    columns = []
    for j in range(n):
        right = [Fraction(i == j) if j in inside else -A[i][j] for i in range(n)]
        column = solve(system, right)
        if column is None:
            return None
        columns.append(column)
    return transpose(tuple(columns))


def is_index_set(alpha: Sequence[int], n: int) -> bool:
    """Indices in 0..n-1, ascending."""
    return list(alpha) == sorted({i for i in alpha if 0 <= i < n})


def show(x: Iterable[Fraction | int]) -> str:
    """(1, 0, 2/3)."""
    return "(" + ", ".join(str(v) for v in x) + ")"


def show_set(alpha: Iterable[int]) -> str:
    """{0, 2}, counted from 0."""
    return "{" + ", ".join(str(i) for i in alpha) + "}"
