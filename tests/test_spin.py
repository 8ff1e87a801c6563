"""Bodies that turn without torque: energy, angular momentum, and the motion of a top."""

from __future__ import annotations

import numpy as np
import pytest

from lcpstar import scenes
from lcpstar.scenes import Body, Box, Scene
from scene_checks import momentum

SHAPES = [(0.01, 0.2, 0.2), (0.2, 0.01, 0.2), (0.001, 0.002, 1.0), (0.1, 0.2, 0.3), (0.2, 0.2, 0.2), (1e-4, 1.0, 1.0)]
SPINS = [(100.0, 5.0, 0.0), (0.0, 1.0, 1e-3), (3.0, -2.0, 1.0), (1e-6, 1.0, 1e-6), (0.0, 0.0, 7.0)]


def free_bodies(scale):
    """All shapes with all spins, too far apart to meet, turned at random."""
    rng = np.random.default_rng(0)
    bodies = [
        Body(Box(half), 2.0, (1e7 * k, 0, 0), rng.normal(size=4), angular_velocity=scale * np.array(spin))
        for k, (half, spin) in enumerate((half, spin) for half in SHAPES for spin in SPINS)
    ]
    return Scene(bodies, (), gravity=(0, 0, 0))


def each(scene, measure):
    return np.array([measure(scene.subset([k])) for k in range(len(scene))])


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("scale", [1e-3, 0.1, 1.0, 10.0, 1e4])
def test_no_body_gains_energy_by_turning(scale, dt):
    scene = free_bodies(scale)
    energy, turning = each(scene, Scene.energy), each(scene, momentum)[:, 3:]
    first, length = energy, np.linalg.norm(turning, axis=1)
    slow = dt * np.linalg.norm(scene.angular_velocity, axis=1) < 0.5
    stepper = scenes.Stepper(scene, dt)
    for _ in range(30):
        stepper.step()
        before, energy = energy, each(scene, Scene.energy)
        assert (energy <= (1 + 1e-14) * before).all()
        now = each(scene, momentum)[:, 3:]
        assert (np.linalg.norm(now - turning, axis=1)[slow] <= 1e-9 * length[slow]).all()
        assert (np.linalg.norm(now, axis=1) <= np.sqrt(2 * first * scene.inertia.max(axis=1)) * (1 + 1e-12)).all()


def test_a_thin_plate_keeps_turning():
    plate = Body(Box((0.01, 0.2, 0.2)), 1.0, (0, 0, 0), angular_velocity=(100, 5, 0))
    wall = Body(Box((1, 1, 1)), np.inf, (5, 0, 0))
    scene = Scene([plate, wall], (), gravity=(0, 0, 0))
    history = scenes.run(scene, 300)
    assert history.energy.max() <= history.initial_energy
    assert history.energy.min() > 0.99 * history.initial_energy
    assert np.isfinite(scene.orientation).all()


def test_a_symmetric_top_precesses():
    """In its own axes the spin goes around the axis of symmetry at `(I3 - I1) / I1 w3`; first order in dt."""
    errors = []
    for dt in (1e-2, 5e-3):
        top = Body(Box((0.3, 0.3, 0.1)), 1.0, (0, 0, 0), angular_velocity=(0.5, 0, 3.0))
        scene = Scene([top], (), gravity=(0, 0, 0))
        one, _, three = scene.inertia[0]
        scenes.run(scene, round(1 / dt), dt=dt)
        R = scenes.rotation.rotations(scene.orientation)[0]
        angle = (three - one) / one * 3.0
        errors.append(np.abs(R.T @ scene.angular_velocity[0] - [0.5 * np.cos(angle), 0.5 * np.sin(angle), 3.0]).max())
    assert errors[1] < 0.6 * errors[0] < 3e-2
