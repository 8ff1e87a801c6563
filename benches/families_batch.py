"""Batches of the families of `lcpstar.problems`: `family(k, n, seed) -> A, q`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lcpstar import problems

DRAWN = 300


def batch(build: Callable[[int, int], problems.Problem], k: int, size: int, seed: int) -> problems.Problem:
    """`DRAWN` problems at most, and as many copies of each in other units as it takes: all are different."""
    drawn = [build(size, 1000 * seed + s) for s in range(min(k, DRAWN))]
    A, q = (np.resize(np.stack(part), (k, *part[0].shape)) for part in zip(*drawn, strict=True))
    units = np.random.default_rng([seed, 3]).uniform(0.5, 2.0, q.shape)
    units[:DRAWN] = 1.0
    return units[:, :, None] * A * units[:, None, :], units * q


def random_pd(k: int, n: int, seed: int = 0) -> problems.Problem:
    """Positive definite, not symmetric."""
    return batch(problems.random_pd, k, n, seed)


def random_spd(k: int, n: int, seed: int = 0) -> problems.Problem:
    """Symmetric positive definite."""
    return batch(problems.random_spd, k, n, seed)


def psd_rank_half(k: int, n: int, seed: int = 0) -> problems.Problem:
    """Symmetric PSD of rank n/2, solvable."""
    return batch(problems.psd_half_rank, k, n, seed)


def stewart_trinkle(k: int, n: int, seed: int = 0) -> problems.Problem:
    """Contacts with a friction pyramid of four facets: n is a multiple of 6."""
    return batch(problems.stewart_trinkle, k, n // 6, seed)


FAMILIES = {
    "random_pd": random_pd,
    "random_spd": random_spd,
    "psd_rank_half": psd_rank_half,
    "stewart_trinkle": stewart_trinkle,
}
