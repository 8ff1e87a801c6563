"""The counterexample machine and the audit of the paper's claims."""

import argparse
import json

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
    "options", [{"n": 0}, {"n": 9}, {"entries": []}, {"samples": 0}, {"threads": 0}, {"resume": {}}]
)
def test_bad_options(options):
    with pytest.raises((errors.OptionError, errors.OptionTypeError)):
        explore("P => P0", **options)


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
