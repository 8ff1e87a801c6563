"""The whole of SOL(q, A): its faces, and what they say about boundedness, convexity, uniqueness and stability."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ..errors import OptionError
from .exact import IndexSet, Rows, Vector, determinant, dot, pivot_transform, principal, read_vector, show, times
from .registry import make_subject
from .subject import Subject
from .witness import is_solution


@dataclass(frozen=True)
class Face:
    """The polyhedron of the z in SOL(q, A) with z = 0 off alpha and w = 0 on alpha."""

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
    """SOL(q, A), exact: a union of `faces`; `components` counts the connected components (0: no solution)."""

    faces: tuple[Face, ...]
    components: int
    q: Vector
    _subject: Subject = field(repr=False)

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
        A, zero = self._subject.rows, (Fraction(0),) * len(self.q)
        points = [
            (z, tuple(a + b for a, b in zip(times(A, z), self.q, strict=True))) for f in self.faces for z in f.vertices
        ]
        points += [(tuple(map(Fraction, r)), times(A, r)) for f in self.faces for r in f.rays] if self.faces else []
        points = [p for p in points if p[0] != zero or any(p[1])]
        return all(dot(z, w) == 0 for z, _ in points for _, w in points)

    def local(self, z: Any) -> LocalReport:
        """What a solution z looks like from nearby; raises OptionError if z does not solve LCP(q, A)."""
        A = self._subject.rows
        point = read_vector(z, len(self.q), "z")
        if not is_solution(A, self.q, point):
            raise OptionError(f"z must solve LCP(q, A), got z = {show(point)}")
        w = [a + b for a, b in zip(times(A, point), self.q, strict=True)]
        alpha = tuple(i for i, v in enumerate(point) if v)
        ties = tuple(i for i, v in enumerate(point) if not v and not w[i])
        unique = self._subject.ask("is_isolated", sum(1 << i for i in alpha), sum(1 << i for i in ties))
        strong = _is_strongly_regular(A, alpha, ties)
        only = self.finite and len({z for f in self.faces for z in f.vertices}) == 1
        by_theorem = only and bool(self._subject.verdict("tE0s")) and self._subject.kernel.game()[0] > 0
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
        Seconds; TimeoutError when they are over.

    Returns
    -------
    SolutionSet

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError
        Subclasses of LCPError.

    Notes
    -----
    One double description per index set and one linear program per pair of them: for n <= 10 or so.

    Examples
    --------
    >>> found = solution_set([[0, 1, 1], [2, 0, 2], [-2, -5, 0]], [-4, -7, 10])
    >>> found.components, found.finite, found.local([5, 0, 4]).strongly_stable
    (3, True, True)
    """
    subject = make_subject(A, time_limit)
    vector = read_vector(q, subject.n)
    # The kernel holds scale * A: with q scaled by the common denominator d, its z is d z / scale.
    common = 1
    for value in vector:
        common = common * value.denominator // _gcd(common, value.denominator)
    whole = tuple(int(v * common) for v in vector)
    factor = Fraction(subject.scale, common)
    faces = []
    for mask, vertices, rays in subject.ask("pieces", whole):
        points = tuple(tuple(Fraction(v, t) * factor for v in z) for z, t in vertices)
        faces.append(Face(tuple(i for i in range(subject.n) if mask >> i & 1), points, tuple(map(tuple, rays))))
    components = subject.ask("components", whole)[2]
    subject.deadline = None  # the time limit is that of the set; `local` is asked later
    return SolutionSet(tuple(faces), components, vector, subject)


def _gcd(a: int, b: int) -> int:
    while b:
        a, b = b, a % b
    return a
