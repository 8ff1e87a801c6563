"""Properties that hold for every problem: hypothesis looks for one that breaks them.

Deterministic (`derandomize`) and bounded. Problems are small and mostly integer, because ties and singular blocks are
what breaks pivoting; the whole solution set in exact arithmetic, `lcpstar.solutions`, is the judge.
"""

from __future__ import annotations

import contextlib
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import lcpstar
from lcp_checks import assert_farkas, assert_solves
from lcpstar import LCPError

DIRECT = ["lemke", "principal_pivoting", "block_pivoting", "enumerate", "bilinear", "interior_point", "lemke_howson"]
METHODS = ["auto", *DIRECT, "chandrasekaran", "potential_reduction"]
STATUSES = {
    "solved",
    "infeasible",
    "nearly_infeasible",
    "secondary_ray",
    "max_iterations",
    "time_limit",
    "numerical_breakdown",
}


def examples(count):
    return settings(
        derandomize=True, max_examples=count, deadline=None, database=None, suppress_health_check=list(HealthCheck)
    )


@st.composite
def problems(draw, most=5, least=0):
    """(A, q): integers, halves or decimals; plain, PSD, skew, Z, diagonally dominant or of low rank."""
    n = draw(st.integers(least, most))
    number = st.integers(-4, 4).map(float)
    if draw(st.integers(0, 2)) == 2:
        number = st.sampled_from([0.0, 0.1, -0.3, 1 / 3, -2.5, 1e-3, -1e3, 7.0])
    A = np.array(draw(st.lists(number, min_size=n * n, max_size=n * n))).reshape(n, n)
    q = np.array(draw(st.lists(number, min_size=n, max_size=n)))
    shape = draw(st.sampled_from(["plain", "psd", "skew", "z", "dominant", "rank"]))
    if shape == "psd":
        A = A.T @ A
    elif shape == "skew":
        A = A - A.T
    elif shape == "z":
        A = np.where(np.eye(n, dtype=bool), A, -np.abs(A))
    elif shape == "dominant":
        A = A + np.diag(np.abs(A).sum(axis=1) + 1)
    elif shape == "rank" and n:
        A = np.outer(A[0], A[:, 0])
    return A, q


def contract(A, q, solution, tol=1e-9):
    """What every answer satisfies, whatever its status."""
    n = len(q)
    assert str(solution.status) in STATUSES
    assert solution.z.shape == solution.w.shape == (n,)
    assert np.isfinite(solution.z).all()
    assert (solution.z >= 0).all()
    assert np.isfinite(solution.w).all()
    assert solution.message
    assert solution.success == (solution.status == "solved")
    if solution.status == "solved":
        assert_solves(A, q, solution, tol)
    if solution.status == "infeasible":
        assert_farkas(A, q, np.array([float(y) for y in solution.certificate.y]))
    if solution.status == "secondary_ray":
        assert solution.ray is not None
    assert lcpstar.verify(A, q, solution, tol=tol), lcpstar.verify(A, q, solution, tol=tol)


def is_in(faces, z, tol=1e-6):
    """Whether z lies in one of the faces: a linear programme over its vertices and rays."""
    from scipy.optimize import linprog

    for face in faces:
        columns = np.vstack([face.vertices, face.rays]).T
        weights = np.r_[np.ones(len(face.vertices)), np.zeros(len(face.rays))]
        scale = max(1.0, np.abs(z).max(initial=0.0))
        n, m = columns.shape
        # columns x - s = z, |s| <= t: least t.
        above = np.hstack([columns, -np.ones((n, 1))])
        below = np.hstack([-columns, -np.ones((n, 1))])
        run = linprog(
            np.r_[np.zeros(m), 1.0],
            A_ub=np.vstack([above, below]),
            b_ub=np.r_[z, -z],
            A_eq=np.r_[weights, 0.0][None, :],
            b_eq=[1.0],
        )
        if run.status == 0 and run.fun <= tol * scale:
            return True
    return False


@given(problems())
@examples(50)
def test_all_methods_agree_with_the_whole_solution_set(problem):
    A, q = problem
    faces = lcpstar.solutions(A, q)
    for method in METHODS:
        solution = lcpstar.solve(A, q, method=method)
        contract(A, q, solution)
        if solution.success:
            assert faces, (method, "solved, but there is no solution")
            if len(q):
                assert is_in(faces, solution.z), (method, solution.z)
        if solution.status == "infeasible":
            assert not faces, (method, "infeasible, but there is a solution")
        if method == "enumerate" and not solution.success:
            # Every index set with a nonsingular block was tried: what remains has singular bases only.
            for face in faces:
                for z in face.vertices:
                    alpha = [i for i in range(len(q)) if z[i] > 0]
                    block = [[Fraction(A[i, j]) for j in alpha] for i in alpha]
                    assert lcpstar.classes.exact.solve(tuple(map(tuple, block)), [0] * len(alpha)) is None


@given(problems(most=4))
@examples(40)
def test_exact_proofs_agree_with_the_whole_solution_set(problem):
    A, q = problem
    faces = lcpstar.solutions(A, q, exact=True)
    for method in ("auto", "principal_pivoting"):
        solution = lcpstar.solve(A, q, method=method, certify="exact")
        contract(A, q, solution)
        certificate = solution.certificate
        if certificate is not None and certificate.exact and certificate.kind in ("solution", "infeasible"):
            assert bool(faces) == (certificate.kind == "solution")
            assert lcpstar.verify(A, q, solution, exact=True)
        if faces == []:
            assert not solution.success


@given(problems(most=6), st.randoms(use_true_random=False))
@examples(40)
def test_permutation_scaling_embedding(problem, random):
    A, q = problem
    n = len(q)
    plain = lcpstar.solve(A, q)
    order = list(range(n))
    random.shuffle(order)
    permuted = lcpstar.solve(A[np.ix_(order, order)], q[order])
    contract(A[np.ix_(order, order)], q[order], permuted)
    contradicts = {("solved", "infeasible"), ("infeasible", "solved")}
    assert (str(plain.status), str(permuted.status)) not in contradicts

    # D_r A D_c and q D_r s by powers of two: the same answer, digit for digit, in other units.
    r, c = (2.0 ** np.array([random.randrange(-20, 21) for _ in range(n)]) for _ in range(2))
    s = 2.0 ** random.randrange(-20, 21)
    scaled = lcpstar.solve(A * r[:, None] * c, q * r * s)
    contract(A * r[:, None] * c, q * r * s, scaled)
    assert (str(plain.status), str(scaled.status)) not in contradicts

    # A decoupled block with a known solution changes nothing for the others.
    big = np.zeros((n + 2, n + 2))
    big[:n, :n], big[n:, n:] = A, [[2.0, 1.0], [1.0, 2.0]]
    embedded = lcpstar.solve(big, np.r_[q, -5.0, -6.0])
    contract(big, np.r_[q, -5.0, -6.0], embedded)
    assert (str(plain.status), str(embedded.status)) not in contradicts
    if embedded.success:
        contract(A, q, lcpstar.solve(A, q, z0=embedded.z[:n]))
        assert np.allclose(embedded.z[n:], [4 / 3, 7 / 3])


@given(problems(most=6, least=1))
@examples(30)
def test_scaling_a_p_matrix_scales_the_answer(problem):
    A, q = problem
    A = A + np.diag(np.abs(A).sum(axis=1) + 1)  # a P-matrix: one solution
    n = len(q)
    r, c = 2.0 ** np.arange(n), 4.0 ** -np.arange(n)
    for method in ("auto", "lemke", "block_pivoting", "principal_pivoting", "interior_point"):
        plain = lcpstar.solve(A, q, method=method)
        scaled = lcpstar.solve(A * r[:, None] * c, q * r, method=method)
        assert plain.success
        assert scaled.success
        assert np.allclose(scaled.z * c, plain.z, rtol=1e-8, atol=1e-8 * max(1.0, np.abs(plain.z).max()))


@given(problems(most=6))
@examples(40)
def test_a_smaller_tol_never_gives_a_larger_residual_than_it_allows(problem):
    A, q = problem
    allowed = np.inf
    for tol in (1e-2, 1e-5, 1e-8, 1e-11):
        for method in ("auto", "interior_point"):
            solution = lcpstar.solve(A, q, method=method, tol=tol)
            contract(A, q, solution, tol)
            if solution.success:
                assert solution.residual <= tol < allowed
        allowed = tol


@given(problems(most=6, least=1), st.integers(0, 7), st.sampled_from(METHODS))
@examples(80)
def test_max_iterations_is_never_exceeded(problem, limit, method):
    A, q = problem
    solution = lcpstar.solve(A, q, method=method, max_iterations=limit)
    contract(A, q, solution)
    assert solution.iterations <= limit


@given(problems(most=6, least=1), st.sampled_from(METHODS), st.randoms(use_true_random=False))
@examples(40)
def test_a_guess_never_changes_the_truth(problem, method, random):
    A, q = problem
    guess = np.array([random.choice([0.0, 0.5, 1e9]) for _ in q])
    solution = lcpstar.solve(A, q, method=method, z0=guess)
    contract(A, q, solution)
    if solution.success:
        again = lcpstar.solve(A, q, method=method, z0=solution.z)
        assert again.success
        assert again.iterations <= solution.iterations or method == "potential_reduction"


@given(problems(most=5, least=1), st.data())
@examples(40)
def test_a_pivot_transform_is_its_own_inverse_and_keeps_solutions(problem, data):
    A, q = problem
    n = len(q)
    alpha = sorted(data.draw(st.sets(st.integers(0, n - 1))))
    try:
        M, p = lcpstar.ppt(A, alpha, q=q)
    except lcpstar.errors.SingularBlockError:
        return
    condition = np.linalg.cond(A[np.ix_(alpha, alpha)]) if alpha else 1.0
    assume(condition < 1e6)
    back, q_back = lcpstar.ppt(M, alpha, q=p)
    size = 1e-9 * condition * (1 + np.abs(M).max() * np.abs(A).max(initial=1.0)) * (1 + np.abs(p).max())
    assert np.abs(back - A).max() <= size
    assert np.abs(q_back - q).max() <= size
    solution = lcpstar.solve(A, q, method="lemke")
    if solution.success:
        swapped = np.where(np.isin(np.arange(n), alpha), solution.w, solution.z)
        slack = np.where(np.isin(np.arange(n), alpha), solution.z, solution.w)
        assert np.abs(M @ swapped + p - slack).max() <= size * (1 + np.abs(swapped).max())


@given(st.lists(problems(most=4, least=4), min_size=1, max_size=9), st.sampled_from([1, 2, 5]))
@examples(30)
def test_a_batch_is_its_problems(batch, threads):
    A, q = np.array([A for A, _ in batch]), np.array([q for _, q in batch])
    together = lcpstar.solve_batch(A, q, threads=threads)
    for k in range(len(batch)):
        alone = lcpstar.solve_batch(A[k : k + 1], q[k : k + 1], threads=1)
        assert together.z[k].tobytes() == alone.z[0].tobytes()
        assert together.status[k] == alone.status[0]
        single = lcpstar.solve(A[k], q[k])
        assert not (together.success[k] and single.status == "infeasible")
        if together.success[k]:
            w = A[k] @ together.z[k] + q[k]
            assert np.abs(np.minimum(together.z[k], w)).max() <= 1e-8 * (1 + np.abs(A[k]).max() * together.z[k].max())


# Arguments: anything goes in, an answer or an exception of lcpstar's own comes out.

DTYPES = ["f2", "f4", "f8", ">f8", "g", "i1", "u2", "i4", ">i4", "i8", "u8", "?"]


@given(st.data())
@examples(60)
def test_any_real_dtype_order_and_stride(data):
    n = data.draw(st.integers(0, 5))
    dtype = np.dtype(data.draw(st.sampled_from(DTYPES)))
    low = 0 if dtype.kind in "u?b" else -3
    draw = hnp.arrays(np.int64, (n, n), elements=st.integers(low, 1 if dtype.kind == "b" else 3))
    A = data.draw(draw).astype(dtype)
    q = np.array(data.draw(st.lists(st.integers(-3, 3), min_size=n, max_size=n)), float)
    expected = lcpstar.solve(A.astype(float), q)
    views = [A, np.asfortranarray(A), A[::-1, ::-1].copy()[::-1, ::-1], A.tolist() if dtype.kind != "g" else A]
    wide = np.zeros((2 * n, 3 * n), dtype)
    wide[::2, ::3] = A
    readonly = A.copy()
    readonly.flags.writeable = False
    for view in [*views, wide[::2, ::3], readonly, np.ma.array(A)]:
        before = np.array(view, copy=True)
        solution = lcpstar.solve(view, q)
        assert (np.array(view) == before).all()
        assert str(solution.status) == str(expected.status)
        assert solution.z.tobytes() == expected.z.tobytes()


STRANGE = st.one_of(
    st.none(),
    st.text(max_size=3),
    st.floats(),
    st.integers(-5, 5),
    st.booleans(),
    st.complex_numbers(),
    st.binary(max_size=3),
    st.lists(
        st.one_of(st.integers(-2, 2), st.floats(), st.text(max_size=2), st.none(), st.lists(st.floats())), max_size=3
    ),
    hnp.arrays(
        st.sampled_from([np.float64, np.complex128, np.dtype("U2"), np.dtype("m8[s]")]), hnp.array_shapes(max_dims=3)
    ),
    st.just(np.array([[None, 1.0], [2.0, object()]], dtype=object)),
    st.sampled_from([{}, {1: 2}, set(), range(2), object, iter([1.0]), np.datetime64("2020-01-01"), slice(None)]),
)


@given(STRANGE, STRANGE)
@examples(80)
def test_strange_arrays_are_refused_by_name(A, q):
    for arguments in ((A, q), (np.eye(2), q), (A, np.ones(2))):
        for call in (lcpstar.solve, lcpstar.solve_batch, lcpstar.solutions):
            with contextlib.suppress(LCPError):
                assert call(*arguments) is not None


@given(
    method=st.one_of(st.sampled_from(METHODS), st.text(max_size=8)),
    tol=st.one_of(st.floats(), st.sampled_from([1e-9, 1e-3, 1e-15, 5e-324])),
    max_iterations=st.one_of(st.none(), st.integers(-3, 2**70)),
    time_limit=st.one_of(st.none(), st.floats()),
    z0=st.one_of(st.none(), STRANGE),
    certify=st.one_of(st.sampled_from(["float", "exact"]), st.text(max_size=5)),
)
@examples(150)
def test_strange_options_are_refused_by_name(**options):
    A, q = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-5.0, 6.0])
    with contextlib.suppress(LCPError, TypeError, OverflowError):  # the last two: a scalar of a wrong type
        contract(A, q, lcpstar.solve(A, q, **options), options["tol"])


@pytest.mark.parametrize("seed", range(6))
def test_larger_problems_by_every_method_that_takes_them(seed):
    """Order 40: planted solutions with ties; the methods' answers may differ, none may be wrong."""
    rng = np.random.default_rng(seed)
    n = 40
    B = rng.integers(-2, 3, (n, n // (1 + seed % 2))).astype(float)
    A = B @ B.T + (seed % 3) * np.eye(n) + (0.5 * (lambda X: X - X.T)(rng.integers(-2, 3, (n, n))) if seed > 2 else 0)
    z = np.where(rng.random(n) < 0.5, rng.integers(0, 4, n), 0).astype(float)
    q = np.where(z > 0, 0.0, rng.integers(0, 3, n)) - A @ z
    for method in ("auto", "lemke", "principal_pivoting", "block_pivoting", "interior_point", "bilinear"):
        solution = lcpstar.solve(A, q, method=method, time_limit=20)
        contract(A, q, solution)
        assert solution.status != "infeasible"
