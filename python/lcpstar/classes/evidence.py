"""What a witness refutes and what a certificate proves: a table for each, from types to classes.

A witness or certificate checks its own claim about a matrix (`refutes`, `proves`). The tables say to which classes the
matrix then does not, or does, belong by their definitions. The proved inclusions carry that to the other classes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields
from fractions import Fraction
from typing import Any

from . import certificate as c
from . import regions as r
from . import witness as w
from .exact import IndexSet, Rows, determinant, pivot_transform, principal, subsets, times, transpose
from .inclusions import enclosing, supersets


def refutes(witness: Any, A: Rows, symbol: str) -> bool:
    """Whether it proves that A is not in the class: in none of those that its claim excludes, nor in smaller ones."""
    return _covers(_excluded(witness, A), symbol)


def proves(certificate: Any, A: Rows, symbol: str) -> bool:
    """Whether it proves that A is in the class."""
    row = CERTIFICATES.get(type(certificate))
    if row is None or not certificate.proves(A):
        return False
    return _name(symbol) in enclosing(row(certificate, A))


def is_plain(value: Any, verdict: type) -> bool:
    """Whether it is made of exact numbers, text, tuples, the types of the tables and verdicts, and of nothing else.

    A float would be rounded in a sum, and an object of another type may say of itself what it likes.
    """
    if type(value) in (bool, int, str, Fraction, type(None), verdict):
        return True
    if type(value) is tuple:
        return all(is_plain(x, verdict) for x in value)
    if type(value) is dict:
        return all(is_plain(x, verdict) for pair in value.items() for x in pair)
    known = type(value) in WITNESSES or type(value) in CERTIFICATES or type(value) is r.Tree
    return known and all(is_plain(getattr(value, field.name), verdict) for field in fields(value))


def is_matrix(A: Any) -> bool:
    """Whether it is a square matrix of exact numbers, of order 1 at least."""
    if type(A) is not tuple or not A or any(type(row) is not tuple or len(row) != len(A) for row in A):
        return False
    return all(type(x) in (int, Fraction) for row in A for x in row)


def _name(symbol: str) -> str:
    """C0(0) is C0, and C0(1) is almost C0."""
    return {"C0(0)": "C0", "C0(1)": "almost-C0"}.get(symbol, symbol)


def _exact_order(k: int) -> str:
    return _name(f"C0({k})")


def _covers(excluded: Iterable[str], symbol: str) -> bool:
    name = _name(symbol)
    return not {name, *supersets(name)}.isdisjoint(excluded)


def _excluded(witness: Any, A: Rows) -> frozenset[str]:
    row = WITNESSES.get(type(witness))
    return frozenset(row(witness, A)) if row is not None and witness.refutes(A) else frozenset()


def _by_minor(x: w.Minor, A: Rows) -> Iterator[str]:
    """A minor of the wrong sign; the almost classes ask for the strictly opposite sign of the whole determinant."""
    minor = determinant(principal(A, x.alpha))
    for rule, symbol in _MINORS.items():
        if len(x.alpha) == len(A):
            if not w.is_opposite(minor, rule):
                yield f"almost-{symbol}"
        elif not w.RULES[rule](minor):
            yield f"almost-{symbol}"
        if not w.RULES[rule](minor):
            yield symbol


_MINORS = {"> 0": "P", ">= 0": "P0", "< 0": "N", "<= 0": "N0"}
#: Every principal submatrix of a matrix of the first class is in the second.
_HEREDITARY = {"cE0s": "E0s", "ctE0s": "tE0s", "cQ": "Q", "cQ0": "Q0"}
#: A matrix of the second class is not in the first.
_MEMBER = {"E": ("almost-E",), "C0": ("almost-C0",)}


def _by_submatrix(x: w.InSubmatrix, A: Rows) -> Iterator[str]:
    n, size, block = len(A), len(x.alpha), principal(A, x.alpha)
    if isinstance(x.inner, w.Member):
        if x.inner.symbol == "C0":
            yield _exact_order(n - size + 1)  # no block of that order may be copositive
        return
    excluded = _excluded(x.inner, block)
    yield from (large for large, part in _HEREDITARY.items() if _covers(excluded, part))
    if size < n and _covers(excluded, "E"):
        yield "almost-E"
    if _covers(excluded, "C0"):
        yield from (_exact_order(k) for k in range(1, n - size + 1))  # all blocks of order n - k are copositive


def _by_transform(x: w.InTransform, A: Rows) -> Iterator[str]:
    M = pivot_transform(A, x.alpha)
    if M is not None:
        yield from _of_transforms(_excluded(x.inner, M), len(A))


def _of_transforms(excluded: Iterable[str], n: int) -> Iterator[str]:
    """What a legitimate transform outside these classes says about A."""
    yield from (f"{symbol}f" for symbol in ("C0", "E0") if _covers(excluded, symbol))
    if _covers(excluded, "C0") and _covers(excluded, "almost-C0"):
        yield "almost-C0f"
    if _covers(excluded, "E0"):
        yield from (f"C0f({k})" for k in range(n + 2) if _covers(excluded, _exact_order(k)))


def _by_all(x: w.All, A: Rows) -> Iterator[str]:
    """Each part counts for itself, for A as a transform of itself, and together they may speak of every transform."""
    n = len(A)
    said: dict[IndexSet, frozenset[str]] = {(): frozenset()}
    for part in x.parts:
        alpha, inner = (part.alpha, part.inner) if isinstance(part, w.InTransform) else ((), part)
        M = pivot_transform(A, alpha)
        if M is not None:
            said[alpha] = said.get(alpha, frozenset()) | _excluded(inner, M)
    yield from said[()]
    for excluded in said.values():
        yield from _of_transforms(excluded, n)
    legitimate = [(), *(alpha for alpha in subsets(n) if determinant(principal(A, alpha)))]
    for k in range(n + 2):
        if all(_covers(said.get(alpha, ()), _exact_order(k)) for alpha in legitimate):
            yield from (f"C0f({k})", *(["almost-C0f"] if k == 1 else []))


def _by_form(x: w.FormValue, A: Rows) -> Iterator[str]:
    yield "C" if x.orthant else "PD"
    if not x.strict:
        yield "C0" if x.orthant else "PSD"


def _by_star(x: w.NotStar, A: Rows) -> Iterator[str]:
    yield "tE0s"
    if times(transpose(A), x.x)[x.i] > 0:
        yield from ("E0s", "C0*")


#: The classes to which A does not belong when the witness's claim about it is true.
WITNESSES: dict[type, Callable[[Any, Rows], Iterable[str]]] = {
    w.Minor: _by_minor,
    w.Entry: lambda x, A: ("Z",),
    w.FormValue: _by_form,
    w.FormZero: lambda x, A: ("C0+",),
    w.SignReversed: lambda x, A: ("CSU",),
    w.AllDecrease: lambda x, A: ("E",) if x.strict else ("E0", "E"),
    w.ZeroSolution: lambda x, A: ("R0",),
    w.EquationSolution: lambda x, A: ("R",),
    w.NotStar: _by_star,
    w.NoDiagonals: lambda x, A: ("L2",),
    w.MixedGradient: lambda x, A: ("PSBD",),
    w.NotMonotonePair: lambda x, A: ("PM",),
    w.Member: lambda x, A: _MEMBER.get(x.symbol, ()),
    w.InSubmatrix: _by_submatrix,
    w.InTransform: _by_transform,
    w.InTranspose: lambda x, A: ("RSU",) if refutes(x.inner, transpose(A), "CSU") else (),
    w.All: _by_all,
    w.Implied: lambda x, A: (verdict.symbol for verdict in x.verdicts),
    r.Infeasible: lambda x, A: ("Q",),
    r.Unsolvable: lambda x, A: ("Q0",),
    r.IsolatedSolution: lambda x, A: ("Ec",),
    r.Disconnected: lambda x, A: ("Ec",),
    r.AllShadowed: lambda x, A: ("++",),
}


#: The classes to which A belongs when the certificate's claim about it is true.
CERTIFICATES: dict[type, Callable[[Any, Rows], Iterable[str]]] = {
    c.LDL: lambda x, A: ("PD", "PSD") if x.definite else ("PSD",),
    c.MinorSigns: lambda x, A: (f"almost-{_MINORS[x.rule]}" if x.proper else _MINORS[x.rule],),
    c.PositiveVector: lambda x, A: ("P", "K0"),
    c.InZ: lambda x, A: ("K0",) if proves(x.inner, A, "P0") else (),
    c.Decomposition: lambda x, A: ("C0",),
    c.OrthantTrees: lambda x, A: ("Q0",) if x.infeasible else ("Q", "Q0"),
    c.MinkowskiFactor: lambda x, A: ("++",),
    w.Implied: lambda x, A: (verdict.symbol for verdict in x.verdicts),
}
