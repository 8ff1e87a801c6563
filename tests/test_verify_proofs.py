"""Each statement of a proof is checked by `verify`: bases, exact solutions, Farkas vectors, sufficiency, rays."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import lcpstar
from answers import A2, BELOW, NEARLY, Q2, SADDLE, answer, copy, failed, infeasible, nearly, on_ray, solved
from lcpstar import verify
from lcpstar.result import Certificate, Ray


def test_a_basis_is_solved_exactly():
    assert verify(A2, Q2, solved(), exact=True).exact
    assert not verify(A2, Q2, solved()).exact
    sol = answer([[-1.0]], [1.0], [1.0], alpha=[])  # z = 0 and z = 1 are solutions; the basis is that of the first
    assert verify([[-1.0]], [1.0], copy(sol, alpha=[0]), exact=True)
    assert failed([[-1.0]], [1.0], sol, exact=True) >= {"z is the exact solution rounded"}
    flat = np.ones((2, 2))
    assert failed(flat, [-1, -1], answer(flat, [-1, -1], [0.5, 0.5]), exact=True) == {"A[alpha, alpha] is not singular"}
    third = np.array([[1.0, 0.0], [3.0, 1.0]])  # w_2 = 3 fl(1/3) - 1 < 0
    sol = answer(third, [-1 / 3, -1.0], [1 / 3, 0])
    assert verify(third, [-1 / 3, -1.0], sol)
    assert failed(third, [-1 / 3, -1.0], sol, exact=True) == {"exact w >= 0 at the basis alpha"}
    negative = answer([[1.0]], [1e-20], [0.0], alpha=[0])
    assert failed([[1.0]], [1e-20], negative, exact=True) >= {"exact z >= 0 at the basis alpha"}


@pytest.mark.parametrize("status", ["solved", "numerical_breakdown", "max_iterations", "time_limit"])
def test_each_statement_about_an_exact_solution_is_checked_whatever_the_status(status):
    def broken(A, q, z, alpha):
        certificate = Certificate("solution", exact=True, alpha=alpha, z=z)
        names = failed([[A]], [q], answer([[A]], [q], [0], status, certificate=certificate))
        return names - {"z is the exact solution rounded"}

    one = Fraction(1)
    outside = "w = 0 on alpha, z = 0 outside"
    assert broken(1, -1, [one], [0]) == set()
    assert broken(1, 1, [-one], [0]) == {"exact z >= 0"}
    assert broken(1, -1, [0 * one], []) == {"exact w = A z + q >= 0"}
    assert broken(0, 1, [one], []) == {"exact z'w = 0", outside}
    assert broken(1, 1, [0 * one], [0]) == {outside}
    assert broken(1, -1, [one], []) == {outside}
    for z in ([1.0], [one, one]):
        assert broken(1, -1, z, [0]) == {"certificate is well formed"}
    assert broken(1, -1, None, [0])
    assert failed([[1]], [1], answer([[1]], [1], [0], status, certificate=Certificate("hearsay", exact=True)))


def test_an_exact_solution_may_underflow():
    """z = 2^-1080 is 0 in doubles; its w is 0, and that of the double is not."""
    A, q = [[2.0**1000]], [-(2.0**-80)]
    proof = Certificate("solution", exact=True, alpha=[0], z=[Fraction(1, 2**1080)])
    sol = answer(A, q, [0.0], certificate=proof, alpha=[0])
    assert verify(A, q, sol).exact
    assert not verify(A, q, copy(sol, certificate=None))
    wrong = Certificate("solution", exact=True, alpha=[0], z=[Fraction(1, 2**1081)])
    assert "w = 0 on alpha, z = 0 outside" in failed(A, q, copy(sol, certificate=wrong))


def test_a_proved_solution_is_solved_although_its_rounding_is_not():
    """z = 7.8e14 (1, 1): a last bit of z changes w by 0.1."""
    A = np.array([[0.40756930889413767, -0.4075693088941364], [-0.6853293444903695, 0.6853293444903705]])
    q = np.array([-1.9125624836303927, 0.7579546637146332])
    (a, b), (c, d) = [[Fraction(x) for x in row] for row in A.tolist()]
    p, r = map(Fraction, q.tolist())
    z = [(-d * p + b * r) / (a * d - b * c), (c * p - a * r) / (a * d - b * c)]
    certificate = Certificate("solution", exact=True, alpha=[0, 1], z=z)
    sol = answer(A, q, z, certificate=certificate)
    assert verify(A, q, sol).exact
    assert not verify(A, q, copy(sol, certificate=None))
    for z in (sol.z * (1 + 1e-15), sol.z + np.array([4.0, 0.0]), sol.z * 1.5):
        forged = answer(A, q, z, certificate=certificate)
        assert failed(A, q, forged) == {"z is the exact solution rounded"}


def test_each_statement_about_a_farkas_vector_is_checked():
    def broken(A, q, y, unit=1.0, exact=False):
        A, q = [[unit * A]], [unit * q]
        certificate = Certificate(
            "infeasible", exact=exact, y=[Fraction(v) for v in y] if exact else np.array(y, float)
        )
        return failed(A, q, answer(A, q, [0], "infeasible", certificate=certificate))

    for options in ({}, {"exact": True}, {"unit": 1e200}, {"unit": 1e-310}, {"unit": 1e-310, "exact": True}):
        assert broken(-1, -1, [1], **options) == set()
        assert broken(0, -1, [1], **options) == set()
        assert broken(1, -1, [1], **options) == {"exact A'y <= 0"}
        assert broken(1, 1, [-1], **options) == {"exact y >= 0"}
        assert broken(-1, 0, [1], **options) == {"exact q'y < 0"}
        assert broken(-1, 1, [1], **options) == {"exact q'y < 0"}


def test_exact_vectors_may_leave_the_range_of_doubles():
    A, q = np.array([[0.0, -1.0], [-1.0, 0.0]]), np.array([-1.0, -1.0])
    for unit in (Fraction(10**400), Fraction(1, 10**400)):
        for y, names in (([unit, 1], set()), ([unit, -1], {"exact y >= 0"}), ([-unit, 2], {"exact y >= 0"})):
            certificate = Certificate("infeasible", exact=True, y=y)
            assert failed(A, q, answer(A, q, [0, 0], "infeasible", certificate=certificate)) >= names
            assert bool(verify(A, q, answer(A, q, [0, 0], "infeasible", certificate=certificate))) == (not names)
    # (A'y)_1 = 1 - (1 +- 10^-400): rounded it is 0, and its sign decides.
    for sign in (1, -1):
        proof = Certificate("infeasible", exact=True, y=[Fraction(1), 1 + sign * Fraction(1, 10**400)])
        sol = answer([[1, 0], [-1, 0]], [0, -1], [0, 0], "infeasible", certificate=proof)
        assert bool(verify([[1, 0], [-1, 0]], [0, -1], sol)) == (sign == 1)


def test_a_farkas_vector_up_to_rounding_is_none():
    """A P-matrix: every LCP has a solution, this one (5e8, 5e8) about."""
    P = np.array([[1.0, -1.0], [-1 + 1e-9, 1 + 1e-9]])
    for A, q in ((P, [-1.0, 1 - 1e-9]), (NEARLY, BELOW), (NEARLY * 1e-300, BELOW)):
        sol = answer(A, q, [0, 0], "infeasible", certificate=Certificate("infeasible", y=np.ones(2)))
        assert "exact A'y <= 0" in failed(A, q, sol)
    tiny = np.array([[1.0, -1.0], [-1.0 + 2.0**-53, 1.0]])
    assert failed(tiny, BELOW, copy(infeasible(), residual=answer(tiny, BELOW, [0, 0]).residual)) == {"exact A'y <= 0"}


def test_each_statement_about_a_nearly_infeasible_problem_is_checked():
    """y = (1, 1): A'y = (2^-40, 0), q'y = -2; so sum(z) >= 2^41."""
    bound = "exact 0 < bound <= -q'y / max_j (A'y)_j"
    assert failed(NEARLY, BELOW, nearly()) == set()
    assert verify(NEARLY, BELOW, nearly()).exact
    for worse in (np.nextafter(2.0**41, np.inf), 1e300, np.inf):
        assert failed(NEARLY, BELOW, nearly(bound=worse)) == {bound}
    for worse in (0.0, -1.0):
        assert failed(NEARLY, BELOW, nearly(bound=worse)) == {bound}
    assert failed(NEARLY, BELOW, nearly(bound=np.nan)) == {"certificate is well formed"}
    assert failed(NEARLY, BELOW, nearly(bound=None))
    assert failed(NEARLY, BELOW, nearly(y=(-1.0, -1.0))) >= {"exact y >= 0", "exact q'y < 0"}
    assert failed(NEARLY, BELOW, nearly(y=(2.0, 1.0), bound=1.0)) == {"A'y <= 0 to 1e-9 of its terms"}
    assert failed(SADDLE, BELOW, nearly(A=SADDLE, bound=np.inf)) == set()
    plain = np.array([[1.0]])
    sol = answer(
        plain, [-1.0], [0], "nearly_infeasible", certificate=Certificate("nearly_infeasible", y=np.ones(1), bound=1.0)
    )
    assert failed(plain, [-1.0], sol) == {"A'y <= 0 to 1e-9 of its terms"}


@pytest.mark.parametrize("transposed", [False, True])
def test_each_statement_about_a_vector_that_refutes_sufficiency_is_checked(transposed):
    name = "(A' x)" if transposed else "(A x)"

    def broken(A, x, exact=True):
        x = [Fraction(v) for v in x]
        certificate = Certificate("not_sufficient", exact=exact, **{"y" if transposed else "z": x})
        A = np.array(A, float).T if transposed else np.array(A, float)
        return failed(A, [1, 1], answer(A, [1, 1], [0, 0], "numerical_breakdown", certificate=certificate))

    assert broken([[0, 1], [0, 0]], [1, -1]) == set()
    assert broken([[0, 0], [1, 0]], [1, -1]) == set()
    assert broken([[-1, 0], [0, 1]], [1, 1]) == {f"exact x_i {name}_i <= 0 for all i"}
    assert broken([[0, 1], [-1, 0]], [1, 0]) == {f"exact x_i {name}_i < 0 for some i"}
    assert broken([[0, 1], [0, 0]], [1]) == {"certificate is well formed"}
    assert "the certificate holds what its kind holds" in broken([[0, 1], [0, 0]], [1, -1], exact=False)


# rays


def ray_claim(A, q, certificate=None, **parts):
    A, n = np.array(A, float), len(q)
    given = {"z": np.zeros(n), "z0": 1.0, "z_hat": np.eye(n)[0], "z0_hat": 0.0, "d": np.ones(n), **parts}
    given = {name: np.array(x, float) if np.ndim(x) else x for name, x in given.items()}
    w_hat = A @ given["z_hat"] + given["d"][:n] * given["z0_hat"]
    sol = answer(A, q, np.zeros(n), "secondary_ray", certificate=certificate, ray=Ray(**{"w_hat": w_hat, **given}))
    return failed(A, q, sol)


def test_each_statement_about_a_ray_is_checked():
    zero = np.zeros((2, 2))
    start = "z >= 0, z0 >= 0 where the ray starts"
    slack = "A z + q + d z0 >= 0 where the ray starts"
    assert ray_claim(zero, [-1, -1]) == set()
    assert ray_claim(zero, [-1, -1], z_hat=[1, -1]) == {"z_hat >= 0, not zero"}
    assert ray_claim(zero, [-1, -1], z_hat=[0, 0]) == {"z_hat >= 0, not zero"}
    assert ray_claim([[1]], [-1], z0_hat=-1.0) == {"z0_hat >= 0"}
    assert ray_claim([[0, 0], [-1, 0]], [-1, -1]) == {"w_hat >= 0"}
    assert ray_claim([[1]], [-1]) == {"z_hat'w_hat = 0"}
    assert ray_claim(zero, [-1, -1], w_hat=[0, 1]) == {"w_hat = A z_hat + d z0_hat"}
    assert ray_claim(zero, [-1, -1], z0=0.5) == {slack}
    assert ray_claim(zero, [-1, -1], z=[-1, 0]) == {start}
    assert ray_claim(zero, [2, 2], z0=-1.0) == {start}
    assert ray_claim(zero, [-1, -1], d=[1, 1, 1]) == {"ray is well formed"}
    assert ray_claim(zero, [-1, -1], d=[1, 0]) == {"the ray's d > 0"}
    assert failed([[0]], [-1], answer([[0]], [-1], [0], "secondary_ray")) == {"the status comes with its ray"}


def test_a_ray_may_be_off_by_rounding():
    """Its exact direction may not."""
    proof = Certificate("ray", exact=True, z=[Fraction(1), Fraction(1)])
    for parts in (
        {"z": np.array([-2e-16, 0.0])},
        {"z": np.array([0.0, -2e-16]), "z0": 1.0 + 2e-16},
        {"z_hat": np.array([1.0, 1.0 - 1e-15]), "w_hat": np.array([1e-15, -1e-15])},
        {"z0_hat": -2e-16, "w_hat": np.full(2, -2e-16)},
    ):
        assert failed(SADDLE, BELOW, on_ray(proof, **parts)) == set(), parts
    z0 = np.array([[-1.0]])  # z and z_0 grow together from z_0 = 0
    ray = Ray(z=np.zeros(1), z0=-2e-16, z_hat=np.ones(1), z0_hat=1.0, w_hat=np.zeros(1), d=np.ones(1))
    sol = answer(z0, [1.0], [0], "secondary_ray", ray=ray, certificate=Certificate("ray", exact=True, z=[Fraction(1)]))
    assert failed(z0, [1.0], sol) == set()
    off = Certificate("ray", exact=True, z=[Fraction(1), Fraction(1) + Fraction(1, 10**30)])
    assert failed(SADDLE, BELOW, on_ray(off)) == {"exact z_hat'w_hat = 0"}


def test_each_statement_about_an_exact_ray_is_checked():
    def broken(A, z, **parts):
        proof = Certificate("ray", exact=True, z=[Fraction(x) for x in z])
        names = ray_claim(A, [-1] * len(A), proof, **parts)
        return {name for name in names if name.startswith(("exact", "the certificate", "certificate"))}

    zero = np.zeros((2, 2))
    signs, slack = "exact z_hat >= 0, not zero, z0_hat >= 0", "exact w_hat = A z_hat + d z0_hat >= 0"
    assert broken(zero, [1, 0]) == set()
    assert broken([[-1]], [1]) == set()  # z0_hat = 1
    assert broken(zero, [1, -1]) == {signs}
    assert broken(zero, [0, 0]) == {signs, slack}
    assert signs in broken([[1]], [1])
    assert broken([[0, 0], [-1, 0]], [1, 0]) == {slack}
    assert broken([[0, 0], [1, 0]], [1, 1]) == {"exact z_hat'w_hat = 0"}
    assert broken(zero, [1]) == {"certificate is well formed"}
    assert broken(zero, [1, 0], d=[0, 1]) == {"the certificate holds n exact numbers, beside a ray with d > 0"}
    parallel = ray_claim(zero, [-1, -1], Certificate("ray", exact=True, z=[Fraction(0), Fraction(1)]))
    assert parallel == {"the ray has the exact direction"}


@pytest.mark.parametrize("method", ["lemke", "principal_pivoting", "enumerate", "interior_point"])
def test_what_the_methods_answer_is_accepted(method):
    rng = np.random.default_rng(11)
    for k in range(40):
        n = 1 + k % 5
        A, q = rng.integers(-2, 4, (n, n)).astype(float), rng.integers(-3, 4, n).astype(float)
        sol = lcpstar.solve(A, q, method=method)
        assert failed(A, q, sol) == set(), (A, q, sol)
