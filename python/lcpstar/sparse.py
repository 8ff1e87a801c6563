"""A `scipy.sparse` matrix on its way to the core, which keeps it sparse."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._core import Solution
from .coerce import Vector, as_vector
from .errors import DTypeError, ShapeError
from .options import MethodOptions

Rows = tuple[NDArray[np.int64], NDArray[np.int64], Vector, Vector]


def is_sparse(A: Any) -> bool:
    """Whether `A` is a matrix or array of `scipy.sparse`, which need not be installed."""
    return type(A) is not np.ndarray and hasattr(A, "tocsr")


def as_rows(A: Any, q: ArrayLike) -> Rows:
    """Compressed rows without duplicates (starts, columns, values), and q of the right length."""
    if A.ndim != 2 or A.shape[0] != A.shape[1]:
        raise ShapeError(f"A must be a square matrix, got shape {A.shape}")
    if A.dtype.kind not in "biuf":
        raise DTypeError(f"A must hold real numbers, got dtype {A.dtype}")
    rows = A.tocsr(copy=True)
    rows.sum_duplicates()
    rhs = as_vector("q", q)
    if len(rhs) != rows.shape[0]:
        raise ShapeError(f"q must have length {rows.shape[0]}, got {len(rhs)}")
    return rows.indptr.astype(np.int64), rows.indices.astype(np.int64), rows.data.astype(np.float64), rhs


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
    return _core.solve_sparse(*as_rows(A, q), method, tol, max_iterations, time_limit, guess, certify, options)
