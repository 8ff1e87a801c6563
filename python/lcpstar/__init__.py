"""lcpstar: linear complementarity problems, solved, verified and proved.

Find z with  w = A z + q >= 0,  z >= 0,  z'w = 0.
"""

from . import errors
from ._core import Solution, __version__
from .errors import LCPError
from .options import BlockPivotingOptions, LemkeHowsonOptions, LemkeOptions
from .result import Certificate, Ray, Status
from .solve import ppt, solve

__all__ = [
    "solve",
    "ppt",
    "Solution",
    "Status",
    "Certificate",
    "Ray",
    "LemkeOptions",
    "LemkeHowsonOptions",
    "BlockPivotingOptions",
    "LCPError",
    "errors",
    "__version__",
]
