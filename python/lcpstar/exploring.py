"""A machine that finds counterexamples: `explore("tE0s & v > 0 => R0 & Q", n=3, entries=range(-2, 3))`."""

from __future__ import annotations

import argparse
import json
import os
import pathlib
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from . import _core
from .classes.exact import Rows, read_matrix, read_number
from .classes.registry import check
from .classes.verdict import Verdict
from .coerce import MAX_SEED, MAX_THREADS, as_count, as_flag, as_seconds, as_text
from .errors import OptionError, OptionTypeError
from .files import read_json
from .formula import is_invariant, parse_claim, symbols

# A larger space is sampled unless `samples` says otherwise.
_EXHAUSTIVE_UP_TO = 6_000_000
_DEFAULT_SAMPLES = 100_000
# One call of the scan takes about this long, so that Ctrl-C and the progress line work.
_CALL_SECONDS = 0.2


@dataclass(frozen=True)
class Exploration:
    """What a scan found.

    `scanned` matrices were looked at (one per class under permutation similarity in an exhaustive scan), `satisfied`
    of them meet the hypothesis, `failures` of these miss the conclusion. `counterexample` is the one with the least
    sum of absolute entries, exact, or None. `outcome` tells a claim without counterexample from one whose hypothesis no
    matrix met. `complete` is False when time ran out: `explore(..., resume=this)` goes on.
    """

    claim: str
    n: tuple[int, ...]
    entries: tuple[int, ...]
    samples: int | None
    seed: int
    scanned: int
    satisfied: int
    failures: int
    counterexample: Rows | None
    complete: bool
    seconds: float
    position: tuple[int, int] = field(repr=False, default=(0, 0))

    @property
    def outcome(self) -> str:
        """What the scan says about the claim."""
        if self.counterexample is not None:
            return "counterexample"
        if self.satisfied == 0 and self.scanned:
            return "no matrix satisfied the hypothesis"
        return "no counterexample"

    @property
    def verdicts(self) -> dict[str, Verdict]:
        """The classes of the claim, decided with witnesses for the counterexample."""
        if self.counterexample is None:
            return {}
        hypothesis, conclusion = parse_claim(self.claim)
        wanted = dict.fromkeys([*symbols(hypothesis), *symbols(conclusion)])
        return {symbol: check(self.counterexample, symbol) for symbol in wanted}

    def state(self) -> dict[str, Any]:
        """Everything as JSON types, for `resume`."""
        state = {name: getattr(self, name) for name in self.__dataclass_fields__}
        if self.counterexample is not None:
            state["counterexample"] = [[int(x) for x in row] for row in self.counterexample]
        return state

    def __str__(self) -> str:
        orders = ", ".join(map(str, self.n))
        how = "all" if self.samples is None else f"{self.samples} random"
        lines = [
            f"claim      {self.claim}",
            f"scanned    {self.scanned} matrices ({how}, n = {orders}, entries {list(self.entries)})"
            + ("" if self.complete else ", not finished"),
            f"hypothesis {self.satisfied} satisfy it, {self.failures} of them miss the conclusion",
        ]
        if self.counterexample is None:
            lines.append(f"verdict    {self.outcome}")
        else:
            lines.append("verdict    false: " + str([[int(x) for x in row] for row in self.counterexample]))
            lines += [f"           {verdict}" for verdict in self.verdicts.values()]
        return "\n".join(lines)


def explore(
    claim: str,
    n: int | Iterable[int] = 3,
    entries: Iterable[int] = range(-2, 3),
    *,
    samples: int | None = None,
    seed: int = 0,
    up_to_permutation: bool = True,
    stop_at_first: bool = False,
    threads: int | None = None,
    time_limit: float | None = None,
    progress: bool | Callable[[Exploration], None] = False,
    resume: Exploration | dict[str, Any] | None = None,
) -> Exploration:
    """Look for a matrix that meets the hypothesis of a claim and misses its conclusion.

    Parameters
    ----------
    claim : str
        `hypothesis => conclusion`, or a formula that should always hold; the language is in `lcpstar.formula`.
    n : int or iterable of int
        Orders, scanned one after the other.
    entries : iterable of int
        What entries may be; tried by increasing absolute value.
    samples : int, optional
        That many random matrices per order instead of all. Default: all, or 100 000 random ones per order when there
        are more than 6 million.
    seed : int
        The random matrices are a function of the seed and their number: the same with any number of threads.
    up_to_permutation : bool
        In an exhaustive scan look only at the first of the matrices P A P'. A claim that names indices is not
        invariant under permutations, and then all matrices are looked at.
    stop_at_first : bool
        Stop soon after the first counterexample instead of looking for the smallest.
    threads : int, optional
        Default: one per processor.
    time_limit : float, optional
        Seconds; an unfinished Exploration can be resumed.
    progress : bool or callable
        True writes a line to standard error; a callable gets the Exploration so far.
    resume : Exploration or its `state()`, optional
        Go on where this one stopped; its claim and space win over the arguments.

    Returns
    -------
    Exploration

    Raises
    ------
    OptionError, OptionTypeError
        The claim cannot be read, an entry is no integer, or an option is out of range or of the wrong type.

    Notes
    -----
    All verdicts are exact. Classes are decided lazily: `&` and `|` stop early, and the conclusion is asked only of
    matrices that meet the hypothesis, so put the cheap and rare parts first.

    Examples
    --------
    >>> found = explore("tE0s => P0", n=2)
    >>> found.failures > 0, [[int(x) for x in row] for row in found.counterexample]
    (True, [[1, 1], [2, 1]])
    """
    start = time.perf_counter()
    done = _begin(claim, n, entries, samples, seed, resume)
    hypothesis, conclusion = parse_claim(done.claim)
    workers = min(as_count("threads", os.cpu_count() or 1 if threads is None else threads, least=1), MAX_THREADS)
    limit = as_seconds("time_limit", time_limit)
    up_to_permutation = as_flag("up_to_permutation", up_to_permutation)
    stop_at_first = as_flag("stop_at_first", stop_at_first)
    progress = progress if callable(progress) else as_flag("progress", progress)
    chunk, patience = 256, 2 * _CALL_SECONDS
    while not done.complete:
        left = None if limit is None else limit - (time.perf_counter() - start)
        if left is not None and left <= 0:
            break
        order, position = done.position
        total = _total(done, order)
        stop = min(position + chunk, total)
        began = time.perf_counter()
        exhaustive = done.samples is None and len(done.entries) ** (done.n[order] ** 2) <= _EXHAUSTIVE_UP_TO
        invariant = is_invariant(hypothesis) and is_invariant(conclusion)
        try:
            tally = _core.scan(
                done.n[order],
                list(done.entries),
                up_to_permutation and exhaustive and invariant,
                None if exhaustive else done.seed,
                hypothesis,
                conclusion,
                position,
                stop,
                workers,
                patience if left is None else min(left, patience),
            )
        except TimeoutError:
            if chunk == 1:  # a single matrix takes long
                patience *= 2
            chunk = max(1, chunk // 8)
            continue
        took = time.perf_counter() - began
        chunk = max(1, int(chunk * min(4.0, max(0.25, _CALL_SECONDS / max(took, 1e-6)))))
        done = _advance(done, order, stop, total, tally, time.perf_counter() - start)
        if callable(progress):
            progress(done)
        elif progress:
            _progress_line(done, order, stop, total)
        if stop_at_first and done.failures:
            break
    return done


def _begin(
    claim: str, n: int | Iterable[int], entries: Iterable[int], samples: int | None, seed: int, resume: Any
) -> Exploration:
    if isinstance(resume, Exploration):
        return resume
    if resume is not None:
        try:
            state = dict(resume)
            state.pop("outcome", None)
            done = _space(*(state.pop(name) for name in ("claim", "n", "entries", "samples", "seed")))
            if state["counterexample"] is not None:
                state["counterexample"] = read_matrix(state["counterexample"])
            for name in ("scanned", "satisfied", "failures"):
                as_count(name, state[name])
            order, position = state["position"]
            state["position"] = as_count("position", order, largest=len(done.n)), as_count("position", position)
            state["complete"] = as_flag("complete", state["complete"]) or order == len(done.n)
            return replace(done, **state)
        except (KeyError, TypeError, ValueError) as error:
            raise OptionError(f"resume must be a state of an exploration: {error}") from None
    return _space(claim, n, entries, samples, seed)


def _space(claim: str, n: Any, entries: Any, samples: int | None, seed: int) -> Exploration:
    """What is to be scanned, nothing of which is done."""
    parse_claim(as_text("claim", claim))
    orders = tuple(as_count("n", order, least=1, largest=8) for order in (n if isinstance(n, Iterable) else (n,)))
    if isinstance(entries, str) or not isinstance(entries, Iterable):
        raise OptionTypeError(f"entries must be integers in a list, got {entries!r}")
    values = sorted({_entry(v, f"entries[{k}]") for k, v in enumerate(entries)}, key=lambda v: (abs(v), v < 0))
    if not orders or not values:
        raise OptionError(f"n and entries must not be empty, got n = {orders}, entries = {values}")
    count = None if samples is None else as_count("samples", samples, least=1)
    return Exploration(
        claim, orders, tuple(values), count, as_count("seed", seed, largest=MAX_SEED), 0, 0, 0, None, False, 0.0
    )


def _entry(value: Any, name: str) -> int:
    number = read_number(value, name)
    if number.denominator != 1 or isinstance(value, bool):
        raise OptionTypeError(f"entries must be integers, got {name} = {value}")
    if abs(number) > 2**31:
        raise OptionError(f"entries must be at most 2^31, got {name} = {value}")
    return int(number)


def _total(done: Exploration, order: int) -> int:
    """How many matrix numbers there are for one order."""
    everything: int = len(done.entries) ** (done.n[order] ** 2)
    if done.samples is not None:
        return done.samples
    return everything if everything <= _EXHAUSTIVE_UP_TO else _DEFAULT_SAMPLES


def _advance(done: Exploration, order: int, stop: int, total: int, tally: Any, seconds: float) -> Exploration:
    scanned, satisfied, failures, smallest = tally
    best = done.counterexample
    if smallest is not None:
        size = done.n[order]
        rows = read_matrix([smallest[1][i * size : (i + 1) * size] for i in range(size)])
        if best is None or (len(rows), _weight(rows)) < (len(best), _weight(best)):
            best = rows
    finished = stop == total
    return Exploration(
        done.claim,
        done.n,
        done.entries,
        done.samples,
        done.seed,
        done.scanned + scanned,
        done.satisfied + satisfied,
        done.failures + failures,
        best,
        finished and order + 1 == len(done.n),
        seconds,
        (order + 1, 0) if finished else (order, stop),
    )


def _weight(rows: Rows) -> int:
    return int(sum(abs(x) for row in rows for x in row))


def _progress_line(done: Exploration, order: int, stop: int, total: int) -> None:
    end = "\n" if done.complete else ""
    percent = 100 * stop // total
    text = f"n = {done.n[order]}: {percent:3d}%  {done.satisfied} satisfy the hypothesis, {done.failures} fail"
    sys.stderr.write(f"\r{text}{end}")
    sys.stderr.flush()


def add_explore_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Adds `lcpstar explore` to the command line; the parsed arguments go to `run_explore`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "explore", help="look for a counterexample to a claim about matrix classes", description=__doc__
    )
    parser.add_argument("claim", help='for example "tE0s & v > 0 => R0 & Q"')
    parser.add_argument("-n", type=int, nargs="+", default=[3], help="orders (default 3)")
    parser.add_argument("--entries", type=int, nargs="+", default=[-2, -1, 0, 1, 2], help="entries (default -2..2)")
    parser.add_argument("--samples", type=int, help="random matrices per order instead of all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", action="store_true", help="stop at the first counterexample")
    parser.add_argument("--threads", type=int)
    parser.add_argument("--time-limit", type=float)
    parser.add_argument("--state", type=pathlib.Path, help="file to resume from and to save to")
    parser.add_argument("--json", action="store_true", help="machine-readable output")
    parser.set_defaults(run=run_explore)
    return parser


def run_explore(args: argparse.Namespace) -> int:
    """Exit status 0: no counterexample in a finished scan; 1: one, nothing that meets the hypothesis, not finished."""
    resume = read_json(args.state) if args.state and args.state.exists() else None
    found = explore(
        args.claim,
        args.n,
        args.entries,
        samples=args.samples,
        seed=args.seed,
        stop_at_first=args.first,
        threads=args.threads,
        time_limit=args.time_limit,
        progress=sys.stderr is not None and sys.stderr.isatty() and not args.json,
        resume=resume,
    )
    if args.state:
        args.state.write_text(json.dumps(found.state()))
    print(json.dumps({**found.state(), "outcome": found.outcome}) if args.json else found)
    return 0 if found.complete and found.outcome == "no counterexample" else 1
