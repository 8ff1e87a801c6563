"""Principal pivot transforms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lcpstar
from lcpstar import errors


@settings(max_examples=100, deadline=None)
@given(st.integers(1, 8), st.integers(0, 2**32 - 1))
def test_involution_and_exchange(n, seed):
    """Pivoting twice on alpha gives A back, and w = A z + q holds with w_alpha and z_alpha exchanged."""
    rng = np.random.default_rng(seed)
    A, q, z = rng.standard_normal((n, n)) + 3 * np.eye(n), rng.standard_normal(n), rng.standard_normal(n)
    alpha = rng.permutation(n)[: rng.integers(0, n + 1)].tolist()
    M, p = lcpstar.ppt(A, alpha, q=q)
    w = A @ z + q
    u, v = z.copy(), w.copy()
    u[alpha], v[alpha] = w[alpha], z[alpha]
    np.testing.assert_allclose(M @ u + p, v, rtol=0, atol=1e-10 * (1 + np.abs(M).max()) ** 2)
    B, r = lcpstar.ppt(M, alpha, q=p)
    np.testing.assert_allclose(B, A, rtol=0, atol=1e-10 * (1 + np.abs(M).max()) ** 2)
    np.testing.assert_allclose(r, q, rtol=0, atol=1e-10 * (1 + np.abs(M).max()) ** 2)


def test_empty_alpha_changes_nothing():
    A = [[1.0, 2.0], [3.0, 4.0]]
    assert lcpstar.ppt(A, []).tolist() == A


def test_singular_block():
    with pytest.raises(errors.SingularBlockError, match=r"alpha = \[0, 1\]: rank 1 of 2"):
        lcpstar.ppt([[0.1, 0.2, 1], [0.3, 0.6, 1], [1, 1, 1]], [0, 1])


@pytest.mark.parametrize(("alpha", "text"), [([2], "got 2"), ([-1], "got -1"), ([0, 0], "0 twice")])
def test_bad_index(alpha, text):
    with pytest.raises(errors.IndexSetError, match=text):
        lcpstar.ppt(np.eye(2), alpha)
