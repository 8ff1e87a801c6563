"""Answers to LCP(q, A) that state the truth about their z, for `verify` to accept until somebody breaks them."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np

from lcpstar import verify
from lcpstar.result import Certificate, Ray

FIELDS = ("z", "w", "status", "success", "residual", "natural_residual", "alpha", "certificate", "ray")


def dense(A):
    return A.toarray() if hasattr(A, "toarray") else np.asarray(A, dtype=object)


def exact_w(A, q, z):
    return [
        sum((Fraction(a) * Fraction(float(x)) for a, x in zip(row, z, strict=True)), Fraction(b))
        for row, b in zip(dense(A).tolist(), list(q), strict=True)
    ]


def exponents(A, q):
    """Ruiz's iteration on exponents, entry by entry: (rows, columns, of q)."""

    def exponent(x):
        return math.frexp(float(x))[1]

    A = dense(A).tolist()
    n = len(A)
    r, c = [0] * n, [0] * n
    for _ in range(12):
        row = [max((exponent(A[i][j]) + r[i] + c[j] for j in range(n) if A[i][j]), default=0) for i in range(n)]
        column = [max((exponent(A[i][j]) + r[i] + c[j] for i in range(n) if A[i][j]), default=0) for j in range(n)]
        r = [e - (int(m / 2) if abs(m) > 1 else 0) for e, m in zip(r, row, strict=True)]
        c = [e - (int(m / 2) if abs(m) > 1 else 0) for e, m in zip(c, column, strict=True)]
    return r, c, -max((exponent(x) + e for x, e in zip(q, r, strict=True) if x), default=0)


def residual(A, q, z):
    """`max|min(z', w')| / max(1, max|z'|)` on the equilibrated problem."""
    r, c, s = exponents(A, q)
    two = Fraction(2)
    z_scaled = [Fraction(float(x)) * two ** (s - e) for x, e in zip(z, c, strict=True)]
    w_scaled = [x * two ** (s + e) for x, e in zip(exact_w(A, q, z), r, strict=True)]
    worst = max((abs(min(a, b)) for a, b in zip(z_scaled, w_scaled, strict=True)), default=Fraction(0))
    return float(worst / max([Fraction(1), *map(abs, z_scaled)]))


def answer(A, q, z, status="solved", **fields):
    """With the true `w`, `residual`, `natural_residual`, `alpha`, unless `fields` say otherwise."""
    z = np.array([float(x) for x in z])
    w = exact_w(A, q, z)
    honest = {
        "z": z,
        "w": np.array([float(x) for x in w]),
        "status": status,
        "success": status == "solved",
        "residual": residual(A, q, z),
        "natural_residual": max(
            (float(abs(min(Fraction(a), b))) for a, b in zip(z.tolist(), w, strict=True)), default=0.0
        ),
        "alpha": np.flatnonzero(z > 0).tolist(),
        "certificate": None,
        "ray": None,
    }
    return SimpleNamespace(**{**honest, **fields})


def copy(sol, **changes):
    """The fields of an answer, some of them changed."""
    return SimpleNamespace(**{**{field: getattr(sol, field) for field in FIELDS}, **changes})


A2, Q2 = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-5.0, -6.0])
PROVED = Certificate("solution", exact=True, alpha=[0, 1], z=[Fraction(4, 3), Fraction(7, 3)])
#: 0 = (z_1 - z_2 - 1) + (z_2 - z_1 - 1) + 2: no point is feasible, and the ray (1, 1) leads nowhere.
SADDLE, BELOW = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([-1.0, -1.0])
RAY = Ray(z=np.zeros(2), z0=1.0, z_hat=np.ones(2), z0_hat=0.0, w_hat=np.zeros(2), d=np.ones(2))
#: 1e-12 above a Farkas vector in the first column: w_1 + w_2 = 1e-12 z_1 - 2 >= 0 needs z_1 >= 2e12.
NEARLY = np.array([[1.0, -1.0], [-1.0 + 2.0**-40, 1.0]])


def failed(A, q, sol, **options):
    report = verify(A, q, sol, **options)
    assert not report.exact or report
    return {check.name for check in report.failures}


def solved(**fields):
    return answer(A2, Q2, [4 / 3, 7 / 3], certificate=Certificate("solution", alpha=[0, 1]), **fields)


def infeasible(y=(1.0, 1.0), exact=False, **fields):
    certificate = Certificate("infeasible", exact=exact, y=list(y) if exact else np.array(y))
    return answer(SADDLE, BELOW, [0, 0], "infeasible", certificate=certificate, **fields)


def nearly(y=(1.0, 1.0), bound=2.0**41, A=NEARLY):
    certificate = Certificate("nearly_infeasible", y=np.array(y), bound=bound)
    return answer(A, BELOW, [0, 0], "nearly_infeasible", certificate=certificate)


def on_ray(certificate=None, **parts):
    return answer(SADDLE, BELOW, [0, 0], "secondary_ray", ray=replace(RAY, **parts), certificate=certificate)
