"""Witnesses: exact objects that refute membership, each with a checker of a few lines and nothing from the core.

`refutes(A)` recomputes everything in `Fraction` from the matrix and the witness alone. Index sets count from 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Protocol

from .exact import (
    IndexSet,
    Rows,
    Vector,
    determinant,
    dot,
    pivot_transform,
    principal,
    show,
    show_set,
    solve,
    subsets,
    times,
    transpose,
)

if TYPE_CHECKING:
    from .verdict import Verdict


class Witness(Protocol):
    """What every witness can do."""

    def refutes(self, A: Rows) -> bool:
        """Whether it proves its claim about A."""
        ...

    def sentence(self, A: Rows) -> str:
        """The claim as a sentence."""
        ...


_RULES: dict[str, Callable[[Fraction], bool]] = {
    "> 0": lambda d: d > 0,
    ">= 0": lambda d: d >= 0,
    "< 0": lambda d: d < 0,
    "<= 0": lambda d: d <= 0,
}


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
        return not _RULES[self.rule](determinant(principal(A, self.alpha)))

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
        return self.i != self.j and A[self.i][self.j] > 0

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
        return any(self.x) and (value < 0 or (self.strict and value == 0)) and (not self.orthant or is_nonnegative(self.x))

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


def cone_columns(A: Rows, alpha: int) -> list[Vector]:
    """The generators of the complementary cone of the bit mask alpha: -A_j inside, e_j outside."""
    n = len(A)
    return [tuple(-A[i][j] if alpha >> j & 1 else Fraction(i == j) for i in range(n)) for j in range(n)]


@dataclass(frozen=True)
class Infeasible:
    """A q with FEA(q, A) empty: y >= 0, A'y <= 0, q'y < 0. Refutes Q."""

    q: Vector
    y: Vector

    def refutes(self, A: Rows) -> bool:
        """Recompute the signs."""
        return is_nonnegative(self.y) and max(times(transpose(A), self.y)) <= 0 and dot(self.q, self.y) < 0

    def sentence(self, A: Rows) -> str:
        """Show them."""
        return f"q = {show(self.q)} is infeasible: y = {show(self.y)} >= 0 has A'y <= 0, q'y < 0"


@dataclass(frozen=True)
class Unsolvable:
    """A q with a feasible point z but no solution: for each index set a vector that separates q from its cone."""

    q: Vector
    z: Vector
    separations: tuple[Vector, ...]

    def refutes(self, A: Rows) -> bool:
        """Every one of the 2^n complementary cones lies on one side, q on the other."""
        feasible = all(v >= 0 for v in self.z) and all(
            v + c >= 0 for v, c in zip(times(A, self.z), self.q, strict=True)
        )
        return (
            feasible
            and len(self.separations) == 2 ** len(A)
            and all(
                dot(y, self.q) < 0 and all(dot(y, c) >= 0 for c in cone_columns(A, alpha))
                for alpha, y in enumerate(self.separations)
            )
        )

    def sentence(self, A: Rows) -> str:
        """Show q and z."""
        return f"q = {show(self.q)} has the feasible point z = {show(self.z)} but lies in no complementary cone"


@dataclass(frozen=True)
class IsolatedSolution:
    """A solution z of LCP(q, A) with z_i + w_i > 0 and A[alpha, alpha] nonsingular is isolated; `other` is a second one."""

    q: Vector
    z: Vector
    other: Vector

    def refutes(self, A: Rows) -> bool:
        """Check both solutions and the isolation."""
        alpha = [i for i, v in enumerate(self.z) if v]
        w = [v + c for v, c in zip(times(A, self.z), self.q, strict=True)]
        return (
            is_solution(A, self.q, self.z)
            and is_solution(A, self.q, self.other)
            and self.z != self.other
            and all(v + c > 0 for v, c in zip(self.z, w, strict=True))
            and determinant(principal(A, alpha)) != 0
        )

    def sentence(self, A: Rows) -> str:
        """Show the solutions."""
        return f"q = {show(self.q)}: the solution {show(self.z)} is isolated and {show(self.other)} is another one"


@dataclass(frozen=True)
class Disconnected:
    """A q whose nonempty pieces fall into two or more groups that do not meet.

    `points[alpha]` lies in piece alpha (bit mask) and `component[alpha]` is its group; `separations` proves that every
    other piece is empty and that pieces of different groups do not meet.
    """

    q: Vector
    points: dict[int, Vector]
    component: dict[int, int]
    separations: tuple[tuple[int, int, Vector], ...]

    def refutes(self, A: Rows) -> bool:
        """Every piece and every pair is accounted for."""
        n = len(A)
        proved = set()
        for alpha, beta, y in self.separations:
            columns = [c for j, c in enumerate(cone_columns(A, alpha)) if not (alpha ^ beta) >> j & 1]
            if dot(y, self.q) < 0 and all(dot(y, c) >= 0 for c in columns):
                proved |= {(alpha, beta), (beta, alpha)}
        for alpha in range(2**n):
            if alpha in self.points:
                z = self.points[alpha]
                w = [v + c for v, c in zip(times(A, z), self.q, strict=True)]
                if not is_solution(A, self.q, z) or any((w if alpha >> i & 1 else z)[i] for i in range(n)):
                    return False
            elif (alpha, alpha) not in proved:
                return False
        pairs = [(a, b) for a in self.points for b in self.points if self.component[a] != self.component[b]]
        return bool(pairs) and all(pair in proved for pair in pairs)

    def sentence(self, A: Rows) -> str:
        """Show one point per group."""
        groups = {c: self.points[alpha] for alpha, c in self.component.items()}
        return f"q = {show(self.q)}: no path in SOL(q, A) joins " + " and ".join(show(z) for z in groups.values())


@dataclass(frozen=True)
class Tree:
    """A binary tree of splits of a simplicial cone, preorder: `(a, (b, ray))` or `(label, None)`."""

    steps: tuple[tuple[int, tuple[int, Vector] | None], ...]

    @classmethod
    def from_kernel(cls, steps: Iterable[tuple[int, tuple[int, list[int]] | None]]) -> Tree:
        """The kernel's lists as tuples."""
        return cls(tuple((head, split and (split[0], tuple(map(Fraction, split[1])))) for head, split in steps))

    def leaves(self, generators: list[Vector]) -> list[tuple[list[Vector], int]] | None:
        """The leaf cones with their labels; None if a split is not between its two generators."""
        stack, leaves = [generators], []
        for head, split in self.steps:
            if not stack:
                return None
            cone = stack.pop()
            if split is None:
                leaves.append((cone, head))
                continue
            b, ray = split
            if not _between(cone[head], cone[b], ray):
                return None
            stack.append([ray if i == b else g for i, g in enumerate(cone)])
            stack.append([ray if i == head else g for i, g in enumerate(cone)])
        return None if stack else leaves


def _between(p: Vector, q: Vector, ray: Vector) -> bool:
    """Whether ray = s p + t q with s, t > 0."""
    pairs = [(i, j) for i in range(len(p)) for j in range(i) if p[i] * q[j] != p[j] * q[i]]
    if not pairs:
        return False
    i, j = pairs[0]
    d = p[i] * q[j] - p[j] * q[i]
    s = Fraction(ray[i] * q[j] - ray[j] * q[i]) / d
    t = Fraction(p[i] * ray[j] - p[j] * ray[i]) / d
    return s > 0 and t > 0 and all(s * a + t * b == c for a, b, c in zip(p, q, ray, strict=True))


@dataclass(frozen=True)
class AllShadowed:
    """A tree that covers the orthant with the cones pos{e_i, A_i. : i != j}, labelled j: refutes (++).

    If AX is in Z with X in K, some v > 0 has v'X > 0; were v = sum of c_i e_i + d_i A_i. over i != j, then
    v'X_j = sum of c_i X_ij + d_i (AX)_ij <= 0, absurd. So v is in no cone, but every v is in a leaf, inside one.
    """

    tree: Tree

    def refutes(self, A: Rows) -> bool:
        """Every generator of every leaf is a nonnegative combination, found by trying bases."""
        n = len(A)
        unit = [tuple(Fraction(i == j) for j in range(n)) for i in range(n)]
        leaves = self.tree.leaves(unit)
        known: dict[tuple[Vector, int], bool] = {}
        for cone, j in leaves or ():
            generators = [g for i in range(n) if i != j for g in (unit[i], A[i])]
            for ray in cone:
                if (ray, j) not in known:
                    known[ray, j] = in_cone(generators, ray)
                if not known[ray, j]:
                    return False
        return leaves is not None

    def sentence(self, A: Rows) -> str:
        """Say what it shows."""
        return "every v > 0 lies in some pos{e_i, A_i. : i != j}, so no X in K with v'X > 0 has AX in Z"


def in_cone(generators: list[Vector], x: Vector) -> bool:
    """Whether x is a nonnegative combination: some independent n generators suffice (Caratheodory)."""
    n = len(x)
    if not any(x):
        return True
    for choice in subsets(len(generators)):
        if len(choice) == n:
            weights = solve(transpose(tuple(generators[i] for i in choice)), x)
            if weights is not None and min(weights) >= 0:
                return True
    return False


@dataclass(frozen=True)
class InSubmatrix:
    """A witness for A[alpha, alpha]."""

    alpha: IndexSet
    inner: Witness

    def refutes(self, A: Rows) -> bool:
        """Check it there."""
        return self.inner.refutes(principal(A, self.alpha))

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
        M = pivot_transform(A, self.alpha)
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
    """Several facts that refute together."""

    parts: tuple[Witness, ...]

    def refutes(self, A: Rows) -> bool:
        """Check each."""
        return all(part.refutes(A) for part in self.parts)

    def sentence(self, A: Rows) -> str:
        """Say each."""
        return "; ".join(part.sentence(A) for part in self.parts)


@dataclass(frozen=True)
class Implied:
    """The witness or certificate of another class, with the inclusion that carries it over."""

    verdict: Verdict
    inclusion: str

    def refutes(self, A: Rows) -> bool:
        """Check the verdict on the larger class."""
        return self.verdict.check() is True

    def proves(self, A: Rows) -> bool:
        """Check the verdict on the smaller class."""
        return self.verdict.check() is True

    def sentence(self, A: Rows) -> str:
        """The inclusion and the other class's reason."""
        return f"{self.inclusion}; {self.verdict.reason}"


def origin(verdict: Verdict) -> Any:
    """The witness behind a chain of inclusions."""
    while isinstance(verdict.witness, Implied):
        verdict = verdict.witness.verdict
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
    for row in range(n):
        rest = tuple(tuple(A[i][j] for j in range(n - 1)) for i in range(n) if i != row)
        y = solve(rest, [-A[i][n - 1] for i in range(n) if i != row])
        if y is not None:
            return min(y) > 0 and dot(A[row], (*y, 1)) == 0
    return False
