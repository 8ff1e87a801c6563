"""`solutions`: the whole solution set of an LCP, as faces in exact numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._core import solutions as find_faces
from .classes.solution_set import solution_set
from .coerce import Matrix, as_flag, as_matrix, as_seconds, as_vector
from .errors import NotFiniteError

Points = Matrix | list[list[Fraction]]


@dataclass(frozen=True, eq=False)
class Face:
    """A maximal face of SOL(q, A): the convex hull of `vertices` plus the cone spanned by `rays`.

    `alpha` holds the indices with z_i > 0 somewhere on the face; there w_i = 0 on the whole face. `vertices` is
    (m, n) with m >= 1 and `rays` (k, n) with k >= 0 and largest entry 1 in each ray: float arrays, the nearest doubles
    of the exact numbers, or lists of lists of `Fraction`.
    """

    alpha: list[int]
    vertices: Points
    rays: Points

    @property
    def is_point(self) -> bool:
        """Whether the face is a single solution."""
        return len(self.vertices) == 1 and len(self.rays) == 0

    def __repr__(self) -> str:
        shape = "point" if self.is_point else f"{len(self.vertices)} vertices, {len(self.rays)} rays"
        return f"Face(alpha={self.alpha}, {shape})"


def solutions(A: ArrayLike, q: ArrayLike, exact: bool = False, time_limit: float | None = None) -> list[Face]:
    """Find every solution of LCP(q, A).

    Parameters
    ----------
    A : (n, n) array_like of real numbers, n <= 127
        Read as the binary numbers they are; `Fraction`, integers of any size, strings like "1/3" and sparse A, too.
    q : (n,) array_like of real numbers
    exact : bool
        Vertices and rays as lists of `Fraction` instead of the nearest doubles. The computation is exact either way.
    time_limit : float, optional
        Seconds.

    Returns
    -------
    list of Face
        The maximal faces of SOL(q, A), ordered by `alpha`; their union is the whole set. Empty: no solution exists.

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError, TooLargeError
        As `solve`; n > 127.
    TimeLimitError
        The set was not complete in time.

    Notes
    -----
    Double description on `{(z, t) >= 0, A z + q t >= 0}` where a generator is dropped as soon as some z_i w_i > 0
    [DSDM95]. Signs are decided in doubles under a rigorous bound and, where that is not enough, in integers.
    Exponential in the worst case; a random dense problem takes well under a second at n = 16.

    Examples
    --------
    >>> [face.vertices.tolist() for face in solutions([[-1]], [1])]
    [[[0.0]], [[1.0]]]
    >>> solutions([[1, 1], [1, 1]], [-1, -1])
    [Face(alpha=[0, 1], 2 vertices, 0 rays)]
    """
    exact, time_limit = as_flag("exact", exact), as_seconds("time_limit", time_limit)
    if _needs_fractions(A) or _needs_fractions(q):
        return _of_fractions(A, q, exact, time_limit)
    matrix, vector = as_matrix("A", A), as_vector("q", q)
    n = len(vector)
    faces = find_faces(matrix, vector, time_limit, exact)
    if exact:
        return [Face(alpha, _fractions(vertices), _fractions(rays)) for alpha, vertices, rays in faces]
    return [
        Face(alpha, np.array(vertices).reshape(len(vertices), n), np.array(rays).reshape(len(rays), n))
        for alpha, vertices, rays in faces
    ]


def _fractions(points: Sequence[tuple[list[int], int]]) -> list[list[Fraction]]:
    return [[Fraction(x, denominator) for x in numerators] for numerators, denominator in points]


def _needs_fractions(value: Any) -> bool:
    """Whether an argument holds anything but doubles and machine integers."""
    try:
        return np.asarray(value).dtype.kind not in "fiubc"
    except ValueError:  # ragged: whoever reads it says so
        return False


def _of_fractions(A: Any, q: Any, exact: bool, time_limit: float | None) -> list[Face]:
    found = sorted(solution_set(A, q, time_limit=time_limit).faces, key=lambda face: face.alpha)
    faces = [
        Face(list(f.alpha), list(map(list, f.vertices)), [[Fraction(x, max(ray)) for x in ray] for ray in f.rays])
        for f in found
    ]
    return (
        faces if exact else [Face(f.alpha, *(_rounded(part, len(q)) for part in (f.vertices, f.rays))) for f in faces]
    )


def _rounded(points: Points, n: int) -> Matrix:
    try:
        return np.array([[float(x) for x in point] for point in points]).reshape(len(points), n)
    except OverflowError:
        raise NotFiniteError("SOL(q, A) has a vertex beyond the range of doubles: ask for exact=True") from None
