"""`classify`: the verdicts of many classes on one matrix, with shared work, closed under the proved inclusions."""

from __future__ import annotations

import copyreg
import html
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from types import NoneType
from typing import Any

from ..coerce import MAX_THREADS, as_count, as_flag
from ..errors import InternalError, OptionTypeError
from .guarantees import guarantees
from .inclusions import INCLUSIONS, conclude
from .registry import make_subject
from .subject import Subject
from .table import CLASSES, find_class
from .verdict import Cost, Verdict
from .witness import Implied

# Cheap classes first: what they decide saves the others.
_ORDER = (
    *("PD", "PSD", "Z", "P", "P0", "E0", "E", "C0", "C", "R0", "K0", "PSBD", "PM", "N", "N0"),
    *("almost-P", "almost-P0", "almost-N", "almost-N0", "C0+", "C0*", "E0s", "tE0s", "L2", "L", "R"),
    *("CSU", "RSU", "SU", "cE0s", "ctE0s", "almost-C0", "almost-E", "E0f", "C0f", "almost-C0f"),
    *("cQ", "Q", "Q0", "Qb", "cQ0", "++", "Ec"),
)
# Up to this order every class is decided by its own definition, so that every verdict has its own witness.
_DIRECT_UP_TO = 4


class Classification(Mapping[str, Verdict]):
    """Symbol -> Verdict, in the order of the paper; prints as a table. `guarantees` says what follows."""

    def __init__(self, verdicts: dict[str, Verdict], n: int, seconds: float):
        self._verdicts = verdicts
        self.n = n
        self.seconds = seconds

    def __getitem__(self, symbol: str) -> Verdict:
        return self._verdicts[symbol if symbol in self._verdicts else find_class(symbol).symbol]

    def __iter__(self) -> Iterator[str]:
        return iter(self._verdicts)

    def __len__(self) -> int:
        return len(self._verdicts)

    @property
    def holds(self) -> tuple[str, ...]:
        """Symbols of the classes that contain the matrix."""
        return tuple(s for s, v in self._verdicts.items() if v.holds)

    @property
    def undecided(self) -> tuple[str, ...]:
        """Symbols that the budget left open."""
        return tuple(s for s, v in self._verdicts.items() if v.holds is None)

    @property
    def guarantees(self) -> tuple[str, ...]:
        """What theory then promises about LCP(q, A), each sentence with its theorem."""
        return guarantees({s: v.holds for s, v in self._verdicts.items() if v.holds is not None})

    def __str__(self) -> str:
        words = {True: "yes", False: "no", None: "?"}
        width = max(map(len, self._verdicts), default=0)
        lines = [f"{s:<{width}}  {words[v.holds]:<3}  {v.reason}" for s, v in self._verdicts.items()]
        lines += ["", *(f"* {sentence}" for sentence in self.guarantees)]
        return "\n".join(lines).rstrip()

    __repr__ = __str__

    def _repr_html_(self) -> str:
        words = {True: "yes", False: "no", None: "?"}
        rows = "".join(
            f"<tr><td>{html.escape(s)}</td><td>{html.escape(v.name)}</td><td>{words[v.holds]}</td>"
            f"<td style='text-align:left'>{html.escape(v.reason)}</td></tr>"
            for s, v in self._verdicts.items()
        )
        items = "".join(f"<li>{html.escape(sentence)}</li>" for sentence in self.guarantees)
        head = "<tr><th>class</th><th>name</th><th>member</th><th style='text-align:left'>why</th></tr>"
        return f"<table>{head}{rows}</table><ul>{items}</ul>"


def _reduce(verdict: Verdict) -> tuple[Any, ...]:
    """Reason and certificate, which wait to be asked for, are worked out for a pickle or a copy."""
    v = verdict
    return Verdict, (v.holds, v.symbol, v.name, v.witness, v.cost, v.matrix, v.reason, v.certificate)


copyreg.pickle(Verdict, _reduce)


def classify(
    A: Any,
    classes: Iterable[str] | None = None,
    *,
    time_limit: float | None = None,
    threads: int | None = None,
    progress: bool | Callable[[int, int, str], None] = False,
) -> Classification:
    """Decide exactly to which matrix classes A belongs, and what follows.

    Parameters
    ----------
    A : (n, n) array_like
        As for `check`: exact numbers, floats are the binary rationals they store.
    classes : iterable of str, optional
        Symbols; default all of `lcpstar.classes.CLASSES`.
    time_limit : float, optional
        Seconds for all classes together. What is then open has `holds=None`, unless a proved inclusion settles it.
    threads : int, optional
        Classes decided at the same time (default 1). Worth it from n = 8 or so.
    progress : bool or callable, optional
        True writes a line to standard error; a callable gets (done, total, symbol).

    Returns
    -------
    Classification

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError, UnknownNameError, OptionError
        Subclasses of LCPError. Classes whose search is not offered for this n are undecided, never an error.

    Notes
    -----
    Up to n = 4 each class is decided by its own definition and has its own witness; beyond, an inclusion that settles a
    class saves its search (the witness of a superset then refutes it). Contradictions with proved inclusions raise
    InternalError.

    Examples
    --------
    >>> report = classify([[0, 1, 1], [2, 0, 2], [-2, -4, 0]])
    >>> report["tE0s"].holds, report["C0*"].holds, str(report["C0*"].witness.x)
    (True, False, '(1, 0, 1)')
    """
    workers = 1 if threads is None else min(as_count("threads", threads, least=1), MAX_THREADS)
    progress = progress if callable(progress) else as_flag("progress", progress)
    start = time.perf_counter()
    if isinstance(classes, str) or not isinstance(classes, (Iterable, NoneType)):
        raise OptionTypeError(f"classes must be symbols in a list, got {classes!r}")
    wanted = [find_class(s, "classes").symbol for s in classes] if classes is not None else list(CLASSES)
    subject = make_subject(A, time_limit)
    place = {s: i for i, s in enumerate(_ORDER)}
    todo = sorted(wanted, key=lambda s: place.get(s, len(_ORDER)))
    if workers == 1:
        for done, symbol in enumerate(todo):
            _report(progress, done, len(todo), symbol)
            _decide(subject, symbol)
    else:
        _decide_together(subject, todo, workers, progress)
    _report(progress, len(todo), len(todo), "")
    _close(subject, wanted)
    return Classification({s: subject.verdicts[s] for s in wanted}, subject.n, time.perf_counter() - start)


def _decide_together(subject: Subject, todo: list[str], threads: int, progress: Any) -> None:
    from concurrent.futures import ThreadPoolExecutor, as_completed

    with ThreadPoolExecutor(threads) as pool:
        futures = {pool.submit(_decide, subject, symbol): symbol for symbol in todo}
        try:
            for done, future in enumerate(as_completed(futures)):
                future.result()
                _report(progress, done, len(todo), futures[future])
        except BaseException:
            subject.kernel.cancel()
            pool.shutdown(cancel_futures=True)
            raise


def _known(subject: Subject) -> dict[str, bool]:
    return {s: v.holds for s, v in list(subject.verdicts.items()) if v.holds is not None}


def _decide(subject: Subject, symbol: str) -> None:
    limit = find_class(symbol).limit
    too_large = limit is not None and subject.n > limit
    if too_large or subject.n > _DIRECT_UP_TO:
        concluded = _concluded(subject, symbol)
        if concluded is not None:
            subject.verdicts[symbol] = concluded
            return
    if too_large:
        which = find_class(symbol)
        reason = f"the search is offered up to n = {limit}"
        subject.verdicts[symbol] = Verdict(None, symbol, which.name, None, Cost(0.0), subject.rows, reason, None)
        return
    subject.verdict(symbol)


def _concluded(subject: Subject, symbol: str) -> Verdict | None:
    """The verdict that proved inclusions give."""
    found = conclude(_known(subject), symbol)
    if found is None:
        return None
    answer, others, sentence = found
    implied = Implied(tuple(subject.verdicts[other] for other in others), sentence)
    name = find_class(symbol).name
    if not answer:
        return Verdict(False, symbol, name, implied, Cost(0.0), subject.rows, sentence, None)
    return Verdict(True, symbol, name, None, Cost(0.0), subject.rows, sentence, partial(_carried, implied))


def _carried(implied: Implied) -> Implied | None:
    """The certificates of the smaller classes, if they have them."""
    return implied if all(verdict.certificate is not None for verdict in implied.verdicts) else None


def _close(subject: Subject, wanted: list[str]) -> None:
    """Settles what is open by inclusions, and checks that nothing contradicts them."""
    changed = True
    while changed:
        changed = False
        for symbol in wanted:
            if subject.verdicts[symbol].holds is None:
                concluded = _concluded(subject, symbol)
                if concluded is not None:
                    subject.verdicts[symbol], changed = concluded, True
    known = _known(subject)
    for small, large, why in INCLUSIONS:
        if known.get(small) is True and known.get(large) is False:
            raise InternalError(f"please report it: {small} holds and {large} fails, against {why}, for {subject.rows}")


def _report(progress: bool | Callable[[int, int, str], None], done: int, total: int, symbol: str) -> None:
    if callable(progress):
        progress(done, total, symbol)
    elif progress:
        end = "\n" if done == total else ""
        sys.stderr.write(f"\rclassify: {done:2d}/{total} {symbol:<12}{end}")
        sys.stderr.flush()
