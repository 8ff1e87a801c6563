"""`w` and both residuals are measured values of the returned z on every path: 10 000 problems, recomputed."""

import numpy as np
import pytest

import lcpstar
from lcpstar import problems

EPS = np.finfo(float).eps


def mixed(count, n, seed):
    """Definite, half rank, skew and unsymmetric problems in units of all sizes, some without a solution."""
    rng = np.random.default_rng(seed)
    B = rng.standard_normal((count, n, n))
    A = B @ B.transpose(0, 2, 1) / n
    kind = rng.integers(4, size=count)
    A[kind == 1] = np.einsum("kij,klj->kil", B[kind == 1][:, :, : (n + 1) // 2], B[kind == 1][:, :, : (n + 1) // 2])
    A[kind == 2] += np.tril(B[kind == 2], -1) - np.tril(B[kind == 2], -1).transpose(0, 2, 1)
    A[kind == 3] = B[kind == 3]
    rows, columns = (2.0 ** rng.integers(-20, 20, (count, n)) for _ in range(2))
    scale = (rng.random(count) < 0.5)[:, None]
    rows, columns = np.where(scale, rows, 1.0), np.where(scale, columns, 1.0)
    return A * rows[:, :, None] * columns[:, None, :], rng.standard_normal((count, n)) * rows


def assert_measured(A, q, z, w, natural):
    """Stacks of problems, in long doubles."""
    wide = A.astype(np.longdouble)
    exact = np.einsum("kij,kj->ki", wide, z) + q
    rounding = (A.shape[-1] + 4) * EPS * (np.einsum("kij,kj->ki", np.abs(A), z) + np.abs(q))
    assert np.all(np.abs(exact - w) <= rounding)
    recomputed = np.abs(np.minimum(z, exact)).max(axis=1)
    assert np.all(np.abs(recomputed - natural) <= rounding.max(axis=1))


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8, 12, 16, 20, 33])
def test_batches_state_what_they_measure(n):
    A, q = mixed(900, n, n)
    found = lcpstar.solve_batch(A, q)
    assert_measured(A, q, found.z, found.w, found.natural_residual)
    assert found.success.mean() > 0.5
    for k in range(0, 900, 90):
        alone = lcpstar.solve(A[k], q[k])
        if found.success[k] and alone.success and np.array_equal(alone.z, found.z[k]):
            rounding = (n + 4) ** 2 * EPS
            assert abs(alone.residual - found.residual[k]) <= rounding


@pytest.mark.parametrize("n", [1, 4, 9, 17, 40, 130])
def test_single_answers_state_what_they_measure(n):
    A, q = mixed(1200 // (n + 8), n, 100 + n)
    for a, b in zip(A, q, strict=True):
        solution = lcpstar.solve(a, b)
        assert_measured(a[None], b[None], solution.z[None], solution.w[None], np.array([solution.natural_residual]))
        assert lcpstar.verify(a, b, solution), (solution, lcpstar.verify(a, b, solution).failures)


METHODS = [
    "lemke",
    "principal_pivoting",
    "block_pivoting",
    "enumerate",
    "interior_point",
    "bilinear",
    "newton",
    "pgs",
    "nncg",
    "admm",
]


@pytest.mark.parametrize("method", METHODS)
def test_methods_by_name_state_what_they_measure(method):
    A, q = mixed(60, 7, 7)
    for a, b in zip(A, q, strict=True):
        solution = lcpstar.solve(a, b, method=method)
        assert_measured(a[None], b[None], solution.z[None], solution.w[None], np.array([solution.natural_residual]))
        assert lcpstar.verify(a, b, solution), (solution, lcpstar.verify(a, b, solution).failures)


@pytest.mark.parametrize("method", ["auto", "interior_point", "newton", "pgs"])
@pytest.mark.parametrize("n", [6, 150])
def test_sparse_answers_state_what_they_measure(method, n):
    sparse = pytest.importorskip("scipy.sparse")
    for seed in range(12):
        A, q = problems.random_spd(n, seed)
        A = np.where(np.abs(np.subtract.outer(range(n), range(n))) <= 2, A, 0.0) + np.eye(n)
        solution = lcpstar.solve(sparse.csr_array(A), q, method=method)
        assert_measured(A[None], q[None], solution.z[None], solution.w[None], np.array([solution.natural_residual]))
        dense = lcpstar.solve(A, q, method=method)
        assert solution.status == dense.status
        assert solution.residual <= 1e-9 or not solution.success
        assert lcpstar.verify(sparse.csr_array(A), q, solution)
