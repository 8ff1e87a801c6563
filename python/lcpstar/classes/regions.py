"""Witnesses about whole regions: a q without solution, a disconnected SOL(q, A), a covering of the orthant by cones."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from .exact import Rows, Vector, determinant, dot, principal, show, times, transpose
from .witness import is_nonnegative, is_solution


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
    """A solution z with z_i + w_i > 0 and A[alpha, alpha] nonsingular is isolated; `other` is a second one."""

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
        if any(not 0 <= alpha < 2**n for alpha in self.points):
            return False
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
        """Every generator of every leaf is a nonnegative combination."""
        n = len(A)
        unit = [tuple(Fraction(i == j) for j in range(n)) for i in range(n)]
        leaves = self.tree.leaves(unit)
        known: dict[tuple[Vector, int], bool] = {}
        for cone, j in leaves or ():
            if not 0 <= j < n:
                return False
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
    """Whether x is a nonnegative combination: the first phase of the simplex method with Bland's rule [Chv83]."""
    n, m = len(x), len(generators)
    # Rows (coefficients | right side >= 0); an artificial variable m + i is basic in row i, and their sum is minimised.
    signs = [-1 if v < 0 else 1 for v in x]
    table = [[*(Fraction(s * g[i]) for g in generators), Fraction(s * x[i])] for i, s in enumerate(signs)]
    basis = [m + i for i in range(n)]
    table.append([sum((row[j] for row in table), Fraction(0)) for j in range(m + 1)])
    while table[n][m]:
        entering = next((j for j in range(m) if table[n][j] > 0), None)
        if entering is None:
            return False
        rows = [i for i in range(n) if table[i][entering] > 0]
        leaving = min(rows, key=lambda i: (table[i][m] / table[i][entering], basis[i]))
        basis[leaving] = entering
        pivot = table[leaving][entering]
        table[leaving] = top = [v / pivot for v in table[leaving]]
        for i in range(n + 1):
            if i != leaving and (factor := table[i][entering]):
                table[i] = [v - factor * t for v, t in zip(table[i], top, strict=True)]
    return True
