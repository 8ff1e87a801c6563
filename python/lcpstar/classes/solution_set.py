"""The whole of SOL(q, A): its maximal faces, and what they say of it: bounded, convex, connected, unique, stable."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from .._core import solutions
from ..coerce import as_seconds
from ..errors import OptionError, TimeLimitError
from .exact import (
    IndexSet,
    Rows,
    Vector,
    determinant,
    dot,
    pivot_transform,
    principal,
    read_matrix,
    read_vector,
    show,
    times,
)
from .subject import Subject
from .witness import is_solution


@dataclass(frozen=True)
class Face:
    """A maximal face, as `lcpstar.solutions` finds it: z_i > 0 somewhere on it for i in alpha, and w_i = 0 there."""

    alpha: IndexSet
    vertices: tuple[Vector, ...]
    rays: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class LocalReport:
    """One solution seen from nearby.

    `strongly_stable` is Robinson's strong regularity: A[alpha, alpha] is nonsingular and its Schur complement on the
    degenerate indices is a P-matrix; then small changes of (q, A) move the solution uniquely, Lipschitz-continuously.
    `stable` is True when the paper's theorem applies (tE0s, v(A) > 0, the only solution) or it is strongly stable;
    otherwise None: stability in general is no finite test.
    """

    z: Vector
    alpha: IndexSet
    degenerate: IndexSet
    locally_unique: bool
    strongly_stable: bool
    stable: bool | None


@dataclass(frozen=True)
class SolutionSet:
    """SOL(q, A), exact: the union of its maximal `faces`, ordered by alpha as a binary number."""

    faces: tuple[Face, ...]
    matrix: Rows = field(repr=False)
    q: Vector

    @cached_property
    def components(self) -> int:
        """The connected components (0: no solution). Faces that meet share a vertex: they are faces of FEA(q, A)."""
        groups: list[set[Vector]] = []
        for face in self.faces:
            touching = [group for group in groups if not group.isdisjoint(face.vertices)]
            groups = [group for group in groups if group.isdisjoint(face.vertices)]
            groups.append(set(face.vertices).union(*touching))
        return len(groups)

    @property
    def empty(self) -> bool:
        """No solution."""
        return not self.faces

    @property
    def bounded(self) -> bool:
        """No face has a ray."""
        return not any(face.rays for face in self.faces)

    @property
    def finite(self) -> bool:
        """Every face is a point."""
        return self.bounded and all(len(face.vertices) == 1 for face in self.faces)

    @property
    def connected(self) -> bool:
        """At most one component."""
        return self.components <= 1

    @property
    def convex(self) -> bool:
        """Any two solutions satisfy z'w~ = 0: then, and only then, the segment between them solves."""
        A, zero = self.matrix, (Fraction(0),) * len(self.q)
        points = [
            (z, tuple(a + b for a, b in zip(times(A, z), self.q, strict=True))) for f in self.faces for z in f.vertices
        ]
        points += [(tuple(map(Fraction, r)), times(A, r)) for f in self.faces for r in f.rays] if self.faces else []
        points = [p for p in points if p[0] != zero or any(p[1])]
        return all(dot(z, w) == 0 for z, _ in points for _, w in points)

    def local(self, z: Any) -> LocalReport:
        """What a solution z looks like from nearby; raises OptionError if z does not solve LCP(q, A)."""
        A = self.matrix
        subject = Subject(A)
        point = read_vector(z, len(self.q), "z")
        if not is_solution(A, self.q, point):
            raise OptionError(f"z must solve LCP(q, A), got z = {show(point)}")
        w = [a + b for a, b in zip(times(A, point), self.q, strict=True)]
        alpha = tuple(i for i, v in enumerate(point) if v)
        ties = tuple(i for i, v in enumerate(point) if not v and not w[i])
        unique = subject.ask("is_isolated", sum(1 << i for i in alpha), sum(1 << i for i in ties))
        strong = _is_strongly_regular(A, alpha, ties)
        only = self.finite and len({z for f in self.faces for z in f.vertices}) == 1
        by_theorem = only and bool(subject.verdict("tE0s")) and subject.kernel.game()[0] > 0
        return LocalReport(point, alpha, ties, unique, strong, True if strong or by_theorem else None)

    def __str__(self) -> str:
        if self.empty:
            return "SOL(q, A) is empty"
        words = [word for word in ("finite", "bounded", "connected", "convex") if getattr(self, word)]
        lines = [f"SOL(q, A): {len(self.faces)} faces, {self.components} components; {', '.join(words) or 'unbounded'}"]
        for face in self.faces:
            rays = f" + cone{{{', '.join(map(show, face.rays))}}}" if face.rays else ""
            lines.append(f"  alpha = {set(face.alpha) or '{}'}: conv{{{', '.join(map(show, face.vertices))}}}{rays}")
        return "\n".join(lines)


def _is_strongly_regular(A: Rows, alpha: IndexSet, ties: IndexSet) -> bool:
    block = principal(A, (*alpha, *ties))
    if alpha and determinant(principal(A, alpha)) == 0:
        return False
    if not ties:
        return True
    M = pivot_transform(block, range(len(alpha))) if alpha else block
    assert M is not None
    schur = principal(M, range(len(alpha), len(block)))
    return bool(Subject(schur).verdict("P"))


def solution_set(A: Any, q: Any, *, time_limit: float | None = None) -> SolutionSet:
    """All of SOL(q, A) in exact arithmetic.

    Parameters
    ----------
    A : (n, n) array_like, q : (n,) array_like
        Exact numbers as for `lcpstar.classes.check`.
    time_limit : float, optional
        Seconds; TimeLimitError when they are over.

    Returns
    -------
    SolutionSet

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError
        Subclasses of LCPError.

    Notes
    -----
    As `lcpstar.solutions`, which takes the problem when a positive factor for each row of (A, q) makes all numbers
    doubles; other problems take one double description per index set: n <= 10 or so.

    Examples
    --------
    >>> found = solution_set([[0, 1, 1], [2, 0, 2], [-2, -5, 0]], [-4, -7, 10])
    >>> found.components, found.finite, found.local([5, 0, 4]).strongly_stable
    (3, True, True)
    """
    limit = as_seconds("time_limit", time_limit)
    rows = read_matrix(A)
    vector = read_vector(q, len(rows))
    given: list[tuple[Any, ...]] = [(*row, c) for row, c in zip(rows, vector, strict=True)]
    for table in (given, list(map(_whole, given))):
        if all(abs(x) < 2**1023 and float(x) == x for row in table for x in row):
            doubles = np.array(table, dtype=np.float64)
            faces = [
                Face(
                    tuple(alpha),
                    tuple(tuple(Fraction(x, d) for x in z) for z, d in vertices),
                    tuple(_whole(ray) for ray, _ in rays),
                )
                for alpha, vertices, rays in solutions(doubles[:, :-1], doubles[:, -1], limit, True)
            ]
            break
    else:
        faces = _maximal_pieces(rows, vector, limit)
    return SolutionSet(tuple(sorted(faces, key=lambda face: sum(1 << i for i in face.alpha))), rows, vector)


def _whole(row: Iterable[Any]) -> tuple[int, ...]:
    """The positive multiple of a row, or of a ray, whose entries are integers without a common factor."""
    fractions = list(map(Fraction, row))
    common = math.lcm(*(x.denominator for x in fractions))
    numbers = [int(x * common) for x in fractions]
    divisor = math.gcd(*numbers) or 1
    return tuple(x // divisor for x in numbers)


def _maximal_pieces(rows: Rows, q: Vector, time_limit: float | None) -> list[Face]:
    """The pieces `z = 0 off alpha, w = 0 on alpha` that lie in no other one."""
    subject = Subject(rows, None if time_limit is None else time.monotonic() + time_limit)
    # The kernel holds scale * A: with q scaled by the common denominator d, its z is d z / scale.
    common = math.lcm(*(value.denominator for value in q))
    try:
        pieces = subject.ask("pieces", tuple(int(v * common) for v in q))
    except TimeoutError:
        raise TimeLimitError("the solution set was not complete when time_limit had passed") from None
    faces = []
    for _, vertices, rays in pieces:
        points = tuple(sorted(tuple(Fraction(v * subject.scale, t * common) for v in z) for z, t in vertices))
        directions = tuple(sorted(map(tuple, rays)))
        alpha = tuple(i for i in range(subject.n) if any(x[i] for x in (*points, *directions)))
        faces.append(Face(alpha, points, directions))
    generators = {face: {*face.vertices, *((ray,) for ray in face.rays)} for face in faces}
    return [f for f, inside in generators.items() if not any(inside < other for other in generators.values())]
