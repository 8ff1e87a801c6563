"""What happened: a record per step, and arrays over all of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..coerce import Matrix, Vector
from .measures import PhysicalErrors
from .scene import Scene


@dataclass(frozen=True)
class StepRecord:
    """One step: the LCPs it needed, how they were solved, and what the answers are worth.

    `rows` of all LCPs together, the order of the `largest`, `islands` solved, bodies `asleep`; `methods` that answered;
    `residual` and `natural_residual` the worst of all islands. After the step: `energy` [J], and `joint_error` [m], how
    far the two anchors of a joint are apart at most. `seconds` for the whole step, `solve_seconds` for assembling and
    solving the LCPs.
    """

    time: float
    rows: int
    largest: int
    islands: int
    asleep: int
    solved: bool
    methods: tuple[str, ...]
    iterations: int
    residual: float
    natural_residual: float
    errors: PhysicalErrors
    energy: float
    joint_error: float
    solve_seconds: float
    seconds: float


class History:
    """Records of the steps of a run, and the positions before and after each step (steps + 1, n, 3).

    Every number of a record is an array over the steps: `rows`, `islands`, `solved`, `residual`, `seconds`, `energy`,
    `penetration`, `penetration_velocity`, `cone_violation`, `signorini`, `dissipation`, `joint_error`, ... with the
    units of `StepRecord` and `PhysicalErrors`.
    """

    def __init__(self, scene: Scene) -> None:
        self.records: list[StepRecord] = []
        self.initial_energy = scene.energy()
        self._position = [scene.position.copy()]
        self._movable = scene.dynamic

    def add(self, scene: Scene, record: StepRecord) -> None:
        """Append a step."""
        self.records.append(record)
        self._position.append(scene.position.copy())

    def __len__(self) -> int:
        return len(self.records)

    def __getattr__(self, name: str) -> NDArray[np.generic]:
        if name in StepRecord.__dataclass_fields__ and name not in ("errors", "methods"):
            return np.array([getattr(r, name) for r in self.records])
        if name in PhysicalErrors.__dataclass_fields__:
            return np.array([getattr(r.errors, name) for r in self.records])
        raise AttributeError(f"History has no attribute {name!r}")

    @property
    def position(self) -> Matrix:
        """Centres of mass (steps + 1, n, 3) [m]."""
        return np.array(self._position)

    @property
    def energy_drift(self) -> Vector:
        """Energy after each step less the energy at the beginning [J]."""
        return np.array([r.energy for r in self.records]) - self.initial_energy

    @property
    def methods(self) -> dict[str, int]:
        """In how many steps each method answered for some island."""
        names = [name for r in self.records for name in r.methods]
        return {name: names.count(name) for name in sorted(set(names))}

    def drift(self) -> Vector:
        """Largest distance of a body from where it began, after each step [m]: for scenes that should stand."""
        moved = self.position[1:] - self._position[0]
        return np.asarray(np.sqrt(np.square(moved[:, self._movable]).sum(axis=2)).max(axis=1, initial=0.0))

    def __str__(self) -> str:
        if not self.records:
            return "no steps"
        ms = 1e3 * np.array([r.seconds for r in self.records])
        unsolved = sum(not r.solved for r in self.records)
        lines = [
            f"{len(self)} steps, rows <= {self.rows.max()}, islands <= {self.islands.max()}",
            f"solved in {len(self) - unsolved} of {len(self)} steps, residual <= {self.residual.max():.1e}",
            f"step              {np.median(ms):.2f} ms median, {ms.max():.2f} ms longest",
            f"drift             {self.drift().max():.3g} m, energy {self.energy_drift[-1]:+.3g} J",
            f"penetration       {self.penetration.max():.2g} m, {self.penetration_velocity.max():.2g} m/s",
            f"joints            {self.joint_error.max():.2g} m, {self.joint_velocity.max():.2g} m/s",
            f"cone violation    {self.cone_violation.max():.2g} N s",
            f"Signorini         {self.signorini.max():.2g} J, dissipation {self.dissipation.max():.2g} J",
        ]
        return "\n".join(lines)
