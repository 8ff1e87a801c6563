"""`verify`: an independent re-check of a solution and of its certificate.

Nothing here calls the compiled core: NumPy for rounded checks, Python integers and `Fraction` for exact ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from .coerce import Matrix, Vector, as_matrix, as_vector
from .errors import NotFiniteError, ShapeError

_EPS = float(np.finfo(float).eps)
# Rounded rays and Farkas vectors come from linear solves: accepted to this relative accuracy.
_SOLVE_TOL = 1e-9


class _Answer(Protocol):
    """What is read of a Solution."""

    @property
    def z(self) -> Vector: ...
    @property
    def w(self) -> Vector: ...
    @property
    def status(self) -> Any: ...
    @property
    def residual(self) -> float: ...
    @property
    def natural_residual(self) -> float: ...
    @property
    def alpha(self) -> Sequence[int]: ...
    @property
    def certificate(self) -> Any: ...
    @property
    def ray(self) -> Any: ...


@dataclass(frozen=True)
class Check:
    """One statement and whether it holds."""

    name: str
    ok: bool
    detail: str = ""


@dataclass(frozen=True)
class Report:
    """The outcome of `verify`: true when every check holds. `exact`: the conclusion was proved in rational numbers."""

    checks: tuple[Check, ...]
    exact: bool

    def __bool__(self) -> bool:
        return all(check.ok for check in self.checks)

    @property
    def failures(self) -> list[Check]:
        """The checks that do not hold."""
        return [check for check in self.checks if not check.ok]

    def __str__(self) -> str:
        lines = [f"{'ok  ' if c.ok else 'FAIL'} {c.name}{': ' + c.detail if c.detail else ''}" for c in self.checks]
        kind = "in rational arithmetic" if self.exact else "in floating point"
        return "\n".join([f"{'verified' if self else 'NOT verified'} {kind}", *lines])


def verify(A: ArrayLike, q: ArrayLike, sol: _Answer, exact: bool = False, tol: float = 1e-9) -> Report:
    """Re-check a Solution of LCP(q, A) and its certificate, independently of the solver.

    Parameters
    ----------
    A : (n, n) array_like of real numbers
    q : (n,) array_like of real numbers
    sol : Solution
    exact : bool
        Demand a proof in rational arithmetic: the certificate's numbers where it is exact; otherwise the complementary
        basis `sol.alpha` is solved here in integers (O(k^3) operations on long integers), or the Farkas vector is
        taken as the binary numbers it is.
    tol : float
        The tolerance that was given to `solve`.

    Returns
    -------
    Report
        True when every check holds. A certificate that says `exact` is always checked exactly.

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError
        For A and q. A wrong `sol` is reported, not raised.

    Notes
    -----
    "solved" means `z >= 0` and, in every row, `|min(z, w)|_i <= 10 tol max|q| + 8 eps m_i` and `|w_i| <= sqrt(tol) m_i`
    where `z_i > 0`, `w_i >= -sqrt(tol) m_i` elsewhere, `m = |A||z| + |q|`, up to rounding.
    "infeasible" means `y >= 0, A'y <= 0, q'y < 0`, up to rounding unless exact; then no z >= 0 has A z + q >= 0.
    A certificate "not_sufficient" is checked in rational numbers: x_i (A x)_i <= 0 for all i, < 0 for some i (or A').
    So is any exact certificate, whatever the status beside it.
    A ray must satisfy `w_hat = A z_hat + d z0_hat >= 0`, `z_hat >= 0`, `z_hat != 0`, `z_hat'w_hat = 0`.

    Examples
    --------
    >>> from lcpstar import solve
    >>> bool(verify([[2, 1], [1, 2]], [-5, -6], solve([[2, 1], [1, 2]], [-5, -6]), exact=True))
    True
    """
    problem = _Problem(as_matrix("A", A), as_vector("q", q))
    checks = [*_shape(problem, sol)]
    proved = False
    if all(check.ok for check in checks):
        checks += _point(problem, sol)
        certificate = sol.certificate
        exact_certificate = certificate is not None and certificate.exact
        if sol.status == "solved":
            checks += _solved(problem, sol, tol)
            if exact_certificate:
                checks += [*_exact_solution(problem, certificate), _rounded(certificate.z, sol.z)]
            elif exact:
                checks += _exact_basis(problem, list(sol.alpha))
            proved = exact or exact_certificate
        elif sol.status == "infeasible":
            proved = exact or exact_certificate
            checks += _farkas(problem, certificate, proved)
        elif sol.status == "secondary_ray":
            checks += [Check("the status comes with its ray", False)] if sol.ray is None else _ray(problem, sol.ray)
        if exact_certificate and not proved:
            checks += _exact_rest(problem, certificate, sol)
            proved = True
    return Report(tuple(checks), proved and all(check.ok for check in checks))


class _Problem:
    def __init__(self, A: Matrix, q: Vector) -> None:
        if len(q) != len(A):
            raise ShapeError(f"q must have length {len(A)}, got {len(q)}")
        for name, array in (("A", A), ("q", q)):
            if not np.isfinite(array).all():
                index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
                raise NotFiniteError(f"{name} must be finite, got {name}{list(index)} = {array[index]}")
        self.A, self.q, self.n = A, q, len(q)

    def size(self, z: Vector) -> Vector:
        """`|A||z| + |q|`: rounding errors are measured by it."""
        return np.asarray(np.abs(self.A) @ np.abs(z) + np.abs(self.q), dtype=np.float64)

    def rounding(self, z: Vector) -> Vector:
        return (self.n + 8) * _EPS * self.size(z) + np.finfo(float).tiny

    def exact_w(self, z: Sequence[Fraction]) -> list[Fraction]:
        """`A z + q`, skipping zeros."""
        support = [j for j in range(self.n) if z[j] != 0]
        return [
            sum(
                (Fraction(float(self.A[i, j])) * z[j] for j in support if self.A[i, j] != 0), Fraction(float(self.q[i]))
            )
            for i in range(self.n)
        ]


def _shape(problem: _Problem, sol: _Answer) -> list[Check]:
    checks = []
    for name in ("z", "w"):
        vector = np.asarray(getattr(sol, name))
        good = vector.shape == (problem.n,) and bool(np.isfinite(vector).all())
        checks.append(Check(f"{name} is a finite vector of length n", good, "" if good else f"shape {vector.shape}"))
    alpha = list(sol.alpha)
    inside = all(0 <= i < problem.n for i in alpha) and len(set(alpha)) == len(alpha)
    checks.append(Check("alpha is an index set", inside, "" if inside else str(alpha)))
    return checks


def _point(problem: _Problem, sol: _Answer) -> list[Check]:
    with np.errstate(over="ignore", invalid="ignore"):
        w = problem.A @ sol.z + problem.q
        bound = problem.rounding(sol.z)
        error = np.abs(w - sol.w)
        natural = float(np.max(np.abs(np.minimum(sol.z, w)), initial=0.0))
        slack = float(np.max(bound, initial=0.0))
        same_w = bool(np.all((error <= bound) | ~np.isfinite(bound)))
        same_residual = not np.isfinite(slack) or abs(natural - sol.natural_residual) <= slack
    return [
        Check("w = A z + q", same_w, f"largest difference {np.max(error, initial=0.0):.3g}"),
        Check("natural_residual = max|min(z, w)|", same_residual, f"{natural:.3g}, stated {sol.natural_residual:.3g}"),
    ]


def _solved(problem: _Problem, sol: _Answer, tol: float) -> list[Check]:
    z, w = np.asarray(sol.z), np.asarray(sol.w)
    limit = 10 * tol * float(np.max(np.abs(problem.q), initial=0.0)) + 8 * _EPS * problem.size(z)
    excess = np.abs(np.minimum(z, w)) - limit
    worst = int(np.argmax(excess)) if problem.n else 0
    rows = bool(np.all(excess <= 0))
    detail = "" if rows else f"row {worst}: z = {z[worst]:.3g}, w = {w[worst]:.3g}"
    certificate = sol.certificate
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.where(z > 0, np.abs(w), np.maximum(-w, 0.0))
        own = bool(np.all(off <= tol**0.5 * problem.size(z) + problem.rounding(z)))
    return [
        Check("z >= 0", bool(np.all(z >= 0))),
        Check("|min(z, w)| is small in every row", rows, detail),
        Check("every row holds to its own numbers", own),
        Check("residual <= tol", bool(sol.residual <= tol), f"stated {sol.residual:.3g}"),
        Check("the certificate is of a solution", certificate is None or certificate.kind == "solution"),
    ]


def _exact_rest(problem: _Problem, certificate: Any, sol: _Answer) -> list[Check]:
    """What an exact certificate proves of a problem that is neither called solved nor infeasible."""
    match certificate.kind:
        case "solution":
            return _exact_solution(problem, certificate)
        case "infeasible":
            return _farkas(problem, certificate, exact=True)
        case "ray":
            return _exact_ray(problem, certificate, sol.ray)
        case "not_sufficient":
            return _not_sufficient(problem, certificate)
    return [Check("the certificate is of a known kind", False, str(certificate.kind))]


def _are_exact(numbers: Sequence[Any] | None, n: int) -> bool:
    return numbers is not None and len(numbers) == n and all(isinstance(x, (int, Fraction)) for x in numbers)


def _rounded(z: Sequence[Fraction] | None, rounded: Vector) -> Check:
    name = "z is the exact solution rounded"
    if z is None or not _are_exact(z, len(rounded)):
        return Check(name, False)
    scale = max((abs(float(x)) for x in z), default=0.0)
    near = all(abs(float(x) - y) <= _SOLVE_TOL * scale for x, y in zip(z, rounded.tolist(), strict=True))
    return Check(name, near)


def _exact_solution(problem: _Problem, certificate: Any) -> list[Check]:
    z, alpha = certificate.z, certificate.alpha
    if not _are_exact(z, problem.n):
        return [Check("the certificate holds n exact numbers", False)]
    w = problem.exact_w([Fraction(x) for x in z])
    basis = set(alpha or ())
    return [
        Check("exact z >= 0", all(x >= 0 for x in z)),
        Check("exact w = A z + q >= 0", all(x >= 0 for x in w)),
        Check("exact z'w = 0", all(x == 0 or y == 0 for x, y in zip(z, w, strict=True))),
        Check("w = 0 on alpha, z = 0 outside", all((w if i in basis else z)[i] == 0 for i in range(problem.n))),
    ]


def _exact_basis(problem: _Problem, alpha: list[int]) -> list[Check]:
    block = [[Fraction(float(problem.A[i, j])) for j in alpha] + [-Fraction(float(problem.q[i]))] for i in alpha]
    part = _solve(block)
    if part is None:
        return [Check("A[alpha, alpha] is not singular", False, f"alpha = {alpha}")]
    z = [Fraction(0)] * problem.n
    for i, x in zip(alpha, part, strict=True):
        z[i] = x
    w = problem.exact_w(z)
    low_z = [i for i in range(problem.n) if z[i] < 0]
    low_w = [i for i in range(problem.n) if w[i] < 0]
    return [
        Check("exact z >= 0 at the basis alpha", not low_z, f"z < 0 at {low_z}" if low_z else ""),
        Check("exact w >= 0 at the basis alpha", not low_w, f"w < 0 at {low_w}" if low_w else ""),
    ]


def _solve(rows: list[list[Fraction]]) -> list[Fraction] | None:
    """Solution of the system `[K | b]`; `None` when K is singular. Bareiss elimination on integers [Bar68]."""
    k = len(rows)
    table: list[list[int]] = []
    for row in rows:
        # Denominators are powers of two: the largest is common to all.
        common = max(x.denominator for x in row)
        table.append([x.numerator * (common // x.denominator) for x in row])
    previous = 1
    for c in range(k):
        pivot = next((r for r in range(c, k) if table[r][c] != 0), None)
        if pivot is None:
            return None
        table[c], table[pivot] = table[pivot], table[c]
        top = table[c]
        for r in range(c + 1, k):
            low, factor = table[r], table[r][c]
            table[r] = [0] * (c + 1) + [(top[c] * low[j] - factor * top[j]) // previous for j in range(c + 1, k + 1)]
        previous = top[c]
    x = [Fraction(0)] * k
    for c in reversed(range(k)):
        known = sum((table[c][j] * x[j] for j in range(c + 1, k)), Fraction(0))
        x[c] = (table[c][k] - known) / table[c][c]
    return x


def _farkas(problem: _Problem, certificate: Any, exact: bool) -> list[Check]:
    name = "the certificate holds a Farkas vector"
    if certificate is None or certificate.kind != "infeasible" or certificate.y is None:
        return [Check(name, False)]
    y = list(certificate.y)
    if len(y) != problem.n:
        return [Check(name, False, f"length {len(y)}")]
    if exact:
        numbers = [Fraction(x) for x in y]
        support = [i for i in range(problem.n) if numbers[i] != 0]
        columns = [
            sum((Fraction(float(problem.A[i, j])) * numbers[i] for i in support), Fraction(0)) for j in range(problem.n)
        ]
        value = sum((Fraction(float(problem.q[i])) * numbers[i] for i in support), Fraction(0))
        return [
            Check("exact y >= 0", all(x >= 0 for x in numbers)),
            Check("exact A'y <= 0", all(x <= 0 for x in columns)),
            Check("exact q'y < 0", value < 0),
        ]
    v = np.asarray(y, dtype=np.float64)
    if not _ordinary(problem.A, problem.q, v):
        return _farkas_in_fractions(problem, v)
    value_size = float(np.abs(problem.q) @ np.abs(v))
    value_float = float(problem.q @ v)
    return [
        Check("y >= 0", bool(np.all(v >= 0))),
        Check("A'y <= 0 up to rounding", bool(np.all(v @ problem.A <= _SOLVE_TOL * (np.abs(v) @ np.abs(problem.A))))),
        Check("q'y < 0", value_float < -(problem.n + 8) * _EPS * value_size, f"{value_float:.3g}"),
    ]


def _ordinary(*arrays: Vector | Matrix) -> bool:
    """Whether no product of two of these numbers leaves the range of doubles."""
    sizes = np.concatenate([np.abs(array[array != 0.0]).ravel() for array in arrays])
    return bool(np.all((sizes > 1e-150) & (sizes < 1e150)))


def _farkas_in_fractions(problem: _Problem, v: Vector) -> list[Check]:
    """As for a rounded vector, but where products of doubles would overflow or underflow."""
    finite = bool(np.isfinite(v).all())
    y = [Fraction(float(x)) for x in v] if finite else []

    def sums(column: Vector) -> tuple[Fraction, Fraction]:
        terms = [Fraction(float(a)) * x for a, x in zip(column, y, strict=finite)]
        return sum(terms, Fraction(0)), sum(map(abs, terms), Fraction(0))

    columns = [sums(column) for column in problem.A.T]
    return [
        Check("y >= 0", finite and min(y, default=Fraction(0)) >= 0),
        Check("A'y <= 0 up to rounding", all(value <= Fraction(_SOLVE_TOL) * size for value, size in columns)),
        Check("q'y < 0", sums(problem.q)[0] < 0),
    ]


def _not_sufficient(problem: _Problem, certificate: Any) -> list[Check]:
    """Exact, on the binary numbers of A: column sufficiency with x = z, row sufficiency with x = y."""
    transposed = certificate.z is None
    x = [Fraction(t) for t in (certificate.y if transposed else certificate.z) or []]
    if len(x) != problem.n:
        return [Check("the refuting vector has n entries", False, f"length {len(x)}")]
    matrix = problem.A.T if transposed else problem.A
    support = [j for j in range(problem.n) if x[j] != 0]
    products = [x[i] * sum((Fraction(float(matrix[i, j])) * x[j] for j in support), Fraction(0)) for i in support]
    name = "(A' x)" if transposed else "(A x)"
    return [
        Check(f"exact x_i {name}_i <= 0 for all i", all(product <= 0 for product in products)),
        Check(f"exact x_i {name}_i < 0 for some i", any(product < 0 for product in products)),
    ]


def _is_covering(d: Vector, n: int) -> bool:
    d = np.asarray(d)
    return d.shape == (n,) and bool(np.isfinite(d).all() and np.all(d > 0))


def _exact_ray(problem: _Problem, certificate: Any, ray: Any) -> list[Check]:
    """With the covering vector of `ray`; the first row with z_i > 0 says what z_0 is."""
    z = certificate.z
    if ray is None or not _are_exact(z, problem.n) or not _is_covering(ray.d, problem.n):
        return [Check("the certificate holds n exact numbers, beside a ray with d > 0", False)]
    z, d = [Fraction(x) for x in z], [Fraction(float(x)) for x in ray.d]
    origin = [Fraction(float(x)) for x in problem.q]
    image = [w - q for w, q in zip(problem.exact_w(z), origin, strict=True)]
    support = [i for i in range(problem.n) if z[i] != 0]
    z0 = -image[support[0]] / d[support[0]] if support else Fraction(-1)
    w = [a + b * z0 for a, b in zip(image, d, strict=True)]
    return [
        Check("exact z_hat >= 0, not zero, z0_hat >= 0", min(z, default=z0) >= 0 and z0 >= 0),
        Check("exact w_hat = A z_hat + d z0_hat >= 0", min(w, default=z0) >= 0),
        Check("exact z_hat'w_hat = 0", not any(w[i] for i in support)),
    ]


def _ray(problem: _Problem, ray: Any) -> list[Check]:
    z_hat, d, z0_hat = np.asarray(ray.z_hat), np.asarray(ray.d), float(ray.z0_hat)
    if z_hat.shape != (problem.n,) or d.shape != (problem.n,):
        return [Check("the ray has n entries", False)]
    w_hat = problem.A @ z_hat + d * z0_hat
    size = np.abs(problem.A) @ np.abs(z_hat) + np.abs(d * z0_hat)
    w = problem.A @ ray.z + problem.q + d * ray.z0
    base = problem.size(np.asarray(ray.z)) + np.abs(d * ray.z0)
    crossed = np.minimum(z_hat, w_hat) <= _SOLVE_TOL * np.minimum(np.max(z_hat, initial=0.0), size + z_hat)
    return [
        Check("z_hat >= 0, not zero, z0_hat >= 0", bool(np.all(z_hat >= 0) and np.any(z_hat > 0) and z0_hat >= 0)),
        Check("w_hat = A z_hat + d z0_hat", bool(np.all(np.abs(w_hat - ray.w_hat) <= _SOLVE_TOL * size))),
        Check("w_hat >= 0", bool(np.all(w_hat >= -_SOLVE_TOL * size))),
        Check("z_hat'w_hat = 0", bool(np.all(crossed | (w_hat <= _SOLVE_TOL * size)))),
        Check("A z + q + d z0 >= 0 where the ray starts", bool(np.all(w >= -_SOLVE_TOL * base))),
        Check("z >= 0, z0 >= 0 where the ray starts", bool(np.all(ray.z >= 0) and ray.z0 >= 0)),
    ]
