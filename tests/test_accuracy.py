"""`accuracy` against exact arithmetic: no bound below the error, wherever in the range of doubles the numbers are."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
import scipy.sparse as sp

import lcpstar


def exact_rows(A, q, z):
    """`w` and `|A||z| + |q|` as fractions."""
    A, q, z = [[Fraction(x) for x in row] for row in A], [Fraction(x) for x in q], [Fraction(x) for x in z]
    w = [sum((a * x for a, x in zip(row, z, strict=True)), c) for row, c in zip(A, q, strict=True)]
    sizes = [sum((abs(a * x) for a, x in zip(row, z, strict=True)), abs(c)) for row, c in zip(A, q, strict=True)]
    return w, sizes


def exact_solution(A, q):
    """The solution of a problem with a P-matrix, by every index set."""
    n = len(q)
    A, q = [[Fraction(float(x)) for x in row] for row in A], [Fraction(float(x)) for x in q]
    for alpha in itertools.chain.from_iterable(itertools.combinations(range(n), k) for k in range(n + 1)):
        rows = [[A[i][j] for j in alpha] + [-q[i]] for i in alpha]
        for k in range(len(alpha)):
            pivot = next((r for r in range(k, len(alpha)) if rows[r][k] != 0), None)
            if pivot is None:
                break
            rows[k], rows[pivot] = rows[pivot], rows[k]
            rows[k] = [x / rows[k][k] for x in rows[k]]
            for r in range(len(alpha)):
                if r != k:
                    rows[r] = [x - rows[r][k] * y for x, y in zip(rows[r], rows[k], strict=True)]
        else:
            z = [Fraction(0)] * n
            for i, row in zip(alpha, rows, strict=True):
                z[i] = row[-1]
            if min(z, default=0) >= 0 and min(exact_rows(A, q, z)[0], default=0) >= 0:
                return z
    raise AssertionError("no P-matrix")


def exact_backward_error(A, q, z):
    """The least omega of the docstring, infinite for a negative z."""
    if min(z, default=0) < 0:
        return math.inf
    worst = Fraction(0)
    for x, w, size in zip(z, *exact_rows(A, q, z), strict=True):
        wrong = abs(w) if x > 0 else max(-w, Fraction(0))
        if wrong:
            worst = max(worst, wrong / size)
    return worst


def assert_honest(A, q, z, found, solution=None):
    w, _ = exact_rows(A, q, z)
    z = [Fraction(float(x)) for x in z]
    residual = max((abs(min(x, y)) for x, y in zip(z, w, strict=True)), default=Fraction(0))
    if residual > Fraction(np.finfo(float).max):
        assert found.natural_residual >= np.finfo(float).max
    else:
        assert abs(Fraction(found.natural_residual) - residual) <= residual * Fraction(1, 10**12) + Fraction(5e-324)
        assert (found.natural_residual == 0) == (residual == 0)
    expected = exact_backward_error(A, q, z)
    if expected == math.inf:
        assert found.backward_error == math.inf
    else:
        assert found.backward_error >= expected * (1 - Fraction(1, 10**12))
        assert Fraction(found.backward_error) <= expected * (1 + Fraction(1, 10**12)) + Fraction(5e-324)
        assert (found.backward_error == 0) == (expected == 0)
    assert found.residual >= 0
    assert (found.residual == 0) == (residual == 0)
    if found.error_bound is not None and solution is not None:
        error = max((abs(x - y) for x, y in zip(z, solution, strict=True)), default=Fraction(0))
        assert not math.isnan(found.error_bound)
        assert found.error_bound == math.inf or Fraction(found.error_bound) >= error


def both(A, q, z):
    yield lcpstar.accuracy(A, q, z)
    yield lcpstar.accuracy(sp.csr_array(np.asarray(A, float)), q, z)


@pytest.mark.parametrize(
    ("A", "q", "z"),
    [
        ([[2.0]], [-1.0], [1e308]),
        ([[1.0, 0.5], [0.5, 1.0]], [-1e-200] * 2, [1e200] * 2),
        ([[1.0, 0.5], [0.5, 1.0]], [-1e-200] * 2, [0.0, 0.0]),
        ([[1e-200]], [0.0], [1e-200]),
        ([[5e-324]], [-5e-324], [1.0]),
        ([[1e308, -1e308], [0.0, 1e308]], [1e-308, -1e308], [1e308, 1e308]),
        ([[1e-308]], [-1e308], [1e308]),
        ([[1.0]], [-1.0], [1.0]),
        ([[1.0]], [1.0], [-0.0]),
        ([[1.0]], [1.0], [-5e-324]),
        ([[3.0]], [-1e-323], [5e-324]),
        ([[1.0, -1.0], [0.0, 1.0]], [-1e-170, 1e-300], [1e300, 1e300]),
    ],
)
def test_ends_of_the_range(A, q, z):
    for found in both(A, q, z):
        assert_honest(A, q, z, found, exact_solution(A, q))


def random_problem(rng, kind):
    """A P-matrix of the kind, its exponents all over the place, and q."""
    n = int(rng.integers(1, 5))
    B = rng.integers(-8, 9, (n, n)).astype(float)
    if kind == "definite":
        S = rng.integers(-4, 5, (n, n))
        A = B @ B.T + np.eye(n) + (S - S.T)
    else:
        A = B + np.diag(1.0 + np.abs(B).sum(axis=1) - np.diag(B))
    spread = int(rng.choice([0, 3, 60, 400]))
    rows, columns = rng.integers(-spread, spread + 1, (2, n)) if spread else np.zeros((2, n), int)
    if kind == "definite":
        columns = rows
    centre = int(rng.integers(-1, 2)) * (1000 - 2 * spread)
    A = np.ldexp(A, rows[:, None] + columns + centre)
    q = np.ldexp(
        rng.integers(-9, 10, n).astype(float), rows + rng.integers(-spread, spread + 1, n) * int(rng.integers(0, 3))
    )
    return A, np.nan_to_num(q, posinf=1e308, neginf=-1e308)


def point_near(rng, solution):
    """The solution rounded, disturbed a little or much, or any point."""
    rounded = []
    for x in solution:
        try:
            rounded.append(float(x))
        except OverflowError:
            rounded.append(np.finfo(float).max)
    z = np.array(rounded)
    match int(rng.integers(0, 5)):
        case 0:
            return z
        case 1:
            return np.minimum(z * (1 + 1e-9 * rng.standard_normal(len(z))), np.finfo(float).max)
        case 2:
            return np.ldexp(rng.random(len(z)), rng.integers(-1070, 1020, len(z)))
        case 3:
            return np.where(rng.random(len(z)) < 0.5, 0.0, z)
        case _:
            return np.ldexp(rng.integers(-3, 4, len(z)).astype(float), int(rng.integers(-1000, 1000)))


@pytest.mark.parametrize("kind", ["definite", "dominant"])
def test_no_bound_is_below_the_error(kind):
    rng = np.random.default_rng([7, len(kind)])
    bounds = 0
    for _ in range(400):
        with np.errstate(over="ignore", under="ignore"):
            A, q = random_problem(rng, kind)
            solution = exact_solution(A, q)
            z = point_near(rng, solution)
        for found in both(A, q, z):
            assert_honest(A, q, z, found, solution)
            bounds += found.error_bound is not None
    assert bounds > 200
