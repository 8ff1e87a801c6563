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
from scene_checks import SCENES, G, kicked, momentum, world_inertia

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
                    spin[body] += np.linalg.solve(world_inertia(scene, body), torque)
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
        (
            lambda: Body(Sphere(1.0), np.inf, (0, 0, 0), velocity=(1, 0, 0)),
            "velocity and angular_velocity must be 0 where mass is inf",
        ),
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
