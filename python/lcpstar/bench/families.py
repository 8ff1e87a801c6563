"""The families of the work-precision benchmark: named groups of instances, reproducible by seed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import problems, scenes
from ..coerce import Matrix, Vector
from ..errors import UnknownNameError
from ..problems import Problem

SEEDS = (1, 2)


@dataclass(frozen=True)
class Group:
    """Instances that share a cell of the benchmark. `parameter` is a mass ratio or a condition number, else `nan`."""

    problem: str
    instances: list[Problem]
    parameter: float = float("nan")

    @property
    def n(self) -> int:
        """The order of the largest instance."""
        return max(len(q) for _, q in self.instances)


@dataclass(frozen=True)
class Family:
    """A family: `build(size, seed)` for each of `sizes`; a quick run takes the first alone."""

    name: str
    title: str
    build: Callable[[int, int], Problem]
    sizes: tuple[int, ...]

    def groups(self, quick: bool) -> Iterator[Group]:
        """One group per size."""
        for size in self.sizes[:1] if quick else self.sizes:
            instances = [self.build(size, seed) for seed in SEEDS[: 1 if quick else None]]
            yield Group(str(len(instances[0][1])), instances)


def american_put(n: int, seed: int) -> Problem:
    """One implicit step of an American put on a uniform grid: an unsymmetric tridiagonal M-matrix.

    Strike 1, rate 5 %, volatility 20 to 40 % (by seed), one of 50 steps to a maturity of one year; z is the price above
    the payoff.
    """
    rate, volatility, step = 0.05, 0.15 + 0.05 * seed, 1 / 50
    i = np.arange(1.0, n + 1)
    price = 4.0 * i / (n + 1)
    a, b = 0.5 * volatility**2 * i**2, 0.5 * rate * i
    A = np.diag(1 + step * (2 * a + rate)) - np.diag(step * (a + b)[:-1], 1) - np.diag(step * (a - b)[1:], -1)
    payoff = np.maximum(1.0 - price, 0.0)
    known = payoff.copy()
    known[0] += step * (a[0] - b[0])  # the price at S = 0 is the strike
    return A, A @ payoff - known


def disturbed(scene: scenes.Scene, seed: int) -> Problem:
    """The largest LCP of a planar scene at the moment when every body was given a velocity of about 1 cm/s."""
    noise = np.random.default_rng(seed).standard_normal(scene.velocity.shape)
    scene.velocity = scene.velocity + 1e-2 * noise * (1.0, 0.0, 1.0)
    return scenes.lcp(scene)


FAMILIES: tuple[Family, ...] = (
    Family("random_spd", "random, symmetric positive definite", problems.random_spd, (16, 64, 256)),
    Family("psd_half_rank", "random, PSD of rank n/2", problems.psd_half_rank, (16, 64, 256)),
    Family("box_stack", "stack of boxes, equal masses", lambda k, s: problems.box_stack(k, 1.0, seed=s), (4, 16, 50)),
    Family(
        "box_stack_1e6",
        "stack of boxes, mass ratio 1e6, heavy on light",
        lambda k, s: problems.box_stack(k, 1e6, seed=s),
        (4, 16, 50),
    ),
    Family("sphere_pile", "pile of spheres, equal masses", lambda k, s: problems.sphere_pile(k, 1.0, s), (8, 32, 150)),
    Family("friction", "contacts with friction (Stewart-Trinkle)", problems.stewart_trinkle, (4, 12, 50)),
    Family(
        "heavy_on_light",
        "scene: heavy box on light ones, mass ratio 1e6, friction",
        lambda k, s: disturbed(scenes.heavy_on_light(k, mass_ratio=1e6), s),
        (3, 10, 25),
    ),
    Family(
        "pyramid_wall", "scene: wall of bricks, friction", lambda k, s: disturbed(scenes.pyramid_wall(k), s), (2, 4, 6)
    ),
    Family("arch", "scene: masonry arch, friction", lambda k, s: disturbed(scenes.arch(k), s), (5, 11, 25)),
    Family("degenerate", "degenerate, PSD with integers", problems.degenerate, (16, 64, 128)),
    Family("badly_scaled", "badly scaled, rows and columns times 10^(-8..8)", problems.badly_scaled, (16, 64)),
    Family("obstacle", "string over an obstacle", lambda n, s: problems.obstacle_1d(n), (16, 64, 256)),
    Family("american_put", "American put, one implicit step", american_put, (16, 64, 256)),
)

#: Sweeps of one parameter, for the success maps.
CONDITION = "condition_number"
MASS = "mass_ratio"
SWEEPS: tuple[str, ...] = (CONDITION, MASS)
_SWEEP_VALUES = {CONDITION: [10.0**k for k in range(0, 17, 2)], MASS: [10.0**k for k in range(9)]}

CORPUS_CONTACT = "corpus_contact"
#: Not measured from a warm start.
COLD_ONLY: tuple[str, ...] = (*SWEEPS, CORPUS_CONTACT)
_CONTACT_FILES = ("fclib_", "siconos_fc_", "dart_", "batch_dartfork_")
_PER_BATCH = 3

NAMES: tuple[str, ...] = (*(family.name for family in FAMILIES), *SWEEPS, CORPUS_CONTACT)
TITLES: dict[str, str] = {family.name: family.title for family in FAMILIES} | {
    CONDITION: "SPD of order 50, condition number",
    MASS: "stack of 10 boxes, mass ratio top to bottom",
    CORPUS_CONTACT: "published contact problems",
}


def conditioned(n: int, condition: float, seed: int) -> Problem:
    """SPD, eigenvalues spaced geometrically from 1 to `1/condition`; the solution is planted."""
    rng = np.random.default_rng(seed)
    Q = np.linalg.qr(rng.standard_normal((n, n)))[0]
    A = (Q * np.geomspace(1.0, 1.0 / condition, n)) @ Q.T
    A = (A + A.T) / 2
    z = np.maximum(rng.standard_normal(n), 0.0)
    w = np.where(z > 0, 0.0, rng.random(n))
    return A, w - A @ z


def groups(name: str, quick: bool) -> Iterator[Group]:
    """The groups of a family, a sweep or the corpus; the corpus is empty unless `LCPSTAR_CORPUS` names its folder."""
    if name == CORPUS_CONTACT:
        yield from _corpus(quick)
    elif name in SWEEPS:
        values = _SWEEP_VALUES[name]
        for value in values[::4] if quick else values:
            seeds = SEEDS[: 1 if quick else None]
            if name == CONDITION:
                instances = [conditioned(50, value, seed) for seed in seeds]
            else:
                instances = [problems.box_stack(10, value, seed=seed) for seed in seeds]
            yield Group(f"{value:.0e}", instances, value)
    else:
        yield from next(family for family in FAMILIES if family.name == name).groups(quick)


def chosen(names: list[str] | None) -> list[str]:
    """These names, all for `None`; the corpus only where it is there, unless it is asked for by name."""
    if names is None:
        return [name for name in NAMES if name != CORPUS_CONTACT or os.environ.get("LCPSTAR_CORPUS")]
    for name in names:
        if name not in NAMES:
            raise UnknownNameError(f"family must be one of {', '.join(NAMES)}, got {name!r}")
        if name == CORPUS_CONTACT and not os.environ.get("LCPSTAR_CORPUS"):
            raise UnknownNameError(
                f"family {name} needs the environment variable LCPSTAR_CORPUS: a folder of .npz files"
            )
    return [name for name in NAMES if name in names]


def _corpus(quick: bool) -> Iterator[Group]:
    folder = Path(os.environ["LCPSTAR_CORPUS"])
    paths = sorted(path for path in folder.glob("*.npz") if path.name.startswith(_CONTACT_FILES))
    for path in paths[:3] if quick else paths:
        with np.load(path, allow_pickle=False) as file:
            A, q = file["A"], file["q"]
        single = A.ndim == 2
        instances = [(A, q)] if single else list(zip(A[:_PER_BATCH], q[:_PER_BATCH], strict=True))
        yield Group(path.stem, [(as_double(A), as_double(q)) for A, q in instances])


def as_double(array: Matrix | Vector) -> Matrix:
    """C-ordered doubles."""
    return np.ascontiguousarray(array, dtype=np.float64)


def previous_step(A: Matrix, q: Vector, seed: int) -> Problem:
    """The problem of the step before: `q` with each entry raised by up to 1 % of its size, which keeps it feasible."""
    return A, q + 0.01 * np.abs(q) * np.random.default_rng([seed, 7]).random(len(q))
