"""`w` and `natural_residual` are those of the point that is returned, whichever path found it."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse

import lcpstar
from lcpstar import _core

EPS = np.finfo(float).eps


def mixed(rng, n):
    """Definite, singular, sparse, general and badly scaled matrices in turn."""
    B = rng.normal(size=(n, n))
    kind = rng.integers(5)
    A = (B @ B.T + np.eye(n), B[:, : n // 2] @ B[:, : n // 2].T, np.triu(B) + n * np.eye(n), B, B @ B.T)[kind]
    units = 2.0 ** rng.integers(-20, 20, size=(2, n)) if kind == 4 else np.ones((2, n))
    return units[0][:, None] * A * units[1], units[0] * rng.normal(size=n)


def assert_measured(A, q, z, w, natural_residual):
    A, q, z = (np.asarray(x, dtype=np.longdouble) for x in (A, q, z))
    exact = np.einsum("...ij,...j->...i", A, z) + q
    size = np.einsum("...ij,...j->...i", np.abs(A), np.abs(z)) + np.abs(q)
    rounding = (q.shape[-1] + 2) * EPS * size
    assert (np.abs(exact - w) <= rounding).all()
    measured = np.abs(np.minimum(z, exact))
    assert (np.abs(measured.max(-1) - natural_residual) <= (rounding + EPS * measured).max(-1)).all()


@pytest.mark.parametrize("n", [1, 2, 3, 4, 8, 12, 16, 17, 24, 40])
def test_numbers_of_a_batch_are_measured(n):
    rng = np.random.default_rng(n)
    problems = [mixed(rng, n) for _ in range(1000)]
    A, q = (np.array(part) for part in zip(*problems, strict=True))
    sols = lcpstar.solve_batch(A, q)
    assert_measured(A, q, sols.z, sols.w, sols.natural_residual)
    assert sols.success.mean() > 0.5
    assert (sols.residual[sols.success] <= 1e-9).all()


@pytest.mark.parametrize("method", _core.METHODS)
def test_numbers_of_a_method_are_measured(method):
    rng = np.random.default_rng(5)
    for n in [1, 2, 3, 5, 9, 14, 20] * 4:
        A, q = mixed(rng, n)
        sol = lcpstar.solve(A, q, method=method, max_iterations=2000)
        assert_measured(A, q, sol.z, sol.w, sol.natural_residual)


@pytest.mark.parametrize("n", [20, 130, 300])
def test_numbers_of_a_sparse_problem_are_measured(n):
    rng = np.random.default_rng(n)
    for _ in range(5):
        B = scipy.sparse.random(n, n, density=3 / n, random_state=rng, format="csr")
        A, q = (B @ B.T + scipy.sparse.eye(n)).tocsr(), rng.normal(size=n)
        sol = lcpstar.solve(A, q)
        assert sol.success
        assert_measured(A.toarray(), q, sol.z, sol.w, sol.natural_residual)
