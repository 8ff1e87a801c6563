"""Polyhedral friction: the matrix of Stewart and Trinkle from the matrix of normals and tangents. [ST96], [AP97]."""

from __future__ import annotations

import numpy as np

from ..coerce import Matrix, Vector
from ..errors import OptionError
from .contact import Indices


def facet_directions(facets: int, planar: bool) -> Matrix:
    """Directions (f, T) in the tangent basis: `+-1` in the plane (T = 1), else `facets` unit vectors (T = 2)."""
    if planar:
        return np.array([[1.0], [-1.0]])
    if facets < 3:
        raise OptionError(f"facets must be at least 3 in space, got {facets}")
    angles = 2 * np.pi * np.arange(facets) / facets
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def on_facets(B: Matrix, contacts: int, directions: Matrix) -> Matrix:
    """The matrix over (normals, facets) from `B` over (normals, tangents); the first `contacts` rows are normals."""
    f, T = directions.shape
    rubbing = (len(B) - contacts) // T
    n = contacts + rubbing * f
    half = np.empty((n, len(B)))
    half[:contacts] = B[:contacts]
    half[contacts:] = _combine(B[contacts:].reshape(rubbing, T, len(B)), directions)
    full = np.empty((n, n))
    full[:, :contacts] = half[:, :contacts]
    tangents = np.ascontiguousarray(half[:, contacts:].T).reshape(rubbing, T, n)
    full[:, contacts:] = _combine(tangents, directions).T
    return full


def _combine(tangents: Matrix, directions: Matrix) -> Matrix:
    """`directions` times the tangents of each contact: (r, T, n) becomes (r f, n)."""
    out = directions[:, 0, None] * tangents[:, 0, None, :]
    for k in range(1, directions.shape[1]):
        out = out + directions[:, k, None] * tangents[:, k, None, :]
    return np.asarray(out.reshape(-1, tangents.shape[2]))


def with_sliding_speeds(B: Matrix, contacts: int, rubbing: Indices, friction: Vector, facets: int) -> Matrix:
    """`[[N'N, N'D, 0], [D'N, D'D, E], [mu, -E', 0]]` from its upper left part `B`: copositive. [ST96].

    Contact `rubbing[k]` of the `contacts` has the coefficient `friction[k]` and facets `contacts + k facets, ...`. The
    last variables are the sliding speeds.
    """
    k, m = len(B), len(rubbing)
    A = np.zeros((k + m, k + m))
    A[:k, :k] = B
    speeds = k + np.arange(m)
    facet = contacts + np.arange(m * facets).reshape(m, facets)
    A[facet, speeds[:, None]] = 1.0
    A[speeds[:, None], facet] = -1.0
    A[speeds, rubbing] = friction
    return A
