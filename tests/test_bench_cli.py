"""`lcpstar bench`: the yardstick is independent and right, the table is sane, exit statuses are the command line's."""

from __future__ import annotations

import csv
import math
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import lcpstar
from lcpstar import problems
from lcpstar.bench import drift, families, methods, report, table, tradeoff
from lcpstar.bench.measure import Yardstick, affine
from lcpstar.errors import FileFormatError, UnknownNameError


def command(*arguments):
    run = [sys.executable, "-m", "lcpstar", *map(str, arguments)]
    return subprocess.run(run, capture_output=True, text=True, check=False, timeout=300)


def row(method, seconds, residual, tol=1e-3, problem="16", status="solved", family="random_spd"):
    solved = int(status == "solved")
    return table.Row(
        family,
        problem,
        16,
        math.nan,
        method,
        "cold",
        tol,
        1,
        solved,
        seconds,
        residual,
        residual,
        3,
        status,
        method,
    )


def test_affine_is_exact_to_the_last_digits_where_everything_cancels():
    rng = np.random.default_rng(3)
    A = rng.standard_normal((9, 9)) * 10.0 ** rng.uniform(-6, 6, (9, 9))
    z = rng.standard_normal(9)
    q = -(A @ z)
    exact = [
        sum((Fraction(a) * Fraction(x) for a, x in zip(r, z, strict=True)), Fraction(b))
        for r, b in zip(A, q, strict=True)
    ]
    size = np.abs(A) @ np.abs(z) + np.abs(q)
    # A plain product is wrong by about eps |A||z|, all of w here; twice the precision leaves eps^2 of that.
    assert np.all(
        np.abs(affine(A, z, q) - np.array(exact, float)) <= 1e-29 * size + 2.3e-16 * np.abs(np.array(exact, float))
    )
    assert np.any(np.abs(A @ z + q - np.array(exact, float)) > 1e-18 * size)


@pytest.mark.parametrize("family", [name for name in families.NAMES if name != families.CORPUS_CONTACT])
def test_the_recomputed_residual_is_the_stated_one(family):
    group = next(iter(families.groups(family, quick=True)))
    for A, q in group.instances:
        yardstick = Yardstick(A, q)
        solution = lcpstar.solve(A, q, "interior_point", tol=1e-4, options=lcpstar.InteriorPointOptions(finish=False))
        assert yardstick.residual(solution.z) == pytest.approx(solution.residual, rel=1e-9, abs=1e-17)
        assert yardstick.natural(solution.z) == pytest.approx(solution.natural_residual, rel=1e-9, abs=1e-300)
        fast = lcpstar.solve(A, q)  # the kernel for small problems measures with plain sums
        rounding = (len(q) + 2) * np.finfo(float).eps * (np.abs(A) @ fast.z + np.abs(q)).max()
        assert abs(yardstick.natural(fast.z) - fast.natural_residual) <= rounding
        assert abs(yardstick.residual(fast.z) - fast.residual) <= (len(q) + 2) ** 2 * np.finfo(float).eps


def test_a_point_that_is_not_finite_has_an_infinite_residual():
    A, q = problems.random_spd(4, 0)
    assert Yardstick(A, q).residual(np.array([1.0, np.nan, 0.0, 0.0])) == np.inf


def test_the_american_put_is_an_m_matrix_whose_price_stays_above_the_payoff():
    A, q = families.american_put(40, 1)
    assert lcpstar.is_z(A[:6, :6].tolist())
    assert (np.linalg.inv(A) >= -1e-15).all()
    solution = lcpstar.solve(A, q)
    assert solution.success
    assert 0 < np.count_nonzero(solution.z) < 40


def test_the_step_before_stays_feasible():
    A, q = problems.psd_half_rank(24, 5)
    before, raised = families.previous_step(A, q, 0)
    assert before is A
    assert (raised >= q).all()
    assert lcpstar.solve(A, raised).success


def test_quick_run_writes_sane_rows(tmp_path):
    run = command(
        "bench", "tradeoff", "--quick", "--families", "random_spd", "mass_ratio", "--methods", "auto", "lemke",
        "interior_point, no finish", "--out", tmp_path / "out", "--budget", "5",
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    rows = table.read_rows(tmp_path / "out" / "tradeoff.csv")
    assert {r.family for r in rows} == {"random_spd", "mass_ratio"}
    assert {r.method for r in rows} == {"auto", "lemke", "interior_point, no finish"}
    assert {r.start for r in rows} == {"cold", "warm"}
    assert {r.tol for r in rows if r.family == "random_spd"} == set(tradeoff.QUICK_TOLERANCES)
    for r in rows:
        assert 0 < r.seconds < 10
        assert r.solved <= r.instances
        assert r.answered_by
        assert r.solved < r.instances or r.residual <= r.tol
        assert r.residual <= r.stated * (1 + 1e-3) + 1e-16  # four digits are written
    loose, tight = (
        next(r for r in rows if r.method == "interior_point, no finish" and r.tol == tol and r.start == "cold")
        for tol in (1e-2, 1e-12)
    )
    assert tight.residual < loose.residual
    assert tight.iterations > loose.iterations
    text = (tmp_path / "out" / "tradeoff.md").read_text()
    assert "recomputed residual exceeds tol: 0." in text


def test_single_precision_and_proof_are_rungs_of_one_ladder():
    A, q = problems.random_spd(16, 1)
    yardstick = Yardstick(A, q)
    residuals = {}
    for entry in methods.chosen(["auto", "auto, float32", "auto, exact"]):
        solution = entry.call(A, q, 1e-9, None, None)()
        residuals[entry.rung] = yardstick.residual(solution.z)
        assert solution.certificate.exact == (entry.rung == "exact")
    assert residuals["float64"] < 1e-13
    assert residuals["exact"] < 1e-13
    assert 1e-10 < residuals["float32"] < 1e-5


def test_rows_survive_the_file_and_other_files_are_refused(tmp_path):
    rows = [row("auto", 1e-5, 1e-16), row("lemke", 2e-5, 1e-4, status="time_limit")]
    table.write_rows(tmp_path / "t.csv", rows)
    assert table.is_table(tmp_path / "t.csv")
    back = table.read_rows(tmp_path / "t.csv")
    assert [(r.method, r.seconds, r.residual, r.status) for r in back] == [
        ("auto", 1e-5, 1e-16, "solved"),
        ("lemke", 2e-5, 1e-4, "time_limit"),
    ]
    (tmp_path / "other.csv").write_text("1,2\n3,4\n")
    assert not table.is_table(tmp_path / "other.csv")
    with pytest.raises(FileFormatError):
        table.read_rows(tmp_path / "other.csv")
    lines = (tmp_path / "t.csv").read_text().splitlines()
    (tmp_path / "cut.csv").write_text(lines[0] + "\n" + lines[1][:20] + "\n")
    with pytest.raises(FileFormatError):
        table.read_rows(tmp_path / "cut.csv")


def test_ratios_count_what_was_achieved_not_what_was_asked():
    rows = [row("auto", 4e-6, 1e-16), row("lemke", 2e-6, 1e-15), row("block_pivoting", 1e-6, 0.1)]
    assert table.best_single(rows, 1e-3, methods.SINGLE) == ("lemke", 2e-6)
    assert report.auto_ratios([rows], 1e-3) == [pytest.approx(2.0)]
    assert report.auto_ratios([[row("auto", 1e-6, 0.5), rows[1]]], 1e-3) == [math.inf]
    assert table.best_single(rows[2:], 1e-3, methods.SINGLE) == ("", math.inf)


@pytest.mark.parametrize(("budget", "outcome"), [(500, "stands"), (1e-6, "fallen at step")])
def test_a_light_stack_stands_and_falls_without_time_to_solve(tmp_path, budget, outcome):
    run = command(
        "bench", "drift", "--boxes", "3", "--mass-ratio", "10", "--steps", "30", "--budget-ms", budget,
        "--methods", "interior_point", "auto, exact", "--out", tmp_path,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    runs = drift.by_method(drift.read_steps(tmp_path / "drift.csv"))
    assert list(runs) == ["interior_point"]  # the rungs of auto are not compared
    steps = runs["interior_point"]
    assert [step.step for step in steps] == list(range(1, 31))
    assert f"| interior_point | {outcome}" in (tmp_path / "drift.md").read_text()
    if outcome == "stands":
        assert all(step.solved and step.drift < 1e-6 for step in steps)
    else:
        assert not any(step.solved for step in steps)
        assert max(step.drift for step in steps) > drift.FALLEN


def test_drift_written_in_part_keeps_the_last_step(tmp_path):
    step = drift.Step("auto", 0.016, 10, 1e6, 1, 1e-9, 0.0, 1e-12, 1, 1e-3, 2e-3)
    steps = [replace(step, step=k) for k in range(1, 26)]
    drift.write_steps(tmp_path / "d.csv", steps, every=10)
    assert [s.step for s in drift.read_steps(tmp_path / "d.csv")] == [10, 20, 25]
    assert drift.is_drift(tmp_path / "d.csv")
    assert not table.is_table(tmp_path / "d.csv")
    (tmp_path / "other.csv").write_text("method,step\nauto,1\n")
    with pytest.raises(FileFormatError):
        drift.read_steps(tmp_path / "other.csv")


def test_bench_lists_and_bad_names_give_status_2_and_one_line(tmp_path):
    listed = command("bench")
    assert listed.returncode == 0
    assert "tradeoff" in listed.stdout
    assert "call" in listed.stdout
    for arguments in (["--families", "nonsense"], ["--methods", "nonsense"], ["--quick", "--budget", "-1"]):
        run = command("bench", "tradeoff", *arguments, "--out", tmp_path / "none")
        assert (run.returncode, len(run.stderr.splitlines())) == (2, 1), run.stderr
        assert not (tmp_path / "none").exists()
    assert command("bench", "nonsense").returncode == 2
    run = command("bench", "drift", "--steps", "0", "--out", tmp_path / "none")
    assert (run.returncode, len(run.stderr.splitlines())) == (2, 1), run.stderr
    (tmp_path / "file").write_text("")
    run = command("bench", "tradeoff", "--out", tmp_path / "file" / "folder")
    assert (run.returncode, len(run.stderr.splitlines())) == (2, 1), run.stderr


def test_the_corpus_is_asked_for_by_name_only_where_it_is(monkeypatch):
    monkeypatch.delenv("LCPSTAR_CORPUS", raising=False)
    assert families.CORPUS_CONTACT not in families.chosen(None)
    with pytest.raises(UnknownNameError, match="LCPSTAR_CORPUS"):
        families.chosen([families.CORPUS_CONTACT])


def test_corpus_groups_hold_contact_problems(corpus):
    groups = list(families.groups(families.CORPUS_CONTACT, quick=False))
    assert len(groups) >= 20
    assert all(np.isfinite(A).all() and A.shape == (len(q), len(q)) for g in groups for A, q in g.instances)


def test_bench_call_prints_a_table():
    run = command("bench", "call", "--quick")
    assert run.returncode == 0, run.stderr
    lines = [line for line in run.stdout.splitlines() if line.startswith(("random", "stack", "contacts"))]
    assert len(lines) == 6
    assert all(" us" in line for line in lines)


def test_the_csv_is_plain(tmp_path):
    table.write_rows(tmp_path / "t.csv", [row("auto", 1.23456789e-5, 1e-16)])
    with (tmp_path / "t.csv").open() as file:
        record = next(csv.DictReader(file))
    assert record["seconds"] == "1.235e-05"
    assert record["parameter"] == "nan"
