"""Bad input gets an exception that names the argument and the number; unusual input just works."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from fractions import Fraction

import numpy as np
import pytest

import lcpstar
from lcp_checks import assert_solves
from lcpstar import LCPError, errors

A = np.array([[2.0, 1.0], [0.5, 2.0]])
q = np.array([-1.0, -2.0])


@pytest.mark.parametrize(
    ("A", "q", "error", "builtin", "text"),
    [
        (np.ones((2, 3)), q, errors.ShapeError, ValueError, r"A must be a square matrix, got shape \(2, 3\)"),
        (np.ones(2), q, errors.ShapeError, ValueError, "A must be a square matrix"),
        (np.eye(3), q, errors.ShapeError, ValueError, "q must have length 3, got 2"),
        (A, q[:, None], errors.ShapeError, ValueError, r"q must be a vector, got shape \(2, 1\)"),
        ([[1, 2], [3]], q, errors.ShapeError, ValueError, "A is ragged"),
        ([[1, np.nan], [0, 1]], q, errors.NotFiniteError, ValueError, r"A\[0, 1\] = NaN"),
        (A, [0, -np.inf], errors.NotFiniteError, ValueError, r"q\[1\] = -inf"),
        (A * 1j, q, errors.DTypeError, TypeError, r"A\[0, 0\]"),
        ([["1", "2"], ["3", "4"]], q, errors.DTypeError, TypeError, r"A\[0, 0\] = "),
        (A, [1.0, None], errors.DTypeError, TypeError, r"q\[1\] = None"),
        (A, [1, Fraction(1, 3)], errors.DTypeError, TypeError, r"q\[1\] = Fraction\(1, 3\)"),
        (A, np.array([1, 2**53 + 1]), errors.DTypeError, TypeError, r"q\[1\] = 9007199254740993"),
        (A, np.ma.array([1.0, 2.0], mask=[0, 1]), errors.DTypeError, TypeError, r"q\[1\] masked"),
    ],
)
def test_arrays(A, q, error, builtin, text):
    with pytest.raises(error, match=text) as caught:
        lcpstar.solve(A, q)
    assert isinstance(caught.value, LCPError)
    assert isinstance(caught.value, builtin)


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        ({"method": "nonsense"}, errors.UnknownNameError, 'method must be one of auto, .*got "nonsense"'),
        ({"tol": 0.0}, errors.OptionError, r"tol must be in \(0, 1\), got 0"),
        ({"tol": float("nan")}, errors.OptionError, "tol"),
        ({"max_iterations": -1}, errors.OptionError, "max_iterations must be nonnegative, got -1"),
        ({"time_limit": 0.0}, errors.OptionError, "time_limit must be positive, got 0"),
        ({"z0": [1.0, -1.0]}, errors.OptionError, r"z0\[1\] = -1"),
        ({"z0": [1.0]}, errors.ShapeError, "z0 must have length 2, got 1"),
        ({"certify": "maybe"}, errors.UnknownNameError, "certify"),
        ({"method": "auto", "options": lcpstar.LemkeOptions()}, errors.OptionTypeError, "takes no options"),
        ({"method": "lemke", "options": lcpstar.LemkeHowsonOptions()}, errors.OptionTypeError, "LemkeOptions"),
        ({"method": "lemke", "options": lcpstar.LemkeOptions(d=[1, -2])}, errors.OptionError, r"d\[1\] = -2"),
        ({"method": "lemke", "options": lcpstar.LemkeOptions(d=[1])}, errors.ShapeError, "d must have length 2"),
        ({"method": "lemke_howson", "options": lcpstar.LemkeHowsonOptions(label=2)}, errors.IndexSetError, "label"),
        (
            {"method": "block_pivoting", "options": lcpstar.BlockPivotingOptions(alpha=[-1])},
            errors.IndexSetError,
            "alpha must hold indices in 0..2, got -1",
        ),
    ],
)
def test_options(arguments, error, text):
    with pytest.raises(error, match=text):
        lcpstar.solve(A, q, **arguments)


def test_unknown_keyword_is_a_type_error():
    with pytest.raises(TypeError):
        lcpstar.solve(A, q, tolerance=1e-3)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.longdouble, np.int8, np.uint32, np.int64, ">f8", "bool"])
def test_any_real_dtype(dtype):
    matrix = np.array([[2, 1], [0, 1]]).astype(dtype)
    assert_solves(matrix, q, lcpstar.solve(matrix, q))


def test_memory_order_and_strides():
    unsymmetric = np.array([[1.0, 5.0, 0.0], [0.0, 1.0, 0.0], [2.0, 3.0, 1.0]])
    vector = np.array([-1.0, -2.0, 4.0])
    expected = lcpstar.solve(unsymmetric, vector).z
    wide = np.zeros((6, 6))
    wide[::2, ::2] = unsymmetric
    flipped = unsymmetric[::-1, ::-1].copy()[::-1, ::-1]
    readonly = unsymmetric.copy()
    readonly.setflags(write=False)
    for matrix in (np.asfortranarray(unsymmetric), wide[::2, ::2], flipped, readonly, unsymmetric.tolist()):
        solution = lcpstar.solve(matrix, vector)
        assert_solves(unsymmetric, vector, solution)
        assert solution.z.tolist() == expected.tolist()
    strided = np.zeros(6)
    strided[::2] = vector
    assert lcpstar.solve(unsymmetric, strided[::2]).z.tolist() == expected.tolist()
    assert lcpstar.solve(unsymmetric, vector[::-1].copy()[::-1]).z.tolist() == expected.tolist()


def test_input_is_never_modified_and_result_is_frozen():
    matrix, vector = A.copy(), q.copy()
    solution = lcpstar.solve(matrix, vector)
    assert (matrix == A).all()
    assert (vector == q).all()
    with pytest.raises(ValueError, match="read-only"):
        solution.z[0] = 1.0
    with pytest.raises(AttributeError):
        solution.status = "solved"


FIELDS = [name for name in dir(lcpstar.Solution) if not name.startswith("_")]
COPIES = [copy.copy, copy.deepcopy, *(lambda s, p=p: pickle.loads(pickle.dumps(s, p)) for p in range(6))]


def plain(value):
    """A field as something that compares by value."""
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, list):
        return [plain(x) for x in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


@pytest.mark.parametrize("again", COPIES)
@pytest.mark.parametrize(
    "solution",
    [
        lcpstar.solve(A, q),
        lcpstar.solve(A, q, certify="exact"),
        lcpstar.solve([[-1]], [-1]),
        lcpstar.solve([[-1, 0], [0, 0]], [-1, 1], method="lemke"),
        lcpstar.solve(np.diag([2.0, 3.0, 4.0]), [-1, -1, 1]),
        lcpstar.solve(A, q, method="pgs", max_iterations=1),
        lcpstar.potential_reduction(A, q, trace=True),
    ],
    ids=str,
)
def test_a_copy_of_a_solution_is_a_solution_with_every_field(solution, again):
    twin = again(solution)
    assert type(twin) is lcpstar.Solution
    assert {name: plain(getattr(twin, name)) for name in FIELDS} == {
        name: plain(getattr(solution, name)) for name in FIELDS
    }
    assert repr(twin) == repr(solution)
    assert bool(twin) is bool(solution) is solution.success
    assert type(twin.status) is lcpstar.Status
    assert bool(lcpstar.verify(A, q, twin)) is bool(lcpstar.verify(A, q, solution))
    with pytest.raises(ValueError, match="read-only"):
        twin.z[0] = 1.0
    assert pickle.loads(pickle.dumps(twin)).z.tolist() == solution.z.tolist()


def test_a_failed_solution_is_false():
    assert not lcpstar.solve([[-1]], [-1])
    assert lcpstar.solve([[1]], [-1])
