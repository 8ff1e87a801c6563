"""`solve_batch`: many small problems in one call, and the same as a generalised ufunc."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .coerce import MAX_THREADS, as_count, as_matrix, as_number, as_real, as_text, as_vector, check_finite
from .errors import DTypeError, OptionError, OptionTypeError, ShapeError
from .result import Status

_STATUS = np.array(list(Status), dtype=object)
_METHODS = np.array(_core.batch_methods(), dtype=object)

Floats = NDArray[np.float64]
Reals = NDArray[np.float64] | NDArray[np.float32]
Guess = NDArray[np.uint64] | NDArray[np.bool_] | NDArray[np.float64]
_Any = TypeVar("_Any", bound=NDArray[Any])
_Arrays = tuple[
    Floats,
    Floats,
    NDArray[np.uint8],
    NDArray[np.uint8],
    NDArray[np.uint32],
    Floats,
    Floats,
    NDArray[np.uint64] | NDArray[np.bool_],
]

# Instances, because they are quicker to compare with than the types.
_DOUBLE, _CODE, _COUNT = np.dtype(np.float64), np.dtype(np.uint8), np.dtype(np.uint32)
_MASK, _FLAG = np.dtype(np.uint64), np.dtype(np.bool_)


@dataclass(frozen=True, eq=False)
class BatchSolution:
    """The verified results of a batch, as arrays over its leading axes.

    `z` and `w` have shape (..., n). `residual` and `natural_residual` are upper bounds of the quantities of `Solution`,
    rounding errors included; `tol` bounds `residual` wherever `success`. `alpha` holds the supports: bit masks (bit i:
    z_i positive or basic) for n <= 64, else booleans of shape (..., n). `iterations` counts factorisations, pivots or
    iterations of the method that answered.

    For a ragged batch `offsets` is set and z, w and alpha (booleans) are flat: problem k has the entries
    `offsets[k]:offsets[k + 1]`.
    """

    z: Floats
    w: Floats
    status_code: NDArray[np.uint8]
    method_code: NDArray[np.uint8]
    iterations: NDArray[np.uint32]
    residual: Floats
    natural_residual: Floats
    alpha: NDArray[np.uint64] | NDArray[np.bool_]
    offsets: NDArray[np.intp] | None = None

    def _arrays(self) -> _Arrays:
        """All arrays but `offsets`, in their order."""
        return (
            self.z,
            self.w,
            self.status_code,
            self.method_code,
            self.iterations,
            self.residual,
            self.natural_residual,
            self.alpha,
        )

    @property
    def success(self) -> NDArray[np.bool_]:
        """Where the problem is solved."""
        return np.asarray(self.status_code == 0)

    @property
    def status(self) -> NDArray[Any]:
        """A `Status` per problem."""
        return np.asarray(_STATUS[self.status_code])

    @property
    def method(self) -> NDArray[Any]:
        """The name of the method that answered, per problem."""
        return np.asarray(_METHODS[self.method_code])

    def __len__(self) -> int:
        """Length of the first axis; problems, if the batch is ragged."""
        return len(self.status_code)

    def __repr__(self) -> str:
        """One line: how many, how many solved, how well."""
        count, solved = self.status_code.size, int(np.count_nonzero(self.success))
        worst = float(self.residual[self.success].max(initial=0.0))
        return f"BatchSolution({solved} of {count} solved, residual <= {worst:.1e})"


def solve_batch(
    A: ArrayLike | Sequence[Any],
    q: ArrayLike | Sequence[Any] | None = None,
    method: str = "auto",
    tol: float = 1e-9,
    threads: int | None = None,
    z0: ArrayLike | Sequence[Any] | None = None,
    alpha0: ArrayLike | None = None,
    offsets: ArrayLike | None = None,
    out: BatchSolution | None = None,
) -> BatchSolution:
    """Solve many problems LCP(q, A) in one call: for each, find z with `w = A z + q >= 0`, `z >= 0`, `z'w = 0`.

    Parameters
    ----------
    A : (..., n, n) array_like, or a list of square matrices, or a list of pairs (A, q)
    q : (..., n) array_like, or a list of vectors; None for a list of pairs
        Leading axes broadcast as in NumPy: one A with many q, many A with one q, or both. C-contiguous float64 arrays
        and float32 arrays are not copied; a float32 stands for the double that equals it. Lists may mix orders
        ("ragged"), or `offsets` says where the problems of flat arrays are; the results are then flat, see
        `BatchSolution.offsets`.
    method : str
        "auto": kernels for small problems (below), then what `solve` does. Any other name as in `solve`, for all.
    tol : float in (0, 1)
        As in `solve`; bounds `residual` of solved problems.
    threads : int, optional
        Threads at most; one per core if None. Results are the same bits for any number of threads, any split of the
        batch and any order of its problems.
    z0 : (..., n) array_like, optional
        Guesses, e.g. the last frame's z. Only the support counts. A right one costs one factorisation and no pivot.
    alpha0 : (...) unsigned integers (bit masks, n <= 64) or (..., n) booleans, optional
        Guessed supports, e.g. `BatchSolution.alpha` of the last frame. Not together with z0.
    offsets : (k + 1,) integers, optional
        Problems of mixed orders in flat arrays: problem i has `n = offsets[i + 1] - offsets[i]`, the entries
        `offsets[i]:offsets[i + 1]` of q (and of z0, and of alpha0 as booleans), and the next n * n entries of A.
    out : BatchSolution, optional
        Results of an earlier call for a batch of the same shape, to be overwritten: a loop over frames then takes no
        memory from the system. Their z or alpha may be the guess of this call.

    Returns
    -------
    BatchSolution
        `out`, if given.

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError, OptionError
        The message names the argument and the index, the first of which is the place in the (flattened) batch.
        A problem that cannot be solved does not raise: look at `status`.

    Notes
    -----
    Eight or sixteen problems share the registers of one core: all supports by minors (n <= 3), Newton's method on
    min(z, w), which is block principal pivoting, for matrices with a positive diagonal (n <= 16), then Lemke's method
    (n <= 12) for what that leaves; up to n = 192 Lemke's method, one problem at a time; then the portfolio of `solve`.
    Every answer is verified from the given numbers with room for rounding; what fails is handed on, never dropped.
    Nothing is allocated per problem before the last stage. The interpreter is released. [CPS92] secs. 4.4, 5.8.

    Examples
    --------
    >>> sols = solve_batch([[[2, 1], [1, 2]]], [[-5, -6], [1, -2]])
    >>> sols.success.all(), sols.z.round(4).tolist()
    (np.True_, [[1.3333, 2.3333], [0.0, 1.0]])
    """
    count = 0 if threads is None else min(as_count("threads", threads, least=1), MAX_THREADS)
    if z0 is not None and alpha0 is not None:
        raise OptionError("z0 and alpha0 are both guesses of the support: give one of them")
    options = _Options(method, tol, count)
    if q is None:
        if not isinstance(A, (list, tuple)) or not all(isinstance(p, (list, tuple)) and len(p) == 2 for p in A):
            raise ShapeError("without q, A must be a list of pairs (A, q)")
        return _ragged([pair[0] for pair in A], [pair[1] for pair in A], z0, alpha0, options, out)
    if offsets is not None:
        return _flat(_real("A", A), _real("q", q), offsets, z0, alpha0, options, out)
    if isinstance(A, (list, tuple)) and isinstance(q, (list, tuple)) and len({_shape(v) for v in q}) > 1:
        return _ragged(A, q, z0, alpha0, options, out)
    return _uniform(_real("A", A), _real("q", q), z0, alpha0, options, out)


@dataclass(frozen=True)
class _Options:
    """What every problem of a batch shares."""

    method: str
    tol: float
    threads: int


def _real(name: str, value: Any) -> Reals:
    """`value` as an array of doubles, or of floats if that is what it holds."""
    if type(value) is np.ndarray and value.dtype == np.float32 and value.dtype.isnative:
        return value
    return as_real(name, value)


def solve_gufunc(A: ArrayLike, q: ArrayLike, tol: float = 1e-9, threads: int | None = 1) -> Floats:
    """Solve a batch and return z alone, NaN where a problem is not solved: a function of signature "(n,n),(n)->(n)".

    For `dask.array.apply_gufunc(lcpstar.solve_gufunc, lcpstar.solve_gufunc.signature, A, q)` and
    `xarray.apply_ufunc(..., input_core_dims=[["i", "j"], ["j"]], output_core_dims=[["i"]])`. One thread by default: the
    caller's scheduler owns the cores. See examples/dask_batch.py.

    Parameters
    ----------
    A : (..., n, n) array_like
    q : (..., n) array_like
    tol, threads
        As in `solve_batch`, which also says what is raised and at which cost.

    Returns
    -------
    (..., n) array

    Examples
    --------
    >>> solve_gufunc([[2, 1], [1, 2]], [[-5, -6], [1, -2]]).round(4).tolist()
    [[1.3333, 2.3333], [0.0, 1.0]]
    """
    sols = solve_batch(A, q, tol=tol, threads=threads)
    if not sols.success.all():
        sols.z[~sols.success] = np.nan
    return sols.z


solve_gufunc.signature = "(n,n),(n)->(n)"  # type: ignore[attr-defined]


def _shape(value: ArrayLike) -> tuple[int, ...] | None:
    """The shape of an array or of nested lists; None where they are ragged."""
    try:
        return np.shape(value)
    except ValueError:
        return None


def _uniform(
    A: Reals, q: Reals, z0: Any, alpha0: ArrayLike | None, options: _Options, out: BatchSolution | None
) -> BatchSolution:
    if A.ndim < 2 or A.shape[-1] != A.shape[-2]:
        raise ShapeError(f"A must have shape (..., n, n), got {A.shape}")
    n = A.shape[-1]
    if q.ndim < 1 or q.shape[-1] != n:
        raise ShapeError(f"q must have shape (..., {n}) to fit A of shape {A.shape}, got {q.shape}")
    lead = A.shape[:-2]
    if lead != q.shape[:-1]:
        try:
            lead = np.broadcast_shapes(lead, q.shape[:-1])
        except ValueError as error:
            raise ShapeError(f"leading axes of A {A.shape} and q {q.shape} do not broadcast") from error
    guess = _guess(z0, alpha0, lead, n)
    sols = _results(out, lead, (*lead, n), masks=n <= 64)
    if out is not None and guess is not None and any(np.may_share_memory(guess, x) for x in (out.z, out.alpha)):
        guess = guess.copy()
    try:
        _core.solve_batch(
            n,
            _contiguous(A),
            _contiguous(q),
            math.prod(lead),
            _map(A.shape[:-2], lead),
            _map(q.shape[:-1], lead),
            options.method,
            options.tol,
            options.threads,
            guess,
            sols._arrays(),
        )
    except TypeError:  # which argument the core did not take is asked afterwards: the usual types pay nothing
        as_text("method", options.method)
        as_number("tol", options.tol)
        raise
    return sols


def _results(
    out: BatchSolution | None,
    lead: tuple[int, ...],
    points: tuple[int, ...],
    masks: bool,
    offsets: NDArray[np.intp] | None = None,
) -> BatchSolution:
    """`out` if it fits, else new arrays: `lead` is the shape of a number per problem, `points` that of z."""
    layout = {
        "z": (points, _DOUBLE),
        "w": (points, _DOUBLE),
        "status_code": (lead, _CODE),
        "method_code": (lead, _CODE),
        "iterations": (lead, _COUNT),
        "residual": (lead, _DOUBLE),
        "natural_residual": (lead, _DOUBLE),
        "alpha": (lead, _MASK) if masks else (points, _FLAG),
    }
    if not isinstance(out, (BatchSolution, NoneType)):
        raise OptionTypeError(f"out must be a BatchSolution, got {type(out).__name__}")
    if out is None:
        return BatchSolution(**{name: np.empty(*kind) for name, kind in layout.items()}, offsets=offsets)
    for name, (shape, dtype) in layout.items():
        array = getattr(out, name)
        if array.shape != shape or array.dtype != dtype or not (array.flags.c_contiguous and array.flags.aligned):
            wanted, given = f"{dtype} of shape {shape}", f"{array.dtype} of {array.shape}"
            raise ShapeError(f"out.{name} must be C-contiguous and aligned {wanted}, got {given}")
    same = out.offsets is offsets if out.offsets is None or offsets is None else np.array_equal(out.offsets, offsets)
    if not same:
        raise ShapeError("out.offsets must be those of this batch")
    return out


def _contiguous(array: _Any) -> _Any:
    """`array` as the core reads it in place: its numbers next to each other, each where the processor wants it."""
    return array if array.flags.c_contiguous and array.flags.aligned else cast("_Any", np.array(array, order="C"))


def _map(own: tuple[int, ...], lead: tuple[int, ...]) -> NDArray[np.uintp] | None:
    """Which block of an array of leading shape `own` each problem reads; None: its own, or the only one."""
    blocks = math.prod(own)
    if own == lead or blocks == 1 or blocks == math.prod(lead):
        return None
    return np.ascontiguousarray(np.broadcast_to(np.arange(blocks, dtype=np.uintp).reshape(own), lead)).ravel()


def _guess(z0: Any, alpha0: ArrayLike | None, lead: tuple[int, ...], n: int) -> Guess | None:
    if z0 is not None:
        points = as_real("z0", z0)
        check_finite("z0", points)
        return _contiguous(_broadcast("z0", points, (*lead, n)))
    if alpha0 is None:
        return None
    alpha = _as_array("alpha0", alpha0)
    if alpha.dtype == np.bool_:
        return _contiguous(_broadcast("alpha0", alpha, (*lead, n)))
    if alpha.dtype.kind not in "iu" or n > 64:
        raise ShapeError(f"alpha0 must be booleans (..., {n}), or bit masks for n <= 64; got dtype {alpha.dtype}")
    if alpha.dtype.kind == "i" and (alpha < 0).any():
        raise OptionError(f"alpha0 must hold bit masks, got {alpha.min()}")
    masks = alpha.astype(np.uint64, copy=False)
    return _contiguous(_broadcast("alpha0", masks, lead))


def _as_array(name: str, value: ArrayLike) -> NDArray[Any]:
    try:
        return np.asarray(value)
    except ValueError as error:
        raise ShapeError(f"{name} is ragged: {error}") from error


def _broadcast(name: str, array: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    if array.shape == shape:
        return array
    try:
        return np.broadcast_to(array, shape)
    except ValueError as error:
        raise ShapeError(f"{name} must broadcast to shape {shape}, got {array.shape}") from error


def _ragged(
    A: Sequence[Any],
    q: Sequence[Any],
    z0: Any,
    alpha0: ArrayLike | None,
    options: _Options,
    out: BatchSolution | None,
) -> BatchSolution:
    """Lists of problems, put into flat arrays."""
    if len(A) != len(q):
        raise ShapeError(f"A and q must have the same length, got {len(A)} matrices and {len(q)} vectors")
    if alpha0 is not None:
        raise OptionError("alpha0 needs problems of one order or offsets; give z0 as a list of vectors")
    matrices = [as_matrix(f"A[{k}]", matrix) for k, matrix in enumerate(A)]
    vectors = [as_vector(f"q[{k}]", vector) for k, vector in enumerate(q)]
    for k, (matrix, vector) in enumerate(zip(matrices, vectors, strict=True)):
        if len(matrix) != len(vector):
            raise ShapeError(f"q[{k}] must have length {len(matrix)}, got {len(vector)}")
    offsets = np.cumsum([0, *map(len, vectors)])
    guess = None
    if z0 is not None:
        if not isinstance(z0, (list, tuple, np.ndarray)):
            raise DTypeError(f"z0 must be a list of vectors, got {type(z0).__name__}")
        points = [as_vector(f"z0[{k}]", point) for k, point in enumerate(z0)]
        if [len(point) for point in points] != [len(vector) for vector in vectors]:
            raise ShapeError("z0 must hold one vector for each problem, of its order")
        guess = _join(points)
    return _flat(_join([matrix.ravel() for matrix in matrices]), _join(vectors), offsets, guess, None, options, out)


def _join(vectors: list[Floats]) -> Floats:
    return np.concatenate([np.zeros(0), *vectors])


def _flat(
    A: Reals,
    q: Reals,
    offsets: ArrayLike,
    z0: Any,
    alpha0: ArrayLike | None,
    options: _Options,
    out: BatchSolution | None,
) -> BatchSolution:
    """Problems of one order are solved together; results go to their places in flat arrays."""
    starts = _as_array("offsets", offsets)
    if starts.ndim != 1 or len(starts) == 0 or starts.dtype.kind not in "iu":
        raise ShapeError(f"offsets must be a vector of integers, got shape {starts.shape} and dtype {starts.dtype}")
    starts = starts.astype(np.intp, copy=False)
    orders = np.diff(starts)
    if starts[0] != 0 or (orders < 0).any():
        raise ShapeError("offsets must start at 0 and not decrease")
    blocks = np.concatenate([[0], np.cumsum(orders * orders)])
    if q.shape != (starts[-1],):
        raise ShapeError(f"q must have shape ({starts[-1]},) to fit offsets, got {q.shape}")
    if A.shape != (blocks[-1],):
        raise ShapeError(f"A must have shape ({blocks[-1]},) to fit offsets, got {A.shape}")
    point = None if z0 is None else _broadcast("z0", as_real("z0", z0), q.shape)
    support = None if alpha0 is None else _as_array("alpha0", alpha0)
    if support is not None and (support.dtype != np.bool_ or support.shape != q.shape):
        raise ShapeError(f"alpha0 must be booleans of shape {q.shape}, got {support.dtype} {support.shape}")
    count, total = len(orders), int(starts[-1])
    sols = _results(out, (count,), (total,), masks=False, offsets=starts)
    for n in np.unique(orders):
        members = np.flatnonzero(orders == n)
        places = starts[members][:, None] + np.arange(n)
        part = _uniform(
            A[blocks[members][:, None] + np.arange(n * n)].reshape(-1, n, n),
            q[places],
            None if point is None else point[places],
            None if support is None else support[places],
            options,
            None,
        )
        sols.z[places], sols.w[places] = part.z, part.w
        sols.alpha[places] = part.alpha if part.alpha.ndim == 2 else _flags(part.alpha, int(n))
        for field in ("status_code", "method_code", "iterations", "residual", "natural_residual"):
            getattr(sols, field)[members] = getattr(part, field)
    return sols


def _flags(masks: NDArray[Any], n: int) -> NDArray[np.bool_]:
    return ((masks[:, None] >> np.arange(n, dtype=np.uint64)) & np.uint64(1)).astype(np.bool_)
