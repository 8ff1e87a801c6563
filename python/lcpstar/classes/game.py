"""The von Neumann value of a matrix, with optimal strategies and Ville's alternative as its certificate."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal, overload

from ..coerce import as_flag
from ..errors import NotFiniteError
from .exact import Rows, Vector, times, transpose
from .registry import make_subject


@dataclass(frozen=True)
class Game:
    """`value = max over the simplex of min_i (Ax)_i`, exact; x and y are optimal: Ax >= v e, A'y <= v e.

    Ville's alternative: v > 0 and then Ax > 0, or v <= 0 and then 0 != y >= 0 has A'y <= 0.
    """

    value: Fraction
    x: Vector
    y: Vector
    matrix: Rows

    def check(self) -> bool:
        """Recompute both inequalities; together they prove the value."""
        simplex = all(min(s) >= 0 and sum(s) == 1 for s in (self.x, self.y))
        return simplex and min(times(self.matrix, self.x)) >= self.value >= max(times(transpose(self.matrix), self.y))


def game(A: Any) -> Game:
    """Solve the matrix game of a square matrix by one exact linear program.

    Raises
    ------
    ShapeError, DTypeError, NotFiniteError
        Subclasses of LCPError.

    Examples
    --------
    >>> g = game([[0, 2, 1], [1, 0, 1], [-2, -2, 1]])
    >>> str(g.value), g.check()
    ('1', True)
    """
    subject = make_subject(A, None)
    numerator, denominator, x, y = subject.kernel.game()
    value = Fraction(numerator, denominator) / subject.scale
    return Game(value, _normalised(x), _normalised(y), subject.rows)


def _normalised(x: list[int]) -> Vector:
    total = sum(x)
    return tuple(Fraction(v, total) for v in x)


@overload
def game_value(A: Any, exact: Literal[True]) -> Fraction: ...
@overload
def game_value(A: Any, exact: Literal[False] = False) -> float: ...
@overload
def game_value(A: Any, exact: bool = False) -> float | Fraction: ...
def game_value(A: Any, exact: bool = False) -> float | Fraction:
    """Von Neumann's v(A) = max over the simplex of min_i (Ax)_i; a Fraction when `exact`, else the nearest float.

    The strategies and the proof are in `lcpstar.classes.game(A)`.

    Examples
    --------
    >>> game_value([[0, "1/2"], ["1/3", 0]], exact=True)
    Fraction(1, 5)
    """
    exact = as_flag("exact", exact)
    value = game(A).value
    try:
        return value if exact else float(value)
    except OverflowError:
        raise NotFiniteError("the value of A is beyond the range of doubles: ask for exact=True") from None
