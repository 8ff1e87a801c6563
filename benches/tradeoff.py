"""Work and precision of every method, and the drift of a stack: `python benches/tradeoff.py [NAME ... | --redraw]`.

Writes `benches/record/tradeoff.csv`, `drift.csv`, `tradeoff.md` and the figures of `docs/figures/`; with `--redraw`,
the tables and figures again from the recorded rows; with names of families, or `stack`, those alone are measured again.
`LCPSTAR_CORPUS` adds published contact problems.
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
ROWS, STEPS_FILE, TEXT = RECORD / "tradeoff.csv", RECORD / "drift.csv", RECORD / "tradeoff.md"
STACK = "stack"
BUDGET = 300.0
STEPS = 1000
#: What the guide shows of the work-precision diagrams.
SHOWN = ("random_spd", "box_stack_1e6", "sphere_pile", "friction", "heavy_on_light", "pyramid_wall", "american_put")


def measure(names: list[str]) -> None:
    """Measure the families named, `stack` for the drift; rows of other families stay as they are recorded."""
    begin = time.monotonic()
    kept = [row for row in table.read_rows(ROWS) if row.family not in names] if ROWS.exists() else []
    chosen = families.chosen([name for name in names if name != STACK])
    rows = list(tradeoff.run(chosen, methods.chosen(None), budget=BUDGET, progress=True))
    order = families.NAMES.index
    table.write_rows(ROWS, sorted(kept + rows, key=lambda row: order(row.family)))
    if STACK in names:
        entries = [entry for entry in methods.chosen(None) if entry.rung == "float64"]
        steps = list(drift.run(entries, STEPS, progress=True))
        drift.write_steps(STEPS_FILE, steps, every=10)
        stack = drift.drift_table(steps, STEPS)
    else:
        stack = recorded_stack()
    took = (time.monotonic() - begin) / 60
    what = "Everything" if not kept else f"{', '.join(names)} (the rest earlier)"
    TEXT.write_text(
        f"# Work and precision\n\n{environment('make bench-tradeoff')}\n"
        f"Times are processor time. {what} was measured in {took:.0f} minutes.\n\n"
        f"A stack of 10 boxes, the top 10^6 times heavier, 16 ms to solve a step, {STEPS} steps:\n\n{stack}\n\n",
        encoding="utf-8",
    )


def recorded_stack() -> str:
    """The table of the stack as it is recorded."""
    heading = TEXT.read_text(encoding="utf-8").split("## ")[0]
    return heading[heading.index("| method") :].strip()


def blocks(rows: list[table.Row], stack: str) -> dict[str, str]:
    """The tables that the guide shows, by the name of their place in it."""
    kinds = {"float": "the answer at 1e-10", "exact": "the proved answer"}
    ratios = report.loose_ratios(rows)
    medians = [
        f"{table.middle(values):.1f} for {kinds[kind]} ({len(values)} problems)"
        for kind, values in ratios.items()
        if values
    ]
    return {
        "fastest": report.fastest_table(rows),
        "auto": report.auto_table(rows),
        "auto warm": report.auto_table(rows, "warm"),
        "reach": report.reach_table(rows),
        "loose": f"Time over that of `tol=1e-3`, median: {'; '.join(medians)}.",
        "stack": stack,
    }


def fill(text: str, tables: dict[str, str]) -> str:
    """The guide with each table between its markers `<!-- NAME -->` and `<!-- end -->`."""
    for name, content in tables.items():
        before, after = text.split(f"<!-- {name} -->\n", 1)
        after = after.split("<!-- end -->", 1)[1]
        text = f"{before}<!-- {name} -->\n{content}\n<!-- end -->{after}"
    return text


def main(arguments: list[str]) -> None:
    if arguments != ["--redraw"]:
        measure(arguments or [*families.chosen(None), STACK])
    rows, steps, stack = table.read_rows(ROWS), drift.read_steps(STEPS_FILE), recorded_stack()
    heading = TEXT.read_text(encoding="utf-8").split("## ")[0]
    TEXT.write_text(heading + "## Summary\n\n" + report.summary(rows) + "\n", encoding="utf-8")
    GUIDE.write_text(fill(GUIDE.read_text(encoding="utf-8"), blocks(rows, stack)), encoding="utf-8")
    FIGURES.mkdir(exist_ok=True)
    figures = {f"work_precision_{name}": plots.work_precision(rows, name) for name in SHOWN}
    figures |= {"profiles": plots.profiles(rows), "profiles_warm": plots.profiles(rows, start="warm")}
    figures |= {"success_map": plots.success_map(rows), "drift": plots.drift(steps)}
    for name, figure in figures.items():
        print(plots.save(figure, FIGURES / f"{name}.png"))
    print(TEXT.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main(sys.argv[1:])
