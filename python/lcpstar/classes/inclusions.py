"""Proved inclusions between classes: `classify` closes its answers under them, the tests try each on many matrices.

A pair (small, large) says small is contained in large. Empirical inclusions are left out.
"""

from __future__ import annotations

from collections.abc import Iterable

INCLUSIONS: tuple[tuple[str, str, str], ...] = (
    ("PD", "P", "[CPS92, 3.3]"),
    ("PD", "PSD", "by definition"),
    ("PD", "C", "by definition"),
    ("PSD", "C0f", "PPTs of a PSD matrix are PSD"),
    ("PSD", "C0+", "by definition of the form"),
    ("PSD", "PM", "(y-x)'Ay = (y-x)'Ax + (y-x)'A(y-x)"),
    ("PSD", "SU", "[CPS92, 3.5]"),
    ("P", "SU", "[CPS92, 3.5]"),
    ("P", "E", "[CPS92, 3.9]"),
    ("P", "P0", "by definition"),
    ("SU", "CSU", "by definition"),
    ("SU", "RSU", "by definition"),
    ("CSU", "P0", "[CPV89]"),
    ("CSU", "Ec", "SOL(q, A) is convex [CPV89]"),
    ("RSU", "P0", "[CPV89]"),
    ("RSU", "Q0", "[CPV89]"),
    ("PM", "PSBD", "the pair of columns with opposite signs"),
    ("PM", "P0", "[Gow89]"),
    ("PM", "C0*", "take y = x + e_i"),
    ("C", "C0+", "the form has no zero"),
    ("C0+", "C0*", "(A + A')x = 0 and Ax >= 0"),
    ("C0*", "C0", "by definition"),
    ("C0*", "tE0s", "x + e e_i lowers the form where (A'x)_i < 0 = (Ax)_i"),
    ("C0+", "ctE0s", "C0+ is hereditary"),
    ("C0", "E0", "x'Ax is a sum of x_i (Ax)_i"),
    ("tE0s", "E0s", "by definition"),
    ("E0s", "E0", "by definition"),
    ("tE0s", "L", "take D2 = I"),
    ("L", "E0", "by definition"),
    ("L", "L2", "by definition"),
    ("L", "Q0", "[Eav71]"),
    ("C", "E", "by definition of the form"),
    ("E", "cQ", "[Cot80]"),
    ("cQ", "E", "[Cot80]"),
    ("E", "R", "[CPS92, 3.9]"),
    ("E", "E0", "by definition"),
    ("R", "R0", "by definition"),
    ("R", "Qb", "[CPS92, 3.9]"),
    ("Qb", "Q", "by definition"),
    ("Qb", "R0", "the set is bounded for q = 0"),
    ("Q", "Q0", "by definition"),
    ("E", "ctE0s", "E is hereditary and SOL(0, A) = {0}"),
    ("ctE0s", "tE0s", "by definition"),
    ("ctE0s", "cE0s", "by definition"),
    ("ctE0s", "cQ0", "tE0s is contained in Q0"),
    ("cE0s", "E0s", "by definition"),
    ("cQ", "Q", "by definition"),
    ("cQ", "cQ0", "by definition"),
    ("cQ0", "Q0", "by definition"),
    ("R0", "L2", "there is nothing to ask"),
    ("P0", "E0f", "PPTs of a P0-matrix are P0 [CPS92, 3.4]"),
    ("E0f", "E0", "by definition"),
    ("C0f", "C0", "by definition"),
    ("C0f", "E0f", "C0 is contained in E0"),
    ("Ec", "E0f", "[JG98]"),
    ("Z", "cQ0", "[Cha70]"),
    ("K0", "Z", "by definition"),
    ("K0", "P0", "by definition"),
    ("N", "N0", "by definition"),
    ("N", "R0", "every minor is nonzero"),
    ("almost-P", "almost-P0", "by definition"),
    ("almost-P", "R0", "every minor is nonzero"),
    ("almost-N", "almost-N0", "by definition"),
    ("almost-N", "R0", "every minor is nonzero"),
)

# (first, second, large): the intersection of two classes is contained in a third one.
INTERSECTIONS: tuple[tuple[str, str, str, str], ...] = (
    ("E0", "R0", "R", "[CPS92, 3.9]"),
    ("E0", "R0", "Qb", "[CPS92, 3.9]"),
    ("E0", "L2", "L", "by definition"),
    ("CSU", "RSU", "SU", "by definition"),
    ("Z", "P0", "K0", "by definition"),
    ("Q", "R0", "Qb", "[FL05]"),
    ("P0", "Q", "R0", "[AC79]"),
)


def supersets(symbol: str) -> dict[str, str]:
    """The classes that contain this one, each with the reason of the last step."""
    found: dict[str, str] = {}
    todo = [symbol]
    while todo:
        small = todo.pop()
        for a, b, why in INCLUSIONS:
            if a == small and b not in found and b != symbol:
                found[b] = why
                todo.append(b)
    return found


def enclosing(symbols: Iterable[str]) -> set[str]:
    """These classes and all that contain one of them, or the intersection of two."""
    found = {large for symbol in symbols for large in (symbol, *supersets(symbol))}
    for first, second, large, _ in INTERSECTIONS:
        if {first, second} <= found and large not in found:
            return enclosing([*found, large])
    return found


def conclude(known: dict[str, bool], symbol: str) -> tuple[bool, tuple[str, ...], str] | None:
    """What known memberships say about a class: (answer, the classes it follows from, sentence), or None."""
    for small, large, why in INCLUSIONS:
        if large == symbol and known.get(small) is True:
            return True, (small,), f"{small} is contained in {symbol}: {why}"
    for first, second, large, why in INTERSECTIONS:
        if large == symbol and known.get(first) and known.get(second):
            return True, (first, second), f"{first} and {second} give {symbol}: {why}"
    for small, large, why in INCLUSIONS:
        if small == symbol and known.get(large) is False:
            return False, (large,), f"not in {large}, which contains {symbol}: {why}"
    return None
