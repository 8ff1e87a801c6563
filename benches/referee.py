"""An exact referee for answers to LCP(q, A): right, nearly right, an honest "no", or wrong.

It shares nothing with lcpstar. Every double x is the integer `x 2^1074`, so sums of products are exact in units of
`2^-2148`.
"""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from functools import cached_property

import numpy as np

UNIT = 1074
ENUMERATED = 4
_SPREAD = 4 * UNIT + 400  # shifts by exponents of two stay integers
_STATUSES = {
    "solved",
    "infeasible",
    "nearly_infeasible",
    "secondary_ray",
    "max_iterations",
    "time_limit",
    "numerical_breakdown",
}


def integer(x):
    """`x 2^1074` of a finite double."""
    numerator, denominator = float(x).as_integer_ratio()
    return (numerator << UNIT) // denominator


def integers(v):
    return [integer(x) for x in np.asarray(v, dtype=float).ravel()]


class WrongError(Exception):
    """What is wrong with an answer."""


def require(it_holds, what):
    if not it_holds:
        raise WrongError(what)


class Problem:
    """LCP(q, A) with what is known about it; `A` a dense array of doubles, of which the zeros cost nothing."""

    def __init__(self, A, q, core=None):
        """`core`: a part of it that has a solution if and only if it has."""
        self.core = core
        self.A, self.q = np.array(A, dtype=float), np.array(q, dtype=float)
        self.n = len(self.q)
        self.rows = [[(int(j), integer(row[j])) for j in np.flatnonzero(row)] for row in self.A]
        self.b = integers(self.q)

    def __repr__(self):
        return f"A = {self.A.tolist()}, q = {self.q.tolist()}"

    def slack(self, z):
        """`w = A z + q` and `|A||z| + |q|`, in units of 2^-2148; z in units of 2^-1074."""
        w = [sum(a * z[j] for j, a in row) + (b << UNIT) for row, b in zip(self.rows, self.b, strict=True)]
        m = [sum(abs(a * z[j]) for j, a in row) + abs(b << UNIT) for row, b in zip(self.rows, self.b, strict=True)]
        return w, m

    @cached_property
    def scaling(self):
        """Exponents of two `(rows, columns, of q)` of the equilibration that defines `residual`: Ruiz's iteration."""
        entries = [(i, j, math.frexp(self.A[i, j])[1]) for i, row in enumerate(self.rows) for j, _ in row]
        r, c = [0] * self.n, [0] * self.n
        for _ in range(12):
            row, column = [None] * self.n, [None] * self.n
            for i, j, e in entries:
                size = e + r[i] + c[j]
                row[i] = size if row[i] is None else max(row[i], size)
                column[j] = size if column[j] is None else max(column[j], size)
            steps = [[int(x / 2) if x is not None and abs(x) > 1 else 0 for x in sizes] for sizes in (row, column)]
            if not any(steps[0]) and not any(steps[1]):
                break
            r, c = ([e - s for e, s in zip(old, step, strict=True)] for old, step in zip((r, c), steps, strict=True))
        s = -max((math.frexp(x)[1] + e for x, e in zip(self.q, r, strict=True) if x), default=0)
        return r, c, s

    @cached_property
    def solutions(self):
        """Solutions among them every isolated one; for n <= ENUMERATED. There is one if LCP(q, A) has any.

        A vertex has a support S and rows T that contain S, as many as the rank falls short, with w_T = 0.
        """
        found = []
        for size in range(self.n + 1):
            for support in itertools.combinations(range(self.n), size):
                z = self._unique(support, support)
                candidates = [z]
                if z is False:
                    rest = [i for i in range(self.n) if i not in support]
                    sets = (itertools.combinations(rest, k) for k in range(1, len(rest) + 1))
                    candidates = [self._unique([*support, *extra], support) for extra in itertools.chain(*sets)]
                found += [z for z in candidates if z is not None and z is not False and self.is_solution(z)]
        return found

    @cached_property
    def is_solvable(self):
        """None where it is not decided."""
        decides = self.core or self
        return bool(decides.solutions) if decides.n <= ENUMERATED else None

    def _unique(self, rows, columns):
        """The only z with support in `columns` and `w = 0` in `rows`; None: there is none; False: there are more."""
        table = [[Fraction(self.A[i, j]) for j in columns] + [Fraction(-self.q[i])] for i in rows]
        for c in range(len(columns)):
            pivot = next((r for r in range(c, len(table)) if table[r][c]), None)
            if pivot is None:
                return False
            table[c], table[pivot] = table[pivot], table[c]
            for r in range(len(table)):
                if r != c and table[r][c]:
                    factor = table[r][c] / table[c][c]
                    table[r] = [x - factor * y for x, y in zip(table[r], table[c], strict=True)]
        if any(row[-1] for row in table[len(columns) :]):
            return None
        z = [Fraction(0)] * self.n
        for c, j in enumerate(columns):
            z[j] = table[c][-1] / table[c][c]
        return z

    def is_solution(self, z):
        """Of rational numbers: `z >= 0`, `w >= 0`, `z'w = 0`."""
        w = self.exact_slack(z)
        return all(x >= 0 and v >= 0 and not (x and v) for x, v in zip(z, w, strict=True))

    def exact_slack(self, z):
        return [
            sum((Fraction(self.A[i, j]) * z[j] for j, _ in row), Fraction(q))
            for i, (row, q) in enumerate(zip(self.rows, self.q, strict=True))
        ]

    def transposed_product(self, y):
        """`A'y` of rational y."""
        sums = [Fraction(0)] * self.n
        for i, row in enumerate(self.rows):
            for j, _ in row:
                sums[j] += Fraction(self.A[i, j]) * y[i]
        return sums


def score(problem, sol, tol, loose=False):
    """ "right", "nearly", "no"; raises WrongError. `loose`: sums may be rounded in any order."""
    n = problem.n
    require(str(sol.status) in _STATUSES, f"status {sol.status}")
    require(len(sol.z) == n and len(sol.w) == n, "the length of z or w")
    require(bool(np.isfinite(sol.z).all() and np.isfinite(sol.w).all()), "z or w is not finite")
    require(math.isfinite(sol.residual) and math.isfinite(sol.natural_residual), "a residual is not finite")
    require(getattr(sol, "success", sol.status == "solved") == (sol.status == "solved"), "success")
    z = integers(sol.z)
    w, m = problem.slack(z)
    scaled = _numbers(problem, sol, z, w, m, loose)
    _alpha(problem, sol, w, m, scaled)
    _certificate(problem, sol)
    if sol.status == "solved":
        return _solved(problem, sol, tol, z, w, m, scaled)
    return "right" if sol.status in ("infeasible", "nearly_infeasible") else "no"


def _numbers(problem, sol, z, w, m, loose):
    """`w`, `natural_residual` and `residual` are those of z. The scaled z and w, in units of `2^-(2148 + _SPREAD)`."""
    n = problem.n
    terms = 2 * (n + 8) if loose else n + 2
    tiny = 1 << (2 * UNIT - 1018)
    room = [(terms * size >> 53) + (abs(v) >> 52) + tiny for v, size in zip(w, m, strict=True)]
    for i, stated in enumerate(integers(sol.w)):
        require(abs((stated << UNIT) - w[i]) <= room[i], f"w[{i}] = {sol.w[i]}")
    r, c, s = problem.scaling
    scaled_z = [x << (UNIT + s - e + _SPREAD) for x, e in zip(z, c, strict=True)]
    scaled_w = [x << (s + e + _SPREAD) for x, e in zip(w, r, strict=True)]
    scaled_room = [x << (s + e + _SPREAD) for x, e in zip(room, r, strict=True)]
    one = 1 << (2 * UNIT + _SPREAD)
    top = max([one, *map(abs, scaled_z)])
    natural = max((abs(min(x << UNIT, v)) for x, v in zip(z, w, strict=True)), default=0)
    violation = max((abs(min(x, v)) for x, v in zip(scaled_z, scaled_w, strict=True)), default=0)
    off = abs((integer(sol.natural_residual) << UNIT) - natural)
    require(off <= (natural >> 30) + max(room, default=0), f"natural_residual = {sol.natural_residual}")
    off = abs(integer(sol.residual) * top - (violation << UNIT))
    allowed = (violation >> 30) + max(scaled_room, default=0)
    require(off <= (allowed << UNIT) + (top << 60), f"residual = {sol.residual}")
    return scaled_z, scaled_w, top, violation


def _alpha(problem, sol, w, m, scaled):
    """The index set covers the support, and w is about 0 on it."""
    alpha = {int(i) for i in sol.alpha}
    require(alpha <= set(range(problem.n)) and len(alpha) == len(sol.alpha), f"alpha = {sol.alpha}")
    require(all(i in alpha for i in np.flatnonzero(sol.z > 0)), "z_i > 0 outside alpha")
    _, scaled_w, top, _ = scaled
    for i in alpha:
        require(sol.z[i] > 0 or sol.status != "solved" or abs(scaled_w[i]) <= top >> 6, f"w[{i}] is not 0, on alpha")


def _solved(problem, sol, tol, z, w, m, scaled):
    require(min(z, default=0) >= 0, "z < 0")
    proof = sol.certificate
    if proof is not None and proof.exact:
        for x, exact in zip(sol.z, proof.z, strict=True):
            require(abs(Fraction(x) - exact) <= np.spacing(abs(x)), "z is not the proved one, rounded")
        return "right"
    allowed = 10 * integer(tol) * max(map(abs, problem.b), default=0)
    for x, v, size in zip(z, w, m, strict=True):
        require(abs(min(x << UNIT, v)) <= allowed + (size >> 49) + (size >> 80), "a row in the caller's units")
    scaled_z, scaled_w, top, violation = scaled
    exact_tol = Fraction(tol) * (1 + Fraction(1, 2**40))
    require(violation <= exact_tol * top, "residual > tol")
    require(violation <= max(exact_tol, Fraction(1e-6)) * (1 << (2 * UNIT + _SPREAD)), "max|min(z', w')|")
    if problem.n <= ENUMERATED:
        support = [i for i in range(problem.n) if z[i] and scaled_w[i] < scaled_z[i]]
        vertex = problem._unique(support, support)
        if vertex is not None and vertex is not False and problem.is_solution(vertex):
            return "right"
    if problem.is_solvable is not False:
        return "right"
    cleaned = [x if v < y else 0 for x, y, v in zip(z, scaled_z, scaled_w, strict=True)]
    distance = min(_distance(z, w, m), _distance(cleaned, *problem.slack(cleaned)))
    require(distance <= 1.000001 * tol**0.5, f"no solution exists, and none {float(distance):.1e} around")
    return "nearly"


def _distance(z, w, m):
    """The least omega such that z solves a problem whose entries differ by the part omega at most."""
    off = [abs(v) if x > 0 else max(-v, 0) for x, v in zip(z, w, strict=True)]
    return max((Fraction(x, size) for x, size in zip(off, m, strict=True) if x), default=Fraction(0))


def _certificate(problem, sol):
    proof = sol.certificate
    kind = None if proof is None else proof.kind
    must = {"infeasible": "infeasible", "nearly_infeasible": "nearly_infeasible"}.get(str(sol.status))
    require(must in (None, kind), f"{sol.status} with a certificate {kind}")
    if kind in ("infeasible", "nearly_infeasible"):
        require(kind == sol.status, f"a certificate {kind} beside {sol.status}")
        require(all(math.isfinite(x) for x in proof.y) and len(proof.y) == problem.n, "y is not finite")
        y = [Fraction(x) for x in proof.y]
        value = sum((Fraction(q) * x for q, x in zip(problem.q, y, strict=True)), Fraction(0))
        largest = max(problem.transposed_product(y), default=Fraction(0))
        require(min(y, default=0) >= 0 and value < 0, "y >= 0, q'y < 0")
        if kind == "infeasible":
            require(largest <= 0, f"A'y = {float(largest):.1e}")
        else:
            require(math.isfinite(proof.bound) and proof.bound > 0, f"bound = {proof.bound}")
            require(Fraction(proof.bound) * largest <= -value, f"bound = {proof.bound:.3e} is too large")
    elif kind == "solution" and proof.exact:
        require(problem.is_solution(list(map(Fraction, proof.z))), "the exact solution is none")
        w = problem.exact_slack(proof.z)
        basis = {int(i) for i in proof.alpha}
        require(not any(w[i] for i in sol.alpha) or sol.status != "solved", "exact w = 0 on alpha")
        require(not any(w[i] if i in basis else proof.z[i] for i in range(problem.n)), "the basis of the proof")
    elif kind == "solution":
        require(sorted(proof.alpha) == sorted(sol.alpha), "two index sets")
    elif kind == "not_sufficient":
        x, transposed = (proof.y, True) if proof.z is None else (proof.z, False)
        image = (
            problem.transposed_product(x)
            if transposed
            else [v - Fraction(q) for v, q in zip(problem.exact_slack(x), problem.q, strict=True)]
        )
        signs = [a * b for a, b in zip(x, image, strict=True)]
        require(max(signs) <= 0 and min(signs) < 0, "the vector against sufficiency")
    elif kind not in (None, "ray"):
        raise WrongError(f"certificate {kind!r}")
