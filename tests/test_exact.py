"""Proofs on the given binary numbers, and `verify`: each check fails when exactly its statement is broken."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

import lcpstar
from lcpstar import _core, verify
from lcpstar.result import Certificate, Ray


def answer(sol, **changes):
    fields = ["z", "w", "status", "residual", "natural_residual", "alpha", "certificate", "ray"]
    return SimpleNamespace(**{**{f: getattr(sol, f) for f in fields}, **changes})


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
    assert verify(A.toarray(), q, sol, exact=True)
    with pytest.raises(lcpstar.errors.TooLargeError, match=r"certify=\"exact\" with a sparse A.*n <= 2000"):
        lcpstar.solve(sparse.eye_array(2001), -np.ones(2001), certify="exact")


# verify


A2, Q2 = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-5.0, -6.0])


def test_a_solution_is_verified_in_both_ways():
    sol = lcpstar.solve(A2, Q2)
    assert verify(A2, Q2, sol)
    report = verify(A2, Q2, sol, exact=True)
    assert report
    assert report.exact
    assert "verified in rational arithmetic" in str(report)
    assert not verify(A2, Q2, sol).exact


@pytest.mark.parametrize(
    ("changes", "broken"),
    [
        ({"z": np.array([1.0, 2.0])}, "w = A z + q"),
        ({"w": np.array([0.0, 1.0])}, "w = A z + q"),
        ({"natural_residual": 1.0}, "natural_residual"),
        ({"residual": 1.0}, "residual <= tol"),
        ({"z": np.array([1.0])}, "z is a finite vector"),
        ({"w": np.array([np.nan, 0.0])}, "w is a finite vector"),
        ({"alpha": [0, 5]}, "alpha is an index set"),
        ({"certificate": Certificate("infeasible")}, "certificate is of a solution"),
    ],
)
def test_one_broken_field_is_found(changes, broken):
    report = verify(A2, Q2, answer(lcpstar.solve(A2, Q2), **changes))
    assert not report
    assert any(broken in check.name for check in report.failures)
    assert "NOT verified" in str(report)


def test_a_wrong_solved_is_found():
    z = np.array([1.0, 0.0])
    w = A2 @ z + Q2
    sol = answer(lcpstar.solve(A2, Q2), z=z, w=w, natural_residual=float(np.max(np.abs(np.minimum(z, w)))))
    assert [c.name for c in verify(A2, Q2, sol).failures] == [
        "|min(z, w)| is small in every row",
        "every row holds to its own numbers",
    ]


def test_a_basis_that_is_not_exactly_right_is_found():
    sol = answer(lcpstar.solve(A2, Q2), alpha=[0])
    assert verify(A2, Q2, sol)
    assert [c.name for c in verify(A2, Q2, sol, exact=True).failures] == ["exact w >= 0 at the basis alpha"]


def test_an_exact_certificate_is_checked():
    sol = lcpstar.solve(A2, Q2)
    right = Certificate("solution", exact=True, alpha=[0, 1], z=[Fraction(4, 3), Fraction(7, 3)])
    assert verify(A2, Q2, answer(sol, certificate=right)).exact
    off = replace(right, z=[Fraction(4, 3), Fraction(7, 3) + Fraction(1, 10**30)])
    failed = {c.name for c in verify(A2, Q2, answer(sol, certificate=off)).failures}
    assert failed == {"exact z'w = 0", "w = 0 on alpha, z = 0 outside"}
    other = Certificate("solution", exact=True, alpha=[0, 1], z=[1.0, 2.0])
    assert not verify(A2, Q2, answer(sol, certificate=other))


def infeasible(y, exact=False):
    A, q = np.array([[0.0, -0.1], [-0.3, 0.0]]), np.array([1.0, -1.0])
    z = np.zeros(2)
    sol = SimpleNamespace(
        z=z, w=q, status="infeasible", residual=1.0, natural_residual=1.0, alpha=[], ray=None,
        certificate=Certificate("infeasible", exact=exact, y=y),
    )  # fmt: skip
    return A, q, sol


def test_farkas_vectors_are_checked():
    assert verify(*infeasible(np.array([0.0, 1.0])))
    assert verify(*infeasible(np.array([0.0, 1.0])), exact=True).exact
    assert verify(*infeasible([Fraction(0), Fraction(1, 3)], exact=True)).exact
    for y in ([1.0, 0.0], [2.0, 1.0], [0.0, -1.0], [0.0, 1.0, 0.0]):
        assert not verify(*infeasible(np.array(y)))
        assert not verify(*infeasible(np.array(y)), exact=True)
    A, q, sol = infeasible(None)
    assert not verify(A, q, sol)


def test_a_ray_is_checked():
    A, q = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([-1.0, -1.0])
    ray = Ray(
        z=np.zeros(2), z0=1.0, z_hat=np.ones(2), z0_hat=0.0, w_hat=np.zeros(2), d=np.ones(2)
    )  # fmt: skip
    z = np.zeros(2)
    sol = SimpleNamespace(
        z=z, w=q, status="secondary_ray", residual=1.0, natural_residual=1.0, alpha=[], certificate=None, ray=ray
    )
    assert verify(A, q, sol)
    for broken in (
        {"z_hat": np.zeros(2)},
        {"z_hat": np.array([1.0, 0.0])},
        {"w_hat": np.ones(2)},
        {"z0_hat": -1.0},
        {"z0": 0.5},
    ):
        sol.ray = replace(ray, **broken)
        assert not verify(A, q, sol), broken


def claim(status, n=1, *, z=None, w=None, alpha=(), certificate=None, ray=None):
    """An answer as `verify` reads it; the point z = 0, w = 0 with A = 0 and q = 0 unless said otherwise."""
    z = np.zeros(n) if z is None else np.array(z, float)
    w = np.zeros(n) if w is None else np.array(w, float)
    natural = float(np.max(np.abs(np.minimum(z, w)), initial=0.0))
    return SimpleNamespace(
        z=z, w=w, status=status, residual=natural, natural_residual=natural, alpha=list(alpha), certificate=certificate,
        ray=ray,
    )  # fmt: skip


def failed(A, q, sol, **options):
    report = verify(np.array(A, float), np.array(q, float), sol, **options)
    assert not report.exact or report
    return {check.name for check in report.failures}


@pytest.mark.parametrize("mode", ["float", "exact", "extreme"])
def test_each_statement_about_a_farkas_vector_is_checked(mode):
    unit = 1e200 if mode == "extreme" else 1.0  # beyond 1e150 the check is in fractions

    def broken(A, q, y):
        certificate = Certificate(
            "infeasible", exact=mode == "exact", y=[Fraction(v) for v in y] if mode == "exact" else np.array(y, float)
        )
        return failed([[unit * A]], [unit * q], claim("infeasible", w=[unit * q], certificate=certificate), exact=False)

    columns = "exact A'y <= 0" if mode == "exact" else "A'y <= 0 up to rounding"
    prefix = "exact " if mode == "exact" else ""
    assert broken(-1, -1, [1]) == set()
    assert broken(1, -1, [1]) == {columns}
    assert broken(1, 1, [-1]) == {prefix + "y >= 0"}
    assert broken(-1, 0, [1]) == {prefix + "q'y < 0"}
    assert broken(-1, 1, [1]) == {prefix + "q'y < 0"}
    if mode != "exact":
        assert broken(-1, -1, [np.nan])
        assert broken(-1, -1, [np.inf])


def test_each_statement_about_a_point_is_checked():
    assert failed([[1]], [1], claim("solved", w=[1])) == set()
    assert failed([[1]], [1], claim("solved", z=[-1e-12], w=[1 - 1e-12])) == {"z >= 0"}
    assert failed([[1]], [-1], claim("solved", z=[1 + 1e-7], w=[1e-7])) == {
        "|min(z, w)| is small in every row",
        "residual <= tol",
    }
    assert failed([[1, 0], [0, 1e-12]], [-1, -1e-12], claim("solved", 2, z=[1, 0], w=[0, -1e-12])) == {
        "every row holds to its own numbers"
    }
    assert failed(np.zeros((2, 2)), [0, 0], claim("solved", 2, alpha=[0, 0])) == {"alpha is an index set"}


@pytest.mark.parametrize("status", ["numerical_breakdown", "max_iterations", "time_limit"])
def test_each_statement_about_an_exact_solution_is_checked_whatever_the_status(status):
    def broken(A, q, z, alpha):
        certificate = Certificate("solution", exact=True, alpha=alpha, z=z)
        return failed([[A]], [q], claim(status, w=[q], certificate=certificate))

    one = Fraction(1)
    assert broken(1, -1, [one], [0]) == set()
    assert broken(1, 1, [-one], [0]) == {"exact z >= 0"}
    assert broken(1, -1, [0 * one], []) == {"exact w = A z + q >= 0"}
    assert broken(0, 1, [one], []) == {"exact z'w = 0", "w = 0 on alpha, z = 0 outside"}
    assert broken(1, 1, [0 * one], [0]) == {"w = 0 on alpha, z = 0 outside"}
    assert broken(1, -1, [one], []) == {"w = 0 on alpha, z = 0 outside"}
    for z in ([1.0], [one, one], None):
        assert broken(1, -1, z, [0]) == {"the certificate holds n exact numbers"}
    assert broken(1, -1, [one], [0]) == set()
    assert failed([[1]], [1], claim(status, w=[1], certificate=Certificate("hearsay", exact=True)))


def test_the_rounded_point_is_that_of_the_certificate():
    certificate = Certificate("solution", exact=True, alpha=[0, 1], z=[Fraction(1), Fraction(1)])
    zero = np.zeros((2, 2))
    assert failed(zero, [0, 0], claim("solved", 2, z=[1, 1], certificate=certificate)) == set()
    assert failed(zero, [0, 0], claim("solved", 2, z=[1, 2], certificate=certificate)) == {
        "z is the exact solution rounded"
    }


def test_each_statement_about_a_basis_is_checked():
    assert failed([[1]], [1], claim("solved", w=[1], alpha=[0]), exact=True) == {"exact z >= 0 at the basis alpha"}
    assert failed([[0]], [0], claim("solved", alpha=[0]), exact=True) == {"A[alpha, alpha] is not singular"}
    assert failed([[1, 1], [1, 1]], [0, 0], claim("solved", 2, alpha=[0, 1]), exact=True) == {
        "A[alpha, alpha] is not singular"
    }


@pytest.mark.parametrize("transposed", [False, True])
def test_each_statement_about_a_vector_that_refutes_sufficiency_is_checked(transposed):
    name = "(A' x)" if transposed else "(A x)"

    def broken(A, x):
        x = [Fraction(v) for v in x]
        certificate = Certificate("not_sufficient", exact=True, **{"y" if transposed else "z": x})
        A = np.array(A, float).T if transposed else np.array(A, float)
        return failed(A, [1, 1], claim("numerical_breakdown", 2, w=[1, 1], certificate=certificate))

    assert broken([[0, 1], [0, 0]], [1, -1]) == set()
    assert broken([[0, 0], [1, 0]], [1, -1]) == set()
    assert broken([[-1, 0], [0, 1]], [1, 1]) == {f"exact x_i {name}_i <= 0 for all i"}
    assert broken([[0, 1], [-1, 0]], [1, 0]) == {f"exact x_i {name}_i < 0 for some i"}
    assert broken([[0, 1], [0, 0]], [1]) == {"the refuting vector has n entries"}


def ray_claim(A, q, certificate=None, **parts):
    n = len(q)
    given = {"z": np.zeros(n), "z0": 1.0, "z_hat": np.eye(n)[0], "z0_hat": 0.0, "d": np.ones(n), **parts}
    given = {name: np.array(x, float) if np.ndim(x) else x for name, x in given.items()}
    w_hat = np.array(A, float) @ given["z_hat"] + given["d"][:n] * given["z0_hat"]
    ray = Ray(**{"w_hat": w_hat, **given})
    return failed(A, q, claim("secondary_ray", n, w=q, certificate=certificate, ray=ray))


def test_each_statement_about_a_ray_is_checked():
    zero = np.zeros((2, 2))
    signs = "z_hat >= 0, not zero, z0_hat >= 0"
    start = "z >= 0, z0 >= 0 where the ray starts"
    assert ray_claim(zero, [-1, -1]) == set()
    assert ray_claim(zero, [-1, -1], z_hat=[1, -1]) == {signs}
    assert ray_claim(zero, [-1, -1], z_hat=[0, 0]) == {signs}
    assert ray_claim([[1]], [-1], z0_hat=-1.0) == {signs}
    assert ray_claim([[0, 0], [-1, 0]], [-1, -1]) == {"w_hat >= 0"}
    assert ray_claim([[1]], [-1]) == {"z_hat'w_hat = 0"}
    assert ray_claim(zero, [-1, -1], w_hat=[0, 1]) == {"w_hat = A z_hat + d z0_hat"}
    assert ray_claim(zero, [-1, -1], z0=0.5) == {"A z + q + d z0 >= 0 where the ray starts"}
    assert ray_claim(zero, [-1, -1], z=[-1, 0]) == {start}
    assert ray_claim(zero, [1, 1], z0=-1.0) == {start}
    assert ray_claim(zero, [-1, -1], d=[1, 1, 1])
    assert failed([[0]], [-1], claim("secondary_ray", w=[-1])) == {"the status comes with its ray"}


def test_each_statement_about_an_exact_ray_is_checked():
    def broken(A, z, q=None, **parts):
        q = [-1] * len(A) if q is None else q
        names = ray_claim(A, q, Certificate("ray", exact=True, z=[Fraction(x) for x in z]), **parts)
        return {name for name in names if name.startswith(("exact", "the certificate"))}

    zero = np.zeros((2, 2))
    assert broken(zero, [1, 0]) == set()
    assert broken([[-1]], [1]) == set()  # z0_hat = 1
    assert broken(zero, [1, -1]) == {"exact z_hat >= 0, not zero, z0_hat >= 0"}
    assert broken(zero, [0, 0]) == {"exact z_hat >= 0, not zero, z0_hat >= 0", "exact w_hat = A z_hat + d z0_hat >= 0"}
    assert broken([[1]], [1]) == {"exact z_hat >= 0, not zero, z0_hat >= 0"}
    assert broken([[0, 0], [-1, 0]], [1, 0]) == {"exact w_hat = A z_hat + d z0_hat >= 0"}
    assert broken([[0, 0], [1, 0]], [1, 1]) == {"exact z_hat'w_hat = 0"}
    assert broken(zero, [1]) == broken(zero, [1, 0], d=[0, 1])
    assert len(broken(zero, [1])) == 1


def test_the_problem_itself_must_be_valid():
    sol = lcpstar.solve(A2, Q2)
    with pytest.raises(lcpstar.errors.NotFiniteError, match="nan"):
        verify([[np.nan]], [1.0], sol)
    with pytest.raises(lcpstar.errors.ShapeError):
        verify(A2, [1.0], sol)
    assert not verify(np.eye(3), -np.ones(3), sol)
