"""`lcpstar bench`: the benchmarks that run on a user's machine. They are loaded when one is run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from ..errors import MissingPackageError, OptionError

BENCHMARKS = {
    "tradeoff": "every method at every tolerance on every family: time against achieved residual (about 10 minutes)",
    "drift": "how far a stack moves that should stand, each method with the same time a step (2 minutes)",
    "call": "what one call of solve costs, by size: cold, warm, in a batch (seconds)",
}


def add_bench_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Adds `lcpstar bench` to the command line."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "bench", help="measure speed and accuracy on this machine", description=__doc__
    )
    parser.set_defaults(run=_list)
    benchmarks = parser.add_subparsers(dest="benchmark", metavar="BENCHMARK")
    trade = benchmarks.add_parser("tradeoff", help=BENCHMARKS["tradeoff"])
    trade.add_argument("--families", nargs="+", metavar="NAME", help="some of those that `lcpstar bench` lists")
    trade.add_argument("--methods", nargs="+", metavar="NAME", help="some of those that `lcpstar bench` lists")
    trade.add_argument("--quick", action="store_true", help="the smallest size, one seed, three tolerances")
    trade.add_argument("--budget", type=float, default=480.0, metavar="SECONDS", help="for repetitions (default 480)")
    trade.add_argument("--out", type=Path, default=Path("bench-tradeoff"), metavar="DIR", help="default bench-tradeoff")
    trade.set_defaults(run=_tradeoff)
    fall = benchmarks.add_parser("drift", help=BENCHMARKS["drift"])
    fall.add_argument("--methods", nargs="+", metavar="NAME", help="some of those that `lcpstar bench` lists")
    fall.add_argument("--steps", type=int, default=1000, help="default 1000")
    fall.add_argument("--budget-ms", type=float, default=16.0, help="to solve the LCPs of a step (default 16)")
    fall.add_argument("--boxes", type=int, default=10, help="default 10")
    fall.add_argument("--mass-ratio", type=float, default=1e6, help="of the top box (default 1e6)")
    fall.add_argument("--out", type=Path, default=Path("bench-drift"), metavar="DIR", help="default bench-drift")
    fall.set_defaults(run=_drift)
    call = benchmarks.add_parser("call", help=BENCHMARKS["call"])
    call.add_argument("--quick", action="store_true", help="small sizes, fewer repetitions")
    call.set_defaults(run=_call)
    return parser


def _list(arguments: argparse.Namespace) -> int:
    from . import families, methods

    print("lcpstar bench BENCHMARK, one of:")
    for name, text in BENCHMARKS.items():
        print(f"  {name:<10} {text}")
    print("\nfamilies of tradeoff:")
    for name in families.NAMES:
        print(f"  {name:<18} {families.TITLES[name]}")
    print(f"\nmethods: {'; '.join(methods.NAMES)}")
    return 0


def _call(arguments: argparse.Namespace) -> int:
    from .call import run

    print(run(arguments.quick))
    return 0


def _folder(path: Path) -> Path:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OptionError(f"out must be a folder that can be made: {error}") from error
    return path


def _drift(arguments: argparse.Namespace) -> int:
    from . import drift, methods
    from .measure import machine

    entries = [entry for entry in methods.chosen(arguments.methods) if entry.rung == "float64"]
    for name in ("steps", "budget_ms", "boxes", "mass_ratio"):
        if not getattr(arguments, name) > 0:
            raise OptionError(f"{name} must be positive, got {getattr(arguments, name)}")
    folder = _folder(arguments.out)
    steps = list(
        drift.run(
            entries,
            arguments.steps,
            arguments.budget_ms / 1e3,
            arguments.boxes,
            arguments.mass_ratio,
            progress=True,
        )
    )
    drift.write_steps(folder / "drift.csv", steps, every=max(1, arguments.steps // 100))
    text = f"# Drift of a stack\n\n{machine()}\n\n{drift.drift_table(steps, arguments.steps)}\n"
    (folder / "drift.md").write_text(text, encoding="utf-8")
    print(text)
    print(f"wrote {folder / 'drift.csv'}")
    try:
        from ..plots import drift as drawn
        from ..plots import save

        print(f"wrote {save(drawn(steps), folder / 'drift.png')}")
    except MissingPackageError as error:
        print(f"no plot: {error}", file=sys.stderr)
    return 0


def _tradeoff(arguments: argparse.Namespace) -> int:
    from . import families, methods, tradeoff
    from .measure import machine
    from .report import summary
    from .table import write_rows

    names, entries = families.chosen(arguments.families), methods.chosen(arguments.methods)
    if not arguments.budget > 0:
        raise OptionError(f"budget must be positive, got {arguments.budget}")
    folder = _folder(arguments.out)
    rows = list(tradeoff.run(names, entries, arguments.quick, arguments.budget, progress=True))
    table = folder / "tradeoff.csv"
    write_rows(table, rows)
    text = f"# Work and precision\n\n{machine()}\n\n{summary(rows)}\n"
    (folder / "tradeoff.md").write_text(text, encoding="utf-8")
    print(text)
    print(f"wrote {table}")
    try:
        from ..plots import figures, save

        for name, figure in figures(rows).items():
            save(figure, folder / f"{name}.png")
        print(f"wrote plots beside it, {folder}")
    except MissingPackageError as error:
        print(f"no plots: {error}", file=sys.stderr)
    return 0
