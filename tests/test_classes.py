"""Verdicts: right on the sample, consistent with the proved inclusions, and every witness stands on its own."""

import copy
import json
import os
import pathlib
import pickle
import random
import signal
import subprocess
import sys
import time
from fractions import Fraction

import numpy as np
import pytest

import lcpstar
from lcpstar import _core, classes, errors
from lcpstar.classes.exact import pivot_transform, read_matrix
from lcpstar.classes.inclusions import INCLUSIONS, INTERSECTIONS
from lcpstar.exploring import explore

SAMPLE = pathlib.Path(os.environ.get("LCPSTAR_CORPUS", "missing")).parent / "classes_sample.json"

EXAMPLES = {
    "example 1": ([[0, -5], [2, 0]], "E0s tE0s P0 Ec", "C0 Q"),
    "example 6": ([[0, 1, 1], [2, 0, 1], [-4, -5, 0]], "E0s", "cE0s P0"),
    "example 8": ([[0, 1, 1], [2, 0, 2], [-2, -4, 0]], "tE0s L", "C0* P0 E0f"),
    "example 9": ([[1, -1, -2], [-1, 1, 0], [0, 0, 1]], "P0 E0s Q0", "tE0s L2"),
    "example 10": ([[0, 2, 1], [1, 0, 1], [-2, -2, 1]], "R0 tE0s Q Qb R", "cQ P0"),
    "F1": ([[1, 3, 1], [0, 1, 1], [-1, -1, 0]], "tE0s Q0", "P0 Ec E0f"),
    "F7": ([[0, -1], [0, 0]], "Z ++ almost-C0 P0", "CSU L2"),
    "Q is not R0": ([[2, -2, 3], [2, -2, 3], [2, -2, 1]], "Q", "R0 Qb E0"),
    "n = 1": ([[-3]], "almost-P almost-E N Z Q0 PSBD ++", "E0 P0 Ec Q"),
}


def random_matrices(count, sizes=(2, 3, 4), spread=2, seed=0):
    rng = random.Random(seed)
    for _ in range(count):
        n = rng.choice(sizes)
        A = [[rng.randint(-spread, spread) for _ in range(n)] for _ in range(n)]
        if rng.random() < 0.6:
            for i in range(n):
                A[i][i] = abs(A[i][i])
        yield A


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_of_the_paper(name):
    A, members, others = EXAMPLES[name]
    for symbols, expected in ((members, True), (others, False)):
        for symbol in symbols.split():
            verdict = classes.check(A, symbol)
            assert verdict.holds is expected, str(verdict)
            assert verdict.check() is not False


@pytest.mark.skipif(not SAMPLE.exists(), reason="needs the sample beside LCPSTAR_CORPUS")
def test_sample_verdicts_and_witnesses():
    for item in json.loads(SAMPLE.read_text()):
        report = lcpstar.classify(item["A"])
        assert lcpstar.game_value(item["A"], exact=True) == Fraction(item["game_value"])
        for symbol, expected in item["classes"].items():
            verdict = report[symbol]
            assert verdict.holds is expected, f"{item['tag']} {item['A']}: {verdict}"
            assert verdict.check() is (True if not expected else verdict.check())
            assert verdict.check() is not False
            assert verdict.reason


@pytest.mark.skipif(not SAMPLE.exists(), reason="needs the sample beside LCPSTAR_CORPUS")
def test_sample_solution_sets():
    for item in json.loads(SAMPLE.read_text()):
        for lcp in item["lcps"]:
            found = lcpstar.solution_set(item["A"], lcp["q"])
            assert found.components == lcp["components"], (item["A"], lcp["q"])
            expected = {v for piece in lcp["pieces"] for v in map(tuple, piece["vertices"])}
            assert {tuple(map(str, z)) for face in found.faces for z in face.vertices} == expected


def test_every_false_has_a_witness_that_checks_and_that_does_not_fit_another_matrix():
    kinds = set()
    for A in random_matrices(120):
        n = len(A)
        # In every class that the witnesses refute, except those that ask for a negative sign somewhere.
        innocent = read_matrix(np.eye(n, dtype=int))
        for symbol, verdict in lcpstar.classify(A).items():
            if verdict.holds is False:
                assert verdict.check() is True, f"{A}: {verdict}"
                kinds.add(type(verdict.witness).__name__)
                if classes.check(innocent, symbol).holds:
                    assert not verdict.witness.refutes(innocent), f"{symbol}: {verdict.witness}"
            else:
                assert verdict.check() in (True, None)
    assert len(kinds) >= 18, kinds


def test_tampered_certificates_are_refused():
    A = [[2, -1], [-1, 2]]
    other = read_matrix([[1, -3], [-3, 1]])
    for symbol in ("PD", "P", "K0", "C0", "Q", "Q0", "++"):
        certificate = classes.check(A, symbol).certificate
        assert certificate.proves(read_matrix(A))
        if symbol != "++":
            assert not certificate.proves(other), symbol
    assert not classes.check(A, "++").certificate.proves(read_matrix([[1, 5], [5, 1]]))


@pytest.mark.parametrize(("small", "large", "why"), INCLUSIONS, ids=lambda s: s if len(s) < 12 else "")
def test_inclusions(small, large, why):
    exhaustive = explore(f"{small} => {large}", n=(1, 2, 3), entries=range(-1, 2))
    sampled = explore(f"{small} => {large}", n=4, samples=1500)
    assert exhaustive.counterexample is None, str(exhaustive)
    assert sampled.counterexample is None, str(sampled)
    assert exhaustive.satisfied > 0


@pytest.mark.parametrize(("first", "second", "large", "why"), INTERSECTIONS)
def test_intersections(first, second, large, why):
    found = explore(f"{first} & {second} => {large}", n=(1, 2, 3), entries=range(-1, 2))
    assert found.counterexample is None, str(found)
    assert found.satisfied > 0


def test_predicates_agree_with_the_bulk_evaluation():
    """The readable predicates and the compiled formulas compose the same kernels independently."""
    for A in random_matrices(60, seed=3):
        kernel = _core.IntegerMatrix(len(A), [x for row in A for x in row])
        for symbol in [*classes.CLASSES, "C0(0)", "C0(2)", "C0f(1)"]:
            verdict = classes.check(A, symbol)
            assert _core.satisfies(kernel, ("in", symbol)) is verdict.holds, f"{A} {symbol}"


def test_true_verdicts_survive_random_attacks():
    rng = random.Random(5)
    attacked = 0
    for A in random_matrices(60, seed=8):
        n, B = len(A), np.array(A)
        holds = set(lcpstar.classify(A, ["E0", "E", "C0", "C", "CSU", "PSBD", "PM", "R0", "Q"]).holds)
        for _ in range(60):
            x = np.array([rng.choice([0, 0, 1, 2, 3, 5]) for _ in range(n)])
            y = np.array([rng.choice([-3, -1, 0, 1, 2]) for _ in range(n)])
            if x.any():
                w = B @ x
                assert "E0" not in holds or (w[x > 0] >= 0).any()
                assert "E" not in holds or (w[x > 0] > 0).any()
                assert "C0" not in holds or x @ w >= 0
                assert "C" not in holds or x @ w > 0
                assert "R0" not in holds or (w < 0).any() or x @ w != 0
                u = np.array([rng.choice([0, 1, 2, 4]) for _ in range(n)])
                assert "PM" not in holds or (u - x) @ w < 0 or (u - x) @ B @ u >= 0
            products = y * (B @ y)
            assert "CSU" not in holds or (products > 0).any() or not products.any()
            gradient = B.T @ y
            assert "PSBD" not in holds or y @ B @ y >= 0 or not (gradient.min() < 0 < gradient.max())
        if "Q" in holds:
            attacked += 1
            q = [rng.randint(-9, 9) for _ in range(n)]
            assert not lcpstar.solution_set(A, q).empty
    assert attacked > 3


def test_invariance_under_permutation_and_symmetric_scaling():
    rng = random.Random(2)
    for A in random_matrices(25, sizes=(3,), seed=4):
        order = rng.sample(range(3), 3)
        d = [rng.choice([1, 2, Fraction(1, 3)]) for _ in range(3)]
        permuted = [[A[i][j] for j in order] for i in order]
        scaled = [[d[i] * A[i][j] * d[j] for j in range(3)] for i in range(3)]
        before = {s: v.holds for s, v in lcpstar.classify(A).items()}
        assert {s: v.holds for s, v in lcpstar.classify(permuted).items()} == before
        after = lcpstar.classify(scaled)
        for symbol, verdict in after.items():
            if symbol != "R":  # its vector e is not scaled along
                assert verdict.holds is before[symbol], f"{A} {d} {symbol}"


def test_pivot_transform_of_a_pivot_transform_is_the_matrix():
    for A in random_matrices(30, seed=6):
        M = pivot_transform(read_matrix(A), (0, 1))
        if M is not None:
            assert pivot_transform(M, (0, 1)) == read_matrix(A)


def test_floats_are_the_binary_rationals_they_are():
    """0.1 * 10 rounds to 1 in doubles, but the double 0.1 is more than 1/10, so that det = 1 - 10 * 0.1 < 0."""
    assert 1 - 10 * 0.1 == 0
    assert classes.check([[1, 0.1], [10, 1]], "P0").holds is False
    assert classes.check([[1, "1/10"], [10, 1]], "P0").holds is True
    assert classes.check(np.array([[1, 0.1], [10, 1]], dtype=np.float32), "P0").holds is False
    assert classes.check(np.array([[1, 2], [3, 7]], dtype=np.uint8, order="F"), "P").holds is True
    assert classes.check([[Fraction(1, 3), 0], [0, True]], "PD").holds is True


@pytest.mark.parametrize(
    ("A", "error", "text"),
    [
        ([[1, float("nan")], [0, 1]], errors.NotFiniteError, r"A\[0, 1\] = nan"),
        ([[1, 2], [float("inf"), 1]], errors.NotFiniteError, r"A\[1, 0\] = inf"),
        ([[1, 2], [3]], errors.ShapeError, "row 1"),
        ([[1, 2, 3], [3, 4, 5]], errors.ShapeError, "2 rows"),
        ([], errors.ShapeError, "order 0"),
        (np.zeros((2, 2), complex), errors.DTypeError, "complex"),
        ([[1, 2j], [0, 1]], errors.DTypeError, r"A\[0, 1\]"),
        ([["x", 1], [0, 1]], errors.DTypeError, r"A\[0, 0\]"),
        ([[None]], errors.DTypeError, r"A\[0, 0\]"),
        (np.zeros(4), errors.ShapeError, "2 dimensions"),
        (3, errors.ShapeError, "sequence"),
    ],
)
def test_bad_matrices_name_the_place(A, error, text):
    with pytest.raises(error, match=text):
        classes.check(A, "P")


def test_unknown_class_and_bad_options():
    with pytest.raises(errors.UnknownNameError, match="'E7'"):
        classes.check([[1]], "E7")
    with pytest.raises(errors.OptionError, match="time_limit"):
        classes.check([[1]], "P", time_limit=-1)
    with pytest.raises(errors.OptionError, match="threads"):
        lcpstar.classify([[1]], threads=0)
    with pytest.raises(errors.TooLargeError, match="n <= 10"):
        classes.check(np.eye(11), "Q")


def test_spellings_and_names_are_the_same_check():
    A = [[0, 1, 1], [2, 0, 2], [-2, -4, 0]]
    assert lcpstar.is_semimonotone_star(A).symbol == classes.check(A, "E0^s").symbol == "E0s"
    assert classes.check(A, "t-E0s").holds is lcpstar.is_tilde_semimonotone_star(A).holds is True
    assert "semimonotone star" in str(lcpstar.is_semimonotone_star(A))
    for which in classes.CLASSES.values():
        assert which.check(A).symbol == which.symbol
        assert which.check.__doc__


def hard_matrix(n=30):
    """Triangular with ones: P and E0, but neither definite nor dominant, so that every subset is visited."""
    return np.triu(np.full((n, n), 7, dtype=int), 1) + np.eye(n, dtype=int)


def test_time_limit_leaves_the_verdict_open_and_says_how_far_it_got():
    start = time.perf_counter()
    verdict = classes.check(hard_matrix(), "E0", time_limit=0.2)
    assert time.perf_counter() - start < 2
    assert verdict.holds is None
    assert verdict.check() is None
    assert 0 < verdict.cost.done < verdict.cost.total == 2**30 - 1
    assert str(verdict.cost.done) in verdict.reason
    with pytest.raises(ValueError, match="undecided"):
        bool(verdict)


def test_control_c_stops_a_search():
    code = (
        "import signal, numpy as np, lcpstar\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a shell's background jobs ignore it
        "print('go', flush=True)\n"
        "lcpstar.is_semimonotone(np.triu(np.full((30, 30), 7), 1) + np.eye(30))"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout.readline() == b"go\n"
    time.sleep(0.3)
    start = time.perf_counter()
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=20)
    assert time.perf_counter() - start < 5
    assert b"KeyboardInterrupt" in stderr


def test_large_orders_use_polynomial_tests_and_bounded_searches():
    rng = np.random.default_rng(0)
    S = rng.integers(-2, 3, (20, 20))
    skew = S - S.T
    scaled = skew @ np.diag(rng.integers(1, 9, 20))
    assert classes.check(skew, "P0").holds is True
    assert classes.check(scaled, "P0").holds is True
    assert classes.check(scaled, "P").holds is False
    assert classes.check(hard_matrix(20), "P").holds is True
    nearly = hard_matrix(20)
    nearly[19, 0] = 1
    verdict = classes.check(nearly, "P")
    assert verdict.holds is False
    assert verdict.check() is True
    assert classes.check(hard_matrix(12), "E0").holds is True
    assert classes.check(np.eye(200), "PD").holds is True


def test_classify_closes_under_inclusions_beyond_order_four():
    report = lcpstar.classify(2 * np.eye(7) - np.eye(7, k=1) - np.eye(7, k=-1), time_limit=20)
    assert report["Q"].holds
    assert report["Ec"].holds
    assert report["Q"].check() is not False
    assert report.undecided == ()
    report = lcpstar.classify(-np.eye(6), time_limit=20)
    assert not report["P0"].holds
    assert all(v.check() is True for v in report.values() if v.holds is False)


def test_classify_reports():
    seen = []
    report = lcpstar.classify([[0, 1, 1], [2, 0, 2], [-2, -5, 0]], progress=lambda *a: seen.append(a))
    assert seen[-1][:2] == (43, 43)
    assert list(report) == list(classes.CLASSES)
    assert "tE0s" in report.holds
    assert any("Lemke" in line for line in report.guarantees)
    assert any("interior" in line or "theorem is false without P0" in line for line in report.guarantees)
    assert "E0s" in str(report)
    assert report._repr_html_().startswith("<table>")
    assert report["E0^s"].symbol == "E0s"
    assert set(lcpstar.classify([[1]], ["P", "C0*"])) == {"P", "C0*"}
    threaded = lcpstar.classify([[0, 1, 1], [2, 0, 2], [-2, -5, 0]], threads=2)
    assert {s: v.holds for s, v in threaded.items()} == {s: v.holds for s, v in report.items()}


@pytest.mark.parametrize("A", [[[0, 1, 1], [2, 0, 2], [-2, -4, 0]], [[1, -1], [-1, 1]], np.eye(5), -np.eye(6)])
def test_a_copy_of_a_classification_says_and_proves_the_same(A):
    report = lcpstar.classify(A, time_limit=20)
    for again in (copy.copy, copy.deepcopy, lambda r: pickle.loads(pickle.dumps(r))):
        twin = again(report)
        assert str(twin) == str(report)
        assert (twin.n, twin.seconds, twin.guarantees) == (report.n, report.seconds, report.guarantees)
        for symbol, verdict in report.items():
            assert type(twin[symbol]) is classes.Verdict
            assert twin[symbol].check() is verdict.check()
            assert repr(twin[symbol].witness) == repr(verdict.witness)


def test_what_follows_does_not_contradict_itself_or_what_happens():
    lines = lcpstar.classify([[-1]]).guarantees
    assert any("Chandrasekaran's method finds it" in line for line in lines)
    assert not any("no method" in line for line in lines)
    for q in (-1, 0, 1):
        assert lcpstar.solve([[-1]], [q], method="chandrasekaran").status in ("solved", "infeasible")
    A, q = [[0, 1, 1], [2, 0, 2], [-2, -5, 0]], [-4, -7, 10]
    run = lcpstar.potential_reduction(A, q, z0=[1, 1, 5])
    assert np.abs(np.minimum(run.z, np.array(A) @ run.z + q)).max() < 1e-2
    assert not any("fails" in line for line in lcpstar.classify(A).guarantees)


def test_game_values_prove_themselves():
    for A in random_matrices(80, seed=9):
        game = classes.game([[Fraction(x, 3) for x in row] for row in A])
        assert game.check()
    assert lcpstar.game_value([[4, -3], [-1, 0]], exact=True) == Fraction(-3, 8)
    assert lcpstar.game_value([[0.5]]) == 0.5


def test_solution_set_of_the_numerical_example():
    A, q = [[0, 1, 1], [2, 0, 2], [-2, -5, 0]], [-4, -7, 10]
    found = lcpstar.solution_set(A, q)
    points = {z for face in found.faces for z in face.vertices}
    assert points == {(Fraction(15, 14), Fraction(11, 7), Fraction(17, 7)), (5, 0, 4), (0, 2, Fraction(7, 2))}
    assert (found.finite, found.bounded, found.connected, found.convex) == (True, True, False, False)
    local = found.local((5, 0, 4))
    assert (local.locally_unique, local.strongly_stable, local.stable) == (True, True, True)
    with pytest.raises(errors.OptionError, match="must solve"):
        found.local((1, 1, 1))


def test_solution_sets_with_rays_and_fractions():
    whole = lcpstar.solution_set([[0, 0], [0, 0]], [0, 0])
    assert (whole.bounded, whole.convex, whole.connected, whole.finite) == (False, True, True, False)
    assert not whole.local([1, 0]).locally_unique
    assert lcpstar.solution_set([[0]], [-1]).empty
    half = lcpstar.solution_set([["1/3"]], ["-1/7"])
    assert half.faces[-1].vertices == ((Fraction(3, 7),),)
    # z = 0 with w = 0 for A = [-1], q = 0 is isolated but not strongly stable: q = 1 has two solutions nearby.
    point = lcpstar.solution_set([[-1]], [0]).local([0])
    assert (point.locally_unique, point.strongly_stable, point.stable) == (True, False, None)
    # The paper's theorem alone: E, so tE0s and v > 0; z = 0 is the only solution for q = 0, and A is not P.
    only = lcpstar.solution_set([[1, 2], [2, 1]], [0, 0]).local([0, 0])
    assert (only.locally_unique, only.strongly_stable, only.stable) == (True, False, True)


def test_solution_set_bounded_inside_the_cone_for_the_tilde_class():
    """For tE0s the set is bounded for every q in the interior of pos(I, -A), against the paper's remark."""
    rng = random.Random(1)
    tried = 0
    for A in random_matrices(200, sizes=(2, 3), seed=12):
        if classes.check(A, "tE0s") and not classes.check(A, "R0"):
            tried += 1
            n = len(A)
            z, w = [rng.randint(1, 4) for _ in range(n)], [rng.randint(1, 4) for _ in range(n)]
            q = [w[i] - sum(A[i][j] * z[j] for j in range(n)) for i in range(n)]
            assert lcpstar.solution_set(A, q).bounded
    assert tried > 10


def test_command_line(tmp_path, capsys):
    import argparse

    parser = argparse.ArgumentParser()
    classes.add_classify_parser(parser.add_subparsers())
    (tmp_path / "a.json").write_text('{"A": [["1/3", 1], [-1, 0]]}')
    (tmp_path / "a.csv").write_text("1/3,1\n-1,0\n")
    (tmp_path / "a.mtx").write_text("%%MatrixMarket matrix array real general\n% c\n2 2\n0.5\n-1\n1\n0\n")
    np.savez(tmp_path / "a.npz", A=np.array([[0.5, 1], [-1, 0]]))
    for name in ("a.json", "a.csv", "a.mtx", "a.npz"):
        args = parser.parse_args(["classify", str(tmp_path / name), "--classes", "PSD", "P", "--json"])
        assert args.run(args) == 0
        out = json.loads(capsys.readouterr().out)
        assert out["classes"]["PSD"]["holds"] is True
        assert out["classes"]["P"]["witness"]["alpha"] == [1]
    args = parser.parse_args(["classify", str(tmp_path / "a.json")])
    assert args.run(args) == 0
    assert "PSD" in capsys.readouterr().out
    args = parser.parse_args(["classify", str(tmp_path / "missing.json")])
    with pytest.raises(errors.FileFormatError):
        args.run(args)
