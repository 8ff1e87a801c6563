"""The counterexample machine and the audit of the paper's claims."""

import argparse
import json
from fractions import Fraction

import pytest

from lcpstar import errors
from lcpstar.audit import CLAIMS, FALSE, HOLDS, audit, recompute, table
from lcpstar.classes import check
from lcpstar.exploring import add_explore_parser, explore
from lcpstar.formula import parse_claim


def ints(A):
    return None if A is None else [[int(x) for x in row] for row in A]


def test_finds_the_smallest_counterexample_with_its_witnesses():
    found = explore("tE0s => P0", n=(1, 2, 3), entries=range(-1, 2))
    assert found.complete
    assert ints(found.counterexample) == [[0, -1, -1], [1, 0, 0], [1, 1, 0]] or len(found.counterexample) == 2
    assert found.verdicts["tE0s"].holds is True
    assert found.verdicts["P0"].check() is True
    assert "false" in str(found)


def test_no_counterexample_counts_the_hypothesis():
    found = explore("tE0s & v > 0 => R0 & Q", n=2)
    assert found.counterexample is None
    assert found.satisfied > 10
    assert "no counterexample" in str(found)


def test_one_hundred_thousand_matrices_in_under_a_minute():
    found = explore("E0 & Q0 => cQ0", n=3, samples=100_000)
    assert found.scanned == 100_000
    assert found.seconds < 60


def test_the_answer_does_not_depend_on_threads_or_interruptions():
    claim = "L => E0f & Q"
    whole = explore(claim, n=(2, 3), entries=range(-1, 2), threads=1)
    threaded = explore(claim, n=(2, 3), entries=range(-1, 2), threads=2)
    part = explore(claim, n=(2, 3), entries=range(-1, 2), time_limit=0)
    assert not part.complete
    assert part.scanned == 0
    state = json.loads(json.dumps(part.state()))
    resumed = explore(claim, resume=state)
    for other in (threaded, resumed):
        assert (other.scanned, other.satisfied, other.failures) == (whole.scanned, whole.satisfied, whole.failures)
        assert other.counterexample == whole.counterexample
    sampled = [explore(claim, n=3, samples=3000, seed=7, threads=t) for t in (1, 2)]
    assert sampled[0].counterexample == sampled[1].counterexample
    assert sampled[0].failures == sampled[1].failures
    assert explore(claim, n=3, samples=3000, seed=8).failures != sampled[0].failures


def test_a_scan_up_to_permutation_sees_every_class():
    for claim in ("E0s => L", "P0 => E0s", "Q => R0"):
        once = explore(claim, n=2, entries=range(-2, 3))
        all_ = explore(claim, n=2, entries=range(-2, 3), up_to_permutation=False)
        assert (once.counterexample is None) == (all_.counterexample is None)
        assert once.scanned < all_.scanned == 5**4


def test_stop_at_first():
    found = explore("E0 => P0", n=3, entries=range(-2, 3), stop_at_first=True, threads=1)
    assert found.counterexample is not None
    assert not found.complete


@pytest.mark.parametrize(
    ("claim", "matrix", "expected"),
    [
        ("A' in E0s", [[0, -1], [0, 1]], False),
        ("A + A' in E0s", [[0, -1], [0, 0]], False),
        ("every PPT in E0s", [[0, 0], [1, 1]], False),
        ("some PPT in (!E0s)", [[0, 0], [1, 1]], True),
        ("every proper principal in P & det < 0", [[1, 2], [2, 1]], True),
        ("almost-P", [[1, 2], [2, 1]], True),
        ("A^-1 in N", [[1, 2], [2, 1]], True),
        ("A^-1 in (max > 0 & min < 0)", [[1, 2], [2, 1]], True),
        ("-A in P", [[-1, 0], [0, -2]], True),
        ("A[1] in N & !A[0] in N", [[1, 0], [0, -2]], True),
        ("ppt[0] in (a[0,1] < 0)", [[1, 2], [2, 1]], True),
        ("symmetric & !skew & rank == 1 & trace >= 2 & n != 3", [[1, 1], [1, 1]], True),
        ("v > 1/3 & v < 2/3 & v == 1/2", [[1, 0], [0, 1]], True),
        ("bordered", [[0, 1], [-1, 0]], True),
        ("bordered", [[0, 1], [0, 0]], False),
        ("every principal of order 2 in (det != 0)", [[1, 2], [2, 1]], True),
        ("C0* | C0+ | ++ | C0(1) | C0f(2)", [[1, 0], [0, 1]], True),
        ("P => C0 | Z", [[1, -9], [0, 1]], True),
        ("not (P & Z)", [[1, -9], [0, 1]], False),
    ],
)
def test_language(claim, matrix, expected):
    from lcpstar import _core

    hypothesis, conclusion = parse_claim(claim)
    kernel = _core.IntegerMatrix(len(matrix), [x for row in matrix for x in row])
    holds = not _core.satisfies(kernel, hypothesis) or _core.satisfies(kernel, conclusion)
    assert holds is expected


@pytest.mark.parametrize(
    ("claim", "text"),
    [
        ("", "expected a statement"),
        ("E0 =>", "expected a statement"),
        ("E0 & & P", "expected a statement"),
        ("E0 P", "expected the end"),
        ("(E0", r"expected '\)'"),
        ("E9", "expected a statement, got 'E9'"),
        ("v >", "expected a number"),
        ("det 3", "expected a relation"),
        ("A[0,0] in P", "repeated"),
        ("every block in P", "principal"),
        ("a[1] < 0", "expected 2 indices"),
        ("P $ Q", "cannot read"),
    ],
)
def test_claims_that_cannot_be_read(claim, text):
    with pytest.raises(errors.OptionError, match=text):
        explore(claim)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"n": 0}, "n must be at least 1, got 0"),
        ({"n": 9}, "n must be at most 8, got 9"),
        ({"n": "two"}, "n must be an integer, got 't'"),
        ({"n": []}, "n and entries must not be empty"),
        ({"entries": []}, "n and entries must not be empty"),
        ({"entries": ["1/2", 0]}, r"entries must be integers, got entries\[0\] = 1/2"),
        ({"entries": [0, Fraction(1, 3)]}, r"entries\[1\] = 1/3"),
        ({"entries": [0, 0.5]}, r"entries\[1\] = 0.5"),
        ({"entries": ["x"]}, r"entries\[0\] must be a number"),
        ({"entries": [True]}, r"entries must be integers, got entries\[0\] = True"),
        ({"entries": [None]}, r"entries\[0\] must be a real number"),
        ({"entries": [2**40]}, r"entries must be at most 2\^31"),
        ({"entries": 3}, "entries must be integers in a list"),
        ({"entries": "12"}, "entries must be integers in a list"),
        ({"samples": 0}, "samples must be at least 1"),
        ({"samples": 1.5}, "samples must be an integer"),
        ({"seed": -1}, "seed must be nonnegative"),
        ({"seed": 2**64}, "seed must be at most"),
        ({"threads": 0}, "threads must be at least 1"),
        ({"threads": "two"}, "threads must be an integer"),
        ({"time_limit": "1"}, "time_limit must be a real number"),
        ({"time_limit": float("nan")}, "time_limit must be nonnegative, got nan"),
        ({"stop_at_first": 1}, "stop_at_first must be True or False"),
        ({"resume": {}}, "resume must be a state"),
        ({"resume": "x"}, "resume must be a state"),
    ],
)
def test_bad_options_are_named(options, text):
    with pytest.raises(errors.LCPError, match=text) as caught:
        explore("P => P0", **options)
    assert isinstance(caught.value, (TypeError, ValueError))


def test_whole_numbers_are_entries_however_they_are_written():
    whole = explore("P => P0", n=2, entries=[1, 0])
    for entries in (["1", "0/3"], [Fraction(1), 0], [1.0, 0.0]):
        found = explore("P => P0", n=2, entries=entries)
        assert (found.entries, found.satisfied) == (whole.entries, whole.satisfied)


def test_a_hypothesis_that_no_matrix_meets_is_not_evidence(capsys):
    found = explore("P & N => Q", n=2)
    assert found.complete
    assert found.satisfied == 0
    assert found.outcome == "no matrix satisfied the hypothesis"
    assert "no counterexample" not in str(found)
    assert "no matrix satisfied the hypothesis" in str(found)
    parser = argparse.ArgumentParser()
    add_explore_parser(parser.add_subparsers())
    args = parser.parse_args(["explore", "P & N => Q", "-n", "2", "--json"])
    assert args.run(args) == 1
    printed = json.loads(capsys.readouterr().out)
    assert printed["outcome"] == found.outcome
    assert explore("P & N => Q", resume=printed).satisfied == 0
    assert explore("P => P0", n=2, entries=[0, 1]).outcome == "no counterexample"
    assert explore("P0 => P", n=2, entries=[0, 1]).outcome == "counterexample"


@pytest.mark.parametrize(
    "damage", [{"n": [9]}, {"seed": "x"}, {"position": [0]}, {"position": [7, 0]}, {"scanned": -1}, {"entries": [[]]}]
)
def test_a_damaged_state_is_refused(damage):
    state = explore("P => P0", n=2, entries=[0, 1], time_limit=0).state()
    with pytest.raises(errors.OptionError, match="resume must be a state of an exploration"):
        explore("P => P0", resume={**state, **damage})


def test_command_line(tmp_path, capsys):
    parser = argparse.ArgumentParser()
    add_explore_parser(parser.add_subparsers())
    state = tmp_path / "state.json"
    args = parser.parse_args(["explore", "P0 => R0", "-n", "2", "--state", str(state)])
    assert args.run(args) == 1
    assert "[[0, 0], [0, 0]]" in capsys.readouterr().out
    assert json.loads(state.read_text())["complete"] is True
    args = parser.parse_args(["explore", "P => P0", "-n", "2", "--entries", "-1", "0", "1", "--json"])
    assert args.run(args) == 0
    assert json.loads(capsys.readouterr().out)["failures"] == 0


def test_audit_refutes_the_papers_false_claims_by_itself():
    outcomes = audit()
    assert all(outcome.agrees for outcome in outcomes), table([o for o in outcomes if not o.agrees])
    refuted = {
        mark for o in outcomes if o.verdict == FALSE for mark in ("F1", "F3", "F4", "F6", "F7") if mark in o.place
    }
    assert refuted == {"F1", "F3", "F4", "F6", "F7"}
    assert sum(outcome.seconds for outcome in outcomes) < 300
    assert sum(outcome.verdict == HOLDS for outcome in outcomes) > 20
    bordered = next(o for o in outcomes if o.place == "Sec. 5, Thm (F1)").counterexample
    assert check(bordered, "P0").check() is True
    assert bordered[2][2] == 0


def test_audit_says_where_it_differs():
    claim = next(c for c in CLAIMS if c.expected == FALSE)
    wrong = type(claim)(claim.place, claim.text, claim.formula, HOLDS)
    assert not recompute(wrong).agrees
    assert "DIFFERS" in table([recompute(wrong)])
