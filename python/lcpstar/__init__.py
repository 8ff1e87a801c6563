"""lcpstar: linear complementarity problems, solved, verified and proved.

Find z with  w = A z + q >= 0,  z >= 0,  z'w = 0.
"""

from ._core import __version__

__all__ = ["__version__"]
