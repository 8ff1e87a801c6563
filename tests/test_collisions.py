"""Where bodies touch, how deep, and which contacts that makes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from lcpstar import scenes
from lcpstar.scenes import Body, Box, Polygon, Scene, Sphere
from lcpstar.scenes.neighbours import near_pairs
from scene_checks import rotation


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


# Depth and direction --------------------------------------------------------------------------------------------------


def overlap(scene):
    """Least translation that parts two convex bodies: from 0 to the boundary of the hull of all corner differences."""
    plane = [0, 2] if scene.planar else [0, 1, 2]
    one, other = (
        scene.position[k] + scene.corners[k, : scene.corner_count[k]] @ rotation(scene.orientation[k]).T for k in (0, 1)
    )
    hull = ConvexHull((one[:, None] - other).reshape(-1, 3)[:, plane])
    return -hull.equations[:, -1].max()


def random_pair(rng, planar):
    """Two long, flat or cubic boxes, or polygons, whose centres are within a metre."""
    bodies = []
    for far in (0.0, rng.uniform(0, 1)):
        shape = Box(tuple(10 ** rng.uniform(-1.5, 0, 3)))
        if planar and rng.random() < 0.5:
            angle = np.sort(rng.uniform(0, 2 * np.pi / 5, 5) + 2 * np.pi / 5 * np.arange(5))
            shape, _ = Polygon.around(rng.uniform(0.1, 0.6) * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        turned = scenes.about_y(rng.uniform(0, 6)) if planar else rng.normal(size=4)
        bodies.append(Body(shape, 1.0, far * rng.normal(size=3) * [1, not planar, 1], turned))
    return bodies


def touching(bodies, planar):
    scene = Scene(bodies, (), planar=planar)
    return scene, scenes.find_contacts(scene, 1e-9, np.full(2, 1e-3))


@pytest.mark.parametrize("planar", [True, False])
def test_penetration_is_the_depth_of_the_overlap(planar):
    rng = np.random.default_rng(0)
    depths, single = [], 0
    for _ in range(600):
        scene, contacts = touching(random_pair(rng, planar), planar)
        depth = overlap(scene)
        deepest = -contacts.gap.min(initial=0.0)
        assert abs(max(0.0, deepest) - max(0.0, depth)) < 2e-4 * scene.radius.min()
        depths.append(depth)
        single += len(contacts) == 1
    assert sum(d > 0 for d in depths) > 150
    assert single > 30


@pytest.mark.parametrize("planar", [True, False])
def test_contacts_of_a_pair_are_those_of_the_pair_exchanged(planar):
    rng = np.random.default_rng(1)
    found = 0
    for _ in range(300):
        bodies = random_pair(rng, planar)
        a, b = touching(bodies, planar)[1], touching(bodies[::-1], planar)[1]
        assert len(a) == len(b)
        one, other = np.lexsort(a.point.round(9).T), np.lexsort(b.point.round(9).T)
        assert np.allclose(a.point[one], b.point[other], rtol=0, atol=1e-9)
        assert np.allclose(a.normal[one], -b.normal[other], rtol=0, atol=1e-9)
        assert np.allclose(a.gap[one], b.gap[other], rtol=0, atol=1e-9)
        found += len(a)
    assert found > 200


def test_moving_along_the_normal_parts_the_bodies():
    rng = np.random.default_rng(2)
    for _ in range(300):
        bodies = random_pair(rng, False)
        scene, contacts = touching(bodies, False)
        if len(contacts) and contacts.gap.min() < 0:
            scene.position[0] += -contacts.gap.min() * contacts.normal[0]
            assert abs(overlap(scene)) < 2e-4 * scene.radius.min()


def beam(mass, height, turn, length=1.0):
    """A beam that lies on an edge, along the x axis turned by `turn`."""
    c, s = np.cos(np.pi / 8), np.sin(np.pi / 8)
    orientation = (c * np.cos(turn / 2), s * np.cos(turn / 2), s * np.sin(turn / 2), c * np.sin(turn / 2))
    return Body(Box((length, 0.05, 0.05)), mass, (0, 0, height), orientation)


@pytest.mark.parametrize("turn", [np.pi / 2, 1.0, 0.3, 0.05])
@pytest.mark.parametrize("drop", [0.0, 0.5])
def test_a_beam_stays_on_a_beam_that_it_crosses(turn, drop):
    touch = 0.1 * np.sqrt(2.0)
    scene = Scene([beam(np.inf, 0.0, 0.0), beam(3.0, touch + drop, turn)], ())
    history = scenes.run(scene, 100)
    assert np.isclose(scene.position[1, 2], touch, rtol=0, atol=1e-6)
    assert history.penetration.max() < 1e-6
    assert (np.diff(history.energy) < 1e-9).all()


def test_edges_that_cross_touch_at_one_point():
    contacts = scenes.find_contacts(Scene([beam(1.0, 0.0, 0.0), beam(1.0, 0.14, 1.0)], ()), 0.01)
    assert len(contacts) == 1
    assert np.allclose(contacts.normal, [[0, 0, -1]])
    assert np.allclose(contacts.point, [[0, 0, 0.07]])
    assert np.allclose(contacts.gap, 0.14 - 0.1 * np.sqrt(2.0))
    apart = Scene([beam(1.0, 0.0, 0.0, 0.2), beam(1.0, 0.15, 1.5, 0.2)], ())
    apart.position[1, 0] = 0.3  # the edges pass each other beyond their ends
    assert len(scenes.find_contacts(apart, 0.01)) == 0


def test_spheres_at_one_point_penetrate():
    contacts = scenes.find_contacts(Scene([Body(Sphere(1.0), 1.0, (0, 0, 0)), Body(Sphere(0.5), 1.0, (0, 0, 0))]), 0.01)
    pair = contacts.take(contacts.bodies[:, 1] == 1)
    assert pair.gap.tolist() == [-1.5]
    assert np.isclose(np.linalg.norm(pair.normal), 1.0)
