"""The command line: exit statuses, machine-readable output, hostile files."""

from __future__ import annotations

import json
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

A = [[0, 1, 1], [2, 0, 2], [-2, -5, 0]]
Q = [-4, -7, 10]


def lcpstar(*arguments):
    command = [sys.executable, "-m", "lcpstar", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)


@pytest.fixture
def files(tmp_path):
    (tmp_path / "p.json").write_text(json.dumps({"A": A, "q": Q}))
    np.savez(tmp_path / "p.npz", A=np.array(A, float), q=np.array(Q, float))
    entries = [(i + 1, j + 1, A[i][j]) for i in range(3) for j in range(3) if A[i][j]]
    header = f"%%MatrixMarket matrix coordinate real general\n% comment\n3 3 {len(entries)}\n"
    (tmp_path / "p.mtx").write_text(header + "\n".join(f"{i} {j} {x}" for i, j, x in entries))
    (tmp_path / "p.csv").write_text("-4\n-7\n10\n")
    (tmp_path / "matrix.csv").write_text("\n".join(",".join(map(str, row)) for row in A))
    return tmp_path


@pytest.mark.parametrize("arguments", [["p.json"], ["p.npz"], ["p.mtx"], ["matrix.csv", "p.csv"]])
def test_solve_reads_every_kind_of_file(files, arguments):
    run = lcpstar("solve", *(files / name for name in arguments), "--json")
    assert run.returncode == 0, run.stderr
    result = json.loads(run.stdout)
    w = np.array(A) @ result["z"] + Q
    assert result["status"] == "solved"
    assert np.abs(np.minimum(result["z"], w)).max() < 1e-12
    assert lcpstar("solve", *(files / name for name in arguments)).stdout.startswith("status            solved")


def test_paper_shows_the_misprint_of_row_97():
    run = lcpstar("paper")
    assert run.returncode == 0
    assert "psi printed    1.1684   recomputed 1.1416" in run.stdout
    assert "(0, 2, 7/2), not in the paper" in run.stdout
    assert "[[0, -1], [0, 0]]; 2 of 62 fail" in run.stdout  # claim F7, found by search


def test_classify_and_explore(tmp_path):
    (tmp_path / "A.json").write_text('{"A": [[0, -1], [0, 0]]}')
    run = lcpstar("classify", tmp_path / "A.json")
    assert run.returncode == 0, run.stderr
    assert "E0s" in run.stdout
    run = lcpstar("explore", "P0 => tE0s", "-n", "2")
    assert "[[0, -1], [0, 0]]" in run.stdout, run.stderr


def test_exit_status_one_when_not_solved(tmp_path):
    (tmp_path / "p.json").write_text('{"A": [[-1]], "q": [-1]}')
    run = lcpstar("solve", tmp_path / "p.json", "--json")
    assert run.returncode == 1
    result = json.loads(run.stdout)
    assert result["status"] == "infeasible"
    assert Fraction(result["certificate"]["y"][0]) > 0


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("p.json", b"{"),
        ("p.json", b"[1, 2]"),
        ("p.json", b'{"A": [[1, 2], [3]], "q": [1, 2]}'),
        ("p.json", b'{"A": [[1]], "q": ["x"]}'),
        ("p.json", b'{"A": [[1]]}'),
        ("p.json", b"[" * 100_000),
        ("p.json", b'{"A": [[NaN]], "q": [1]}'),
        ("p.npz", b"not a zip file"),
        ("p.mtx", b"%%MatrixMarket matrix coordinate real general\n1000000000 1000000000 1\n1 1 1\n"),
        ("p.mtx", b"%%MatrixMarket matrix coordinate real general\n2 2 1\n3 1 1\n"),
        ("p.mtx", b"%%MatrixMarket matrix array complex general\n1 1\n1 2\n"),
        ("p.mtx", b"\xff\xfe"),
        ("p.csv", b"1,2\n3\n"),
        ("p.txt", b"1"),
    ],
)
def test_hostile_files_give_status_2_and_one_line(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    run = lcpstar("solve", tmp_path / name)
    assert run.returncode == 2
    assert run.stdout == ""
    assert len(run.stderr.splitlines()) == 1
    assert run.stderr.startswith("lcpstar: ")


def test_pickles_are_refused(tmp_path):
    np.savez(tmp_path / "p.npz", A=np.array([[print]], dtype=object), q=np.array([1.0]))
    run = lcpstar("solve", tmp_path / "p.npz")
    assert (run.returncode, len(run.stderr.splitlines())) == (2, 1)


def test_sizes_are_checked_before_memory_is_taken(tmp_path):
    import zipfile

    with zipfile.ZipFile(tmp_path / "p.npz", "w") as archive, archive.open("A.npy", "w") as member:
        header = {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**6)}
        np.lib.format.write_array_header_1_0(member, header)
    run = lcpstar("solve", tmp_path / "p.npz")
    assert (run.returncode, len(run.stderr.splitlines())) == (2, 1)


def test_missing_file_and_unknown_method(files):
    assert lcpstar("solve", files / "none.json").returncode == 2
    assert lcpstar("solve", files / "p.json", "--method", "nonsense").returncode == 2
    assert lcpstar("nonsense").returncode == 2


def test_every_method_of_the_core_is_listed_and_documented():
    from lcpstar import _core, solve

    listed = lcpstar("solve", "--help").stdout
    assert "auto" in _core.METHODS
    for method in _core.METHODS:
        assert method in listed
        assert f'"{method}"' in solve.__doc__
