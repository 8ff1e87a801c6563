"""A rigid body: its shape, mass, state and surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..coerce import Matrix, Vector, as_real, as_vector
from ..errors import NotFiniteError, OptionError, ShapeError

_IDENTITY = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Sphere:
    """A ball; in a planar scene a disc with the mass properties of a ball."""

    radius: float

    def __post_init__(self) -> None:
        positive("radius", self.radius)

    @property
    def bounding_radius(self) -> float:
        """Radius of a ball around the centre of mass that holds the body."""
        return self.radius

    def corners_in(self, planar: bool) -> Matrix:
        """None."""
        return np.empty((0, 3))

    def inertia(self, mass: float) -> Vector:
        """Principal moments [kg m^2]."""
        return np.full(3, 0.4 * mass * self.radius**2)


@dataclass(frozen=True)
class Box:
    """A box with half extents along its own x, y, z [m]; in a planar scene the rectangle of x and z."""

    half: tuple[float, float, float]

    def __post_init__(self) -> None:
        for axis, extent in zip("xyz", self.half, strict=True):
            positive(f"half extent along {axis}", extent)

    @property
    def bounding_radius(self) -> float:
        """Radius of a ball around the centre of mass that holds the body."""
        return float(np.sqrt(sum(h * h for h in self.half)))

    def inertia(self, mass: float) -> Vector:
        """Principal moments [kg m^2]."""
        x, y, z = np.square(self.half)
        return mass / 3.0 * np.array([y + z, x + z, x + y])

    def corners_in(self, planar: bool) -> Matrix:
        """The eight corners (8, 3); in the plane four, counter-clockwise in x and z."""
        if planar:
            x, _, z = self.half
            return np.array([[-x, 0.0, -z], [x, 0.0, -z], [x, 0.0, z], [-x, 0.0, z]])
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
        return signs * self.half


@dataclass(frozen=True)
class Polygon:
    """A convex polygon in the x-z plane with its centroid at 0; planar scenes only. Made by `Polygon.around`."""

    corners: tuple[tuple[float, float], ...]

    @staticmethod
    def around(points: ArrayLike) -> tuple[Polygon, Vector]:
        """The polygon of `points` (m, 2), counter-clockwise and convex, and its centroid as a point (3,) with y = 0."""
        p = as_real("points", points)
        if p.ndim != 2 or p.shape[1] != 2 or len(p) < 3:
            raise ShapeError(f"points must have shape (m, 2) with m >= 3, got {p.shape}")
        edges = np.roll(p, -1, axis=0) - p
        turns = edges[:, 0] * np.roll(edges[:, 1], -1) - edges[:, 1] * np.roll(edges[:, 0], -1)
        if not (turns > 0).all():
            i = int(np.argmin(turns))
            raise OptionError(f"points must be convex and counter-clockwise, got a turn of {turns[i]:g} at points[{i}]")
        cross = p[:, 0] * np.roll(p[:, 1], -1) - p[:, 1] * np.roll(p[:, 0], -1)
        centre = ((p + np.roll(p, -1, axis=0)) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())
        local = p - centre
        return Polygon(tuple((float(x), float(z)) for x, z in local)), np.array([centre[0], 0.0, centre[1]])

    @property
    def bounding_radius(self) -> float:
        """Radius of a ball around the centre of mass that holds the body."""
        return float(np.sqrt(np.square(self.corners).sum(axis=1).max()))

    def corners_in(self, planar: bool) -> Matrix:
        """The corners (m, 3), counter-clockwise in x and z."""
        x, z = np.array(self.corners).T
        return np.stack([x, np.zeros(len(x)), z], axis=1)

    def inertia(self, mass: float) -> Vector:
        """The moment about y [kg m^2], three times: a planar scene uses no other."""
        p = np.array(self.corners)
        r = np.roll(p, -1, axis=0)
        cross = p[:, 0] * r[:, 1] - p[:, 1] * r[:, 0]
        second = (cross * (p * p + p * r + r * r).sum(axis=1)).sum() / (6.0 * cross.sum())
        return np.full(3, mass * float(second))


Shape = Sphere | Box | Polygon


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body as it is put into a `Scene`; the scene then owns the state.

    `mass` [kg] may be `inf`: the body never moves. `orientation` is a unit quaternion (w, x, y, z) from the body's axes
    to the world's; `inertia` [kg m^2] are the principal moments along the body's axes, by default those of the shape
    with uniform density. A contact has the geometric mean of two `friction` coefficients and the larger `restitution`.
    """

    shape: Shape
    mass: float
    position: Sequence[float] | Vector
    orientation: Sequence[float] | Vector = _IDENTITY
    velocity: Sequence[float] | Vector = (0.0, 0.0, 0.0)
    angular_velocity: Sequence[float] | Vector = (0.0, 0.0, 0.0)
    inertia: Sequence[float] | Vector | None = None
    friction: float = 0.5
    restitution: float = 0.0
    name: str = field(default="")

    def __post_init__(self) -> None:
        if not self.mass > 0:
            raise OptionError(f"mass must be strictly positive, got {self.mass}")
        surface(self.friction, self.restitution)
        for name, length in (("position", 3), ("orientation", 4), ("velocity", 3), ("angular_velocity", 3)):
            finite_vector(name, getattr(self, name), length)
        if np.isinf(self.mass) and (np.any(self.velocity) or np.any(self.angular_velocity)):
            raise OptionError("velocity and angular_velocity must be 0 where mass is inf: the body never moves")
        if self.inertia is not None and not (finite_vector("inertia", self.inertia, 3) > 0).all():
            raise OptionError(f"inertia must be strictly positive, got {list(self.inertia)}")

    @property
    def principal_inertia(self) -> Vector:
        """`inertia`, or that of the shape; infinite for a body that never moves."""
        if np.isinf(self.mass):
            return np.full(3, np.inf)
        return self.shape.inertia(self.mass) if self.inertia is None else np.asarray(self.inertia, float)


def positive(name: str, value: float) -> None:
    """Raises OptionError unless `value` is finite and > 0."""
    if not (value > 0 and np.isfinite(value)):
        raise OptionError(f"{name} must be strictly positive and finite, got {value}")


def surface(friction: float, restitution: float) -> None:
    """Raises OptionError unless both lie in their ranges."""
    if not (friction >= 0 and np.isfinite(friction)):
        raise OptionError(f"friction must be nonnegative and finite, got {friction}")
    if not 0 <= restitution <= 1:
        raise OptionError(f"restitution must lie in [0, 1], got {restitution}")


def finite_vector(name: str, value: ArrayLike, length: int) -> Vector:
    """`value` as a finite vector of that length; the error names the entry."""
    vector = as_vector(name, value)
    if len(vector) != length:
        raise ShapeError(f"{name} must have length {length}, got {len(vector)}")
    bad = np.flatnonzero(~np.isfinite(vector))
    if len(bad):
        raise NotFiniteError(f"{name} must be finite, got {name}[{bad[0]}] = {vector[bad[0]]}")
    return vector


def about_y(angle: float) -> tuple[float, float, float, float]:
    """The quaternion of a rotation in the x-z plane that turns x towards z by `angle` [rad]."""
    return (float(np.cos(angle / 2)), 0.0, -float(np.sin(angle / 2)), 0.0)
