"""lcpstar: linear complementarity problems, solved, verified and proved.

Find z with  w = A z + q >= 0,  z >= 0,  z'w = 0.
"""

from . import errors
from ._core import Solution, __version__
from .batch import BatchSolution, solve_batch, solve_gufunc
from .errors import LCPError
from .interior import potential_reduction
from .options import BlockPivotingOptions, LemkeHowsonOptions, LemkeOptions, PotentialReductionOptions
from .result import Certificate, Ray, Status
from .solutions import Face, solutions
from .solve import ppt, solve
from .verify import Report, verify

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
    "BlockPivotingOptions",
    "PotentialReductionOptions",
    "LCPError",
    "errors",
    "__version__",
]
