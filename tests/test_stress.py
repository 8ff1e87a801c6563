"""What the stress campaign (`make stress`) found, problem by problem, and the families it must not fail on."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lcpstar
from lcp_checks import assert_solves
from lcpstar.bench.families import american_put
from lcpstar.problems import badly_scaled, box_stack, degenerate, random_pd

POINTS = ["auto", "lemke", "principal_pivoting", "block_pivoting", "enumerate", "bilinear", "interior_point"]


def fractions(x):
    return [Fraction(float(v)) for v in x]


def exactly_solvable(A, q):
    """Whether LCP(q, A) has a solution, on the binary numbers: `solutions` in exact arithmetic."""
    return len(lcpstar.solutions(A, q, exact=True)) > 0


def distance(A, q, z):
    """The least omega with |E| <= omega |A|, |e| <= omega |q| such that z solves LCP(q + e, A + E)."""
    worst = 0.0
    for i, row in enumerate(A):
        terms = [Fraction(float(a)) * x for a, x in zip(row, fractions(z), strict=True)] + [Fraction(float(q[i]))]
        w, size = sum(terms), sum(map(abs, terms))
        off = abs(w) if z[i] > 0 else max(-w, 0)
        worst = max(worst, float(off / size) if off else 0.0)
    return worst


# Not solvable, and called solved before each row was held to its own numbers.
UNSOLVABLE = {
    "a row without entries, beside a large q": ([[-(2.0**-25), 0], [0, 0]], [-(2.0**-17), 2.0**54], 1e-14),
    "a row without entries": ([[0, 0, 0], [0, 2, -1], [0, -1, 1]], [-9.453967333270292e-17, 0.04, 0.93], 1e-9),
    "a tiny row without entries": ([[0, 0], [0, 0]], [-4.918330791826217e-7, 17.34220188372288], 1e-3),
    "subnormal": ([[-0.5, 0], [3, 1]], [-5e-324, 0.1], 1e-3),
    "graded": (
        [[0, -3.7804762014355e158, 0], [0, -1.4781819334312017e166, 36117874339.34071], [0, 0, 0]],
        [0, -1.3372372772406724e33, 6.123645718239227e49],
        1e-9,
    ),
    "every product of a row underflows": ([[1, 3], [-1, -5e-324]], [-0.5, 0], 1e-9),
    "overflow": ([[0, 0], [1e200, 0]], [-3, 1e200], 1e-14),
}


# Exactly unsolvable, solvable for a neighbour closer than rounding.
ALMOST = {
    "a tie that rounding breaks": (
        [
            [0, 0, 2.0**10, -(2.0**-16), 0],
            [2.0**7, 2.0**-40, 2.0**-4, -(2.0**-30), 2.0**-22],
            [-(2.0**11), 2.0**-36, 1, -(2.0**-26), -(2.0**-18)],
            [2.0**56, -(2.0**9), -(2.0**45), 0, -(2.0**27)],
            [0, 0, 2.0**-19, -(2.0**-45), 2.0**-37],
        ],
        [-3 * 2.0**-25, 0, 0, -3 * 2.0**-25, 3 * 2.0**-25],
    ),
    "a ray so long that q is below its rounding": (
        [
            [-(2.0**35), -0.25, 2.0**-6, 2, -(2.0**-6)],
            [2.0**-35, -(2.0**-72), 0, -(2.0**-70), 2.0**-77],
            [2.0**-27, 2.0**-64, -(2.0**-68), 0, 2.0**-69],
            [-(2.0**-8), -(2.0**-45), 0, 2.0**-42, -(2.0**-49)],
            [0, -(2.0**-74), 2.0**-78, 2.0**-71, -(2.0**-79)],
        ],
        [2.0**25, -3 * 2.0**25, 3 * 2.0**25, 0, 2.0**26],
    ),
    "a basis of Lemke's method that a batch believed": (
        [
            [2.0**-48, 2.0**-9, 2.0**-70, 2.0**-7, 2.0**-2],
            [2.0**-27, -(2.0**12), -(2.0**-49), 0, 2.0**19],
            [2.0**-47, 0, 0, 2.0**-6, -(2.0**-1)],
            [2.0**-35, 16, 0, 0, 2.0**11],
            [2.0**27, -(2.0**66), -32, -(2.0**68), 2.0**73],
        ],
        [128, -128, 0, -128, -128],
    ),
    "a basis of the tableau whose point misses q": (
        [[-(2.0**-32), 512, -(2.0**-11)], [1, 2.0**41, 0], [0, -256, 0]],
        [2.0**-38, -32768.016384, 1.9073467254638671e-06],
    ),
    "an error as large as q, in two rows": (
        [
            [2.0**33, 32, 2.0**13, 0, -(2.0**31)],
            [-(2.0**56), 2.0**27, 2.0**35, -(2.0**40), 2.0**54],
            [2.0**34, 32, -(2.0**14), -(2.0**20), -(2.0**32)],
            [-(2.0**-18), 2.0**-47, -(2.0**-39), 2.0**-34, 2.0**-20],
            [-(2.0**-21), -(2.0**-50), 2.0**-42, 2.0**-36, 2.0**-22],
        ],
        [2, -3, 2, 0, -2],
    ),
}


@pytest.mark.parametrize("name", ALMOST)
def test_almost_solvable_is_not_solved(name):
    A, q = ALMOST[name]
    assert not exactly_solvable(A, q)
    sol = lcpstar.solve(A, q)
    assert sol.status != "solved"
    if sol.status == "infeasible":
        assert lcpstar.verify(A, q, sol)
    assert lcpstar.solve_batch([A], [q]).status[0] != "solved"


@pytest.mark.parametrize(
    "name", ["a basis of Lemke's method that a batch believed", "an error as large as q, in two rows"]
)
def test_a_guess_on_which_q_is_lost_is_not_taken(name):
    A, q = ALMOST[name]
    for support in range(1, 2 ** len(q)):
        z0 = [float(support >> i & 1) for i in range(len(q))]
        assert lcpstar.solve(A, q, method="interior_point", z0=z0).status != "solved"


def test_a_point_beside_which_nobody_sees_q():
    """ADMM diverges to z of 1e103 with A z = 0 nearly: w, computed in twice the working precision, is all rounding."""
    A = np.array([[-3, 3, -3, 3, -3, -3], [-3, 3, 0, 3, -3, 3], [3, 3, 3, 3, -3, 3], [3, 0, 0, 3, 3, 3],
                  [0, 3, 3, -3, -3, 3], [3, 3, 3, 3, 3, 3]], float)  # fmt: skip
    q = np.array([-3.0, -3.0, 0.0, -3.0, -3.0, -3.0])
    for tol in (1e-14, 1e-9, 1e-3):
        for method in ("admm", *POINTS):
            sol = lcpstar.solve(A, q, method=method, tol=tol)
            if sol.success:
                assert np.max(np.abs(np.minimum(sol.z, A @ sol.z + q))) <= 3 * max(tol, 1e-6)


@pytest.mark.parametrize("method", [*POINTS, "batch"])
@pytest.mark.parametrize("name", UNSOLVABLE)
def test_no_solution_no_claim(name, method):
    A, q, tol = UNSOLVABLE[name]
    assert not exactly_solvable(A, q)
    if method == "batch":
        assert not lcpstar.solve_batch(np.stack([A] * 9), np.stack([q] * 9), tol=tol).success.any()
    else:
        solution = lcpstar.solve(A, q, method=method, tol=tol)
        assert not solution.success
        assert solution.status != "infeasible" or lcpstar.verify(A, q, solution)


EXTREME = {
    "w underflows in the scaled problem": ([[1e-154, 0], [1e-200, 1e-154]], [-1e-154, 1.7976931348623157e308]),
    "w overflows": ([[3, 3], [-2.3e-308, 2.3e-308]], [-2.3e-308, -3]),
    "z overflows": ([[5e-324]], [-0.5]),
    "q at the end": ([[-1e307]], [-1.7976931348623157e308]),
    "ray": (
        [[0, -1e307, -1e-154, 0], [1e307, 1e307, 0, -1e307], [1e-154, -1, 0, 1e307], [-1, 1, 1e-154, 0]],
        [1e307, 1, 0, -1e307],
    ),
    "y overflows": ([[3e-310, 1.7976931348623157e308], [0, -3e-310]], [0, -3e-310]),
    "y is large": ([[-0.5, 1e-160], [-1, -1e160]], [-1e160, -1e160]),
    "y underflows": ([[1e200, 1e200], [-5e-324, -5e-324]], [-1e200, 0]),
    "A underflows": ([[0, 5e-324, -1e200], [5e-324, -1e200, 0], [1e200, 1e200, -1e200]], [-1e200, 0, -5e-324]),
    "z is a third of the least number": ([[3]], [-5e-324]),
    "w far from z": ([[2, -1e-16], [-0.5, 1e308]], [3, 1e-160]),
}


@pytest.mark.parametrize("certify", ["float", "exact"])
@pytest.mark.parametrize("method", [*POINTS, "lemke_howson", "potential_reduction"])
@pytest.mark.parametrize("name", EXTREME)
def test_results_stay_finite_and_true_at_the_ends_of_the_range(name, method, certify):
    A, q = (np.array(x, float) for x in EXTREME[name])
    solution = lcpstar.solve(A, q, method=method, certify=certify)
    for numbers in (solution.z, solution.w, solution.residual, solution.natural_residual):
        assert np.isfinite(numbers).all(), solution
    proved = solution.certificate is not None and solution.certificate.kind == "solution" and solution.certificate.exact
    if proved:  # whether or not doubles hold it
        z = solution.certificate.z
        for i, (row, p) in enumerate(zip(A, q, strict=True)):
            w = sum((Fraction(float(a)) * x for a, x in zip(row, z, strict=True)), Fraction(float(p)))
            assert z[i] >= 0
            assert w >= 0
            assert z[i] * w == 0
    if solution.success:
        assert proved or distance(A, q, solution.z) <= 1e-9 + 8 * np.finfo(float).eps
        for row, p, w in zip(A, q, solution.w, strict=True):
            terms = [Fraction(float(a)) * x for a, x in zip(row, fractions(solution.z), strict=True)] + [
                Fraction(float(p))
            ]
            assert abs(sum(terms) - Fraction(float(w))) <= Fraction(1e-15) * sum(map(abs, terms)) + Fraction(5e-324)
    elif solution.status == "infeasible":
        y = [Fraction(v) for v in solution.certificate.y]  # refuses NaN and infinity
        assert min(y) >= 0
        assert sum(Fraction(float(p)) * v for p, v in zip(q, y, strict=True)) < 0
        for column in A.T:
            terms = [Fraction(float(a)) * v for a, v in zip(column, y, strict=True)]
            assert sum(terms) <= Fraction(64 * np.finfo(float).eps) * sum(map(abs, terms))


def test_the_small_kernel_is_no_easier_than_certify():
    """A violation of 6e-4 on the equilibrated problem is more than tol = 5e-4."""
    A = np.array([[4.0, 4, -4], [4, 4, -4], [-4, -4, 4]])
    q = np.array([-3.919771501409369, -4.122678195581982, 4.113056364198336])
    assert not lcpstar.solve(A, q, tol=5e-4, method="lemke").success
    assert not lcpstar.solve(A, q, tol=5e-4).success
    assert not lcpstar.solve_batch(np.stack([A] * 9), np.stack([q] * 9), tol=5e-4).success.any()


@pytest.mark.parametrize("method", ["auto", "interior_point", "newton", "pgs", "pgs_sm", "nncg", "apgd", "admm"])
@pytest.mark.parametrize(
    ("A", "q"),
    [
        ([[0, 0], [0, 1]], [-(2.0**-40), 2.0**20]),  # a row without entries
        ([[0, 0], [2.0**16, -(2.0**-6)]], [2.0**39, -(2.0**-38)]),
        ([[-1, 0], [0, 1]], [-(2.0**-40), 2.0**20]),
        ([[-1, 0], [0, 1]], [-(2.0**-40), -(2.0**20)]),
    ],
)
def test_a_small_row_of_a_sparse_matrix_holds_too(A, q, method):
    """z = 0 leaves w_i = q_i < 0, far below the rounding of the largest q: a row of data, and no tail of a solution."""
    sparse = pytest.importorskip("scipy.sparse")
    assert not exactly_solvable(A, q)
    solution = lcpstar.solve(sparse.csr_array(np.array(A, float)), q, method=method)
    assert not solution.success
    assert solution.status != "infeasible" or lcpstar.verify(A, q, solution)


@pytest.mark.parametrize("method", ["auto", "newton", "pgs"])
def test_a_sparse_point_beyond_the_doubles_is_no_solution(method):
    """z = 1e600 solves the problem and is no double."""
    sparse = pytest.importorskip("scipy.sparse")
    solution = lcpstar.solve(sparse.csr_array([[1e-300]]), [-1e300], method=method)
    assert not solution.success
    assert np.isfinite([solution.z[0], solution.w[0], solution.residual]).all()


HIDDEN = (
    [
        [-(2.0**65), 2.0**60, -(2.0**57), 2.0**15, -(2.0**36)],
        [-(2.0**23), -(2.0**18), 2.0**14, 2.0**-28, 0],
        [-(2.0**15), 0, 2.0**7, 0, -(2.0**-13)],
        [-(2.0**56), 2.0**51, -(2.0**48), 2.0**6, -(2.0**27)],
        [-(2.0**-7), 0, 2.0**-16, 2.0**-57, 2.0**-36],
    ],
    [-3 * 2.0**-27, 2.0**-27, -(2.0**-27), 2.0**-27, -(2.0**-27)],
)


def test_a_proof_that_fails_leaves_no_less_doubt():
    """Without a solution; `certify="exact"` called the point solved that `certify="float"` had withdrawn."""
    A, q = HIDDEN
    assert not exactly_solvable(A, q)
    for tol in (1e-4, 1e-9, 1e-12):
        for certify in ("float", "exact"):
            assert not lcpstar.solve(A, q, tol=tol, certify=certify).success


@settings(max_examples=400, deadline=None)
@given(st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_powers_of_two_make_nothing_solvable(n, seed):
    """Integers with rows and columns times 2^(+-40): what is called solved has a solution."""
    rng = np.random.default_rng(seed)
    A, q = rng.integers(-3, 4, (n, n)).astype(float), rng.integers(-3, 4, n).astype(float)
    rows, columns = 2.0 ** rng.integers(-40, 41, n), 2.0 ** rng.integers(-40, 41, n)
    solution = lcpstar.solve(rows[:, None] * A * columns, rows * q)
    if solution.success:
        assert exactly_solvable(A, q)
    elif solution.status == "infeasible":
        assert not exactly_solvable(A, q)


def test_a_ray_is_verified_though_some_of_it_is_rounding():
    A = [[0, 2, -1, -1, 0], [0, 0, 0, 2, 0], [0, 0, -2, 1, 1], [0, 0, 0, 1, 2], [1, -1, -2, 0, 0]]
    q = [-2, -1, -3, 0, 2]
    solution = lcpstar.solve(A, q, method="lemke")
    assert solution.status == "secondary_ray"
    assert lcpstar.verify(A, q, solution)


@pytest.mark.parametrize("n", [4, 8, 16, 32, 64, 128])
@pytest.mark.parametrize("method", ["auto", "lemke"])
def test_the_badly_scaled_family_is_solved(n, method):
    """Rows and columns times 10^U(-8, 8): every instance, with the support of the problem in its own units."""
    for seed in range(20 if n <= 32 else 5):
        A, q = badly_scaled(n, seed)
        solution = lcpstar.solve(A, q, method=method)
        assert_solves(A, q, solution)
        assert solution.alpha == lcpstar.solve(*random_pd(n, seed)).alpha


@pytest.mark.parametrize("scale", [1e-300, 1e-8, 1e8, 1e300])
@pytest.mark.parametrize("family", [random_pd, degenerate])
def test_units_of_q_do_not_change_the_support(family, scale):
    for n, seed in itertools.product([2, 5, 12, 30], range(5)):
        A, q = family(n, seed)
        plain, scaled = lcpstar.solve(A, q), lcpstar.solve(A, scale * q)
        assert plain.success
        assert scaled.success
        if family is random_pd:  # one solution
            assert scaled.alpha == plain.alpha


@pytest.mark.parametrize("mass_ratio", [1.0, 1e2, 1e4, 1e6, 1e8])
def test_mass_ratios(mass_ratio):
    """The stack of boxes carries its weight at every ratio: the sum of the lowest impulses is known."""
    for boxes in (1, 2, 5, 10):
        A, q = box_stack(boxes, mass_ratio)
        solution = lcpstar.solve(A, q)
        assert_solves(A, q, solution)
        mass = mass_ratio ** (np.arange(boxes) / max(1, boxes - 1))
        assert solution.z[:4].sum() == pytest.approx(9.81 * 0.01 * mass.sum(), rel=1e-7)


@pytest.mark.parametrize(
    "method", ["auto", "lemke", "principal_pivoting", "block_pivoting", "chandrasekaran", "newton"]
)
@pytest.mark.parametrize("n", [16, 64, 128, 256])
def test_a_solution_that_decays_to_nothing_is_solved_to_its_end(n, method):
    """z falls by a factor a row, from 1 to 1e-28; rows of q are noise or zero: each row holds to its own numbers."""
    A, q = american_put(n, 1)
    solution = lcpstar.solve(A, q, method=method)
    assert_solves(A, q, solution)
    assert distance(A, q, solution.z) <= 1e-4
    if method == "auto":
        assert solution.method in ("lemke_small", "chandrasekaran")


@pytest.mark.parametrize("seed", range(3))
def test_signs_below_the_rounding_of_doubles_are_found_in_double_doubles(seed):
    """Redundant equations as two inequalities each, with right-hand sides that are rounding errors."""
    rng = np.random.default_rng(seed)
    m, k = 90, 260
    equations = rng.integers(-2, 3, (m, k)) * (rng.random((m, k)) < 0.3)
    noise = np.where(np.arange(m) % 3 == 0, 1e-17 * rng.random(m), 0.0)
    equations[m // 2 :], noise[m // 2 :] = equations[: m // 2], noise[: m // 2]
    rows = np.vstack([equations, -equations])
    A = np.block([[np.zeros((k, k)), -rows.T], [rows, np.zeros((2 * m, 2 * m))]]).astype(float)
    q = np.concatenate([rng.random(k), -noise, noise])
    solution = lcpstar.solve(A, q)
    assert_solves(A, q, solution)
    assert solution.method == "lemke_double_double"
    assert 0 < distance(A, q, solution.z) <= 1e-4
