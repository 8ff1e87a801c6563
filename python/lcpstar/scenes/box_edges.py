"""Contacts of boxes in space where an edge crosses an edge: nine directions, and the closest points of two segments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..coerce import Matrix, Vector
from .contact import Indices
from .rotation import cross, dot, rotate, rotate_back

#: Edges whose angle has a smaller sine are parallel: the faces' normals separate what they can separate.
_PARALLEL = 1e-5
#: An edge is this much longer, relatively, than it is: the deepest point of an overlap may lie at its end.
_LONGER = 1e-4


def crossing_axes(R: Matrix, S: Matrix, half: Matrix, other: Matrix, offset: Matrix) -> tuple[Vector, Matrix, Indices]:
    """The cross product of two edges that separates each pair of boxes most: by how much, its direction towards the
    second box (p, 3), and the two edges' axes (p, 2). The boxes' axes are R and S (p, 3, 3), the second is at `offset`.
    """
    first, second = np.divmod(np.arange(9), 3)
    n = cross(np.swapaxes(R, 1, 2)[:, first], np.swapaxes(S, 1, 2)[:, second])
    sine = np.sqrt(dot(n, n))
    n = n / np.where(sine > _PARALLEL, sine, 1.0)[..., None]
    along = dot(n, offset[:, None])
    reach = dot(np.abs(rotate_back(R[:, None], n)), half[:, None])
    reach = reach + dot(np.abs(rotate_back(S[:, None], n)), other[:, None])
    separation = np.where(sine > _PARALLEL, np.abs(along) - reach, -np.inf)
    best = np.argmax(separation, axis=1)
    rows = np.arange(len(best))
    towards = n[rows, best] * np.where(along[rows, best] < 0, -1.0, 1.0)[:, None]
    return separation[rows, best], towards, np.stack([first[best], second[best]], axis=1)


def crossings(
    R: Matrix, S: Matrix, half: Matrix, other: Matrix, offset: Matrix, normal: Matrix, axes: Indices
) -> tuple[Matrix, NDArray[np.bool_], Indices]:
    """Where the edge of the first box furthest along `normal` passes the edge of the second furthest against it.

    The point between the two lines from the first box's centre (p, 3), whether it lies on both edges, and a number
    0..143 for the two edges.
    """
    p, d, long, one = _edge(R, half, normal, axes[:, 0])
    q, e, wide, two = _edge(S, other, -normal, axes[:, 1])
    r = q + offset - p
    c = dot(d, e)
    s = (dot(r, d) - c * dot(r, e)) / (1 - c * c)
    t = c * s - dot(r, e)
    on = (np.abs(s) <= (1 + _LONGER) * long) & (np.abs(t) <= (1 + _LONGER) * wide)
    middle = 0.5 * (p + s[:, None] * d + q + offset + t[:, None] * e)
    return middle, on, 12 * one + two


def _edge(R: Matrix, half: Matrix, normal: Matrix, axis: Indices) -> tuple[Matrix, Matrix, Vector, Indices]:
    """Centre, direction, half length and number 0..11 of the edge along `axis` furthest along `normal`."""
    rows = np.arange(len(axis))
    sign = np.where(rotate_back(R, normal) < 0, -1.0, 1.0)
    sign[rows, axis] = 0.0
    up, side = sign[rows, (axis + 1) % 3] > 0, sign[rows, (axis + 2) % 3] > 0
    return rotate(R, sign * half), R[rows, :, axis], half[rows, axis], 4 * axis + 2 * up + side
