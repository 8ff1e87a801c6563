"""A scene: bodies, planes, joints, and the state that time stepping changes."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ..coerce import Matrix, Vector
from ..errors import NotFiniteError, OptionError
from .body import Body, Box, Polygon, Sphere, finite_vector, surface
from .contact import WORLD, Indices
from .rotation import dot, rotate_back, rotations


@dataclass(frozen=True, eq=False)
class Plane:
    """The half space `normal . x >= offset` is free; the rest is the world's. The normal is made a unit vector."""

    normal: Sequence[float] | Vector = (0.0, 0.0, 1.0)
    offset: float = 0.0
    friction: float = 0.5
    restitution: float = 0.0

    def __post_init__(self) -> None:
        normal = finite_vector("normal", self.normal, 3)
        length = float(np.sqrt(normal @ normal))
        if length == 0:
            raise OptionError("normal must not be zero")
        object.__setattr__(self, "normal", normal / length)
        surface(self.friction, self.restitution)


@dataclass(frozen=True, eq=False)
class Joint:
    """A ball joint (a pin in the plane): a point of `bodies[0]` and one of `bodies[1]` stay together.

    `anchors` are the two points, each in its own body's axes; in the world's where the body is `WORLD` (-1). Three
    bilateral rows in space, two in the plane.
    """

    bodies: tuple[int, int]
    anchors: tuple[Sequence[float] | Vector, Sequence[float] | Vector]

    def __post_init__(self) -> None:
        for k in range(2):
            finite_vector(f"anchors[{k}]", self.anchors[k], 3)
        if self.bodies[0] < 0 or self.bodies[1] < WORLD or self.bodies[0] == self.bodies[1]:
            raise OptionError(f"bodies must be two different bodies, the second may be -1; got {self.bodies}")


class Scene:
    """Rigid bodies under gravity, with frictional contacts and joints.

    Parameters
    ----------
    bodies : iterable of Body
        Spheres alone, or boxes alone, or (planar) boxes and polygons: what `find_contacts` can collide.
    planes : sequence of Plane
        The ground, walls, an incline.
    joints : sequence of Joint
    gravity : (3,) [m/s^2]
    planar : bool
        Motion in the x-z plane: three degrees of freedom a body, and two friction facets, which are exact there.

    Attributes
    ----------
    position, velocity, angular_velocity : (n, 3)
        Of the centre of mass [m, m/s]; angular velocity in the world's axes [rad/s].
    orientation : (n, 4)
        Unit quaternions (w, x, y, z).
    mass : (n,) [kg], inertia : (n, 3) [kg m^2]
        `inf` where a body never moves; principal moments along the body's axes.
    still : (n,)
        Seconds for which a body has been slower than the threshold of sleep.
    time : float [s]

    The state arrays are the caller's to change between steps.
    """

    def __init__(
        self,
        bodies: Iterable[Body],
        planes: Sequence[Plane] = (Plane(),),
        joints: Sequence[Joint] = (),
        gravity: Sequence[float] = (0.0, 0.0, -9.81),
        planar: bool = False,
    ) -> None:
        self.bodies = tuple(bodies)
        self.planes = tuple(planes)
        self.joints = tuple(joints)
        self.planar = planar
        self.gravity = finite_vector("gravity", gravity, 3)
        n = len(self.bodies)
        for k, joint in enumerate(self.joints):
            if max(joint.bodies) >= n:
                raise OptionError(f"joints[{k}] names body {max(joint.bodies)}, but there are {n}")
        self.kind = self._kind()
        self.position = np.array([b.position for b in self.bodies], dtype=float).reshape(n, 3)
        self.orientation = np.array([b.orientation for b in self.bodies], dtype=float).reshape(n, 4)
        self.orientation /= np.sqrt(dot(self.orientation, self.orientation))[:, None]
        self.velocity = np.array([b.velocity for b in self.bodies], dtype=float).reshape(n, 3)
        self.angular_velocity = np.array([b.angular_velocity for b in self.bodies], dtype=float).reshape(n, 3)
        self.mass = np.array([b.mass for b in self.bodies], dtype=float)
        self.inertia = np.array([b.principal_inertia for b in self.bodies], dtype=float).reshape(n, 3)
        self.friction = np.array([b.friction for b in self.bodies], dtype=float)
        self.restitution = np.array([b.restitution for b in self.bodies], dtype=float)
        self.radius = np.array([b.shape.bounding_radius for b in self.bodies], dtype=float)
        self.corners, self.corner_count = self._corners()
        self.still = np.zeros(n)
        self.time = 0.0
        if planar:
            self._check_planar()

    def __len__(self) -> int:
        return len(self.bodies)

    def _kind(self) -> str:
        """ "sphere", "polygon" or "box": which collision test the scene needs."""
        spheres = [isinstance(b.shape, Sphere) for b in self.bodies]
        if all(spheres):
            return "sphere"
        if any(spheres):
            raise OptionError(f"bodies[{spheres.index(True)}] is a sphere among boxes: one scene holds one kind")
        if self.planar:
            return "polygon"
        for k, body in enumerate(self.bodies):
            if not isinstance(body.shape, Box):
                raise OptionError(f"bodies[{k}] is a {type(body.shape).__name__}: planar scenes only")
        return "box"

    def _corners(self) -> tuple[Matrix, Indices]:
        """Corners (n, m, 3) along each body's axes, the last repeated to fill m places, and how many there are."""
        corners = [b.shape.corners_in(self.planar) for b in self.bodies]
        count = np.array([len(c) for c in corners], dtype=np.intp)
        m = int(count.max(initial=0))
        padded = [np.concatenate([c, np.repeat(c[-1:], m - len(c), axis=0)]) for c in corners]
        return np.array(padded, dtype=float).reshape(len(corners), m, 3), count

    def _check_planar(self) -> None:
        for k in range(len(self)):
            spin, v = self.angular_velocity[k], self.velocity[k]
            x, z = self.orientation[k, [1, 3]]
            if v[1] or spin[0] or spin[2] or x or z:
                raise OptionError(f"bodies[{k}] leaves the x-z plane of a planar scene")
        for k, plane in enumerate(self.planes):
            if np.asarray(plane.normal)[1]:
                raise OptionError(f"planes[{k}] is not perpendicular to the x-z plane of a planar scene")
        if self.gravity[1]:
            raise OptionError(
                f"gravity must lie in the x-z plane of a planar scene, got gravity[1] = {self.gravity[1]}"
            )

    def check_finite(self) -> None:
        """Raises NotFiniteError where the state is NaN or inf."""
        for name in _STATE:
            bad = np.argwhere(~np.isfinite(getattr(self, name)))
            if len(bad):
                k = tuple(bad[0].tolist())
                raise NotFiniteError(f"{name} must be finite, got {name}{list(k)} = {getattr(self, name)[k]}")

    @property
    def dynamic(self) -> Indices:
        """Indices of the bodies that can move."""
        return np.flatnonzero(np.isfinite(self.mass))

    def copy(self) -> Scene:
        """The same scene with a state of its own."""
        other = copy.copy(self)
        for name in _STATE:
            setattr(other, name, getattr(self, name).copy())
        return other

    def subset(self, which: Sequence[int] | Indices, joints: Sequence[Joint] | None = None) -> Scene:
        """Those bodies in that order, in their present state, with the joints (or `joints`) among them or the world."""
        keep = np.asarray(which, dtype=np.intp)
        place = {int(k): i for i, k in enumerate(keep)} | {WORLD: WORLD}
        other = copy.copy(self)
        other.bodies = tuple(self.bodies[k] for k in keep)
        other.joints = tuple(
            Joint((place[j.bodies[0]], place[j.bodies[1]]), j.anchors)
            for j in (self.joints if joints is None else joints)
            if j.bodies[0] in place and j.bodies[1] in place
        )
        for name in (*_STATE, "mass", "inertia", "friction", "restitution", "radius", "corners", "corner_count"):
            setattr(other, name, getattr(self, name)[keep])
        return other

    def energy(self) -> float:
        """Kinetic and potential energy [J] of the bodies that can move; potential zero at the origin."""
        m = self.dynamic
        spin = rotate_back(rotations(self.orientation[m]), self.angular_velocity[m])
        kinetic = 0.5 * (self.mass[m] * dot(self.velocity[m], self.velocity[m])).sum()
        kinetic += 0.5 * dot(self.inertia[m] * spin, spin).sum()
        return float(kinetic - (self.mass[m] * (self.position[m] @ self.gravity)).sum())


_STATE = ("position", "orientation", "velocity", "angular_velocity", "still")

__all__ = ["Joint", "Plane", "Polygon", "Scene"]
