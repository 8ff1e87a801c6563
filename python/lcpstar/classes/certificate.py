"""Certificates of membership, where a compact one exists; checked like witnesses, without the core."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .exact import Rows, Vector, determinant, dot, principal, solve, subsets, times, transpose
from .regions import Tree, cone_columns
from .witness import RULES, is_opposite


@dataclass(frozen=True)
class LDL:
    """A + A' = L D L' with L unit lower triangular after the permutation `order`, D >= 0 (`definite`: > 0)."""

    order: tuple[int, ...]
    L: Rows
    D: Vector
    definite: bool = False

    def proves(self, A: Rows) -> bool:
        """Multiply it out."""
        n = len(A)
        if sorted(self.order) != list(range(n)) or len(self.D) != n or any(len(row) != n for row in self.L):
            return False
        unit = all(self.L[i][j] == (i == j) for i in range(n) for j in range(i, n))
        signs = all(d > 0 if self.definite else d >= 0 for d in self.D)
        product = all(
            sum((self.L[i][k] * self.D[k] * self.L[j][k] for k in range(n)), Fraction(0))
            == A[self.order[i]][self.order[j]] + A[self.order[j]][self.order[i]]
            for i in range(n)
            for j in range(i + 1)
        )
        return unit and signs and product


def ldl(A: Rows, definite: bool) -> LDL:
    """Factor A + A', known to be PSD, with diagonal pivoting. O(n^3)."""
    n = len(A)
    order: list[int] = []
    S = [[A[i][j] + A[j][i] for j in range(n)] for i in range(n)]
    columns: list[dict[int, Fraction]] = []
    D: list[Fraction] = []
    left = list(range(n))
    while left:
        k = max(left, key=lambda i: S[i][i])
        left.remove(k)
        d = S[k][k]
        column = {i: S[i][k] / d if d else Fraction(0) for i in left}
        for i in left:
            for j in left:
                S[i][j] -= column[i] * S[k][j]
        order.append(k)
        columns.append(column)
        D.append(d)
    L = tuple(
        tuple(
            Fraction(1) if i == k else columns[k].get(order[i], Fraction(0)) if k < i else Fraction(0) for k in range(n)
        )
        for i in range(n)
    )
    return LDL(tuple(order), L, tuple(D), definite)


@dataclass(frozen=True)
class MinorSigns:
    """All principal minors obey `rule`, one of `witness.RULES`; `proper`: all but det A, strictly of the other sign."""

    rule: str
    proper: bool = False

    def proves(self, A: Rows) -> bool:
        """2^n determinants."""
        minors = [determinant(principal(A, alpha)) for alpha in subsets(len(A))]
        if self.proper and not is_opposite(minors.pop(), self.rule):
            return False
        return all(map(RULES[self.rule], minors))


@dataclass(frozen=True)
class PositiveVector:
    """A in Z and v > 0 with Av > 0: A is a nonsingular M-matrix, hence P and K0 [CPS92, 3.11]."""

    v: Vector

    def proves(self, A: Rows) -> bool:
        """Multiply."""
        z = all(A[i][j] <= 0 for i in range(len(A)) for j in range(len(A)) if i != j)
        return z and min(self.v) > 0 and min(times(A, self.v)) > 0


@dataclass(frozen=True)
class InZ:
    """A in Z, and `inner` proves that it is in P0: A is in K0."""

    inner: Any

    def proves(self, A: Rows) -> bool:
        """Look at the entries off the diagonal, and check the other."""
        z = all(A[i][j] <= 0 for i in range(len(A)) for j in range(len(A)) if i != j)
        return z and bool(self.inner.proves(A))


@dataclass(frozen=True)
class Decomposition:
    """A + A' = N + S with N >= 0 entrywise and S PSD by `factor`: A is copositive."""

    N: Rows
    factor: LDL

    def proves(self, A: Rows) -> bool:
        """Check both parts."""
        n = len(A)
        half = tuple(tuple(A[i][j] - self.N[i][j] / 2 for j in range(n)) for i in range(n))
        symmetric = all(self.N[i][j] == self.N[j][i] >= 0 for i in range(n) for j in range(n))
        return symmetric and self.factor.proves(half)


@dataclass(frozen=True)
class OrthantTrees:
    """Space is covered by simplicial cones, each inside one complementary cone, so that LCP(q, A) is solvable there.

    `trees[orthant]` splits the orthant whose entry i is nonpositive for each bit i. A leaf labelled below 2^n lies in
    the complementary cone of that bit mask; a leaf labelled 2^n + k lies in the half space `y_k q <= 0`, `y_k` one of
    `infeasible`, whose interior is infeasible. With no infeasible half space this proves Q, otherwise Q0.
    """

    trees: dict[int, Tree]
    infeasible: tuple[Vector, ...] = ()

    def proves(self, A: Rows) -> bool:
        """Walk all trees; a generator of a leaf is in its cone when it solves the complementary system."""
        n = len(A)
        transposed = transpose(A)
        if not all(min(y) >= 0 and any(y) and max(times(transposed, y)) <= 0 for y in self.infeasible):
            return False
        known: dict[tuple[Vector, int], bool] = {}
        for orthant in range(2**n):
            corner = [tuple(Fraction((-1 if orthant >> i & 1 else 1) * (i == j)) for j in range(n)) for i in range(n)]
            leaves = self.trees[orthant].leaves(corner)
            if leaves is None:
                return False
            for cone, label in leaves:
                for q in cone:
                    if (q, label) not in known:
                        known[q, label] = self._inside(A, q, label)
                    if not known[q, label]:
                        return False
        return True

    def _inside(self, A: Rows, q: Vector, label: int) -> bool:
        n = len(A)
        if label >= 2**n:
            return dot(self.infeasible[label - 2**n], q) <= 0
        weights = solve(transpose(tuple(cone_columns(A, label))), q)
        return weights is not None and min(weights) >= 0


@dataclass(frozen=True)
class MinkowskiFactor:
    """X in K with AX in Z, proved by v > 0 with v'X > 0: the (++)-property."""

    X: Rows
    v: Vector

    def proves(self, A: Rows) -> bool:
        """Multiply."""
        n = len(A)
        columns = transpose(self.X)
        images = [times(A, x) for x in columns]
        off = [(i, j) for i in range(n) for j in range(n) if i != j]
        return (
            min(self.v) > 0
            and all(columns[j][i] <= 0 and images[j][i] <= 0 for i, j in off)
            and all(dot(self.v, x) > 0 for x in columns)
        )
