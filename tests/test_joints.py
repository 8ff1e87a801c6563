"""Joints: rows that hold bodies together, eliminated from the LCPs of their islands."""

from __future__ import annotations

import numpy as np
import pytest

from lcpstar import scenes
from lcpstar.scenes import Body, Box, Contact, Contacts, Joint, Scene
from scene_checks import G, momentum, rotation, world_inertia


def test_a_pendulum_keeps_its_length_and_its_period():
    """A small swing of a single link: period 2 pi sqrt(I / (m g l)) about the pivot."""
    scene = scenes.chain(1, length=1.0, angle=0.05)
    history = scenes.run(scene, 260, dt=0.002)
    assert history.joint_velocity.max() < 1e-12
    x = history.position[:, 0, 0]
    crossings = np.flatnonzero((x[:-1] > 0) & (x[1:] <= 0))
    inertia = scene.inertia[0, 1] + 0.25
    assert np.isclose(crossings[0] * 0.002 * 4, 2 * np.pi * np.sqrt(inertia / (0.5 * G)), rtol=0.01)
    top = scene.position[0] - 0.5 * (rotation(scene.orientation[0]) @ [0, 0, -1.0])
    assert np.abs(top - [0, 0, 1.2]).max() < 1e-4


def test_redundant_joints_do_not_matter():
    once = scenes.chain(3, height=0.5, angle=1.0)
    twice = Scene(once.bodies, once.planes, [*once.joints, *once.joints], planar=True)
    scenes.run(once, 50)
    scenes.run(twice, 50)
    assert np.abs(once.position - twice.position).max() < 1e-9


# Closed joints --------------------------------------------------------------------------------------------------------


def apart(scene):
    """How far anchors are apart, by Rodrigues' formula."""
    ends = [
        [a if k < 0 else scene.position[k] + rotation(scene.orientation[k]) @ a for k, a in zip(*joint, strict=True)]
        for joint in ((j.bodies, j.anchors) for j in scene.joints)
    ]
    return max(np.linalg.norm(one - other) for one, other in ends)


@pytest.mark.parametrize("mass_ratio", [1e-2, 1.0, 100.0, 1e4])
@pytest.mark.parametrize(("links", "length"), [(1, 0.2), (3, 0.01), (3, 2.0), (10, 0.2)])
def test_a_chain_does_not_fall_off_its_joints(links, length, mass_ratio):
    scene = scenes.chain(links, mass_ratio, length)
    history = scenes.run(scene, 150)
    assert history.solved.all()
    assert history.joint_error.max() < 1e-3 * length
    assert np.isclose(history.joint_error[-1], apart(scene), rtol=0, atol=1e-12 * links * length)
    weight = scene.mass.sum() * G * links * length
    assert history.energy_drift.max() < 0.01 * weight


@pytest.mark.parametrize("mass_ratio", [1.0, 1e4, 1e6])
@pytest.mark.parametrize(("height", "angle", "strikes"), [(1.0, 1.2, True), (2.4, 1.5, False)])
def test_a_chain_that_whips_or_strikes_the_ground_stays_closed(height, angle, strikes, mass_ratio):
    scene = scenes.chain(8, mass_ratio, height=height, angle=angle)
    history = scenes.run(scene, 100)
    assert history.rows.max() > 0 or not strikes
    assert history.solved.all()
    assert history.joint_error.max() < 1e-3
    assert history.joint_velocity.max() < 1e-7
    assert history.penetration.max() < (0.01 if mass_ratio <= 1e4 else 0.05)


@pytest.mark.parametrize("mass_ratio", [1.0, 1e3])
def test_jointed_bodies_in_free_space_keep_their_momentum(mass_ratio):
    rng = np.random.default_rng(5)
    bodies = [Body(Box((0.1, 0.2, 0.3)), m, (k, 0, 0)) for k, m in enumerate((1.0, 2.0, mass_ratio))]
    joints = [Joint((k, k + 1), ((0.5, 0, 0), (-0.5, 0, 0))) for k in range(2)]
    scene = Scene(bodies, (), joints, gravity=(0, 0, 0))
    scene.velocity[:] = rng.normal(size=(3, 3))
    scene.angular_velocity[:] = rng.normal(size=(3, 3))
    before, centre = momentum(scene), scene.mass @ scene.position
    history = scenes.run(scene, 200)
    after = momentum(scene)
    assert np.abs(after - before)[:3].max() < 1e-11 * mass_ratio
    assert np.abs(scene.mass @ scene.position - centre - 2.0 * before[:3]).max() < 1e-10 * mass_ratio
    assert np.linalg.norm(after[3:] - before[3:]) < 0.05 * np.linalg.norm(before[3:])
    assert history.joint_error.max() < 1e-12
    assert history.energy_drift.max() < 1e-3 * history.initial_energy


def test_anchors_that_begin_apart_are_joined_without_a_kick():
    scene = scenes.chain(3)
    scene.position[1, 0] += 0.05
    history = scenes.run(scene, 1)
    assert history.joint_error[0] < 1e-12
    assert np.abs(scene.velocity).max() < 2 * G * 0.01


def test_joints_that_cannot_be_closed_are_reported():
    """A bar of 1 m between two points of the world 3 m apart."""
    bar = Body(Box((0.5, 0.1, 0.1)), 1.0, (0, 0, 0))
    joints = [Joint((0, -1), ((0.5 * side, 0, 0), (1.5 * side, 0, 0.3))) for side in (1, -1)]
    scene = Scene([bar], (), joints, planar=True)
    history = scenes.run(scene, 10)
    assert history.joint_error.min() >= 1.0 - 1e-9
    assert history.joint_error[-1] < 1.1
    assert np.abs(scene.velocity).max() < 1.0


# A against the whole scene's KKT system -------------------------------------------------------------------------------


def jointed_at(bodies, pair, point):
    """A joint of the pair at a point of the world."""
    ends = [
        point if k < 0 else rotation(np.array(bodies[k].orientation)).T @ (point - bodies[k].position) for k in pair
    ]
    return Joint(pair, tuple(ends))


def rows_of(scene, pairs, points, directions):
    """Rows over the bodies' (v, omega) in the world's axes: relative velocities along the directions."""
    J = np.zeros((len(pairs), len(scene), 6))
    for row, (pair, point, direction) in enumerate(zip(pairs, points, directions, strict=True)):
        for sign, k in zip((1.0, -1.0), pair, strict=True):
            if k >= 0:
                J[row, k] += sign * np.concatenate([direction, np.cross(point - scene.position[k], direction)])
    J = J[:, :, [0, 2, 4]] if scene.planar else J
    return J.reshape(len(pairs), len(scene) * J.shape[2])


def inverse_mass(scene):
    D = 3 if scene.planar else 6
    inverse = np.zeros((len(scene), D, len(scene), D))
    for k in np.flatnonzero(np.isfinite(scene.mass)):
        full = np.zeros((6, 6))
        full[:3, :3] = np.eye(3) / scene.mass[k]
        full[3:, 3:] = np.linalg.inv(world_inertia(scene, k))
        inverse[k, :, k] = full[np.ix_([0, 2, 4], [0, 2, 4])] if scene.planar else full
    return inverse.reshape(len(scene) * D, -1)


def random_scene(seed, planar):
    """Bodies, some jointed, some static; contacts anywhere, some without friction."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 9))
    flat = np.array([1.0, 0.0 if planar else 1.0, 1.0])
    bodies = [
        Body(
            Box(tuple(rng.uniform(0.1, 1.0, 3))),
            np.inf if rng.random() < 0.15 else 10 ** rng.uniform(-1, 2),
            rng.normal(size=3) * flat,
            scenes.about_y(rng.normal()) if planar else rng.normal(size=4),
        )
        for _ in range(n)
    ]
    for body in bodies:
        object.__setattr__(body, "orientation", np.array(body.orientation) / np.linalg.norm(body.orientation))
    pairs = [(i, j) for i in range(n) for j in range(-1, n) if i != j]
    joints = [
        jointed_at(bodies, pairs[k], rng.normal(size=3) * flat) for k in rng.integers(len(pairs), size=rng.integers(n))
    ]
    scene = Scene(bodies, (), joints, planar=planar)
    scene.velocity[:] = rng.normal(size=(n, 3)) * flat * np.isfinite(scene.mass)[:, None]
    contacts = []
    for k in rng.integers(len(pairs), size=rng.integers(1, 2 * n)):
        normal = rng.normal(size=3) * flat
        contacts.append(
            Contact(
                rng.normal(size=3) * flat,
                normal / np.linalg.norm(normal),
                pairs[k],
                gap=rng.uniform(0, 0.1),
                friction=rng.choice([0.0, 0.5]),
                feature=len(contacts),
            )
        )
    return scene, Contacts.of(contacts)


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("seed", range(60))
def test_the_matrix_is_the_schur_complement_of_the_joints(seed, planar):
    """`J M^-1 J'` less what the joints take, `u_f` less what they forbid: by NumPy on the whole scene at once."""
    scene, contacts = random_scene(seed, planar)
    dt, inverse = 0.01, inverse_mass(scene)
    axes = np.eye(3)[[0, 2]] if planar else np.eye(3)
    at = [j.anchors[0] @ rotation(scene.orientation[j.bodies[0]]).T + scene.position[j.bodies[0]] for j in scene.joints]
    G = rows_of(
        scene,
        [j.bodies for j in scene.joints for _ in axes],
        [p for p in at for _ in axes],
        [d for _ in scene.joints for d in axes],
    )
    K = inverse @ G.T @ np.linalg.pinv(G @ inverse @ G.T, rcond=1e-12, hermitian=True)
    moves = np.isfinite(scene.mass)[:, None]
    v = np.where(moves, scene.velocity + dt * scene.gravity, scene.velocity)
    u = np.concatenate([v, np.zeros_like(v)], axis=1)[:, [0, 2, 4] if planar else slice(None)].ravel()
    u = u - K @ (G @ u)
    found = 0
    for island in scenes.lcps(scene, dt, contacts=contacts, reach=1e9):
        which = [*island.contacts]
        directions = [contacts.normal[c] for c in which]
        for c in island.contacts[island.rubbing]:
            n = contacts.normal[c]
            if planar:
                basis = [np.array([n[2], 0.0, -n[0]])]
            else:
                t = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
                basis = [t / np.linalg.norm(t), np.cross(n, t / np.linalg.norm(t))]
            which += [c] * len(island.directions)
            directions += list(island.directions @ basis)
        J = rows_of(scene, contacts.bodies[which], contacts.point[which], directions)
        A = J @ inverse @ J.T - J @ K @ (G @ inverse @ J.T)
        q = J @ u
        q[: len(island.contacts)] += contacts.gap[island.contacts] / dt
        k = len(which)
        assert np.abs(island.A[:k, :k] - A).max() < 1e-9 * np.abs(J @ inverse @ J.T).max()
        assert np.abs(island.q[:k] - q).max() < 1e-9 * (1 + np.abs(q).max())
        found += len(island.contacts)
    touches = (contacts.bodies >= 0) & np.isfinite(scene.mass)[contacts.bodies]
    assert found == touches.any(axis=1).sum()


def test_a_box_on_a_pinned_plank():
    """The plank turns about its pin, the box is free: `A = 1 / m + r^2 / I`."""
    plank = Body(Box((1.0, 0.5, 0.05)), 4.0, (0.0, 0.0, 1.0), friction=0.0)
    boxes = [Body(Box((0.1, 0.5, 0.1)), 1.0, (x, 0.0, 1.15), friction=0.0) for x in (0.5, -0.5)]
    pin = Joint((0, -1), ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    contacts = [Contact((x, 0.0, 1.05), (0.0, 0.0, 1.0), (k, 0)) for k, x in ((1, 0.5), (2, -0.5))]
    moment = 4.0 / 3 * (1.0 + 0.05**2)
    (island,) = scenes.lcps(Scene([plank, *boxes], (), [pin], planar=True), contacts=Contacts.of(contacts))
    r = 0.5**2 / moment
    assert np.allclose(island.A, [[1 + r, -r], [-r, 1 + r]], rtol=1e-12)
