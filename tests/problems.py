"""Textbook problems as data: source, all known solutions, errata. Every row runs against every method that applies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


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


def murty(n):
    """Murty (1978): a P-matrix on which least-index rules and Lemke's method with d = e need 2^n - 1 pivots."""
    A = np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)
    q = -np.array([sum(2.0 ** (n - k) for k in range(i)) for i in range(1, n + 1)])
    return A, q


def fathi(n):
    """Fathi (1979): symmetric positive definite, M M' with Murty's M; exponential for Lemke's method."""
    M, q = murty(n)
    return M @ M.T, q


def random_pd(n, seed):
    """Unsymmetric, A + A' positive definite."""
    rng = np.random.default_rng(seed)
    B, S = rng.standard_normal((n, n)), rng.standard_normal((n, n))
    return B @ B.T / n + 0.1 * np.eye(n) + (S - S.T) / np.sqrt(n), rng.standard_normal(n)


def psd_half_rank(n, seed):
    """Symmetric PSD of rank n/2, q from a complementary pair."""
    rng = np.random.default_rng(seed)
    B = rng.standard_normal((n, max(1, n // 2)))
    A = B @ B.T / n
    z = np.maximum(rng.standard_normal(n), 0.0)
    w = np.where(z > 0, 0.0, rng.random(n))
    return A, w - A @ z


def box_stack(boxes, mass_ratio=1.0, step=0.01):
    """Frictionless stack of unit boxes, four contacts per interface: singular PSD, every pivot ties.

    A = J M^-1 J' over the contact normals, q = J v with v the free velocity after one step of gravity.
    """
    corners = 0.5 * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]])
    J = np.zeros((4 * boxes, 6 * boxes))
    up = np.array([0.0, 0.0, 1.0])
    for k in range(boxes):
        for c, (x, y) in enumerate(corners):
            J[4 * k + c, 6 * k : 6 * k + 6] = np.concatenate([up, np.cross([x, y, -0.5], up)])
            if k > 0:
                J[4 * k + c, 6 * k - 6 : 6 * k] = -np.concatenate([up, np.cross([x, y, 0.5], up)])
    mass = mass_ratio ** (np.arange(boxes) / max(1, boxes - 1))
    inverse_mass = np.concatenate([[1 / m] * 3 + [6 / m] * 3 for m in mass])
    v = np.zeros(6 * boxes)
    v[2::6] = -9.81 * step
    A = (J * inverse_mass) @ J.T
    return (A + A.T) / 2, J @ v
