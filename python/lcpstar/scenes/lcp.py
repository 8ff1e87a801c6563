"""The LCPs of a scene at one moment, for those who want the problems and not the motion."""

from __future__ import annotations

from ..coerce import Matrix, Vector
from ..errors import OptionError
from .assembly import Island, Stepping, System
from .collide import find_contacts
from .contact import Contacts
from .scene import Scene
from .stepping import Stepper


def lcps(
    scene: Scene, dt: float = 0.01, facets: int = 4, contacts: Contacts | None = None, reach: float = 10.0
) -> list[Island]:
    """The LCP of each island that has contacts, in the order of bodies: `.A`, `.q`, and what the variables mean.

    `contacts` from one's own collision detection (`Contacts.of`), or found here. Contacts that open faster than
    `reach dt |g|` without impulses are left out. The scene does not change. Cost: see `System`.
    """
    found = find_contacts(scene, dt) if contacts is None else contacts
    system = System(scene, found, Stepping(dt, facets, reach=reach))
    included = system.may_act()
    home = system.island_of(included)
    every = sorted({int(i) for i in home if i >= 0})
    return [island for island in system.islands(included, home, every) if len(island.q)]


def lcp(scene: Scene, dt: float = 0.01, facets: int = 4, settle: int = 0) -> tuple[Matrix, Vector]:
    """`(A, q)` of the largest island, after `settle` steps by `method="auto"`; the scene does not change.

    Examples
    --------
    >>> from lcpstar import scenes, solve
    >>> A, q = scenes.lcp(scenes.heavy_on_light(10, mass_ratio=1e6))
    >>> A.shape, solve(A, q).success
    ((80, 80), True)
    """
    scene = scene.copy()
    stepper = Stepper(scene, dt, facets=facets)
    for _ in range(settle):
        stepper.step()
    problems = lcps(scene, dt, facets)
    if not problems:
        raise OptionError(f"the scene has no contact that can act at time {scene.time:g} s")
    largest = max(problems, key=lambda island: len(island.q))
    return largest.A, largest.q
