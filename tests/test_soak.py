"""The soak run in small: the same checks as `make soak`, a few seconds long."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

import pytest

SOAK = Path(__file__).parents[1] / "benches" / "soak.py"
needs_linux = pytest.mark.skipif(
    not Path("/proc/self/statm").exists() or not hasattr(os, "fork"), reason="needs /proc and fork"
)


@pytest.fixture(scope="module")
def soak():
    spec = importlib.util.spec_from_file_location("soak", SOAK)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@needs_linux
def test_memory_stays_flat(soak):
    assert soak.memory(10_000)


def test_threads_check_their_own_answers_while_shared_arrays_change(soak):
    assert soak.threads(1)


@needs_linux
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*fork:DeprecationWarning")
def test_forked_children_solve_with_threads_again(soak):
    assert soak.forks(3)


def test_an_interrupt_gives_a_whole_answer_or_none(soak):
    assert soak.interrupts(10, seed=1)


def test_the_interpreter_may_end_during_a_batch(soak):
    assert soak.shutdowns(2, seed=1)
