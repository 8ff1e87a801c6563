"""lcpstar: linear complementarity problems, solved, verified and proved.

Find z with  w = A z + q >= 0,  z >= 0,  z'w = 0.
"""

from typing import TYPE_CHECKING, Any

from . import errors
from ._core import Solution, __version__
from .accuracy import Accuracy, accuracy
from .batch import BatchSolution, solve_batch, solve_gufunc
from .errors import LCPError
from .interior import potential_reduction
from .options import (
    AdmmOptions,
    BilinearOptions,
    BlockPivotingOptions,
    InteriorPointOptions,
    LemkeHowsonOptions,
    LemkeOptions,
    NewtonOptions,
    PgsOptions,
    PgsSmOptions,
    PotentialReductionOptions,
)
from .result import Certificate, Ray, Status
from .solutions import Face, solutions
from .solve import ppt, solve
from .verify import Report, verify

if TYPE_CHECKING:  # loaded on first use, so that a program which only solves does not pay for the theory
    from . import classes, scenes
    from .classes import (
        Classification,
        Verdict,
        classify,
        game_value,
        is_almost_copositive,
        is_almost_fully_copositive,
        is_almost_n,
        is_almost_n0,
        is_almost_p,
        is_almost_p0,
        is_almost_strictly_semimonotone,
        is_column_sufficient,
        is_completely_q,
        is_completely_q0,
        is_completely_semimonotone_star,
        is_completely_tilde_semimonotone_star,
        is_connected,
        is_copositive,
        is_copositive_plus,
        is_copositive_star,
        is_fully_copositive,
        is_fully_semimonotone,
        is_k0,
        is_l,
        is_l2,
        is_n,
        is_n0,
        is_p,
        is_p0,
        is_plus_plus,
        is_positive_definite,
        is_positive_semidefinite,
        is_positive_subdefinite,
        is_pseudomonotone,
        is_q,
        is_q0,
        is_qb,
        is_r0,
        is_regular,
        is_row_sufficient,
        is_semimonotone,
        is_semimonotone_star,
        is_strictly_copositive,
        is_strictly_semimonotone,
        is_sufficient,
        is_tilde_semimonotone_star,
        is_z,
        solution_set,
    )
    from .exploring import explore

__all__ = [
    "solve",
    "solve_batch",
    "solve_gufunc",
    "ppt",
    "solutions",
    "verify",
    "potential_reduction",
    "Solution",
    "BatchSolution",
    "Status",
    "Certificate",
    "Face",
    "Report",
    "Ray",
    "LemkeOptions",
    "LemkeHowsonOptions",
    "BilinearOptions",
    "BlockPivotingOptions",
    "Accuracy",
    "accuracy",
    "PotentialReductionOptions",
    "PgsOptions",
    "PgsSmOptions",
    "AdmmOptions",
    "NewtonOptions",
    "InteriorPointOptions",
    "classes",
    "scenes",
    "classify",
    "explore",
    "game_value",
    "solution_set",
    "Classification",
    "Verdict",
    "is_almost_copositive",
    "is_almost_fully_copositive",
    "is_almost_n",
    "is_almost_n0",
    "is_almost_p",
    "is_almost_p0",
    "is_almost_strictly_semimonotone",
    "is_column_sufficient",
    "is_completely_q",
    "is_completely_q0",
    "is_completely_semimonotone_star",
    "is_completely_tilde_semimonotone_star",
    "is_connected",
    "is_copositive",
    "is_copositive_plus",
    "is_copositive_star",
    "is_fully_copositive",
    "is_fully_semimonotone",
    "is_k0",
    "is_l",
    "is_l2",
    "is_n",
    "is_n0",
    "is_p",
    "is_p0",
    "is_plus_plus",
    "is_positive_definite",
    "is_positive_semidefinite",
    "is_positive_subdefinite",
    "is_pseudomonotone",
    "is_q",
    "is_q0",
    "is_qb",
    "is_r0",
    "is_regular",
    "is_row_sufficient",
    "is_semimonotone",
    "is_semimonotone_star",
    "is_strictly_copositive",
    "is_strictly_semimonotone",
    "is_sufficient",
    "is_tilde_semimonotone_star",
    "is_z",
    "LCPError",
    "errors",
    "__version__",
]


def __getattr__(name: str) -> Any:
    """Load the classes and what builds on them, and scenes, when one of their names is first asked for."""
    if name not in __all__:
        raise AttributeError(f"module 'lcpstar' has no attribute {name!r}")
    from importlib import import_module

    if name == "scenes":
        return import_module(".scenes", __name__)
    module = import_module(".exploring" if name == "explore" else ".classes", __name__)
    return module if name == "classes" else getattr(module, name)
