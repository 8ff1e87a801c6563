"""The yardstick and the clock of the benchmarks: what a point achieves, recomputed here, and what it took."""

from __future__ import annotations

import platform
import sys
import time
from collections.abc import Callable

import numpy as np

from .._core import __version__
from ..coerce import Matrix, Vector

#: Processor time of this thread where its clock is fine enough, so that a busy machine disturbs less; else wall time.
_CLOCK_IS_FINE = time.get_clock_info("thread_time").resolution <= 1e-6
CLOCK = "thread_time" if _CLOCK_IS_FINE else "perf_counter"
clock: Callable[[], float] = time.thread_time if _CLOCK_IS_FINE else time.perf_counter

_ZERO = -1_000_000  # the exponent of zero, smaller than any other
_SWEEPS = 12


class Yardstick:
    """Residuals of points z of LCP(q, A), computed without the compiled core and in twice the working precision.

    `residual(z)` is `max|min(z', w')| / max(1, max|z'|)` on the problem equilibrated by powers of two, as
    docs/accuracy.md defines it; `natural(z)` is `max|min(z, w)|` in the caller's units. O(n^2) each.
    """

    def __init__(self, A: Matrix, q: Vector) -> None:
        self.rows, self.columns, self.s = _exponents(A, q)
        self.A = np.ldexp(A, self.rows[:, None] + self.columns)
        self.q = np.ldexp(q, self.rows + self.s)

    def residual(self, z: Vector) -> float:
        """The equilibrated residual; infinite when z is not finite."""
        u, v = self._pair(z)
        if not np.isfinite(v).all():
            return float("inf")
        return float(np.abs(np.minimum(u, v)).max(initial=0.0) / max(1.0, np.abs(u).max(initial=0.0)))

    def natural(self, z: Vector) -> float:
        """The residual in the caller's units."""
        _, v = self._pair(z)
        return float(np.abs(np.minimum(z, np.ldexp(v, -self.rows - self.s))).max(initial=0.0))

    def _pair(self, z: Vector) -> tuple[Vector, Vector]:
        u = np.ldexp(z, self.s - self.columns)
        with np.errstate(over="ignore", invalid="ignore"):
            return u, affine(self.A, u, self.q)


def affine(A: Matrix, z: Vector, q: Vector) -> Vector:
    """`A z + q` as if in twice the working precision, rounded once at the end: Dot2 of [ORO05], summed as a tree."""
    support = np.flatnonzero(z)
    terms, error = _two_product(A[:, support], z[support])
    correction = error.sum(axis=1)
    terms = np.column_stack([terms, q])
    while terms.shape[1] > 1:
        half = terms.shape[1] // 2
        left, right, rest = terms[:, :half], terms[:, half : 2 * half], terms[:, 2 * half :]
        total = left + right
        virtual = total - left
        correction += ((left - (total - virtual)) + (right - virtual)).sum(axis=1)
        terms = np.hstack([total, rest])
    return np.asarray(terms[:, 0] + correction)


def _two_product(a: Matrix, b: Vector) -> tuple[Matrix, Matrix]:
    """`a * b` and its rounding error, exact barring overflow and underflow."""
    product = a * b
    a_high, b_high = _high(a), _high(b)
    a_low, b_low = a - a_high, b - b_high
    error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
    return product, error


def _high(x: Matrix | Vector) -> Matrix:
    """The upper half of the digits of x (Veltkamp's splitting)."""
    shifted = 134217729.0 * x  # 2^27 + 1
    return np.asarray(shifted - (shifted - x))


def _exponents(A: Matrix, q: Vector) -> tuple[np.ndarray, np.ndarray, int]:
    """Binary exponents of the scaling of rows, columns and q: Ruiz equilibration in the max norm. [Rui01]."""
    entries = np.where(A == 0.0, _ZERO, np.frexp(A)[1])
    rows, columns = np.zeros(len(q), dtype=np.int64), np.zeros(len(q), dtype=np.int64)
    largest = np.abs(A)
    ends = np.concatenate([largest.max(axis=1, initial=0.0), largest.max(axis=0, initial=0.0)])
    if not ((ends >= 0.25) & (ends < 2.0)).all():
        for _ in range(_SWEEPS):
            scaled = entries + rows[:, None] + columns
            down_rows, down_columns = _halved(scaled.max(axis=1)), _halved(scaled.max(axis=0))
            if not (down_rows.any() or down_columns.any()):
                break
            rows, columns = rows - down_rows, columns - down_columns
    scaled_q = np.where(q == 0.0, _ZERO, np.frexp(q)[1] + rows)
    top = int(scaled_q.max(initial=_ZERO))
    return rows, columns, 0 if top < _ZERO // 2 else -top


def _halved(current: np.ndarray) -> np.ndarray:
    """Half the distance of each largest entry from 1, towards zero; nothing for an empty row or a near one."""
    half = np.sign(current) * (np.abs(current) // 2)
    return np.where((current < _ZERO // 2) | (np.abs(current) <= 1), 0, half)


def seconds(call: Callable[[], object], budget: float, once: float) -> float:
    """Seconds per call over about `budget` seconds of calls, where one was seen to take `once`."""
    repeats = max(1, min(1000, int(budget / max(once, 1e-7))))
    start = clock()
    for _ in range(repeats):
        call()
    return (clock() - start) / repeats


def machine() -> str:
    """The machine in one line, for records."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as info:
            model = next((line.split(":", 1)[1].strip() for line in info if line.startswith("model name")), model)
    except OSError:
        pass  # not Linux: what platform says is all there is
    return (
        f"{model}, {platform.system()}, Python {sys.version.split()[0]}, NumPy {np.__version__}, "
        f"lcpstar {__version__}; clock {CLOCK}"
    )
