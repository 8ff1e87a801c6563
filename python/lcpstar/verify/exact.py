"""Sums of products without a rounding error that could hide anything.

Each is the exact value rounded once. Doubles of ordinary size: a product is split into two doubles whose sum it is
[Dek71], and `math.fsum` adds all parts exactly. Other numbers: Python integers over a common denominator.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..coerce import Vector

Numbers: TypeAlias = Vector | list[Fraction]
Integers: TypeAlias = NDArray[np.int64]

# Products and sums of doubles between these stay in the range of normal numbers, with the second half of each product.
_SMALL, _LARGE = 2.0**-450, 2.0**450
_SPLIT = 2.0**27 + 1.0
_ENTRIES_AT_ONCE = 1 << 18


def to_double(x: Fraction) -> float:
    """The nearest double; infinite beyond their range."""
    try:
        return float(x)
    except OverflowError:
        return math.inf if x > 0 else -math.inf


def as_doubles(x: Numbers) -> Vector:
    """Each number rounded to a double."""
    return x if isinstance(x, np.ndarray) else np.array([to_double(v) for v in x], dtype=np.float64)


def simplest(x: Numbers) -> Numbers:
    """Doubles where every number is one."""
    doubles = as_doubles(x)
    return doubles if np.isfinite(doubles).all() and doubles.tolist() == list(x) else x


@dataclass(frozen=True)
class Rationals:
    """A vector of rational numbers as integers over one denominator."""

    numerators: Sequence[int]
    denominator: int

    @classmethod
    def of(cls, x: Numbers) -> Rationals:
        """Doubles are the binary rationals that they store."""
        ratios = [v.as_integer_ratio() for v in (x.tolist() if isinstance(x, np.ndarray) else x)]
        denominator = math.lcm(*{d for _, d in ratios})
        return cls([p * (denominator // d) for p, d in ratios], denominator)

    def sizes(self) -> Rationals:
        """Without their signs."""
        return Rationals([abs(p) for p in self.numerators], self.denominator)

    def dot(self, other: Rationals) -> Fraction:
        """The sum of the products."""
        total = sum(a * b for a, b in zip(self.numerators, other.numerators, strict=True))
        return Fraction(total, self.denominator * other.denominator)


@dataclass(frozen=True)
class Sums:
    """`value 2^exponent` is each sum rounded once, with its exact sign; `size` is that of the terms' magnitudes."""

    value: Vector
    size: Vector
    exponent: Integers

    def doubles(self, shift: Integers | int = 0) -> Vector:
        """The sums times `2^shift`."""
        return times_powers_of_two(self.value, self.exponent + shift)


def times_powers_of_two(x: Vector, exponents: Integers | int) -> Vector:
    """`x 2^e`, rounded once where it leaves the range of doubles."""
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(np.ldexp(x, np.clip(exponents, -10_000, 10_000)))


@dataclass(frozen=True)
class Matrix:
    """The entries of a square matrix that are not zero, by rows: `values[k]` in `columns[k]`, rows from `starts[i]`."""

    n: int
    starts: Integers
    columns: Integers
    values: Numbers

    @cached_property
    def rows(self) -> Integers:
        """The row of each entry."""
        return np.repeat(np.arange(self.n), self.counts)

    @property
    def counts(self) -> Integers:
        """How many entries each row has."""
        return np.diff(self.starts)

    @cached_property
    def transposed(self) -> Matrix:
        """The transpose, by rows."""
        order = np.argsort(self.columns, kind="stable")
        starts = np.searchsorted(self.columns[order], np.arange(self.n + 1))
        values = self.values
        moved = values[order] if isinstance(values, np.ndarray) else [values[k] for k in order.tolist()]
        return Matrix(self.n, starts, self.rows[order], moved)

    def row(self, i: int) -> tuple[list[int], Numbers]:
        """Columns and values of row i."""
        entries = slice(self.starts[i], self.starts[i + 1])
        return self.columns[entries].tolist(), self.values[entries]

    def times(self, x: Numbers, start: Numbers | None = None) -> Sums:
        """`start + A x`; `start` is 0 unless given."""
        start = np.zeros(self.n) if start is None else start
        sums = Sums(np.zeros(self.n), np.zeros(self.n), np.zeros(self.n, dtype=np.int64))
        exactly = list(range(self.n))
        if isinstance(x, np.ndarray) and isinstance(start, np.ndarray) and isinstance(self.values, np.ndarray):
            exactly = self._add_doubles(self.values, x, start, sums)
        if exactly:
            self._add_integers(exactly, Rationals.of(x), start, sums)
        return sums

    def _add_doubles(self, values: Vector, x: Vector, start: Vector, sums: Sums) -> list[int]:
        """Fills in the rows whose numbers are of ordinary size, and returns the others."""
        ordinary = np.abs(start) < _LARGE
        used = x[self.columns] != 0.0
        extreme = used & ~(_is_ordinary(values) & _is_ordinary(x)[self.columns])
        ordinary[self.rows[extreme]] = False
        first = 0
        while first < self.n:
            last = int(np.searchsorted(self.starts, self.starts[first] + _ENTRIES_AT_ONCE, side="right")) - 1
            last = min(max(last, first + 1), self.n)
            entries = np.arange(self.starts[first], self.starts[last])
            entries = entries[used[entries] & ordinary[self.rows[entries]]]
            product, rest = _two_products(values[entries], x[self.columns[entries]])
            rows = self.rows[entries] - first
            ends = (2 * np.searchsorted(rows, np.arange(last - first + 1))).tolist()
            terms = np.column_stack((product, rest)).ravel().tolist()
            wanted = zip(ends, ends[1:], start[first:last].tolist(), strict=False)
            good = np.flatnonzero(ordinary[first:last])
            block = np.array([math.fsum([*terms[a:b], c]) if abs(c) < _LARGE else 0.0 for a, b, c in wanted])
            size = np.bincount(rows, np.abs(product), last - first) + np.abs(start[first:last])
            sums.value[first + good], sums.size[first + good] = block[good], size[good]
            first = last
        return [int(i) for i in np.flatnonzero(~ordinary)]

    def _add_integers(self, rows: list[int], x: Rationals, start: Numbers, sums: Sums) -> None:
        for i in rows:
            total, size = self._exact(i, x, start[i])
            e = size.numerator.bit_length() - size.denominator.bit_length() if size else 0
            scale = Fraction(2) ** -e
            value = to_double(total * scale)
            least = math.ulp(0.0) if total > 0 else -math.ulp(0.0)
            sums.value[i] = value if value or not total else least
            sums.size[i], sums.exponent[i] = to_double(size * scale), e

    def _exact(self, i: int, x: Rationals, start: Any) -> tuple[Fraction, Fraction]:
        columns, values = self.row(i)
        row = Rationals.of(values)
        used = Rationals([x.numerators[j] for j in columns], x.denominator)
        start = Fraction(*start.as_integer_ratio())
        return row.dot(used) + start, row.sizes().dot(used.sizes()) + abs(start)

    def entry_of_product(self, i: int, x: Rationals) -> Fraction:
        """`(A x)_i` as a rational number."""
        return self._exact(i, x, 0)[0]


def _is_ordinary(x: Vector) -> NDArray[np.bool_]:
    size = np.abs(x)
    return np.asarray((size == 0.0) | ((size > _SMALL) & (size < _LARGE)))


def _two_products(a: Vector, b: Vector) -> tuple[Vector, Vector]:
    """`p + r = a b` without an error. [Dek71]"""

    def halves(x: Vector) -> tuple[Vector, Vector]:
        c = _SPLIT * x
        high = c - (c - x)
        return high, x - high

    p = a * b
    (a_high, a_low), (b_high, b_low) = halves(a), halves(b)
    return p, a_low * b_low - (((p - a_high * b_high) - a_low * b_high) - a_high * b_low)
