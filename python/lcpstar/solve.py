"""`solve` and `ppt`: coerce the arrays, call the core."""

from __future__ import annotations

from collections.abc import Sequence

from numpy import ndarray
from numpy.typing import ArrayLike

from . import _core
from ._core import Solution
from .coerce import Matrix, Vector, as_count, as_indices, as_matrix, as_number, as_seconds, as_text, as_vector
from .errors import OptionTypeError
from .options import OPTIONS, InteriorPointOptions, MethodOptions
from .sparse import is_sparse, solve_sparse


def solve(
    A: ArrayLike,
    q: ArrayLike,
    method: str = "auto",
    tol: float = 1e-9,
    max_iterations: int | None = None,
    time_limit: float | None = None,
    z0: ArrayLike | None = None,
    certify: str = "float",
    options: MethodOptions | None = None,
) -> Solution:
    """Solve the linear complementarity problem LCP(q, A).

    Find z with  w = A z + q,  w >= 0,  z >= 0,  z'w = 0.

    Parameters
    ----------
    A : (n, n) array_like of real numbers, or a scipy.sparse matrix or array
        Need not be symmetric. Copied; never modified. A sparse A stays sparse: methods "auto",
        "interior_point" and the approximate ones.
    q : (n,) array_like of real numbers
    method : str
        "auto" (a documented portfolio, see docs/methods.md), "lemke", "lemke_howson", "principal_pivoting",
        "block_pivoting", "chandrasekaran" (Z-matrices), "enumerate" (n <= 24), "bilinear", "interior_point",
        "potential_reduction", and the approximate "newton", "pgs", "pgs_sm", "nncg", "apgd", "admm".
    tol : float in (0, 1)
        Bounds `Solution.residual` of a solved problem: `max|min(z', w')| / max(1, max|z'|)` on the problem
        equilibrated by powers of two, so it does not depend on units.
    max_iterations : int, optional
        Pivots or iterations in all; the default depends on the method.
    time_limit : float, optional
        Seconds; checked once per iteration.
    z0 : (n,) array_like, optional
        A guess, used by its support. Right, it costs one factorisation and no pivot; nearly right, about one pivot for
        each wrong index.
    certify : "float" or "exact"
        "exact" proves the answer in rational arithmetic on the given binary numbers.
    options : LemkeOptions or the options class of `method`, optional

    Returns
    -------
    Solution
        Check `success` or `status`. Anything but "solved" keeps the best iterate.

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError, OptionError
        Subclasses of LCPError and of ValueError or TypeError, as is TooLargeError ("enumerate" beyond its order).
        A problem that cannot be solved does not raise.

    Notes
    -----
    Lemke's method solves every q when A is strictly semimonotone (P, strictly copositive, ...), and every feasible q
    when A is PSD, copositive plus, row sufficient, or in the paper's tilde class. "solved" and "infeasible" are said
    only after a check against the given numbers. O(n^2) a pivot. [CPS92] sec. 4.4.

    Examples
    --------
    >>> sol = solve([[2, 1], [1, 2]], [-5, -6])
    >>> sol.success, sol.z.round(4).tolist()
    (True, [1.3333, 2.3333])
    """
    sparse = type(A) is not ndarray and is_sparse(A)
    if sparse and method == "auto" and isinstance(options, InteriorPointOptions):
        method = "interior_point"
    if options is not None:
        _check_options(method, options)
    if max_iterations is not None:
        max_iterations = as_count("max_iterations", max_iterations)
    if time_limit is not None:
        time_limit = as_seconds("time_limit", time_limit)
    if sparse:
        _check_types(method, tol, certify)
        return solve_sparse(A, q, method, tol, max_iterations, time_limit, z0, certify, options)
    start = None if z0 is None else as_vector("z0", z0)
    solution = None
    try:
        if type(A) is ndarray and type(q) is ndarray:  # most calls; the core takes them as they are, or says None
            solution = _core.solve(A, q, method, tol, max_iterations, time_limit, start, certify, options)
        if solution is None:
            a, b = as_matrix("A", A), as_vector("q", q)
            solution = _core.solve(a, b, method, tol, max_iterations, time_limit, start, certify, options)
    except TypeError:
        _check_types(method, tol, certify)
        raise
    assert solution is not None
    return solution


def _check_types(method: object, tol: object, certify: object) -> None:
    """Says which argument the core did not take. Asked afterwards, so that a call with the usual types pays nothing."""
    as_text("method", method)
    as_number("tol", tol)
    as_text("certify", certify)


def _check_options(method: str, options: MethodOptions) -> None:
    expected = OPTIONS.get(as_text("method", method))
    if expected is None or not isinstance(options, expected):
        takes = "no options" if expected is None else f"options of class {expected.__name__}"
        raise OptionTypeError(f"method {method!r} takes {takes}, got {type(options).__name__}")


def ppt(A: ArrayLike, alpha: Sequence[int], q: ArrayLike | None = None) -> Matrix | tuple[Matrix, Vector]:
    """Principal pivot transform of A (and q) on the index set alpha: `w_alpha` and `z_alpha` trade places.

    `M_aa = A_aa^-1`, `M_ab = -A_aa^-1 A_ab`, `M_ba = A_ba A_aa^-1`, `M_bb = A_bb - A_ba A_aa^-1 A_ab`, where b is the
    complement of a = alpha; `p_a = -A_aa^-1 q_a`, `p_b = q_b - A_ba A_aa^-1 q_a`. O(n^2 |alpha|). [CPS92] sec. 2.3.

    Parameters
    ----------
    A : (n, n) array_like
    alpha : sequence of int
        Indices in 0..n, none repeated, in any order.
    q : (n,) array_like, optional

    Returns
    -------
    M, or (M, p) when q is given

    Raises
    ------
    SingularBlockError
        A[alpha, alpha] is singular to rounding, so the transform does not exist. Names alpha and the rank.
    IndexSetError, OptionTypeError
        An index is out of range or repeated, or no integer.

    Examples
    --------
    >>> ppt([[2, 1], [1, 2]], [0]).tolist()
    [[0.5, -0.5], [0.5, 1.5]]
    """
    M, p = _core.ppt(as_matrix("A", A), as_indices("alpha", alpha), None if q is None else as_vector("q", q))
    return M if q is None else (M, p)
