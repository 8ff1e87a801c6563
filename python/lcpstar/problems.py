"""Problem families for tests, benchmarks and teaching: each returns `(A, q)`, reproducible by its seed.

Import it by name: `from lcpstar import problems`. Contact problems of bodies that stand, swing or fall: `scenes.lcp`.
"""

from __future__ import annotations

import numpy as np

from .coerce import Matrix, Vector
from .scenes.friction import with_sliding_speeds

Problem = tuple[Matrix, Vector]


def murty(n: int) -> Problem:
    """Murty's P-matrix, on which Lemke's method with d = e needs 2^n - 1 pivots. [Mur78]."""
    A = np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)
    q = -np.array([sum(2.0 ** (n - k) for k in range(i)) for i in range(1, n + 1)])
    return A, q


def fathi(n: int) -> Problem:
    """Symmetric positive definite, M M' with Murty's M: exponential for Lemke's method, too. [Fat79]."""
    M, q = murty(n)
    return M @ M.T, q


def morris(n: int) -> Problem:
    """Morris's P-matrix for odd n: ones, and twos after them in a ring; random pivoting is exponential. [Mor02]."""
    return np.eye(n) + 2.0 * np.roll(np.eye(n), 1, axis=1), -np.ones(n)


def csizmadia(n: int) -> Problem:
    """Csizmadia's matrix, ones above minus ones: a P-matrix and Z, but with a handicap exponential in n. [KN11]."""
    return np.eye(n) - np.tril(np.ones((n, n)), -1), -np.ones(n)


def random_pd(n: int, seed: int = 0) -> Problem:
    """Unsymmetric, `A + A'` positive definite: a P-matrix, one solution for every q."""
    rng = np.random.default_rng(seed)
    B, S = rng.standard_normal((n, n)), rng.standard_normal((n, n))
    return B @ B.T / n + 0.1 * np.eye(n) + (S - S.T) / np.sqrt(n), rng.standard_normal(n)


def random_spd(n: int, seed: int = 0) -> Problem:
    """Symmetric positive definite."""
    rng = np.random.default_rng(seed)
    B = rng.standard_normal((n, n))
    return B @ B.T / n + 0.1 * np.eye(n), rng.standard_normal(n)


def psd_half_rank(n: int, seed: int = 0, skew: float = 0.0) -> Problem:
    """PSD of rank n/2, plus `skew` times a skew-symmetric matrix; q from a complementary pair, so it is solvable."""
    rng = np.random.default_rng(seed)
    B = rng.standard_normal((n, max(1, n // 2)))
    A = B @ B.T / n
    if skew:
        S = rng.standard_normal((n, n))
        A = A + skew * (S - S.T) / np.sqrt(n)
    z = np.maximum(rng.standard_normal(n), 0.0)
    w = np.where(z > 0, 0.0, rng.random(n))
    return A, w - A @ z


def degenerate(n: int, seed: int = 0) -> Problem:
    """Integer PSD with repeated rows, many zeros in the solution and in the slacks: ties everywhere."""
    rng = np.random.default_rng(seed)
    half = rng.integers(-2, 3, ((n + 1) // 2, max(1, n // 3))).astype(float)
    B = np.vstack([half, half])[:n]
    A = B @ B.T
    z = (rng.random(n) < 0.3).astype(float)
    w = np.where((z == 0) & (rng.random(n) < 0.3), 1.0, 0.0)
    return A, w - A @ z


def badly_scaled(n: int, seed: int = 0, decades: float = 8.0) -> Problem:
    """`random_pd` with rows and columns multiplied by `10^U(-decades, decades)`."""
    A, q = random_pd(n, seed)
    rng = np.random.default_rng([seed, 1])
    rows, columns = 10.0 ** rng.uniform(-decades, decades, n), 10.0 ** rng.uniform(-decades, decades, n)
    return rows[:, None] * A * columns, rows * q


def bimatrix(m: int, seed: int = 0) -> Problem:
    """An m x m game with costs in (0.1, 1.1): `A = [[0, C], [D, 0]]`, `q = -e`."""
    rng = np.random.default_rng(seed)
    A = np.zeros((2 * m, 2 * m))
    A[:m, m:] = rng.random((m, m)) + 0.1
    A[m:, :m] = rng.random((m, m)) + 0.1
    return A, -np.ones(2 * m)


def box_stack(boxes: int, mass_ratio: float = 1.0, step: float = 0.01, seed: int | None = None) -> Problem:
    """Frictionless stack of unit boxes, four contacts per interface: singular PSD of order `4 boxes`, every pivot ties.

    `A = J M^-1 J'` over the contact normals, `q = J v` with v the free velocity after `step` seconds of gravity, plus
    noise of 1e-3 m/s when a seed is given. Masses grow geometrically upwards from 1 to `mass_ratio` (heavy on light).
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
    v = np.zeros(6 * boxes)
    v[2::6] = -9.81 * step
    if seed is not None:
        v += 1e-3 * np.random.default_rng(seed).standard_normal(6 * boxes)
    return _delassus(J, np.repeat(np.outer(1 / mass, [1.0, 6.0]).ravel(), 3)), J @ v


def sphere_pile(bodies: int, mass_ratio: float = 1.0, seed: int = 0) -> Problem:
    """Frictionless pile of spheres with two contacts per body: block-sparse PSD of order `2 bodies`."""
    rng = np.random.default_rng(seed)
    contacts = 2 * bodies
    J = np.zeros((contacts, 3 * bodies))
    for k in range(contacts):
        i = k % bodies
        normal = rng.standard_normal(3)
        normal[2] = abs(normal[2]) + 0.5
        normal /= np.linalg.norm(normal)
        J[k, 3 * i : 3 * i + 3] = normal
        if i > 0 and rng.random() > 0.25:
            j = int(rng.integers(max(0, i - 6), i))
            J[k, 3 * j : 3 * j + 3] = -normal
    v = 0.02 * rng.standard_normal(3 * bodies)
    v[2::3] -= 0.0981
    return _delassus(J, np.repeat(mass_ratio ** -rng.random(bodies), 3)), J @ v


def stewart_trinkle(contacts: int, seed: int = 0, facets: int = 4, friction: float = 0.5) -> Problem:
    """Contacts with a polyhedral friction cone at the velocity level: order `contacts (facets + 2)`.

    `z = (normal impulses, facets tangential impulses per contact, sliding speeds)`,
    `A = [[N'N, N'D, 0], [D'N, D'D, E], [mu, -E', 0]]` in the inverse mass metric: copositive, not PSD. [ST96].
    """
    rng = np.random.default_rng(seed)
    bodies = max(1, (contacts + 2) // 3)
    normals = np.zeros((contacts, 6 * bodies))
    tangents = np.zeros((contacts * facets, 6 * bodies))
    for k in range(contacts):
        i = k % bodies
        j = int(rng.integers(0, i)) if i > 0 and rng.random() < 0.5 else None
        normal = np.append(0.2 * rng.standard_normal(2), 1.0)
        normal /= np.linalg.norm(normal)
        t1 = np.cross(normal, [1.0, 0.0, 0.0])
        t1 /= np.linalg.norm(t1)
        t2 = np.cross(normal, t1)
        below, above = np.append(rng.uniform(-0.5, 0.5, 2), -0.5), np.append(rng.uniform(-0.5, 0.5, 2), 0.5)
        angles = 2 * np.pi * np.arange(facets) / facets
        directions = [normal, *(np.cos(a) * t1 + np.sin(a) * t2 for a in angles)]
        rows = [normals[k], *tangents[k * facets : (k + 1) * facets]]
        for row, direction in zip(rows, directions, strict=True):
            row[6 * i : 6 * i + 6] = np.concatenate([direction, np.cross(below, direction)])
            if j is not None:
                row[6 * j : 6 * j + 6] = -np.concatenate([direction, np.cross(above, direction)])
    J = np.vstack([normals, tangents])
    B = _delassus(J, np.tile([1.0, 1.0, 1.0, 6.0, 6.0, 6.0], bodies))
    A = with_sliding_speeds(B, contacts, np.arange(contacts), np.full(contacts, friction), facets)
    v = 0.2 * rng.standard_normal(6 * bodies)
    v[2::6] -= 0.0981
    return A, np.concatenate([J @ v, np.zeros(contacts)])


def obstacle_1d(n: int) -> Problem:
    """A string over an obstacle: `tridiag(-1, 2, -1)`, an M-matrix; z is the height above the obstacle."""
    h = 1.0 / (n + 1)
    x = np.linspace(h, 1 - h, n)
    height = np.maximum(0.2 - 2.0 * (x - 0.5) ** 2, -0.5) + 0.05 * np.sin(6 * np.pi * x)
    A = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    return A, A @ height + h * h


def _delassus(J: Matrix, inverse_mass: Vector) -> Matrix:
    """`J M^-1 J'`, symmetric to the last bit."""
    A = (J * inverse_mass) @ J.T
    return (A + A.T) / 2
