"""The command line: `lcpstar solve FILE`, `lcpstar paper`. Exit status 0 solved, 1 not solved, 2 bad input."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import sys
from typing import Any, TextIO

from . import __version__
from ._core import METHODS
from .bench.cli import add_bench_parser
from .classes import add_classify_parser
from .errors import FileFormatError, LCPError
from .exploring import add_explore_parser
from .files import read_problem
from .plotting import add_plot_parser
from .solve import solve


def main(argv: list[str] | None = None) -> int:
    """Run the command line; returns the exit status. Output that nobody takes is status 2, as bad input is."""
    try:
        if sys.stdout is None:
            raise OSError("standard output is closed")
        try:
            return _run(argv)
        finally:
            sys.stdout.flush()
    except OSError as error:
        _abandon(sys.stdout)
        return _refuse(str(error))


def _run(argv: list[str] | None) -> int:
    parser = argparse.ArgumentParser(prog="lcpstar", description=__doc__)
    parser.add_argument("--version", action="version", version=f"lcpstar {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_solve(commands)
    add_classify_parser(commands)
    add_explore_parser(commands)
    add_bench_parser(commands)
    add_plot_parser(commands)
    paper = commands.add_parser("paper", help="recompute the paper: its example, Table 1, and every claim")
    paper.set_defaults(run=_paper)
    help_text = io.StringIO()  # argparse itself would say nothing about a full disk
    try:
        with contextlib.redirect_stdout(help_text):
            arguments = parser.parse_args(argv)
    finally:
        sys.stdout.write(help_text.getvalue())
    try:
        return int(arguments.run(arguments))
    except LCPError as error:
        return _refuse(str(error))
    except MemoryError as error:
        return _refuse(f"not enough memory: {error}")
    except KeyboardInterrupt:
        return _refuse("interrupted", status=130)


def _refuse(reason: str, status: int = 2) -> int:
    """Says why in one line, where somebody can read it."""
    if sys.stderr is not None:
        try:
            print(f"lcpstar: {_one_line(reason)}", file=sys.stderr, flush=True)
        except OSError:
            _abandon(sys.stderr)
    return status


def _abandon(stream: TextIO | None) -> None:
    """What a full disk or a closed pipe did not take would be tried again, and reported, when Python ends."""
    if stream is not None:
        with contextlib.suppress(OSError, ValueError), open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), stream.fileno())


def _one_line(text: str, longest: int = 400) -> str:
    """What a file's name or content put into a message cannot start a line, move the cursor or fill the screen."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= longest else line[: longest - 3] + "..."


def _add_solve(commands: Any) -> None:
    parser = commands.add_parser("solve", help="solve the LCP in FILE", description="Solve the LCP in FILE.")
    parser.add_argument(
        "file", metavar="FILE", help=".json or .npz with A and q, or .mtx/.csv/save_npz with the matrix"
    )
    parser.add_argument("q", metavar="Q", nargs="?", help=".csv with q, when FILE holds the matrix alone")
    parser.add_argument("--method", default="auto", help=f"one of {', '.join(METHODS)} (default: auto)")
    parser.add_argument("--tol", type=float, default=1e-9, help="bound on the residual of a solved problem")
    parser.add_argument("--max-iterations", type=int, metavar="N", help="pivots or iterations in all")
    parser.add_argument("--time-limit", type=float, metavar="SECONDS")
    parser.add_argument("--certify", default="float", choices=("float", "exact"))
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")
    parser.set_defaults(run=_solve)


def _solve(arguments: argparse.Namespace) -> int:
    A, q = read_problem(arguments.file, arguments.q)
    if q is None:
        raise FileFormatError(f"{arguments.file}: no q; give it in the file or as a second argument")
    solution = solve(
        A,
        q,
        method=arguments.method,
        tol=arguments.tol,
        max_iterations=arguments.max_iterations,
        time_limit=arguments.time_limit,
        certify=arguments.certify,
    )
    if arguments.json:
        print(json.dumps(solution_as_dict(solution)))
    else:
        print(describe(solution))
    return 0 if solution.success else 1


def _paper(arguments: argparse.Namespace) -> int:
    from .audit import audit, table
    from .paper import main as report

    report()
    print("\nEvery claim and example, by exhaustive search and exact verdicts:\n")
    print(table(audit()))
    return 0


def describe(solution: Any) -> str:
    """A few lines that a person reads."""
    lines = [
        f"status            {solution.status}",
        f"method            {solution.method}, {solution.iterations} iterations, {solution.time:.3g} s",
        f"residual          {solution.residual:.3e} (equilibrated), {solution.natural_residual:.3e} max|min(z, w)|",
    ]
    if solution.certificate is not None:
        proof = "exact rational arithmetic" if solution.certificate.exact else "floating point, checked"
        lines.append(f"certificate       {solution.certificate.kind}, {proof}")
    if len(solution.z) <= 20:
        lines += [f"z                 {_numbers(solution.z)}", f"w                 {_numbers(solution.w)}"]
    return "\n".join([*lines, solution.message])


def _numbers(vector: Any) -> str:
    return " ".join(f"{x:.6g}" for x in vector)


def solution_as_dict(solution: Any) -> dict[str, Any]:
    """Plain values: lists of floats, exact numbers as strings."""
    certificate = solution.certificate
    return {
        "status": str(solution.status),
        "success": solution.success,
        "method": solution.method,
        "iterations": solution.iterations,
        "residual": solution.residual,
        "natural_residual": solution.natural_residual,
        "z": solution.z.tolist(),
        "w": solution.w.tolist(),
        "alpha": list(solution.alpha),
        "certificate": None
        if certificate is None
        else {
            "kind": certificate.kind,
            "exact": certificate.exact,
            "alpha": certificate.alpha,
            "y": _plain(certificate.y),
            "bound": certificate.bound,
            "z": _plain(certificate.z),
        },
        "pieces": [{"indices": indices, "method": method} for indices, method in solution.pieces],
        "time": solution.time,
        "message": solution.message,
    }


def _plain(vector: Any) -> list[Any] | None:
    if vector is None:
        return None
    return [x if isinstance(x, float) else str(x) for x in list(vector)]


if __name__ == "__main__":
    sys.exit(main())
