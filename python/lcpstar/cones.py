"""Pictures of LCPs of order 2, for teaching: complementary cones in the plane of q, the solutions in the plane of z.

LCP(q, A) has a solution with `z_i = 0` outside alpha exactly when q lies in the cone of `-A_i` for i in alpha and
the unit vectors `e_i` for the others: the complementary cone of alpha. The four cones cover the plane when A is in Q,
without overlap when A is a P-matrix. [CPS92] sec. 1.3. Needs matplotlib.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .coerce import Matrix, Vector, as_matrix, as_vector
from .errors import ShapeError
from .plots import new_figure
from .solutions import solutions

_COLOURS = {(): "#56B4E9", (0,): "#E69F00", (1,): "#009E73", (0, 1): "#CC79A7"}
_STRAIGHT = 1e-12


def picture(A: ArrayLike, q: ArrayLike) -> Any:
    """A figure of LCP(q, A) of order 2: its complementary cones with q, and its feasible set with all its solutions.

    Parameters
    ----------
    A : (2, 2) array_like
    q : (2,) array_like

    Raises
    ------
    ShapeError
        The order is not 2.
    MissingPackageError
        matplotlib is not installed.
    """
    matrix, vector = as_matrix("A", A), as_vector("q", q)
    if matrix.shape != (2, 2) or vector.shape != (2,):
        raise ShapeError(f"A picture needs A of shape (2, 2) and q of length 2, got {matrix.shape} and {vector.shape}")
    figure = new_figure(9.2, 5.0)
    left, right = figure.subplots(1, 2)
    covering = draw_cones(left, matrix, vector)
    count = draw_solutions(right, matrix, vector)
    left.set_title(f"q lies in {len(covering)} of 4 complementary cones", fontsize=10)
    right.set_title(f"{count} face{'s' * (count != 1)} of solutions in FEA(q, A)", fontsize=10)
    return figure


def generators(A: Matrix, alpha: tuple[int, ...]) -> Matrix:
    """The columns that span the complementary cone of alpha: `-A_i` for i in alpha, `e_i` otherwise."""
    G = np.eye(len(A))
    for i in alpha:
        G[:, i] = -A[:, i]
    return G


def draw_cones(axis: Any, A: Matrix, q: Vector) -> list[tuple[int, ...]]:
    """Draws the four cones and q; returns the index sets of those that contain q, boundaries included."""
    radius = 1.6 * (float(np.abs(q).max()) or 1.0)
    containing = []
    for alpha, colour in _COLOURS.items():
        G = generators(A, alpha)
        lengths = np.linalg.norm(G, axis=0)
        G = G / np.where(lengths > 0, lengths, 1.0)
        determinant = G[0, 0] * G[1, 1] - G[0, 1] * G[1, 0]
        label = "alpha = {" + ", ".join(map(str, alpha)) + "}"
        for g in G.T:
            axis.plot([0, radius * g[0]], [0, radius * g[1]], color=colour, lw=1.5)
        if abs(determinant) > _STRAIGHT:
            start = float(np.arctan2(G[1, 0], G[0, 0]))
            turn = float(np.arctan2(determinant, G[:, 0] @ G[:, 1]))
            angles = start + np.linspace(0.0, turn, 40)
            xs, ys = np.append(0.0, radius * np.cos(angles)), np.append(0.0, radius * np.sin(angles))
            axis.fill(xs, ys, color=colour, alpha=0.3, lw=0, label=label)
            middle = start + turn / 2
            axis.text(0.75 * radius * np.cos(middle), 0.75 * radius * np.sin(middle), label, ha="center", fontsize=8)
        if in_cone(G, q):
            containing.append(alpha)
    axis.plot(*q, "k*", ms=11)
    axis.annotate("q", q, xytext=(6, 6), textcoords="offset points", fontsize=10)
    axis.set(xlabel="q[0]", ylabel="q[1]", aspect="equal", xlim=(-radius, radius), ylim=(-radius, radius))
    return containing


def in_cone(G: Matrix, q: Vector) -> bool:
    """Whether q is a nonnegative combination of the two columns of G, to rounding.

    >>> in_cone(np.eye(2), np.array([1.0, 0.0])), in_cone(-np.eye(2), np.array([1.0, 1.0]))
    (True, False)
    """
    tolerance = 1e-12 * float(np.abs(q).max())
    if abs(np.linalg.det(G)) > _STRAIGHT:
        return bool((np.linalg.solve(G, q) >= -tolerance).all())
    along = [float(g @ q) for g in G.T]
    off = [float(np.abs(q - a * g).max()) for a, g in zip(along, G.T, strict=True)]
    return any(a >= -tolerance and o <= tolerance for a, o in zip(along, off, strict=True))


def draw_solutions(axis: Any, A: Matrix, q: Vector) -> int:
    """Draws `w >= 0, z >= 0`, the lines `w_i = 0` and all solutions; returns the number of faces."""
    faces = list(solutions(A, q))
    points = [np.asarray(vertex, float) for face in faces for vertex in face.vertices]
    crossings = [abs(q[i] / A[i, j]) for i in range(2) for j in range(2) if A[i, j] != 0]
    top = 1.4 * (max([0.0, *crossings, *(float(p.max()) for p in points)]) or 1.0)
    grid = np.linspace(0.0, top, 300)
    Z0, Z1 = np.meshgrid(grid, grid)
    feasible = np.ones_like(Z0, dtype=bool)
    for i, dash in ((0, "--"), (1, ":")):
        W = A[i, 0] * Z0 + A[i, 1] * Z1 + q[i]
        feasible &= W >= 0
        if A[i].any():
            axis.contour(Z0, Z1, W, levels=[0.0], colors="#0072B2", linestyles=dash, linewidths=1.3)
            axis.plot([], [], dash, color="#0072B2", label=f"w[{i}] = 0")
    axis.contourf(Z0, Z1, feasible.astype(float), levels=[0.5, 1.5], colors=["#56B4E9"], alpha=0.25)
    for face in faces:
        vertices = [np.asarray(vertex, float) for vertex in face.vertices]
        for ray in face.rays:
            direction = np.asarray(ray, float)
            base = vertices[0] if vertices else np.zeros(2)
            end = base + 3 * top * direction / np.abs(direction).max()
            axis.plot([base[0], end[0]], [base[1], end[1]], color="#D55E00", lw=3)
        if len(vertices) > 1:
            axis.plot(*np.transpose(vertices), color="#D55E00", lw=3)
    for p in points:
        axis.plot(*p, "o", color="#D55E00", ms=7, clip_on=False)
        axis.annotate(f"({p[0]:.4g}, {p[1]:.4g})", p, xytext=(7, 7), textcoords="offset points", fontsize=8)
    axis.set(xlabel="z[0]", ylabel="z[1]", aspect="equal", xlim=(0, top), ylim=(0, top))
    if A.any():
        axis.legend(fontsize=8, loc="upper right")
    return len(faces)
