"""One place that says what a solution is; every test goes through it."""

from __future__ import annotations

import numpy as np


def assert_solves(A, q, solution, tol=1e-9):
    """`w = A z + q`, signs and complementarity, on the caller's numbers, row by row."""
    A, q = np.asarray(A, float), np.asarray(q, float)
    z, w = solution.z, solution.w
    assert solution.success, solution
    assert solution.status == "solved"
    assert (z >= 0).all()
    scale = np.abs(A) @ np.abs(z) + np.abs(q)
    assert (np.abs(A @ z + q - w) <= 8 * len(q) * np.finfo(float).eps * scale).all()
    allowed = 10 * tol * np.abs(q).max(initial=0.0) + 8 * np.finfo(float).eps * scale
    assert (np.abs(np.minimum(z, w)) <= allowed).all()
    assert solution.residual <= tol
    assert solution.natural_residual == np.abs(np.minimum(z, w)).max(initial=0.0)


def assert_farkas(A, q, y, tol=1e-10):
    """`y >= 0, A'y <= 0, q'y < 0`, to rounding."""
    A, q, y = np.asarray(A, float), np.asarray(q, float), np.asarray(y, float)
    assert (y >= 0).all()
    assert y.any()
    assert q @ y < 0
    assert (A.T @ y <= tol * (np.abs(A).T @ y)).all()
