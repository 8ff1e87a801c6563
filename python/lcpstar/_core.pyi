from collections.abc import Sequence
from typing import Any, final

from .coerce import Matrix, Vector
from .options import MethodOptions, PotentialReductionOptions
from .result import Certificate, Ray, Status

__all__ = ["Solution", "__version__", "potential_direction", "potential_reduction", "ppt", "solve"]
__version__: str

@final
class Solution:
    """The verified result of one solve. Frozen; compares by identity."""

    @property
    def z(self) -> Vector: ...
    @property
    def w(self) -> Vector: ...
    @property
    def status(self) -> Status: ...
    @property
    def success(self) -> bool: ...
    @property
    def method(self) -> str: ...
    @property
    def iterations(self) -> int: ...
    @property
    def residual(self) -> float: ...
    @property
    def natural_residual(self) -> float: ...
    @property
    def alpha(self) -> list[int]: ...
    @property
    def certificate(self) -> Certificate | None: ...
    @property
    def ray(self) -> Ray | None: ...
    @property
    def pieces(self) -> list[tuple[list[int], str]]: ...
    @property
    def message(self) -> str: ...
    @property
    def time(self) -> float: ...
    @property
    def trace(self) -> Any: ...

def solve(
    a: Matrix,
    q: Vector,
    method_name: str,
    tol: float,
    max_iterations: int | None,
    time_limit: float | None,
    z0: Vector | None,
    certify: str,
    options: MethodOptions | None,
) -> Solution: ...
def ppt(a: Matrix, alpha: Sequence[int], q: Vector | None) -> tuple[Matrix, Vector]: ...
def potential_reduction(
    a: Matrix,
    q: Vector,
    z0: Vector | None,
    eps: float,
    max_iterations: int,
    options: PotentialReductionOptions,
    trace: bool,
) -> Solution: ...
def potential_direction(
    a: Matrix, z: Vector, w: Vector, kappa: float, direction: str
) -> tuple[Vector, Vector, str]: ...
def prove_solution(
    a: Matrix, q: Vector, alpha: Sequence[int]
) -> tuple[str, list[int], tuple[list[int], int] | None, int]: ...
def solutions(a: Matrix, q: Vector, time_limit: float | None, exact: bool) -> Any: ...
