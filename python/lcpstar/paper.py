"""The paper's numbers, recomputed: Table 1 and the solutions of its example.

Jana, Das, Sinha, "On Semimonotone Star Matrices and Linear Complementarity Problem", section 7.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from .coerce import Vector
from .interior import Record, potential_reduction
from .solve import solve

#: The example of section 7 and the start of Table 1.
EXAMPLE_A = ((0, 1, 1), (2, 0, 2), (-2, -5, 0))
EXAMPLE_Q = (-4, -7, 10)
EXAMPLE_Z0 = (1, 1, 5)


@dataclass(frozen=True)
class PrintedRow:
    """A row of Table 1 as the paper prints it, digits included."""

    k: int
    z: tuple[str, str, str]
    w: tuple[str, str, str]
    dz: tuple[str, str, str]
    dw: tuple[str, str, str]
    psi: str


PRINTED = (
    PrintedRow(
        1,
        ("1.05", "1.09", "4.76"),
        ("1.85", "4.62", "2.42"),
        ("0.106", "0.189", "-0.487"),
        ("-0.298", "-0.761", "-1.155"),
        "29.3308",
    ),
    PrintedRow(
        2,
        ("1.1", "1.17", "4.53"),
        ("1.7", "4.25", "1.94"),
        ("0.0853", "0.1607", "-0.4551"),
        ("-0.294", "-0.74", "-0.974"),
        "23.2919",
    ),
    PrintedRow(
        50,
        ("1.07", "1.57", "2.43"),
        ("0.00608", "0.00389", "0.00281"),
        ("0.00047", "-0.00017", "-0.00154"),
        ("-0.00171", "-0.00215", "-0.00009"),
        "2.4617",
    ),
    PrintedRow(
        96,
        ("1.07", "1.57", "2.43"),
        ("0.00001", "0.000000", "0.00000"),
        ("-0.000001", "-0.00000", "-0.000003"),
        ("-0.00000", "-0.00000", "-0.00000"),
        "1.1684",
    ),
    PrintedRow(
        97,
        ("1.07", "1.57", "2.43"),
        ("0.00001", "0.000009", "0.000005"),
        ("0.000002", "0.000000", "-0.000000"),
        ("-0.000000", "-0.000000", "-0.000000"),
        "1.1684",
    ),
    PrintedRow(
        100,
        ("1.07", "1.57", "2.43"),
        ("0.00000", "0.00000", "0.00000"),
        ("0.000000", "-0.000000", "-0.000000"),
        ("-0.000000", "-0.000000", "0.00000"),
        "1.0565",
    ),
)


@dataclass(frozen=True)
class ComparedRow:
    """A printed row beside the recomputed one."""

    printed: PrintedRow
    record: Record

    def differences(self) -> list[str]:
        """Entries that do not round to what is printed, as "name[i]: printed / recomputed"."""
        found = []
        for name in ("z", "w", "dz", "dw"):
            values: Vector = getattr(self.record, name)
            for i, (text, value) in enumerate(zip(getattr(self.printed, name), values, strict=True)):
                if not _rounds_to(value, text):
                    found.append(f"{name}[{i}]: {text} / {value:.7f}")
        if not _rounds_to(self.record.psi, self.printed.psi):
            found.append(f"psi: {self.printed.psi} / {self.record.psi:.4f}")
        return found


def _rounds_to(value: float, text: str) -> bool:
    """Whether `value` rounds to `text` at the digits of `text`."""
    digits = len(text.partition(".")[2])
    return abs(value - float(text)) <= 0.5000001 * 10.0**-digits


def table_1() -> list[ComparedRow]:
    """Table 1, recomputed with `kappa = 1.01 max(n, z'w / min z_i w_i)` and steps of at most half the direction."""
    run = potential_reduction(EXAMPLE_A, EXAMPLE_Q, z0=EXAMPLE_Z0, trace=True)
    rows = {record.k: record for record in run.trace}
    return [ComparedRow(printed, rows[printed.k]) for printed in PRINTED]


def example_solutions() -> Iterator[tuple[str, Vector]]:
    """The three solutions of the example, each with where it comes from, each verified."""
    for source, guess in (
        ("the paper's (15/14, 11/7, 17/7)", (15 / 14, 11 / 7, 17 / 7)),
        ("(0, 2, 7/2), not in the paper", (0, 2, 7 / 2)),
        ("(5, 0, 4), not in the paper", (5, 0, 4)),
    ):
        solution = solve(EXAMPLE_A, EXAMPLE_Q, z0=guess)
        if not solution.success:
            raise ArithmeticError(f"{source} does not solve the paper's example: {solution.message}")
        yield source, solution.z


def _vector(values: Vector) -> str:
    return "(" + ", ".join(f"{x:9.6f}" for x in values) + ")"


def main() -> int:
    """Print Table 1 beside the printed numbers, and the example's solutions."""
    print("Example of section 7: A = [[0, 1, 1], [2, 0, 2], [-2, -5, 0]], q = (-4, -7, 10), z0 = (1, 1, 5)\n")
    print("Table 1. Row k: z^k, w^k, the direction d^(k-1) that led there, psi at the previous point.")
    for row in table_1():
        printed, record = row.printed, row.record
        print(f"\n  k = {printed.k}")
        for name in ("z", "w", "dz", "dw"):
            texts = "(" + ", ".join(f"{text:>9}" for text in getattr(printed, name)) + ")"
            print(f"    {name:<3} printed {texts}   recomputed {_vector(getattr(record, name))}")
        print(f"    psi printed {printed.psi:>9}   recomputed {record.psi:.4f}")
        if differences := row.differences():
            print(f"    differs (printed / recomputed) in {', '.join(differences)}")
    run = potential_reduction(EXAMPLE_A, EXAMPLE_Q, z0=EXAMPLE_Z0, trace=True)
    at_100 = float(run.trace[99].z @ run.trace[99].w)
    print("\n  Row 97 repeats row 96's psi, a misprint. Row 100 has z'w = "
          f"{at_100:.1e} > 1e-5: the paper's stopping rule holds at k = {run.iterations}.")  # fmt: skip
    print("\nThe example has three solutions:")
    for source, z in example_solutions():
        print(f"    z = {_vector(z)}   {source}")
    return 0
