"""Batches of random problems of one family, generated with array operations: `family(k, n, seed) -> A, q`."""

from __future__ import annotations

import numpy as np


def random_pd(k: int, n: int, seed: int = 0, skew: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """Positive definite, not symmetric: `G'G/n + 0.1 I` plus a skew part; q standard normal."""
    rng = np.random.default_rng(1000 + seed)
    G = rng.standard_normal((k, n, n))
    A = G.swapaxes(1, 2) @ G / n + 0.1 * np.eye(n)
    if skew:
        S = rng.standard_normal((k, n, n))
        A += skew * (S - S.swapaxes(1, 2)) / np.sqrt(n)
    else:
        A = 0.5 * (A + A.swapaxes(1, 2))
    return A, rng.standard_normal((k, n))


def random_spd(k: int, n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Symmetric positive definite."""
    return random_pd(k, n, seed, skew=0.0)


def psd_rank_half(k: int, n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Symmetric PSD of rank n/2; q is built from a complementary pair, so a solution exists."""
    rng = np.random.default_rng(2000 + seed)
    B = rng.standard_normal((k, n, max(1, n // 2)))
    A = B @ B.swapaxes(1, 2) / n
    A = 0.5 * (A + A.swapaxes(1, 2))
    z = np.maximum(rng.standard_normal((k, n)), 0.0)
    w = np.where(z > 0, 0.0, rng.random((k, n)))
    return A, w - (A @ z[..., None])[..., 0]


def stewart_trinkle(
    k: int, n: int, seed: int = 0, facets: int = 4, mu: float = 0.5, h: float = 0.01
) -> tuple[np.ndarray, np.ndarray]:
    """Contacts with a friction pyramid, z = (normal, tangential impulses, slacks): copositive, not PSD, not symmetric.

    n is a multiple of `facets + 2`. Boxes with three contacts each; a contact joins a box to the ground or to another.
    """
    rng = np.random.default_rng(4000 + seed)
    contacts, rest = divmod(n, facets + 2)
    if rest:
        raise ValueError(f"n must be a multiple of {facets + 2}, got {n}")
    bodies = max(1, (contacts + 2) // 3)
    J = np.zeros((k, contacts * (facets + 1), 6 * bodies))
    every = np.arange(k)
    for c in range(contacts):
        i = c % bodies
        j = rng.integers(0, i, k) if i > 0 else np.zeros(k, int)
        paired = (rng.random(k) < 0.5) & (i > 0)
        normal = np.concatenate([0.2 * rng.standard_normal((k, 2)), np.ones((k, 1))], axis=1)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        t1 = np.cross(normal, [1.0, 0.0, 0.0])
        t1 /= np.linalg.norm(t1, axis=1, keepdims=True)
        t2 = np.cross(normal, t1)
        r_i = np.concatenate([rng.uniform(-0.5, 0.5, (k, 2)), np.full((k, 1), -0.5)], axis=1)
        r_j = np.concatenate([rng.uniform(-0.5, 0.5, (k, 2)), np.full((k, 1), 0.5)], axis=1)
        directions = [normal] + [np.cos(a) * t1 + np.sin(a) * t2 for a in 2 * np.pi * np.arange(facets) / facets]
        rows = [c] + [contacts + c * facets + f for f in range(facets)]
        for row, d in zip(rows, directions, strict=True):
            J[:, row, 6 * i : 6 * i + 3] += d
            J[:, row, 6 * i + 3 : 6 * i + 6] += np.cross(r_i, d)
            back = np.where(paired[:, None], np.concatenate([d, np.cross(r_j, d)], axis=1), 0.0)
            J[every[:, None], row, 6 * j[:, None] + np.arange(6)] -= back
    inverse_mass = np.tile([1.0, 1.0, 1.0, 6.0, 6.0, 6.0], bodies)
    m = contacts * (facets + 1)
    E = np.kron(np.eye(contacts), np.ones((facets, 1)))
    A = np.zeros((k, n, n))
    A[:, :m, :m] = (J * inverse_mass) @ J.swapaxes(1, 2)
    A[:, contacts:m, m:] = E
    A[:, m:, :contacts] = mu * np.eye(contacts)
    A[:, m:, contacts:m] = -E.T
    v = 0.2 * rng.standard_normal((k, 6 * bodies))
    v[:, 2::6] -= 9.81 * h
    q = np.zeros((k, n))
    q[:, :m] = (J @ v[..., None])[..., 0]
    return A, q


FAMILIES = {
    "random_pd": random_pd,
    "random_spd": random_spd,
    "psd_rank_half": psd_rank_half,
    "stewart_trinkle": stewart_trinkle,
}
