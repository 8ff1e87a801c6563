"""Tails: rows in which the solution of a discretised equation has decayed to rounding beside its largest entries.

A row whose error is a large part of its own numbers is wrong, unless A is a P-matrix, for which every LCP has a
solution, and the error is below the rounding of the part of the problem that the row belongs to. The P-matrices that
are recognised are the weakly chained diagonally dominant ones with a positive diagonal [AF16].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..coerce import Vector
from .exact import Integers, Matrix, as_doubles, times_powers_of_two
from .problem import Problem

_EPS = float(np.finfo(float).eps)


def forgiven(problem: Problem, off: Vector, size: Vector) -> NDArray[np.bool_]:
    """Which rows of the equilibrated problem may be off by this much; `size` is `|A'||z'| + |q'|`."""
    if not is_chained_dominant(problem.A):
        return np.zeros(problem.n, dtype=bool)
    scaling = problem.scaling
    q = np.abs(times_powers_of_two(as_doubles(problem.q), scaling.rows + scaling.q))
    part = parts(problem.A)
    largest = np.zeros(problem.n)
    np.maximum.at(largest, part, q)
    return np.asarray((2 * q < size) & (off <= 32 * _EPS * largest[part]))


def is_chained_dominant(A: Matrix) -> bool:
    """`0 < a_ii >= sum_j |a_ij|`, and from every row a chain of entries leads to a strict one. Decided exactly."""
    diagonal = A.rows == A.columns
    if np.count_nonzero(diagonal & (as_doubles(A.values) > 0)) < A.n:
        return False
    values = [a if on else -abs(a) for a, on in zip(list(A.values), diagonal.tolist(), strict=True)]
    kept = np.array(values) if isinstance(A.values, np.ndarray) else values
    excess = Matrix(A.n, A.starts, A.columns, kept).times(np.ones(A.n)).value
    if not np.all(excess >= 0):
        return False
    # Backwards along the chains from the strict rows.
    into, reached = A.transposed, excess > 0
    todo = np.flatnonzero(reached).tolist() if not reached.all() else []
    while todo:
        j = todo.pop()
        new = [i for i in into.columns[into.starts[j] : into.starts[j + 1]].tolist() if not reached[i]]
        reached[new] = True
        todo += new
    return bool(reached.all())


def parts(A: Matrix) -> Integers:
    """The least index of the part of each row: rows hang together where a chain of entries joins them."""
    least = np.arange(A.n)
    while True:
        lower = least.copy()
        np.minimum.at(lower, A.rows, least[A.columns])
        np.minimum.at(lower, A.columns, least[A.rows])
        lower = lower[lower]
        if np.array_equal(lower, least):
            return least
        least = lower
