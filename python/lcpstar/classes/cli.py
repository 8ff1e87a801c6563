"""`lcpstar classify FILE`."""

from __future__ import annotations

import argparse
import json
import pathlib
import sys
from fractions import Fraction
from typing import Any

import numpy as np

from ..errors import FileFormatError
from .report import classify
from .witness import Implied


def read_matrix_file(path: pathlib.Path) -> Any:
    """The matrix in a `.json` (an object with "A", or rows; exact strings allowed), `.npz`, `.csv` or `.mtx` file.

    Raises
    ------
    FileFormatError
        The file cannot be read as a matrix.
    """
    try:
        if path.suffix == ".json":
            data = json.loads(path.read_text())
            return data["A"] if isinstance(data, dict) else data
        if path.suffix == ".npz":
            with np.load(path) as archive:
                return archive["A"]
        if path.suffix == ".csv":
            return [line.split(",") for line in path.read_text().split("\n") if line.strip()]
        if path.suffix == ".mtx":
            return _matrix_market(path.read_text())
    except (OSError, ValueError, KeyError, IndexError) as error:
        raise FileFormatError(f"{path}: {error}") from None
    raise FileFormatError(f"{path}: expected .json, .npz, .csv or .mtx")


def _matrix_market(text: str) -> list[list[Fraction]]:
    header, *lines = text.lower().splitlines()
    words = header.split()
    if words[:2] != ["%%matrixmarket", "matrix"] or words[3] not in ("real", "integer"):
        raise ValueError("expected a real or integer MatrixMarket matrix")
    body = [line.split() for line in lines if line.strip() and not line.startswith("%")]
    rows, columns = int(body[0][0]), int(body[0][1])
    table = [[Fraction(0)] * columns for _ in range(rows)]
    mirror = {"general": 0, "symmetric": 1, "skew-symmetric": -1}[words[4]]
    if words[2] == "array":
        places = [(i, j) for j in range(columns) for i in range(rows) if not mirror or i >= j + (mirror < 0)]
        values = [(i, j, line[0]) for (i, j), line in zip(places, body[1:], strict=True)]
    else:
        values = [(int(i) - 1, int(j) - 1, value) for i, j, value in body[1:]]
    for i, j, value in values:
        table[i][j] = Fraction(value)
        if mirror and i != j:
            table[j][i] = mirror * table[i][j]
    return table


def add_classify_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Adds `lcpstar classify` to the command line; the parsed arguments go to `run_classify`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "classify", help="decide exactly to which matrix classes a matrix belongs"
    )
    parser.add_argument("file", type=pathlib.Path, help=".json, .npz, .csv or .mtx; JSON may hold strings like '1/3'")
    parser.add_argument("--classes", nargs="+", help="symbols, e.g. E0s 'C0*' (default: all)")
    parser.add_argument("--time-limit", type=float, help="seconds")
    parser.add_argument("--threads", type=int)
    parser.add_argument("--json", action="store_true", help="machine-readable output")
    parser.set_defaults(run=run_classify)
    return parser


def run_classify(args: argparse.Namespace) -> int:
    """Exit status 0: every class decided; 1: some are not."""
    report = classify(
        read_matrix_file(args.file),
        args.classes,
        time_limit=args.time_limit,
        threads=args.threads,
        progress=sys.stderr.isatty() and not args.json,
    )
    if args.json:
        verdicts = {
            symbol: {"holds": v.holds, "reason": v.reason, "witness": to_json(v.witness), "seconds": v.cost.seconds}
            for symbol, v in report.items()
        }
        print(json.dumps({"classes": verdicts, "guarantees": list(report.guarantees)}))
    else:
        print(report)
    return 1 if report.undecided else 0


def to_json(witness: Any) -> Any:
    """A witness as JSON types: numbers become exact strings."""
    if witness is None or isinstance(witness, (bool, int, str)):
        return witness
    if isinstance(witness, Fraction):
        return str(witness)
    if isinstance(witness, Implied):
        return {
            "kind": "Implied",
            "inclusion": witness.inclusion,
            "witness": [to_json(v.witness) for v in witness.verdicts],
        }
    if isinstance(witness, (tuple, list)):
        return [to_json(part) for part in witness]
    if isinstance(witness, dict):
        return {str(key): to_json(value) for key, value in witness.items()}
    fields = {name: to_json(getattr(witness, name)) for name in witness.__dataclass_fields__}
    return {"kind": type(witness).__name__, **fields}
