"""`solve_batch`: every answer checked against the mathematics, every bit independent of how the batch is cut."""

from __future__ import annotations

import importlib
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import lcpstar

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "benches"))
from families_batch import psd_rank_half, random_pd, random_spd, stewart_trinkle

EPS = np.finfo(float).eps
FIELDS = ("z", "w", "status_code", "method_code", "iterations", "residual", "natural_residual", "alpha")


def assert_solved(A, q, sols, tol=1e-9):
    """Signs, `w = A z + q`, complementarity and the reported bounds, problem by problem, row by row."""
    A, q = np.asarray(A, float), np.asarray(q, float)
    assert sols.success.all(), sols
    z, w = sols.z, sols.w
    assert (z >= 0).all()
    scale = (np.abs(A) @ z[..., None])[..., 0] + np.abs(q)
    exact = (A @ z[..., None])[..., 0] + q
    assert (np.abs(exact - w) <= 4 * z.shape[-1] * EPS * scale).all()
    natural = np.abs(np.minimum(z, w))
    largest = np.abs(q).max(axis=-1, initial=0.0, keepdims=True)
    assert (natural <= 10 * tol * largest + 8 * EPS * scale).all()
    assert (sols.residual <= tol).all()
    assert (natural.max(axis=-1, initial=0.0) <= sols.natural_residual).all()


def assert_same_bits(a, b):
    for field in FIELDS:
        assert getattr(a, field).tobytes() == getattr(b, field).tobytes(), field


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 7, 8, 9, 12, 16, 20, 21, 32, 40])
@pytest.mark.parametrize("family", [random_pd, random_spd, psd_rank_half])
def test_every_problem_of_a_family_is_solved_and_verified(family, n):
    A, q = family(203, n, seed=n)
    assert_solved(A, q, lcpstar.solve_batch(A, q))


@pytest.mark.parametrize("n", [6, 12, 18, 30])
def test_friction_is_solved_and_verified(n):
    A, q = stewart_trinkle(500, n)
    assert_solved(A, q, lcpstar.solve_batch(A, q))


def test_unique_solutions_agree_with_solve():
    A, q = random_pd(60, 9)
    sols = lcpstar.solve_batch(A, q)
    for k in range(60):
        one = lcpstar.solve(A[k], q[k])
        assert np.allclose(sols.z[k], one.z, rtol=1e-12, atol=1e-13)
        assert [i for i in range(9) if int(sols.alpha[k]) >> i & 1] == list(one.alpha)


def test_every_orthant_of_two_by_two():
    q = np.array([[a, b] for a in (-1.0, 0.0, 2.0) for b in (-3.0, 0.0, 1.0)])
    sols = lcpstar.solve_batch([[2.0, 1.0], [1.0, 2.0]], q)
    assert_solved(np.array([[2.0, 1.0], [1.0, 2.0]]), q, sols)
    assert sols.z.shape == (9, 2)


def test_statuses_are_those_of_solve():
    A = np.array([[[1.0, -1.0], [-1.0, 1.0]], [[2.0, 1.0], [1.0, 2.0]], [[-1.0, 0.0], [0.0, 1.0]]])
    q = np.array([[-1.0, -1.0], [-5.0, -6.0], [-1.0, 1.0]])
    sols = lcpstar.solve_batch(A, q)
    assert sols.status.tolist() == [lcpstar.solve(a, b).status for a, b in zip(A, q, strict=True)]
    assert sols.success.tolist() == [False, True, False]
    assert sols.status[0] == "infeasible"


@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8])
def test_units_do_not_matter(scale):
    rng = np.random.default_rng(3)
    A, q = random_pd(100, 6)
    r, c = 10.0 ** rng.uniform(-6, 6, (2, 100, 6))
    sols = lcpstar.solve_batch(r[:, :, None] * A * c[:, None, :], scale * r * q)
    assert sols.success.all()
    plain = lcpstar.solve_batch(A, q)
    assert np.allclose(sols.z, scale * plain.z / c, rtol=1e-9, atol=0.0)


def assert_bits_do_not_depend_on_the_batch(A, q, guess=None, **options):
    """Threads, splits and permutations; `guess` is an alpha0 or, if its last axis is n, a z0."""

    def solve(part, threads=None):
        given = {} if guess is None else {"alpha0" if guess.ndim == 1 else "z0": guess[part]}
        return lcpstar.solve_batch(A[part], q[part], threads=threads, **given, **options)

    count = len(q)
    whole = solve(slice(None), threads=1)
    for threads in (2, 4):
        assert_same_bits(whole, solve(slice(None), threads))
    parts = [solve(slice(i, j)) for i, j in [(0, 1), (1, 14), (14, count // 2), (count // 2, count)]]
    order = np.random.default_rng(0).permutation(count)
    mixed = solve(order, threads=2)
    for field in FIELDS:
        expected = getattr(whole, field)
        assert np.concatenate([getattr(part, field) for part in parts]).tobytes() == expected.tobytes(), field
        assert getattr(mixed, field).tobytes() == expected[order].tobytes(), field


@pytest.mark.parametrize("n", [2, 4, 6, 12, 18, 30])
@pytest.mark.parametrize("family", [random_pd, random_spd, psd_rank_half, stewart_trinkle])
def test_same_bits_for_any_threads_split_and_order(family, n):
    if family is stewart_trinkle and n % 6:
        n = 24
    assert_bits_do_not_depend_on_the_batch(*family(1500, n))


@pytest.mark.parametrize("n", [6, 18, 30])
@pytest.mark.parametrize("family", [psd_rank_half, stewart_trinkle])
def test_same_bits_for_warm_starts(family, n):
    """Guesses of which some are right, some nearly, some wrong."""
    A, q = family(700, n)
    cold = lcpstar.solve_batch(A, q)
    rng = np.random.default_rng(2)
    flips = (rng.random((700, n)) < 0.02) @ (1 << np.arange(n, dtype=np.uint64))
    assert_bits_do_not_depend_on_the_batch(A, q, cold.alpha ^ flips.astype(np.uint64))
    assert_bits_do_not_depend_on_the_batch(A, q, cold.z * (rng.random((700, n)) < 0.98))


@pytest.mark.parametrize("family", [random_pd, psd_rank_half, stewart_trinkle])
def test_same_bits_in_single_precision(family):
    for n in (6, 18):
        A, q = (x.astype(np.float32) for x in family(700, n))
        assert_bits_do_not_depend_on_the_batch(A, q)


@pytest.mark.parametrize("n", [2, 3, 4, 8, 12, 16, 20, 32, 40])
@pytest.mark.parametrize("family", [random_pd, random_spd, psd_rank_half])
def test_single_precision_is_solved_and_verified_in_double(family, n):
    """A float32 stands for the double that equals it: the same contract as for the widened problem."""
    A, q = (x.astype(np.float32) for x in family(203, n, seed=n))
    if family is psd_rank_half:  # rounding may leave no solution; a little more diagonal than that gives one
        A += np.float32(1e-4) * np.eye(n, dtype=np.float32)
    assert_solved(A, q, lcpstar.solve_batch(A, q))
    assert_solved(A, q, lcpstar.solve_batch(A, q.astype(float)))
    wide = lcpstar.solve_batch(A.astype(float), q.astype(float))
    assert np.array_equal(wide.z, lcpstar.solve_batch(A, q).z, equal_nan=True)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_tiny_problems_of_every_kind(n):
    """Small integers: many singular, indefinite and infeasible ones. A solution exists iff some support gives one."""
    rng = np.random.default_rng(n)
    A = rng.integers(-2, 3, (3000, n, n)).astype(float)
    q = rng.integers(-3, 4, (3000, n)).astype(float)
    sols = lcpstar.solve_batch(A, q)
    where = sols.success
    w = (A @ sols.z[..., None])[..., 0] + q
    assert (np.abs(np.minimum(sols.z, w))[where] <= 1e-9).all()
    assert (sols.z[where] >= 0).all()
    regular = np.zeros(3000, bool)
    for mask in range(2**n):
        alpha = [i for i in range(n) if mask >> i & 1]
        B = A[:, alpha][:, :, alpha]
        good = np.abs(np.linalg.det(B)) > 0.5 if alpha else np.ones(3000, bool)
        z = np.zeros((3000, n))
        if alpha:
            z[np.ix_(good, alpha)] = -np.linalg.solve(B[good], q[good][:, alpha, None])[..., 0]
        w = (A @ z[..., None])[..., 0] + q
        regular |= good & (z > -1e-12).all(axis=1) & (w > -1e-12).all(axis=1)
    assert where[regular].all()
    assert (sols.method[regular] == "enumerate").mean() > 0.9


@pytest.mark.parametrize("n", [2, 8, 18, 30])
def test_one_matrix_with_many_vectors(n):
    """The matrix is loaded once: the same bits as many copies of it."""
    A = random_spd(1, n)[0][0]
    q = np.random.default_rng(n).standard_normal((333, n))
    assert_same_bits(lcpstar.solve_batch(A, q), lcpstar.solve_batch(np.stack([A] * 333), q))
    two = np.stack([A, A + np.eye(n)])
    each = np.broadcast_to(two[:, None], (2, 333, n, n))
    assert_same_bits(lcpstar.solve_batch(two[:, None], q), lcpstar.solve_batch(each, np.broadcast_to(q, (2, 333, n))))


@pytest.mark.parametrize("n", [6, 12, 18, 30])
def test_a_right_guess_of_frictional_contacts(n):
    """No pivot where the support is regular without exchanges, which nearly all are."""
    A, q = stewart_trinkle(600, n)
    cold = lcpstar.solve_batch(A, q)
    warm = lcpstar.solve_batch(A, q, z0=cold.z)
    assert_solved(A, q, warm)
    assert ((warm.method == "newton") & (warm.iterations <= 1)).mean() > 0.97
    warm = lcpstar.solve_batch(A, q, alpha0=cold.alpha)
    assert_solved(A, q, warm)
    assert ((warm.method == "newton") & (warm.iterations == 1)).mean() > 0.97


@pytest.mark.parametrize("n", [12, 18, 24, 30])
def test_degenerate_contacts_do_not_need_the_general_solver(n):
    """Impulses that are rounding error beside their terms are zero: the kernels verify what they find."""
    A, q = stewart_trinkle(2000, n)
    sols = lcpstar.solve_batch(A, q)
    assert_solved(A, q, sols)
    assert (sols.method == "lemke").mean() > 0.995
    assert (sols.z[sols.z > 0] > 1e-25).all()


def test_results_bear_the_names_that_solve_gives():
    """Two unconnected blocks, too large for the kernels: `solve` answers them piece by piece, and the batch says so."""
    (smooth, rough), n = (random_spd(1, 100), stewart_trinkle(1, 96)), 196
    A = np.zeros((n, n))
    A[:100, :100], A[100:, 100:] = smooth[0][0], rough[0][0]
    q = np.concatenate([smooth[1][0], rough[1][0]])
    assert lcpstar.solve(A, q).method == "pieces"
    assert lcpstar.solve_batch(A, q).method == "pieces"


def test_a_point_on_a_singular_support_is_a_guess():
    """Four legs on the floor: any split of the load is a solution, and the one given is kept."""
    A = np.ones((50, 4, 4))
    q = np.full((50, 4), -1.0)
    z = np.random.default_rng(0).dirichlet(np.ones(4), 50)
    warm = lcpstar.solve_batch(A, q, z0=z)
    assert_solved(A, q, warm)
    assert (warm.iterations == 1).all()
    assert (warm.method == "newton").all()


def test_neighbours_do_not_matter():
    """A symmetric, a skew, a singular, an indefinite and a hopeless problem side by side, in every order."""
    n = 4
    A = np.stack([random_spd(1, n)[0][0], random_pd(1, n)[0][0], np.ones((n, n)), np.diag([1.0, -1, 2, 3]), -np.eye(n)])
    q = np.array([[-1.0, 2, -3, 1], [-1.0, -1, -1, -1], [-1.0, -1, -1, -1], [-1.0, 2, -1, 0], [-1.0, -1, -1, -1]])
    alone = [lcpstar.solve_batch(A[k : k + 1], q[k : k + 1]) for k in range(5)]
    rng = np.random.default_rng(1)
    for _ in range(20):
        order = rng.integers(0, 5, 23)
        sols = lcpstar.solve_batch(A[order], q[order])
        for field in FIELDS:
            expected = np.concatenate([getattr(alone[k], field) for k in order])
            assert getattr(sols, field).tobytes() == expected.tobytes(), field


def test_broadcasting_equals_the_loop():
    A, _ = random_pd(3, 5)
    q = np.random.default_rng(0).standard_normal((4, 1, 5))
    sols = lcpstar.solve_batch(A, q)
    assert sols.z.shape == (4, 3, 5)
    assert sols.alpha.shape == sols.residual.shape == (4, 3)
    flat = lcpstar.solve_batch(np.broadcast_to(A, (4, 3, 5, 5)), np.broadcast_to(q, (4, 3, 5)))
    assert_same_bits(sols, flat)
    one = lcpstar.solve_batch(A[0], q[:, 0])
    assert_same_bits(one, lcpstar.solve_batch(np.stack([A[0]] * 4), q[:, 0]))
    assert lcpstar.solve_batch(A[0], q[0, 0]).z.shape == (5,)


def test_views_and_memory_orders():
    A, q = random_pd(40, 5)
    expected = lcpstar.solve_batch(A, q)
    assert_same_bits(expected, lcpstar.solve_batch(np.asfortranarray(A), np.asfortranarray(q)))
    assert_same_bits(lcpstar.solve_batch(A[::2], q[::2]), lcpstar.solve_batch(A[::2].copy(), q[::2].copy()))


def test_inputs_are_not_changed():
    A, q = stewart_trinkle(30, 6)
    before = A.copy(), q.copy()
    lcpstar.solve_batch(A, q)
    assert np.array_equal(A, before[0])
    assert np.array_equal(q, before[1])


@pytest.mark.parametrize("shape", [(0, 3), (0, 0), (5, 0)])
def test_empty_batches(shape):
    sols = lcpstar.solve_batch(np.zeros((*shape, shape[1])), np.zeros(shape))
    assert sols.z.shape == shape
    assert sols.success.all()
    assert len(sols) == shape[0]


def test_ragged_batches_equal_the_loop():
    rng = np.random.default_rng(5)
    problems = []
    for k in range(50):
        A, q = random_pd(1, int(rng.integers(1, 9)), seed=k)
        problems.append((A[0], q[0]))
    sols = lcpstar.solve_batch(problems)
    split = lcpstar.solve_batch([A for A, _ in problems], [q for _, q in problems])
    assert_same_bits(sols, split)
    assert sols.offsets[-1] == sum(len(q) for _, q in problems)
    for k, (A, q) in enumerate(problems):
        here = slice(sols.offsets[k], sols.offsets[k + 1])
        one = lcpstar.solve_batch(A, q)
        assert sols.z[here].tobytes() == one.z.tobytes()
        assert sols.alpha[here].tolist() == [bool(int(one.alpha) >> i & 1) for i in range(len(q))]
    A_flat, q_flat = np.concatenate([A.ravel() for A, _ in problems]), np.concatenate([q for _, q in problems])
    flat = lcpstar.solve_batch(A_flat, q_flat, offsets=sols.offsets)
    assert_same_bits(sols, flat)
    for guess in ({"z0": sols.z}, {"alpha0": sols.alpha}):
        warm = lcpstar.solve_batch(A_flat, q_flat, offsets=sols.offsets, **guess)
        assert warm.success.all()
        assert (warm.iterations == 1).all()
    again = lcpstar.solve_batch(problems, z0=[sols.z[sols.offsets[k] : sols.offsets[k + 1]] for k in range(50)])
    assert again.success.all()
    assert (again.iterations == 1).all()


@pytest.mark.parametrize("n", [4, 12, 24, 32])
def test_a_right_guess_costs_one_factorisation(n):
    A, q = random_pd(300, n)
    cold = lcpstar.solve_batch(A, q)
    flags = (cold.alpha[:, None] >> np.arange(n, dtype=np.uint64)) & np.uint64(1) == 1
    for guess in ({"alpha0": cold.alpha}, {"alpha0": flags}, {"z0": cold.z}):
        warm = lcpstar.solve_batch(A, q, **guess)
        assert_solved(A, q, warm)
        assert (warm.iterations == 1).all()
        assert (warm.method == "newton").all()
        assert np.allclose(warm.z, cold.z, rtol=1e-11, atol=1e-13)


def test_a_right_guess_above_the_lanes():
    A, q = random_pd(20, 48)
    cold = lcpstar.solve_batch(A, q)
    warm = lcpstar.solve_batch(A, q, z0=cold.z)
    assert_solved(A, q, warm)
    assert (warm.iterations == 0).all()
    assert (warm.method[q.min(axis=1) < 0] == "warm_start").all()


@pytest.mark.parametrize("n", [4, 12, 24, 40, 70])
def test_a_wrong_guess_costs_nothing_but_time(n):
    A, q = random_pd(300, n)
    rng = np.random.default_rng(1)
    assert_solved(A, q, lcpstar.solve_batch(A, q, alpha0=rng.random((300, n)) < 0.5))


def test_other_methods_solve_each_problem():
    A, q = random_pd(20, 5)
    sols = lcpstar.solve_batch(A, q, method="lemke")
    assert_solved(A, q, sols)
    assert set(sols.method) <= {"lemke", "trivial"}


def test_masks_up_to_64_flags_above():
    A, q = random_pd(3, 64)
    assert lcpstar.solve_batch(A, q).alpha.dtype == np.uint64
    A, q = random_pd(3, 65)
    sols = lcpstar.solve_batch(A, q)
    assert sols.alpha.shape == (3, 65)
    assert np.array_equal(sols.alpha, sols.z > 0)


@pytest.mark.parametrize("k", [0, 5, 19])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_the_first_number_that_is_not_finite_is_named(k, value):
    A, q = random_pd(20, 3)
    bad = A.copy()
    bad[k, 1, 2] = value
    if k < 19:
        bad[19, 0, 0] = np.nan
    with pytest.raises(lcpstar.errors.NotFiniteError, match=rf"A\[{k}, 1, 2\]"):
        lcpstar.solve_batch(bad, q)
    bad = q.copy()
    bad[k, 2] = value
    with pytest.raises(lcpstar.errors.NotFiniteError, match=rf"q\[{k}, 2\]"):
        lcpstar.solve_batch(A, bad, threads=2)


@pytest.mark.parametrize(
    ("A", "q", "options"),
    [
        (np.zeros((3, 2, 3)), np.zeros((3, 3)), {}),
        (np.zeros((3, 2, 2)), np.zeros((3, 3)), {}),
        (np.zeros((3, 2, 2)), np.zeros((4, 2)), {}),
        (np.zeros(4), np.zeros(4), {}),
        (np.eye(2), np.zeros(2), {"threads": 0}),
        (np.eye(2), np.zeros(2), {"tol": 0.0}),
        (np.eye(2), np.zeros(2), {"tol": np.nan}),
        (np.eye(2), np.zeros(2), {"method": "magic"}),
        (np.eye(2), np.zeros(2), {"z0": np.zeros(3)}),
        (np.eye(2), np.zeros(2), {"z0": np.zeros(2), "alpha0": 0}),
        (np.eye(2), np.zeros(2), {"alpha0": 0.5}),
        ([np.eye(2), np.eye(3)], [np.zeros(2)], {}),
        ([np.eye(2), np.eye(3)], [np.zeros(2), np.zeros(2)], {}),
        ([np.eye(2), np.eye(3)], [np.zeros(2), np.zeros(3)], {"z0": [np.zeros(2), np.zeros(2)]}),
        (np.zeros(5), np.zeros(3), {"offsets": [0, 1, 2]}),
        (np.zeros(4), np.zeros(3), {"offsets": [0, 1, 3]}),
        (np.zeros(5), np.zeros(3), {"offsets": [1, 2, 3]}),
        (np.zeros(5), np.zeros(3), {"offsets": [0, 3, 1, 3]}),
        (np.zeros(5), np.zeros(3), {"offsets": [0.0, 1.0, 3.0]}),
        (np.zeros(5), np.zeros(3), {"offsets": []}),
        (np.zeros(5), np.zeros(3), {"offsets": [0, 1, 3], "alpha0": [0, 1, 0]}),
        (np.zeros(5), np.zeros(3), {"offsets": [0, 1, 3], "z0": np.zeros(2)}),
    ],
)
def test_broken_promises_are_exceptions(A, q, options):
    with pytest.raises(lcpstar.LCPError) as caught:
        lcpstar.solve_batch(A, q, **options)
    assert isinstance(caught.value, ValueError)


def test_gufunc_marks_what_is_not_solved():
    A = np.array([[[2.0, 1.0], [1.0, 2.0]], [[1.0, -1.0], [-1.0, 1.0]]])
    z = lcpstar.solve_gufunc(A, [[-5.0, -6.0], [-1.0, -1.0]])
    assert np.allclose(z[0], [4 / 3, 7 / 3])
    assert np.isnan(z[1]).all()
    assert lcpstar.solve_gufunc.signature == "(n,n),(n)->(n)"


def test_the_interpreter_is_released():
    """Another Python thread makes progress during one long call."""
    A, q = random_pd(60_000, 8)
    ticks, stop = [], threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.0005)

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.perf_counter()
    for _ in range(5):
        lcpstar.solve_batch(A, q, threads=1)
    end = time.perf_counter()
    stop.set()
    thread.join()
    assert sum(start < t < end for t in ticks) > 5


def test_published_contact_batches(corpus):
    for path in [p for p in corpus if p.name.startswith("batch_")]:
        data = np.load(path)
        assert_solved(data["A"], data["q"], lcpstar.solve_batch(data["A"], data["q"]))


def test_dask_example():
    pytest.importorskip("dask.distributed")
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "examples"))
    example = importlib.import_module("dask_batch")
    summary = example.run(problems=20_000, n=8, chunk=5_000, workers=2)
    assert summary["solved"] == summary["problems"] == 20_000
    assert summary["worst"] <= 1e-9
