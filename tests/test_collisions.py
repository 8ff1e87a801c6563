"""Where bodies touch, how deep, and which contacts that makes."""

from __future__ import annotations

import numpy as np
import pytest

from lcpstar import scenes
from lcpstar.scenes import Body, Box, Scene
from lcpstar.scenes.neighbours import near_pairs


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
