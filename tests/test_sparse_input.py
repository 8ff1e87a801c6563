"""A malformed or surprising sparse A is an exception that names the array and the number, never a crash."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp

import lcpstar
from lcp_checks import assert_solves
from lcpstar import errors

DENSE = np.array([[2.0, -1, 0, 0], [-1, 2, -1, 0], [0, -1, 2, -1], [0, 0, -1, 2]])
Q = np.array([-1.0, 1, -2, 3])


def broken(kind, **arrays):
    """The matrix with some of its arrays overwritten."""
    A = sp.csr_array(DENSE).asformat(kind)
    if kind == "bsr":
        A = sp.csr_array(DENSE).tobsr((2, 2))
    for name, change in arrays.items():
        setattr(A, name, change(getattr(A, name).copy()))
    return A


def put(i, value):
    def change(array):
        array[i] = value
        return array

    return change


def cut(array):
    return array[:-1]


COMPRESSED = [
    ({"indptr": put(1, 10**6)}, r"A\.indptr must not decrease, got A\.indptr\[2\] = \d+ after 1000000"),
    ({"indptr": put(-1, 10**6)}, r"A\.indptr must end within the \d+ indices, got 1000000"),
    ({"indptr": put(0, -5)}, r"A\.indptr must start at 0, got -5"),
    ({"indptr": put(0, 1)}, r"A\.indptr must start at 0, got 1"),
    ({"indptr": cut}, r"A\.indptr must have length \d, got \d"),
    ({"indptr": lambda v: v.astype(float)}, r"A\.indptr must be a vector of integers"),
    ({"indptr": lambda v: v[:, None]}, r"A\.indptr must be a vector of integers"),
    ({"indices": put(1, 4)}, r"A\.indices must hold indices in 0\.\.\d, got A\.indices\[1\] = 4"),
    ({"indices": put(2, -1)}, r"A\.indices must hold indices in 0\.\.\d, got A\.indices\[2\] = -1"),
    ({"indices": cut}, r"A\.ind"),
    ({"indices": lambda v: v.astype(float)}, r"A\.indices must be a vector of integers"),
    ({"data": cut}, r"A\.indices must have the length of A\.data"),
]
OTHERS = [
    ("coo", {"row": put(0, 4)}, r"A\.row must hold indices in 0\.\.4, got A\.row\[0\] = 4"),
    ("coo", {"col": put(3, -7)}, r"A\.col must hold indices in 0\.\.4, got A\.col\[3\] = -7"),
    ("coo", {"data": cut}, r"A\.row must have the length of A\.data"),
    ("dia", {"offsets": cut}, r"A\.offsets must have the length of A\.data"),
    ("dia", {"data": lambda v: v[0]}, r"A\.data must have a row for each diagonal"),
    ("bsr", {"data": lambda v: v[0]}, r"A\.data must hold blocks"),
    ("bsr", {"data": lambda v: np.ones((len(v), 3, 3))}, r"A\.data must hold blocks that divide order 4"),
]
CASES = [(kind, *case) for kind in ("csr", "csc", "bsr") for case in COMPRESSED] + OTHERS


@pytest.mark.parametrize(("kind", "arrays", "text"), CASES)
def test_malformed_arrays_are_named(kind, arrays, text):
    for call in (lcpstar.solve, lambda A, q: lcpstar.accuracy(A, q, Q)):
        with pytest.raises((errors.ShapeError, errors.IndexSetError), match=text):
            call(broken(kind, **arrays), Q)


def test_a_malformed_matrix_does_not_end_the_process():
    code = (
        "import numpy as np, scipy.sparse as sp, lcpstar\n"
        "A = sp.csr_array(np.eye(50))\n"
        "A.indptr[1:] = 10**9\n"
        "try: lcpstar.solve(A, np.ones(50))\n"
        "except lcpstar.LCPError as error: print(error)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60)
    assert (run.returncode, run.stdout) == (0, "A.indptr must end within the 50 indices, got 1000000000\n")


@pytest.mark.parametrize("kind", ["csr", "csc", "coo", "bsr", "dia", "lil", "dok"])
def test_every_format_is_read(kind):
    A = sp.csr_array(DENSE).asformat(kind)
    assert_solves(DENSE, Q, lcpstar.solve(A, Q))


def test_duplicates_are_summed_and_a_longer_tail_is_ignored():
    i, j = np.nonzero(DENSE)
    twice = sp.coo_array((np.tile(DENSE[i, j] / 2, 2), (np.tile(i, 2), np.tile(j, 2))), shape=DENSE.shape)
    assert_solves(DENSE, Q, lcpstar.solve(twice, Q))
    tail = sp.csr_array(DENSE)
    tail.data, tail.indices = np.append(tail.data, np.nan), np.append(tail.indices, 0).astype(np.int32)
    assert_solves(DENSE, Q, lcpstar.solve(tail, Q))


@pytest.mark.parametrize("dtype", [np.int64, np.uint64])
def test_integers_that_are_no_doubles_are_refused_sparse_as_dense(dtype):
    A = np.array([[2, 0], [0, 2**53 + 1]], dtype=dtype)
    for matrix in (A, sp.csr_array(A), sp.coo_array(A), A.tolist(), [[2, 0.5], [0, 2**53 + 1]]):
        with pytest.raises(errors.DTypeError, match="9007199254740993, which is none"):
            lcpstar.solve(matrix, [-1, -1])
    A[1, 1] = 2**53 + 2
    for matrix in (A, sp.csr_array(A), A.tolist()):
        assert_solves(A.astype(float), [-2.0, -1.0], lcpstar.solve(matrix, [-2, -1]))


def test_integers_of_any_size_are_read_where_they_are_doubles():
    assert lcpstar.solve([[2**70]], [-(2**70)]).z.tolist() == [1.0]
    with pytest.raises(errors.DTypeError, match=r"q\[0\] = -1180591620717411303425"):
        lcpstar.solve([[1, 0], [0, 1]], [-(2**70) - 1, 0.5])
    with pytest.raises(errors.NotFiniteError, match="A must hold doubles"):
        lcpstar.solve([[10**400]], [-1])


@pytest.mark.parametrize("method", ["lemke", "enumerate"])
def test_a_method_for_dense_matrices_says_that_the_matrix_is_sparse(method):
    with pytest.raises(errors.UnknownNameError, match=f"method .*sparse.*interior_point.*{method}"):
        lcpstar.solve(sp.csr_array(DENSE), Q, method=method)
