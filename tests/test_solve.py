"""Right answers: textbook problems, planted solutions, degenerate stacks, published problems."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lcpstar
from lcp_checks import assert_farkas, assert_solves
from lcpstar.problems import box_stack, fathi, murty, psd_half_rank, random_pd
from textbook import CASES

METHODS = ["auto", "lemke"]
#: Solvable, but every covering vector d > 0 ends on a ray: bimatrix games need the Lemke-Howson path.
RAYS = {("swap", "lemke")}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_textbook(case, method):
    solution = lcpstar.solve(case.A, case.q, method=method)
    if (case.name, method) in RAYS:
        assert solution.status == "secondary_ray"
    elif case.solvable:
        assert_solves(case.A, case.q, solution)
        if case.solutions:
            assert min(np.abs(solution.z - z).max() for z in case.solutions) < 1e-12
    else:
        assert solution.status == "infeasible"
        assert_farkas(case.A, case.q, solution.certificate.y)


def test_paper_example_with_d_of_ones_ends_where_the_book_says():
    case = CASES[0]
    solution = lcpstar.solve(case.A, case.q, method="lemke", options=lcpstar.LemkeOptions(d=[1, 1, 1]))
    assert solution.z.tolist() == [0, 2, 3.5]


def test_order_zero():
    solution = lcpstar.solve(np.zeros((0, 0)), [])
    assert solution.success
    assert solution.z.shape == (0,)


@pytest.mark.parametrize("n", [4, 12, 20, 40, 60])
@pytest.mark.parametrize("family", [murty, fathi])
def test_exponential_examples_are_solved_by_a_restart(family, n):
    A, q = family(n)
    solution = lcpstar.solve(A, q)
    assert_solves(A, q, solution)
    if n <= 40:  # beyond that, neighbouring bases differ by less than the rounding of q
        assert solution.alpha == [0]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("n", "seed"), list(itertools.product([1, 2, 5, 16, 40, 100], range(3))))
def test_planted(n, seed, method):
    for family in (random_pd, psd_half_rank):
        A, q = family(n, seed)
        assert_solves(A, q, lcpstar.solve(A, q, method=method))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("mass_ratio", [1.0, 1e4, 1e8])
@pytest.mark.parametrize("boxes", [1, 3, 10, 25])
def test_box_stack_stands(boxes, mass_ratio, method):
    A, q = box_stack(boxes, mass_ratio)
    assert_solves(A, q, lcpstar.solve(A, q, method=method))


def brute_force_solvable(A, q):
    """Whether some complementary basis gives a solution; the 2^n oracle."""
    n = len(q)
    for size in range(n + 1):
        for alpha in itertools.combinations(range(n), size):
            a = list(alpha)
            z = np.zeros(n)
            block = A[np.ix_(a, a)]
            if abs(np.linalg.det(block)) > 1e-9:
                z[a] = np.linalg.solve(block, -q[a])
                if (z >= -1e-9).all() and (A @ z + q >= -1e-9).all():
                    return True
    return False


@settings(max_examples=300, deadline=None)
@given(st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_never_wrong_on_small_integers(n, seed):
    """Ties, singular blocks, no solution: whatever is said must be true."""
    rng = np.random.default_rng(seed)
    A, q = rng.integers(-2, 3, (n, n)).astype(float), rng.integers(-3, 4, n).astype(float)
    solution = lcpstar.solve(A, q)
    if solution.success:
        assert_solves(A, q, solution)
    elif solution.status == "infeasible":
        assert_farkas(A, q, solution.certificate.y)
        assert not brute_force_solvable(A, q)


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 12), st.integers(0, 2**32 - 1))
def test_powers_of_two_change_nothing(n, seed):
    """D_r A D_c with powers of two: the same support, the same digits."""
    rng = np.random.default_rng(seed)
    A, q = random_pd(n, seed)
    rows, columns = 2.0 ** rng.integers(-300, 300, n), 2.0 ** rng.integers(-300, 300, n)
    plain = lcpstar.solve(A, q)
    scaled = lcpstar.solve(rows[:, None] * A * columns, rows * q)
    assert_solves(rows[:, None] * A * columns, rows * q, scaled)
    assert scaled.alpha == plain.alpha
    np.testing.assert_allclose(scaled.z * columns, plain.z, rtol=1e-9, atol=0)


@pytest.mark.parametrize("method", ["auto", "lemke", "bilinear", "enumerate", "interior_point"])
def test_a_huge_z_hides_no_violation(method):
    """No solution exists; z of 1e16 from nearly singular blocks leaves min(z, w) = 5.7 within its own rounding."""
    A = [[0, 2, -1, 2, -1], [0, 2, 2, -2, 0], [-2, 2, 1, -2, 0], [0, 2, -1, 0, -2], [0, 0, 2, 1, -1]]
    q = [1, -2, -3, -3, -3]
    assert lcpstar.solutions(A, q) == []
    assert not lcpstar.solve(A, q, method=method).success


@pytest.mark.parametrize("method", ["auto", "batch"])
def test_a_tiny_unit_of_z_hides_no_violation(method):
    """z in units of 2^-122 beside w in units of 1: min(z, w) is small whatever w is."""
    A, q = random_pd(3, 198)
    rows, columns = 2.0 ** np.array([-60.0, 179, 245]), 2.0 ** np.array([192.0, 122, -248])
    B, p = rows[:, None] * A * columns, rows * q
    alpha = lcpstar.solve(A, q).alpha
    if method == "auto":
        assert lcpstar.solve(B, p).alpha == alpha
    else:
        z = lcpstar.solve_batch(np.stack([B] * 9), np.stack([p] * 9)).z
        np.testing.assert_allclose(z * columns, np.stack([lcpstar.solve(A, q).z] * 9), rtol=1e-12)


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_q_at_the_ends_of_the_range(scale):
    A, q = random_pd(6, 0)
    solution = lcpstar.solve(A, scale * q)
    assert solution.success
    assert solution.alpha == lcpstar.solve(A, q).alpha


@pytest.mark.parametrize("n", [4, 8, 16, 32, 64, 128])
def test_badly_scaled(n):
    """Rows and columns times 10^U(-8, 8): units must not matter."""
    A, q = random_pd(n, 7)
    rng = np.random.default_rng(n)
    rows, columns = 10.0 ** rng.uniform(-8, 8, n), 10.0 ** rng.uniform(-8, 8, n)
    solution = lcpstar.solve(rows[:, None] * A * columns, rows * q)
    assert_solves(rows[:, None] * A * columns, rows * q, solution)
    assert solution.alpha == lcpstar.solve(A, q).alpha


def test_warm_start_costs_no_pivot_and_no_digit():
    A, q = random_pd(30, 3)
    cold = lcpstar.solve(A, q)
    warm = lcpstar.solve(A, q, z0=cold.z)
    assert (warm.iterations, warm.method) == (0, "warm_start")
    assert warm.residual <= max(cold.residual, 1e-15)
    assert_solves(A, q, lcpstar.solve(A, q, z0=np.ones(30)))


def test_a_point_is_not_called_solved_for_being_close():
    A, q = random_pd(20, 1)
    solution = lcpstar.solve(A, q, method="lemke", max_iterations=2)
    assert solution.status == "max_iterations"
    assert solution.iterations == 2
    assert not solution.success


def test_published_problems(corpus):
    """`auto` never lies, and `lemke` solves at least 85 % of the solvable ones."""
    solved = total = 0
    for path in corpus:
        data = np.load(path)
        matrices = data["A"] if data["A"].ndim == 3 else data["A"][None]
        vectors = data["q"] if data["q"].ndim == 2 else data["q"][None]
        statuses = np.broadcast_to(data["status"], len(vectors))
        for A, q, status in zip(matrices, vectors, statuses, strict=True):
            for method in METHODS:
                solution = lcpstar.solve(A, q, method=method)
                if solution.success:
                    assert_solves(A, q, solution)
                assert (solution.status == "infeasible") <= (status == "infeasible"), path
            total += status == "solvable"
            solved += status == "solvable" and solution.success
    assert solved >= 0.85 * total, (solved, total)
