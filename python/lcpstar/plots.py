"""Pictures of measurements: work-precision diagrams, performance profiles, success maps. Needs matplotlib.

Every function returns a `matplotlib.figure.Figure`, which shows itself in a notebook; `save` writes it as `.png` or
`.svg`. Pictures of small problems are in `lcpstar.cones`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .bench import families
from .bench.drift import FALLEN, Step, by_method
from .bench.table import Row, groups, seconds_to
from .errors import MissingPackageError, OptionError

#: Line of each method: colour (Okabe and Ito's palette, safe for colour-blind readers), dash, marker. Pairs that share
#: a colour differ by dash and marker, and every line carries its name.
STYLES: dict[str, tuple[str, str, str]] = {
    "auto": ("#000000", "-", "o"),
    "auto, float32": ("#777777", ":", "v"),
    "auto, exact": ("#777777", "--", "^"),
    "lemke": ("#0072B2", "-", "s"),
    "principal_pivoting": ("#0072B2", "--", "D"),
    "block_pivoting": ("#56B4E9", "-", "s"),
    "newton": ("#56B4E9", "--", "D"),
    "interior_point": ("#CC79A7", "-", "o"),
    "interior_point, no finish": ("#CC79A7", "--", "P"),
    "potential_reduction": ("#CC79A7", ":", "X"),
    "pgs": ("#D55E00", "-", "s"),
    "pgs_sm": ("#D55E00", "--", "D"),
    "nncg": ("#E69F00", "-", "o"),
    "apgd": ("#E69F00", "--", "P"),
    "admm": ("#009E73", "-", "s"),
}
_OTHER = ("#777777", "-.", ".")
_FLOOR = 1e-17  # residuals below are drawn here
_PROFILE_RUNGS = ("auto, float32", "auto, exact")  # not compared in profiles: they answer another question


def new_figure(width: float, height: float) -> Any:
    """An empty figure, or MissingPackageError with the command that installs matplotlib."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingPackageError("plots need matplotlib: pip install 'lcpstar[plot]'") from error
    return Figure(figsize=(width, height), layout="constrained")


def save(figure: Any, path: Path) -> Path:
    """Write `.svg`, or `.png` with 256 colours at 110 dots per inch, which keeps it small."""
    if path.suffix not in (".png", ".svg"):
        raise OptionError(f"a picture must end in .png or .svg, got {path.name!r}")
    if path.suffix == ".svg":
        figure.savefig(path, metadata={"Date": None})
        return path
    from io import BytesIO

    from PIL import Image  # comes with matplotlib

    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    Image.open(buffer).convert("RGB").quantize(128, dither=Image.Dither.NONE).save(path, optimize=True)
    return path


def work_precision(rows: Sequence[Row], family: str, start: str = "cold", panels: int = 3) -> Any:
    """Time against achieved residual, a line per method, a panel per size: the lower and the more right, the better.

    Each point is one `tol`; the residual is the one that the benchmark recomputed. Of a family with more than `panels`
    problems, the largest are shown.
    """
    of_family = groups([row for row in rows if row.family == family and row.start == start])
    if not of_family:
        raise OptionError(f"no rows of family {family!r} with a {start} start")
    chosen = sorted(of_family.values(), key=lambda members: members[0].n)[-panels:]
    figure = new_figure(1.2 + 4.4 * len(chosen), 4.6)
    axes = figure.subplots(1, len(chosen), squeeze=False)[0]
    for axis, members in zip(axes, chosen, strict=True):
        _work_precision_panel(axis, members)
        name = "" if members[0].problem == str(members[0].n) else f"{members[0].problem}, "
        axis.set_title(f"{name}n = {members[0].n}", fontsize=9)
    axes[0].set_ylabel("seconds per solve")
    figure.suptitle(f"{families.TITLES.get(family, family)}, {start} start", fontsize=11)
    return figure


def _work_precision_panel(axis: Any, rows: Sequence[Row]) -> None:
    ends = []
    for method in dict.fromkeys(row.method for row in rows):
        points = [(max(row.residual, _FLOOR), row.seconds) for row in rows if row.method == method]
        points = [(min(x, 1.0), y) for x, y in points]
        colour, dash, marker = STYLES.get(method, _OTHER)
        width = 2.0 if method == "auto" else 1.1
        axis.plot(*zip(*points, strict=True), dash, color=colour, marker=marker, ms=3.5, lw=width)
        ends.append((*min(points), method, colour))
    axis.set(xscale="log", yscale="log", xlabel="achieved residual (more accurate to the right)")
    axis.set_xlim(2.0, _FLOOR / 2)
    axis.set_xticks([1.0, 1e-4, 1e-8, 1e-12, 1e-16])
    axis.grid(True, which="major", lw=0.3, color="#cccccc")
    axis.tick_params(labelsize=8)
    _label_ends(axis, ends)


def _label_ends(axis: Any, ends: Sequence[tuple[float, float, str, str]]) -> None:
    """Names beside the axis at the height of the last point of each line, moved apart where they would touch."""
    to_axes = axis.transScale + axis.transLimits
    placed = sorted((float(to_axes.transform((x, y))[1]), x, y, name, colour) for x, y, name, colour in ends)
    heights = spread([height for height, *_ in placed], 0.052)
    for (_, x, y, name, colour), height in zip(placed, heights, strict=True):
        axis.annotate(
            name,
            (x, y),
            xytext=(1.03, height),
            textcoords="axes fraction",
            color=colour if colour != "#56B4E9" else "#2a85b8",  # the light blue is hard to read
            fontsize=7.5,
            va="center",
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "lw": 0.4, "color": colour, "shrinkA": 0, "shrinkB": 2},
        )


def spread(heights: Sequence[float], gap: float) -> list[float]:
    """Ascending heights moved apart to a distance of at least `gap`, as little as a pass up and a pass down allow.

    >>> [round(h, 2) for h in spread([0.5, 0.5, 0.9], 0.1)]
    [0.5, 0.6, 0.9]
    """
    placed: list[float] = []
    for height in heights:
        placed.append(max(height, placed[-1] + gap) if placed else height)
    limit = max(1.0, (len(placed) - 1) * gap)
    for i in reversed(range(len(placed))):
        placed[i] = min(placed[i], limit)
        limit = placed[i] - gap
    return placed


def profiles(rows: Sequence[Row], accuracies: Sequence[float] = (1e-3, 1e-6, 1e-12), start: str = "cold") -> Any:
    """Performance profiles of Dolan and More: the share of problems on which a method is within a factor of the best.

    A method has solved a problem to an accuracy when the recomputed residual is below it, whatever `tol` it was given;
    its time is the least of those. The height at 1 is how often it is the fastest, the height at the right how often it
    succeeds at all. [DM02].
    """
    compared = [row for row in rows if row.start == start and row.family not in families.SWEEPS]
    compared = [row for row in compared if row.method not in _PROFILE_RUNGS]
    if not compared:
        raise OptionError(f"no rows with a {start} start outside the sweeps")
    figure = new_figure(1.2 + 4.4 * len(accuracies), 4.4)
    axes = figure.subplots(1, len(accuracies), squeeze=False)[0]
    problems = list(groups(compared).values())
    for axis, accuracy in zip(axes, accuracies, strict=True):
        _profile_panel(axis, problems, accuracy)
        axis.set_title(f"achieved residual {accuracy:.0e}", fontsize=9)
    axes[0].set_ylabel(f"share of {len(problems)} problems")
    figure.suptitle(f"Solved within a factor of the fastest method's time, {start} start", fontsize=11)
    return figure


def profile(problems: Sequence[Sequence[Row]], method: str, methods: Sequence[str], accuracy: float) -> list[float]:
    """For each problem, the method's time over the fastest method's; `inf` where it does not achieve the accuracy."""
    ratios = []
    for rows in problems:
        best = min(seconds_to(rows, name, accuracy) for name in methods)
        time = seconds_to(rows, method, accuracy)
        ratios.append(time / best if math.isfinite(time) else math.inf)
    return ratios


def _profile_panel(axis: Any, problems: Sequence[Sequence[Row]], accuracy: float) -> None:
    methods = list(dict.fromkeys(row.method for rows in problems for row in rows))
    farthest, ends = 100.0, []
    for method in methods:
        ratios = sorted(ratio for ratio in profile(problems, method, methods, accuracy) if ratio <= farthest)
        xs = [1.0, *(x for ratio in ratios for x in (ratio, ratio)), farthest]
        steps = [k / len(problems) for k in range(len(ratios) + 1) for _ in (0, 1)]
        colour, dash, _ = STYLES.get(method, _OTHER)
        axis.plot(xs, steps, dash, color=colour, lw=2.0 if method == "auto" else 1.1)
        ends.append((farthest, len(ratios) / len(problems), method, colour))
    axis.set(xscale="log", xlim=(1, farthest), ylim=(0, 1.02), xlabel="time / fastest time")
    axis.grid(True, lw=0.3, color="#cccccc")
    axis.tick_params(labelsize=8)
    _label_ends(axis, ends)


def success_map(rows: Sequence[Row], accuracy: float = 1e-6) -> Any:
    """Digits that each method achieves over condition number and mass ratio; a cross where it misses `accuracy`."""
    sweeps = [name for name in families.SWEEPS if any(row.family == name for row in rows)]
    if not sweeps:
        raise OptionError(f"no rows of {' or '.join(families.SWEEPS)}")
    figure = new_figure(2.2 + 4.6 * len(sweeps), 4.6)
    axes = figure.subplots(1, len(sweeps), squeeze=False)[0]
    for axis, sweep in zip(axes, sweeps, strict=True):
        picture = _map_panel(axis, [row for row in rows if row.family == sweep], accuracy)
        axis.set_title(families.TITLES[sweep], fontsize=9)
    figure.colorbar(picture, ax=axes, label="digits achieved, -log10(residual)", shrink=0.8)
    figure.suptitle(f"What survives the extremes (x: residual above {accuracy:.0e})", fontsize=11)
    return figure


def _map_panel(axis: Any, rows: Sequence[Row], accuracy: float) -> Any:
    methods = list(dict.fromkeys(row.method for row in rows))
    values = sorted({row.parameter for row in rows})
    best = {(row.method, row.parameter): row.residual for row in rows}
    digits = [[min(16.0, max(0.0, -math.log10(max(best.get((m, v), 1.0), _FLOOR)))) for v in values] for m in methods]
    picture = axis.imshow(digits, cmap="cividis", vmin=0, vmax=16, aspect="auto")
    for i, method in enumerate(methods):
        for j, value in enumerate(values):
            if not best.get((method, value), math.inf) <= accuracy:
                axis.text(j, i, "x", ha="center", va="center", color="white", fontsize=8)
    axis.set_xticks(range(len(values)), [f"1e{round(math.log10(value))}" for value in values], fontsize=8)
    axis.set_yticks(range(len(methods)), methods, fontsize=8)
    return picture


def drift(steps: Sequence[Step]) -> Any:
    """How far each method's stack has moved over the steps, and how long its steps took: median to 99 of 100."""
    runs = by_method(steps)
    if not runs:
        raise OptionError("no steps to draw")
    first = steps[0]
    figure = new_figure(11.0, 4.6)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    ends = []
    for method, members in runs.items():
        colour, dash, _ = STYLES.get(method, _OTHER)
        heights = [min(max(step.drift, 1e-12), 10.0) for step in members]
        left.plot([s.step for s in members], heights, dash, color=colour, lw=2.0 if method == "auto" else 1.1)
        ends.append((float(members[-1].step), heights[-1], method, colour))
    left.axhline(FALLEN, color="black", lw=0.6, ls=":")
    left.set(yscale="log", ylim=(1e-12, 20.0), xlim=(0, max(step.step for step in steps)), xlabel="step")
    left.set_ylabel("farthest that a box has moved [m]")
    _label_ends(left, ends)
    for place, (method, members) in enumerate(reversed(runs.items())):
        colour = STYLES.get(method, _OTHER)[0]
        times = sorted(1e3 * step.step_seconds for step in members)
        span = times[len(times) // 2], times[min(len(times) - 1, int(0.99 * len(times)))]
        right.plot(span, (place, place), "-", color=colour, lw=2)
        right.plot(span[0], place, "o", color=colour, ms=5)
    right.axvline(1e3 * first.budget, color="black", lw=0.6, ls=":")
    right.set_yticks(range(len(runs)), list(reversed(runs)), fontsize=8)
    fastest, slowest = (1e3 * pick(step.step_seconds for step in steps) for pick in (min, max))
    right.set(xscale="log", xlabel="ms per step, all included", xlim=(fastest / 1.5, 1.5 * slowest))
    ticks = [tick for tick in (0.1, 0.3, 1, 3, 10, 30, 100, 300) if fastest / 1.5 <= tick <= 1.5 * slowest]
    right.set_xticks(ticks, map(str, ticks))
    right.minorticks_off()
    for axis in (left, right):
        axis.grid(True, lw=0.3, color="#cccccc")
    stack = f"{first.boxes} boxes, the top {first.mass_ratio:.0e} times heavier"
    figure.suptitle(f"{stack}, {1e3 * first.budget:.3g} ms to solve a step", fontsize=11)
    return figure


def figures(rows: Sequence[Row]) -> dict[str, Any]:
    """Every figure that the rows allow, by name."""
    drawn: dict[str, Any] = {}
    names = list(dict.fromkeys(row.family for row in rows))
    for name in names:
        if name not in families.SWEEPS:
            for start in dict.fromkeys(row.start for row in rows if row.family == name):
                drawn[f"work_precision_{name}_{start}"] = work_precision(rows, name, start)
    if drawn:
        drawn["profiles"] = profiles(rows)
    if any(name in families.SWEEPS for name in names):
        drawn["success_map"] = success_map(rows)
    return drawn
