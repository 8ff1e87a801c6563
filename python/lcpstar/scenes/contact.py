"""Contacts: where two surfaces meet or may meet in this step."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..coerce import Matrix, Vector
from ..errors import OptionError
from .body import finite_vector, surface

Indices = NDArray[np.intp]

#: In the place of a body: the world, which never moves.
WORLD = -1


@dataclass(frozen=True, eq=False)
class Contact:
    """One contact point.

    `normal` is a unit vector from `bodies[1]` towards `bodies[0]`; `WORLD` (-1) may stand for the second. `gap` [m] is
    the distance along it, negative when the bodies penetrate. `feature` tells contacts of the same pair apart, so
    that the next step recognises them.
    """

    point: Sequence[float] | Vector
    normal: Sequence[float] | Vector
    bodies: tuple[int, int]
    gap: float = 0.0
    friction: float = 0.0
    restitution: float = 0.0
    feature: int = 0

    def __post_init__(self) -> None:
        finite_vector("point", self.point, 3)
        normal = finite_vector("normal", self.normal, 3)
        length = float(np.sqrt(normal @ normal))
        if not abs(length - 1) <= 1e-9:
            raise OptionError(f"normal must have length 1, got {length!r}")
        if self.bodies[0] < 0 or self.bodies[1] < WORLD or self.bodies[0] == self.bodies[1]:
            raise OptionError(f"bodies must be two different bodies, the second may be -1; got {self.bodies}")
        finite_vector("gap", [self.gap], 1)
        surface(self.friction, self.restitution)


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts as arrays over k: `bodies` (k, 2), `point` and `normal` (k, 3), the rest (k,). In order of bodies."""

    bodies: Indices
    point: Matrix
    normal: Matrix
    gap: Vector
    friction: Vector
    restitution: Vector
    feature: Indices

    @staticmethod
    def of(contacts: Iterable[Contact]) -> Contacts:
        """Arrays of the given contacts, sorted by bodies and feature."""
        items = list(contacts)
        return Contacts(
            np.array([c.bodies for c in items], dtype=np.intp).reshape(-1, 2),
            np.array([c.point for c in items], dtype=float).reshape(-1, 3),
            np.array([c.normal for c in items], dtype=float).reshape(-1, 3),
            np.array([c.gap for c in items], dtype=float),
            np.array([c.friction for c in items], dtype=float),
            np.array([c.restitution for c in items], dtype=float),
            np.array([c.feature for c in items], dtype=np.intp),
        ).ordered()

    @staticmethod
    def join(parts: Sequence[Contacts]) -> Contacts:
        """All contacts of the parts, sorted by bodies and feature: an order that other bodies do not change."""
        if not parts:
            return Contacts.of([])
        return Contacts(*(np.concatenate([getattr(p, name) for p in parts]) for name in _FIELDS)).ordered()

    def ordered(self) -> Contacts:
        """Sorted by first body, second body, feature."""
        return self.take(np.lexsort((self.feature, self.bodies[:, 1], self.bodies[:, 0])))

    def take(self, which: Indices | NDArray[np.bool_]) -> Contacts:
        """Those contacts."""
        return Contacts(*(getattr(self, name)[which] for name in _FIELDS))

    def __len__(self) -> int:
        return len(self.gap)

    def __getitem__(self, k: int) -> Contact:
        return Contact(
            self.point[k],
            self.normal[k],
            (int(self.bodies[k, 0]), int(self.bodies[k, 1])),
            float(self.gap[k]),
            float(self.friction[k]),
            float(self.restitution[k]),
            int(self.feature[k]),
        )

    def identity(self) -> NDArray[np.int64]:
        """A number per contact that stays the same while the same features touch."""
        first, second = self.bodies[:, 0].astype(np.int64), self.bodies[:, 1].astype(np.int64)
        return (first << 40) + ((second + 1) << 16) + self.feature


_FIELDS = ("bodies", "point", "normal", "gap", "friction", "restitution", "feature")
