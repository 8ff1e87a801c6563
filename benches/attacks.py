"""Problems that mislead solvers, in NumPy: one generator per way to do so, reproducible by its seed."""

from __future__ import annotations

import numpy as np


def integers(rng, n):
    m = rng.integers(1, 4)
    A = rng.integers(-m, m + 1, (n, n)) * (rng.random((n, n)) < rng.uniform(0.3, 1))
    return A.astype(float), rng.integers(-3, 4, n).astype(float)


def powers(rng, shape, low, high):
    return np.ldexp(1.0, rng.integers(low, high + 1, shape))


def scaled_integers(rng, n):
    A, q = integers(rng, n)
    r, c = powers(rng, n, -40, 40), powers(rng, n, -40, 40)
    return A * r[:, None] * c, q * r * powers(rng, None, -30, 30)


def mixed_exponents(rng, n):
    spread = int(rng.choice([4, 13, 30, 60]))
    A, q = integers(rng, n)
    return A * powers(rng, (n, n), -spread, spread), q * powers(rng, n, -spread, spread)


def rank_one(rng, n):
    u = rng.standard_normal(n) * powers(rng, n, 0, int(rng.integers(0, 12)))
    A = np.outer(u, u)
    if rng.random() < 0.5:
        A = A * (1 + 1e-16 * rng.integers(-4, 5, (n, n)))
    return A, A @ np.abs(rng.standard_normal(n)) * rng.choice([-1, 1]) + rng.choice(
        [0, 1e-16, 1e-8]
    ) * rng.standard_normal(n)


def zero_row_sums(rng, n):
    """Off the diagonal nonpositive, row sums near 0: feasible points may be huge."""
    A = -np.abs(rng.standard_normal((n, n)))
    np.fill_diagonal(A, 0.0)
    np.fill_diagonal(A, -A.sum(axis=1) * (1 + rng.choice([0, 1e-16, -1e-15, 1e-12, -1e-9], n)))
    return A, rng.standard_normal(n)


def mass_ratio(rng, n):
    J = rng.standard_normal((n, n // 2 + 1)) * (rng.random((n, n // 2 + 1)) < 0.7)
    mass = 10.0 ** rng.uniform(0, rng.uniform(0, 12), n // 2 + 1)
    return (J / mass) @ J.T, J @ rng.standard_normal(n // 2 + 1) - 0.1


def ties(rng, n):
    B = rng.integers(-2, 3, ((n + 1) // 2, int(rng.integers(1, n + 1)))).astype(float)
    B = B[np.arange(n) % len(B)]
    pair = rng.integers(0, 3, n)
    return B @ B.T, (pair == 1) - B @ B.T @ (pair == 2).astype(float)


def ends(rng, n):
    sizes = np.array([5e-324, 3e-310, 2.3e-308, 1e-200, 1e-154, 1.0, 3.0, 1e154, 1e200, 1e307, 1.7e308])
    few = np.concatenate([[0.0], rng.choice(sizes, rng.integers(1, 4))])
    return (rng.choice(few, shape) * rng.choice([-1, 1, 1, 1], shape) for shape in ((n, n), n))


def almost_solvable(rng, n):
    rank = int(rng.integers(1, n + 1))
    B = rng.standard_normal((n, rank)) if rng.random() < 0.5 else rng.integers(-3, 4, (n, rank)).astype(float)
    i, j = rng.integers(0, n, 2)
    B[i] = 0.0 if i == j else -B[j]
    A = B @ B.T
    A = np.triu(A) + np.triu(A, 1).T
    q = np.abs(rng.standard_normal(n)) * (rng.random(n) < 0.5) - A @ (
        np.abs(rng.standard_normal(n)) * (rng.random(n) < 0.5)
    )
    q[i] = (0.0 if i == j else -q[j]) + rng.choice([-1, 1]) * 10.0 ** rng.uniform(-17, 0)
    return A, q


def positive(rng, n):
    B = rng.standard_normal((n, n))
    S = rng.standard_normal((n, n))
    A = B @ B.T / n + 10.0 ** rng.uniform(-6, 0) * np.eye(n) + S - S.T
    d = 10.0 ** (rng.uniform(-8, 8, n) * (rng.random() < 0.5))
    return A * d[:, None] * d, rng.standard_normal(n) * d


def dominant(rng, n):
    """Strictly dominant rows: both bounds of `accuracy` may hold."""
    A = rng.standard_normal((n, n)) * (rng.random((n, n)) < 0.6)
    np.fill_diagonal(A, np.abs(A).sum(axis=1) * (1 + 10.0 ** rng.uniform(-14, 0)) + 1e-3)
    return A, rng.standard_normal(n)


def random(rng, n):
    return rng.standard_normal((n, n)), rng.standard_normal(n)


ATTACKS = (
    integers,
    scaled_integers,
    mixed_exponents,
    rank_one,
    zero_row_sums,
    mass_ratio,
    ties,
    ends,
    almost_solvable,
    positive,
    dominant,
    random,
)


def embedded(rng, A, q):
    """The problem at random places of a band matrix with dominant rows, which cannot make it solvable or unsolvable."""
    n, size = int(rng.integers(130, 150)), len(q)
    places = rng.permutation(n)
    core, rest = places[:size], places[size:]
    big, rhs = np.zeros((n, n)), np.zeros(n)
    big[np.ix_(core, core)], rhs[core] = A, q
    factor = 10.0 ** (rng.uniform(-8, 8, len(rest)) * (rng.random() < 0.5))
    big[rest, rest] = 2.5 * factor
    big[rest[:-1], rest[1:]] = -factor[:-1]
    big[rest[1:], rest[:-1]] = -factor[1:]
    if size:
        some = rng.random(len(rest)) < 0.1
        big[rest[some], rng.choice(core, int(some.sum()))] = 0.25 * factor[some]
    rhs[rest] = factor * rng.standard_normal(len(rest)) * (rng.random(len(rest)) < rng.random())
    return big, rhs


def problem(rng, attack, n):
    """Finite numbers."""
    with np.errstate(all="ignore"):
        A, q = attack(rng, n)
        return np.clip(np.nan_to_num(A), -1.7e308, 1.7e308), np.clip(np.nan_to_num(q), -1.7e308, 1.7e308)
