"""Scenes with parameters: what people stack, build, hang and pour. All stand on the ground z = 0 unless said otherwise.

Masses are in kg, lengths in m. Each returns a fresh `Scene`.
"""

from __future__ import annotations

import numpy as np

from ..coerce import Matrix
from ..errors import OptionError
from .body import Body, Box, Polygon, Sphere, about_y
from .contact import WORLD
from .scene import Joint, Plane, Scene


def box_stack(
    boxes: int = 10,
    mass_ratio: float = 1.0,
    friction: float = 0.5,
    size: float = 1.0,
    planar: bool = True,
    stacks: int = 1,
    spacing: float = 2.0,
) -> Scene:
    """`stacks` separate stacks of equal boxes, `spacing` sizes apart; masses grow geometrically upwards from 1.

    The top of each is `mass_ratio` times as heavy as its bottom (1 to 1e8). Four contacts per interface in space, two
    in the plane.
    """
    masses = mass_ratio ** (np.arange(boxes) / max(1, boxes - 1))
    return Scene(_towers(masses, friction, size, stacks, spacing), (Plane(friction=friction),), planar=planar)


def heavy_on_light(
    boxes: int = 10, mass_ratio: float = 1e6, friction: float = 0.5, size: float = 1.0, planar: bool = True
) -> Scene:
    """A stack of boxes of mass 1 under one that is `mass_ratio` times heavier."""
    masses = np.ones(boxes)
    masses[-1:] = mass_ratio
    return Scene(_towers(masses, friction, size, 1, 0.0), (Plane(friction=friction),), planar=planar)


def _towers(masses: np.ndarray, friction: float, size: float, stacks: int, spacing: float) -> list[Body]:
    half = (size / 2, size / 2, size / 2)
    return [
        Body(Box(half), float(mass), (spacing * size * s, 0.0, (k + 0.5) * size), friction=friction)
        for s in range(stacks)
        for k, mass in enumerate(masses)
    ]


def pyramid_wall(rows: int = 6, friction: float = 0.5, width: float = 1.0, height: float = 0.5) -> Scene:
    """Bricks of mass 1 in the plane, `rows` at the bottom and one less in each course; every brick rests on two."""
    half = (width / 2, width / 2, height / 2)
    pitch = 1.02 * width  # bricks of one course do not touch
    bricks = [
        Body(Box(half), 1.0, ((i + k / 2) * pitch, 0.0, (k + 0.5) * height), friction=friction)
        for k in range(rows)
        for i in range(rows - k)
    ]
    return Scene(bricks, (Plane(friction=friction),), planar=True)


def arch(voussoirs: int = 9, thickness: float = 0.2, radius: float = 1.0, friction: float = 0.9) -> Scene:
    """A semicircular masonry arch in the plane: equal voussoirs around the mean `radius`, density 1 kg/m^2.

    `thickness` is in parts of the mean radius. A semicircle with radial joints everywhere needs about 0.106 to stand
    [Hey69]; with few voussoirs a little less does, because hinges form at joints only.
    """
    if not 0 < thickness < 2:
        raise OptionError(f"thickness must lie in (0, 2), got {thickness}")
    angles = np.pi * np.arange(voussoirs + 1) / voussoirs
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rays[0, 1] = rays[-1, 1] = 0.0
    inner, outer = radius * (1 - thickness / 2), radius * (1 + thickness / 2)
    bodies = []
    for k in range(voussoirs):
        corners = np.array([inner * rays[k], outer * rays[k], outer * rays[k + 1], inner * rays[k + 1]])
        bodies.append(_block(corners, friction))
    return Scene(bodies, (Plane(friction=friction),), planar=True)


def _block(corners: Matrix, friction: float) -> Body:
    shape, centre = Polygon.around(corners)
    x, z = corners[:, 0], corners[:, 1]
    area = 0.5 * float((x * np.roll(z, -1) - np.roll(x, -1) * z).sum())
    return Body(shape, area, centre, friction=friction)


def chain(
    links: int = 10,
    mass_ratio: float = 1.0,
    length: float = 0.2,
    height: float | None = None,
    angle: float = 0.5,
    friction: float = 0.5,
) -> Scene:
    """A straight chain of jointed links in the plane, hung from a point at `height`, `angle` from the vertical [rad].

    Links weigh 1, the last `mass_ratio`. From the default height, 1.2 times its length, it swings free; from less than
    its length it strikes the ground. A link does not collide with its neighbours.
    """
    total = links * length
    height = 1.2 * total if height is None else height
    if height <= total * np.cos(angle) + 0.1 * length:
        raise OptionError(
            f"height must exceed {total * np.cos(angle) + 0.1 * length:g}, got {height}: the end is buried"
        )
    along = np.array([np.sin(angle), 0.0, -np.cos(angle)])
    top = np.array([0.0, 0.0, height])
    turned = about_y(angle)  # a link's own axis is -z
    half = (0.1 * length, 0.1 * length, 0.4 * length)
    bodies, joints = [], []
    for k in range(links):
        mass = mass_ratio if k == links - 1 else 1.0
        bodies.append(Body(Box(half), mass, top + (k + 0.5) * length * along, turned, friction=friction))
        end = (0.0, 0.0, 0.5 * length)
        before = top if k == 0 else (0.0, 0.0, -0.5 * length)
        joints.append(Joint((k, k - 1 if k else WORLD), (end, before)))
    return Scene(bodies, (Plane(friction=friction),), joints, planar=True)


def card_house(
    levels: int = 3, friction: float = 0.7, lean: float = 0.35, card: float = 1.0, thick: float = 0.02
) -> Scene:
    """A house of cards in the plane: leaning pairs (`lean` from the vertical [rad]), a flat card across each two pairs.

    `levels` pairs at the bottom, one less on each level. It stands while the friction holds the feet.
    """
    half = (thick / 2, card / 2, card / 2)
    s, c = np.sin(lean), np.cos(lean)
    foot = 0.5 * (card * s + thick * c)  # half the width of a leaning card
    rise = card * c + thick * s  # and its height
    pitch = 4 * foot
    floor = rise + thick
    bodies = []
    for level in range(levels):
        z = level * floor
        for i in range(levels - level):
            x = (i + level / 2) * pitch
            for side in (-1.0, 1.0):
                at = (x + side * foot, 0.0, z + rise / 2)
                bodies.append(Body(Box(half), 1.0, at, about_y(side * lean), friction=friction))
        for i in range(levels - level - 1):
            x = (i + (level + 1) / 2) * pitch
            flat = Box((pitch / 2, card / 2, thick / 2))
            at = (x, 0.0, z + rise + thick / 2)
            bodies.append(Body(flat, 1.0, at, friction=friction))
    return Scene(bodies, (Plane(friction=friction),), planar=True)


def sphere_pile(
    bodies: int = 64,
    mass_ratio: float = 1.0,
    friction: float = 0.0,
    radius: float = 0.1,
    width: int = 4,
    seed: int = 0,
    planar: bool = False,
) -> Scene:
    """Spheres dropped into a box of `width` spheres' width, in layers, off centre by up to a tenth of a radius.

    Masses are `mass_ratio ** -U(0, 1)`: no order of heavy and light. The walls are planes without friction.
    """
    rng = np.random.default_rng(seed)
    pitch = 2.25 * radius
    side = pitch * width
    per_layer = width if planar else width * width
    k = np.arange(bodies)
    cell = k % per_layer
    x, y = (cell % width + 0.5) * pitch, (cell // width + 0.5) * pitch
    at = np.stack([x, np.zeros(bodies) if planar else y, (k // per_layer + 0.5) * pitch], axis=1)
    shift = rng.uniform(-0.1 * radius, 0.1 * radius, (bodies, 3))
    shift[:, 1] *= not planar
    masses = mass_ratio ** -rng.random(bodies)
    walls = [Plane(friction=friction), Plane((1, 0, 0), 0.0, 0.0), Plane((-1, 0, 0), -side, 0.0)]
    if not planar:
        walls += [Plane((0, 1, 0), 0.0, 0.0), Plane((0, -1, 0), -side, 0.0)]
    return Scene(
        [Body(Sphere(radius), float(m), p, friction=friction) for m, p in zip(masses, at + shift, strict=True)],
        walls,
        planar=planar,
    )


def incline(angle: float = 0.4, friction: float = 0.5, planar: bool = True, size: float = 1.0) -> Scene:
    """A block at rest on a plane that rises towards +x by `angle` [rad]: it slides if tan(angle) > friction."""
    up = np.array([-np.sin(angle), 0.0, np.cos(angle)])
    half = (size / 2, size / 2, size / 4)
    block = Body(Box(half), 1.0, up * size / 4, about_y(angle), friction=friction)
    return Scene([block], (Plane(up, 0.0, friction),), planar=planar)
