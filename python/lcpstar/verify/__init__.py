"""`verify`: an independent re-check of a solution and of its certificate.

Nothing here calls the compiled core, and no field of an answer is believed: each is computed again, in sums that are
exact.
"""

from __future__ import annotations

import math
from typing import Any

from ..errors import OptionError
from .claim import Claim, read_claim
from .point import Point, check_basis, check_exact_solution, check_numbers, check_rounded, check_solved
from .problem import Problem, read_problem
from .proofs import check_exact_ray, check_farkas, check_nearly_farkas, check_not_sufficient, check_ray
from .report import Check, Report

__all__ = ["Check", "Report", "verify"]

#: The certificates that may stand beside a status.
_KINDS: dict[str, tuple[str | None, ...]] = {
    "solved": ("solution", None),
    "infeasible": ("infeasible",),
    "nearly_infeasible": ("nearly_infeasible",),
}
_UNSOLVED = ("solution", "ray", "not_sufficient", None)
#: What a certificate of each kind holds, and nothing else.
_HOLDS: dict[str, tuple[set[str], ...]] = {
    "solution": ({"alpha"}, set()),
    "exact solution": ({"alpha", "z"},),
    "infeasible": ({"y"},),
    "nearly_infeasible": ({"y", "bound"},),
    "exact ray": ({"z"},),
    "exact not_sufficient": ({"y"}, {"z"}),
}


def verify(A: Any, q: Any, sol: Any, exact: bool = False, tol: float = 1e-9) -> Report:
    """Re-check a Solution of LCP(q, A) and its certificate, independently of the solver.

    Parameters
    ----------
    A : (n, n) array_like or scipy.sparse matrix
        Real numbers; in lists also `Fraction`, integers of any size and strings like "1/3", taken exactly.
    q : (n,) array_like
        As A.
    sol : Solution
        Or anything with its fields; none is trusted. `success` may be missing.
    exact : bool
        Demand a proof in rational arithmetic that `sol.z` is a solution, rounded: that of the certificate where it is
        exact; otherwise the complementary basis `sol.alpha` is solved here in O(k^3) operations on long integers.
    tol : float
        The tolerance that was given to `solve`.

    Returns
    -------
    Report
        True when every check holds. A certificate that says `exact` is checked exactly in any case, and so is what
        claims that a problem has no solution.

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError, OptionError
        For A, q and tol. Whatever is wrong with `sol` is reported, not raised.

    Notes
    -----
    `w = A z + q`, computed exactly and rounded once, must be the stated w up to the rounding of a plain sum; so must
    both residuals. "solved" then means `z >= 0` and, with `m = |A||z| + |q|`, on the equilibrated problem (z', w')
    `max|min(z', w')| <= tol max(1, max z')` and `<= max(tol, 1e-6)`, and in every row of the given one
    `|min(z, w)|_i <= 10 tol max|q| + 8 eps m_i` and `|w_i| <= sqrt(tol) m_i`, where `z_i = 0` only for `w_i < 0`.
    In a row in which the solution of a diagonally dominant system has decayed, w_i may be off by `32 eps max|q'|`.
    Instead an exact certificate may prove the solution of which `z` is the rounding, to the last bit.
    "infeasible" needs `y >= 0, A'y <= 0, q'y < 0` as rational numbers, whatever y is made of.
    "nearly_infeasible" needs `y >= 0, q'y < 0`, `(A'y)_j <= 1e-9 (|A|'y)_j`, and exactly
    `bound <= -q'y / max_j (A'y)_j`: no z >= 0 with `sum(z) < bound` is feasible.
    A certificate "not_sufficient" has x with x_i (A x)_i <= 0 for all i, < 0 for some i (or A').
    A ray must satisfy `w_hat = A z_hat + d z0_hat >= 0`, `z_hat >= 0`, `z_hat != 0`, `z_hat'w_hat = 0`, up to rounding.

    Examples
    --------
    >>> from lcpstar import solve
    >>> bool(verify([[2, 1], [1, 2]], [-5, -6], solve([[2, 1], [1, 2]], [-5, -6]), exact=True))
    True
    """
    if not 0 <= tol < math.inf:
        raise OptionError(f"tol must be nonnegative and finite, got {tol}")
    problem = read_problem(A, q)
    claim, checks = read_claim(sol, problem.n)
    if claim is None:
        return Report(tuple(checks), False)
    point = Point.of(problem, claim.z)
    checks += [*check_numbers(point, claim, tol), *_fits(claim)]
    proved = False
    if claim.status == "solved":
        found, proved = _solved(problem, point, claim, exact, tol)
        checks += found
    if claim.ray is not None:
        checks += check_ray(problem, claim.ray)
    if claim.certificate is not None and claim.status != "solved":
        checks += _certificate(problem, claim)
        proved = claim.certificate.exact or claim.certificate.kind in ("infeasible", "nearly_infeasible")
    return Report(tuple(checks), proved and all(check.ok for check in checks))


def _fits(claim: Claim) -> list[Check]:
    """Whether the fields belong together."""
    proof = claim.certificate
    kind = None if proof is None else proof.kind
    named = f"exact {kind}" if proof is not None and proof.exact else f"{kind}"
    allowed = _HOLDS.get(named, _HOLDS.get(f"{kind}", ()))
    basis = claim.alpha if proof is None or proof.exact or proof.alpha is None else proof.alpha
    held = set() if proof is None else {f for f in ("alpha", "y", "z", "bound") if getattr(proof, f) is not None}
    return [
        Check("success is that of the status", claim.success in (None, claim.status == "solved")),
        Check("the certificate fits the status", kind in _KINDS.get(claim.status, _UNSOLVED), f"{kind}"),
        Check("the certificate holds what its kind holds", proof is None or held in allowed, f"{sorted(held)}"),
        Check("alpha is the certificate's", sorted(basis) == sorted(claim.alpha)),
        Check("the status comes with its ray", claim.ray is not None or claim.status != "secondary_ray"),
    ]


def _solved(problem: Problem, point: Point, claim: Claim, exact: bool, tol: float) -> tuple[list[Check], bool]:
    """The checks, and whether they are a proof."""
    proof = claim.certificate
    if proof is not None and proof.exact:
        checks = check_exact_solution(problem, proof, claim.alpha)
        return [*checks, *([check_rounded(claim.z, proof.z)] if isinstance(proof.z, list) else [])], True
    checks = check_solved(problem, point, claim, tol)
    return (checks + check_basis(problem, claim), True) if exact else (checks, False)


def _certificate(problem: Problem, claim: Claim) -> list[Check]:
    """What it proves of a problem that is not called solved."""
    proof = claim.certificate
    assert proof is not None
    match proof.kind:
        case "infeasible":
            return check_farkas(problem, proof)
        case "nearly_infeasible":
            return check_nearly_farkas(problem, proof)
        case "not_sufficient":
            return check_not_sufficient(problem, proof)
        case "ray" if claim.ray is not None:
            return check_exact_ray(problem, proof, claim.ray)
        case "solution" if proof.exact:
            return check_exact_solution(problem, proof, claim.alpha)
    return [Check("the certificate proves something", False, proof.kind)]
