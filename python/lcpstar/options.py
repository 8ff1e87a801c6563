"""Options of the methods of `solve`: one frozen class per method; `None` means the core's default."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from numpy.typing import ArrayLike

from .coerce import MAX_SEED, as_count, as_flag, as_indices, as_number, as_text, as_vector

_COUNT_FROM_ONE, _SEED = partial(as_count, least=1), partial(as_count, largest=MAX_SEED)

#: What the fields hold, whatever class they are in. The core checks ranges.
_FIELDS: dict[str, Callable[[str, Any], Any]] = {
    "d": as_vector,
    "alpha": as_indices,
    "direction": as_text,
    **dict.fromkeys(("restarts", "label", "starts", "patience", "min_halvings"), as_count),
    **dict.fromkeys(("sweeps", "solves"), _COUNT_FROM_ONE),
    "seed": _SEED,
    **dict.fromkeys(("beta", "gamma", "sigma", "kappa_factor", "relaxation", "rho"), as_number),
    **dict.fromkeys(("long_step", "finish", "symmetric", "polish"), as_flag),
}


class _Checked:
    """Options say at once which field is of the wrong type."""

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:  # type: ignore[attr-defined]
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, _FIELDS[name](name, value))


@dataclass(frozen=True, eq=False)
class LemkeOptions(_Checked):
    """Options of `method="lemke"`.

    `d` : (n,) covering vector, strictly positive, in the units of w. Without it, ones on the equilibrated problem, then
    `restarts` (default 6) other vectors after a failure, drawn with `seed` (default 0). With it, exactly that run.
    """

    d: ArrayLike | None = None
    restarts: int | None = None
    seed: int | None = None


@dataclass(frozen=True)
class LemkeHowsonOptions(_Checked):
    """Options of `method="lemke_howson"`: the `label` (an index, default 0) that is dropped first."""

    label: int | None = None


@dataclass(frozen=True)
class BilinearOptions(_Checked):
    """Options of `method="bilinear"`: random `starts` (default 100) after the first, and their `seed` (default 0)."""

    starts: int | None = None
    seed: int | None = None


@dataclass(frozen=True)
class BlockPivotingOptions(_Checked):
    """Options of `method="block_pivoting"`.

    `patience` (default 5): block exchanges that may fail to reduce the number of wrong signs before Murty's rule takes
    over. `alpha`: first guess of the support; default, the indices with `q_i < 0`.
    """

    patience: int | None = None
    alpha: Sequence[int] | None = None


@dataclass(frozen=True)
class PotentialReductionOptions(_Checked):
    """Options of `method="potential_reduction"`: the paper's parameters, as in `lcpstar.potential_reduction`.

    Its `eps` is chosen from `tol`. Defaults: beta 0.5, gamma 0.5, sigma 0.2, kappa_factor 1.01, min_halvings 1,
    direction "cholesky" (or "qr"), long_step False.
    """

    beta: float | None = None
    gamma: float | None = None
    sigma: float | None = None
    kappa_factor: float | None = None
    min_halvings: int | None = None
    direction: str | None = None
    long_step: bool | None = None


@dataclass(frozen=True)
class InteriorPointOptions(_Checked):
    """Options of `method="interior_point"`.

    `finish` (default True): end at a complementary basis, with a residual at rounding level, where one is found.
    """

    finish: bool | None = None


@dataclass(frozen=True)
class PgsOptions(_Checked):
    """Options of `method="pgs"`.

    `relaxation` in (0, 2) (default 1); `symmetric` (default False): every other sweep runs downwards.
    """

    relaxation: float | None = None
    symmetric: bool | None = None


@dataclass(frozen=True)
class PgsSmOptions(_Checked):
    """Options of `method="pgs_sm"`.

    `sweeps` (default 5) before the first solve; `solves` (default 4) on the support in a round, after each of which
    indices with the wrong sign leave; `relaxation` of the sweeps in (0, 2) (default 1).
    """

    sweeps: int | None = None
    solves: int | None = None
    relaxation: float | None = None


@dataclass(frozen=True)
class AdmmOptions(_Checked):
    """Options of `method="admm"`.

    `rho` (default 0.1) is the first penalty, on the equilibrated problem; it adapts. `relaxation` in (0, 2) (default
    1.6). `polish` (default True): solve on the support when it has settled.
    """

    rho: float | None = None
    relaxation: float | None = None
    polish: bool | None = None


@dataclass(frozen=True)
class NewtonOptions(_Checked):
    """Options of `method="newton"`: `patience` (default 3), the guesses of the support that may bring it no nearer."""

    patience: int | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.patience is not None:
            as_count("patience", self.patience, least=1)


MethodOptions = (
    LemkeOptions
    | LemkeHowsonOptions
    | BilinearOptions
    | BlockPivotingOptions
    | PotentialReductionOptions
    | InteriorPointOptions
    | PgsOptions
    | PgsSmOptions
    | AdmmOptions
    | NewtonOptions
)

#: The options class of each method that has one.
OPTIONS: dict[str, type[MethodOptions]] = {
    "lemke": LemkeOptions,
    "lemke_howson": LemkeHowsonOptions,
    "bilinear": BilinearOptions,
    "block_pivoting": BlockPivotingOptions,
    "potential_reduction": PotentialReductionOptions,
    "interior_point": InteriorPointOptions,
    "pgs": PgsOptions,
    "pgs_sm": PgsSmOptions,
    "admm": AdmmOptions,
    "newton": NewtonOptions,
}
