"""A short run of the stress campaign through the Python face (`make stress`, benches/doors.py), and of its referee."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import lcpstar

pytest.importorskip("scipy.sparse")
sys.path.insert(0, str(Path(__file__).parents[1] / "benches"))
import doors
import forgeries
import referee


def test_no_door_gives_a_wrong_answer_and_no_forgery_is_accepted():
    campaign = doors.run(count=13 * doors.CHUNK, seed=20)
    assert campaign.findings == []
    refused = sum(count["refused"] for count in campaign.counts.values())
    assert campaign.problems >= 200
    assert refused >= 500


def test_alpha_after_a_wrong_guess_is_that_of_the_point():
    """The guess says basis {0, 1}, whose z_0 is negative; without it z solves the problem, and w_0 > 0."""
    A, q = np.array([[0.6875, 0.03125], [0.0, 1.0625]]), np.array([1.4375, -1.375])
    rest = np.eye(18) * 2.0
    rest[:2, :2] = A
    for matrix, rhs in ((A, q), (rest, np.concatenate([q, -np.ones(16)]))):
        sol = lcpstar.solve(matrix, rhs, z0=np.ones(len(rhs)))
        assert sol.success
        assert 0 not in sol.alpha
        assert lcpstar.verify(matrix, rhs, sol), lcpstar.verify(matrix, rhs, sol).failures


RAYS_BEYOND_DOUBLES = (
    ([[-2.3e-308, 0.0, 1e307], [-1e307, 2.3e-308, -2.3e-308], [0.0, 1e307, -1e307]], [-2.3e-308, 0.0, 2.3e-308], 1e-14),
    (
        [[-3e-310, 0, 0, 0], [0, -3e-310, 1e307, -3e-310], [3e-310, 1e307, 0, -3e-310], [1e307, 3e-310, 0, 0]],
        [3e-310, 1e307, -1e307, 0],
        1e-9,
    ),
)


@pytest.mark.parametrize(("A", "q", "tol"), RAYS_BEYOND_DOUBLES)
def test_a_ray_that_doubles_do_not_hold_is_no_status(A, q, tol):
    sol = lcpstar.solve(A, q, tol=tol)
    assert lcpstar.verify(A, q, sol, tol=tol), (sol, lcpstar.verify(A, q, sol, tol=tol).failures)


def test_verify_refuses_wrong_residuals_at_the_lower_end_of_the_doubles():
    tiny = 5e-324
    A = np.array([[0, 1, 0, tiny], [1, -tiny, tiny, 1], [tiny, tiny, 1, tiny], [0, 0, tiny, -tiny]])
    q = np.array([tiny, tiny, tiny, 0])
    sol = lcpstar.solve(A, q)
    assert lcpstar.verify(A, q, sol)
    fields = {field: getattr(sol, field) for field in forgeries.FIELDS}
    for residual in (np.inf, 1e300, 1.0):
        assert not lcpstar.verify(A, q, SimpleNamespace(**{**fields, "residual": residual}))


def test_verify_measures_points_whose_scaled_entries_overflow():
    """z' and w' beyond the range of doubles are still equal or not."""
    tiny, huge = 5e-324, 1e154
    A = np.array(
        [
            [tiny, -huge, huge, -tiny, huge, tiny],
            [huge, tiny, 0, 0, 0, tiny],
            [tiny, 0, tiny, tiny, huge, tiny],
            [huge, tiny, tiny, huge, tiny, -huge],
            [-tiny, 0, 0, huge, tiny, 0],
            [tiny, -tiny, 0, huge, 0, tiny],
        ]
    )
    q = np.array([0, 0, 0, tiny, -tiny, 0])
    sol = lcpstar.solve(A, q, tol=1e-14, certify="exact")
    assert sol.success
    assert lcpstar.verify(A, q, sol, tol=1e-14), lcpstar.verify(A, q, sol, tol=1e-14).failures


@pytest.mark.parametrize(
    ("A", "q", "solvable"),
    [
        ([[2.0]], [-1.0], True),
        ([[-2.0]], [-1.0], False),
        ([[0.0, 1.0], [1.0, 0.0]], [-1.0, -1.0], True),
        # Feasible at z = (0, 1), but then w_2 = 1.
        ([[0.0, 1.0], [0.0, 0.0]], [-1.0, 1.0], False),
        # z = (1, 1, 0): the block of the support is singular, and only the row of w_3 gives z_1.
        ([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, -1.0, 0.0]], [-1.0, 0.0, 0.0], True),
        ([], [], True),
    ],
)
def test_the_referee_knows_what_has_a_solution(A, q, solvable):
    A = np.reshape(A, (len(q), len(q)))
    assert referee.Problem(A, q).is_solvable is solvable


def said(z, w, **fields):
    honest = {"status": "solved", "residual": 0.0, "natural_residual": 0.0, "certificate": None}
    alpha = [i for i, x in enumerate(z) if x > 0]
    return SimpleNamespace(z=np.array(z), w=np.array(w), alpha=alpha, **{**honest, **fields})


def test_the_referee_tells_right_from_wrong():
    problem = referee.Problem([[2.0]], [-1.0])
    assert referee.score(problem, said([0.5], [0.0]), 1e-9) == "right"
    no = said([0.0], [-1.0], status="secondary_ray", residual=0.5, natural_residual=1.0)
    assert referee.score(problem, no, 1e-9) == "no"
    for lie in (
        said([0.5 + 1e-6], [2e-6], residual=2e-6, natural_residual=2e-6),
        said([0.5], [0.1]),
        said([0.5], [0.0], residual=1e-9),
        said([-0.5], [-2.0], residual=1.0, natural_residual=2.0),
        said([0.5], [0.0], status="infeasible"),
        said([np.nan], [0.0]),
        said([0.5], [0.0], status="optimal"),
    ):
        with pytest.raises(referee.WrongError):
            referee.score(problem, lie, 1e-9)


def test_the_referee_tells_nearly_solvable_from_not_solvable():
    def score(A, q, tol):
        claim = said([1.0, 0.0], [0.0, -1e-12], natural_residual=1e-12, residual=residual(A, q))
        return referee.score(referee.Problem(A, q), claim, tol)

    def residual(A, q):
        r, _, s = referee.Problem(A, q).scaling
        return float(np.ldexp(1e-12, s + r[1]) / max(1.0, np.ldexp(1.0, s)))

    assert score([[1.0, 0.0], [-1.0, 0.0]], [-1.0, 1.0 - 1e-12], 1e-9) == "nearly"
    # The same with a row so small that only its own numbers show the error.
    with pytest.raises(referee.WrongError, match="residual"):
        score([[1.0, 1.0], [-1e-12, 0.0]], [-1.0, 0.0], 1e-3)
