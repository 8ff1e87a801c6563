"""Homogeneous predictor-corrector: solves and certifies monotone problems, finishes exactly, claims nothing false."""

from fractions import Fraction

import numpy as np
import pytest

import lcpstar
from lcp_checks import assert_solves
from lcpstar import problems


def solve(A, q, tol=1e-12, **kwargs):
    return lcpstar.solve(A, q, method="interior_point", tol=tol, **kwargs)


def farkas_holds(A, q, y):
    """Exactly, on the binary numbers."""

    def dot(x):
        return sum((Fraction(float(a)) * b for a, b in zip(x, y, strict=True) if a != 0), Fraction(0))

    return min(y) >= 0 and dot(q) < 0 and all(dot(column) <= 0 for column in A.T)


def is_monotone(A):
    """A + A' PSD to rounding, after the congruence that makes its diagonal one."""
    S = (A + A.T) / 2
    d = np.sqrt(np.maximum(np.abs(S).max(axis=1), 1e-300))
    return bool(np.linalg.eigvalsh(S / d[:, None] / d).min() >= -1e-12 * len(A))


@pytest.mark.parametrize("n", [40, 100])
@pytest.mark.parametrize("family", [problems.murty, problems.fathi])
def test_exponential_families_take_few_iterations(family, n):
    A, q = family(n)
    sol = solve(A, q)
    assert sol.status == "solved"
    assert sol.iterations < 20
    assert sol.residual <= 1e-15


def monotone_problems(corpus):
    """Published problems with A + A' PSD to rounding, of each batch every 25th."""
    for path in corpus:
        with np.load(path) as data:
            matrices, vectors = data["A"], data["q"]
        if matrices.ndim == 2:
            matrices, vectors = matrices[None], vectors[None]
        for A, q in list(zip(matrices, vectors, strict=True))[::25]:
            if 0 < len(q) <= 700 and is_monotone(A):
                yield A, q


def test_published_monotone_problems(corpus):
    iterations = []
    for A, q in monotone_problems(corpus):
        sol = solve(A, q)
        assert_solves(A, q, sol)
        assert sol.residual <= 1e-12
        iterations.append(sol.iterations)
    assert len(iterations) >= 40
    assert np.median(iterations) <= 12
    assert max(iterations) <= 30


def infeasible(kind, n, rng):
    """A monotone problem with a known Farkas vector y."""
    y = np.abs(rng.standard_normal(n)) + 0.01
    off = np.eye(n) - np.outer(y, y) / (y @ y)
    if kind == "symmetric":
        G = off @ rng.standard_normal((n, max(1, n // 2)))
        A = G @ G.T
    elif kind == "unsymmetric":
        G, B = off @ rng.standard_normal((n, max(1, n // 2))), rng.standard_normal((n, n))
        A = G @ G.T + off @ (B - B.T) @ off
    else:  # the KKT system of a quadratic program with R x >= b, y'R <= 0 < y'b
        k = n // 2 + 1
        R = rng.standard_normal((n, k))
        below = np.abs(rng.standard_normal(k)) * (rng.random(k) < 0.5)
        R -= np.outer(y, (y @ R + below)) / (y @ y)
        H = rng.standard_normal((k, k))
        b = rng.standard_normal(n)
        b += y * (1 - y @ b) / (y @ y)
        A = np.block([[H @ H.T / k, -R.T], [R, np.zeros((n, n))]])
        return A, np.concatenate([rng.standard_normal(k), -b])
    q = rng.standard_normal(n)
    return A, q - y * (q @ y + 0.3) / (y @ y)


@pytest.mark.parametrize("kind", ["symmetric", "unsymmetric", "kkt"])
def test_infeasible_monotone_problems_are_certified(kind):
    """By a vector that anyone can check; nearly infeasible where the rounding of A leaves feasible points far out."""
    rng = np.random.default_rng(7)
    exactly = 0
    for _ in range(60):
        A, q = infeasible(kind, int(rng.integers(2, 50)), rng)
        sol = solve(A, q, tol=1e-9)
        assert sol.status in ("infeasible", "nearly_infeasible"), (kind, len(q), sol)
        if sol.status == "infeasible":
            assert farkas_holds(A, q, sol.certificate.y)
            exactly += 1
        else:
            assert sol.certificate.bound > 1e8
            assert lcpstar.verify(A, q, sol)
        assert sol.iterations <= 20
    assert exactly >= 10 or kind == "symmetric"


@pytest.mark.parametrize(
    "family", [problems.random_pd, problems.random_spd, problems.psd_half_rank, problems.degenerate]
)
@pytest.mark.parametrize("n", [1, 2, 5, 20, 60])
def test_generated_families(family, n):
    for seed in range(5):
        A, q = family(n, seed=seed)
        sol = solve(A, q)
        assert sol.status == "solved", (family.__name__, n, seed, sol)
        assert sol.iterations <= 30


def test_finish_ends_at_a_basis_that_reproduces_z():
    A, q = problems.psd_half_rank(30, seed=2)
    sol = solve(A, q)
    alpha = sol.alpha
    z = np.zeros(30)
    z[alpha] = np.linalg.solve(A[np.ix_(alpha, alpha)], -q[alpha])
    assert sol.z == pytest.approx(z, abs=1e-9)


def test_finish_moves_from_the_centre_of_a_face_to_a_vertex():
    sol = solve(np.ones((5, 5)), -np.ones(5))
    assert sol.status == "solved"
    assert (sol.z > 0).sum() == 1
    assert len(sol.alpha) == 1


def test_tol_changes_only_the_number_of_iterations():
    A, q = problems.random_spd(40, seed=1)
    options = lcpstar.InteriorPointOptions(finish=False)
    counts, residuals = [], []
    for tol in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        sol = solve(A, q, tol=tol, options=options)
        assert sol.status == "solved"
        assert sol.residual <= tol
        counts.append(sol.iterations)
        residuals.append(sol.residual)
    assert counts == sorted(counts)
    assert counts[-1] > counts[0]
    assert residuals == sorted(residuals, reverse=True)


def test_tol_1e_14_is_reached_by_the_finish():
    for seed in range(5):
        A, q = problems.random_spd(30, seed=seed)
        assert solve(A, q, tol=1e-14).residual <= 1e-14


def test_warm_start_does_not_hurt():
    A, q = problems.random_spd(50, seed=3)
    cold = solve(A, q)
    rng = np.random.default_rng(0)
    for change in (1e-8, 1e-4, 1e-1, 10.0):
        guess = np.abs(cold.z + change * rng.standard_normal(50))
        warm = solve(A, q, z0=guess)
        assert warm.status == "solved"
        assert warm.iterations <= cold.iterations + 1


def test_two_by_two_counterexample_is_not_called_solved_unless_it_is():
    A, q = np.array([[1.0, 2], [2, 1]]), np.array([-7.0, -3])
    sol = solve(A, q)
    if sol.success:
        assert sol.z == pytest.approx([7, 0], abs=1e-9)
    assert lcpstar.solve(A, q).z == pytest.approx([7, 0])


def test_thousand_tilde_class_matrices_outside_p0():
    """Positive matrices are in the paper's tilde class (R0 and semimonotone); keep those not P0."""
    rng = np.random.default_rng(4)
    count = 0
    while count < 1000:
        n = int(rng.integers(2, 6))
        A = rng.uniform(0.05, 2.0, (n, n))
        if all(A[i, i] * A[j, j] >= A[i, j] * A[j, i] for i in range(n) for j in range(i)):
            continue  # no negative principal minor of order 2 seen
        count += 1
        q = rng.uniform(-3.0, 2.0, n)
        for method in ("interior_point", "auto"):
            sol = lcpstar.solve(A, q, method=method)
            if sol.success:
                w = A @ sol.z + q
                assert np.abs(np.minimum(sol.z, w)).max() <= 1e-8 * np.abs(q).max()
            else:
                assert method != "auto"
                assert sol.status in ("numerical_breakdown", "max_iterations")
                assert sol.message


@pytest.mark.parametrize(
    ("A", "q", "z"),
    [([], [], []), ([[2]], [-4], [2]), ([[0]], [3], [0]), ([[2]], [1], [0]), ([[0, 1], [-1, 1]], [1, -1], [0, 1])],
)
def test_small_orders(A, q, z):
    sol = solve(np.reshape(np.array(A, float), (len(q), len(q))), q)
    assert sol.status == "solved"
    assert sol.z == pytest.approx(z)


def test_units_do_not_matter():
    A, q = problems.random_spd(12, seed=5)
    d = 2.0 ** np.random.default_rng(1).integers(-40, 40, 12)
    plain, scaled = solve(A, q), solve(d[:, None] * A * d, d * q)
    assert scaled.status == "solved"
    assert scaled.alpha == plain.alpha
    assert d * scaled.z == pytest.approx(plain.z, rel=1e-9)


def test_limits_stop_it():
    A, q = problems.random_spd(30)
    stopped = solve(A, q, max_iterations=2)
    assert stopped.status == "max_iterations"
    assert stopped.iterations == 2
    assert solve(A, q, time_limit=1e-9).status == "time_limit"


@pytest.fixture(scope="module")
def sparse():
    return pytest.importorskip("scipy.sparse")


@pytest.mark.parametrize("convert", ["csr_array", "csc_array", "coo_array", "csr_matrix"])
def test_sparse_symmetric_obstacle_problem(sparse, convert):
    m = 20
    T = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(m, m))
    A = sparse.kron(T, sparse.eye_array(m)) + sparse.kron(sparse.eye_array(m), T)
    q = np.random.default_rng(0).standard_normal(m * m) * 0.1
    sol = lcpstar.solve(getattr(sparse, convert)(A), q)
    assert sol.status == "solved"
    assert sol.residual <= 1e-12
    assert np.abs(np.minimum(sol.z, A @ sol.z + q)).max() <= 1e-13
    assert sol.z == pytest.approx(lcpstar.solve(A.toarray(), q).z, abs=1e-10)


def test_sparse_kkt_system_and_its_infeasible_sister(sparse):
    rng = np.random.default_rng(1)
    k, m = 60, 30
    seen = set()
    for density in (0.05, 0.1, 0.5, 0.5):
        R = sparse.csr_array(rng.standard_normal((m, k)) * (rng.random((m, k)) < density))
        A = sparse.block_array([[sparse.eye_array(k), -R.T], [R, None]], format="csc")
        q = np.concatenate([rng.standard_normal(k), -0.1 * rng.random(m)])
        sol = lcpstar.solve(A, q)
        seen.add(sol.status.value)
        if sol.success:
            assert np.abs(np.minimum(sol.z, A @ sol.z + q)).max() <= 1e-12
        else:
            assert sol.status == "infeasible"
            assert farkas_holds(A.toarray(), q, sol.certificate.y)
    assert seen == {"solved", "infeasible"}
    stuck = lcpstar.solve(sparse.csr_array(np.array([[1.0, -1], [-1, 1]])), [-1, -1])
    assert stuck.status == "infeasible"
    assert farkas_holds(np.array([[1.0, -1], [-1, 1]]), np.array([-1.0, -1]), stuck.certificate.y)


def test_sparse_input_errors(sparse):
    A = sparse.csr_array(np.eye(2))
    with pytest.raises(lcpstar.errors.ShapeError):
        lcpstar.solve(A, [1.0])
    with pytest.raises(lcpstar.errors.ShapeError):
        lcpstar.solve(sparse.csr_array(np.ones((2, 3))), [1.0, 1.0])
    with pytest.raises(lcpstar.errors.NotFiniteError, match=r"A\.data"):
        lcpstar.solve(sparse.csr_array(np.array([[1.0, np.nan], [0, 1]])), [-1.0, 1.0])
    with pytest.raises(lcpstar.errors.DTypeError):
        lcpstar.solve(sparse.csr_array(np.eye(2, dtype=complex)), [1.0, 1.0])
    with pytest.raises(lcpstar.errors.UnknownNameError):
        lcpstar.solve(A, [1.0, 1.0], method="lemke")
    with pytest.raises(lcpstar.errors.ShapeError, match="z0"):
        lcpstar.solve(A, [-1.0, 1.0], z0=[1.0])
    with pytest.raises(lcpstar.errors.OptionTypeError):
        lcpstar.solve(A, [-1.0, 1.0], options=lcpstar.LemkeOptions())
