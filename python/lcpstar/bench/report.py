"""What the measured rows say: tables in Markdown, every number from the rows."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from .families import CORPUS_CONTACT, SWEEPS, TITLES
from .methods import APPROXIMATE, SINGLE
from .table import Row, at_tolerance, best_single, groups, middle, seconds_to

ACCURACIES = (1e-3, 1e-6, 1e-12)


def duration(seconds: float) -> str:
    """A time that a person reads.

    >>> duration(2.34e-5), duration(0.5)
    ('23 us', '500 ms')
    """
    if not math.isfinite(seconds):
        return "-"
    unit, scale = ("us", 1e6) if seconds < 1e-3 else ("ms", 1e3) if seconds < 1 else ("s", 1.0)
    value = seconds * scale
    return f"{value:.3g} {unit}" if value < 100 else f"{value:.0f} {unit}"


def fastest_table(rows: Sequence[Row], start: str = "cold") -> str:
    """For the largest problem of each family, the fastest single method to each accuracy, and auto's time over its."""
    head = ["family", "n", *(f"{accuracy:.0e}" for accuracy in ACCURACIES)]
    lines = [_line(head), _line(["---"] * len(head))]
    for family in dict.fromkeys(row.family for row in rows):
        of_family = groups([row for row in rows if row.family == family and row.start == start])
        if family in SWEEPS or family == CORPUS_CONTACT or not of_family:
            continue
        members = max(of_family.values(), key=lambda members: members[0].n)
        cells = [_fastest(members, accuracy) for accuracy in ACCURACIES]
        lines.append(_line([TITLES.get(family, family), str(members[0].n), *cells]))
    return "\n".join(lines)


def _fastest(members: Sequence[Row], accuracy: float) -> str:
    name, best = best_single(members, accuracy, SINGLE)
    if not name:
        return "none"
    auto = at_tolerance(members, "auto", accuracy)
    if auto is None:
        return f"{name} {duration(best)}"
    share = f"{auto.seconds / best:.1f}x" if auto.residual <= accuracy else "misses"
    return f"{name} {duration(best)} (auto {share})"


def auto_table(rows: Sequence[Row], start: str = "cold") -> str:
    """Per family, the median over its problems of auto's time, asked for an accuracy, over the best single method's."""
    head = ["family", "problems", *(f"{accuracy:.0e}" for accuracy in ACCURACIES)]
    lines = [_line(head), _line(["---"] * len(head))]
    medians: dict[float, list[float]] = {accuracy: [] for accuracy in ACCURACIES}
    for family in dict.fromkeys(row.family for row in rows):
        members = list(groups([row for row in rows if row.family == family and row.start == start]).values())
        if family in SWEEPS or not members:
            continue
        cells = []
        for accuracy in ACCURACIES:
            ratios = auto_ratios(members, accuracy)
            medians[accuracy] += [middle(ratios)] if ratios else []
            cells.append(f"{middle(ratios):.2f}" if ratios else "-")
        lines.append(_line([TITLES.get(family, family), str(len(members)), *cells]))
    lines.append(_line(["**median over families**", "", *(f"**{middle(medians[a]):.2f}**" for a in ACCURACIES)]))
    return "\n".join(lines)


def auto_ratios(problems: Sequence[Sequence[Row]], accuracy: float) -> list[float]:
    """Auto's time, asked for the accuracy, over the best single method's; `inf` where auto misses it."""
    ratios = []
    for rows in problems:
        auto = at_tolerance(rows, "auto", accuracy)
        _, best = best_single(rows, accuracy, SINGLE)
        if auto is not None and math.isfinite(best):
            ratios.append(auto.seconds / best if auto.residual <= accuracy else math.inf)
    return ratios


def loose_table(rows: Sequence[Row], tol: float = 1e-3) -> str:
    """Published contact problems: how much faster `tol=1e-3` is than the exact answer, where a method can use it.

    "exact" is auto with `certify="exact"` at the tightest tolerance, "float" the same without the proof.
    """
    members = groups([row for row in rows if row.family == CORPUS_CONTACT and row.start == "cold"])
    head = [
        "problem",
        "n",
        "auto, tol=1e-3",
        "answered by",
        "fastest approximate",
        "float",
        "exact",
        "float / tol",
        "exact / tol",
    ]
    lines = [_line(head), _line(["---"] * len(head))]
    for (_, problem, _), cells in members.items():
        loose = at_tolerance(cells, "auto", tol)
        tight = at_tolerance(cells, "auto", 1e-10)
        proof = at_tolerance(cells, "auto, exact", 1e-10)
        if loose is None or tight is None:
            continue
        name, rough = best_single(cells, tol, APPROXIMATE)
        exact = proof.seconds if proof is not None and proof.solved == proof.instances else math.nan
        lines.append(
            _line(
                [
                    problem,
                    str(loose.n),
                    duration(loose.seconds) if loose.residual <= tol else "misses",
                    loose.answered_by,
                    f"{name} {duration(rough)}" if name else "none",
                    duration(tight.seconds),
                    duration(exact),
                    f"{tight.seconds / loose.seconds:.1f}",
                    f"{exact / loose.seconds:.1f}" if exact == exact else "-",
                ]
            )
        )
    return "\n".join(lines)


def loose_ratios(rows: Sequence[Row], tol: float = 1e-3) -> dict[str, list[float]]:
    """The last two columns of `loose_table`, for problems where an approximate method achieves `tol`."""
    found: dict[str, list[float]] = {"float": [], "exact": []}
    for cells in groups([row for row in rows if row.family == CORPUS_CONTACT and row.start == "cold"]).values():
        loose, tight = at_tolerance(cells, "auto", tol), at_tolerance(cells, "auto", 1e-10)
        proof = at_tolerance(cells, "auto, exact", 1e-10)
        if loose is None or tight is None or not math.isfinite(best_single(cells, tol, APPROXIMATE)[1]):
            continue
        found["float"].append(tight.seconds / loose.seconds)
        if proof is not None and proof.solved == proof.instances:
            found["exact"].append(proof.seconds / loose.seconds)
    return found


def reach_table(rows: Sequence[Row], start: str = "cold") -> str:
    """How many problems each method brings to each accuracy, and its median time over the best."""
    compared = [row for row in rows if row.start == start and row.family not in SWEEPS]
    members = list(groups(compared).values())
    head = ["method", *(f"{accuracy:.0e}" for accuracy in ACCURACIES)]
    lines = [_line(head), _line(["---"] * len(head))]
    for method in dict.fromkeys(row.method for row in compared):
        cells = []
        for accuracy in ACCURACIES:
            times = [(seconds_to(cell, method, accuracy), best_single(cell, accuracy, SINGLE)[1]) for cell in members]
            ratios = [time / best for time, best in times if math.isfinite(time) and math.isfinite(best)]
            cells.append(f"{len(ratios)} of {len(members)}, {middle(ratios):.1f}x")
        lines.append(_line([method, *cells]))
    return "\n".join(lines)


def summary(rows: Sequence[Row]) -> str:
    """All tables that the rows allow."""
    statuses = Counter(row.status for row in rows if row.residual > row.tol)
    missed = ", ".join(f"{status} {count}" for status, count in statuses.most_common())
    wrong = [
        row for row in rows if row.solved == row.instances and row.residual > row.tol and "float32" not in row.method
    ]
    parts = [
        f"{len(rows)} cells. Asked tolerance missed: {missed or 'none'}. "
        f"Cells called solved whose recomputed residual exceeds tol: {len(wrong)}.",
    ]
    if any(row.family not in SWEEPS for row in rows):
        parts += [
            "## Fastest single method to an achieved residual, largest problem of each family, cold\n\n"
            + fastest_table(rows),
            "## auto, asked for that residual, over the best single method (median over problems)\n\n"
            + auto_table(rows),
            "## Problems brought to an achieved residual, and the median time over the fastest single method's\n\n"
            + reach_table(rows),
        ]
    if any(row.family == CORPUS_CONTACT for row in rows):
        ratios = loose_ratios(rows)
        medians = ", ".join(f"{kind} {middle(values):.1f}x ({len(values)})" for kind, values in ratios.items())
        parts.append(
            "## Published contact problems: tol=1e-3 beside the exact answer\n\n"
            f"Median over the problems where an approximate method achieves 1e-3: {medians}.\n\n" + loose_table(rows)
        )
    return "\n\n".join(parts)


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"
