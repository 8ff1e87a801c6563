"""Which bodies may touch: a grid of cells, O(n + pairs) for bodies of similar size."""

from __future__ import annotations

import numpy as np

from ..coerce import Matrix, Vector
from .contact import Indices
from .rotation import dot


def near_pairs(position: Matrix, reach: Vector, movable: np.ndarray) -> tuple[Indices, Indices]:
    """Pairs i < j, sorted, with `|x_i - x_j| <= reach_i + reach_j` and at least one of them movable.

    Cells have the edge `2 max reach`, so a pair lies in the same or in neighbouring cells. Whether a pair is found does
    not depend on other bodies.
    """
    n = len(position)
    if n < 2:
        return np.empty(0, np.intp), np.empty(0, np.intp)
    if n <= 24:
        i, j = np.triu_indices(n, 1)
    else:
        i, j = _cell_pairs(position, 2.0 * float(reach.max()) * (1 + 1e-12))
    apart = position[i] - position[j]
    limit = reach[i] + reach[j]
    keep = (dot(apart, apart) <= limit * limit) & (movable[i] | movable[j])
    i, j = i[keep], j[keep]
    order = np.lexsort((j, i))
    return i[order], j[order]


def _cell_pairs(position: Matrix, edge: float) -> tuple[Indices, Indices]:
    cell = np.floor((position - position.min(axis=0)) / edge).astype(np.int64) + 1
    spans = cell.max(axis=0) + 2
    strides = np.array([spans[1] * spans[2], spans[2], 1])
    key = cell @ strides
    order = np.argsort(key, kind="stable")
    sorted_key = key[order]
    firsts, seconds = [], []
    for dx, dy, dz in _HALF:
        target = key + int(np.array([dx, dy, dz]) @ strides)
        low = np.searchsorted(sorted_key, target, "left")
        count = np.searchsorted(sorted_key, target, "right") - low
        i = np.repeat(np.arange(len(key)), count)
        within = np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count)
        j = order[np.repeat(low, count) + within]
        if (dx, dy, dz) == (0, 0, 0):
            i, j = i[i < j], j[i < j]
        firsts.append(np.minimum(i, j))
        seconds.append(np.maximum(i, j))
    return np.concatenate(firsts), np.concatenate(seconds)


#: A cell itself and one of every two opposite neighbours.
_HALF = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) >= (0, 0, 0)]
