"""Witnesses: exact objects that refute membership, each with a checker of a few lines and nothing from the core.

`refutes(A)` recomputes everything in `Fraction` from the matrix and the witness alone. Index sets count from 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

from .exact import (
    IndexSet,
    Rows,
    Vector,
    determinant,
    dot,
    is_index_set,
    pivot_transform,
    principal,
    show,
    show_set,
    solve,
    subsets,
    times,
    transpose,
)


class Witness(Protocol):
    """What every witness can do."""

    def refutes(self, A: Rows) -> bool:
        """Whether it proves its claim about A."""
        ...

    def sentence(self, A: Rows) -> str:
        """The claim as a sentence."""
        ...


RULES: dict[str, Callable[[Fraction], bool]] = {
    "> 0": lambda d: d > 0,
    ">= 0": lambda d: d >= 0,
    "< 0": lambda d: d < 0,
    "<= 0": lambda d: d <= 0,
}


def is_opposite(d: Fraction, rule: str) -> bool:
    """Whether d is strictly of the sign that `rule` excludes."""
    return d < 0 if rule.startswith(">") else d > 0


def is_nonnegative(x: Vector) -> bool:
    """X >= 0, x != 0."""
    return all(v >= 0 for v in x) and any(x)


def is_solution(A: Rows, q: Vector, z: Vector) -> bool:
    """Z is in SOL(q, A)."""
    w = [v + c for v, c in zip(times(A, z), q, strict=True)]
    return all(v >= 0 for v in (*z, *w)) and not any(a * b for a, b in zip(z, w, strict=True))


@dataclass(frozen=True)
class Minor:
    """A principal minor whose sign breaks `rule`."""

    alpha: IndexSet
    rule: str

    def refutes(self, A: Rows) -> bool:
        """Recompute the minor."""
        if not self.alpha or not is_index_set(self.alpha, len(A)):
            return False
        return not RULES[self.rule](determinant(principal(A, self.alpha)))

    def sentence(self, A: Rows) -> str:
        """Show the minor."""
        value = determinant(principal(A, self.alpha))
        return f"det A[{show_set(self.alpha)}] = {value}, not {self.rule}"


@dataclass(frozen=True)
class Entry:
    """A positive entry off the diagonal."""

    i: int
    j: int

    def refutes(self, A: Rows) -> bool:
        """Look at it."""
        n = len(A)
        return 0 <= self.i < n and 0 <= self.j < n and self.i != self.j and A[self.i][self.j] > 0

    def sentence(self, A: Rows) -> str:
        """Show it."""
        return f"A[{self.i}, {self.j}] = {A[self.i][self.j]} > 0"


@dataclass(frozen=True)
class FormValue:
    """X != 0 with x'Ax < 0 (`strict`: <= 0); `orthant`: x >= 0."""

    x: Vector
    strict: bool = False
    orthant: bool = False

    def refutes(self, A: Rows) -> bool:
        """Recompute x'Ax."""
        value = dot(self.x, times(A, self.x))
        return (
            any(self.x) and (value < 0 or (self.strict and value == 0)) and (not self.orthant or is_nonnegative(self.x))
        )

    def sentence(self, A: Rows) -> str:
        """Show x'Ax."""
        return f"x = {show(self.x)} has x'Ax = {dot(self.x, times(A, self.x))}"


@dataclass(frozen=True)
class FormZero:
    """X >= 0 with x'Ax = 0 and (A + A')x != 0: refutes copositive plus."""

    x: Vector

    def refutes(self, A: Rows) -> bool:
        """Recompute both."""
        gradient = [a + b for a, b in zip(times(A, self.x), times(transpose(A), self.x), strict=True)]
        return is_nonnegative(self.x) and dot(self.x, times(A, self.x)) == 0 and any(gradient)

    def sentence(self, A: Rows) -> str:
        """Show the gradient."""
        gradient = [a + b for a, b in zip(times(A, self.x), times(transpose(A), self.x), strict=True)]
        return f"x = {show(self.x)} has x'Ax = 0 but (A + A')x = {show(gradient)} != 0"


@dataclass(frozen=True)
class SignReversed:
    """X with x_i (Ax)_i <= 0 for all i and < 0 for one: refutes column sufficient."""

    x: Vector

    def refutes(self, A: Rows) -> bool:
        """Recompute the products."""
        products = [a * b for a, b in zip(self.x, times(A, self.x), strict=True)]
        return all(p <= 0 for p in products) and any(p < 0 for p in products)

    def sentence(self, A: Rows) -> str:
        """Show the products."""
        products = [a * b for a, b in zip(self.x, times(A, self.x), strict=True)]
        return f"x = {show(self.x)} has x_i (Ax)_i = {show(products)}: none positive, one negative"


@dataclass(frozen=True)
class AllDecrease:
    """0 != x >= 0 with (Ax)_i < 0 (`strict`: <= 0) wherever x_i > 0: refutes E0 (E)."""

    x: Vector
    strict: bool = False

    def refutes(self, A: Rows) -> bool:
        """Recompute Ax on the support."""
        w = times(A, self.x)
        bad = [w[i] for i, v in enumerate(self.x) if v]
        return is_nonnegative(self.x) and all(v < 0 or (self.strict and v == 0) for v in bad)

    def sentence(self, A: Rows) -> str:
        """Show Ax."""
        sign = "<= 0" if self.strict else "< 0"
        return f"x = {show(self.x)} has Ax = {show(times(A, self.x))}, {sign} wherever x_i > 0"


@dataclass(frozen=True)
class ZeroSolution:
    """0 != x in SOL(0, A): refutes R0."""

    x: Vector

    def refutes(self, A: Rows) -> bool:
        """It solves LCP(0, A)."""
        return any(self.x) and is_solution(A, (Fraction(0),) * len(A), self.x)

    def sentence(self, A: Rows) -> str:
        """Show Ax."""
        return f"x = {show(self.x)} solves LCP(0, A): Ax = {show(times(A, self.x))}"


@dataclass(frozen=True)
class EquationSolution:
    """0 != z in SOL(t e, A), t >= 0: refutes R."""

    z: Vector
    t: Fraction | int

    def refutes(self, A: Rows) -> bool:
        """It solves LCP(t e, A)."""
        return any(self.z) and self.t >= 0 and is_solution(A, (Fraction(self.t),) * len(A), self.z)

    def sentence(self, A: Rows) -> str:
        """Show it."""
        return f"z = {show(self.z)} != 0 solves LCP(t e, A) with t = {self.t}"


@dataclass(frozen=True)
class NotStar:
    """X in SOL(0, A) with (A'x)_i > 0; `tilde`: or (A'x)_i != 0 = (Ax)_i."""

    x: Vector
    i: int
    tilde: bool = False

    def refutes(self, A: Rows) -> bool:
        """Recompute Ax and A'x."""
        if not 0 <= self.i < len(A):
            return False
        w, y = times(A, self.x)[self.i], times(transpose(A), self.x)[self.i]
        return is_solution(A, (Fraction(0),) * len(A), self.x) and (y > 0 or (self.tilde and y != 0 and w == 0))

    def sentence(self, A: Rows) -> str:
        """Show both."""
        w, y = times(A, self.x), times(transpose(A), self.x)
        return f"x = {show(self.x)} solves LCP(0, A) with Ax = {show(w)}, A'x = {show(y)}, at fault in entry {self.i}"


@dataclass(frozen=True)
class NoDiagonals:
    """X in SOL(0, A) without D1, D2 as L2 asks; u is Ville's alternative.

    If A'D2 x = -D1 A x with y = D2 x != 0, then y >= 0 lives on the support of x, A'y <= 0, and (A'y)_i = 0 where
    (Ax)_i = 0. With u_i >= 0 where (Ax)_i > 0 and (Au)_j > 0 on the support, 0 < y'Au = (A'y)'u <= 0: absurd.
    """

    x: Vector
    u: Vector

    def refutes(self, A: Rows) -> bool:
        """Recompute the signs."""
        w, image = times(A, self.x), times(A, self.u)
        return (
            any(self.x)
            and is_solution(A, (Fraction(0),) * len(A), self.x)
            and all(u >= 0 for u, v in zip(self.u, w, strict=True) if v > 0)
            and all(v > 0 for v, x in zip(image, self.x, strict=True) if x)
        )

    def sentence(self, A: Rows) -> str:
        """Show both vectors."""
        return (
            f"x = {show(self.x)} solves LCP(0, A), Ax = {show(times(A, self.x))}, and has no D1, D2: "
            f"u = {show(self.u)} has Au = {show(times(A, self.u))} > 0 on its support"
        )


@dataclass(frozen=True)
class MixedGradient:
    """X with x'Ax < 0 and A'x of both signs: refutes PSBD."""

    x: Vector

    def refutes(self, A: Rows) -> bool:
        """Recompute both."""
        y = times(transpose(A), self.x)
        return dot(self.x, times(A, self.x)) < 0 and min(y) < 0 < max(y)

    def sentence(self, A: Rows) -> str:
        """Show both."""
        value = dot(self.x, times(A, self.x))
        return f"x = {show(self.x)} has x'Ax = {value} < 0 and A'x = {show(times(transpose(A), self.x))} of both signs"


@dataclass(frozen=True)
class NotMonotonePair:
    """X, y >= 0 with (y - x)'Ax >= 0 > (y - x)'Ay: refutes pseudomonotone."""

    x: Vector
    y: Vector

    def refutes(self, A: Rows) -> bool:
        """Recompute both products."""
        z = [b - a for a, b in zip(self.x, self.y, strict=True)]
        return all(v >= 0 for v in (*self.x, *self.y)) and dot(z, times(A, self.x)) >= 0 > dot(z, times(A, self.y))

    def sentence(self, A: Rows) -> str:
        """Show both products."""
        z = [b - a for a, b in zip(self.x, self.y, strict=True)]
        return (
            f"x = {show(self.x)}, y = {show(self.y)} have (y-x)'Ax = {dot(z, times(A, self.x))} >= 0 "
            f"and (y-x)'Ay = {dot(z, times(A, self.y))} < 0"
        )


@dataclass(frozen=True)
class InSubmatrix:
    """A witness for A[alpha, alpha]."""

    alpha: IndexSet
    inner: Witness

    def refutes(self, A: Rows) -> bool:
        """Check it there."""
        return is_index_set(self.alpha, len(A)) and self.inner.refutes(principal(A, self.alpha))

    def sentence(self, A: Rows) -> str:
        """Say it there."""
        return f"for A[{show_set(self.alpha)}]: {self.inner.sentence(principal(A, self.alpha))}"


@dataclass(frozen=True)
class InTransform:
    """A witness for the principal pivot transform on alpha."""

    alpha: IndexSet
    inner: Witness

    def refutes(self, A: Rows) -> bool:
        """Pivot and check it there."""
        M = pivot_transform(A, self.alpha) if is_index_set(self.alpha, len(A)) else None
        return M is not None and self.inner.refutes(M)

    def sentence(self, A: Rows) -> str:
        """Say it there."""
        M = pivot_transform(A, self.alpha)
        return f"for the PPT M on {show_set(self.alpha)}: {self.inner.sentence(M) if M else 'singular'}"


@dataclass(frozen=True)
class InTranspose:
    """A witness for A'."""

    inner: Witness

    def refutes(self, A: Rows) -> bool:
        """Check it there."""
        return self.inner.refutes(transpose(A))

    def sentence(self, A: Rows) -> str:
        """Say it there."""
        return f"for A': {self.inner.sentence(transpose(A))}"


@dataclass(frozen=True)
class All:
    """Facts of which each is true."""

    parts: tuple[Witness, ...]

    def refutes(self, A: Rows) -> bool:
        """Check each."""
        return all(part.refutes(A) for part in self.parts)

    def sentence(self, A: Rows) -> str:
        """Say each."""
        return "; ".join(part.sentence(A) for part in self.parts)


@dataclass(frozen=True)
class Implied:
    """The witness or the certificates of other classes, with the inclusion that carries them over.

    `verdicts` are `Verdict`s, which are built on this module.
    """

    verdicts: tuple[Any, ...]
    inclusion: str

    def refutes(self, A: Rows) -> bool:
        """Check the verdict on the larger class."""
        return all(v.holds is False and v.matrix == A and v.check() is True for v in self.verdicts)

    def proves(self, A: Rows) -> bool:
        """Check the verdicts on the smaller classes."""
        return all(v.holds is True and v.matrix == A and v.check() is True for v in self.verdicts)

    def sentence(self, A: Rows) -> str:
        """The inclusion and the other reasons."""
        return "; ".join([self.inclusion, *(verdict.reason for verdict in self.verdicts)])


def origin(verdict: Any) -> Any:
    """The witness behind a chain of inclusions."""
    while isinstance(verdict.witness, Implied):
        verdict = verdict.witness.verdicts[0]
    return verdict.witness


@dataclass(frozen=True)
class Member:
    """A is in E0, E, C0 or C, shown by going through all index sets: no A[alpha, alpha] x = -e (= 0) has x > 0.

    That this suffices is proved in the documentation of `is_semimonotone`; for C0 and C the matrix is A + A'.
    """

    symbol: str

    def refutes(self, A: Rows) -> bool:
        """2^n eliminations."""
        S = A
        if self.symbol in ("C0", "C"):
            S = tuple(tuple(a + b for a, b in zip(r, c, strict=True)) for r, c in zip(A, transpose(A), strict=True))
        strict = self.symbol in ("E", "C")
        return not any(_decreases(principal(S, alpha), strict) for alpha in subsets(len(A)))

    def sentence(self, A: Rows) -> str:
        """Say it."""
        return f"the matrix is itself in {self.symbol}"


def _decreases(A: Rows, strict: bool) -> bool:
    n = len(A)
    x = solve(A, [-1] * n)
    if x is not None:
        return min(x) > 0
    if not strict:
        return False
    if n == 1:
        return True
    # Singular: normalise the last entry of a null vector to 1; a positive one of a nullity-one block shows itself.
    # Where the other rows determine it, they span the rows of A: the one left out holds, too.
    for row in range(n):
        rest = tuple(tuple(A[i][j] for j in range(n - 1)) for i in range(n) if i != row)
        y = solve(rest, [-A[i][n - 1] for i in range(n) if i != row])
        if y is not None:
            return min(y) > 0
    return False
