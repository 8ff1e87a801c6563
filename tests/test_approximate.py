"""Approximate methods: solved means `residual <= tol`, more time is never worse, bounds on the error are true."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

import lcpstar
from lcp_checks import assert_solves
from lcpstar import problems

METHODS = ["pgs", "pgs_sm", "nncg", "apgd", "admm", "newton"]
#: Symmetric positive definite or semidefinite with a positive diagonal: every method converges.
SYMMETRIC = {
    "random_spd": lambda: problems.random_spd(40, 1),
    "psd_half_rank": lambda: problems.psd_half_rank(30, 2),
    "box_stack": lambda: problems.box_stack(6, seed=0),
    "sphere_pile": lambda: problems.sphere_pile(20, seed=1),
    "obstacle_1d": lambda: problems.obstacle_1d(60),
    "degenerate": lambda: problems.degenerate(30, 3),
}
#: `A + A'` positive definite, not symmetric: Gauss-Seidel has no guarantee there.
MONOTONE = {
    "random_pd": lambda: problems.random_pd(40, 1),
    "badly_scaled": lambda: problems.badly_scaled(20, 1, decades=3),
}


def in_exact_numbers(A, q, z):
    """`max|min(z, A z + q)|` in rational arithmetic on the given doubles."""
    rows = [[Fraction(float(a)) for a in row] for row in A]
    point = [Fraction(float(x)) for x in z]
    products = [sum(a * x for a, x in zip(row, point, strict=True)) for row in rows]
    w = [Fraction(float(b)) + product for b, product in zip(q, products, strict=True)]
    return max(abs(min(x, y)) for x, y in zip(point, w, strict=True))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tol", [1e-2, 1e-4, 1e-7])
@pytest.mark.parametrize("family", SYMMETRIC)
def test_symmetric_problems_are_solved_to_the_tolerance(family, tol, method):
    A, q = SYMMETRIC[family]()
    sol = lcpstar.solve(A, q, method=method, tol=tol, max_iterations=200_000)
    assert sol.method == method
    assert_solves(A, q, sol, tol)
    exact = in_exact_numbers(A, q, sol.z)
    assert abs(float(exact) - sol.natural_residual) <= 1e-13 * max(1.0, np.abs(A).max() * sol.z.max() + np.abs(q).max())


@pytest.mark.parametrize("method", ["apgd", "admm", "newton"])
@pytest.mark.parametrize("tol", [1e-3, 1e-7])
@pytest.mark.parametrize("family", MONOTONE)
def test_monotone_problems_are_solved_without_symmetry(family, tol, method):
    A, q = MONOTONE[family]()
    assert_solves(A, q, lcpstar.solve(A, q, method=method, tol=tol, max_iterations=50_000), tol)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("family", ["stack", "pd"])
def test_more_iterations_are_never_worse(family, method):
    A, q = problems.box_stack(5, 100.0, seed=0) if family == "stack" else problems.random_pd(30, 2)
    residuals = []
    for limit in [0, 1, 2, 3, 5, 8, 13, 21, 34, 55, 89, 144]:
        sol = lcpstar.solve(A, q, method=method, tol=1e-12, max_iterations=limit)
        assert sol.iterations <= limit
        assert sol.success or sol.status in ("max_iterations", "numerical_breakdown")
        residuals.append(sol.residual)
    assert all(b <= a * (1 + 1e-9) + 1e-15 for a, b in itertools.pairwise(residuals)), residuals
    assert residuals[-1] < residuals[0]


@pytest.mark.parametrize("method", METHODS)
def test_a_time_limit_returns_the_best_point(method):
    A, q = problems.box_stack(40, 1e8, seed=1)
    sol = lcpstar.solve(A, q, method=method, tol=1e-15, time_limit=0.02)
    assert sol.status in ("time_limit", "max_iterations", "numerical_breakdown", "solved")
    assert sol.residual <= lcpstar.solve(A, q, method=method, tol=1e-15, max_iterations=0).residual
    assert (sol.z >= 0).all()
    assert sol.time < 5


@pytest.mark.parametrize("method", METHODS)
def test_the_values_of_a_warm_start_are_used(method):
    A, q = problems.random_spd(40, 4)
    best = lcpstar.solve(A, q)
    warm = lcpstar.solve(A, q, method=method, z0=best.z, tol=1e-8)
    assert (warm.status, warm.iterations, warm.method) == ("solved", 0, method)
    cold = lcpstar.solve(A, q, method=method, tol=1e-8, max_iterations=100_000)
    near = lcpstar.solve(A, q, method=method, tol=1e-8, z0=best.z * (1 + 1e-6), max_iterations=100_000)
    assert near.success
    # One round of pgs_sm, five sweeps and a solve, is the least it does.
    assert near.iterations < cold.iterations or (method == "pgs_sm" and near.iterations == 5)


def test_newton_from_a_nearly_right_start_takes_one_factorisation():
    A, q = problems.random_spd(60, 5)
    best = lcpstar.solve(A, q)
    near = lcpstar.solve(A, q, method="newton", z0=best.z * 1.001)
    assert near.success
    assert near.iterations == 1


@pytest.mark.parametrize("method", METHODS)
def test_orders_zero_and_one(method):
    assert lcpstar.solve(np.zeros((0, 0)), [], method=method).success
    assert abs(lcpstar.solve([[2.0]], [-3.0], method=method).z[0] - 1.5) < 1e-8
    assert lcpstar.solve([[2.0]], [3.0], method=method).z.tolist() == [0.0]
    assert lcpstar.solve([[-1.0]], [2.0], method=method).method == "trivial"
    for a in (0.0, -1.0):
        unsolvable = lcpstar.solve([[a]], [-1.0], method=method)
        assert not unsolvable.success
        assert np.isfinite(unsolvable.z).all()


@pytest.mark.parametrize("method", ["pgs", "nncg"])
def test_a_zero_diagonal_is_skipped_and_said(method):
    # w_1 = z_0 - 1 and a_11 = 0: no sweep moves z_1.
    sol = lcpstar.solve([[1.0, -1.0], [1.0, 0.0]], [-0.5, -1.0], method=method)
    assert sol.status == "numerical_breakdown"
    assert "diagonal" in sol.message
    assert sol.z.tolist() == [0.5, 0.0]


@pytest.mark.parametrize("method", ["newton", "admm"])
def test_a_zero_diagonal_is_no_obstacle(method):
    A, q = [[1.0, -1.0], [1.0, 0.0]], [0.5, -1.0]
    sol = lcpstar.solve(A, q, method=method)
    assert_solves(A, q, sol)
    assert np.allclose(sol.z, [1, 1.5])


@pytest.mark.parametrize("method", METHODS)
def test_a_tolerance_hides_no_row(method):
    """In every row, `|min(z, w)| <= 10 tol max|q|` in the caller's units: a badly scaled row cannot hide."""
    A, q = problems.badly_scaled(12, 3, decades=2)
    A = (A + A.T) / 2
    A += np.diag(np.abs(A).sum(axis=1))
    sol = lcpstar.solve(A, q, method=method, tol=1e-3, max_iterations=50_000)
    assert_solves(A, q, sol, 1e-3)


@pytest.mark.parametrize("method", ["pgs_sm", "admm", "newton"])
@pytest.mark.parametrize("mass_ratio", [1e2, 1e4, 1e6, 1e8])
def test_large_mass_ratios_are_solved(mass_ratio, method):
    A, q = problems.box_stack(8, mass_ratio, seed=0)
    sol = lcpstar.solve(A, q, method=method, tol=1e-7)
    assert_solves(A, q, sol, 1e-7)


def american_put(n, sparse):
    """One implicit step on a log-price grid: a tridiagonal M-matrix, not symmetric."""
    x = np.linspace(-3, 3, n)
    h, sigma, rate, step = x[1] - x[0], 0.3, 0.05, 0.02
    diffusion, drift = 0.5 * sigma**2 / h**2, (rate - 0.5 * sigma**2) / (2 * h)
    A = sparse.diags_array(
        [-step * (diffusion - drift), 1 + step * (2 * diffusion + rate), -step * (diffusion + drift)],
        offsets=[-1, 0, 1],
        shape=(n, n),
        format="csr",
    )
    payoff = np.maximum(1 - np.exp(x), 0)
    return A, A @ payoff - payoff


@pytest.fixture
def sparse():
    return pytest.importorskip("scipy.sparse")


def check_sparse(A, q, sol, tol):
    assert sol.success, sol
    scale = np.abs(A) @ sol.z + np.abs(q)
    w = A @ sol.z + q
    assert (sol.z >= 0).all()
    assert (np.abs(np.minimum(sol.z, w)) <= 10 * tol * np.abs(q).max() + 1e-14 * scale).all()
    assert sol.residual <= tol


@pytest.mark.parametrize("method", METHODS)
def test_sparse_takes_the_same_path(sparse, method):
    A, q = problems.sphere_pile(15, seed=2)
    dense = lcpstar.solve(A, q, method=method, tol=1e-6, max_iterations=100_000)
    sol = lcpstar.solve(sparse.csr_array(A), q, method=method, tol=1e-6, max_iterations=100_000)
    check_sparse(A, q, sol, 1e-6)
    if method in ("pgs", "nncg"):
        assert sol.iterations == dense.iterations


@pytest.mark.parametrize("n", [1000, 20_000])
def test_american_put_by_newton(sparse, n):
    A, q = american_put(n, sparse)
    sol = lcpstar.solve(A, q, method="newton")
    check_sparse(A, q, sol, 1e-9)
    assert sol.iterations <= 80
    again = lcpstar.solve(A, q * 1.0001, method="newton", z0=sol.z)
    check_sparse(A, q * 1.0001, again, 1e-9)
    assert again.iterations <= 2


def test_obstacle_in_the_plane_by_newton(sparse):
    m = 48
    T = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(m, m))
    A = (sparse.kron(T, sparse.eye_array(m)) + sparse.kron(sparse.eye_array(m), T)).tocsr()
    g = (np.arange(m) + 1) / (m + 1)
    height = np.maximum(0.4 - 4 * ((g[:, None] - 0.5) ** 2 + (g - 0.5) ** 2), -0.2).ravel()
    q = A @ height + 2 / (m + 1) ** 2
    sol = lcpstar.solve(A, q, method="newton")
    check_sparse(A, q, sol, 1e-9)
    assert sol.iterations <= 40
    assert np.abs(sol.z - lcpstar.solve(A, q).z).max() <= 1e-7 * sol.z.max()


def test_newton_leaves_the_cycle_of_ben_gharbia_and_gilbert():
    A, q = np.array([[1.0, 0, 2], [2, 1, 0], [0, 2, 1]]), -np.ones(3)
    sol = lcpstar.solve(A, q, method="newton", z0=[1, 0, 0])
    assert_solves(A, q, sol)
    assert np.allclose(sol.z, 1 / 3)


@pytest.mark.parametrize(
    ("method", "options", "name"),
    [
        ("pgs", lcpstar.PgsOptions(relaxation=2.0), "relaxation"),
        ("pgs", lcpstar.PgsOptions(relaxation=float("nan")), "relaxation"),
        ("pgs_sm", lcpstar.PgsSmOptions(relaxation=0.0), "relaxation"),
        ("admm", lcpstar.AdmmOptions(rho=0.0), "rho"),
        ("admm", lcpstar.AdmmOptions(rho=float("inf")), "rho"),
        ("admm", lcpstar.AdmmOptions(relaxation=-1.0), "relaxation"),
    ],
)
def test_bad_options_are_named(method, options, name):
    with pytest.raises(lcpstar.errors.OptionError, match=name):
        lcpstar.solve([[1.0]], [-1.0], method=method, options=options)


def test_options_of_another_method_are_refused():
    with pytest.raises(lcpstar.errors.OptionTypeError, match="PgsOptions"):
        lcpstar.solve([[1.0]], [-1.0], method="pgs", options=lcpstar.NewtonOptions())
    with pytest.raises(lcpstar.errors.OptionTypeError, match="takes no options"):
        lcpstar.solve([[1.0]], [-1.0], method="nncg", options=lcpstar.NewtonOptions())
    for bad in (dict(sweeps=0), dict(solves=0)):
        with pytest.raises(lcpstar.errors.OptionError, match="at least 1"):
            lcpstar.PgsSmOptions(**bad)


def test_options_reach_the_method():
    A, q = problems.obstacle_1d(40)
    plain = lcpstar.solve(A, q, method="pgs", tol=1e-6)
    relaxed = lcpstar.solve(A, q, method="pgs", tol=1e-6, options=lcpstar.PgsOptions(relaxation=1.8))
    assert relaxed.iterations < plain.iterations / 2
    both_ways = lcpstar.solve(A, q, method="pgs", tol=1e-6, options=lcpstar.PgsOptions(symmetric=True))
    assert both_ways.success
    assert both_ways.iterations != plain.iterations
    A, q = problems.box_stack(6, 1e4, seed=0)
    polished = lcpstar.solve(A, q, method="admm")
    plain = lcpstar.solve(A, q, method="admm", options=lcpstar.AdmmOptions(polish=False), max_iterations=100_000)
    assert polished.success
    assert polished.iterations < plain.iterations


@pytest.mark.parametrize("method", METHODS)
def test_batches_know_the_methods(method):
    rng = np.random.default_rng(0)
    B = rng.standard_normal((20, 8, 8))
    A, q = B @ B.transpose(0, 2, 1) / 8 + 0.5 * np.eye(8), rng.standard_normal((20, 8))
    sols = lcpstar.solve_batch(A, q, method=method, tol=1e-6)
    assert sols.success.all()
    assert (sols.residual <= 1e-6).all()
    assert set(sols.method) <= {method, "trivial"}
    assert sols.z[3].tolist() == lcpstar.solve(A[3], q[3], method=method, tol=1e-6).z.tolist()


# --- auto under a loose tolerance or a time limit


@pytest.mark.parametrize("tol", [1e-2, 1e-3, 1e-6])
@pytest.mark.parametrize("family", [*SYMMETRIC, *MONOTONE])
def test_auto_meets_a_loose_tolerance(family, tol):
    A, q = {**SYMMETRIC, **MONOTONE}[family]()
    assert_solves(A, q, lcpstar.solve(A, q, tol=tol), tol)


def test_auto_takes_a_matrix_for_symmetric_that_is_so_up_to_rounding():
    A, q = problems.sphere_pile(80, seed=0)
    rounded = A * (1 + 1e-15 * np.random.default_rng(0).standard_normal(A.shape))
    assert {lcpstar.solve(M, q, tol=1e-3).method for M in (A, rounded)} <= {"nncg", "pgs_sm"}
    assert lcpstar.solve(A, q).method not in ("nncg", "pgs_sm")


def test_auto_falls_back_on_the_exact_portfolio():
    """Friction and games have zeros on the diagonal: no sweep solves them, auto does."""
    for A, q in (problems.stewart_trinkle(8, 0), problems.bimatrix(20, 0), problems.murty(40)):
        assert_solves(A, q, lcpstar.solve(A, q, tol=1e-3), 1e-3)


def test_auto_still_proves_infeasibility():
    n = 40
    A = np.eye(n) - np.ones((n, n)) / n * 1.5
    sol = lcpstar.solve(A, -np.ones(n), tol=1e-3)
    assert sol.status == "infeasible"


def test_auto_with_a_time_limit_returns_something_useful():
    A, q = problems.random_spd(400, 0)
    sol = lcpstar.solve(A, q, time_limit=1e-9)
    assert sol.status in ("time_limit", "solved")
    assert (sol.z >= 0).all()
    assert lcpstar.solve(A, q, time_limit=60.0).success


# --- what is said about accuracy


def perturbed(A, q, size, seed):
    """The exact solution, and a point `size` away from it."""
    exact = lcpstar.solve(A, q, certify="exact")
    assert exact.certificate.exact
    z = np.maximum(exact.z + size * np.random.default_rng(seed).standard_normal(len(q)), 0)
    return exact.certificate.z, z


def distance(exact, z):
    return max(abs(a - Fraction(float(b))) for a, b in zip(exact, z, strict=True))


def h_matrix(n, seed):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    np.fill_diagonal(A, 0)
    return A + np.diag(1.05 * np.abs(A).sum(axis=1)), rng.standard_normal(n)


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-6, 1e-1])
@pytest.mark.parametrize("seed", range(4))
def test_error_bounds_hold(seed, size):
    cases = [h_matrix(12, seed), problems.random_pd(10, seed), problems.random_spd(15, seed), problems.obstacle_1d(20)]
    for A, q in cases:
        exact, z = perturbed(A, q, size, seed)
        found = lcpstar.accuracy(A, q, z)
        error = distance(exact, z)
        assert found.error_bound is not None, found.bound_reason
        assert error <= Fraction(found.error_bound)
        if size >= 1e-6:
            assert found.error_bound <= 1e4 * float(error)


def test_error_bounds_hold_in_any_units():
    A, q = h_matrix(10, 0)
    rows, columns = 10.0 ** np.linspace(-6, 6, 10), 10.0 ** np.linspace(4, -5, 10)
    A, q = rows[:, None] * A * columns, rows * q
    exact, z = perturbed(A, q, 1e-3, 0)
    found = lcpstar.accuracy(A, q, z)
    assert distance(exact, z) <= Fraction(found.error_bound)


def test_the_backward_error_is_attained_and_least():
    A, q = problems.random_spd(8, 0)
    sol = lcpstar.solve(A, q, method="pgs", tol=1e-2)
    found = lcpstar.accuracy(A, q, sol)
    assert (found.natural_residual, found.residual) == (sol.natural_residual, sol.residual)
    omega, z = found.backward_error, sol.z
    w, scale = A @ z + q, np.abs(A) @ z + np.abs(q)
    # Each row, moved by the fraction that it needs, solves the problem; a smaller fraction does not.
    need = np.where(z > 0, np.abs(w), np.maximum(-w, 0)) / scale
    assert np.isclose(omega, need.max(), rtol=1e-9)
    change = np.where((z > 0) | (w < 0), -w / scale, 0.0)[:, None]
    A2, q2 = A + change * np.abs(A), q + change[:, 0] * np.abs(q)
    assert np.abs(np.minimum(z, A2 @ z + q2)).max() < 1e-14 * scale.max()


def test_no_bound_where_the_solution_need_not_be_unique():
    for A, q in (problems.box_stack(3), problems.psd_half_rank(8, 0), problems.bimatrix(3)):
        found = lcpstar.accuracy(A, q, lcpstar.solve(A, q))
        assert found.error_bound is None
        assert "unique" in found.bound_reason


def test_accuracy_of_a_sparse_problem(sparse):
    A, q = american_put(200, sparse)
    sol = lcpstar.solve(A, q, method="newton")
    found = lcpstar.accuracy(A, q, sol)
    exact = lcpstar.solve(A.toarray(), q, certify="exact")
    assert found.residual == sol.residual
    assert distance(exact.certificate.z, sol.z) <= Fraction(found.error_bound)
    assert found.error_bound < 1e-10


def test_accuracy_checks_its_input():
    with pytest.raises(lcpstar.errors.ShapeError, match="z must have length 2"):
        lcpstar.accuracy(np.eye(2), [1.0, 1.0], [1.0])
    with pytest.raises(lcpstar.errors.NotFiniteError, match="z"):
        lcpstar.accuracy(np.eye(2), [1.0, 1.0], [1.0, np.nan])
