"""Exceptions: a broken promise of the caller. An LCP that cannot be solved is a status, never an exception.

Every class inherits `LCPError` and the builtin that fits, so both `except LCPError` and `except ValueError` work.
The compiled core raises these by name.
"""

from __future__ import annotations


class LCPError(Exception):
    """Base of every exception that lcpstar raises on purpose."""


class ShapeError(LCPError, ValueError):
    """An array has the wrong number of dimensions or the wrong length, or a list is ragged."""


class DTypeError(LCPError, TypeError):
    """An array holds something that is not a real number (complex, object, text)."""


class NotFiniteError(LCPError, ValueError):
    """An entry is NaN or infinite."""


class OptionError(LCPError, ValueError):
    """An option is outside its range, e.g. a covering vector `d` that is not strictly positive."""


class UnknownNameError(OptionError):
    """A method, class symbol or other named choice is unknown."""


class OptionTypeError(LCPError, TypeError):
    """An option has the wrong type, e.g. the options class of another method."""


class IndexSetError(LCPError, IndexError, ValueError):
    """An index set holds an index that is out of range or repeated."""


class SingularBlockError(LCPError, ArithmeticError, ValueError):
    """`A[alpha, alpha]` is singular, so the principal pivot transform on `alpha` does not exist."""


class StartError(LCPError, ValueError):
    """A starting point does not satisfy what the method needs."""


class MissingPackageError(LCPError, ImportError):
    """An optional package is not installed; the message holds the command that installs it."""


class TooLargeError(LCPError, ValueError):
    """The matrix is larger than an exponential method takes."""


class TimeLimitError(LCPError, TimeoutError):
    """A computation that has no meaningful partial answer ran out of its `time_limit`."""


class FileFormatError(LCPError, ValueError):
    """A problem file is malformed, incomplete or too large."""


class InternalError(LCPError, RuntimeError):
    """A bug in lcpstar: please report it."""
