"""Scenes: mechanics that can be checked by hand, and the LCPs behind it."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import numpy as np
import pytest

from lcp_checks import assert_solves
from lcpstar import errors, scenes, solve
from lcpstar.scenes import Body, Box, Contact, Contacts, Joint, Plane, Polygon, Scene, Sphere
from lcpstar.scenes.neighbours import near_pairs

G = 9.81

SCENES = {
    "box_stack": lambda: scenes.box_stack(4, mass_ratio=100.0),
    "box_stack_space": lambda: scenes.box_stack(3, mass_ratio=100.0, planar=False),
    "heavy_on_light": lambda: scenes.heavy_on_light(10, mass_ratio=1e6),
    "heavy_on_light_1e8": lambda: scenes.heavy_on_light(6, mass_ratio=1e8),
    "pyramid_wall": lambda: scenes.pyramid_wall(4),
    "arch": lambda: scenes.arch(9, 0.2),
    "card_house": lambda: scenes.card_house(2),
    "chain": lambda: scenes.chain(6, height=0.7, angle=1.2),
    "sphere_pile": lambda: scenes.sphere_pile(20, friction=0.3),
    "discs": lambda: scenes.sphere_pile(20, friction=0.3, planar=True),
    "incline": lambda: scenes.incline(0.4),
}


def kicked(scene: Scene, seed: int, speed: float = 0.3) -> Scene:
    """The scene with random velocities, by body, so that a subset is kicked alike."""
    rng = np.random.default_rng(seed)
    scene.velocity[:, 0] += rng.uniform(-speed, speed, len(scene))
    scene.angular_velocity[:, 1] += rng.uniform(-speed, speed, len(scene))
    return scene


def momentum(scene: Scene) -> np.ndarray:
    """Linear and, about the origin, angular momentum."""
    m = scene.mass[:, None]
    spin = [_world_inertia(scene, k) @ scene.angular_velocity[k] for k in range(len(scene))]
    return np.concatenate(
        [(m * scene.velocity).sum(axis=0), (np.cross(scene.position, m * scene.velocity) + spin).sum(axis=0)]
    )


def _world_inertia(scene: Scene, k: int) -> np.ndarray:
    R = scenes_rotation(scene.orientation[k])
    return R @ np.diag(scene.inertia[k]) @ R.T


def scenes_rotation(q: np.ndarray) -> np.ndarray:
    """Rodrigues' formula, written apart from the package's."""
    w, axis = q[0], q[1:]
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + 2 * w * K + 2 * K @ K


# The LCP --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SCENES)
def test_every_island_of_the_first_steps_is_solved(name):
    scene = SCENES[name]()
    stepper = scenes.Stepper(scene)
    orders = 0
    for _ in range(30):
        record = stepper.step()
        assert record.solved
        for island in stepper.islands:
            assert_solves(island.A, island.q, solve(island.A, island.q))
            orders += len(island.q)
    assert orders > 0


@pytest.mark.parametrize("planar", [True, False])
def test_the_matrix_is_what_impulses_do_to_velocities(planar):
    """A by single impulses on bodies, in the world's axes; q by the free velocities."""
    rng = np.random.default_rng(1)
    bodies = []
    for k in range(3):
        orientation = scenes.about_y(rng.normal()) if planar else rng.normal(size=4)
        bodies.append(Body(Box((0.3, 0.4, 0.5)), 1.0 + k, rng.normal(size=3) * [1, not planar, 1], orientation))
    scene = Scene(bodies, planes=(), planar=planar)
    mask = np.array([1, not planar, 1.0])
    scene.velocity[:] = rng.normal(size=(3, 3)) * mask
    normals = rng.normal(size=(3, 3)) * mask
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    points = rng.normal(size=(3, 3)) * mask
    pairs = [(0, 1), (0, -1), (2, 1)]
    contacts = Contacts.of(
        [Contact(p, n, pair, gap=0.01, friction=0.5) for p, n, pair in zip(points, normals, pairs, strict=True)]
    )
    order = [pairs.index(tuple(pair)) for pair in contacts.bodies.tolist()]
    (island,) = scenes.lcps(scene, dt=0.01, contacts=contacts, facets=4, reach=1e6)
    facets = len(island.directions)
    rows = [(order[k], normals[order[k]]) for k in range(3)]
    for k in range(3):
        n = normals[order[k]]
        if planar:
            basis = [np.array([n[2], 0.0, -n[0]])]
        else:
            t = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
            basis = [t / np.linalg.norm(t)]
            basis.append(np.cross(n, basis[0]))
        rows += [(order[k], sum(c * t for c, t in zip(d, basis, strict=True))) for d in island.directions]
    k = 3 + 3 * facets
    assert island.A.shape == (k + 3, k + 3)

    def response(row, free):
        """Relative velocities along all rows, after gravity alone or after a unit impulse along one row."""
        v, spin = np.zeros((3, 3)), np.zeros((3, 3))
        if free:
            v = scene.velocity + 0.01 * scene.gravity
        else:
            contact, direction = row
            for sign, body in zip((1, -1), pairs[contact], strict=True):
                if body >= 0:
                    v[body] += sign * direction / scene.mass[body]
                    torque = np.cross(points[contact] - scene.position[body], sign * direction)
                    spin[body] += np.linalg.solve(_world_inertia(scene, body), torque)
        out = []
        for contact, direction in rows:
            speed = 0.0
            for sign, body in zip((1, -1), pairs[contact], strict=True):
                if body >= 0:
                    at = v[body] + np.cross(spin[body], points[contact] - scene.position[body])
                    speed += sign * direction @ at
            out.append(speed)
        return np.array(out)

    A = np.array([response(row, False) for row in rows]).T
    assert np.abs(island.A[:k, :k] - A).max() < 1e-12 * np.abs(A).max()
    q = response(None, True)
    q[:3] += 0.01 / 0.01
    assert np.abs(island.q[:k] - q).max() < 1e-12
    assert (island.q[k:] == 0).all()
    assert (island.A[k:, :3] == 0.5 * np.eye(3)).all()
    assert (island.A[k:, 3:k] == -np.kron(np.eye(3), np.ones(facets))).all()
    assert (island.A[3:k, k:] == np.kron(np.eye(3), np.ones(facets)).T).all()


def test_rows_no_more_than_needed():
    stack = scenes.lcps(scenes.box_stack(5, friction=0.0))
    assert [len(island.q) for island in stack] == [10]  # two contacts per interface, one row each
    assert [len(i.q) for i in scenes.lcps(scenes.box_stack(5, friction=0.0, planar=False))] == [20]
    assert [len(i.q) for i in scenes.lcps(scenes.box_stack(5))] == [40]  # 2 facets and a sliding speed more
    for facets in (3, 4, 8):
        assert [len(i.q) for i in scenes.lcps(scenes.box_stack(2, planar=False), facets=facets)] == [8 * (facets + 2)]
    assert len(scenes.lcps(scenes.box_stack(5, stacks=7))) == 7


def test_contacts_left_out_are_put_back_when_they_act():
    """A fast ball strikes a row of balls that are apart: the impulse reaches contacts that would open without it."""

    def row(reach):
        bodies = [Body(Sphere(0.5), 1.0, (1.001 * k, 0, 0), restitution=0.0, friction=0.0) for k in range(4)]
        scene = Scene(bodies, planes=(), gravity=(0, 0, 0))
        scene.velocity[0, 0] = 5.0
        scene.velocity[3, 0] = 0.5
        stepper = scenes.Stepper(scene, dt=0.01, reach=reach)
        records = [stepper.step() for _ in range(3)]
        return scene, records

    lazy, records = row(0.0)
    eager, all_records = row(1e9)
    assert np.abs(lazy.velocity - eager.velocity).max() < 1e-12
    assert lazy.velocity[3, 0] > 1.0
    assert sum(r.rows for r in records) <= sum(r.rows for r in all_records)
    assert np.allclose(lazy.velocity.sum(axis=0), [5.5, 0, 0])


def test_a_body_shot_by_an_impulse_does_not_pass_through():
    """A light ball squeezed out by a heavy one meets a third within the same step."""
    bodies = [
        Body(Sphere(0.5), 1e6, (0, 0, 0), friction=0.0),
        Body(Sphere(0.1), 1.0, (0.61, 0, 0), friction=0.0),
        Body(Sphere(0.5), 1e6, (1.42, 0, 0), friction=0.0),
    ]
    scene = Scene(bodies, planes=(), gravity=(0, 0, 0))
    scene.velocity[0, 0] = 30.0
    history = scenes.run(scene, 5, dt=0.01)
    assert history.penetration.max() < 1e-9
    assert scene.position[0, 0] < scene.position[1, 0] < scene.position[2, 0]


def test_lcp_of_the_largest_island():
    A, q = scenes.lcp(scenes.heavy_on_light(10, mass_ratio=1e6))
    assert A.shape == (80, 80)
    assert_solves(A, q, solve(A, q))
    A, q = scenes.lcp(scenes.sphere_pile(16), settle=60)
    assert_solves(A, q, solve(A, q))
    with pytest.raises(errors.OptionError, match="no contact"):
        scenes.lcp(Scene([Body(Sphere(1.0), 1.0, (0, 0, 5))]))


# Mechanics ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.0, 0.7])
@pytest.mark.parametrize("facets", [4, 7])
def test_collisions_conserve_momentum(restitution, facets):
    rng = np.random.default_rng(3)
    bodies = [
        Body(Sphere(0.4), float(m), p, velocity=-2 * p, angular_velocity=rng.normal(size=3), restitution=restitution)
        for m, p in zip(rng.uniform(1, 5, 6), rng.uniform(-1.5, 1.5, (6, 3)), strict=True)
    ]
    scene = Scene(bodies, planes=(), gravity=(0, 0, 0))
    before = momentum(scene)
    history = scenes.run(scene, 60, facets=facets)
    assert history.rows.max() > 0
    # positions move between the impulse and the next step, so angular momentum is conserved step by step to O(dt)
    after = momentum(scene)
    assert np.abs(after - before)[:3].max() < 1e-12
    assert np.abs(after - before)[3:].max() < 0.1


def test_a_step_of_box_on_box_conserves_both_momenta():
    bodies = [
        Body(Box((0.5, 0.5, 0.5)), 2.0, (0, 0, 0), velocity=(0.3, 0.1, 2.0), angular_velocity=(0, 0, 0)),
        Body(Box((0.5, 0.5, 0.5)), 3.0, (0.2, 0.3, 1.005), velocity=(0, 0, -1.0)),
    ]
    scene = Scene(bodies, planes=(), gravity=(0, 0, 0))
    before = momentum(scene)
    still = scene.position.copy()
    stepper = scenes.Stepper(scene)
    assert stepper.step().rows > 0
    scene.position = still  # the impulse acts where the bodies were
    scene.orientation[:] = (1, 0, 0, 0)
    assert np.abs(momentum(scene) - before).max() < 1e-12


def test_the_ground_carries_the_weight():
    scene = scenes.box_stack(5, mass_ratio=1e3)
    stepper = scenes.Stepper(scene, dt=0.01)
    stepper.step()
    (island,) = stepper.islands
    c, _ = island.impulses(solve(island.A, island.q).z)
    on_ground = stepper.contacts.bodies[island.contacts, 1] == -1
    assert np.isclose(c[on_ground].sum(), scene.mass.sum() * G * 0.01, rtol=1e-12)


@pytest.mark.parametrize("e", [0.3, 0.8, 1.0])
def test_bounce_height(e):
    ball = Body(Sphere(0.1), 1.0, (0, 0, 1.1), restitution=e)
    scene = Scene([ball])
    history = scenes.run(scene, 450, dt=0.002)
    height = history.position[:, 0, 2] - 0.1
    first = int(np.argmin(height[:300]))
    apex = height[first:].max()
    assert np.isclose(apex, e * e, atol=0.02)
    assert (np.diff(history.energy_drift) <= 1e-9).all()


@pytest.mark.parametrize("angle", [0.2, 0.5, 0.7])
@pytest.mark.parametrize("planar", [True, False])
def test_friction_holds_up_to_its_angle(angle, planar):
    stays = scenes.incline(angle, 1.01 * np.tan(angle), planar)
    assert scenes.run(stays, 100).drift()[-1] < 1e-10
    mu = 0.9 * np.tan(angle)
    slides = scenes.incline(angle, mu, planar)
    scenes.run(slides, 100, dt=0.01)
    expected = G * (np.sin(angle) - mu * np.cos(angle))  # times 1 s
    assert np.isclose(np.linalg.norm(slides.velocity[0]), expected, rtol=1e-9)


@pytest.mark.parametrize("facets", [4, 8, 16])
def test_facets_lose_friction_between_their_directions(facets):
    """Down the middle between two facets a polyhedral cone is `cos(pi / facets)` thinner."""
    angle, turned = 0.4, np.pi / facets
    spin = np.array([[np.cos(turned), -np.sin(turned), 0], [np.sin(turned), np.cos(turned), 0], [0, 0, 1]])

    def slope(mu):
        # the tangent basis follows the axis that the normal has least of: turn gravity, not the plane
        ball = Body(Sphere(0.1), 1.0, (0, 0, 0.1), inertia=(1e9, 1e9, 1e9), friction=mu)
        scene = Scene([ball], (Plane(friction=mu),))
        scene.gravity = spin @ np.array([-np.sin(angle), 0, -np.cos(angle)]) * G
        scenes.run(scene, 50, facets=facets)
        return np.linalg.norm(scene.velocity[0])

    assert slope(1.001 * np.tan(angle) / np.cos(np.pi / facets)) < 1e-9
    assert slope(0.999 * np.tan(angle) / np.cos(np.pi / facets)) > 1e-4


@pytest.mark.parametrize("name", ["box_stack", "pyramid_wall", "arch", "sphere_pile", "discs", "card_house"])
def test_energy_does_not_grow(name):
    scene = kicked(SCENES[name](), 5)
    if name == "sphere_pile":
        scene.velocity[:, 1] = 0.1
    history = scenes.run(scene, 60, stabilisation=0.0, dt=0.005)
    energy = np.concatenate([[history.initial_energy], history.energy])
    assert history.rows.max() > 0
    # impulses act on the contacts where they were: turning bodies leave errors of second order in dt
    speed = np.abs(np.diff(history.position, axis=0)).max(axis=(0, 2)) / 0.005
    assert np.diff(energy).max() <= 0.02 * (scene.mass * speed**2).sum() + 1e-9


@pytest.mark.parametrize("name", SCENES)
def test_physical_errors_of_solved_steps_are_small(name):
    scene = SCENES[name]()
    history = scenes.run(scene, 40)
    weight = scene.mass.sum() * G * 0.01
    assert history.solved.all()
    assert history.penetration_velocity.max() < 1e-7
    assert history.cone_violation.max() < 1e-7 * weight
    assert history.signorini.max() < 1e-7 * weight
    assert history.joint_velocity.max(initial=0.0) < 1e-7
    if scene.planar:
        assert history.dissipation.max() < 1e-7 * weight


@pytest.mark.parametrize("facets", [4, 8, 32])
def test_facets_lose_dissipation_within_their_bound(facets):
    scene = scenes.box_stack(1, planar=False)
    scene.velocity[0, :2] = (1.0, 0.3)
    lost = scenes.run(scene, 1, facets=facets).dissipation.max()
    assert 0 < lost <= 0.5 * G * 0.01 * np.hypot(1.0, 0.3) * (1 - np.cos(np.pi / facets))


# Structures -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("mass_ratio", [1.0, 1e3, 1e6, 1e8])
def test_heavy_on_light_stands(planar, mass_ratio):
    scene = scenes.heavy_on_light(10, mass_ratio=mass_ratio, planar=planar)
    history = scenes.run(scene, 60)
    assert history.solved.all()
    assert history.drift().max() < 1e-9


def test_a_stack_that_is_put_down_comes_to_rest():
    scene = scenes.heavy_on_light(10, mass_ratio=1e6)
    scene.position[:, 0] += np.random.default_rng(0).uniform(-0.03, 0.03, 10)
    scene.position[:, 2] += 0.002 * np.arange(1, 11)
    history = scenes.run(scene, 120)
    assert history.solved.all()
    assert np.abs(history.position[-1, :, 2] - (0.5 + np.arange(10))).max() < 1e-6
    assert history.drift()[-1] - history.drift()[-30] < 1e-9
    assert history.energy_drift[-1] < 0


@pytest.mark.parametrize(("thickness", "stands"), [(0.2, True), (0.14, True), (0.07, False), (0.05, False)])
def test_an_arch_stands_when_it_is_thick_enough(thickness, stands):
    """Heyman: t/R >= 0.106 for a semicircle with joints everywhere."""
    drift = scenes.run(scenes.arch(15, thickness), 150).drift()[-1]
    assert drift < 1e-6 if stands else drift > 0.1


def test_walls_arch_and_cards_lean_by_friction():
    assert scenes.run(scenes.pyramid_wall(4), 60).drift()[-1] < 1e-9
    assert scenes.run(scenes.card_house(2), 60).drift()[-1] < 1e-9
    assert scenes.run(scenes.card_house(2, friction=0.1), 100).drift()[-1] > 0.2
    without_middle = [0, 2, 3, 4, 5]
    arching = scenes.pyramid_wall(3, friction=0.5).subset(without_middle)
    assert scenes.run(arching, 60).drift()[-1] < 1e-9
    falling = scenes.pyramid_wall(3, friction=0.05).subset(without_middle)
    assert scenes.run(falling, 60).drift()[-1] > 1e-3


def test_a_pendulum_keeps_its_length_and_its_period():
    """A small swing of a single link: period 2 pi sqrt(I / (m g l)) about the pivot."""
    scene = scenes.chain(1, length=1.0, angle=0.05)
    history = scenes.run(scene, 260, dt=0.002)
    assert history.joint_velocity.max() < 1e-12
    x = history.position[:, 0, 0]
    crossings = np.flatnonzero((x[:-1] > 0) & (x[1:] <= 0))
    inertia = scene.inertia[0, 1] + 0.25
    assert np.isclose(crossings[0] * 0.002 * 4, 2 * np.pi * np.sqrt(inertia / (0.5 * G)), rtol=0.01)
    top = scene.position[0] - 0.5 * (scenes_rotation(scene.orientation[0]) @ [0, 0, -1.0])
    assert np.abs(top - [0, 0, 1.2]).max() < 1e-4


@pytest.mark.parametrize("mass_ratio", [1.0, 1e6])
def test_a_chain_stays_together_when_it_strikes_the_ground(mass_ratio):
    links = 8
    scene = scenes.chain(links, mass_ratio, height=1.0, angle=1.2)
    history = scenes.run(scene, 150, dt=0.005)
    assert history.rows.max() > 0
    assert history.solved.all()
    ends = [
        scene.position[k] + 0.1 * s * (scenes_rotation(scene.orientation[k]) @ [0, 0, 1.0])
        for k in range(links)
        for s in (1, -1)
    ]
    apart = max(np.linalg.norm(ends[2 * k + 1] - ends[2 * k + 2]) for k in range(links - 1))
    assert apart < (0.02 if mass_ratio == 1 else 0.5) * 0.2  # light links whip: 75 rad/s
    assert history.joint_velocity.max() < 1e-9
    assert scene.position[:, 2].min() > 0


def test_redundant_joints_do_not_matter():
    once = scenes.chain(3, height=0.5, angle=1.0)
    twice = Scene(once.bodies, once.planes, [*once.joints, *once.joints], planar=True)
    scenes.run(once, 50)
    scenes.run(twice, 50)
    assert np.abs(once.position - twice.position).max() < 1e-9


# Islands, order, sleep ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("boxes", "planar"), [(1, True), (2, True), (5, True), (3, False)])
def test_stacks_in_one_scene_have_the_bits_of_stacks_alone(boxes, planar):
    stacks = 12
    scene = kicked(scenes.box_stack(boxes, mass_ratio=50.0, stacks=stacks, planar=planar, spacing=3.0), 2)
    scene.position[:, 2] += 0.003 * np.tile(np.arange(boxes), stacks)
    alone = [scene.subset(range(k * boxes, (k + 1) * boxes)) for k in range(stacks)]
    together = scenes.Stepper(scene)
    apart = [scenes.Stepper(one) for one in alone]
    for _ in range(25):
        record = together.step()
        records = [stepper.step() for stepper in apart]
        assert record.islands >= stacks
        assert record.rows == sum(r.rows for r in records)
        for name in ("position", "orientation", "velocity", "angular_velocity"):
            assert np.array_equal(getattr(scene, name), np.concatenate([getattr(one, name) for one in alone])), name


@pytest.mark.parametrize(("rows", "apart"), [(2, 1e-9), (4, 2e-3)])
def test_order_of_bodies_is_physics_of_its_own(rows, apart):
    """Contact with friction has many solutions in a wall; the order of the bodies decides, by less than a slip."""
    scene = kicked(scenes.pyramid_wall(rows), 7, 0.1)
    order = np.random.default_rng(0).permutation(len(scene))
    other = scene.subset(order)
    a, b = scenes.run(scene, 20), scenes.run(other, 20)
    assert a.solved.all()
    assert b.solved.all()
    assert np.abs(scene.position[order] - other.position).max() < apart
    assert np.isclose(a.energy[-1], b.energy[-1], atol=10 * apart)


def test_sleep_and_waking():
    scene = scenes.box_stack(3, stacks=2, spacing=4.0)
    missile = Body(Box((0.2, 0.2, 0.2)), 5.0, (4.0, 0, 6.0), velocity=(0, 0, 0))
    scene = Scene([*scene.bodies, missile], scene.planes, planar=True)
    history = scenes.run(scene, 120, sleep_speed=0.01, sleep_after=0.2)
    assert history.asleep[25] == 6
    assert history.rows[25] == 0
    hit = np.flatnonzero(history.asleep[25:] == 3)  # the struck stack wakes, the other sleeps on
    assert len(hit) > 0
    assert history.rows[25 + hit[0]] > 0
    assert history.position[-1, 6, 2] > 3.0
    assert (history.position[-1, :3] == history.position[30, :3]).all()


def test_nothing_falls_asleep_unless_asked():
    history = scenes.run(scenes.box_stack(2), 100)
    assert history.asleep.max() == 0


def test_slow_motion_is_not_mistaken_for_rounding():
    scene = Scene([Body(Box((0.5, 0.5, 0.5)), 1.0, (0, 0, 0.5), velocity=(1e-9, 0, 0), friction=0.0)], planar=True)
    scenes.run(scene, 100)
    assert np.isclose(scene.position[0, 0], 1e-9, rtol=1e-6)


def test_warm_start_finds_the_same_motion():
    cold, warm = (kicked(scenes.box_stack(4), 4, 0.05) for _ in range(2))
    a = scenes.run(cold, 60, warm_start=False)
    b = scenes.run(warm, 60)
    assert "warm_start" not in a.methods
    assert "warm_start" in b.methods
    assert np.abs(cold.position - warm.position).max() < 1e-9


def test_an_answer_that_is_not_solved_is_said_and_used():
    scene = scenes.box_stack(5)
    history = scenes.run(scene, 3, method="lemke", max_iterations=1)
    assert not history.solved.any()
    assert history.residual.min() > 1e-6
    assert history.penetration_velocity.max() > 1e-3
    assert "solved in 0 of 3" in str(history)


def test_a_step_without_time_moves_on_and_says_so():
    scene = scenes.sphere_pile(16, friction=0.3)
    history = scenes.run(scene, 60, method="lemke", time_limit=1e-9)
    assert len(history) == 60
    assert not history.solved.all()
    assert np.isfinite(scene.position).all()


def test_history_has_an_array_for_every_number():
    history = scenes.run(scenes.box_stack(2), 5)
    for name in ("time", "rows", "islands", "residual", "seconds", "penetration", "signorini", "energy"):
        assert getattr(history, name).shape == (5,)
    assert history.position.shape == (6, 2, 3)
    assert history.energy_drift.shape == history.drift().shape == (5,)
    with pytest.raises(AttributeError, match="nonsense"):
        _ = history.nonsense


# Collisions -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [5, 300])
def test_the_grid_finds_all_near_pairs(n):
    rng = np.random.default_rng(n)
    position, reach = rng.uniform(0, 4, (n, 3)), rng.uniform(0.05, 0.3, n)
    movable = rng.random(n) < 0.8
    i, j = near_pairs(position, reach, movable)
    distance = np.linalg.norm(position[:, None] - position, axis=2)
    near = (distance <= reach[:, None] + reach) & (movable[:, None] | movable)
    expected = np.argwhere(np.triu(near, 1))
    assert np.array_equal(np.stack([i, j], axis=1), expected)


def test_box_on_box_turned_by_45_degrees_has_eight_contacts():
    turned = (np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8))
    bodies = [Body(Box((0.5, 0.5, 0.5)), 1.0, (0, 0, 0.5)), Body(Box((0.5, 0.5, 0.5)), 1.0, (0, 0, 1.5), turned)]
    contacts = scenes.find_contacts(Scene(bodies, planes=()), 0.01)
    assert len(contacts) == 8
    assert np.abs(contacts.gap).max() < 1e-12
    assert np.allclose(contacts.normal, [0, 0, -1])
    assert np.allclose(contacts.point[:, 2], 1.0)
    assert np.allclose(np.sort(np.abs(contacts.point[:, :2]).max(axis=1)), 0.5)


def test_a_tilted_box_touches_with_its_edge():
    box = Body(Box((0.5, 0.5, 0.5)), 1.0, (0, 0, np.sqrt(0.5) + 1e-4), scenes.about_y(np.pi / 4))
    for planar, count in ((True, 1), (False, 2)):
        contacts = scenes.find_contacts(Scene([box], planar=planar), 0.001)
        assert len(contacts) == count
        assert np.allclose(contacts.gap, 1e-4)
        assert (contacts.bodies == [0, -1]).all()


def test_corner_over_a_face_in_the_plane():
    bodies = [
        Body(Box((1, 1, 0.5)), 1.0, (0, 0, 0.5)),
        Body(Box((0.5, 1, 0.5)), 1.0, (0.2, 0, 1.71), scenes.about_y(0.785)),
    ]
    contacts = scenes.find_contacts(Scene(bodies, planes=(), planar=True), 0.01)
    assert len(contacts) == 1
    assert np.allclose(contacts.normal[0], [0, 0, -1])
    assert np.isclose(contacts.gap[0], 0.71 - np.sqrt(0.5), atol=1e-6)


# Documentation --------------------------------------------------------------------------------------------------------


def test_the_page_and_the_docstrings_run():
    page = (Path(__file__).parent.parent / "docs" / "scenes.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) == 2
    for block in blocks:
        exec(block.replace("steps=1000", "steps=10"), {})
    for module in ("stepping", "lcp"):
        found = doctest.testmod(__import__(f"lcpstar.scenes.{module}", fromlist=["_"]))
        assert found.attempted > 0
        assert found.failed == 0


# Bad input ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Body(Sphere(-1.0), 1.0, (0, 0, 0)), "radius must be strictly positive and finite, got -1"),
        (lambda: Body(Sphere(1.0), 0.0, (0, 0, 0)), "mass must be strictly positive, got 0"),
        (lambda: Body(Sphere(1.0), 1.0, (0, np.nan, 0)), r"position\[1\] = nan"),
        (lambda: Body(Sphere(1.0), 1.0, (0, 0)), "position must have length 3, got 2"),
        (lambda: Body(Sphere(1.0), 1.0, (0, 0, 0), friction=-0.1), "friction must be nonnegative and finite, got -0.1"),
        (lambda: Body(Sphere(1.0), 1.0, (0, 0, 0), restitution=1.1), r"restitution must lie in \[0, 1\], got 1.1"),
        (lambda: Polygon.around([[0, 0], [0, 1], [1, 0]]), "counter-clockwise"),
        (lambda: Plane((0, 0, 0)), "normal must not be zero"),
        (lambda: Contact((0, 0, 0), (0, 0, 2), (0, 1)), "normal must have length 1, got 2.0"),
        (lambda: Contact((0, 0, 0), (0, 0, 1), (1, 1)), r"bodies must be two different bodies.*\(1, 1\)"),
        (lambda: Joint((0, 0), ((0, 0, 0), (0, 0, 0))), "two different bodies"),
        (lambda: Scene([Body(Sphere(1.0), 1.0, (0, 0, 0)), Body(Box((1, 1, 1)), 1.0, (0, 0, 3))]), "one kind"),
        (
            lambda: Scene([Body(Sphere(1.0), 1.0, (0, 0, 0))], joints=[Joint((0, 3), ((0, 0, 0), (0, 0, 0)))]),
            r"joints\[0\] names body 3, but there are 1",
        ),
        (lambda: Scene([Body(Sphere(1.0), 1.0, (0, 0, 0), velocity=(0, 1, 0))], planar=True), "leaves the x-z plane"),
        (lambda: scenes.run(scenes.box_stack(1), 1, dt=0.0), "dt must be strictly positive"),
        (
            lambda: scenes.run(scenes.box_stack(1, planar=False), 1, facets=2),
            "facets must be at least 3 in space, got 2",
        ),
        (lambda: scenes.run(scenes.box_stack(1), 1, stabilisation=2.0), r"stabilisation must lie in \[0, 1\], got 2"),
        (lambda: scenes.run(scenes.box_stack(1), 1, method="magic"), "magic"),
        (lambda: scenes.arch(thickness=3.0), r"thickness must lie in \(0, 2\), got 3"),
        (lambda: scenes.chain(10, height=0.5), "the end is buried"),
    ],
)
def test_bad_input_names_the_argument_and_the_number(make, message):
    with pytest.raises(errors.LCPError, match=message):
        make()


# The portfolio --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("seed", "noise"), [(12, 1e-11), (8, 1e-9)])
def test_auto_solves_a_heavy_stack_with_noise(seed, noise):
    """Solvable by theory [AP97]; Lemke's method ended on a ray in doubles and in double-doubles, whatever its d."""
    rng = np.random.default_rng(seed)
    scene = scenes.heavy_on_light(10, mass_ratio=1e6)
    plane = [1.0, 0.0, 1.0]
    scene.velocity += noise * rng.standard_normal((10, 3)) * plane
    scene.position += 1e-2 * noise * rng.standard_normal((10, 3)) * plane
    scene.orientation[:, 2] += 1e-2 * noise * rng.standard_normal(10)
    scene.angular_velocity[:, 1] += noise * rng.standard_normal(10)
    A, q = scenes.lcp(scene)
    assert_solves(A, q, solve(A, q))
