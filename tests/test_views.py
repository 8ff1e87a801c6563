"""Every function that takes an array reads every view of it as the plain copy is read."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

import lcpstar

A = np.array([[4.0, -1.0, 0.5], [-1.5, 3.0, 0.25], [0.0, -1.0, 2.0]])
q = np.array([-5.0, -6.0, 1.0])
z = np.array([2.0, 2.5, 1.0])


def _field(itemsize, offset):
    def view(x):
        record = np.zeros(
            x.shape, np.dtype({"names": ["x"], "formats": [x.dtype], "offsets": [offset], "itemsize": itemsize})
        )
        record["x"] = x
        return record["x"]

    return view


def _from_bytes(x):
    """Numbers that begin at an odd address."""
    return np.frombuffer(b"?" + np.ascontiguousarray(x).tobytes(), dtype=x.dtype, offset=1).reshape(x.shape)


def _every_other(x):
    wide = np.zeros((*x.shape[:-1], 2 * x.shape[-1]), x.dtype)
    wide[..., ::2] = x
    return wide[..., ::2]


def _backwards(x):
    every = tuple(slice(None, None, -1) for _ in x.shape)
    return x[every].copy()[every]


def _read_only(x):
    copy = x.copy()
    copy.setflags(write=False)
    return copy


VIEWS = {
    "packed field, item size 12": _field(12, 0),
    "packed field, item size 12, offset 4": _field(12, 4),
    "packed field, item size 9": _field(9, 1),
    "field, item size 16": _field(16, 8),
    "odd address": _from_bytes,
    "negative strides": _backwards,
    "every other": _every_other,
    "Fortran order": np.asfortranarray,
    "broadcast": lambda x: np.broadcast_to(x, (2, *x.shape))[1],
    "big-endian": lambda x: x.astype(x.dtype.newbyteorder(">")),
    "read-only": _read_only,
    "subclass": lambda x: np.ma.masked_array(x, mask=False),
    "matrix": lambda x: x.view(np.matrix) if x.ndim == 2 else x,
}


def _answer(solution):
    return solution.status, solution.z.tolist(), solution.w.tolist(), solution.residual


def _exact(A, q):
    solution = lcpstar.solve(A, q, certify="exact")
    return _answer(solution), solution.certificate.exact, solution.certificate.z


def _sparse(A, q, view):
    """A sparse matrix whose three arrays are views."""
    rows = sp.csr_array(A)
    parts = tuple(view(part) for part in (rows.data, rows.indices, rows.indptr))
    if parts[0].dtype.byteorder == ">":
        parts = (rows.data, rows.indices, rows.indptr)  # scipy does not take it
    made = sp.csr_array(rows)
    made.data, made.indices, made.indptr = parts
    return made


FUNCTIONS = {
    "solve": lambda v: _answer(lcpstar.solve(v(A), v(q))),
    "solve with z0": lambda v: _answer(lcpstar.solve(v(A), v(q), z0=v(z))),
    "solve, lists": lambda v: _answer(lcpstar.solve(A.tolist(), v(q))),
    "exact": lambda v: _exact(v(A), v(q)),
    "ppt": lambda v: [x.tolist() for x in lcpstar.ppt(v(A), [0, 2], q=v(q))],
    "solutions": lambda v: [(f.alpha, f.vertices.tolist()) for f in lcpstar.solutions(v(A), v(q))],
    "accuracy": lambda v: lcpstar.accuracy(v(A), v(q), v(z)),
    "potential_reduction": lambda v: _answer(lcpstar.potential_reduction(v(A), v(q), z0=v(z + 5.0), max_iterations=20)),
    "covering vector": lambda v: _answer(
        lcpstar.solve(v(A), v(q), "lemke", options=lcpstar.LemkeOptions(d=v(np.array([1.0, 2.0, 3.0]))))
    ),
    "verify": lambda v: bool(lcpstar.verify(v(A), v(q), lcpstar.solve(A, q))),
    "check": lambda v: lcpstar.classes.check(v(A), "P").holds,
    "game_value": lambda v: lcpstar.game_value(v(A)),
    "sparse": lambda v: _answer(lcpstar.solve(_sparse(A, q, v), v(q))),
    "sparse accuracy": lambda v: lcpstar.accuracy(_sparse(A, q, v), v(q), v(z)),
    "solve_gufunc": lambda v: lcpstar.solve_gufunc(v(A), v(q)).tolist(),
}


def _batched(v, dtype=np.float64, z0=None, alpha0=None):
    matrices, vectors = np.stack([A, A.T, A]).astype(dtype), np.stack([q, -q, z - 2.0]).astype(dtype)
    guess = {} if z0 is None else {"z0": v(np.stack([z, 0 * z, z]))}
    if alpha0 is not None:
        guess = {"alpha0": v(alpha0)}
    sols = lcpstar.solve_batch(v(matrices), v(vectors), **guess)
    return [x.tolist() for x in (sols.z, sols.w, sols.status_code, sols.natural_residual, sols.iterations)]


FUNCTIONS |= {
    "batch": _batched,
    "batch, float32": lambda v: _batched(v, dtype=np.float32),
    "batch with z0": lambda v: _batched(v, z0=True),
    "batch with masks": lambda v: _batched(v, alpha0=np.array([3, 0, 7], np.uint64)),
    "batch with flags": lambda v: _batched(v, alpha0=np.array([[True, True, False]] * 3)),
    "flat batch": lambda v: lcpstar.solve_batch(
        v(np.tile(A.ravel(), 2)), v(np.tile(q, 2)), offsets=v(np.array([0, 3, 6]))
    ).z.tolist(),
    "list of pairs": lambda v: lcpstar.solve_batch([(v(A), v(q)), (v(A[:2, :2].copy()), v(q[:2].copy()))]).z.tolist(),
}


@pytest.mark.filterwarnings("ignore:the matrix subclass")
@pytest.mark.parametrize("kind", VIEWS)
@pytest.mark.parametrize("function", FUNCTIONS)
def test_a_view_is_read_as_its_copy(function, kind):
    view = VIEWS[kind]
    assert FUNCTIONS[function](view) == FUNCTIONS[function](lambda x: x.copy())


def test_zero_strides():
    ones = np.broadcast_to(1.0, (3, 3))
    rhs = np.broadcast_to(-2.0, (3,))
    assert _answer(lcpstar.solve(ones, rhs)) == _answer(lcpstar.solve(np.ones((3, 3)), np.full(3, -2.0)))
    sols = lcpstar.solve_batch(np.broadcast_to(A, (5, 3, 3)), np.broadcast_to(q, (5, 3)))
    assert (sols.z == lcpstar.solve_batch(A, q).z).all()


@pytest.mark.parametrize("name", ["z", "w", "status_code", "iterations", "residual"])
def test_out_that_the_core_cannot_write_is_named(name):
    sols = lcpstar.solve_batch([A, A], [q, q])
    array = getattr(sols, name)
    for kind in ("odd address", "packed field, item size 12", "every other", "negative strides"):
        object.__setattr__(sols, name, VIEWS[kind](array))
        with pytest.raises(lcpstar.LCPError, match=rf"out\.{name}|writable"):
            lcpstar.solve_batch([A, A], [q, q], out=sols)


@pytest.mark.parametrize(
    "bad", [np.float64(1.0), np.zeros(()), np.zeros((0, 3)), np.zeros((1, 1, 1)), "text", object(), {}]
)
def test_what_is_no_matrix_is_named(bad):
    calls = [
        lambda: lcpstar.solve(bad, q),
        lambda: lcpstar.ppt(bad, [0]),
        lambda: lcpstar.accuracy(bad, q, z),
        lambda: lcpstar.solutions(bad, q),
        lambda: lcpstar.potential_reduction(bad, q),
        lambda: lcpstar.solve_batch(np.zeros((0, 2, 3)) if isinstance(bad, np.ndarray) and bad.ndim == 3 else bad, q),
    ]
    for call in calls:
        with pytest.raises(lcpstar.LCPError, match=r"\bA\b|A\["):
            call()


def test_empty():
    empty = np.zeros((0, 0))
    assert lcpstar.solve(empty, []).success
    assert lcpstar.solve_batch(np.zeros((4, 0, 0)), np.zeros((4, 0))).success.all()
    assert lcpstar.accuracy(empty, [], []).error_bound in (None, 0.0)
    assert lcpstar.ppt(empty, []).shape == (0, 0)


def test_a_vector_of_the_wrong_shape_is_named():
    for bad in (np.float64(1.0), np.zeros((3, 1)), np.zeros((0,)), "text", None):
        for call in (
            lambda bad=bad: lcpstar.solve(A, bad),
            lambda bad=bad: lcpstar.potential_reduction(A, bad),
            lambda bad=bad: lcpstar.accuracy(A, bad, z),
        ):
            with pytest.raises(lcpstar.LCPError, match=r"\bq\b"):
                call()
