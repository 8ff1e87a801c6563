"""Each documented status is reached for the right reason, says what to do next, and limits are kept."""

from __future__ import annotations

import re
import time
from pathlib import Path

import numpy as np
import pytest

import lcpstar
from answers import BELOW, NEARLY, answer
from lcp_checks import assert_farkas, assert_solves
from lcpstar.problems import murty

METHODS = {
    "auto",
    "lemke",
    "lemke_howson",
    "principal_pivoting",
    "block_pivoting",
    "chandrasekaran",
    "enumerate",
    "bilinear",
    "interior_point",
    "potential_reduction",
}
#: A P-matrix: every method but two takes it.
P = np.array([[2.0, 1.0], [1.0, 2.0]])
Q = np.array([-5.0, -6.0])
#: z = (0, 1) is feasible and there is no solution.
GAP_A = np.array([[-1.0, 1.0], [-1.0, 2.0]])
GAP_Q = np.array([-1.0, -1.0])


def verified(A, q, solution, **options):
    report = lcpstar.verify(A, q, solution, **options)
    assert report, str(report)


# solved


@pytest.mark.parametrize("method", sorted(METHODS - {"lemke_howson", "chandrasekaran"}))
def test_solved(method):
    solution = lcpstar.solve(P, Q, method=method)
    assert_solves(P, Q, solution)
    assert np.allclose(solution.z, [4 / 3, 7 / 3])
    assert solution.certificate.kind == "solution"
    assert solution.message.startswith("solved")


def test_solved_by_the_methods_of_a_structure():
    game = np.array([[0.0, 1.0], [2.0, 0.0]])
    assert_solves(game, -np.ones(2), lcpstar.solve(game, -np.ones(2), method="lemke_howson"))
    Z = np.array([[2.0, -1.0], [-1.0, 2.0]])
    assert_solves(Z, -np.ones(2), lcpstar.solve(Z, -np.ones(2), method="chandrasekaran"))


def test_nearly_solved_is_not_solved():
    """The same point passes with a tolerance above its residual and fails with one below it."""
    A, q = np.array([[1.0, 1.0], [1.0, 1.0 + 2.0**-30]]), np.array([-1.0, -1.0])
    loose = lcpstar.solve(A, q, method="interior_point", tol=1e-2, max_iterations=4)
    assert 0 <= loose.residual <= 1e-2
    for tol in (1e-3, 1e-6, 1e-9):
        solution = lcpstar.solve(A, q, method="interior_point", tol=tol, max_iterations=4)
        assert solution.success == (solution.residual <= tol)


# infeasible


@pytest.mark.parametrize("method", ["auto", "lemke", "principal_pivoting", "interior_point"])
@pytest.mark.parametrize("certify", ["float", "exact"])
def test_infeasible(method, certify):
    A, q = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([-1.0, -1.0])
    solution = lcpstar.solve(A, q, method=method, certify=certify)
    assert solution.status == "infeasible"
    assert not solution.success
    assert_farkas(A, q, [float(y) for y in solution.certificate.y])
    assert solution.certificate.exact
    assert "no z >= 0" in solution.message or "proved" in solution.message
    verified(A, q, solution, exact=True)


def test_infeasible_z_matrix():
    A, q = np.array([[0.0, -1.0], [0.0, 1.0]]), np.array([-1.0, 0.0])
    solution = lcpstar.solve(A, q, method="chandrasekaran")
    assert solution.status == "infeasible"
    assert_farkas(A, q, solution.certificate.y)


def test_nearly_infeasible():
    """w_1 + w_2 = 2^-40 z_1 - 2 >= 0 needs a large z; there is one."""
    y = lcpstar.result.Certificate("nearly_infeasible", y=np.ones(2), bound=2.0**41)
    verified(NEARLY, BELOW, answer(NEARLY, BELOW, [0, 0], "nearly_infeasible", certificate=y))
    z = [2.0**41, 2.0**41 - 1]
    verified(NEARLY, BELOW, answer(NEARLY, BELOW, z, certificate=None), exact=True)


def test_feasible_without_a_solution():
    """FEA(q, A) is not empty and SOL(q, A) is: no method may say solved or infeasible."""
    assert (GAP_A @ [0, 1] + GAP_Q >= 0).all()
    assert lcpstar.solutions(GAP_A, GAP_Q) == []
    for method in sorted(METHODS - {"lemke_howson", "chandrasekaran"}):
        for certify in ("float", "exact"):
            solution = lcpstar.solve(GAP_A, GAP_Q, method=method, certify=certify)
            assert solution.status not in ("solved", "infeasible"), (method, solution)
            assert solution.certificate is None or solution.certificate.kind in ("ray", "not_sufficient")


# secondary_ray


def test_secondary_ray():
    A, q = GAP_A, GAP_Q
    solution = lcpstar.solve(A, q, method="lemke", options=lcpstar.LemkeOptions(d=[1.0, 1.0]))
    assert solution.status == "secondary_ray"
    ray = solution.ray
    assert (ray.z_hat >= 0).all()
    assert ray.z_hat.any()
    w_hat = A @ ray.z_hat + ray.d * ray.z0_hat
    assert (w_hat >= 0).all()
    assert np.allclose(w_hat, ray.w_hat)
    assert (ray.z_hat * w_hat == 0).all()
    assert 'method="auto"' in solution.message
    verified(A, q, solution)
    exact = lcpstar.solve(A, q, method="lemke", certify="exact", options=lcpstar.LemkeOptions(d=[1.0, 1.0]))
    assert exact.status == "secondary_ray"
    assert exact.certificate.kind == "ray"
    assert exact.certificate.exact


def test_a_ray_always_comes_with_its_ray():
    """`auto` once reported the status of Lemke's method with the point of the linear programme, which has no ray."""
    rng = np.random.default_rng(0)
    seen = 0
    for _ in range(300):
        n = int(rng.integers(2, 7))
        A, q = rng.integers(-3, 3, (n, n)).astype(float), rng.integers(-3, 1, n).astype(float)
        for method in ("auto", "lemke"):
            solution = lcpstar.solve(A, q, method=method)
            if solution.status == "secondary_ray":
                assert solution.ray is not None
                verified(A, q, solution)
                seen += 1
    assert seen > 50


# max_iterations


@pytest.mark.parametrize(
    ("method", "options"),
    [
        ("lemke", lcpstar.LemkeOptions(d=np.ones(12))),
        ("lemke", None),
        ("auto", None),
        ("principal_pivoting", None),
        ("bilinear", None),
        ("interior_point", lcpstar.InteriorPointOptions(finish=False)),
        ("potential_reduction", None),
    ],
)
@pytest.mark.parametrize("limit", [0, 1, 2, 5])
def test_max_iterations_is_exact(method, options, limit):
    A, q = murty(12)
    solution = lcpstar.solve(A, q, method=method, max_iterations=limit, options=options)
    assert solution.iterations <= limit
    if not solution.success:
        assert solution.status == "max_iterations"
        assert solution.iterations == limit
        assert "max_iterations" in solution.message


def test_max_iterations_of_a_path_of_known_length():
    """Lemke with d = e needs 2^n - 1 pivots on Murty's example (and the one that z_0 enters with)."""
    n = 8
    A, q = murty(n)
    options = lcpstar.LemkeOptions(d=np.ones(n))
    needed = lcpstar.solve(A, q, method="lemke", options=options, max_iterations=10**6).iterations
    assert needed >= 2**n - 1
    assert lcpstar.solve(A, q, method="lemke", options=options, max_iterations=needed).success
    short = lcpstar.solve(A, q, method="lemke", options=options, max_iterations=needed - 1)
    assert (short.status, short.iterations) == ("max_iterations", needed - 1)


# time_limit


@pytest.mark.parametrize("method", sorted(METHODS - {"lemke_howson", "chandrasekaran", "enumerate"}))
def test_a_time_limit_that_has_passed(method):
    rng = np.random.default_rng(0)
    A, q = rng.standard_normal((60, 60)), -rng.random(60)
    solution = lcpstar.solve(A, q, method=method, time_limit=1e-9)
    assert solution.status == "time_limit"
    assert solution.z.shape == (60,)
    assert "raise time_limit" in solution.message


def test_a_time_limit_stops_enumeration_sets_and_classes():
    n = 24
    start = time.perf_counter()
    solution = lcpstar.solve(-np.eye(n) - 0.1, -np.ones(n), method="enumerate", time_limit=0.1)
    assert solution.status == "time_limit"
    rng = np.random.default_rng(0)
    with pytest.raises(lcpstar.errors.TimeLimitError, match="time_limit"):
        lcpstar.solutions(rng.standard_normal((40, 40)), rng.standard_normal(40), time_limit=0.1)
    verdict = lcpstar.classes.check(rng.integers(-9, 10, (10, 10)), "Q0", time_limit=0.1)
    assert verdict.holds is not True
    assert time.perf_counter() - start < 5


def test_an_exact_proof_keeps_the_time_limit_and_says_that_it_did_not_finish():
    rng = np.random.default_rng(0)
    n = 150
    solution = lcpstar.solve(rng.standard_normal((n, n)), rng.standard_normal(n), certify="exact", time_limit=0.2)
    if not solution.success:  # on a busy machine the time may be over after a path that ended on a ray
        assert solution.status in ("time_limit", "secondary_ray")
    if solution.certificate is None or not solution.certificate.exact:
        assert "not proved" in solution.message


def test_an_exact_path_with_ties_ends():
    """The weights of a p-adic solution's combination vanished on (1, 1, 1, -1), and more digits were asked for ever."""
    for n in range(1, 8):
        solution = lcpstar.solve(np.eye(n) / 4, np.full(n, -1.75), certify="exact", max_iterations=0)
        assert solution.status == "solved"
        assert solution.certificate.z == [7] * n


# numerical_breakdown


@pytest.mark.parametrize(
    ("method", "A", "q", "text"),
    [
        ("chandrasekaran", [[1, 1], [0, 1]], [-1, -1], r"A is not a Z-matrix: A\[0, 1\] = 1"),
        ("lemke_howson", [[1, 0], [0, 1]], [-1, -1], r"not \[\[0, C\], \[D, 0\]\]"),
        ("principal_pivoting", GAP_A, GAP_Q, "not sufficient"),
        ("block_pivoting", [[0, 0], [0, 0]], [-1, -1], "not a P-matrix"),
        ("enumerate", GAP_A, GAP_Q, "no index set"),
        ("bilinear", [[0, 0], [0, 0]], [-1, -1], "no z >= 0"),
        ("interior_point", GAP_A, GAP_Q, "residual"),
        ("potential_reduction", [[0, 0], [0, 0]], [-1, -1], "strictly feasible"),
    ],
)
def test_numerical_breakdown_names_the_reason_and_the_way_out(method, A, q, text):
    solution = lcpstar.solve(A, q, method=method)
    assert solution.status == "numerical_breakdown"
    assert re.search(text, solution.message), solution.message
    assert 'method="auto"' in solution.message


def test_not_sufficient_is_proved():
    solution = lcpstar.solve(GAP_A, GAP_Q, method="principal_pivoting")
    assert solution.certificate.kind == "not_sufficient"
    verified(GAP_A, GAP_Q, solution)


# the table


def test_the_documented_table_is_complete():
    text = (Path(__file__).parents[1] / "docs" / "statuses.md").read_text().split("## Limits")[0]
    rows = dict(re.findall(r"^\| `(\w+)` \|(.*)\|$", text, flags=re.MULTILINE))
    assert set(rows) == {str(status) for status in lcpstar.Status}
    for status, row in rows.items():
        tests = re.findall(r"`(test_\w+)`", row)
        assert tests, f"{status} has no test"
        assert all(name in globals() for name in tests), tests
