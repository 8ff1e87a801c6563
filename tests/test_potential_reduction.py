"""The paper's method: Table 1, the switch to QR, stalls, phase one, the long-step mode."""

import math

import numpy as np
import pytest
from mpmath import mp, mpf

import lcpstar
from lcpstar import _core

PAPER_A = [[0, 1, 1], [2, 0, 2], [-2, -5, 0]]
PAPER_Q = [-4, -7, 10]
PAPER_SOLUTIONS = [(0, 2, 7 / 2), (5, 0, 4), (15 / 14, 11 / 7, 17 / 7)]


def assert_solves(A, q, sol, tol):
    A, q = np.asarray(A, float), np.asarray(q, float)
    w = A @ sol.z + q
    assert sol.status == "solved"
    assert np.abs(np.minimum(sol.z, w)).max() <= tol


@pytest.mark.parametrize("direction", ["cholesky", "qr"])
def test_table_1_to_every_printed_digit(direction):
    run = lcpstar.potential_reduction(PAPER_A, PAPER_Q, z0=[1, 1, 5], direction=direction, trace=True)
    row = {r.k: r for r in run.trace}
    assert row[1].z == pytest.approx([1.05298, 1.09436, 4.75675], abs=5e-6)
    assert row[1].w == pytest.approx([1.85110, 4.61945, 2.42226], abs=5e-6)
    assert row[1].dz == pytest.approx([0.106, 0.189, -0.487], abs=5e-4)
    assert row[1].dw == pytest.approx([-0.298, -0.761, -1.155], abs=5e-4)
    assert row[2].z == pytest.approx([1.09564, 1.17472, 4.52917], abs=5e-6)
    assert row[2].dz == pytest.approx([0.0853, 0.1607, -0.4551], abs=5e-5)
    assert row[50].w == pytest.approx([0.006079, 0.003885, 0.002808], abs=5e-7)
    # Row 97 repeats row 96's psi in the paper: a misprint for 1.1416. Row 50 prints 2.4617.
    for k, psi in {1: 29.3308, 2: 23.2919, 50: 2.4618, 96: 1.1684, 97: 1.1416, 100: 1.0565}.items():
        assert row[k].psi == pytest.approx(psi, abs=5e-5), k
    assert row[1].kappa == pytest.approx(1.01 * max(3, 22 / 2))
    assert all(r.halvings >= 1 for r in run.trace)
    assert row[100].z @ row[100].w == pytest.approx(2.8e-5, rel=0.02)
    assert run.iterations == 108
    assert_solves(PAPER_A, PAPER_Q, run, math.sqrt(1e-5))
    assert run.z == pytest.approx(PAPER_SOLUTIONS[2], abs=1e-4)


def test_each_row_is_half_the_printed_direction():
    run = lcpstar.potential_reduction(PAPER_A, PAPER_Q, z0=[1, 1, 5], trace=True)
    previous = np.array([1.0, 1.0, 5.0])
    for row in run.trace:
        assert row.z == pytest.approx(previous + 0.5**row.halvings * row.dz, rel=1e-12)
        previous = row.z


def test_without_the_forced_halving_the_first_step_is_the_whole_direction():
    run = lcpstar.potential_reduction(PAPER_A, PAPER_Q, z0=[1, 1, 5], min_halvings=0, trace=True)
    assert run.trace[0].z == pytest.approx([1.106, 1.189, 4.514], abs=1e-3)


@pytest.mark.parametrize("min_halvings", [0, 1])
@pytest.mark.parametrize("long_step", [False, True])
def test_two_by_two_counterexample_to_the_convergence_theorem(min_halvings, long_step):
    """claims.md F2: converges to z'w = 7/4; the only solution is (7, 0)."""
    A, q = [[1, 2], [2, 1]], [-7, -3]
    run = lcpstar.potential_reduction(
        A, q, z0=[2, 3], min_halvings=min_halvings, long_step=long_step, max_iterations=5000, trace=True
    )
    if run.success:
        assert run.z == pytest.approx([7, 0], abs=0.01)
    else:
        assert run.status in ("numerical_breakdown", "max_iterations")
        assert "z'w stopped falling" in run.message or "no step" in run.message or "limit" in run.message
    if not long_step:
        assert not run.success
        assert run.trace[-1].z @ run.trace[-1].w == pytest.approx(7 / 4, rel=1e-3)
    assert lcpstar.solve(A, q).z == pytest.approx([7, 0])


def test_a_start_that_is_not_strictly_feasible_is_named():
    with pytest.raises(lcpstar.errors.StartError, match=r"\(A z0 \+ q\)\[0\] = -2"):
        lcpstar.potential_reduction(PAPER_A, PAPER_Q, z0=[1, 1, 1])
    with pytest.raises(lcpstar.errors.StartError, match=r"\(z0\)\[1\] = 0"):
        lcpstar.potential_reduction(PAPER_A, PAPER_Q, z0=[1, 0, 5])
    with pytest.raises(lcpstar.errors.ShapeError):
        lcpstar.potential_reduction(PAPER_A, PAPER_Q, z0=[1, 5])


@pytest.mark.parametrize(
    ("name", "value"),
    [("beta", 1.0), ("gamma", 0.0), ("sigma", 0.5), ("eps", 0.0), ("kappa_factor", 1.0), ("direction", "svd"),
     ("min_halvings", -1), ("max_iterations", -1), ("beta", float("nan"))],
)  # fmt: skip
def test_parameters_out_of_range(name, value):
    with pytest.raises(lcpstar.errors.OptionError, match=name):
        lcpstar.potential_reduction(PAPER_A, PAPER_Q, **{name: value})


@pytest.mark.parametrize(("A", "q"), [([[-1]], [-1]), ([[1, -1], [-1, 1]], [-1, 0])])
def test_no_strictly_feasible_point_is_a_status(A, q):
    run = lcpstar.potential_reduction(A, q)
    assert run.status == "numerical_breakdown"
    assert "phase one found no strictly feasible point" in run.message
    assert run.iterations == 0


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e8])
def test_phase_one_finds_a_start_whatever_the_units(scale):
    rng = np.random.default_rng(5)
    for n in (1, 2, 5, 20):
        G = rng.standard_normal((n, n))
        A, q = scale * (G @ G.T), rng.standard_normal(n)
        sol = lcpstar.solve(A, q, method="potential_reduction", tol=1e-8)
        assert sol.status == "solved"
        assert sol.residual <= 1e-8


@pytest.mark.parametrize("n", [3, 10, 30, 100])
def test_long_steps_reach_1e_8_in_at_most_40_iterations(n):
    """Random monotone problems."""
    rng = np.random.default_rng(n)
    options = lcpstar.PotentialReductionOptions(long_step=True)
    counts = []
    for _ in range(10):
        G, S = rng.standard_normal((n, n)), rng.standard_normal((n, n))
        A, q = G @ G.T / n + S - S.T, rng.standard_normal(n)
        sol = lcpstar.solve(A, q, method="potential_reduction", tol=1e-8, options=options)
        assert sol.status == "solved"
        counts.append(sol.iterations)
    assert max(counts) <= 40, counts


def exact_direction(A, z, w, kappa):
    """The least-squares solution in 60 digits."""
    mp.dps = 60
    n = len(z)
    z, w = [mpf(x) for x in z], [mpf(x) for x in w]
    B = mp.matrix(n, n)
    for i in range(n):
        for j in range(n):
            B[i, j] = mpf(A[i][j]) * z[j] / w[i]
    gap = mp.fsum(a * b for a, b in zip(z, w, strict=True))
    p = mp.matrix([mpf(kappa) * a * b / gap - 1 for a, b in zip(z, w, strict=True)])
    u = mp.lu_solve(mp.eye(n) + B.T * B, -(p + B.T * p))
    return u, B * u


def degenerate_pair(n, mu, degenerate, rng):
    """A monotone A and a central pair: z_i w_i = mu, a share of the indices with z_i = w_i = sqrt(mu)."""
    G = rng.standard_normal((n, n))
    z, w = np.ones(n), np.full(n, mu)
    small = rng.permutation(n)
    cut, half = int(degenerate * n), n // 2
    z[small[half:]], w[small[half:]] = mu, 1.0
    z[small[:cut]] = w[small[:cut]] = math.sqrt(mu)
    spread = rng.uniform(0.5, 2.0, (2, n))
    return G @ G.T / n, z * spread[0], w * spread[1]


@pytest.mark.parametrize("degenerate", [0.0, 0.25])
def test_direction_keeps_its_digits_where_plain_cholesky_loses_them(degenerate):
    """Relative error under 1e-8 for mu = 1e-2 .. 1e-14, against 60 digits."""
    rng = np.random.default_rng(1)
    n, switched, plain_worst = 12, [], 0.0
    for exponent in range(2, 15, 2):
        A, z, w = degenerate_pair(n, 10.0**-exponent, degenerate, rng)
        kappa = 1.01 * max(n, z @ w / (z * w).min())
        u, v = exact_direction(A, z, w, kappa)
        size = mp.norm(u, mp.inf) + mp.norm(v, mp.inf)

        def error(found_u, found_v, u=u, v=v, size=size):
            return float((mp.norm(mp.matrix(found_u) - u, mp.inf) + mp.norm(mp.matrix(found_v) - v, mp.inf)) / size)

        for direction in ("cholesky", "qr"):
            found_u, found_v, solver = _core.potential_direction(A, z, w, kappa, direction)
            assert error(found_u, found_v) <= 1e-8, (exponent, direction, solver)
            if direction == "cholesky":
                switched.append(solver == "qr")
        B = A * z / w[:, None]
        p = kappa * z * w / (z @ w) - 1
        plain = np.linalg.solve(np.eye(n) + B.T @ B, -(p + B.T @ p))
        plain_worst = max(plain_worst, error(plain, B @ plain))
    assert not switched[0]
    if degenerate:
        assert plain_worst > 1e-8  # what plain normal equations lose
        assert switched[-1]  # and the switch is seen


def test_the_switch_is_visible_in_the_trace():
    """A run that converges to a degenerate solution, deep enough to need QR."""
    rng = np.random.default_rng(3)
    n = 8
    G = rng.standard_normal((n, n))
    A = G @ G.T / n
    z_star = np.array([1.0, 1, 1, 0, 0, 0, 0, 0])
    w_star = np.array([0.0, 0, 0, 0, 0, 1, 1, 1])  # indices 3, 4 are degenerate
    q = w_star - A @ z_star
    run = lcpstar.potential_reduction(A, q, eps=1e-22, long_step=True, trace=True, max_iterations=300)
    solvers = [r.solver for r in run.trace]
    assert solvers[0] == "cholesky"
    assert solvers[-1] == "qr"
    assert solvers == sorted(solvers)  # it stays switched
    assert np.abs(run.z - z_star).max() < 1e-5


def test_tol_chooses_eps():
    for tol in (1e-2, 1e-5, 1e-8):
        sol = lcpstar.solve(PAPER_A, PAPER_Q, method="potential_reduction", tol=tol)
        assert sol.status == "solved"
        assert sol.residual <= tol


def test_no_false_solved_outside_p0():
    """Positive matrices (tilde class, often not P0): an answer is right or it is not called solved."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        n = int(rng.integers(2, 5))
        A, q = rng.uniform(0.05, 2.0, (n, n)), rng.uniform(-4.0, 2.0, n)
        run = lcpstar.potential_reduction(A, q, max_iterations=600)
        if run.success:
            assert np.abs(np.minimum(run.z, A @ run.z + q)).max() <= 0.01 * max(1, np.abs(run.z).max())
        assert lcpstar.solve(A, q).success


def test_paper_report_shows_table_misprint_and_three_solutions(capsys):
    from lcpstar import paper

    assert paper.main() == 0
    text = capsys.readouterr().out
    assert "psi printed   29.3308   recomputed 29.3308" in text
    assert "psi: 1.1684 / 1.1416" in text
    assert "Row 97 repeats row 96's psi" in text
    rows = {row.printed.k: row.differences() for row in paper.table_1()}
    assert rows[1] == rows[2] == []
    found = {tuple(np.round(z, 6)) for _, z in paper.example_solutions()}
    assert found == {tuple(np.round(z, 6)) for z in PAPER_SOLUTIONS}


def test_the_papers_stop_is_enough_where_z_and_w_vanish_together():
    """q = 0 and A = [[a]]: z and w = a z shrink together, each a whole row, until z'w <= eps."""
    for a in (0.5, 0.6, 0.75, 1, 1.5, 2, 3):
        run = lcpstar.potential_reduction([[a]], [0], z0=[1], trace=True)
        assert run.trace[-1].z @ run.trace[-1].w <= 1e-5
        assert run.status == "solved"
        assert run.z.tolist() == [0.0]
    rng = np.random.default_rng(0)
    for _ in range(200):
        n = int(rng.integers(1, 5))
        G, K = rng.integers(-2, 3, (n, n)), rng.integers(-1, 2, (n, n))
        A = G @ G.T + K - K.T
        q = rng.integers(1, 4, n) - A @ rng.integers(1, 4, n)
        run = lcpstar.potential_reduction(A, q)
        assert run.status == "solved", (A, q)
        assert np.abs(np.minimum(run.z, A @ run.z + q)).max() <= 1e-2
