"""Classes by the signs of principal minors: P, P0, N, N0, their "almost" forms, and Z, K0."""

from __future__ import annotations

from functools import partial

from .certificate import InZ, MinorSigns, PositiveVector
from .exact import solve
from .registry import predicate
from .subject import Subject
from .verdict import Finding, Verdict
from .witness import Entry, Implied, Minor

_RULE = {"P": "> 0", "P0": ">= 0", "N": "< 0", "N0": "<= 0"}
_RECHECK_UP_TO = 8


def _minors(A: Subject, rule: str, proper: bool = False) -> Finding:
    """Every (proper) principal minor obeys the rule."""
    alpha = A.ask("minor", rule, proper)
    which = "proper principal minor" if proper else "principal minor"
    if alpha is not None:
        witness = Minor(tuple(alpha), _RULE[rule])
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    certificate = MinorSigns(_RULE[rule], proper) if A.n <= _RECHECK_UP_TO else None
    return Finding(True, f"every {which} is {_RULE[rule]}", certificate=certificate)


def _almost(A: Subject, rule: str, opposite: str) -> Finding:
    """Every proper principal minor obeys the rule and the determinant is strictly of the other sign."""
    everything = tuple(range(A.n))
    if (A.kernel.determinant() > 0) != (opposite == "> 0") or A.kernel.determinant() == 0:
        witness = Minor(everything, opposite)
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    proper = _minors(A, rule, proper=True)
    return Finding(proper.holds, proper.reason, proper.witness, proper.certificate)


def _implied(A: Subject, smaller: str, sentence: str) -> Finding:
    return Finding(True, sentence, certificate=Implied((A.verdict(smaller),), sentence))


@predicate("P", "P-matrix")
def is_p(A: Subject) -> Finding:
    """All principal minors are positive.

    Schur recursion visits all 2^n minors [TL00]; doubles with a proved error bound, integers where the bound cannot
    tell a pivot from zero. First, in O(n^3): diagonal dominance, and A D positive definite for a few diagonals D.
    """
    if A.n > _RECHECK_UP_TO and A.verdict("PD").holds:
        return _implied(A, "PD", "PD is contained in P")
    return _minors(A, "P")


@predicate("P0", "P0-matrix")
def is_p0(A: Subject) -> Finding:
    """All principal minors are nonnegative. As P."""
    if A.n > _RECHECK_UP_TO and A.verdict("PSD").holds:
        return _implied(A, "PSD", "PSD is contained in P0")
    return _minors(A, "P0")


@predicate("N", "N-matrix")
def is_n(A: Subject) -> Finding:
    """All principal minors are negative (of nonempty index sets). O(2^n)."""
    return _minors(A, "N")


@predicate("N0", "N0-matrix")
def is_n0(A: Subject) -> Finding:
    """All principal minors are nonpositive (of nonempty index sets). O(2^n)."""
    return _minors(A, "N0")


@predicate("almost-P0", "almost P0-matrix")
def is_almost_p0(A: Subject) -> Finding:
    """All proper principal minors are nonnegative and det A < 0. O(2^n)."""
    return _almost(A, "P0", "< 0")


@predicate("almost-P", "almost P-matrix")
def is_almost_p(A: Subject) -> Finding:
    """All proper principal minors are positive and det A < 0. O(2^n)."""
    return _almost(A, "P", "< 0")


@predicate("almost-N0", "almost N0-matrix")
def is_almost_n0(A: Subject) -> Finding:
    """All proper principal minors (nonempty) are nonpositive and det A > 0. O(2^n)."""
    return _almost(A, "N0", "> 0")


@predicate("almost-N", "almost N-matrix")
def is_almost_n(A: Subject) -> Finding:
    """All proper principal minors (nonempty) are negative and det A > 0. O(2^n)."""
    return _almost(A, "N", "> 0")


@predicate("Z", "Z-matrix", limit=None)
def is_z(A: Subject) -> Finding:
    """a_ij <= 0 for i != j (the paper prints a_ij <= 0 for all i, j). O(n^2)."""
    for i, row in enumerate(A.rows):
        for j, value in enumerate(row):
            if i != j and value > 0:
                witness = Entry(i, j)
                return Finding(False, witness.sentence(A.rows), witness)
    return Finding(True, "no entry off the diagonal is positive")


@predicate("K0", "K0-matrix")
def is_k0(A: Subject) -> Finding:
    """Z and P0. A nonsingular one is an M-matrix, with the certificate v > 0, Av > 0: O(n^3); otherwise as P0."""
    z = A.decided("Z")
    if not z:
        return Finding(False, lambda: z.reason, z.witness)
    v = solve(A.rows, [1] * A.n)
    if v is not None and min(v) > 0:
        return Finding(True, "in Z with v > 0, Av = e > 0: an M-matrix", certificate=PositiveVector(v))
    p0 = A.verdict("P0")
    return Finding(p0.holds, lambda: f"in Z; {p0.reason}", p0.witness, partial(_in_z, p0))


def _in_z(p0: Verdict) -> InZ | None:
    return None if p0.certificate is None else InZ(p0.certificate)
