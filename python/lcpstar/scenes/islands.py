"""Islands: bodies that act on one another through contacts and joints; the world joins nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .contact import Indices


def islands(pairs: Indices, movable: NDArray[np.bool_]) -> Indices:
    """For each body the smallest index in its island, -1 for a body that never moves.

    `pairs` (k, 2): bodies in contact or jointed, -1 for the world. Union-find with path halving,
    O((n + k) log n) at worst. [TL84]
    """
    parent = list(range(len(movable)))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    moves = np.asarray((pairs >= 0).all(axis=1) & movable[pairs].all(axis=1))
    if moves.any():
        code = np.unique(pairs[moves, 0] * len(movable) + pairs[moves, 1])
        for i, j in zip((code // len(movable)).tolist(), (code % len(movable)).tolist(), strict=True):
            a, b = root(i), root(j)
            if a < b:
                parent[b] = a
            else:
                parent[a] = b
    return np.array([root(i) if movable[i] else -1 for i in range(len(movable))], dtype=np.intp)
