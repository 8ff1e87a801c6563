"""The paper's potential reduction method, with its table as a trace."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from . import _core
from ._core import Solution
from .coerce import Vector, as_count, as_flag, as_matrix, as_number, as_vector
from .options import PotentialReductionOptions


@dataclass(frozen=True, eq=False)
class Record:
    """Row k of the paper's Table 1: the point reached and the step that led there.

    `z`, `w` are `z^k`, `w^k`; `dz`, `dw` the direction `d^(k-1)`, of which `gamma**halvings` was taken; `psi` and
    `kappa` belong to the *previous* point, as in the paper. `solver` is "cholesky" or "qr": the factorisation that
    gave the direction, which differs from the one asked for after a switch.
    """

    k: int
    z: Vector
    w: Vector
    dz: Vector
    dw: Vector
    psi: float
    kappa: float
    halvings: int
    solver: str


def potential_reduction(
    A: ArrayLike,
    q: ArrayLike,
    z0: ArrayLike | None = None,
    beta: float = 0.5,
    gamma: float = 0.5,
    sigma: float = 0.2,
    eps: float = 1e-5,
    kappa_factor: float = 1.01,
    min_halvings: int = 1,
    max_iterations: int = 1000,
    direction: str = "cholesky",
    long_step: bool = False,
    trace: bool = False,
) -> Solution:
    """Solve LCP(q, A) by the paper's potential reduction method, on the numbers as they are given.

    `psi(z, w) = kappa log z'w - sum log z_i w_i` is reduced over strictly feasible pairs with
    `kappa = kappa_factor max(n, z'w / min_i z_i w_i)` anew in each iteration; the direction minimises its linearisation
    over `|Z^-1 d_z|^2 + |W^-1 d_w|^2 <= beta^2`, `d_w = A d_z`.

    Parameters
    ----------
    A : (n, n) array_like
    q : (n,) array_like
    z0 : (n,) array_like, optional
        Strictly feasible: `z0 > 0` and `A z0 + q > 0`. Without it, phase one looks for one.
    beta : float in (0, 1)
        Length of the direction in the scaled norm.
    gamma : float in (0, 1)
        Backtracking factor: trial step m is `gamma**m`.
    sigma : float in (0, 1/2)
        Fraction of the predicted decrease that is asked of a step.
    eps : float
        Stop when `z'w <= eps`. Status "solved" asks, beyond that, `residual <= min(sqrt(eps), 1e-2)`, because
        `z'w <= eps` bounds every `min(z_i, w_i)` by `sqrt(eps)`.
    kappa_factor : float above 1
    min_halvings : int
        The first trial step is `gamma**min_halvings`. The paper says 0, its Table 1 was made with 1.
    max_iterations : int
    direction : "cholesky" or "qr"
        Cholesky of `I + B'B`, `B = W^-1 A Z`, which switches to QR where its error estimate says that digits would be
        lost; or always QR of `[I; B]` with sorted rows and column pivoting.
    long_step : bool
        Same direction and potential; the step goes 0.95 of the way to the boundary, then is halved as needed. Tens of
        iterations instead of hundreds.
    trace : bool
        Keep `Solution.trace`, a list of `Record`.

    Returns
    -------
    Solution
        "numerical_breakdown" when phase one finds no strictly feasible point, or when `z'w` stops falling (see Notes);
        `message` says which.

    Raises
    ------
    StartError
        `z0` is not strictly feasible; names the entry.
    OptionError
        A parameter is out of range.

    Notes
    -----
    Converges for row sufficient A [Pang91]. The paper's theorem for the tilde class is false: on
    `A = [[1, 2], [2, 1]]`, `q = (-7, -3)`, `z0 = (2, 3)` the iterates tend to a point with `z'w = 7/4`. O(n^3) an
    iteration.

    Examples
    --------
    >>> A, q = [[0, 1, 1], [2, 0, 2], [-2, -5, 0]], [-4, -7, 10]
    >>> run = potential_reduction(A, q, z0=[1, 1, 5], trace=True)
    >>> run.success, run.z.round(4).tolist(), round(run.trace[0].psi, 4)
    (True, [1.0714, 1.5714, 2.4286], 29.3308)
    """
    limit, eps, trace = as_count("max_iterations", max_iterations), as_number("eps", eps), as_flag("trace", trace)
    options = PotentialReductionOptions(
        beta=beta,
        gamma=gamma,
        sigma=sigma,
        kappa_factor=kappa_factor,
        min_halvings=min_halvings,
        direction=direction,
        long_step=long_step,
    )
    start = None if z0 is None else as_vector("z0", z0)
    return _core.potential_reduction(as_matrix("A", A), as_vector("q", q), start, eps, limit, options, trace)
