"""The rows that the work-precision benchmark measures: one CSV, written, read and summarised here."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from statistics import median

from ..errors import FileFormatError


@dataclass(frozen=True)
class Row:
    """One cell: a method at a tolerance on the instances of a group.

    `seconds` is the median over the instances of the time per call; `residual` the largest equilibrated residual over
    the instances, recomputed by the benchmark; `stated` the largest that the solver stated, `solved` how many it called
    solved; `answered_by` which member gave the first answer. `parameter` is a condition number or a mass ratio, or nan.
    """

    family: str
    problem: str
    n: int
    parameter: float
    method: str
    start: str
    tol: float
    instances: int
    solved: int
    seconds: float
    residual: float
    stated: float
    iterations: int
    status: str
    answered_by: str

    @property
    def group(self) -> tuple[str, str, str]:
        """What is compared with each other: a problem from a start."""
        return self.family, self.problem, self.start


_NAMES = [field.name for field in fields(Row)]
_NUMBERS = {"n": int, "instances": int, "solved": int, "iterations": int}
_REALS = ("parameter", "tol", "seconds", "residual", "stated")


def write_rows(path: Path, rows: Iterable[Row]) -> None:
    """Write the CSV; real numbers with four digits."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_NAMES)
        for row in rows:
            values = [getattr(row, name) for name in _NAMES]
            writer.writerow([f"{value:.4g}" if isinstance(value, float) else value for value in values])


def is_table(path: Path) -> bool:
    """Whether the file begins as `write_rows` writes it."""
    with path.open(encoding="utf-8", errors="replace") as file:
        return file.readline().strip() == ",".join(_NAMES)


def read_rows(path: Path) -> list[Row]:
    """The rows of a CSV that `write_rows` wrote; FileFormatError otherwise."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            if reader.fieldnames != _NAMES:
                raise FileFormatError(f"{path.name}: not a table of lcpstar bench tradeoff")
            return [_row(record) for record in reader]
    except (OSError, UnicodeDecodeError, ValueError, TypeError, KeyError) as error:
        if isinstance(error, FileFormatError):
            raise
        raise FileFormatError(f"{path.name}: {error}") from error


def _row(record: dict[str, str]) -> Row:
    values: dict[str, object] = dict(record)
    values.update({name: kind(record[name]) for name, kind in _NUMBERS.items()})
    values.update({name: float(record[name]) for name in _REALS})
    return Row(**values)  # type: ignore[arg-type]  # every field is converted above


def groups(rows: Sequence[Row]) -> dict[tuple[str, str, str], list[Row]]:
    """The rows of each group, in order of appearance."""
    found: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        found.setdefault(row.group, []).append(row)
    return found


def seconds_to(rows: Sequence[Row], method: str, accuracy: float) -> float:
    """The least time in which the method *achieved* the accuracy on every instance of a group, at any `tol`."""
    times = [row.seconds for row in rows if row.method == method and row.residual <= accuracy]
    return min(times, default=math.inf)


def best_single(rows: Sequence[Row], accuracy: float, singles: Sequence[str]) -> tuple[str, float]:
    """The fastest single method to the accuracy, and its time; `("", inf)` when none achieved it."""
    times = {method: seconds_to(rows, method, accuracy) for method in singles}
    fastest = min(times, key=times.__getitem__, default="")
    return (fastest, times[fastest]) if fastest and times[fastest] < math.inf else ("", math.inf)


def at_tolerance(rows: Sequence[Row], method: str, tol: float) -> Row | None:
    """The row of the method that was asked for `tol`."""
    return next((row for row in rows if row.method == method and math.isclose(row.tol, tol)), None)


def geometric_mean(values: Sequence[float]) -> float:
    """The geometric mean of positive numbers; nan of none."""
    return math.exp(sum(map(math.log, values)) / len(values)) if values else math.nan


def middle(values: Sequence[float]) -> float:
    """The median; nan of none."""
    return median(values) if values else math.nan
