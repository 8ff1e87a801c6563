"""Unit quaternions (w, x, y, z) by arithmetic alone: no sine, so that array lengths do not change a bit."""

from __future__ import annotations

import numpy as np

from ..coerce import Matrix, Vector


def cross(a: Matrix, b: Matrix) -> Matrix:
    """Cross products of the rows."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    out[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    out[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return out


def dot(a: Matrix, b: Matrix) -> Vector:
    """Inner products of the rows, summed from the left."""
    total = a[..., 0] * b[..., 0]
    for i in range(1, a.shape[-1]):
        total = total + a[..., i] * b[..., i]
    return np.asarray(total)


def rotations(quaternion: Matrix) -> Matrix:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4)."""
    w, x, y, z = quaternion[:, 0], quaternion[:, 1], quaternion[:, 2], quaternion[:, 3]
    R = np.empty((len(quaternion), 3, 3))
    R[:, 0, 0], R[:, 1, 1], R[:, 2, 2] = 1 - 2 * (y * y + z * z), 1 - 2 * (x * x + z * z), 1 - 2 * (x * x + y * y)
    R[:, 0, 1], R[:, 1, 0] = 2 * (x * y - w * z), 2 * (x * y + w * z)
    R[:, 0, 2], R[:, 2, 0] = 2 * (x * z + w * y), 2 * (x * z - w * y)
    R[:, 1, 2], R[:, 2, 1] = 2 * (y * z - w * x), 2 * (y * z + w * x)
    return R


def rotate(R: Matrix, v: Matrix) -> Matrix:
    """`R v` for each row."""
    return R[..., :, 0] * v[..., 0:1] + R[..., :, 1] * v[..., 1:2] + R[..., :, 2] * v[..., 2:3]


def rotate_back(R: Matrix, v: Matrix) -> Matrix:
    """`R' v` for each row."""
    return R[..., 0, :] * v[..., 0:1] + R[..., 1, :] * v[..., 1:2] + R[..., 2, :] * v[..., 2:3]


def turn(quaternion: Matrix, angular_velocity: Matrix, dt: float) -> Matrix:
    """Orientation after `dt`: the Cayley map, `(1, dt omega / 2) q` made a unit quaternion again."""
    w, x, y, z = quaternion[:, 0], quaternion[:, 1], quaternion[:, 2], quaternion[:, 3]
    half = 0.5 * dt * angular_velocity
    a, b, c = half[:, 0], half[:, 1], half[:, 2]
    out = np.stack(
        [w - a * x - b * y - c * z, x + a * w + b * z - c * y, y + b * w + c * x - a * z, z + c * w + a * y - b * x],
        axis=1,
    )
    return np.asarray(out / np.sqrt(dot(out, out))[:, None])


#: Sweeps of `free_spin`: enough where a body turns by less than a radian in a step.
_SWEEPS = 30
#: A body is done when a sweep changes its energy's square root by less than this, squared, of it.
_SETTLED = 1e-30


def free_spin(inertia: Matrix, spin: Matrix, dt: float) -> Matrix:
    """Angular velocities (n, 3) after `dt` without torque, in the bodies' principal axes.

    Solves `I (v - w) = -dt/2 v x (I v + I w)` for v: with `turn(orientation, v, dt)` the angular momentum in the world
    stays what it was, and `v'I v = v'I w` keeps the energy from growing. A sweep solves, in closed form, the linear
    equation in v that has the last v in the bracket; the energy bound holds after any number of sweeps.
    """
    out = spin.copy()
    inertia = np.where(np.isfinite(inertia), inertia, 0.0)  # bodies that never move
    at = np.flatnonzero((cross(inertia * spin, spin) != 0).any(axis=1))
    moments = inertia[at] / inertia[at].max(axis=1, initial=0.0)[:, None]
    root = np.sqrt(moments)
    push = 0.5 * dt * moments / (root[:, 0] * root[:, 1] * root[:, 2])[:, None]
    start = root * spin[at]  # the energy is half the square of its length
    now = start
    for _ in range(_SWEEPS):
        a = push * (now + start)
        new = (start + cross(a, start) + a * dot(a, start)[:, None]) / (1 + dot(a, a))[:, None]
        out[at] = new / root
        moves = dot(new - now, new - now) > _SETTLED * dot(start, start)
        if not moves.any():
            break
        at, root, push, start, now = at[moves], root[moves], push[moves], start[moves], new[moves]
    return out
