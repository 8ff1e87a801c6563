"""The methods table of the work-precision benchmark: a new method is one line."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..coerce import Matrix, Vector
from ..errors import UnknownNameError
from ..options import InteriorPointOptions, MethodOptions, PotentialReductionOptions
from ..solve import solve


@dataclass(frozen=True)
class Entry:
    """A way to call `solve`: `rung` is the precision of the input and of the proof."""

    name: str
    method: str
    kind: str
    options: MethodOptions | None = None
    rung: str = "float64"

    def call(self, A: Matrix, q: Vector, tol: float, time_limit: float | None, z0: Vector | None) -> Any:
        """A function of no argument that solves the problem; conversions of the input are not part of it."""
        keywords: dict[str, Any] = {"method": self.method, "tol": tol, "time_limit": time_limit}
        if z0 is not None:
            keywords["z0"] = z0
        if self.options is not None:
            keywords["options"] = self.options
        if self.rung == "exact":
            keywords["certify"] = "exact"
        if self.rung == "float32":
            A, q = _single(A), _single(q)
        return partial(solve, A, q, **keywords)


def _single(array: Matrix | Vector) -> Matrix:
    """Rounded to single precision; a number beyond its range becomes its largest, a tiny one zero."""
    top = float(np.finfo(np.float32).max)
    return np.clip(array, -top, top).astype(np.float32).astype(np.float64)


_LONG_STEPS = PotentialReductionOptions(long_step=True)

TABLE: tuple[Entry, ...] = (
    Entry("auto", "auto", "auto"),
    Entry("auto, float32", "auto", "auto", rung="float32"),
    Entry("auto, exact", "auto", "auto", rung="exact"),
    Entry("lemke", "lemke", "pivoting"),
    Entry("principal_pivoting", "principal_pivoting", "pivoting"),
    Entry("block_pivoting", "block_pivoting", "pivoting"),
    Entry("interior_point", "interior_point", "interior"),
    Entry("interior_point, no finish", "interior_point", "interior", InteriorPointOptions(finish=False)),
    Entry("newton", "newton", "pivoting"),
    Entry("pgs", "pgs", "approximate"),
    Entry("pgs_sm", "pgs_sm", "approximate"),
    Entry("nncg", "nncg", "approximate"),
    Entry("apgd", "apgd", "approximate"),
    Entry("admm", "admm", "approximate"),
    Entry("potential_reduction", "potential_reduction", "interior", _LONG_STEPS),
)

NAMES: tuple[str, ...] = tuple(entry.name for entry in TABLE)
#: Single methods: what "auto" is compared with.
SINGLE: tuple[str, ...] = tuple(entry.name for entry in TABLE if entry.kind != "auto")
#: Methods whose work grows with the accuracy asked for.
APPROXIMATE: tuple[str, ...] = tuple(entry.name for entry in TABLE if entry.kind == "approximate")


def chosen(names: list[str] | None) -> list[Entry]:
    """The entries of these names, all for `None`."""
    if names is None:
        return list(TABLE)
    unknown = [name for name in names if name not in NAMES]
    if unknown:
        raise UnknownNameError(f"method must be one of {'; '.join(NAMES)}, got {unknown[0]!r}")
    return [entry for entry in TABLE if entry.name in names]
