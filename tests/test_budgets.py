"""Budgets of class questions: whatever runs out is undecided, and no limit means no limit."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

import lcpstar
from lcpstar import classes, errors


def gram(n, seed):
    G = np.random.default_rng(seed).integers(-3, 4, (n, n))
    return G @ G.T


def _triangular(n):
    """P, but neither definite nor dominant: every index set is visited."""
    return np.triu(np.full((n, n), 7), 1) + np.eye(n, dtype=int)


@pytest.mark.parametrize("n", [7, 8, 9])
@pytest.mark.parametrize("limit", [0.0, 0.003, 0.05])
def test_a_class_that_rests_on_an_undecided_one_is_undecided(n, limit):
    A = gram(n, n)
    report = lcpstar.classify(A, time_limit=limit)
    verdicts = [*report.values(), *(classes.check(A, s, time_limit=limit) for s in classes.CLASSES if s not in _SMALL)]
    for verdict in verdicts:
        assert verdict.reason
        assert verdict.holds is not False or verdict.check() is True
        if verdict.symbol in ("PSD", "P0", "SU", "CSU", "RSU", "C0", "Q0"):
            assert verdict.holds is not False


# Offered up to lower orders only.
_SMALL = ("Ec", "cQ0")


def test_one_refuted_part_decides_an_intersection_whose_other_part_is_open():
    A = _triangular(12)
    A[0, 0] = -1  # not in E0, found at once; L2 would take long
    assert classes.check(A, "L", time_limit=5).holds is False


@pytest.mark.parametrize("limit", [math.inf, 1e300, 1e19, np.float64("inf")])
def test_an_infinite_time_limit_is_none(limit):
    assert classes.check(_triangular(12), "E0", time_limit=limit).holds is True
    assert lcpstar.classify(_triangular(6), ["E0", "RSU"], time_limit=limit).undecided == ()
    assert classes.solution_set([[1]], [-1], time_limit=limit).components == 1
    assert lcpstar.explore("P => P0", n=2, entries=[0, 1], time_limit=limit).complete


def test_completely_q_is_refuted_beyond_the_order_of_q():
    A = np.eye(12, dtype=int)
    A += np.where(np.arange(12) == (np.arange(12)[:, None] + 1) % 12, -1, 0)  # singular: A e = 0, and minimal with it
    verdict = classes.check(A, "cQ")
    assert verdict.holds is False
    assert verdict.check() is True


def test_a_point_of_a_solution_set_is_looked_at_after_the_time_limit_of_the_set():
    A = _triangular(10)
    found = classes.solution_set(A, [-1] * 10, time_limit=1)
    time.sleep(1)
    assert found.local(found.faces[0].vertices[0]).stable


def test_a_search_through_small_blocks_keeps_its_time_limit():
    G = np.random.default_rng(0).normal(size=(16, 16))
    for symbol in ("cE0s", "C0(1)", "C0f"):
        start = time.perf_counter()
        verdict = classes.check(G @ G.T, symbol, time_limit=0.3)
        assert time.perf_counter() - start < 2  # half a second more, on a machine that has other work
        assert verdict.holds is None


@pytest.mark.parametrize("threads", [1, 2])
def test_an_exploration_whose_single_matrices_take_long_keeps_its_time_limit(threads):
    start = time.perf_counter()
    found = lcpstar.explore("Q => P0", n=6, samples=1000, time_limit=0.5, threads=threads)
    assert time.perf_counter() - start < 2  # half a second, on a machine that has other work
    assert not found.complete
    assert lcpstar.explore("Q => P0", n=6, resume=found, time_limit=0).scanned == found.scanned


@pytest.mark.parametrize("limit", ["1", True, None.__class__, [1], 1j])
def test_a_time_limit_that_is_no_number_is_named(limit):
    with pytest.raises(errors.OptionTypeError, match="time_limit must be a real number"):
        classes.check([[1]], "P", time_limit=limit)
