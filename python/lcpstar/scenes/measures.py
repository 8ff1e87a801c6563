"""What an answer is worth in the scene: errors with units, measured from impulses and velocities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..coerce import Matrix, Vector
from .assembly import Island, System
from .rotation import dot


@dataclass(frozen=True)
class PhysicalErrors:
    """The largest error of a step over its contacts; 0 is perfect.

    penetration [m]: how deep bodies overlap when the step begins.
    penetration_velocity [m/s]: by how much the new normal velocity falls short of the bound `w_n >= 0`.
    cone_violation [N s]: tangential impulse beyond the friction coefficient times the normal impulse (Euclidean).
    signorini [J]: `|c_n w_n|`, impulse at a contact that opens.
    dissipation [J]: `mu c_n |v_t| + p_t . v_t`, friction that takes less than it could; facets leave some in space.
    joint_velocity [m/s]: by how much joints miss their velocity.
    """

    penetration: float
    penetration_velocity: float
    cone_violation: float
    signorini: float
    dissipation: float
    joint_velocity: float


def physical_errors(system: System, solved: Sequence[tuple[Island, Vector]], u: Matrix) -> PhysicalErrors:
    """Errors of the answers z, measured at the velocities u that came out of them."""
    contacts, T = system.contacts, system.T
    c, t = system.impulses(solved)
    p = t.reshape(-1, T)
    awake = np.zeros(len(contacts), dtype=bool)
    for island, _ in solved:
        awake[island.contacts] = True
    w = system.normals.times(u) + system.b
    sliding = system.tangents.times(u).reshape(-1, T)
    speed, force = np.sqrt(dot(sliding, sliding)), np.sqrt(dot(p, p))
    limit = contacts.friction * c
    lost = limit * speed + dot(p, sliding)
    missed = np.abs(system.joints.times(u))
    return PhysicalErrors(
        _largest(-contacts.gap),
        _largest(-w[awake]),
        _largest(force - limit),
        _largest(np.abs(c * w)),
        _largest(lost[contacts.friction > 0]),
        _largest(missed),
    )


def _largest(values: Vector) -> float:
    return float(np.max(values, initial=0.0)) + 0.0  # never -0
