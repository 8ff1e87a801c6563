"""Scenes that several tests run, and mechanics written apart from the package's."""

from __future__ import annotations

import numpy as np

from lcpstar import scenes
from lcpstar.scenes import Scene

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
    spin = [world_inertia(scene, k) @ scene.angular_velocity[k] for k in range(len(scene))]
    return np.concatenate(
        [(m * scene.velocity).sum(axis=0), (np.cross(scene.position, m * scene.velocity) + spin).sum(axis=0)]
    )


def world_inertia(scene: Scene, k: int) -> np.ndarray:
    R = rotation(scene.orientation[k])
    return R @ np.diag(scene.inertia[k]) @ R.T


def rotation(q: np.ndarray) -> np.ndarray:
    """Rodrigues' formula, written apart from the package's."""
    w, axis = q[0], q[1:]
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + 2 * w * K + 2 * K @ K
