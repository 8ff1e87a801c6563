"""Contact scenes: rigid bodies, contacts and joints, the LCPs that they need, and time steps to watch them.

A workload generator and a front door, not a physics engine: bodies are spheres, boxes or planar polygons, and no mesh
is read. See docs/scenes.md.
"""

from .assembly import Island, Stepping, System
from .body import Body, Box, Polygon, Sphere, about_y
from .collide import find_contacts
from .contact import WORLD, Contact, Contacts
from .generators import (
    arch,
    box_stack,
    card_house,
    chain,
    heavy_on_light,
    incline,
    pyramid_wall,
    sphere_pile,
)
from .history import History, StepRecord
from .lcp import lcp, lcps
from .measures import PhysicalErrors, physical_errors
from .scene import Joint, Plane, Scene
from .stepping import Stepper, run

__all__ = [
    "Body",
    "Sphere",
    "Box",
    "Polygon",
    "about_y",
    "Plane",
    "Joint",
    "Contact",
    "Contacts",
    "WORLD",
    "Scene",
    "find_contacts",
    "System",
    "Stepping",
    "Island",
    "lcp",
    "lcps",
    "Stepper",
    "run",
    "History",
    "StepRecord",
    "PhysicalErrors",
    "physical_errors",
    "box_stack",
    "heavy_on_light",
    "pyramid_wall",
    "arch",
    "chain",
    "card_house",
    "sphere_pile",
    "incline",
]
