"""Textbook problems as data: source, all known solutions, errata. Every row runs against every method that applies."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Case:
    """One LCP with its source; `solutions` lists all of them when known, `None` when infeasible."""

    name: str
    source: str
    A: list
    q: list
    solutions: list | None
    solvable: bool = True


CASES = [
    Case(
        "paper_section_7",
        "Jana, Das, Sinha, last example; the paper prints only the third solution",
        [[0, 1, 1], [2, 0, 2], [-2, -5, 0]],
        [-4, -7, 10],
        [(0, 2, 3.5), (5, 0, 4), (15 / 14, 11 / 7, 17 / 7)],
    ),
    Case("order_one_positive", "by hand", [[2]], [-1], [(0.5,)]),
    Case("order_one_trivial", "by hand", [[2]], [1], [(0,)]),
    Case("order_one_negative", "by hand: z = 0 and z = 1 solve it", [[-1]], [1], [(0,), (1,)]),
    Case("order_one_none", "by hand: w = -z - 1 < 0", [[-1]], [-1], None, solvable=False),
    Case("order_one_zero", "by hand: w = -1", [[0]], [-1], None, solvable=False),
    Case("p_matrix_2", "by hand", [[2, 1], [1, 2]], [-5, -6], [(4 / 3, 7 / 3)]),
    Case("singular_tie", "by hand: both rows say z1 + z2 >= 1", [[1, 1], [1, 1]], [-1, -1], [(1, 0), (0, 1)]),
    Case("infeasible_psd", "by hand: y = (1, 1)", [[1, -1], [-1, 1]], [-1, -1], None, solvable=False),
    Case("swap", "bimatrix 1x1: z = (1, 1)", [[0, 1], [1, 0]], [-1, -1], [(1, 1)]),
    Case(
        "f1_bordered",
        "counterexample to a theorem of the paper's section 5: two isolated solutions",
        [[1, 3, 1], [0, 1, 1], [-1, -1, 0]],
        [-4, -2, 1],
        [(1, 0, 3), (0, 1, 1)],
    ),
    Case("f2_interior_stalls", "the paper's interior point method stalls here", [[1, 2], [2, 1]], [-7, -3], [(7, 0)]),
    Case("zero_matrix", "A = 0, q = 0: every z >= 0", [[0, 0], [0, 0]], [0, 0], []),
]
