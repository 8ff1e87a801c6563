"""Work and precision of every method, and the drift of a stack: `python benches/tradeoff.py [--redraw]`.

Writes `benches/record/tradeoff.csv`, `drift.csv`, `tradeoff.md` and the figures of `docs/figures/`; with `--redraw`,
the tables and figures again from the recorded rows. `LCPSTAR_CORPUS` adds published contact problems.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from harness import RECORD, environment
from lcpstar import plots
from lcpstar.bench import drift, families, methods, report, table, tradeoff

DOCS = Path(__file__).parent.parent / "docs"
FIGURES, GUIDE = DOCS / "figures", DOCS / "guide.md"
BUDGET = 400.0
STEPS = 1000
#: What the guide shows of the work-precision diagrams.
SHOWN = ("random_spd", "box_stack_1e6", "sphere_pile", "friction", "heavy_on_light", "pyramid_wall", "american_put")


def measure() -> tuple[list[table.Row], list[drift.Step], float]:
    begin = time.monotonic()
    rows = list(tradeoff.run(families.chosen(None), methods.chosen(None), budget=BUDGET, progress=True))
    entries = [entry for entry in methods.chosen(None) if entry.rung == "float64"]
    steps = list(drift.run(entries, STEPS, progress=True))
    return rows, steps, time.monotonic() - begin


def blocks(rows: list[table.Row], stack: str) -> dict[str, str]:
    """The tables that the guide shows, by the name of their place in it."""
    kinds = {"float": "the answer at 1e-10", "exact": "the proved answer"}
    ratios = report.loose_ratios(rows)
    medians = [
        f"{table.middle(values):.1f} times faster than {kinds[kind]} ({len(values)} problems)"
        for kind, values in ratios.items()
        if values
    ]
    return {
        "fastest": report.fastest_table(rows),
        "auto": report.auto_table(rows),
        "auto warm": report.auto_table(rows, "warm"),
        "reach": report.reach_table(rows),
        "loose": f"Median: {'; '.join(medians)}.\n\n{report.loose_table(rows)}",
        "stack": stack,
    }


def fill(text: str, tables: dict[str, str]) -> str:
    """The guide with each table between its markers `<!-- NAME -->` and `<!-- end -->`."""
    for name, content in tables.items():
        before, after = text.split(f"<!-- {name} -->\n", 1)
        after = after.split("<!-- end -->", 1)[1]
        text = f"{before}<!-- {name} -->\n{content}\n<!-- end -->{after}"
    return text


def main(redraw: bool) -> None:
    rows_file, steps_file, text_file = RECORD / "tradeoff.csv", RECORD / "drift.csv", RECORD / "tradeoff.md"
    if redraw:
        heading = text_file.read_text(encoding="utf-8").split("## ")[0]
    else:
        rows, steps, took = measure()
        table.write_rows(rows_file, rows)
        drift.write_steps(steps_file, steps, every=10)
        stack = drift.drift_table(steps, STEPS)
        heading = (
            f"# Work and precision\n\n{environment('make bench-tradeoff')}\n"
            f"Times are processor time; the whole run took {took / 60:.0f} minutes.\n\n"
            f"A stack of 10 boxes, the top 10^6 times heavier, 16 ms to solve a step, {STEPS} steps:\n\n{stack}\n\n"
        )
    rows, steps = table.read_rows(rows_file), drift.read_steps(steps_file)
    text_file.write_text(heading + "## Summary\n\n" + report.summary(rows) + "\n", encoding="utf-8")
    stack = heading[heading.index("| method") :].strip()
    GUIDE.write_text(fill(GUIDE.read_text(encoding="utf-8"), blocks(rows, stack)), encoding="utf-8")
    FIGURES.mkdir(exist_ok=True)
    figures = {f"work_precision_{name}": plots.work_precision(rows, name) for name in SHOWN}
    figures |= {"profiles": plots.profiles(rows), "profiles_warm": plots.profiles(rows, start="warm")}
    figures |= {"success_map": plots.success_map(rows), "drift": plots.drift(steps)}
    for name, figure in figures.items():
        print(plots.save(figure, FIGURES / f"{name}.png"))
    print(text_file.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main("--redraw" in sys.argv[1:])
