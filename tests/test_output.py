"""Output that nobody takes, and arguments beyond every range: exit status 2 or an answer, one line, no traceback."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.fixture
def problem(tmp_path):
    path = tmp_path / "p.json"
    path.write_text(json.dumps({"A": [[2, 1], [1, 2]], "q": [-5, -6]}))
    return path


def run(arguments, **streams):
    command = [sys.executable, "-m", "lcpstar", *map(str, arguments)]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams}
    return subprocess.run(command, check=False, timeout=120, **streams)


COMMANDS = [
    ["solve", "FILE"],
    ["solve", "FILE", "--json"],
    ["classify", "FILE"],
    ["explore", "P => P0", "-n", "1"],
    ["--help"],
    ["solve", "--help"],
    ["--version"],
]


def commands(problem, which):
    return [str(problem) if word == "FILE" else word for word in which]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
@pytest.mark.parametrize("which", COMMANDS)
def test_a_full_device_is_status_two(problem, which):
    with open("/dev/full", "w") as full:
        found = run(commands(problem, which), stdout=full)
        assert found.returncode == 2
        assert found.stderr.startswith(b"lcpstar: ")
        assert found.stderr.count(b"\n") == 1
        assert run(["solve", "missing.json"], stderr=full).returncode == 2


@pytest.mark.parametrize("which", COMMANDS)
def test_a_closed_pipe_is_status_two(problem, which):
    reader, writer = os.pipe()
    os.close(reader)
    found = run(commands(problem, which), stdout=writer)
    os.close(writer)
    assert found.returncode == 2
    assert b"Traceback" not in found.stderr
    assert b"Exception ignored" not in found.stderr


@pytest.mark.skipif(os.name != "posix", reason="needs a shell")
@pytest.mark.parametrize(("closed", "status"), [(">&-", 2), ("2>&-", 0), (">&- 2>&-", 2)])
def test_closed_streams(problem, closed, status):
    command = f"{sys.executable} -m lcpstar solve {problem} {closed}"
    found = subprocess.run(command, shell=True, check=False, capture_output=True, timeout=120)
    assert found.returncode == status
    assert b"Traceback" not in found.stderr


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["--max-iterations", "99999999999999999999"], 0),
        (["--max-iterations", "-1"], 2),
        (["--max-iterations", "1.5"], 2),
        (["--time-limit", "inf"], 0),
        (["--time-limit", "1e300"], 0),
        (["--time-limit", "nan"], 2),
        (["--time-limit", "-1"], 2),
        (["--tol", "nan"], 2),
        (["--tol", "1e400"], 2),
    ],
)
def test_numbers_beyond_every_range(problem, arguments, status):
    found = run(["solve", problem, *arguments])
    assert found.returncode == status
    assert b"Traceback" not in found.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["--seed", "-1"],
        ["--seed", "99999999999999999999999"],
        ["--threads", "-5"],
        ["-n", "99999999999999999999"],
        ["--entries", "99999999999999999999"],
        ["--time-limit", "nan"],
        ["--samples", "0"],
    ],
)
def test_explore_refuses_numbers_out_of_range(arguments):
    found = run(["explore", "P => P0", *arguments])
    assert found.returncode == 2
    assert b"Traceback" not in found.stderr


def test_a_state_that_cannot_be_written_is_status_two(tmp_path):
    found = run(["explore", "P => P0", "-n", "1", "--state", tmp_path / "none" / "state.json"])
    assert found.returncode == 2
    assert b"Traceback" not in found.stderr
