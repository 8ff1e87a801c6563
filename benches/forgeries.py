"""Forged answers: a genuine one of which something was changed. Most are false; the referee says which are not."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np

from lcpstar.result import Certificate

FIELDS = ("z", "w", "status", "success", "residual", "natural_residual", "alpha", "certificate", "ray")
NOT_FINITE = (math.nan, math.inf, -math.inf)


def _changed(rng, v):
    """One entry of a vector: by a part of it, of its sign, or by a number of another size."""
    v = np.array(v, dtype=float)
    i = int(rng.integers(len(v)))
    match rng.integers(4):
        case 0:
            v[i] *= 1 + 10.0 ** rng.uniform(-6, 0)
        case 1:
            v[i] = -v[i] if v[i] else -1.0
        case 2:
            v[i] += 10.0 ** rng.uniform(-6, 12)
        case _:
            v[i] = rng.choice(NOT_FINITE)
    return v


def _point(rng, case, sol):
    return {"z": _changed(rng, sol.z)}


def _consistent_point(rng, case, sol):
    """Another z with its own w and residuals: only the status is a lie."""
    z = np.abs(_changed(rng, sol.z))
    if not np.isfinite(z).all():
        return None
    w = case.A @ z + case.q
    r, c, s = case.scaling
    with np.errstate(all="ignore"):
        scaled_z, scaled_w = np.ldexp(z, s - np.array(c)), np.ldexp(w, s + np.array(r))
        worst = np.abs(np.minimum(scaled_z, scaled_w)).max()
        residual = float(worst / max(1.0, scaled_z.max()))
    natural = float(np.abs(np.minimum(z, w)).max())
    return {
        "z": z,
        "w": w,
        "residual": residual,
        "natural_residual": natural,
        "status": "solved",
        "success": True,
        "alpha": np.flatnonzero(z > 0).tolist(),
        "certificate": None,
        "ray": None,
    }


def _slack(rng, case, sol):
    return {"w": _changed(rng, sol.w)}


def _residual(rng, case, sol):
    name = str(rng.choice(["residual", "natural_residual"]))
    true = getattr(sol, name)
    return {name: [true * 2 + 1e-3, 0.0, true / 4, -true, *NOT_FINITE][rng.integers(7)]}


def _status(rng, case, sol):
    others = ["solved", "infeasible", "nearly_infeasible", "secondary_ray", "optimal", "Solved", "", None, 0]
    status = others[rng.integers(len(others))]
    if status == sol.status:
        return None
    return {"status": status, "success": status == "solved"}


def _success(rng, case, sol):
    return {"success": not sol.success}


def _alpha(rng, case, sol):
    alpha, i = set(map(int, sol.alpha)), int(rng.integers(case.n))
    wild = [list(alpha ^ {i}), [*alpha, case.n], [*alpha, -1], [i, i], [0.5], None, "alpha"]
    return {"alpha": wild[rng.integers(len(wild))] if rng.random() < 0.3 else sorted(alpha ^ {i})}


def _invented(rng, case, sol):
    """A multiplier or a proof from nowhere."""
    n = case.n
    y = [
        np.ones(n),
        np.eye(n)[rng.integers(n)],
        rng.integers(0, 3, n).astype(float),
        np.abs(rng.standard_normal(n)),
        sol.z,
    ][rng.integers(5)]
    match rng.integers(4):
        case 0:
            proof = Certificate("infeasible", y=y)
            status = "infeasible"
        case 1:
            proof = Certificate("infeasible", exact=True, y=[Fraction(float(x)) for x in y])
            status = "infeasible"
        case 2:
            proof = Certificate("nearly_infeasible", y=y, bound=10.0 ** rng.uniform(0, 300))
            status = "nearly_infeasible"
        case _:
            z = [Fraction(float(x)) for x in sol.z]
            alpha = np.flatnonzero(sol.z > 0).tolist()
            return {
                "status": "solved",
                "success": True,
                "alpha": alpha,
                "certificate": Certificate("solution", exact=True, alpha=alpha, z=z),
            }
    return {"status": status, "success": False, "certificate": proof}


def _certificate(rng, case, sol):
    """One field of the certificate, its numbers above all."""
    proof, i = sol.certificate, int(rng.integers(case.n))
    if proof is None:
        return {
            "certificate": Certificate("not_sufficient", exact=True, z=[Fraction(int(k == i)) for k in range(case.n)])
        }
    choices = [{"kind": k} for k in ("solution", "infeasible", "nearly_infeasible", "ray", "proved") if k != proof.kind]
    choices.append({"exact": not proof.exact})
    for name in ("y", "z"):
        numbers = getattr(proof, name)
        if numbers is not None:
            step = [Fraction(1), Fraction(-1), Fraction(1, 2**60), Fraction(-(10**30)), -2 * Fraction(numbers[i])]
            for s in step:
                choices.append({name: [Fraction(x) + s * (k == i) for k, x in enumerate(numbers)]})
            for x in (None, math.nan, "1", complex(1)):
                choices.append({name: [x if k == i else y for k, y in enumerate(numbers)]})
            choices += [{name: None}, {name: list(numbers)[1:]}]
    if proof.alpha is not None:
        choices.append({"alpha": sorted({*proof.alpha} ^ {i})})
    if proof.bound is not None:
        choices += [
            {"bound": proof.bound * 2},
            {"bound": math.inf},
            {"bound": math.nan},
            {"bound": -1.0},
            {"bound": None},
        ]
    return {"certificate": replace(proof, **choices[rng.integers(len(choices))])}


def _ray(rng, case, sol):
    ray = sol.ray
    if ray is None:
        return {"status": "secondary_ray", "success": False, "certificate": None}
    return {
        "ray": replace(
            ray,
            **[
                {"d": -ray.d},
                {"d": 0 * ray.d},
                {"z_hat": 0 * ray.z_hat},
                {"z_hat": -ray.z_hat - 1.0},
                {"z_hat": ray.z_hat[1:]},
                {"w_hat": np.full(case.n, math.nan)},
                {"z0": math.nan},
                {"z0_hat": None},
                {"z": None},
            ][rng.integers(9)],
        )
    }


FORGERS = {
    "z": _point,
    "z with its w and residuals": _consistent_point,
    "w": _slack,
    "a residual": _residual,
    "status": _status,
    "success": _success,
    "alpha": _alpha,
    "an invented proof": _invented,
    "a field of the certificate": _certificate,
    "the ray": _ray,
}


def forged(rng, case, sol):
    """Some forgeries of one answer: pairs of what was changed and the result."""
    if not case.n:
        return
    for name in rng.choice(list(FORGERS), 3, replace=False):
        with np.errstate(all="ignore"):
            changes = FORGERS[name](rng, case, sol)
        if changes is not None:
            genuine = {field: getattr(sol, field) for field in FIELDS}
            yield str(name), SimpleNamespace(**{**genuine, **changes})
