"""Matrix classes of complementarity theory: exact verdicts with witnesses that can be checked by hand."""

from .complementarity import (
    is_completely_q,
    is_completely_q0,
    is_completely_semimonotone_star,
    is_completely_tilde_semimonotone_star,
    is_almost_strictly_semimonotone,
    is_column_sufficient,
    is_connected,
    is_fully_semimonotone,
    is_l,
    is_l2,
    is_plus_plus,
    is_q,
    is_q0,
    is_qb,
    is_r0,
    is_regular,
    is_row_sufficient,
    is_semimonotone,
    is_semimonotone_star,
    is_strictly_semimonotone,
    is_sufficient,
    is_tilde_semimonotone_star,
)
from .game import Game, game, game_value
from .minors import (
    is_almost_n,
    is_almost_n0,
    is_almost_p,
    is_almost_p0,
    is_k0,
    is_n,
    is_n0,
    is_p,
    is_p0,
    is_z,
)
from .quadratic import (
    is_almost_copositive,
    is_almost_fully_copositive,
    is_copositive,
    is_copositive_plus,
    is_copositive_star,
    is_fully_copositive,
    is_positive_definite,
    is_positive_semidefinite,
    is_positive_subdefinite,
    is_pseudomonotone,
    is_strictly_copositive,
)
from .registry import ALIASES, CLASSES, MatrixClass, check
from .report import Classification, classify
from .solution_set import Face, LocalReport, SolutionSet, solution_set
from .verdict import Cost, Verdict

__all__ = [
    "ALIASES",
    "CLASSES",
    "Classification",
    "Cost",
    "MatrixClass",
    "Verdict",
    "check",
    "classify",
    *(name for name in dir() if name.startswith("is_")),
]
