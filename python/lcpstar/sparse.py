"""A `scipy.sparse` matrix on its way to the core, which keeps it sparse."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import Solution
from ._core import solve_sparse as solve_rows
from .coerce import Vector, as_vector, check_integers
from .errors import DTypeError, IndexSetError, ShapeError
from .options import MethodOptions

Rows = tuple[NDArray[np.int64], NDArray[np.int64], Vector, Vector]


def is_sparse(A: Any) -> bool:
    """Whether `A` is a matrix or array of `scipy.sparse`, which need not be installed."""
    return type(A) is not np.ndarray and hasattr(A, "tocsr")


def as_rows(A: Any, q: ArrayLike) -> Rows:
    """Compressed rows without duplicates (starts, columns, values), and q of the right length.

    The arrays of A are checked before scipy computes with them: its compiled loops trust them.
    """
    n = _checked_order(A)
    rows = A.tocsr(copy=True)
    check_arrays(rows, n)
    rows.sum_duplicates()
    values = rows.data.astype(np.float64)
    if rows.data.dtype.kind in "iu":
        check_integers("A.data", rows.data, values)
    rhs = as_vector("q", q)
    if len(rhs) != n:
        raise ShapeError(f"q must have length {n}, got {len(rhs)}")
    return rows.indptr.astype(np.int64), rows.indices.astype(np.int64), values, rhs


def as_dense(A: Any) -> NDArray[Any]:
    """A sparse A as an array of its own type, for what is exponential in n anyway."""
    _checked_order(A)
    return np.asarray(A.toarray())


def _checked_order(A: Any) -> int:
    if A.ndim != 2 or A.shape[0] != A.shape[1]:
        raise ShapeError(f"A must be a square matrix, got shape {A.shape}")
    if A.dtype.kind not in "biuf":
        raise DTypeError(f"A must hold real numbers, got dtype {A.dtype}")
    check_arrays(A, A.shape[0])
    return int(A.shape[0])


def check_arrays(A: Any, n: int) -> None:
    """The arrays that hold an (n, n) matrix in one of scipy's formats; lists and dictionaries are safe with scipy."""
    kind = getattr(A, "format", None)
    if kind in ("csr", "csc"):
        _check_compressed(A, n, n)
        _check_same_length(A, "indices", A.indices)
    elif kind == "bsr":
        blocks = np.asarray(A.data).shape
        if len(blocks) != 3 or 0 in blocks[1:] or n % blocks[1] or n % blocks[2]:
            raise ShapeError(f"A.data must hold blocks that divide order {n}, got shape {blocks}")
        _check_compressed(A, n // blocks[1], n // blocks[2])
        _check_same_length(A, "indices", A.indices)
    elif kind == "coo":
        for name, indices in (("row", A.row), ("col", A.col)):
            _check_range(f"A.{name}", indices, n)
            _check_same_length(A, name, indices)
    elif kind == "dia":
        offsets = np.asarray(A.offsets)
        if np.ndim(A.data) != 2:
            raise ShapeError(f"A.data must have a row for each diagonal, got shape {np.shape(A.data)}")
        _check_index_array("A.offsets", offsets)
        _check_same_length(A, "offsets", offsets)


def _check_compressed(A: Any, major: int, minor: int) -> None:
    """`indptr` starts at 0, does not decrease and ends within `indices`, which are in 0..minor."""
    starts = np.asarray(A.indptr)
    _check_index_array("A.indptr", starts)
    if len(starts) != major + 1:
        raise ShapeError(f"A.indptr must have length {major + 1}, got {len(starts)}")
    if starts[0] != 0:
        raise ShapeError(f"A.indptr must start at 0, got {starts[0]}")
    falls = np.flatnonzero(starts[1:] < starts[:-1])
    if len(falls):
        i = int(falls[0])
        raise ShapeError(f"A.indptr must not decrease, got A.indptr[{i + 1}] = {starts[i + 1]} after {starts[i]}")
    if starts[-1] > len(A.indices):
        raise ShapeError(f"A.indptr must end within the {len(A.indices)} indices, got {starts[-1]}")
    _check_range("A.indices", A.indices, minor)


def _check_range(name: str, indices: Any, n: int) -> None:
    array = np.asarray(indices)
    _check_index_array(name, array)
    outside = np.flatnonzero((array < 0) | (array >= n))
    if len(outside):
        i = int(outside[0])
        raise IndexSetError(f"{name} must hold indices in 0..{n}, got {name}[{i}] = {array[i]}")


def _check_index_array(name: str, array: NDArray[Any]) -> None:
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise ShapeError(f"{name} must be a vector of integers, got shape {array.shape} and dtype {array.dtype}")


def _check_same_length(A: Any, name: str, array: Any) -> None:
    if len(A.data) != len(array):
        raise ShapeError(f"A.{name} must have the length of A.data, {len(A.data)}, got {len(array)}")


def solve_sparse(
    A: Any,
    q: ArrayLike,
    method: str,
    tol: float,
    max_iterations: int | None,
    time_limit: float | None,
    z0: ArrayLike | None,
    certify: str,
    options: MethodOptions | None,
) -> Solution:
    """Solve LCP(q, A) for a `scipy.sparse` A; called by `lcpstar.solve`.

    "auto" is the interior point method with sparse factorisations: monotone A (A + A' PSD) is solved or certified
    infeasible. The approximate methods work on A by rows and columns. The residual is that of the problem scaled to
    `D A D`. `certify="exact"` works on a dense copy and raises TooLargeError for n > 2000.
    """
    guess = None if z0 is None else as_vector("z0", z0)
    return solve_rows(*as_rows(A, q), method, tol, max_iterations, time_limit, guess, certify, options)
