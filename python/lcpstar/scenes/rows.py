"""Rows of a scene's Jacobian: each on two bodies, and the masses that go with them.

A body's velocity is `u = (v, R' omega)`, angular part in its own axes, so that the mass matrix is diagonal; planar
scenes keep three of the six columns. With `S = J M^(-1/2)` the matrix of a contact problem is `S S'`, symmetric to the
last bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..coerce import Matrix, Vector
from .contact import WORLD, Contacts, Indices
from .rotation import cross, dot, rotate, rotate_back, rotations
from .scene import Scene

_PLANAR = np.array([0, 2, 4])


@dataclass(frozen=True, eq=False)
class Rows:
    """`bodies` (r, 2), -1 where nothing moves; `J` (r, 2, D): the row's entries on the one and the other body."""

    bodies: Indices
    J: Matrix

    def times(self, u: Matrix) -> Vector:
        """`J u` for velocities u (n, D)."""
        if not len(u):
            return np.zeros(len(self.J))
        first = dot(self.J[:, 0], u[self.bodies[:, 0]])
        return np.asarray(first + dot(self.J[:, 1], u[self.bodies[:, 1]]))

    def rounding_times(self, error: Matrix) -> Vector:
        """`|J| error`: what errors of the velocities make of the rows."""
        return Rows(self.bodies, np.abs(self.J)).times(error)

    def transposed_times(self, p: Vector, n: int) -> Matrix:
        """`J' p` (n, D); terms of one body are added in the order of the rows."""
        body = self.bodies.ravel()
        on = body >= 0
        out = np.empty((n, self.J.shape[2]))
        for d in range(self.J.shape[2]):
            terms = (self.J[:, :, d] * p[:, None]).ravel()
            out[:, d] = np.bincount(body[on], terms[on], minlength=n)
        return out


class Masses:
    """Velocities and inverse masses of a scene in the columns that `Rows` use."""

    def __init__(self, scene: Scene) -> None:
        self.columns = _PLANAR if scene.planar else np.arange(6)
        self.R = rotations(scene.orientation)
        with np.errstate(divide="ignore"):
            inverse = np.concatenate([np.repeat(1 / scene.mass[:, None], 3, axis=1), 1 / scene.inertia], axis=1)
        self.inverse = inverse[:, self.columns]
        self.root = np.sqrt(self.inverse)

    def pack(self, velocity: Matrix, angular_velocity: Matrix) -> Matrix:
        """`u` (n, D) from velocities in the world's axes."""
        both = np.concatenate([velocity, rotate_back(self.R, angular_velocity)], axis=1)
        return both[:, self.columns]

    def unpack(self, u: Matrix) -> tuple[Matrix, Matrix]:
        """Velocities and angular velocities (n, 3) in the world's axes."""
        if len(self.columns) == 6:
            return u[:, :3].copy(), rotate(self.R, u[:, 3:])
        none = np.zeros(len(u))
        return np.stack([u[:, 0], none, u[:, 1]], axis=1), np.stack([none, u[:, 2], none], axis=1)

    @cached_property
    def movable(self) -> np.ndarray:
        """Which bodies can move."""
        return np.asarray(self.inverse[:, 0] > 0)


def contact_rows(scene: Scene, masses: Masses, contacts: Contacts) -> tuple[Rows, Rows]:
    """Rows of the normals (k), and of the tangents: k in a planar scene, else 2 k, contact after contact."""
    normals = directed_rows(scene, masses, contacts.bodies, contacts.point, contacts.point, contacts.normal)
    n = contacts.normal
    if scene.planar:
        t = np.stack([n[:, 2], np.zeros(len(n)), -n[:, 0]], axis=1)
        return normals, directed_rows(scene, masses, contacts.bodies, contacts.point, contacts.point, t)
    axis = np.zeros_like(n)
    axis[np.arange(len(n)), np.argmin(np.abs(n), axis=1)] = 1.0
    t1 = cross(n, axis)
    t1 /= np.sqrt(dot(t1, t1))[:, None]
    both = np.stack([t1, cross(n, t1)], axis=1).reshape(-1, 3)
    bodies, point = np.repeat(contacts.bodies, 2, axis=0), np.repeat(contacts.point, 2, axis=0)
    return normals, directed_rows(scene, masses, bodies, point, point, both)


def directed_rows(scene: Scene, masses: Masses, bodies: Indices, at: Matrix, other: Matrix, direction: Matrix) -> Rows:
    """Rows of the velocity along `direction` of the first body's point `at` relative to the second's point `other`."""
    J = np.zeros((len(bodies), 2, len(masses.columns)))
    owner = np.full(bodies.shape, WORLD, dtype=np.intp)
    for side, point, sign in ((0, at, 1.0), (1, other, -1.0)):
        on = np.flatnonzero(bodies[:, side] >= 0)
        on = on[masses.movable[bodies[on, side]]]
        body = bodies[on, side]
        owner[on, side] = body
        arm = cross(point[on] - scene.position[body], direction[on])
        entries = np.concatenate([direction[on], rotate_back(masses.R[body], arm)], axis=1)
        J[on, side] = sign * entries[:, masses.columns]
    return Rows(owner, J)
