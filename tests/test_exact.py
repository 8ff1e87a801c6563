"""Proofs on the given binary numbers."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import lcpstar
from lcpstar import _core, verify


def proved(A, q, alpha):
    """The proof from a basis as `Fraction`s, checked here."""
    verdict, basis, z, pivots = _core.prove_solution(np.asarray(A, float), np.asarray(q, float), alpha)
    assert verdict == "proved"
    numerators, denominator = z
    exact = [Fraction(x, denominator) for x in numerators]
    support = [j for j, x in enumerate(exact) if x != 0]
    for i in range(len(q)):
        w = sum((Fraction(float(A[i][j])) * exact[j] for j in support), Fraction(float(q[i])))
        assert exact[i] >= 0
        assert w >= 0
        assert exact[i] == 0 or w == 0
        assert w == 0 if i in set(basis) else exact[i] == 0
    return exact, basis, pivots


def test_a_right_basis_takes_no_pivot():
    exact, basis, pivots = proved([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0], [0, 1])
    assert (exact, basis, pivots) == ([Fraction(4, 3), Fraction(7, 3)], [0, 1], 0)


@pytest.mark.parametrize("seed", range(10))
def test_a_wrong_basis_is_repaired(seed):
    rng = np.random.default_rng(seed)
    n = 12
    B = rng.standard_normal((n, n))
    A, q = B @ B.T + np.eye(n), rng.standard_normal(n)
    right = lcpstar.solve(A, q).alpha
    wrong = sorted(set(right) ^ {0, 5})
    _, basis, pivots = proved(A, q, wrong)
    assert sorted(basis) == sorted(right)
    assert 0 < pivots < 5 * n


def test_near_ties_are_decided_on_the_binary_numbers():
    third = 1 / 3
    exact, basis, pivots = proved([[1.0, 0.0], [-3.0, 1.0]], [-third, 1.0], [0])
    assert (exact[0], basis, pivots) == (Fraction(third), [0], 0)
    # w_2 = 3 fl(1/3) - 1 = -2^-54: z_2 must enter.
    exact, basis, pivots = proved([[1.0, 0.0], [3.0, 1.0]], [-third, -1.0], [0])
    assert exact[1] == Fraction(1, 2**54)
    assert pivots >= 1


def test_bad_index_sets_are_named():
    with pytest.raises(lcpstar.errors.IndexSetError, match="7"):
        _core.prove_solution(np.eye(2), np.ones(2), [7])


def test_every_solvable_problem_of_the_corpus_with_n_to_130_is_proved(corpus):
    """Of each batch every seventh; `make corpus` takes them all."""
    count = 0
    for path in corpus:
        with np.load(path) as data:
            A, q, status = data["A"], data["q"], str(np.atleast_1d(data["status"])[0])
        n = A.shape[-1]
        if n > 130 or status != "solvable":
            continue
        A, q = A.reshape(-1, n, n), q.reshape(-1, n)
        for k in range(0, len(A), 7):
            sol = lcpstar.solve(A[k], q[k], certify="exact", time_limit=60)
            assert sol.success
            assert sol.certificate.exact == (path.stem not in ROUNDED_AWAY), path.stem
            if sol.certificate.exact:
                assert verify(A[k], q[k], sol, exact=True)
            count += 1
    assert count > 50


#: Solved to 3e-16, where 40 columns of rank 32 meet 100 rows with w = 0: equations that the rounded data contradict in
#: their last bits. No complementary basis was found that solves the binary numbers exactly.
ROUNDED_AWAY = {"dcabl_n100-asym_100-1-1"}


@pytest.mark.parametrize(
    ("A", "q"),
    [
        ([[0, 1], [3, 1]], [0, -1]),  # z = (1/3, 0): A[alpha, alpha] = 0, row 2 fixes z_1
        ([[1, 1], [1, 1]], [-1, -1]),  # a segment of solutions, A[alpha, alpha] singular
        ([[0, 0, 1], [3, -1, 0], [-2, 3, 1]], [0, 1, 1]),  # a face on which rows 2 and 3 are inequalities
    ],
)
def test_degenerate_solutions_with_a_singular_block_are_proved(A, q):
    sol = lcpstar.solve(A, q, certify="exact")
    assert sol.success
    assert sol.certificate.exact
    assert verify(A, q, sol, exact=True)


def test_small_integer_problems_that_are_solved_are_proved():
    rng = np.random.default_rng(5)
    count = 0
    for _ in range(1500):
        n, m = int(rng.integers(1, 6)), int(rng.integers(1, 4))
        A, q = rng.integers(-m, m + 1, (n, n)).astype(float), rng.integers(-3, 4, n).astype(float)
        sol = lcpstar.solve(A, q, certify="exact")
        if sol.status in ("solved", "infeasible"):
            assert sol.certificate.exact, (A.tolist(), q.tolist())
            assert verify(A, q, sol, exact=True)
            count += 1
    assert count > 1000


def test_the_last_bits_of_q_decide_the_basis():
    """w = 0 in all rows up to rounding: the exact residual of the rounded q says which pairs are basic."""
    rng = np.random.default_rng(3)
    n, k = 30, 12
    B = rng.standard_normal((n, n))
    A = B @ B.T / n
    z = np.concatenate([rng.random(k) + 0.1, np.zeros(n - k)])
    q = -A @ z
    sol = lcpstar.solve(A, q, certify="exact")
    assert sol.success
    assert sol.certificate.exact
    assert k < len(sol.certificate.alpha) < n
    assert verify(A, q, sol, exact=True)


def test_a_problem_that_only_rounding_makes_solvable_is_infeasible():
    third = 1 / 3  # below 1/3, so 3 z = 1 asks more than z <= fl(1/3)
    A, q = np.array([[0.0, -1.0], [0.0, 3.0]]), np.array([third, -1.0])
    assert lcpstar.solve(A, q).success
    sol = lcpstar.solve(A, q, certify="exact")
    assert sol.status == "infeasible"
    assert sol.certificate.exact
    assert "residual" in sol.message
    assert verify(A, q, sol, exact=True)


def test_sparse_problems_are_proved_up_to_their_limit():
    sparse = pytest.importorskip("scipy.sparse")
    m = 8
    T = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(m, m))
    A = sparse.kron(T, sparse.eye_array(m)) + sparse.kron(sparse.eye_array(m), T)
    q = np.random.default_rng(0).standard_normal(m * m) * 0.1
    sol = lcpstar.solve(A, q, certify="exact")
    assert sol.certificate.exact
    assert verify(A, q, sol, exact=True)
    with pytest.raises(lcpstar.errors.TooLargeError, match=r"certify=\"exact\" with a sparse A.*n <= 2000"):
        lcpstar.solve(sparse.eye_array(2001), -np.ones(2001), certify="exact")
