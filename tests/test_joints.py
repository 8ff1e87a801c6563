"""Joints: rows that hold bodies together, eliminated from the LCPs of their islands."""

from __future__ import annotations

import numpy as np
import pytest

from lcpstar import scenes
from lcpstar.scenes import Scene
from scene_checks import G, rotation


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


@pytest.mark.parametrize("mass_ratio", [1.0, 1e6])
def test_a_chain_stays_together_when_it_strikes_the_ground(mass_ratio):
    links = 8
    scene = scenes.chain(links, mass_ratio, height=1.0, angle=1.2)
    history = scenes.run(scene, 150, dt=0.005)
    assert history.rows.max() > 0
    assert history.solved.all()
    ends = [
        scene.position[k] + 0.1 * s * (rotation(scene.orientation[k]) @ [0, 0, 1.0])
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
