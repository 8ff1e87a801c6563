"""`Verdict.check` proves the verdict: its class, its matrix, and its answer; whatever else its evidence proves."""

from __future__ import annotations

import json
import os
import pathlib
import random
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from functools import cache

import pytest

import lcpstar
from lcpstar import classes
from lcpstar.classes import certificate as c
from lcpstar.classes import regions as r
from lcpstar.classes import witness as w
from lcpstar.classes.exact import read_matrix
from lcpstar.classes.verdict import Cost, Verdict

SAMPLE = pathlib.Path(os.environ.get("LCPSTAR_CORPUS", "missing")).parent / "classes_sample.json"
PARAMETRIC = ("C0(0)", "C0(1)", "C0(2)", "C0(3)", "C0(4)", "C0f(1)", "C0f(2)")
MATRICES = (
    *([[1, 1], [0, 1]], [[0, 0], [0, 0]], [[-1, 0], [0, -1]], [[0, -1], [0, 0]], [[0, 1], [1, 0]], [[1, -3], [-3, 1]]),
    *(
        [[2, -1], [-1, 2]],
        [[-1, 1], [-1, 2]],
        [[1, 5], [5, 1]],
        [[0, -5], [2, 0]],
        [[1, 1], [1, 1]],
        [[-1, -2], [-3, -1]],
    ),
    *([[0, 1, 1], [2, 0, 1], [-4, -5, 0]], [[1, -1, -2], [-1, 1, 0], [0, 0, 1]], [[0, 2, 1], [1, 0, 1], [-2, -2, 1]]),
    *([[2, -2, 3], [2, -2, 3], [2, -2, 1]], [[1, 3, 1], [0, 1, 1], [-1, -1, 0]], [[1, 2, 0], [0, 1, 2], [2, 0, 1]]),
    *(
        [[-1, 1, 1], [1, -1, 1], [1, 1, -1]],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [["1/2", 0, 0], [1, 0, 0], [0, -2, "1/3"]],
    ),
)


@dataclass(frozen=True)
class Case:
    """A matrix with the truth about it and all evidence for that truth."""

    matrix: tuple
    truth: dict
    verdicts: tuple


@cache
def cases():
    items = [(A, None) for A in MATRICES]
    if SAMPLE.exists():
        sample = [item for item in json.loads(SAMPLE.read_text()) if len(item["A"]) <= 3]
        items += [(item["A"], item["classes"]) for item in sample[::4]]
    found = []
    for A, known in items:
        report = lcpstar.classify(A)
        verdicts = {**report, **{symbol: classes.check(A, symbol) for symbol in PARAMETRIC}}
        truth = {symbol: verdict.holds for symbol, verdict in verdicts.items()}
        assert known is None or all(truth[symbol] is known[symbol] for symbol in known)
        found.append(Case(read_matrix(A), truth, tuple(verdicts.values())))
    return found


def forged(holds, symbol, A, evidence):
    A = A if isinstance(A, tuple) and isinstance(A[0], tuple) else read_matrix(A)
    witness, certificate = (None, evidence) if holds else (evidence, None)
    return Verdict(holds, symbol, "", witness, Cost(0.0), A, "because", certificate)


def evidence_of(verdict):
    return verdict.certificate if verdict.holds else verdict.witness


def test_every_genuine_verdict_is_proved():
    count = 0
    for case in cases():
        for verdict in case.verdicts:
            if verdict.holds is False or verdict.certificate is not None:
                assert verdict.check() is True, verdict
                count += 1
            else:
                assert verdict.check() is None
    assert count > 500


def test_evidence_for_another_class_proves_only_what_is_true():
    accepted = refused = 0
    for case in cases():
        for verdict in case.verdicts:
            evidence = evidence_of(verdict)
            for symbol, truth in case.truth.items() if evidence is not None else ():
                for holds in (True, False):
                    said = forged(holds, symbol, case.matrix, evidence).check()
                    assert said is False or (said is True and truth is holds), (symbol, holds, evidence, case.matrix)
                    accepted, refused = accepted + said, refused + (not said)
    assert accepted > 1000
    assert refused > 10 * accepted


def test_evidence_from_another_matrix_proves_only_what_is_true():
    rng = random.Random(1)
    for _ in range(20_000):
        case, other = rng.choice(cases()), rng.choice(cases())
        verdict = rng.choice(case.verdicts)
        symbol = rng.choice([verdict.symbol, *case.truth])
        holds = rng.random() < 0.5 if rng.random() < 0.3 else verdict.holds
        said = forged(holds, symbol, other.matrix, evidence_of(verdict)).check()
        assert said is not True or other.truth[symbol] is holds, (symbol, holds, evidence_of(verdict), other.matrix)


LEAVES = (
    -1,
    0,
    1,
    2,
    3,
    Fraction(1, 2),
    Fraction(-1),
    0.5,
    float("nan"),
    None,
    True,
    "> 0",
    "< 0",
    "E",
    "C0",
    (),
    (0,),
    (0, 0),
    (1, 0),
)


def mutated(value, rng, pool):
    """The evidence with something in it changed, however deep."""
    if is_dataclass(value) and not isinstance(value, Verdict) and rng.random() < 0.9:
        field = rng.choice(fields(value))
        return replace(value, **{field.name: mutated(getattr(value, field.name), rng, pool)})
    if isinstance(value, tuple) and value and rng.random() < 0.85:
        i = rng.randrange(len(value))
        change = rng.randrange(5)
        inner = mutated(value[i], rng, pool)
        return (value[:i] + value[i + 1 :], value + value[i:], value[::-1], (*value[:i], inner, *value[i + 1 :]))[
            min(change, 3)
        ]
    if isinstance(value, dict) and value and rng.random() < 0.9:
        key = rng.choice(list(value))
        rest = {k: v for k, v in value.items() if k != key}
        return rng.choice(
            [rest, {**value, key: mutated(value[key], rng, pool)}, {**rest, rng.choice([-1, 0, 4, 9]): value[key]}]
        )
    if isinstance(value, (int, Fraction)) and not isinstance(value, bool) and rng.random() < 0.7:
        return rng.choice([-value, value + 1, value - 1, 2 * value, Fraction(value) / 3, float(value)])
    if isinstance(value, bool):
        return not value
    return rng.choice([*LEAVES, evidence_of(rng.choice(rng.choice(pool).verdicts))])


def test_broken_evidence_proves_only_what_is_true():
    rng = random.Random(2)
    pool = cases()
    refused = 0
    for _ in range(30_000):
        case = rng.choice(pool)
        verdict = rng.choice(case.verdicts)
        evidence = evidence_of(verdict)
        if evidence is None:
            continue
        for _ in range(rng.choice([1, 1, 2, 3])):
            evidence = mutated(evidence, rng, pool)
        symbol = rng.choice([verdict.symbol] * 3 + list(case.truth))
        holds = rng.choice([verdict.holds] * 3 + [not verdict.holds])
        said = forged(holds, symbol, case.matrix, evidence).check()
        assert said is not True or case.truth[symbol] is holds, (symbol, holds, evidence, case.matrix)
        refused += said is False
    assert refused > 5000


P = [[1, 1], [0, 1]]
YES, NO = classes.check(P, "PD"), classes.check([[1, 5], [5, 1]], "PSD")
FLAT = c.LDL((0, 0), ((1, 0), (1, 1)), (Fraction(2), Fraction(0)), definite=False)
HALF = [[-1, 0], [0, 1]]


class AnythingGoes:
    """Says yes whatever it is asked."""

    def refutes(self, A):
        return True

    def proves(self, A):
        return True


class BetterEntry(w.Entry):
    def refutes(self, A):
        return True


@pytest.mark.parametrize(
    ("holds", "symbol", "A", "evidence"),
    [
        (False, "P0", P, w.Entry(0, 1)),
        (False, "P", P, w.Minor((0, 0), "> 0")),
        (False, "P", P, w.Minor((), "> 0")),
        (False, "P", P, w.Minor((0,), "< 0")),
        (False, "P", P, w.All(())),
        (False, "almost-C0f", [[0, -1], [0, 0]], w.All(())),
        (False, "P", P, w.Implied((), "P is contained in no class")),
        (False, "P", P, w.Implied((YES,), "not in PD, which contains P")),
        (True, "N", P, w.Implied((), "everything is in N")),
        (True, "N", P, w.Implied((YES,), "PD is contained in N")),
        (False, "PD", P, w.Implied((NO,), "")),
        (True, "P", [[-1, 0], [0, -2]], c.MinorSigns("> 0", proper=True)),
        (True, "P", [[-1, 0], [0, 0]], c.MinorSigns("<= 0")),
        (True, "P", [[-1, -2], [-2, -1]], c.MinorSigns("< 0")),
        (True, "PSD", [[1, 1], [1, -9]], FLAT),
        (True, "PD", [[1, 1], [1, 1]], replace(FLAT, order=(0, 1))),
        (True, "Q", [[1, 0], [0, -1]], classes.check([[1, 0], [0, -1]], "Q0").certificate),
        (True, "P0", [[0, 1], [1, 0]], c.Decomposition(((0, 2), (2, 0)), c.LDL((0, 1), ((1, 0), (0, 1)), (0, 0)))),
        (False, "++", P, r.AllShadowed(r.Tree(((2, None),)))),
        (False, "++", P, r.AllShadowed(r.Tree(((-1, None),)))),
        (False, "C0", HALF, w.FormZero((0, 1))),
        (False, "Z", P, w.Entry(1, -1)),
        (False, "E0s", P, w.NotStar((0, 0), -3)),
        (False, "almost-E", P, w.Member("E0")),
        (False, "cE0s", P, w.InSubmatrix((1, 0), w.Entry(0, 1))),
        (False, "C0f", P, w.InTransform((0, 0), w.FormValue((1, 0), orthant=True))),
        (False, "Ec", [[1]], r.IsolatedSolution((Fraction(1),), (Fraction(0),), [Fraction(0)])),
        (False, "PSD", P, w.FormValue((1e200, 1e-200))),
        (False, "P", P, AnythingGoes()),
        (True, "N", P, AnythingGoes()),
        (False, "Z", [[1, 0], [0, 1]], BetterEntry(0, 1)),
        (False, "cE0s", P, w.InSubmatrix((0,), AnythingGoes())),
        (False, "P", P, None),
        (True, "N", P, 3),
        (False, "no such class", [[1, 1], [0, 1]], w.Entry(0, 1)),
    ],
)
def test_a_forged_verdict_is_refused(holds, symbol, A, evidence):
    assert forged(holds, symbol, A, evidence).check() is False


def test_a_verdict_is_bound_to_its_class_its_matrix_and_its_answer():
    for verdict in (classes.check(P, "Z"), classes.check(P, "P"), classes.check(HALF, "C0"), classes.check(P, "Q")):
        assert verdict.check() is True
        assert replace(verdict, holds=not verdict.holds).check() is not True
        assert replace(verdict, holds=None).check() is None
        assert replace(verdict, symbol="almost-N").check() is False
        for matrix in ((), ((1.0, 1.0), (0.0, 1.0)), ((1, 1),), [[1, 1], [0, 1]], None, read_matrix([[0]])):
            assert replace(verdict, matrix=matrix).check() is False
        other = [[-1, -1], [-7, -1]] if verdict.holds else [[1, 0], [0, 1]]
        assert replace(verdict, matrix=read_matrix(other)).check() is False


def test_inclusions_carry_evidence_to_other_classes():
    copositive = w.FormValue((1, 0), orthant=True)
    for symbol in ("C0", "C", "C0+", "PSD", "PD", "C0*", "C0f", "PSD", "C0(0)"):
        assert forged(False, symbol, HALF, copositive).check() is True, symbol
    for symbol in ("E0", "P0", "almost-C0", "Z"):
        assert forged(False, symbol, HALF, copositive).check() is False, symbol
    definite = YES.certificate
    for symbol in ("PD", "PSD", "P", "P0", "SU", "E", "Q", "R0", "Qb", "ctE0s", "E0f", "C0"):
        assert forged(True, symbol, P, definite).check() is True, symbol
    for symbol in ("Z", "N", "K0", "++"):
        assert forged(True, symbol, P, definite).check() is False, symbol


def test_an_empty_block_is_copositive():
    """C0(n + 1) asks that no block of order 0 is: nothing belongs to it."""
    for A in ([[-1]], P, HALF):
        verdict = classes.check(A, f"C0({len(A) + 1})")
        assert verdict.holds is False
        assert verdict.check() is True
