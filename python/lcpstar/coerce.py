"""Arguments in: arrays of any real dtype and memory order, lists, numbers; anything else raises and names itself."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import DTypeError, IndexSetError, NotFiniteError, OptionError, OptionTypeError, ShapeError

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_FLOAT64 = np.dtype(np.float64)


#: Largest count that the core takes, and a time limit [s] beyond which there is none.
_LARGEST, _FOREVER = 2**63 - 1, 1e9
#: Largest seed, and more threads than anybody has.
MAX_SEED, MAX_THREADS = 2**64 - 1, 1024


def as_number(name: str, value: Any) -> float:
    """A real number, not a boolean. Its range is checked by who uses it."""
    if isinstance(value, (bool, np.bool_, str, bytes, complex)) or not hasattr(value, "__float__") or np.ndim(value):
        raise OptionTypeError(f"{name} must be a real number, got {_shown(value)}")
    return float(value)


def as_count(name: str, value: Any, least: int = 0, largest: int | None = None) -> int:
    """An integer in `least..=largest`. Without `largest` one beyond 2^63 is no limit: the largest the core takes."""
    if isinstance(value, (bool, np.bool_)) or not hasattr(value, "__index__") or np.ndim(value):
        raise OptionTypeError(f"{name} must be an integer, got {_shown(value)}")
    count = operator.index(value)
    if count < least:
        rule = {0: "nonnegative", 1: "at least 1"}.get(least, f"at least {least}")
        raise OptionError(f"{name} must be {rule}, got {count}")
    if largest is not None and count > largest:
        raise OptionError(f"{name} must be at most {largest}, got {count}")
    return min(count, _LARGEST) if largest is None else count


def as_flag(name: str, value: Any) -> bool:
    """True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise OptionTypeError(f"{name} must be True or False, got {_shown(value)}")
    return bool(value)


def as_text(name: str, value: Any) -> str:
    """A string."""
    if not isinstance(value, str):
        raise OptionTypeError(f"{name} must be a string, got {_shown(value)}")
    return value


def as_indices(name: str, value: Any) -> tuple[int, ...]:
    """An index set; one index may stand alone. Its range is checked by the core."""
    if isinstance(value, (str, bytes)) or np.ndim(value) > 1:
        raise OptionTypeError(f"{name} must hold indices, got {_shown(value)}")
    entries = list(value) if isinstance(value, Iterable) else [value]
    indices = tuple(as_count(f"{name}[{k}]", i, least=-_LARGEST) for k, i in enumerate(entries))
    for i in indices:
        if i == _LARGEST:
            raise IndexSetError(f"{name} must hold indices of A, got one beyond 2^63")
    return indices


def as_seconds(name: str, value: Any) -> float | None:
    """A time limit, None for none: infinity is none, and so is one longer than a life."""
    if value is None:
        return None
    seconds = as_number(name, value)
    if not seconds >= 0:
        raise OptionError(f"{name} must be nonnegative, got {seconds:g}")
    return seconds if seconds < _FOREVER else None


def _shown(value: Any) -> str:
    text = repr(value)
    return f"{text if len(text) <= 40 else text[:37] + '...'} of type {type(value).__name__}"


def as_matrix(name: str, value: ArrayLike) -> Matrix:
    """`value` as an (n, n) float64 array; not copied when it is one already. Finiteness is checked by the core."""
    array = _as_float64(name, value)
    if array.ndim != 2 or array.shape[0] != array.shape[1]:
        if array.size == 0 and array.ndim == 1:  # [] is the matrix of order 0
            return np.zeros((0, 0))
        raise ShapeError(f"{name} must be a square matrix, got shape {array.shape}")
    return array


def as_vector(name: str, value: ArrayLike) -> Vector:
    """`value` as an (n,) float64 array; not copied when it is one already."""
    array = _as_float64(name, value)
    if array.ndim != 1:
        raise ShapeError(f"{name} must be a vector, got shape {array.shape}")
    return array


def as_real(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """`value` as a float64 array of any shape; not copied when it is one already."""
    return _as_float64(name, value)


def _as_float64(name: str, value: ArrayLike) -> NDArray[np.float64]:
    if type(value) is np.ndarray and value.dtype is _FLOAT64:
        return value
    if hasattr(value, "toarray"):
        raise DTypeError(f"{name} must be a dense array, got {type(value).__name__}; pass {name}.toarray()")
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        index = tuple(int(i) for i in np.argwhere(np.ma.getmaskarray(value))[0])
        raise DTypeError(f"{name} must have no masked entries, got {_entry(name, index)} masked")
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ShapeError(f"{name} is ragged: {error}") from error
    if array.dtype.kind not in "fiubO" or (array.dtype.kind == "O" and not _holds_numbers(array)):
        raise DTypeError(_not_real(name, value, array))
    try:
        with np.errstate(
            over="ignore"
        ):  # a long double beyond the range of doubles becomes inf, which the core reports
            converted = np.ascontiguousarray(array, dtype=np.float64).reshape(array.shape)
    except OverflowError:  # an int
        raise NotFiniteError(f"{name} must hold doubles, got an integer beyond their range") from None
    if array.dtype.kind != "f" or not isinstance(value, np.ndarray):
        check_integers(name, value, converted)
    return converted


def _holds_numbers(array: NDArray[Any]) -> bool:
    return all(isinstance(x, (int, float)) for x in array.flat)


def check_integers(name: str, given: Any, converted: NDArray[np.float64]) -> None:
    """Integers above 2^53 may not be doubles: better said than silently changed."""
    large = np.argwhere(np.abs(converted) >= 2.0**53)
    if not len(large):
        return
    exact = np.asarray(given, dtype=None if isinstance(given, np.ndarray) else object)
    for position in large:
        index = tuple(int(i) for i in position)
        x = exact[index]
        if isinstance(x, (int, np.integer)) and int(x) != int(converted[index]):
            raise DTypeError(f"{name} must hold doubles, got {_entry(name, index)} = {int(x)}, which is none")


def check_finite(name: str, array: NDArray[np.float64]) -> None:
    """For what the core does not look at."""
    finite = np.isfinite(array)
    if not finite.all():
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise NotFiniteError(f"{name} must be finite, got {_entry(name, index)} = {array[index]}")


def _not_real(name: str, value: Any, array: NDArray[Any]) -> str:
    entries = array if isinstance(value, np.ndarray) else np.asarray(value, dtype=object)
    strange = (i for i in np.ndindex(entries.shape) if not isinstance(entries[i], (int, float, np.number, np.bool_)))
    imaginary = (i for i in np.ndindex(array.shape) if array.dtype.kind == "c" and array[i].imag)
    index = next(strange, None) or next(imaginary, None)
    found = "" if index is None else f": {_entry(name, index)} = {entries[index]!r}"
    return f"{name} must hold real numbers, got dtype {array.dtype}{found}"


def _entry(name: str, index: tuple[int, ...]) -> str:
    return f"{name}[{', '.join(map(str, index))}]" if index else name
