"""Pictures: every figure is drawn and written; what they show is computed right. Without matplotlib: one clear line."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from lcpstar import cones, plots
from lcpstar.bench import drift, families, methods, tradeoff
from lcpstar.bench.table import write_rows
from lcpstar.errors import OptionError, ShapeError
from test_bench_cli import command, row

HINT = "matplotlib is not installed: pip install 'lcpstar[plot]'"


@pytest.fixture(scope="module")
def rows():
    entries = methods.chosen(["auto", "lemke", "interior_point, no finish"])
    return list(tradeoff.run(["random_spd", "condition_number", "mass_ratio"], entries, quick=True, budget=1.0))


def test_every_figure_is_written_and_small(rows, tmp_path):
    pytest.importorskip("matplotlib", reason=HINT)
    drawn = plots.figures(rows)
    assert set(drawn) == {"work_precision_random_spd_cold", "work_precision_random_spd_warm", "profiles", "success_map"}
    for name, figure in drawn.items():
        path = plots.save(figure, tmp_path / f"{name}.png")
        assert path.read_bytes()[:4] == b"\x89PNG"
        assert 3_000 < path.stat().st_size < 120_000
    svg = plots.save(drawn["profiles"], tmp_path / "profiles.svg")
    assert "<svg" in svg.read_text()
    with pytest.raises(OptionError):
        plots.save(drawn["profiles"], tmp_path / "profiles.exe")


def test_lines_hold_the_measured_points(rows):
    pytest.importorskip("matplotlib", reason=HINT)
    figure = plots.work_precision(rows, "random_spd")
    line = next(line for line in figure.axes[0].lines if line.get_linestyle() == "--")
    measured = [
        r for r in rows if r.method == "interior_point, no finish" and r.family == "random_spd" and r.start == "cold"
    ]
    assert line.get_xdata().tolist() == [max(min(r.residual, 1.0), 1e-17) for r in measured]
    assert line.get_ydata().tolist() == [r.seconds for r in measured]
    names = {text.get_text() for text in figure.axes[0].texts}
    assert names == {"auto", "lemke", "interior_point, no finish"}
    with pytest.raises(OptionError, match="nonsense"):
        plots.work_precision(rows, "nonsense")


def test_profile_counts_by_hand():
    first = [row("auto", 2e-6, 1e-9), row("lemke", 1e-6, 1e-9), row("pgs", 1e-7, 1e-1)]
    second = [row("auto", 3e-6, 1e-9), row("lemke", 9e-6, 1e-9), row("pgs", 1e-6, 1e-4)]
    names = ["auto", "lemke", "pgs"]
    ratios = {name: plots.profile([first, second], name, names, 1e-3) for name in names}
    assert ratios["auto"] == [pytest.approx(2.0), pytest.approx(3.0)]
    assert ratios["lemke"] == [pytest.approx(1.0), pytest.approx(9.0)]
    assert ratios["pgs"] == [math.inf, pytest.approx(1.0)]


def test_labels_do_not_touch():
    placed = plots.spread([0.99, 0.99, 1.0, 1.0], 0.05)
    assert np.all(np.diff(placed) >= 0.05 - 1e-12)
    assert placed[-1] <= 1.0


def test_every_method_of_the_table_has_a_line_of_its_own():
    assert set(methods.NAMES) <= set(plots.STYLES)
    looks = [(colour, dash) for colour, dash, _ in plots.STYLES.values()]
    assert len(set(looks)) == len(looks)


@pytest.mark.parametrize(
    ("A", "q", "expected"),
    [
        ([[1, 2], [2, 1]], [-3, -4], [(0,), (1,), (0, 1)]),  # three solutions
        ([[2, 1], [1, 2]], [-5, -6], [(0, 1)]),  # a P-matrix: one cone
        ([[2, 1], [1, 2]], [1, 2], [()]),
        ([[1, -1], [-1, 1]], [-1, -1], []),  # infeasible
        ([[0, 0], [0, 1]], [0, -1], [(1,), (0, 1)]),  # a zero column: the boundary belongs to both cones
    ],
)
def test_cones_that_hold_q_are_the_supports_of_the_solutions(A, q, expected):
    G = {alpha: cones.generators(np.array(A, float), alpha) for alpha in [(), (0,), (1,), (0, 1)]}
    assert [alpha for alpha, g in G.items() if cones.in_cone(g, np.array(q, float))] == expected


def test_picture_of_order_two(tmp_path):
    pytest.importorskip("matplotlib", reason=HINT)
    figure = cones.picture([[1, 2], [2, 1]], [-3, -4])
    assert figure.axes[0].get_title() == "q lies in 3 of 4 complementary cones"
    assert figure.axes[1].get_title() == "3 faces of solutions in FEA(q, A)"
    assert {"(0, 4)", "(3, 0)", "(1.667, 0.6667)"} <= {text.get_text() for text in figure.axes[1].texts}
    with pytest.raises(ShapeError):
        cones.picture(np.eye(3), np.ones(3))
    for A, q in (([[1, -1], [-1, 1]], [-1, 1]), ([[0, 0], [0, 0]], [0, 0]), ([[-1, 0], [0, -1]], [-1, -1])):
        plots.save(cones.picture(A, q), tmp_path / "p.png")


def test_drift_picture(tmp_path):
    pytest.importorskip("matplotlib", reason=HINT)
    step = drift.Step("auto", 0.016, 10, 1e6, 1, 1e-9, 0.0, 1e-12, 1, 1e-3, 2e-3)
    steps = [replace(step, step=k) for k in range(1, 20)]
    steps += [replace(step, method="lemke", step=k, drift=1e-3 * 10**k) for k in range(1, 5)]
    drift.write_steps(tmp_path / "drift.csv", steps)
    run = command("plot", tmp_path / "drift.csv")
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "drift.png").stat().st_size > 3_000
    left, right = plots.drift(steps).axes
    assert left.lines[1].get_ydata().tolist() == pytest.approx([0.01, 0.1, 1.0, 10.0])
    assert [text.get_text() for text in right.get_yticklabels()] == ["lemke", "auto"]
    with pytest.raises(OptionError):
        plots.drift([])


def test_command_line(rows, tmp_path):
    pytest.importorskip("matplotlib", reason=HINT)
    write_rows(tmp_path / "t.csv", rows)
    run = command("plot", tmp_path / "t.csv", "--out", tmp_path / "pictures", "--svg")
    assert run.returncode == 0, run.stderr
    assert len(run.stdout.splitlines()) == len(list((tmp_path / "pictures").glob("*.svg"))) == 4
    (tmp_path / "p.json").write_text(json.dumps({"A": [[1, 2], [2, 1]], "q": [-3, -4]}))
    assert command("plot", tmp_path / "p.json").returncode == 0
    assert (tmp_path / "p.png").stat().st_size > 3_000


def test_bad_files_give_status_2_and_one_line(tmp_path):
    (tmp_path / "p.json").write_text(json.dumps({"A": np.eye(3).tolist(), "q": [1, 2, 3]}))
    (tmp_path / "matrix.json").write_text(json.dumps({"A": [[1]]}))
    (tmp_path / "t.csv").write_text("family,problem\n1,2\n")
    for name in ("p.json", "matrix.json", "none.csv", "t.csv"):
        run = command("plot", tmp_path / name)
        assert (run.returncode, len(run.stderr.splitlines())) == (2, 1), run.stderr


def test_without_matplotlib_the_message_holds_the_command(tmp_path):
    (tmp_path / "p.json").write_text(json.dumps({"A": [[1, 2], [2, 1]], "q": [-3, -4]}))
    hidden = (
        "import sys; sys.modules['matplotlib'] = None; from lcpstar.__main__ import main; sys.exit(main(sys.argv[1:]))"
    )
    run = subprocess.run(
        [sys.executable, "-c", hidden, "plot", str(tmp_path / "p.json")], capture_output=True, text=True, check=False
    )
    assert run.returncode == 2
    assert run.stderr == "lcpstar: plots need matplotlib: pip install 'lcpstar[plot]'\n"


def test_titles_name_every_family():
    assert set(families.NAMES) == set(families.TITLES)
