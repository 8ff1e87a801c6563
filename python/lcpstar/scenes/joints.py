"""Joints: their rows, the velocities that they allow, and the positions in which they are closed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..coerce import Matrix, Vector
from .contact import WORLD, Indices
from .islands import islands
from .rotation import dot, rotate, rotations, turn
from .rows import Masses, Rows, directed_rows
from .scene import Scene

#: Newton steps that close the joints of an island.
_NEWTON_STEPS = 20
#: A joint is closed to this, times the size of its bodies and of its place: their rounding.
_CLOSED = 256 * np.finfo(float).eps
#: Metrics to try, powers of the masses, until the error is below this times the largest radius.
_METRICS, _ENOUGH = (1.0, 0.5, 0.0), 1e-3
#: No body turns by more in one of them [rad].
_TURN = 0.5


def anchors(scene: Scene) -> tuple[Indices, Matrix, Matrix]:
    """The bodies (j, 2) of each joint and its two anchors in the world (j, 3)."""
    bodies = np.array([j.bodies for j in scene.joints], dtype=np.intp).reshape(-1, 2)
    local = np.array([j.anchors for j in scene.joints], dtype=float).reshape(-1, 2, 3)
    turned = rotate(rotations(scene.orientation)[bodies], local) + scene.position[bodies]
    at = np.where((bodies == WORLD)[..., None], local, turned)
    return bodies, at[:, 0], at[:, 1]


def joint_errors(scene: Scene) -> Vector:
    """How far the two anchors of each joint are apart [m]."""
    _, one, other = anchors(scene)
    return np.asarray(np.sqrt(dot(one - other, one - other)))


def _open(scene: Scene) -> NDArray[np.bool_]:
    """Which joints are further apart than rounding explains."""
    bodies, one, other = anchors(scene)
    size = np.abs(one).max(axis=1) + np.where(bodies >= 0, scene.radius[bodies], 0.0).max(axis=1)
    return np.asarray(np.sqrt(dot(one - other, one - other)) > _CLOSED * size)


def joint_rows(scene: Scene, masses: Masses) -> tuple[Rows, Vector]:
    """Rows of the joints (two each in the plane, three in space) and by how much each is apart [m]."""
    bodies, one, other = anchors(scene)
    directions = np.eye(3)[[0, 2]] if scene.planar else np.eye(3)
    m = len(directions)
    at, away = np.repeat(one, m, axis=0), np.repeat(other, m, axis=0)
    rows = directed_rows(scene, masses, np.repeat(bodies, m, axis=0), at, away, np.tile(directions, (len(bodies), 1)))
    return rows, ((one - other) @ directions.T).ravel()


def close_joints(scene: Scene) -> tuple[Matrix, Matrix]:
    """Moves jointed bodies until their anchors meet: by how much each moved and turned (n, 3).

    Newton's method in the mass metric, so that the centre of mass of bodies that hang on nothing stays; where that does
    not close them (a taut chain with a heavy end), in metrics with less of the masses. Joints that cannot be closed are
    left with the smallest error found.
    """
    moved, turned = np.zeros((2, len(scene), 3))
    apart = _open(scene)
    if not apart.any():
        return moved, turned
    bodies, _, _ = anchors(scene)
    home = np.append(islands(bodies, np.isfinite(scene.mass)), WORLD)
    of_joint = home[bodies].max(axis=1)
    for island in np.unique(of_joint[apart & (of_joint >= 0)]):
        own = np.flatnonzero(of_joint == island)
        which = np.unique(bodies[own])
        which = which[which >= 0]
        part = scene.subset(which, [scene.joints[k] for k in own])
        best = joint_errors(part).max()
        for power in _METRICS:
            trial = part.copy()
            shift, turns = _newton(trial, power)
            error = joint_errors(trial).max()
            if error < best:
                best, moved[which], turned[which] = error, shift, turns
                scene.position[which], scene.orientation[which] = trial.position, trial.orientation
            if best <= _ENOUGH * part.radius.max():
                break
    return moved, turned


def _newton(scene: Scene, power: float) -> tuple[Matrix, Matrix]:
    """Newton's method on the joints of one island in the metric of `mass^power`."""
    weights = np.where(np.isfinite(scene.mass), scene.mass, 1.0)[:, None] ** (0.5 - 0.5 * power)
    moved, turned = np.zeros((2, len(scene), 3))
    for _ in range(_NEWTON_STEPS):
        if not _open(scene).any():
            break
        masses = Masses(scene)
        masses.root = masses.root * weights
        rows, apart = joint_rows(scene, masses)
        projector = Projector(rows, masses, apart)
        shift, turns = masses.unpack(projector.velocity(np.zeros((len(scene), len(masses.columns)))))
        share = min(1.0, _TURN / max(_TURN, float(np.abs(turns).max())))
        scene.position = scene.position + share * shift
        scene.orientation = turn(scene.orientation, turns, share)
        moved, turned = moved + share * shift, turned + share * turns
    return moved, turned


class Projector:
    """Velocities that satisfy the joint rows `J u = -target` (0 by default), nearest in the mass metric."""

    def __init__(self, rows: Rows, masses: Masses, target: Vector | None = None) -> None:
        self.bodies = np.unique(rows.bodies[rows.bodies >= 0])
        self.places = np.full(len(masses.root) + 1, -1, dtype=np.intp)
        self.places[self.bodies] = np.arange(len(self.bodies))
        self.root = masses.root
        G = dense_rows(rows.bodies, rows.J * masses.root[rows.bodies], self.places)
        scale = np.sqrt((G * G).sum(axis=1))  # rows of very different masses weigh the same
        scale = np.where(scale > 0, scale, 1.0)
        U, sigma, V = np.linalg.svd(G / scale[:, None], full_matrices=False)
        rank = int((sigma > len(G) * np.finfo(float).eps * sigma.max(initial=0.0)).sum())
        self.V = V[:rank]
        missing = np.zeros(len(G)) if target is None else target / scale
        self.shift = -((U[:, :rank].T @ missing) / sigma[:rank]) @ self.V

    def velocity(self, u: Matrix) -> Matrix:
        """`u`, corrected on the jointed bodies."""
        out = u.copy()
        root = self.root[self.bodies]
        scaled = (u[self.bodies] / root).ravel()
        scaled = scaled - (scaled @ self.V.T) @ self.V + self.shift
        out[self.bodies] = scaled.reshape(len(self.bodies), -1) * root
        return out


def dense_rows(bodies: Indices, S: Matrix, places: Indices) -> Matrix:
    """Rows S (r, 2, D) as a matrix over the bodies that have a place; entries of others are dropped."""
    D = S.shape[2]
    out = np.zeros((len(S), int(places.max(initial=-1)) + 1, D))
    for side in range(2):
        at = places[bodies[:, side]]
        on = np.flatnonzero((bodies[:, side] >= 0) & (at >= 0))
        out[on, at[on]] += S[on, side]
    return out.reshape(len(S), out.shape[1] * D)
