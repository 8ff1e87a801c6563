"""Warm starts: a right guess costs nothing, a nearly right one little, a wrong one no answer and no digit."""

import numpy as np
import pytest

import lcpstar
from lcp_checks import assert_solves
from lcpstar.problems import box_stack, degenerate, psd_half_rank, random_pd, random_spd

PROBLEMS = {
    "random_pd": random_pd(50, seed=2),
    "random_spd": random_spd(50, seed=1),
    "psd_half_rank": psd_half_rank(60, seed=3),
    "box_stack": box_stack(12),
}


def changed(z, count, rng):
    """`z` with `count` entries moved between zero and positive."""
    guess = z.copy()
    for i in rng.choice(len(z), count, replace=False):
        guess[i] = 0.0 if z[i] > 0 else 1.0
    return guess


@pytest.mark.parametrize("method", ["auto", "lemke"])
@pytest.mark.parametrize("name", PROBLEMS)
def test_a_right_support_takes_no_pivot(name, method):
    A, q = PROBLEMS[name]
    cold = lcpstar.solve(A, q, method=method)
    warm = lcpstar.solve(A, q, method=method, z0=cold.z)
    assert (warm.iterations, warm.method) == (0, "warm_start")
    assert warm.residual <= max(cold.residual, 1e-15)


#: Pivots of the cold path, and their mean from supports with 1, 2, 3 wrong indices, at most: a change is explained in
#: the commit.
GOLDEN = {
    "random_pd": (29, 2.0, 3.0, 4.0),
    "random_spd": (19, 2.0, 3.0, 4.0),
    "psd_half_rank": (28, 3.6, 7.2, 8.4),
    "box_stack": (37, 0.6, 1.9, 2.0),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_nearly_right_support_takes_few_pivots(name):
    A, q = PROBLEMS[name]
    rng = np.random.default_rng(0)
    cold = lcpstar.solve(A, q, method="lemke")
    found = [cold.iterations]
    for count in (1, 2, 3):
        pivots = []
        for _ in range(10):
            warm = lcpstar.solve(A, q, method="lemke", z0=changed(cold.z, count, rng))
            assert_solves(A, q, warm)
            assert warm.residual <= max(10 * cold.residual, 1e-14)
            pivots.append(warm.iterations)
        found.append(round(float(np.mean(pivots)), 1))
    assert found[0] == GOLDEN[name][0]
    assert all(mean <= most for mean, most in zip(found, GOLDEN[name], strict=True))


@pytest.mark.parametrize("method", ["auto", "lemke", "block_pivoting", "interior_point"])
def test_a_wrong_guess_costs_no_answer(method):
    rng = np.random.default_rng(1)
    for name, (A, q) in PROBLEMS.items():
        if method == "block_pivoting" and name not in ("random_pd", "random_spd"):
            continue
        cold = lcpstar.solve(A, q, method=method)
        for guess in (np.ones(len(q)), rng.random(len(q)) * (rng.random(len(q)) < 0.5), np.zeros(len(q))):
            warm = lcpstar.solve(A, q, method=method, z0=guess)
            assert_solves(A, q, warm)
            assert warm.residual <= max(10 * cold.residual, 1e-13)


def test_a_ray_from_the_guess_is_not_the_answer():
    """From some of these supports the path ends on a ray: statuses are those without a guess."""
    rng = np.random.default_rng(0)
    for _ in range(300):
        n = int(rng.integers(2, 7))
        A, q = rng.integers(-3, 4, (n, n)).astype(float), rng.integers(-3, 4, n).astype(float)
        cold = lcpstar.solve(A, q)
        warm = lcpstar.solve(A, q, z0=(rng.random(n) < 0.5).astype(float))
        if cold.success or cold.status == "infeasible":
            assert warm.status == cold.status
        if warm.status == "secondary_ray":
            assert warm.ray is not None


def test_degenerate_problems_from_every_neighbour():
    A, q = degenerate(16, seed=1)
    cold = lcpstar.solve(A, q)
    for i in range(16):
        guess = cold.z.copy()
        guess[i] = 0.0 if guess[i] > 0 else 1.0
        assert_solves(A, q, lcpstar.solve(A, q, z0=guess))
