"""Contact points of a scene: spheres, convex polygons in the plane, boxes, and planes.

A workload generator, not a collision library: a scene holds spheres or boxes, not both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..coerce import Matrix, Vector
from .box_faces import box_contacts
from .contact import WORLD, Contacts, Indices
from .neighbours import near_pairs
from .polygons import polygon_contacts
from .rotation import dot, rotate, rotations
from .scene import Scene

#: Contacts are looked for up to this gap, in bounding radii, beyond what motion asks for.
SKIN = 0.01


@dataclass(frozen=True, eq=False)
class Points:
    """Contact points of pairs (i, j): `normal` points from j to i, `gap` along it, `feature` within the pair."""

    i: Indices
    j: Indices
    point: Matrix
    normal: Matrix
    gap: Vector
    feature: Indices


def motion(scene: Scene, velocity: Matrix, angular_velocity: Matrix, dt: float) -> Vector:
    """How far any point of a body moves in `dt` seconds at most (n,): `dt (|v| + |omega| r)`, r its bounding radius."""
    speed, spin = np.sqrt(dot(velocity, velocity)), np.sqrt(dot(angular_velocity, angular_velocity))
    return np.asarray(dt * (speed + spin * scene.radius))


def margins(scene: Scene, dt: float) -> Vector:
    """How far each body may move in a step without impulses, and a little more: `motion + dt^2 |g| + SKIN r`."""
    fall = dt * dt * float(np.sqrt(scene.gravity @ scene.gravity))
    return np.asarray(motion(scene, scene.velocity, scene.angular_velocity, dt) + fall + SKIN * scene.radius)


def find_contacts(scene: Scene, dt: float, margin: Vector | None = None) -> Contacts:
    """All contacts that could close while no body moves further than `margin` (n,) [m], in the order of bodies.

    By default the `margins` of a step of `dt` seconds. Bodies that share a joint do not collide.

    A pair's contacts depend on
    that pair alone. O(n + contacts) in NumPy for bodies of similar size; a planar pair of polygons with m corners costs
    O(m^2), a pair of boxes six face normals and nine products of edges.
    """
    margin = margins(scene, dt) if margin is None else margin
    movable = np.isfinite(scene.mass)
    R = rotations(scene.orientation)
    i, j = near_pairs(scene.position, scene.radius + margin, movable)
    if scene.joints:
        jointed = {tuple(sorted(joint.bodies)) for joint in scene.joints}
        free = np.array([pair not in jointed for pair in zip(i.tolist(), j.tolist(), strict=True)], dtype=bool)
        i, j = i[free], j[free]
    between = (polygon_contacts if scene.kind == "polygon" else box_contacts if scene.kind == "box" else _spheres)(
        scene, R, i, j, margin[i] + margin[j]
    )
    parts = [_finished(scene, Points(*between))]
    parts += [_on_plane(scene, R, k, margin, movable) for k in range(len(scene.planes))]
    return Contacts.join(parts)


def _finished(scene: Scene, p: Points) -> Contacts:
    bodies = np.stack([p.i, p.j], axis=1).astype(np.intp)
    friction = np.sqrt(scene.friction[p.i] * scene.friction[p.j])
    restitution = np.maximum(scene.restitution[p.i], scene.restitution[p.j])
    return Contacts(bodies, p.point, p.normal, p.gap, friction, restitution, p.feature)


def _spheres(
    scene: Scene, R: Matrix, i: Indices, j: Indices, margin: Vector
) -> tuple[Indices, Indices, Matrix, Matrix, Vector, Indices]:
    radius = scene.radius
    apart = scene.position[i] - scene.position[j]
    distance = np.sqrt(dot(apart, apart))
    gap = distance - (radius[i] + radius[j])
    keep = gap < margin
    i, j, gap = i[keep], j[keep], gap[keep]
    at_one_point = (distance[keep] == 0)[:, None]  # any normal will do
    normal = np.where(at_one_point, (0.0, 0.0, 1.0), apart[keep]) / np.where(at_one_point, 1.0, distance[keep, None])
    point = scene.position[j] + normal * (radius[j] + 0.5 * gap)[:, None]
    return i, j, point, normal, gap, np.zeros(len(i), np.intp)


def _on_plane(scene: Scene, R: Matrix, k: int, margin: Vector, movable: np.ndarray) -> Contacts:
    plane = scene.planes[k]
    normal = np.asarray(plane.normal, dtype=float)
    height = dot(scene.position, normal[None, :]) - plane.offset
    near = np.flatnonzero((height < scene.radius + margin) & movable)
    if scene.kind == "sphere":
        body, lowest = near, scene.position[near] - normal * scene.radius[near, None]
        vertex = np.zeros(len(near), np.intp)
    else:
        at, vertex = np.nonzero(np.arange(scene.corners.shape[1]) < scene.corner_count[near, None])
        body = near[at]
        lowest = scene.position[body] + rotate(R[body], scene.corners[body, vertex])
    gap = dot(lowest, normal[None, :]) - plane.offset
    keep = gap < margin[body]
    body, lowest, gap, vertex = body[keep], lowest[keep], gap[keep], vertex[keep]
    return Contacts(
        np.stack([body, np.full(len(body), WORLD)], axis=1).astype(np.intp),
        lowest - normal * (0.5 * gap)[:, None],
        np.broadcast_to(normal, (len(body), 3)),
        gap,
        np.sqrt(scene.friction[body] * plane.friction),
        np.maximum(scene.restitution[body], plane.restitution),
        (64 * k + vertex).astype(np.intp),
    )
