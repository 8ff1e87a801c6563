"""`verify` accepts answers that state the truth, and refuses each one of whose statements one is broken."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lcpstar
from answers import (
    A2,
    BELOW,
    NEARLY,
    PROVED,
    Q2,
    SADDLE,
    answer,
    copy,
    exact_w,
    exponents,
    failed,
    infeasible,
    nearly,
    on_ray,
    solved,
)
from lcpstar import verify
from lcpstar.result import Certificate
from lcpstar.verify.problem import read_problem
from lcpstar.verify.tails import is_chained_dominant

GENUINE = {
    "solved": (A2, Q2, solved()),
    "solved without a certificate": (A2, Q2, answer(A2, Q2, [4 / 3, 7 / 3])),
    "solved, proved": (A2, Q2, answer(A2, Q2, [4 / 3, 7 / 3], certificate=PROVED)),
    "infeasible": (SADDLE, BELOW, infeasible()),
    "infeasible in fractions": (SADDLE, BELOW, infeasible([Fraction(1, 3)] * 2, exact=True)),
    "nearly infeasible": (NEARLY, BELOW, nearly()),
    "on a ray": (SADDLE, BELOW, on_ray()),
    "on a proved ray": (SADDLE, BELOW, on_ray(Certificate("ray", exact=True, z=[Fraction(1)] * 2))),
    "not sufficient": (
        -A2,
        Q2,
        answer(-A2, Q2, [0, 0], "numerical_breakdown", certificate=Certificate("not_sufficient", True, z=[1, 1])),
    ),
    "max_iterations": (A2, Q2, answer(A2, Q2, [1, 0], "max_iterations")),
}


@pytest.mark.parametrize("name", GENUINE)
def test_the_truth_is_accepted_dense_and_sparse(name):
    sparse = pytest.importorskip("scipy.sparse")
    A, q, sol = GENUINE[name]
    assert failed(A, q, sol) == set()
    for form in (sparse.csr_array, sparse.csc_matrix, sparse.coo_array):
        assert failed(form(A), q, sol) == set()
    assert failed([[Fraction(x) for x in row] for row in A.tolist()], [str(x) for x in q.tolist()], sol) == set()


class Hostile:
    """Raises whatever is asked of it."""

    def __getattr__(self, name):
        raise RuntimeError(name)

    def __iter__(self):
        raise KeyError("no")

    def __array__(self, *_, **__):
        raise ZeroDivisionError


BROKEN_VALUES = [
    *(None, "x", "1", b"1", np.nan, np.inf, -np.inf, 1j, -1, 7, 10**400, [], [None, None], ["1", "2"], [np.nan, 0.0]),
    *(
        [np.inf, 1.0],
        [[1.0, 2.0], [3.0]],
        [1.0],
        [-1.0, -1.0],
        [0.5, 0.25],
        [1.0, 2.0, 3.0],
        np.zeros((2, 2)),
        np.zeros(3),
    ),
    *(
        np.array([1j, 0]),
        np.array(["a", "b"]),
        np.array([None, 1]),
        {},
        object(),
        Ellipsis,
        Hostile(),
        True,
        False,
        [7],
        [-1],
    ),
    *(
        [0, 0],
        [0],
        [1],
        [True, False],
        [Fraction(1), Fraction(2)],
        [Fraction(-1), 1],
        "optimal",
        "solved",
        "infeasible",
    ),
    *("nearly_infeasible", "secondary_ray", "time_limit", lcpstar.Status.SOLVED, int, np.float32(3.0), 1e-3),
]
#: What a change by one of these values leaves as true as it was, by field.
STILL_TRUE = {
    "status": {"<Status.SOLVED: 'solved'>", "'time_limit'"},
    "success": {"None"},
    "z": {"[0, 0]"},
    "w": {"[0, 0]", "[-1.0, -1.0]"},
    "certificate": {"None"},  # the claim is then smaller
    "certificate.alpha": {"None"},
    "certificate.exact": {"False"},  # y proves it all the same
    "certificate.bound": {"7", "np.float32(3.0)", "0.001"},  # a weaker bound
    "certificate.z": {"[Fraction(1, 1), Fraction(2, 1)]", "[Fraction(-1, 1), 1]"},  # refutes sufficiency, too
    "ray.z": {"[0, 0]"},
    "ray.z0": {"7", "np.float32(3.0)"},
    "ray.w_hat": {"[0, 0]"},
}


def same(a, b):
    try:
        return type(a) is type(b) and bool(np.all(np.asarray(a) == np.asarray(b)))
    except Exception:
        return False


def broken_answers(sol):
    """The answer with one field broken, however deep."""
    for field in vars(sol):
        for value in BROKEN_VALUES:
            if not same(value, getattr(sol, field)):
                yield field, value, copy(sol, **{field: value})
    for part in ("certificate", "ray"):
        inner = getattr(sol, part)
        for field in vars(inner) if inner is not None else ():
            for value in BROKEN_VALUES:
                if not same(value, getattr(inner, field)):
                    yield (
                        f"{part}.{field}",
                        value,
                        copy(sol, **{part: SimpleNamespace(**{**vars(inner), field: value})}),
                    )


@pytest.mark.parametrize("name", GENUINE)
def test_one_broken_field_is_reported_and_nothing_raises(name):
    A, q, sol = GENUINE[name]
    count = 0
    for field, value, forged in broken_answers(sol):
        report = verify(A, q, forged)
        assert "verified" in str(report)
        assert not report or repr(value) in STILL_TRUE.get(field, ()), (field, value)
        count += not report
    assert count > 300
    for field in ("z", "w", "status", "residual", "natural_residual", "alpha", "certificate", "ray"):
        forged = copy(sol)
        delattr(forged, field)
        assert not verify(A, q, forged), field
    for nonsense in (None, 3, "solved", object(), Hostile(), {}, sol.z):
        assert not verify(A, q, nonsense)


def break_one(A, q, sol, i):
    """Genuine answers with one number or word changed in or at entry i."""
    step = np.zeros(len(q))
    step[i] = 1e-6 * (1 + abs(sol.z).max() + abs(sol.w).max())
    yield copy(sol, z=sol.z + step)
    yield copy(sol, w=sol.w + step)
    yield copy(sol, residual=sol.residual + 1e-6)
    yield copy(sol, natural_residual=sol.natural_residual + step[i])
    yield copy(sol, success=not sol.success)
    yield copy(sol, status="infeasible" if sol.success else "solved")
    if sol.z[i] > 0 or sol.w[i] > 1e-3:
        yield copy(sol, alpha=sorted({*sol.alpha} ^ {i}))
    for change in (lambda y: -y - 1, lambda y: y + 10**6) if sol.status == "infeasible" else ():
        y = list(sol.certificate.y)
        y[i] = change(y[i])
        if y[i] < 0 or (np.array(y) @ A > 0).any() or np.dot(q, y) >= 0:
            yield copy(sol, certificate=replace(sol.certificate, y=y))


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_an_answer_of_the_core_with_one_number_changed_is_refused(n, seed):
    rng = np.random.default_rng(seed)
    A, q = rng.integers(-3, 4, (n, n)).astype(float), rng.integers(-4, 5, n).astype(float)
    sol = lcpstar.solve(A, q, method="lemke", certify="exact")
    assert failed(A, q, sol) == set()
    for forged in break_one(A, q, sol, seed % n):
        assert failed(A, q, forged)


# numbers


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0, 30, 400, 1000]))
def test_sums_are_exact_up_to_one_rounding(seed, spread):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 6))

    def numbers(*shape):
        return np.ldexp(rng.integers(-3, 4, shape).astype(float), rng.integers(-spread, spread + 1, shape))

    A, x, q = numbers(n, n), numbers(n), numbers(n)
    with np.errstate(all="ignore"):
        last = -(A[0] @ x)  # cancels up to rounding
    q[0] = last if np.isfinite(last) else q[0]
    problem = read_problem(A, q)
    for sums in (problem.w(x), problem.w([Fraction(v) for v in x.tolist()])):
        for i, total in enumerate(exact_w(A, q, x)):
            unit = Fraction(2) ** int(sums.exponent[i])
            assert sums.value[i] == float(total / unit) or abs(total / unit) < 2.0**-1000
            assert (sums.value[i] > 0, sums.value[i] < 0) == (total > 0, total < 0)
            size = sum(abs(Fraction(a) * Fraction(v)) for a, v in zip(A[i].tolist(), x.tolist(), strict=True))
            size += abs(Fraction(float(q[i])))
            assert abs(Fraction(float(sums.size[i])) * unit - size) <= size / 2**48


def test_the_equilibration_is_that_of_the_core():
    """Named methods state the measured residual; so does an iterate that is not a solution."""
    rng = np.random.default_rng(5)
    for k in range(60):
        n = 1 + k % 7
        A = rng.standard_normal((n, n)) * 2.0 ** rng.integers(-60, 60, (n, n)) * (rng.random((n, n)) < 0.7)
        q = rng.standard_normal(n) * 2.0 ** rng.integers(-60, 60, n)
        scaling = read_problem(A, q).scaling
        assert (scaling.rows.tolist(), scaling.columns.tolist(), scaling.q) == exponents(A, q)
        sol = lcpstar.solve(A, q, method="lemke", max_iterations=1)
        assert not {name for name in failed(A, q, sol) if name.startswith(("residual =", "natural", "w ="))}


@pytest.mark.parametrize("unit", [1.0, 1e-290, 1e150])
def test_numbers_are_measured_in_any_unit(unit):
    rng = np.random.default_rng(7)
    for n in (1, 2, 5):
        A, q = rng.standard_normal((n, n)) * min(unit, 1e150), rng.standard_normal(n) * unit
        sol = answer(A, q, rng.random(n), "max_iterations")
        assert failed(A, q, sol) == set()
        assert failed(A, q, copy(sol, residual=sol.residual * (1 + 1e-9))) == {
            "residual = max|min(z', w')| / max(1, max|z'|)"
        }
        w = sol.w.copy()
        w[-1] += 1e-9 * abs(q[-1])
        assert "w = A z + q" in failed(A, q, copy(sol, w=w))


def test_each_statement_about_a_point_is_checked():
    def broken(A, q, z, **fields):
        A, q = np.array(A, float), np.array(q, float)
        return failed(A, q, answer(A, q, z, **fields))

    small, rows, alone = "residual <= tol", "|min(z, w)| is small in every row", "every row holds to its own numbers"
    absolute = "max|min(z', w')| is small itself"
    assert broken([[1]], [1], [0]) == set()
    assert broken([[1]], [1], [-1e-12]) == {"z >= 0"}
    assert broken([[1]], [-1], [1 + 1e-7]) == {rows, small}
    assert broken([[1, 0], [0, 1]], [-1, -1e-12], [1, 0]) == {alone}
    assert broken([[2.0, 1.0], [1.0, 2.0]], [-5, -6], [1, 0]) == {small, absolute, rows, alone}
    assert broken([[1, 0], [0, 1]], [-1, 1], [1, 0], alpha=[0, 1]) == {"w = 0 on alpha where z = 0"}
    assert broken([[1, 0], [0, 1]], [-1, 1], [1, 0], alpha=[]) == {"z = 0 outside alpha"}
    assert broken(np.zeros((2, 2)), [0, 0], [0, 0], alpha=[0, 0]) == {"alpha is an index set"}


FORGED_POINTS = [
    (SADDLE, BELOW, [1e16, 1e16]),
    (SADDLE, BELOW, [1e200, 1e200]),
    (SADDLE, BELOW, [2.0**900, 2.0**900]),
    (NEARLY, BELOW, [1e20, 1e20]),
    ([[1.0, 0], [0, 0]], [-1e300, -1e-30], [1e300, 0]),
    ([[1e-300, 0], [0, 1.0]], [-1e-300, -1e-320], [1, 0]),
    ([[-1.0]], [1.0], [0.5]),
    ([[0, -(2.0**-11), -0.25], [8192, -(2.0**-11), 0], [-(2.0**-11), 16384, 0]], [0, -4.0, 0], [2.0**-11, 2.0**-36, 0]),
    ([[-(2.0**-12), 2.0**-8, -256], [0, 0, 2.0**-12], [8, 0, -256.0]], [0, 256, -(2.0**-12)], [2.0**-15, 0, 0]),
    ([[-(2.0**26), 2.0**53], [2.0**-30, 2.0**-4]], [-16.0, 0], [0, 2.0**-49]),
]


@pytest.mark.parametrize(("A", "q", "z"), FORGED_POINTS)
def test_an_unsolvable_problem_is_not_solved_by_a_point_that_hides_its_error(A, q, z):
    sparse = pytest.importorskip("scipy.sparse")
    A, q = np.array(A, float), np.array(q, float)
    for stated in ({}, {"residual": 0.0}, {"natural_residual": 0.0}, {"residual": 0.0, "natural_residual": 0.0}):
        sol = answer(A, q, z, **stated)
        assert failed(A, q, sol), stated
        assert failed(sparse.csr_array(A), q, sol), stated
        assert failed(A, q, sol, exact=True), stated


def test_a_decayed_tail_is_forgiven_where_a_is_dominant():
    """z_i = 2^-i; the entries after the 70th are 0, and w = -2^-71 in the row that knows."""
    n = 100
    A = 2.5 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    q, z = -np.eye(n)[0], np.where(np.arange(n) < 70, 0.5 ** np.arange(1, n + 1), 0.0)
    assert failed(A, q, answer(A, q, z)) == set()
    alone = {"every row holds to its own numbers"}
    assert failed(A, q, answer(A, q, np.where(np.arange(n) < 40, z, 0.0))) >= alone  # 2^-41 is no rounding
    twice = np.kron(np.eye(2), A)
    both = np.concatenate([q, 1e-9 * q])
    found = failed(twice, both, answer(twice, both, np.concatenate([z, 1e-9 * z])))
    assert found == set()
    assert failed(twice, both, answer(twice, both, np.concatenate([z, 1e-9 * np.where(z < 1e-14, 0.0, z)]))) == alone
    loose = A.copy()
    loose[99, 98] = loose[98, 99] = -2.51  # not dominant
    assert failed(loose, q, answer(loose, q, z)) == alone


def test_chains_to_a_strict_row_make_a_dominant_matrix():
    def dominant(rows):
        return is_chained_dominant(read_problem(np.array(rows, float), np.zeros(len(rows))).A)

    assert dominant([[2, -1], [1, 2]])
    assert dominant([[2, -1, 0], [-1, 2, -1], [0, -1, 2]])
    assert not dominant([[1, -1], [-1, 1]])
    assert not dominant([[1, -1, 0], [-1, 1, 0], [0, 0, 1]])
    assert not dominant([[1, -2], [0, 1]])
    assert not dominant([[0]])
    assert not dominant([[-1]])
    assert not dominant([[0.3, -0.1, -0.2], [0, 1, 0], [0, 0, 1]])  # 0.1 + 0.2 > 0.3 in doubles, exactly


def test_the_empty_problem_and_the_options():
    empty = answer(np.zeros((0, 0)), [], [])
    assert verify([], [], empty)
    assert verify(np.zeros((0, 0)), np.zeros(0), empty, exact=True)
    for tol in (-1.0, np.nan, np.inf):
        with pytest.raises(lcpstar.errors.OptionError, match="tol"):
            verify(A2, Q2, solved(), tol=tol)
    sol = answer([[1.0]], [-1.0], [1 + 1e-7])
    assert verify([[1.0]], [-1.0], sol, tol=1e-6)
    assert "NOT verified" in str(verify([[1.0]], [-1.0], sol))


def test_the_problem_itself_must_be_valid():
    with pytest.raises(lcpstar.errors.NotFiniteError, match="nan"):
        verify([[np.nan]], [1.0], solved())
    with pytest.raises(lcpstar.errors.NotFiniteError, match="inf"):
        verify(A2, np.array([1.0, np.inf]), solved())
    with pytest.raises(lcpstar.errors.ShapeError):
        verify(A2, [1.0], solved())
    with pytest.raises(lcpstar.errors.LCPError):
        verify([["x"]], [1.0], solved())
    assert not verify(np.eye(3), -np.ones(3), solved())


def test_exact_numbers_are_taken_as_they_are():
    """3 z = 1 has the solution 1/3; the double next to it solves the rounded problem only."""
    third = Fraction(1, 3)
    proof = Certificate("solution", exact=True, alpha=[0], z=[Fraction(1)])
    for A, q in (([["1/3"]], ["-1/3"]), ([[third]], [-third])):
        sol = answer([[third]], [-third], [1.0])
        assert verify(A, q, sol, exact=True).exact
        assert verify(A, q, copy(sol, certificate=proof)).exact
        assert not verify([[1 / 3]], [-third], copy(sol, certificate=proof))
    large = 2**53 + 1
    sol = answer([[large]], [-large], [1.0])
    assert verify([[large]], [-large], sol, exact=True)
    assert verify([[large]], [-large], copy(sol, certificate=proof))
    assert not verify([[large]], [-(large - 1)], copy(sol, certificate=proof))
    y = Certificate("infeasible", y=np.array([3.0, 1.0]))
    A, q = [["-1/3", 0], [1, -1]], [0, -1]
    sol = answer([[-third, 0], [1, -1]], q, [0, 0], "infeasible", certificate=y)
    assert verify(A, q, sol).exact
    assert not verify([[float(-third), 0], [1, -1]], q, sol)  # 1 - 3 fl(1/3) > 0


def test_a_sparse_problem_of_half_a_million_stays_sparse():
    sparse = pytest.importorskip("scipy.sparse")
    n = 500_000
    A = sparse.diags_array([-1.0, 2.5, -1.0], offsets=[-1, 0, 1], shape=(n, n)).tocsr()
    rng = np.random.default_rng(0)
    z = np.maximum(rng.integers(-8, 9, n), 0).astype(float)
    q = np.where(z > 0, 0.0, rng.integers(0, 5, n)) - A @ z
    sol = SimpleNamespace(
        z=z, w=A @ z + q, status="solved", success=True, residual=0.0, natural_residual=0.0,
        alpha=np.flatnonzero(z).tolist(), certificate=None, ray=None,
    )  # fmt: skip
    assert failed(A, q, sol) == set()
    z = z.copy()
    z[77] += 0.5
    assert "w = A z + q" in failed(A, q, copy(sol, z=z))
    assert failed(A, q, copy(sol, z=z, w=A @ z + q))
