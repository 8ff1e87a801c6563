"""A contact scene becomes the LCPs that it needs: one per island, idle contacts left out, joints eliminated.

With velocities u, free velocity `u_f = u + dt M^-1 (forces)`, rows J and impulses p, `u_new = u_f + M^-1 J' p`:

    normals    w_n = N u_new + b >= 0,          c_n >= 0
    facets     w_d = D u_new + lambda e >= 0,   d >= 0
    sliding    w_s = mu c_n - e'd >= 0,         lambda >= 0

each pair complementary: w = A z + q in z = (c_n, d, lambda). [ST96], [AP97]. `b = gap / dt` where there is a gap, a
fraction of it where bodies penetrate, and `b = restitution * (approach velocity)` where a bounce asks for more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..coerce import Matrix, Vector
from .contact import WORLD, Contacts, Indices
from .friction import facet_directions, on_facets, with_sliding_speeds
from .islands import islands
from .joints import Projector, dense_rows, joint_rows
from .rotation import free_spin
from .rows import Masses, Rows, contact_rows
from .scene import Scene


@dataclass(frozen=True)
class Stepping:
    """How a step of `dt` seconds is put into numbers.

    `facets` of the friction cone (in space; the plane needs two). `stabilisation`: the fraction of a penetration that
    one step takes back. `bounce_speed` [m/s]: slower contacts do not bounce. `reach`:
    contacts that would part faster than `reach * dt * |g|` without impulses are left out at first, and put back if
    they act.
    """

    dt: float
    facets: int = 4
    stabilisation: float = 0.2
    bounce_speed: float = 0.1
    reach: float = 10.0


@dataclass(frozen=True, eq=False)
class Island:
    """One LCP(q, A): `bodies` and `contacts` are indices into the scene and its contacts.

    z holds the normal impulses of all contacts [N s], then `facets` tangential impulses and at the end one sliding
    speed [m/s] for each contact `rubbing` (positions within `contacts`) that has friction. `joints` are the scene's.
    """

    bodies: Indices
    contacts: Indices
    rubbing: Indices
    joints: Indices
    A: Matrix
    q: Vector
    directions: Matrix

    def impulses(self, z: Vector) -> tuple[Vector, Matrix]:
        """Normal impulses (k,) and tangential impulses (rubbing, T) in the tangent basis."""
        k, m, f = len(self.contacts), len(self.rubbing), len(self.directions)
        d = z[k : k + m * f].reshape(m, f)
        tangential = d[:, 0:1] * self.directions[0]
        for facet in range(1, f):
            tangential = tangential + d[:, facet : facet + 1] * self.directions[facet]
        return z[:k], tangential


_EPS = float(np.finfo(float).eps)


class System:
    """A scene and its contacts at one moment: rows, free velocity, and from them islands and velocities.

    Assembly costs O(sum over bodies of (rows on the body)^2), one NumPy pass for all islands; an island of n rows holds
    its A densely, and with m joint rows adds a singular value decomposition, O(m^2 (m + bodies)).
    """

    def __init__(self, scene: Scene, contacts: Contacts, settings: Stepping, error: Matrix | None = None) -> None:
        """`error` (n, D): bounds of the rounding errors in the scene's velocities, from `System.rounding`."""
        self.scene, self.contacts, self.settings = scene, contacts, settings
        self.masses = Masses(scene)
        self.normals, self.tangents = contact_rows(scene, self.masses, contacts)
        self.directions = facet_directions(settings.facets, scene.planar)
        self.T = self.directions.shape[1]
        self.joints, _ = joint_rows(scene, self.masses)
        self.jointed = np.zeros(len(scene), dtype=bool)
        self.jointed[self.joints.bodies[self.joints.bodies >= 0]] = True
        self.per_joint = 2 if scene.planar else 3
        self.u = self.masses.pack(scene.velocity, scene.angular_velocity)
        self.free = self._free_velocity()
        self._projectors: dict[bytes, Projector] = {}
        self.b = self._targets()
        self.error = np.zeros_like(self.u) if error is None else error
        self.at_rest = self._without_noise(self.normals, self.free, self.b)  # w_n without impulses

    def _free_velocity(self) -> Matrix:
        scene, dt = self.scene, self.settings.dt
        velocity = scene.velocity + dt * scene.gravity
        free = self.masses.pack(velocity, scene.angular_velocity)
        if not scene.planar:
            free[:, 3:] = free_spin(scene.inertia, free[:, 3:], dt)
        moves = self.masses.movable[:, None]
        return np.where(moves, free, 0.0)

    def _targets(self) -> Vector:
        gap, settings = self.contacts.gap, self.settings
        b = np.where(gap > 0, gap, settings.stabilisation * gap) / settings.dt
        before, after = self.normals.times(self.u), self.normals.times(self.free)
        arrives = gap + settings.dt * after < 0
        bounces = (self.contacts.restitution > 0) & (before < -settings.bounce_speed) & arrives
        # forces act during the bounce, too: without `after - before` it would gain energy of first order in dt
        return np.where(bounces, np.minimum(b, self.contacts.restitution * before - (after - before)), b)

    def _without_noise(self, rows: Rows, u: Matrix, b: Vector) -> Vector:
        """`J u + b`, 0 where it is below the rounding errors of the last step's velocities and of the gaps.

        Redundant contacts take noise for motion: every step would look for another basis.
        """
        value = rows.times(u) + b
        size = np.abs(self.scene.position).max(axis=1, initial=0.0) + self.scene.radius
        of_gap = 8 * _EPS * np.where(rows.bodies >= 0, size[rows.bodies], 0.0).sum(axis=1) / self.settings.dt
        noise = rows.rounding_times(self.error) + of_gap
        return np.where(np.abs(value) <= noise, 0.0, value)

    def may_act(self) -> NDArray[np.bool_]:
        """Contacts that are not left out at first."""
        g = float(np.sqrt(self.scene.gravity @ self.scene.gravity))
        return np.asarray(self.at_rest <= self.settings.reach * self.settings.dt * g)

    def island_of(self, included: NDArray[np.bool_]) -> Indices:
        """The island of each body under the included contacts and the joints; -1 for bodies that never move."""
        jointed = np.array([j.bodies for j in self.scene.joints], dtype=np.intp).reshape(-1, 2)
        return islands(np.concatenate([self.contacts.bodies[included], jointed]), self.masses.movable)

    def islands(self, included: NDArray[np.bool_], home: Indices, which: Sequence[int]) -> list[Island]:
        """The LCPs of the islands `which` (values of `home`, from `island_of`), in that order."""
        label = np.full(len(self.scene), -1, dtype=np.intp)
        label[np.asarray(which, dtype=np.intp)] = np.arange(len(which))
        position = np.append(np.where(home >= 0, label[home], -1), -1)  # the last place is the world's
        of_contact = _owner(position, self.normals.bodies)
        of_contact = np.where(included, of_contact, -1)
        of_joint = _owner(position, self.joints.bodies)[:: self.per_joint]
        contacts = _grouped(of_contact, len(which))
        joints = _grouped(of_joint, len(which))
        bodies = _grouped(position[:-1], len(which))
        rough = self.contacts.friction > 0
        rows, rubbings = [], []
        for c in contacts:
            rubbing = np.flatnonzero(rough[c])
            tangents = (self.T * c[rubbing][:, None] + np.arange(self.T)).ravel()
            rows.append(np.concatenate([c, len(self.contacts) + tangents]))
            rubbings.append(rubbing)
        bases = self._products(rows, joints)
        result = []
        for k in range(len(which)):
            B, drift = bases[k]
            result.append(self._island(bodies[k], contacts[k], rubbings[k], joints[k], B, drift))
        return result

    def _island(
        self, bodies: Indices, contacts: Indices, rubbing: Indices, joints: Indices, B: Matrix, drift: Vector
    ) -> Island:
        """`B` and `drift` over (normals, tangents); the LCP over (normals, facets, sliding speeds)."""
        k, m = len(contacts), len(rubbing)
        if m:
            facets = len(self.directions)
            B = on_facets(B, k, self.directions)
            tangential = drift[k:].reshape(m, self.T)
            along = tangential[:, None, 0] * self.directions[:, 0]
            for t in range(1, self.T):
                along = along + tangential[:, None, t] * self.directions[:, t]
            drift = np.concatenate([drift[:k], along.ravel(), np.zeros(m)])
            B = with_sliding_speeds(B, k, rubbing, self.contacts.friction[contacts[rubbing]], facets)
        return Island(bodies, contacts, rubbing, joints, B, drift, self.directions)

    def _products(self, rows: list[Indices], joints: list[Indices]) -> list[tuple[Matrix, Vector]]:
        """`S S'` and `J u_f + b` of each island over its rows, the joints eliminated.

        `S = (S_f, S_j)` by the columns of free and of jointed bodies: joints project `S_j` and leave `S_f S_f'`.
        """
        flat = np.concatenate([*rows, np.empty(0, np.intp)]).astype(np.intp)
        bodies = np.concatenate([self.normals.bodies, self.tangents.bodies])[flat]
        J = np.concatenate([self.normals.J, self.tangents.J])[flat]
        S = J * self.masses.root[bodies]  # rows on the world are zero
        b = np.concatenate([self.b, np.zeros(len(self.tangents.J))])[flat]
        drift = self._without_noise(Rows(bodies, J), self.free, b)
        ends = np.concatenate([[0], np.cumsum([len(r) for r in rows])]).astype(np.intp)
        free = np.where((bodies >= 0) & self.jointed[bodies], WORLD, bodies)
        gram = _gram(free, S, ends)
        result = []
        for k in range(len(rows)):
            part = slice(int(ends[k]), int(ends[k + 1]))
            if len(joints[k]):
                P, u = self._jointed(bodies[part], S[part], joints[k])
                A = P @ P.T
                result.append((gram[k] + (A + A.T) / 2, self._without_noise(Rows(bodies[part], J[part]), u, b[part])))
            else:
                result.append((gram[k], drift[part]))
        return result

    def _jointed(self, bodies: Indices, S: Matrix, joints: Indices) -> tuple[Matrix, Matrix]:
        """`S_j`, dense and projected onto the motions that the joints allow, and the velocity without contacts.

        With the joint rows G: `S_j (I - G'(G G')^+ G) S_j'` is the Schur complement of the joints' block.
        """
        projector = self._projector(joints)
        dense = dense_rows(bodies, S, projector.places)
        V = projector.V
        return dense - (dense @ V.T) @ V, projector.velocity(self.free)

    def _projector(self, joints: Indices) -> Projector:
        key = joints.tobytes()
        if key not in self._projectors:
            picked = (self.per_joint * joints[:, None] + np.arange(self.per_joint)).ravel()
            self._projectors[key] = Projector(Rows(self.joints.bodies[picked], self.joints.J[picked]), self.masses)
        return self._projectors[key]

    def rounding(self, solved: Sequence[tuple[Island, Vector]]) -> Matrix:
        """Bounds (n, D) of the rounding errors in `velocity`.

        The largest `32 eps (|u_f| + M^-1 |J|' |p|)` of the island, speeds and spins apart: contacts tie heavy bodies to
        light ones, whose errors are larger.
        """
        c, t = self.impulses(solved)
        n = len(self.scene)
        push = Rows(self.normals.bodies, np.abs(self.normals.J)).transposed_times(np.abs(c), n)
        push += Rows(self.tangents.bodies, np.abs(self.tangents.J)).transposed_times(np.abs(t), n)
        error = 32 * _EPS * (np.abs(self.free) + self.masses.inverse * push)
        speeds = self.u.shape[1] - (1 if self.scene.planar else 3)
        for island, _ in solved:
            if len(island.contacts):
                own = error[island.bodies]
                error[island.bodies, :speeds] = own[:, :speeds].max()
                error[island.bodies, speeds:] = own[:, speeds:].max()
        return np.asarray(error)

    def impulses(self, solved: Sequence[tuple[Island, Vector]]) -> tuple[Vector, Vector]:
        """Impulses along all normals, and along all tangents."""
        c = np.zeros(len(self.contacts))
        t = np.zeros((len(self.contacts), self.T))
        for island, z in solved:
            c[island.contacts], t[island.contacts[island.rubbing]] = island.impulses(z)
        return c, t.ravel()

    def velocity(self, solved: Sequence[tuple[Island, Vector]]) -> Matrix:
        """New velocities u (n, D) from the answers z of the islands; bodies of no island keep their free velocity."""
        c, t = self.impulses(solved)
        n = len(self.scene)
        push = self.normals.transposed_times(c, n) + self.tangents.transposed_times(t, n)
        u = self.free + self.masses.inverse * push
        for island, _ in solved:
            if len(island.joints):
                projector = self._projector(island.joints)
                u[projector.bodies] = projector.velocity(u)[projector.bodies]
        return u


def _gram(bodies: Indices, S: Matrix, ends: Indices) -> list[Matrix]:
    """`S S'` of each island: only rows that share a body meet. Same bits whoever else is there."""
    row = np.repeat(np.arange(len(S)), 2)
    body = bodies.ravel()
    entries = S.reshape(-1, S.shape[2])
    on = np.flatnonzero(body >= 0)
    order = on[np.argsort(body[on], kind="stable")]
    row, entries = row[order], entries[order]
    count = np.bincount(body[order]) if len(order) else np.empty(0, np.intp)
    count = count[count > 0]
    first = np.repeat(np.cumsum(count) - count, count)
    size = np.repeat(count, count)
    left = np.repeat(np.arange(len(row)), size)
    right = np.repeat(first, size) + np.arange(len(left)) - np.repeat(np.cumsum(size) - size, size)
    value = entries[left, 0] * entries[right, 0]
    for d in range(1, entries.shape[1]):
        value += entries[left, d] * entries[right, d]
    n = np.diff(ends)
    starts = np.concatenate([[0], np.cumsum(n * n)])
    home = np.repeat(np.arange(len(n)), n)
    at = home[row[left]]
    where = starts[at] + (row[left] - ends[at]) * n[at] + row[right] - ends[at]
    flat = np.bincount(where, value, minlength=int(starts[-1])).astype(np.float64)
    return [flat[starts[k] : starts[k + 1]].reshape(int(m), int(m)) for k, m in enumerate(n)]


def _owner(position: Indices, bodies: Indices) -> Indices:
    """The island of each row: that of its first body that can move."""
    first, second = position[bodies[:, 0]], position[bodies[:, 1]]
    return np.where(bodies[:, 0] >= 0, first, np.where(bodies[:, 1] >= 0, second, -1))


def _grouped(label: Indices, groups: int) -> list[Indices]:
    """Positions of each label 0..groups, ascending."""
    order = np.argsort(label, kind="stable")
    bounds = np.searchsorted(label[order], np.arange(groups + 1))
    return [order[bounds[k] : bounds[k + 1]] for k in range(groups)]
