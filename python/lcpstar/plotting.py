"""`lcpstar plot FILE`: pictures of a table that `lcpstar bench` wrote, or of an LCP of order 2."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .errors import FileFormatError, OptionError
from .files import read_problem


def add_plot_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Adds `lcpstar plot` to the command line."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "plot", help="pictures of benchmark tables, and of LCPs of order 2", description=__doc__
    )
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="tradeoff.csv, drift.csv, or an LCP of order 2 as for solve"
    )
    parser.add_argument("q", type=Path, nargs="?", metavar="Q", help=".csv with q, when FILE holds the matrix alone")
    parser.add_argument("--out", type=Path, metavar="PATH", help="folder for a table's pictures; file for an LCP's")
    parser.add_argument("--svg", action="store_true", help=".svg instead of .png")
    parser.set_defaults(run=run_plot)
    return parser


def run_plot(arguments: argparse.Namespace) -> int:
    """Draw; prints the name of every file written."""
    from .plots import save

    for path, figure in _pictures(arguments):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            print(save(figure, path))
        except OSError as error:
            raise OptionError(f"out must be a place that can be written: {error}") from error
    return 0


def _pictures(arguments: argparse.Namespace) -> list[tuple[Path, Any]]:
    from .bench.drift import is_drift, read_steps
    from .bench.table import is_table, read_rows

    source: Path = arguments.file
    ending = ".svg" if arguments.svg else ".png"
    if source.suffix.lower() == ".csv" and source.is_file() and is_table(source):
        from .plots import figures

        folder = arguments.out or source.parent
        return [(folder / f"{name}{ending}", figure) for name, figure in figures(read_rows(source)).items()]
    if source.suffix.lower() == ".csv" and source.is_file() and is_drift(source):
        from .plots import drift

        return [((arguments.out or source.parent) / f"drift{ending}", drift(read_steps(source)))]
    from .cones import picture

    A, q = read_problem(source, arguments.q)
    if q is None:
        raise FileFormatError(f"{source.name}: no q; give it in the file or as a second argument")
    return [(arguments.out or source.with_suffix(ending), picture(A, q))]
