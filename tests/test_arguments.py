"""Every argument of every public function: what is wrong raises an exception that inherits LCPError and names it."""

from __future__ import annotations

import dataclasses
import inspect
import re

import numpy as np
import pytest
import scipy.sparse as sp

import lcpstar
from lcpstar import LCPError, classes

A = [[2.0, 1.0], [1.0, 2.0]]
Q = [-5.0, -6.0]
NAN, INF = float("nan"), float("inf")

MATRIX = [None, "x", 3, {}, object(), np.zeros((2, 3)), [[1, 2], [3]], [[1, "x"], [0, 1]], [[1j, 0], [0, 1]], [1, 2]]
FINITE = [[[NAN, 0], [0, 1]], [[1, INF], [0, 1]], [[10**400, 0], [0, 1]]]
DENSE = [*MATRIX, *FINITE, [[None, 1], [1, 1]], sp.eye_array(2).tocsr()]
#: A that is read as exact numbers may be sparse and may hold 10^400.
EXACT = [*MATRIX, *FINITE[:2], [[None, 1], [1, 1]]]
VECTOR = ["x", 3, {}, object(), [[1, 2]], [1, "x"], [1, 2j], [1, None], [NAN, 1], [10**400, 1], [1, 2, 3]]
EXACT_VECTOR = [q for q in VECTOR if q != [10**400, 1]]
#: One vector more is a batch.
BATCH_VECTOR = [q for q in VECTOR if q != [[1, 2]]]
COUNT = ["x", 1.5, True, NAN, [1], -1, object()]
NO_NUMBER = ["x", True, [1], 1j, object()]
NUMBER = [*NO_NUMBER, NAN, -1.0]
FLAG = ["x", 1, 0.5, [True], object()]
TEXT = [3, True, None, ["auto"], object(), "nonsense"]
SECONDS = ["1", True, NAN, [1], -1.0, 1j]
THREADS = [x for x in COUNT if x != "x"] + ["2", 0]

SOLVE = {
    "A": DENSE[:-1],
    "q": [None, *VECTOR],
    "method": TEXT,
    "tol": [*NUMBER, None, 0, 1],
    "max_iterations": COUNT,
    "time_limit": SECONDS,
    "z0": VECTOR,
    "certify": TEXT,
    "options": [3, "x", {}, lcpstar.LemkeOptions()],
}
TABLE = {
    "solve": (lcpstar.solve, {"A": A, "q": Q}, SOLVE),
    "solve, coerced": (lcpstar.solve, {"A": [[2, 1], [1, 2]], "q": [-5, -6]}, {"tol": NUMBER, "certify": TEXT}),
    "solve, sparse": (
        lcpstar.solve,
        {"A": sp.csr_array(A), "q": Q},
        {name: SOLVE[name] for name in SOLVE if name != "A"},
    ),
    "solve_batch": (
        lcpstar.solve_batch,
        {"A": A, "q": Q},
        {
            "A": DENSE,
            "q": BATCH_VECTOR,
            "method": TEXT,
            "tol": [*NUMBER, None, 0, 1],
            "threads": THREADS,
            "z0": [z for z in BATCH_VECTOR if z != 3],
            "alpha0": ["x", 0.5, [[1, 2], [3]], {}, object(), -1, [[True, False, True]]],
            "offsets": ["x", 0.5, [[1, 2], [3]], {}, [1, 2], [0, 3, 1]],
            "out": [3, "x", {}, np.zeros(2)],
        },
    ),
    "solve_gufunc": (
        lcpstar.solve_gufunc,
        {"A": A, "q": Q},
        {"A": DENSE, "q": BATCH_VECTOR, "tol": NUMBER, "threads": THREADS},
    ),
    "ppt": (
        lcpstar.ppt,
        {"A": A, "alpha": [0]},
        {
            "A": DENSE,
            "alpha": [None, "x", [0.5], [True, False], [[0]], [2], [-1], [0, 0], [10**30], ["0"], object(), 0.5],
            "q": VECTOR,
        },
    ),
    "solutions": (
        lcpstar.solutions,
        {"A": A, "q": Q},
        {"A": EXACT, "q": [None, *EXACT_VECTOR], "exact": FLAG, "time_limit": SECONDS},
    ),
    "accuracy": (
        lcpstar.accuracy,
        {"A": A, "q": Q, "sol": [1.0, 1.0]},
        {"A": DENSE[:-1], "q": [None, *VECTOR], "sol": [None, *VECTOR]},
    ),
    "potential_reduction": (
        lcpstar.potential_reduction,
        {"A": A, "q": Q},
        {
            "A": DENSE,
            "q": [None, *VECTOR],
            "z0": VECTOR,
            **dict.fromkeys(("beta", "gamma", "sigma", "eps", "kappa_factor"), NUMBER),
            **dict.fromkeys(("min_halvings", "max_iterations"), COUNT),
            "direction": [x for x in TEXT if x is not None],
            "long_step": FLAG,
            "trace": FLAG,
        },
    ),
    "game_value": (lcpstar.game_value, {"A": A}, {"A": EXACT, "exact": FLAG}),
    "classes.game": (classes.game, {"A": A}, {"A": EXACT}),
    "classes.check": (
        classes.check,
        {"A": A, "symbol": "P"},
        {"A": EXACT, "symbol": [3, None, ["P"], "E7", b"P"], "time_limit": SECONDS},
    ),
    "is_p": (lcpstar.is_p, {"A": A}, {"A": EXACT, "time_limit": SECONDS}),
    "classify": (
        lcpstar.classify,
        {"A": A, "classes": ["P"]},
        {
            "A": EXACT,
            "classes": ["P", 3, [3], ["E7"], [None]],
            "time_limit": SECONDS,
            "threads": THREADS,
            "progress": FLAG,
        },
    ),
    "solution_set": (
        lcpstar.solution_set,
        {"A": A, "q": Q},
        {"A": EXACT, "q": [None, *EXACT_VECTOR], "time_limit": SECONDS},
    ),
    "explore": (
        lcpstar.explore,
        {"claim": "P => P0", "n": 1},
        {
            "claim": [3, None, b"P", "E9"],
            "n": ["x", None, 1.5, True, [1.5], 0, 9],
            "entries": [None, 3, "x", [0.5], ["1/2"], [None], [True], [], [1j], [NAN]],
            "samples": [*COUNT, 0],
            "seed": [*COUNT, None, 2**64],
            "up_to_permutation": FLAG,
            "stop_at_first": FLAG,
            "threads": THREADS,
            "time_limit": SECONDS,
            "progress": FLAG,
            "resume": [3, "x", {}, {"n": 1}],
        },
    ),
}
OPTIONS = {
    "d": VECTOR[:-3],
    "alpha": ["x", [0.5], [True], [[0]], [10**30], 0.5],
    "direction": [3, True, object()],
    **dict.fromkeys(("restarts", "label", "starts", "patience", "min_halvings", "sweeps", "solves"), COUNT),
    "seed": [*COUNT, 2**64],
    **dict.fromkeys(("beta", "gamma", "sigma", "kappa_factor", "relaxation", "rho"), NO_NUMBER),
    **dict.fromkeys(("long_step", "finish", "symmetric", "polish"), FLAG),
}
CLASSES = [getattr(lcpstar, name) for name in lcpstar.__all__ if name.endswith("Options")]
CASES = [
    *(
        (f, good, name, wrong)
        for f, good, table in TABLE.values()
        for name, values in table.items()
        for wrong in values
    ),
    *((c, {}, f.name, wrong) for c in CLASSES for f in dataclasses.fields(c) for wrong in OPTIONS[f.name]),
]


@pytest.mark.parametrize(
    ("function", "good", "name", "wrong"), CASES, ids=[f"{f.__name__}-{n}-{w!r:.30}" for f, _, n, w in CASES]
)
def test_a_wrong_argument_is_named(function, good, name, wrong):
    with pytest.raises((TypeError, ValueError, IndexError)) as caught:
        function(**{**good, name: wrong})
    assert isinstance(caught.value, LCPError), repr(caught.value)
    assert re.search(rf"\b{name}\b", str(caught.value)), str(caught.value)


def test_the_table_holds_every_argument():
    others = {"verify"}  # takes anything, and reports
    for name in lcpstar.__all__:
        thing = getattr(lcpstar, name)
        if inspect.isfunction(thing) and name not in others and not name.startswith("is_"):
            arguments = set(inspect.signature(thing).parameters)
            assert arguments == set(TABLE[name][2]), name
    for which in classes.CLASSES.values():
        assert list(inspect.signature(which.check).parameters) == ["A", "time_limit"]


@pytest.mark.parametrize("wrong", [1j, "x", None])
def test_a_wrong_entry_is_named_with_its_place(wrong):
    matrix = [[2, 1], [1, wrong]]
    for call in (
        lambda: lcpstar.solve(matrix, Q),
        lambda: lcpstar.ppt(matrix, [0]),
        lambda: lcpstar.is_p(matrix),
        lambda: lcpstar.game_value(matrix),
    ):
        with pytest.raises(LCPError, match=r"A\[1, 1\]"):
            call()


def test_usual_numbers_of_other_types_are_taken():
    expected = lcpstar.solve(A, Q).z.tolist()
    for arguments in (
        {"tol": np.float32(1e-6)},
        {"max_iterations": np.int64(50)},
        {"max_iterations": 10**30},
        {"time_limit": np.float64(5)},
        {"time_limit": INF},
        {"time_limit": 3},
        {"method": "lemke", "options": lcpstar.LemkeOptions(restarts=np.int32(2), seed=2**64 - 1)},
    ):
        assert np.allclose(lcpstar.solve(A, Q, **arguments).z, expected)
    assert lcpstar.ppt(A, np.array([0])).tolist() == lcpstar.ppt(A, (0,)).tolist() == lcpstar.ppt(A, 0).tolist()
    assert lcpstar.game_value(A, exact=np.True_) == lcpstar.game_value(A)
