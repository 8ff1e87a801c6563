"""Contacts of convex polygons in the x-z plane: separating face, incident edge, clipping; all pairs at once."""

from __future__ import annotations

import numpy as np

from ..coerce import Matrix, Vector
from .contact import Indices
from .rotation import rotate
from .scene import Scene

#: The first body's face is kept as the reference unless the other's separates by this fraction of the radius more.
_PREFERENCE = 1e-4


def polygon_contacts(
    scene: Scene, R: Matrix, i: Indices, j: Indices, margin: Vector
) -> tuple[Indices, Indices, Matrix, Matrix, Vector, Indices]:
    """At most two contacts per pair: the ends of the overlap of the reference face and the incident edge."""
    W, normals, size = _world_outlines(scene, R)
    separation_i, face_i = _deepest_face(W[i], normals[i], W[j])
    separation_j, face_j = _deepest_face(W[j], normals[j], W[i])
    swap = separation_j > separation_i + _PREFERENCE * np.minimum(scene.radius[i], scene.radius[j])
    near = np.where(swap, separation_j, separation_i) < margin
    i, j, swap, margin = i[near], j[near], swap[near], margin[near]
    reference, other = np.where(swap, j, i), np.where(swap, i, j)
    face = np.where(swap, face_j[near], face_i[near])
    m = W.shape[1]
    normal = normals[reference, face]
    start, end = W[reference, face], W[reference, (face + 1) % m]
    facing = normals[other, :, 0] * normal[:, None, 0] + normals[other, :, 1] * normal[:, None, 1]
    edge = np.argmin(np.where(size[other] > 0, facing, np.inf), axis=1)
    a, b = W[other, edge], W[other, (edge + 1) % m]
    points, kept = _clipped(start, end, a, b)
    gap = (points[..., 0] - start[:, None, 0]) * normal[:, None, 0]
    gap = gap + (points[..., 1] - start[:, None, 1]) * normal[:, None, 1]
    kept &= gap < margin[:, None]
    pair, tip = np.nonzero(kept)
    gap, flat = gap[pair, tip], normal[pair]
    middle = points[pair, tip] - flat * (0.5 * gap)[:, None]
    towards = np.where(swap[pair], 1.0, -1.0)[:, None] * flat  # from body j to body i
    feature = ((swap[pair] * m + face[pair]) * m + edge[pair]) * 2 + tip
    return i[pair], j[pair], _spatial(middle), _spatial(towards), gap, feature.astype(np.intp)


def _world_outlines(scene: Scene, R: Matrix) -> tuple[Matrix, Matrix, Matrix]:
    """Corners (n, m, 2) in the world, outward unit normals of the edges after them, and edge lengths.

    Shorter outlines repeat their last corner; the edges of length 0 get the normal 0.
    """
    W = scene.position[:, None, [0, 2]] + rotate(R[:, None], scene.corners)[..., [0, 2]]
    along = np.roll(W, -1, axis=1) - W
    length = np.sqrt(along[..., 0] * along[..., 0] + along[..., 1] * along[..., 1])
    real = np.where(length > 0, length, 1.0)
    normals = np.stack([along[..., 1] / real, -along[..., 0] / real], axis=-1)
    return W, normals, length


def _deepest_face(W: Matrix, normals: Matrix, others: Matrix) -> tuple[Vector, Indices]:
    """The face of each polygon that separates it most from the other, and by how much."""
    dx = others[:, None, :, 0] - W[:, :, None, 0]
    dz = others[:, None, :, 1] - W[:, :, None, 1]
    distance = (dx * normals[:, :, None, 0] + dz * normals[:, :, None, 1]).min(axis=2)
    distance = np.where((normals[..., 0] == 0) & (normals[..., 1] == 0), -np.inf, distance)
    face = np.argmax(distance, axis=1)
    return distance[np.arange(len(face)), face], face


def _clipped(start: Matrix, end: Matrix, a: Matrix, b: Matrix) -> tuple[Matrix, np.ndarray]:
    """Ends (p, 2, 2) of the part of the segment a b that lies above the face from start to end, and which count."""
    along = end - start
    squared = along[:, 0] * along[:, 0] + along[:, 1] * along[:, 1]
    s = ((a - start)[:, 0] * along[:, 0] + (a - start)[:, 1] * along[:, 1]) / squared
    t = ((b - start)[:, 0] * along[:, 0] + (b - start)[:, 1] * along[:, 1]) / squared
    run = np.where(s == t, 1.0, t - s)
    at_zero, at_one = -s / run, (1 - s) / run
    first = np.clip(np.minimum(at_zero, at_one), 0.0, 1.0)
    last = np.clip(np.maximum(at_zero, at_one), 0.0, 1.0)
    inside = np.where(s == t, (s >= 0) & (s <= 1), (np.maximum(s, t) > 0) & (np.minimum(s, t) < 1))
    points = np.stack([a + first[:, None] * (b - a), a + last[:, None] * (b - a)], axis=1)
    two = (last - first) * np.abs(run) > 1e-6
    return points, np.stack([inside, inside & two], axis=1)


def _spatial(flat: Matrix) -> Matrix:
    return np.stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]], axis=1)
