"""Inputs on which fuzzing (`make fuzz`) broke a promise once. Each is as the fuzzer left it, or smaller."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import lcpstar


def exact_w(A, q, z):
    return [
        sum((Fraction(a) * Fraction(x) for a, x in zip(row, z, strict=True)), Fraction(b))
        for row, b in zip(A, q, strict=True)
    ]


def ring(n, value, corner=0.0, far=0.0):
    A = np.zeros((n, n))
    for i in range(n - 1):
        A[i, i + 1] = value
    for i in range(n - 5):
        A[i, i + 5] = far
    A[n - 1, 0] = corner
    return A


@pytest.mark.parametrize(
    ("A", "q"),
    [
        # w was computed on the scaled problem, in which q had become zero or lost digits: w = 0 was printed for w = 3.
        (ring(8, 254.0, far=1e-323), np.full(8, 3.0)),
        (ring(8, -1.7555586765467464e307, far=-0.0125), np.array([0.1, 11.1, 22.1, 33.1, 44.1, 55.1, 65.9, 77.1])),
        (np.array([[-0.0, -2.3e-246], [5.5e301, -0.0]]), np.array([4.0, 79.0])),
        # z = 5e-337 is no double: its rounding 0 does not solve the problem.
        (np.array([[0.0, 4.722366482869645e21, 0.0], [0.0] * 3, [0.0] * 3]), np.array([-2.4866874e-315, 0.0, 0.0])),
        # The solution 4.8e314 is no double.
        (4.14452305e-315 * np.diag(np.ones(7), 1), np.full(8, -2.0)),
        (np.array([[1.7976931348623157e308]]), np.array([-1.56575653125701e-294])),
        # The batch said "solved" with z = 0 and w_1 = -2.
        (
            np.array(
                [[0.0, -8.343699359066055e93, 0.0], [0.0, 3.0, -8.343699359066055e93], [9.0350602e-315, 0.0, 3.0]]
            ),
            np.array([-2.0, 13.0, 32.0]),
        ),
        # Entries of the Farkas vector became infinite in the caller's units.
        (ring(8, 1.0, far=5e-324) - np.diag(np.full(8, 6.0)), np.full(8, -4.0)),
        # q_3 became zero when it was equilibrated, though no number is near the ends: w = 0 for w_3 = q_3, proved.
        (
            np.array(
                [
                    [1.2223578507093907e-117, 0.0, 0.0],
                    [1e140, 5.192296858534828e33, 0.0],
                    [1.5930919111324523e-58, -1.5, 1.0],
                ]
            ),
            np.array([1e140, 0.0, -5.147557589468029e-85]),
        ),
    ],
)
@pytest.mark.parametrize("method", ["auto", "exact", "lemke", "interior_point", "bilinear", "batch"])
def test_numbers_at_both_ends_of_the_doubles(A, q, method):
    n = len(q)
    if method == "batch":
        sols = lcpstar.solve_batch(A[None], q[None], alpha0=np.zeros((1, n), dtype=bool))
        z, w, solved = sols.z[0], sols.w[0], bool(sols.success[0])
    else:
        exact = {"certify": "exact", "time_limit": 5} if method == "exact" else {"method": method}
        solution = lcpstar.solve(A, q, **exact)
        proved = solution.certificate is not None and solution.certificate.exact
        z, w, solved = solution.z, solution.w, solution.success and not proved
        if solution.status == "infeasible":
            assert np.isfinite(np.asarray(solution.certificate.y, float)).all()
    assert np.isfinite(z).all()
    assert (z >= 0).all()
    size = np.abs(A) @ z + np.abs(q)
    for i, value in enumerate(exact_w(A, q, z)):
        assert abs(value - Fraction(w[i])) <= Fraction(float((n + 4) * 2.0**-52 * size[i])) + Fraction(5e-324)
        if solved:
            allowed = 1e-8 * np.abs(q).max() + 2.0**-48 * size[i]
            assert abs(min(value, Fraction(z[i]))) <= Fraction(float(allowed)) + Fraction(5e-324)


def test_an_overflowing_transform_names_its_entry():
    with pytest.raises(lcpstar.errors.NotFiniteError, match=r"M\[0, 0\] = inf"):
        lcpstar.ppt([[1e-310]], [0])


def test_messages_never_say_that_a_small_residual_is_large():
    """The row test had failed, and the message said `residual 5.77e-17 > tol 1e-9`."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        n = 4
        A = rng.integers(-2, 3, (n, n)) * 2.0 ** rng.integers(-40, 41, n)
        q = -rng.integers(0, 3, n) * 2.0 ** rng.integers(-40, 41, n)
        solution = lcpstar.solve(A, q, max_iterations=3)
        if " > tol " in solution.message:
            assert solution.residual > 1e-9


def test_the_linear_programme_of_the_portfolio_counts_its_pivots():
    """`max_iterations=7` made 8 pivots: the limit was handed to all members but this one."""
    n = 14
    A = np.zeros((n, n))
    for i in range(n):
        for j in range(n):
            block = j // 2 - i // 2
            A[i, j] = 3.0 if block == 1 else 0.005 if block and (7 * i + 3 * j) % 5 == 0 else 0.0
    q = np.array([-4.0, -4.0, -3.0, -3.0, -2.0, -2.0, -1.0, -1.0, 8.0, 8.0, 1.0, 1.0, 2.0, 2.0])
    for method in ("auto", "lemke"):
        for limit in range(40):
            solution = lcpstar.solve(A, q, method=method, tol=1e-15, max_iterations=limit)
            assert solution.iterations <= limit
