"""`lcpstar classify FILE`."""

from __future__ import annotations

import argparse
import json
import pathlib
import sys
from fractions import Fraction
from functools import partial
from typing import Any

from ..files import read_matrix
from .exact import read_number
from .report import classify
from .witness import Implied


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
        read_matrix(args.file, partial(read_number, where="an entry")),
        args.classes,
        time_limit=args.time_limit,
        threads=args.threads,
        progress=sys.stderr is not None and sys.stderr.isatty() and not args.json,
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
