"""`solve_batch(out=)`: results of an earlier call are overwritten, all of them, and nothing else is."""

import dataclasses
import tracemalloc

import numpy as np
import pytest

import lcpstar
from lcpstar.errors import OptionError, ShapeError
from lcpstar.problems import random_pd, stewart_trinkle

FIELDS = [field.name for field in dataclasses.fields(lcpstar.BatchSolution) if field.name != "offsets"]


def batch(n, count=40, seed=0):
    """Problems of order n, one of them infeasible."""
    problems = [random_pd(n, seed=seed + k) for k in range(count)]
    A, q = (np.array(part) for part in zip(*problems, strict=True))
    if n > 0:
        A[3], q[3] = 0.0, -1.0
    return A, q


def spoiled(sols):
    """`sols` with garbage in every array."""
    for name in FIELDS:
        getattr(sols, name).view(np.uint8).fill(0xA5)
    return sols


def assert_same(a, b):
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


@pytest.mark.parametrize("n", [0, 1, 3, 4, 16, 24, 40, 70])
@pytest.mark.parametrize("threads", [1, 2])
def test_every_number_is_overwritten(n, threads):
    A, q = batch(n)
    fresh = lcpstar.solve_batch(A, q, threads=threads)
    out = spoiled(lcpstar.solve_batch(A, q))
    assert lcpstar.solve_batch(A, q, threads=threads, out=out) is out
    assert_same(out, fresh)
    assert n == 0 or out.status[3] == "infeasible"


def test_success_is_that_of_the_last_call():
    A, q = batch(4)
    out = lcpstar.solve_batch(A, q)
    assert not out.success[3]
    A[3], q[3] = A[2], q[2]
    assert lcpstar.solve_batch(A, q, out=out).success.all()
    assert out.status[3] == "solved"
    assert out.method[3] == out.method[2]


@pytest.mark.parametrize("n", [4, 24, 40, 70])
@pytest.mark.parametrize("guess", ["alpha0", "z0"])
def test_the_last_frame_is_the_guess_of_the_next(n, guess):
    A, q = batch(n)
    out = lcpstar.solve_batch(A, q)
    expected = lcpstar.solve_batch(A, q, **{guess: (out.z if guess == "z0" else out.alpha).copy()})
    lcpstar.solve_batch(A, q, out=out, **{guess: out.z if guess == "z0" else out.alpha})
    assert_same(out, expected)


def test_ragged_and_broadcast_batches():
    pairs = [random_pd(n, seed=n) for n in (3, 5, 3, 40)] + [stewart_trinkle(2, 0)]
    fresh = lcpstar.solve_batch(pairs)
    out = spoiled(lcpstar.solve_batch(pairs))
    assert lcpstar.solve_batch(pairs, out=out) is out
    assert_same(out, fresh)
    with pytest.raises(ShapeError, match=r"out\.offsets must be those of this batch"):
        lcpstar.solve_batch([pairs[1], pairs[0], *pairs[2:]], out=out)

    A, q = batch(5, 6)
    q = q.reshape(2, 3, 5)
    fresh = lcpstar.solve_batch(A[0], q)
    assert_same(lcpstar.solve_batch(A[0], q, out=spoiled(lcpstar.solve_batch(A[0], q))), fresh)


def test_what_does_not_fit_is_refused():
    A, q = batch(4)
    out = lcpstar.solve_batch(A, q)
    for others in (batch(4, 39), batch(5)):
        with pytest.raises(ShapeError, match=r"out\.z must be C-contiguous and aligned float64 of shape"):
            lcpstar.solve_batch(*others, out=out)
    with pytest.raises(ShapeError, match=r"out\.alpha must be C-contiguous and aligned uint64"):
        lcpstar.solve_batch(A, q, out=dataclasses.replace(out, alpha=np.zeros((40, 4), bool)))
    with pytest.raises(OptionError, match="share no memory with A, q"):
        lcpstar.solve_batch(A, out.w, out=out)
    out.residual.flags.writeable = False
    with pytest.raises(OptionError, match="must hold writable arrays"):
        lcpstar.solve_batch(A, q, out=out)


def test_no_array_is_allocated():
    A, q = batch(8, 2000)
    out = lcpstar.solve_batch(A, q)
    tracemalloc.start()
    try:
        lcpstar.solve_batch(A, q, alpha0=out.alpha, out=out)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < out.z.nbytes / 2  # the guess is copied, 8 bytes a problem
