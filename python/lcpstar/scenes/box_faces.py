"""Contacts of boxes in space, all pairs at once: edges that cross, or the separating face and what lies above it."""

from __future__ import annotations

import numpy as np

from ..coerce import Matrix, Vector
from .box_edges import crossing_axes, crossings
from .contact import Indices
from .rotation import dot, rotate, rotate_back
from .scene import Scene

#: The first body's face is kept as the reference unless the other's, or two edges, separate by this fraction of the
#: radius more.
_PREFERENCE = 1e-4
#: Points of a face nearer than this, in extents, are one: faces that match have four contacts, not eight.
_SAME = 1e-4
#: Numbers of contacts on faces are below this; edges come after.
_FACES = 144
#: Going around the face with the normal along `axis`: signs along the next two axes.
_AROUND = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def box_contacts(
    scene: Scene, R: Matrix, i: Indices, j: Indices, margin: Vector
) -> tuple[Indices, Indices, Matrix, Matrix, Vector, Indices]:
    """One contact where an edge crosses an edge; else the corners of the overlap of two faces, at most eight."""
    half = np.array([b.shape.half for b in scene.bodies]).reshape(-1, 3)  # type: ignore[union-attr]
    offset = scene.position[j] - scene.position[i]
    separation_i, axis_i = _deepest_axis(R, half, i, j, offset)
    separation_j, axis_j = _deepest_axis(R, half, j, i, -offset)
    preference = _PREFERENCE * np.minimum(scene.radius[i], scene.radius[j])
    of_faces = np.maximum(separation_i, separation_j)
    boxes = (R[i], R[j], half[i], half[j], offset)
    separation_e, normal, edges = crossing_axes(*boxes)
    middle, crosses, number = crossings(*boxes, normal, edges)
    crosses &= separation_e > of_faces + preference
    near = crosses & (separation_e < margin)
    on_edges = (
        i[near],
        j[near],
        scene.position[i[near]] + middle[near],
        -normal[near],
        separation_e[near],
        _FACES + number[near],
    )
    near = ~crosses & (of_faces < margin)
    swap = (separation_j > separation_i + preference)[near]
    axis = np.where(swap, axis_j[near], axis_i[near])
    on_faces = _face_contacts(scene, R, half, i[near], j[near], margin[near], swap, axis)
    return tuple(np.concatenate(both) for both in zip(on_faces, on_edges, strict=True))  # type: ignore[return-value]


def _face_contacts(
    scene: Scene, R: Matrix, half: Matrix, i: Indices, j: Indices, margin: Vector, swap: np.ndarray, axis: Indices
) -> tuple[Indices, Indices, Matrix, Matrix, Vector, Indices]:
    """What of the facing face lies above the face along `axis` of box i, or of box j where `swap`."""
    reference, other = np.where(swap, j, i), np.where(swap, i, j)
    towards_other = scene.position[other] - scene.position[reference]
    rows = np.arange(len(i))
    column = R[reference, :, axis]
    side = np.where(dot(column, towards_other) >= 0, 1.0, -1.0)
    normal = column * side[:, None]
    corners = _facing_face(R[other], half[other], normal) + towards_other[:, None]
    local = rotate_back(R[reference][:, None], corners)  # the facing face in the axes of the reference
    first, second = (axis + 1) % 3, (axis + 2) % 3
    flat = np.stack([local[rows, :, first], local[rows, :, second]], axis=-1)
    height = local[rows, :, axis] * side[:, None] - half[reference, axis][:, None]
    extent = np.stack([half[reference, first], half[reference, second]], axis=-1)
    spots, gap, kept = _overlap(flat, height, extent)
    kept &= gap < margin[:, None]
    pair, tip = np.nonzero(kept)
    gap = gap[pair, tip]
    local = np.empty((len(pair), 3))
    at = np.arange(len(pair))
    local[at, first[pair]], local[at, second[pair]] = spots[pair, tip, 0], spots[pair, tip, 1]
    local[at, axis[pair]] = side[pair] * (half[reference[pair], axis[pair]] + 0.5 * gap)
    point = scene.position[reference[pair]] + rotate(R[reference[pair]], local)
    feature = ((swap[pair] * 3 + axis[pair]) * 2 + (side[pair] > 0)) * 12 + tip
    outward = np.where(swap[pair], 1.0, -1.0)[:, None] * normal[pair]  # from body j to body i
    return i[pair], j[pair], point, outward, gap, feature.astype(np.intp)


def _deepest_axis(R: Matrix, half: Matrix, i: Indices, j: Indices, offset: Matrix) -> tuple[Vector, Indices]:
    """The axis of box i whose faces separate it most from box j, and by how much."""
    away = np.abs(rotate_back(R[i], offset)) - half[i]
    for axis in range(3):
        along = np.abs(rotate_back(R[j], R[i][:, :, axis]))  # that axis in the axes of j
        away[:, axis] -= dot(along, half[j])
    best = np.argmax(away, axis=1)
    return away[np.arange(len(best)), best], best


def _facing_face(R: Matrix, half: Matrix, normal: Matrix) -> Matrix:
    """Corners (p, 4, 3), from its centre, of the face of each box whose outward normal is most against `normal`."""
    along = rotate_back(R, normal)
    axis = np.argmax(np.abs(along), axis=1)
    rows = np.arange(len(axis))
    sign = np.where(along[rows, axis] > 0, -1.0, 1.0)
    corners = np.empty((len(axis), 4, 3))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    corners[rows, :, axis] = (sign * half[rows, axis])[:, None]
    corners[rows, :, first] = half[rows, first][:, None] * _AROUND[:, 0]
    corners[rows, :, second] = half[rows, second][:, None] * _AROUND[:, 1]
    return rotate(R[:, None], corners)


def _overlap(flat: Matrix, height: Matrix, extent: Matrix) -> tuple[Matrix, Matrix, np.ndarray]:
    """Corners of the quadrilateral `flat` (p, 4, 2) within the rectangle `|x| <= extent`, heights, which count.

    Twelve candidates: the start of each clipped edge, its end where it leaves the rectangle, and the rectangle's
    corners strictly inside the quadrilateral.
    """
    wide = (1 + _SAME) * extent
    step, rise = np.roll(flat, -1, axis=1) - flat, np.roll(height, -1, axis=1) - height
    enter, leave = np.zeros(height.shape), np.ones(height.shape)
    hit = np.ones(height.shape, dtype=bool)
    for k in range(2):
        moves = step[..., k] != 0
        run = np.where(moves, step[..., k], 1.0)
        one = (wide[:, None, k] - flat[..., k]) / run
        two = (-wide[:, None, k] - flat[..., k]) / run
        hit &= moves | (np.abs(flat[..., k]) <= wide[:, None, k])
        enter = np.where(moves, np.maximum(enter, np.minimum(one, two)), enter)
        leave = np.where(moves, np.minimum(leave, np.maximum(one, two)), leave)
    hit &= enter < leave - 1e-9
    starts, ends = flat + enter[..., None] * step, flat + leave[..., None] * step
    corners = extent[:, None] * _AROUND
    # positive on the left of an edge; the quadrilateral may go around either way
    left = step[:, :, None, 0] * (corners[:, None, :, 1] - flat[:, :, None, 1])
    left = left - step[:, :, None, 1] * (corners[:, None, :, 0] - flat[:, :, None, 0])
    least = 2 * _SAME * np.abs(step).max(axis=-1) * extent.max(axis=1)[:, None]
    inside = (left > least[:, :, None]).all(axis=1) | (left < -least[:, :, None]).all(axis=1)
    spots = np.clip(np.concatenate([starts, ends, corners], axis=1), -extent[:, None], extent[:, None])
    plane = _height_above(flat, height, corners)
    heights = np.concatenate([height + enter * rise, height + leave * rise, plane], axis=1)
    return spots, heights, np.concatenate([hit, hit & (leave < 1 - 1e-9), inside], axis=1)


def _height_above(flat: Matrix, height: Matrix, spots: Matrix) -> Matrix:
    """Height of the plane through the quadrilateral's first corner and its two neighbours, at the spots."""
    u, v = flat[:, 1] - flat[:, 0], flat[:, 3] - flat[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    area = np.where(area == 0, np.inf, area)[:, None]
    d = spots - flat[:, :1]
    a = (d[..., 0] * v[:, None, 1] - d[..., 1] * v[:, None, 0]) / area
    b = (u[:, None, 0] * d[..., 1] - u[:, None, 1] * d[..., 0]) / area
    return np.asarray(height[:, :1] + a * (height[:, 1:2] - height[:, :1]) + b * (height[:, 3:4] - height[:, :1]))
