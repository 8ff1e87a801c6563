"""Every call that may take long stops soon after Ctrl-C and after its `time_limit`: see docs/statuses.md.

Times are those of the processor, so that other processes do not matter.
"""

from __future__ import annotations

import signal
import time

import numpy as np
import pytest
import scipy.sparse as sp

import lcpstar

#: Seconds of the processor after the signal.
SOON = 0.5
#: ... where a factorisation by a library has to end first.
FACTORISATION = 3.0

rng = np.random.default_rng(19)


def monotone(n):
    """`A + A'` positive definite, badly conditioned."""
    S = rng.random((n, n), dtype=np.float32).astype(float)
    return S - S.T + 1e-3 * np.eye(n), -rng.random(n)


def symmetric(n, rank=40):
    """Positive definite, of low rank but for the diagonal."""
    B = rng.standard_normal((n, rank))
    return B @ B.T + 1e-4 * np.eye(n), -rng.random(n)


def chain(n):
    """Tridiagonal, condition n^2."""
    return 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1), -rng.random(n) + 0.2


def grid(n):
    """The Laplacian of an n x n grid."""
    T, one = sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)), sp.eye_array(n)
    return sp.csr_array(sp.kron(T, one) + sp.kron(one, T)), rng.standard_normal(n * n)


def scattered(n):
    """A sparse M-matrix whose factors are dense."""
    R = abs(sp.random_array((n, n), density=4 / n, rng=rng, format="csr"))
    return sp.csr_array(sp.diags_array(2.0 + (R + R.T).sum(axis=1)) - R - R.T), rng.standard_normal(n)


def integers(n):
    return rng.integers(-99, 100, (n, n))


def solving(problem, method="auto", **options):
    """`solve` with a time limit, if one is given."""
    return lambda **limit: lcpstar.solve(*problem, method=method, **options, **limit)


def checking(A, symbol):
    return lambda **limit: lcpstar.classes.check(A, symbol, **limit)


def gram(n):
    B = integers(n)
    return B @ B.T


def cycle(n):
    """P for odd n, by its minors: nothing simpler shows it."""
    return np.eye(n, dtype=int) + 3 * np.roll(np.eye(n, dtype=int), 1, axis=1)


def p_matrix(n):
    """P by a positive definite symmetric part, with a skew one that hides it."""
    S = integers(n)
    return gram(n) + 1000 * (S - S.T) + np.eye(n, dtype=int)


def point(problem):
    return lambda: lcpstar.accuracy(*problem, np.abs(rng.standard_normal(len(problem[1]))))


def transforming(n):
    A, _ = monotone(n)
    return lambda: lcpstar.ppt(A, range(n // 2))


def stubborn(n):
    """n problems in one batch, each long."""
    A, q = monotone(1200)
    return lambda: lcpstar.solve_batch(A, np.tile(q, (n, 1)), method="lemke", threads=2)


def batch(n, count, **options):
    A, _ = symmetric(n, n)
    vectors = rng.standard_normal((count, n))
    return lambda: lcpstar.solve_batch(A, vectors, **options)


def proving(n):
    A, q = rng.standard_normal((n, n)), -rng.random(n)
    A = A @ A.T + np.eye(n)
    return lambda: lcpstar.verify(A, q, lcpstar.solve(A, q, certify="exact"), exact=True)


SOON_JOBS = {
    "lemke": lambda: solving(monotone(2000), "lemke"),
    "principal_pivoting": lambda: solving(monotone(2000), "principal_pivoting"),
    "bilinear": lambda: solving(monotone(2000), "bilinear"),
    "enumerate": lambda: solving((-np.eye(24) - 0.1, -np.ones(24)), "enumerate"),
    "pgs": lambda: solving(chain(3000), "pgs"),
    "nncg": lambda: solving(symmetric(3000), "nncg", tol=1e-14),
    "apgd": lambda: solving(chain(3000), "apgd", tol=1e-14),
    "sparse pgs": lambda: solving(grid(500), "pgs"),
    "sparse nncg": lambda: solving(grid(500), "nncg", tol=1e-14),
    "sparse apgd": lambda: solving(grid(500), "apgd", tol=1e-14),
    "exact": lambda: solving(monotone(900), "auto", certify="exact"),
    "solutions": lambda: lambda **limit: lcpstar.solutions(integers(60).astype(float), -np.ones(60), **limit),
    "batch of small ones": lambda: batch(8, 3_000_000, threads=2),
    "batch of small ones, one thread": lambda: batch(8, 3_000_000, threads=1),
    "batch of middle ones": lambda: batch(100, 40_000),
    "batch by name": lambda: batch(20, 400_000, method="lemke"),
    "batch of two": lambda: stubborn(2),
    "batch of five": lambda: stubborn(5),
    "game_value": lambda: lambda: lcpstar.game_value(integers(150)),
    "PSD": lambda: checking(gram(220), "PSD"),
    "PSBD": lambda: checking(gram(220), "PSBD"),
    "P": lambda: checking(cycle(31), "P"),
    "PM": lambda: checking(p_matrix(18), "PM"),
    "E0": lambda: checking(gram(24) - 3, "E0"),
    "C0": lambda: checking(gram(30) - 5 * np.eye(30, dtype=int), "C0"),
    "Q": lambda: checking(rng.integers(-3, 4, (9, 9)) + 8 * np.eye(9, dtype=int), "Q"),
    "classify": lambda: lambda **limit: lcpstar.classify(gram(10) + rng.integers(0, 3, (10, 10)), **limit),
    "determinant": lambda: lcpstar._core.IntegerMatrix(400, [int(x) for x in integers(400).ravel()]).determinant,
    "explore": lambda: lambda **limit: lcpstar.explore("Q & E0 => C0 | P", n=6, samples=10**6, **limit),
    "verify": lambda: proving(300),
}
FACTORISATION_JOBS = {
    "auto": lambda: solving(monotone(2500)),
    "block_pivoting": lambda: solving(monotone(2500), "block_pivoting"),
    "interior_point": lambda: solving(monotone(2000), "interior_point"),
    "newton": lambda: solving(monotone(2500), "newton"),
    "pgs_sm": lambda: solving(chain(4000), "pgs_sm", tol=1e-15),
    "admm": lambda: solving(monotone(2500), "admm", tol=1e-14),
    "potential_reduction": lambda: lambda: lcpstar.potential_reduction(*symmetric(1500)),
    "potential_reduction by QR": lambda: lambda: lcpstar.potential_reduction(*symmetric(700), direction="qr"),
    "ppt": lambda: transforming(3000),
    "accuracy": lambda: point(chain(3000)),
    "sparse auto": lambda: solving(grid(700)),
    "sparse interior_point": lambda: solving(grid(700), "interior_point"),
    "sparse newton": lambda: solving(grid(700), "newton"),
    "sparse pgs_sm": lambda: solving(grid(700), "pgs_sm"),
    "sparse admm": lambda: solving(grid(700), "admm"),
    "sparse accuracy": lambda: point(scattered(5000)),
    "sparse auto with fill": lambda: solving(scattered(5000)),
}
JOBS = SOON_JOBS | FACTORISATION_JOBS


class Stop(BaseException):
    """What the signal handler raises."""


def stop(_number, _frame):
    raise Stop


@pytest.mark.parametrize("name", JOBS)
def test_ctrl_c(name):
    job = JOBS[name]()
    after = float(rng.uniform(0.05, 0.4))
    previous = signal.signal(signal.SIGPROF, stop)
    start = time.process_time()
    try:
        signal.setitimer(signal.ITIMER_PROF, after)
        with pytest.raises(Stop):
            job()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, previous)
    late = time.process_time() - start - after
    assert late < (SOON if name in SOON_JOBS else FACTORISATION), f"{late:.1f} s late"


LIMITED = [
    name
    for name in JOBS
    if not any(part in name for part in ("batch", "potential", "ppt", "accuracy", "game", "determinant", "verify"))
]


@pytest.mark.parametrize("name", LIMITED)
def test_time_limit(name):
    job, limit = JOBS[name](), 0.2
    start = time.process_time()
    try:
        found = job(time_limit=limit)
    except lcpstar.errors.TimeLimitError:
        found = None
    late = time.process_time() - start - limit
    assert late < (SOON if name in SOON_JOBS else FACTORISATION), f"{late:.1f} s late"
    if isinstance(found, lcpstar.Solution):
        assert found.status == "time_limit" or found.success  # a solution in time is one, too
        assert np.isfinite(found.z).all()
