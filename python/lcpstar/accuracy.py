"""`accuracy`: what can be said about a point beside its residual."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from . import _core
from .coerce import as_matrix, as_vector, check_finite
from .errors import ShapeError
from .sparse import as_rows, is_sparse


@dataclass(frozen=True)
class Accuracy:
    """How accurate a point z is, with `w = A z + q` without rounding: the sums are exact.

    `natural_residual` is `max|min(z, w)|`, `residual` the scale-free residual that `tol` bounds. `backward_error` is
    the least omega such that z solves a problem whose entries differ from the given ones by the fraction omega: `|w_i|`
    (where `z_i > 0`) or `max(0, -w_i)` (where `z_i = 0`) over `(|A||z| + |q|)_i`, at its largest. `error_bound` bounds
    `max|z - z*|` for the only solution z*, rounding errors included; infinite beyond the range of doubles, None where
    nothing is proved. `bound_reason` names the theorem, or says why there is none.
    """

    natural_residual: float
    residual: float
    backward_error: float
    error_bound: float | None
    bound_reason: str


def accuracy(A: ArrayLike, q: ArrayLike, sol: Any) -> Accuracy:
    """Measure a solution or any point of LCP(q, A).

    Parameters
    ----------
    A : (n, n) array_like, or a scipy.sparse matrix or array
    q : (n,) array_like
    sol : Solution, or (n,) array_like
        The point; of a `Solution` its `z`.

    Returns
    -------
    Accuracy

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError

    Notes
    -----
    Two classes have a bound. H-matrices with positive diagonal, M-matrices among them: `|z - z*| <= v` for any v > 0
    with `<A> v >= |min(diag(A) z, w)|`, where `<A>` is the comparison matrix; one solve finds v, and the inequality is
    checked with room for rounding [CX06]. Dense A with A + A' positive definite: `max|r| + |(A - I) r|_2 / lambda`,
    r = min(z, w), with a lower bound lambda of the least eigenvalue that a finished Cholesky factorisation proves
    [Rum06]. The smaller one is given. O(n^3); sparse A: one sparse factorisation.

    Examples
    --------
    >>> sol = lcpstar.solve([[2, -1], [-1, 2]], [-2, -2], method="pgs", tol=1e-3)
    >>> found = accuracy([[2, -1], [-1, 2]], [-2, -2], sol)
    >>> abs(sol.z - 2).max() <= found.error_bound < 0.01
    np.True_
    """
    z = as_vector("sol.z", getattr(sol, "z", sol))
    rhs = as_vector("q", q)
    check_finite("sol.z", z)
    if len(z) != len(rhs):
        raise ShapeError(f"sol.z must have length {len(rhs)}, as q, got {len(z)}")
    if is_sparse(A):
        return Accuracy(*_core.accuracy_sparse(*as_rows(A, rhs), z))
    return Accuracy(*_core.accuracy(as_matrix("A", A), rhs, z))
