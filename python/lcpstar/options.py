"""Options of the methods of `solve`: one frozen class per method; `None` means the core's default."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from .coerce import as_vector


@dataclass(frozen=True, eq=False)
class LemkeOptions:
    """Options of `method="lemke"`.

    `d` : (n,) covering vector, strictly positive, in the units of w. Without it, ones on the equilibrated problem, then
    `restarts` (default 6) other vectors after a failure, drawn with `seed` (default 0). With it, exactly that run.
    """

    d: ArrayLike | None = None
    restarts: int | None = None
    seed: int | None = None

    def __post_init__(self) -> None:
        if self.d is not None:
            object.__setattr__(self, "d", as_vector("d", self.d))


@dataclass(frozen=True)
class LemkeHowsonOptions:
    """Options of `method="lemke_howson"`: the `label` (an index, default 0) that is dropped first."""

    label: int | None = None


@dataclass(frozen=True)
class BlockPivotingOptions:
    """Options of `method="block_pivoting"`.

    `patience` (default 5): block exchanges that may fail to reduce the number of wrong signs before Murty's rule takes
    over. `alpha`: first guess of the support; default, the indices with `q_i < 0`.
    """

    patience: int | None = None
    alpha: Sequence[int] | None = None


MethodOptions = LemkeOptions | LemkeHowsonOptions | BlockPivotingOptions

#: The options class of each method that has one.
OPTIONS: dict[str, type[MethodOptions]] = {
    "lemke": LemkeOptions,
    "lemke_howson": LemkeHowsonOptions,
    "block_pivoting": BlockPivotingOptions,
}
