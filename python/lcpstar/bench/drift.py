"""`lcpstar bench drift`: how far a stack moves that should stand, for each method at the same time for every step."""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from .. import scenes
from ..errors import FileFormatError
from .methods import Entry

#: A stack whose bodies have moved farther than this part of a box's size is taken to have failed.
FALLEN = 0.05


@dataclass(frozen=True)
class Step:
    """One step of one method's run: drift and penetration [m], time of the solves and of the whole step [s]."""

    method: str
    budget: float
    boxes: int
    mass_ratio: float
    step: int
    drift: float
    penetration: float
    residual: float
    solved: int
    solve_seconds: float
    step_seconds: float


def run(
    entries: Sequence[Entry],
    steps: int = 1000,
    budget: float = 0.016,
    boxes: int = 10,
    mass_ratio: float = 1e6,
    progress: bool = False,
) -> Iterator[Step]:
    """Every method moves the same planar stack, a heavy box on light ones, in steps with `budget` seconds to solve.

    A run ends early once the stack has moved by a box's size: nothing of it stands.
    """
    for entry in entries:
        if progress:
            print(f"{entry.name}: {steps} steps, {1e3 * budget:.3g} ms each", file=sys.stderr, flush=True)
        scene = scenes.heavy_on_light(boxes, mass_ratio=mass_ratio)
        stepper = scenes.Stepper(scene, method=entry.method, tol=1e-9, time_limit=budget, options=entry.options)
        start = scene.position.copy()
        for step in range(1, steps + 1):
            record = stepper.step()
            drift = float(np.sqrt(np.square(scene.position - start).sum(axis=1)).max())
            drift = drift if math.isfinite(drift) else math.inf
            yield Step(
                entry.name,
                budget,
                boxes,
                mass_ratio,
                step,
                drift,
                record.errors.penetration,
                record.residual,
                int(record.solved),
                record.solve_seconds,
                record.seconds,
            )
            if not drift < 1.0:
                break


_NAMES = [field.name for field in fields(Step)]
_INTEGERS = ("boxes", "step", "solved")


def write_steps(path: Path, steps: Sequence[Step], every: int = 1) -> None:
    """Write the CSV: every `every`-th step and the last of each method; real numbers with four digits."""
    last = {step.method: step.step for step in steps}
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_NAMES)
        for step in steps:
            if step.step % every == 0 or step.step == last[step.method]:
                values = [getattr(step, name) for name in _NAMES]
                writer.writerow([f"{value:.4g}" if isinstance(value, float) else value for value in values])


def is_drift(path: Path) -> bool:
    """Whether the file begins as `write_steps` writes it."""
    with path.open(encoding="utf-8", errors="replace") as file:
        return file.readline().strip() == ",".join(_NAMES)


def read_steps(path: Path) -> list[Step]:
    """The steps of a CSV that `write_steps` wrote; FileFormatError otherwise."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            records = list(csv.DictReader(file))
        return [
            Step(**{name: _value(name, record[name]) for name in _NAMES})  # type: ignore[arg-type]  # by name
            for record in records
        ]
    except (OSError, UnicodeDecodeError, ValueError, TypeError, KeyError) as error:
        raise FileFormatError(f"{path.name}: not a table of lcpstar bench drift: {error}") from error


def _value(name: str, text: str) -> str | int | float:
    return text if name == "method" else int(text) if name in _INTEGERS else float(text)


def by_method(steps: Sequence[Step]) -> dict[str, list[Step]]:
    """The steps of each method, in order of appearance."""
    found: dict[str, list[Step]] = {}
    for step in steps:
        found.setdefault(step.method, []).append(step)
    return found


def drift_table(steps: Sequence[Step], planned: int) -> str:
    """How each method ended, in Markdown."""
    lines = [
        "| method | outcome | drift after the run | steps solved | step, median | step, 99 of 100 below |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for method, members in by_method(steps).items():
        final = members[-1].drift
        largest = max(step.drift for step in members)
        fell = next((step.step for step in members if step.drift > FALLEN), None)
        outcome = f"fallen at step {fell}" if fell else "stands" if len(members) == planned else "stopped"
        times = 1e3 * np.array([step.step_seconds for step in members])
        solved = sum(step.solved for step in members)
        lines.append(
            f"| {method} | {outcome} | {final:.2g} m (largest {largest:.2g} m) | {solved} of {len(members)} | "
            f"{np.median(times):.2f} ms | {np.quantile(times, 0.99):.2f} ms |"
        )
    return "\n".join(lines)
