"""The pivoting methods beside each other: answers, proofs, golden pivot counts, parts of a problem."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lcpstar
from lcp_checks import assert_farkas, assert_solves
from lcpstar.problems import (
    box_stack,
    csizmadia,
    degenerate,
    fathi,
    morris,
    murty,
    obstacle_1d,
    psd_half_rank,
    random_pd,
)

ANY = ["auto", "lemke", "principal_pivoting", "enumerate"]


def check(A, q, solution):
    """Whatever is said must be true; returns the status."""
    if solution.success:
        assert_solves(A, q, solution)
    elif solution.status == "infeasible":
        assert_farkas(A, q, solution.certificate.y)
    assert lcpstar.verify(A, q, solution)
    return solution.status


@settings(max_examples=300, deadline=None)
@given(st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_methods_agree_on_small_integers(n, seed):
    rng = np.random.default_rng(seed)
    A = rng.integers(-2, 3, (n, n)).astype(float) * (rng.random((n, n)) < 0.7)
    q = rng.integers(-3, 4, n).astype(float)
    said = {method: check(A, q, lcpstar.solve(A, q, method=method)) for method in ANY}
    assert not {"solved", "infeasible"} <= set(said.values()), said
    if said["enumerate"] == "solved":
        assert said["auto"] == "solved"


@settings(max_examples=300, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_principal_pivoting_always_ends_with_an_answer_or_a_proof(n, seed):
    rng = np.random.default_rng(seed)
    A, q = rng.integers(-2, 3, (n, n)).astype(float), rng.integers(-3, 4, n).astype(float)
    solution = lcpstar.solve(A, q, method="principal_pivoting")
    if check(A, q, solution) not in ("solved", "infeasible"):
        assert solution.certificate.kind == "not_sufficient", solution.message
        assert lcpstar.verify(A, q, solution).exact


@pytest.mark.parametrize("n", [3, 10, 30, 60])
@pytest.mark.parametrize("family", [random_pd, psd_half_rank, degenerate])
def test_principal_pivoting_solves_sufficient_problems(family, n):
    for seed in range(4):
        A, q = family(n, seed)
        assert_solves(A, q, lcpstar.solve(A, q, method="principal_pivoting"))


def test_a_wrong_refutation_is_not_verified():
    A, q = np.array([[0.0, 1.0], [1.0, 0.0]]), np.array([-1.0, -1.0])
    solution = lcpstar.solve(A, q, method="principal_pivoting")
    assert solution.certificate.kind == "not_sufficient"
    assert not lcpstar.verify(np.eye(2), q, solution)


@settings(max_examples=200, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_chandrasekaran_decides_z_matrices(n, seed):
    rng = np.random.default_rng(seed)
    A = -rng.integers(0, 3, (n, n)).astype(float)
    np.fill_diagonal(A, rng.integers(-1, 8, n))
    q = rng.integers(-3, 4, n).astype(float)
    solution = lcpstar.solve(A, q, method="chandrasekaran")
    assert check(A, q, solution) in ("solved", "infeasible")
    assert solution.iterations <= n
    assert lcpstar.solve(A, q).status == solution.status


def test_chandrasekaran_names_the_entry_that_is_not_z():
    solution = lcpstar.solve([[1, -1], [0.5, 1]], [-1, -1], method="chandrasekaran")
    assert solution.status == "numerical_breakdown"
    assert "A[1, 0] = 0.5" in solution.message


def test_enumerate_refuses_large_problems():
    with pytest.raises(lcpstar.errors.TooLargeError, match="n <= 24, got n = 25"):
        lcpstar.solve(np.eye(25), -np.ones(25), method="enumerate")


@pytest.mark.parametrize("mass_ratio", [1e4, 1e6])
@pytest.mark.parametrize("boxes", [5, 6, 8, 12, 16])
def test_stacks_of_heavy_on_light_need_no_portfolio(boxes, mass_ratio):
    """Errors of earlier pivots, times the mass ratio, must not be pivots: paths stay short and end on a solution."""
    for seed in range(10):
        A, q = box_stack(boxes, mass_ratio, seed=seed)
        found = lcpstar.solve(A, q)
        assert_solves(A, q, found)
        assert found.method in ("lemke_small", "block_pivoting", "pieces")
        assert found.iterations <= 2 * len(q)


@pytest.mark.parametrize("boxes", [17, 25, 32])
def test_heavy_on_light_holds_in_every_row(boxes):
    """Above n = 64 block pivoting goes first: its point need not satisfy the light rows, and is not believed."""
    for seed in range(8):
        A, q = box_stack(boxes, 1e8, seed=seed)
        assert_solves(A, q, lcpstar.solve(A, q))


def test_islands_get_the_digits_they_get_alone():
    stacks = [box_stack(1 + k % 3, seed=k) for k in range(100)]
    n = sum(len(q) for _, q in stacks)
    A, q, at = np.zeros((n, n)), np.concatenate([q for _, q in stacks]), 0
    order = np.random.default_rng(0).permutation(n)
    alone = np.zeros(n)
    for B, p in stacks:
        A[at : at + len(p), at : at + len(p)] = B
        alone[at : at + len(p)] = lcpstar.solve(B, p).z
        at += len(p)
    whole = lcpstar.solve(A, q)
    assert_solves(A, q, whole)
    assert whole.z.tobytes() == alone.tobytes()
    assert len(whole.pieces) >= 100
    mixed = lcpstar.solve(A[np.ix_(order, order)], q[order])
    assert_solves(A[np.ix_(order, order)], q[order], mixed)


def test_a_triangular_problem_is_solved_block_by_block():
    rng = np.random.default_rng(3)
    n = 20
    A = np.triu(rng.standard_normal((n, n)), 1) / n + np.diag(1 + rng.random(n))
    solution = lcpstar.solve(A, -np.ones(n))
    assert_solves(A, -np.ones(n), solution)
    assert [indices for indices, _ in solution.pieces] == [[i] for i in reversed(range(n))]


def test_pairs_that_cannot_be_positive_are_dropped():
    A, q = random_pd(40, 0)
    A[34:] = np.abs(A[34:])
    q[34:] = 1.0
    solution = lcpstar.solve(A, q)
    assert_solves(A, q, solution)
    assert max(max(indices) for indices, _ in solution.pieces) < 34
    assert not solution.z[34:].any()


def test_a_problem_of_one_part_has_no_pieces():
    A, q = random_pd(8, 0)
    assert lcpstar.solve(A, q).pieces == []


def test_an_infeasible_island_proves_the_whole_infeasible():
    A, q = random_pd(20, 0)
    A[10, :], A[:, 10], A[10, 10], q[10] = 0.0, 0.0, -1.0, -1.0
    solution = lcpstar.solve(A, q)
    assert check(A, q, solution) == "infeasible"
    assert solution.pieces


def test_obstacle_in_at_most_n_pivots():
    A, q = obstacle_1d(60)
    solution = lcpstar.solve(A, q, method="chandrasekaran")
    assert_solves(A, q, solution)
    assert solution.iterations == len(solution.alpha) <= 60


#: Pivots of auto, lemke and principal_pivoting: a change is explained in the commit.
GOLDEN = {
    ("murty", 4): (10, 2, 1),
    ("murty", 20): (2, 2, 1),
    ("murty", 40): (2, 2, 1),
    ("fathi", 4): (6, 4, 1),
    ("fathi", 20): (18, 4, 1),
    ("fathi", 60): (8, 4, 1),
    ("csizmadia", 4): (5, 5, 4),
    ("csizmadia", 32): (64, 33, 32),
    ("csizmadia", 60): (120, 144, 97),
    ("morris", 5): (6, 6, 13),
    ("morris", 15): (26, 16, 113),
    ("morris", 31): (56, 32, 481),
    ("box_stack", 1): (3, 4, 3),
    ("box_stack", 3): (7, 10, 9),
    ("box_stack", 10): (24, 31, 30),
    ("degenerate", 4): (2, 2, 1),
    ("degenerate", 16): (4, 4, 3),
    ("degenerate", 30): (11, 9, 36),
    ("murty", 8): (26, 2, 1),
    ("murty", 60): (2, 749, 1),
    ("fathi", 40): (8, 4, 1),
    ("csizmadia", 16): (17, 17, 16),
    ("morris", 59): (118, 60, 2353),
    ("all_ties", 4): (3, 3, 6),
    ("all_ties", 15): (26, 16, 113),
    ("all_ties", 32): (61, 17, 496),
    ("all_ties", 60): (111, 31, 2382),
}


def all_ties(n):
    """Kostreva's first example for any n: q = -e, equal row sums, so that every row ties in the first ratio test."""
    return np.eye(n) + 2.0 * np.eye(n, k=1) + 2.0 * np.eye(n, k=1 - n), -np.ones(n)


FAMILIES = (murty, fathi, csizmadia, morris, box_stack, degenerate, all_ties)


def test_kostreva_1_cycles_without_careful_ties():
    """[Kos79], the first example, as in QuantEcon.py's tests of `lcp_lemke`."""
    A, q = np.array([[1.0, 2, 0], [0, 1, 2], [2, 0, 1]]), -np.ones(3)
    solution = lcpstar.solve(A, q, method="lemke")
    assert_solves(A, q, solution)
    assert solution.z == pytest.approx([1 / 3] * 3)
    assert solution.iterations == 4


def test_kostreva_2_cycles_without_lexico():
    """[Kos79], the second example: with careful ties a ray, and no solution at all."""
    A, q = np.array([[1.0, -1, 3], [2, -1, 3], [-1, -2, 0]]), -np.ones(3)
    one_path = lcpstar.solve(A, q, method="lemke", options=lcpstar.LemkeOptions(restarts=0))
    assert one_path.iterations == 1
    solution = lcpstar.solve(A, q, certify="exact")
    assert solution.status == "infeasible"
    assert solution.certificate.exact
    assert (solution.z >= 0).all()


@pytest.mark.parametrize("case", GOLDEN, ids=lambda case: f"{case[0]}-{case[1]}")
def test_golden_pivot_counts(case):
    family = next(family for family in FAMILIES if family.__name__ == case[0])
    A, q = family(case[1])
    found = [lcpstar.solve(A, q, method=method) for method in ("auto", "lemke", "principal_pivoting")]
    for solution in found:
        assert_solves(A, q, solution)
    assert tuple(solution.iterations for solution in found) == GOLDEN[case]
