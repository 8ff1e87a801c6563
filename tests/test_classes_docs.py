"""The sessions in the documentation are what the library prints."""

import doctest
import importlib
import pathlib

import pytest

DOCS = pathlib.Path(__file__).parent.parent / "docs"


def test_session_of_a_theorist():
    failed, attempted = doctest.testfile(str(DOCS / "classes.md"), module_relative=False)
    assert (failed, attempted > 10) == (0, True)


@pytest.mark.parametrize(
    "name", ["classes.registry", "classes.report", "classes.game", "classes.solution_set", "exploring"]
)
def test_docstrings(name):
    failed, attempted = doctest.testmod(importlib.import_module(f"lcpstar.{name}"))
    assert (failed, attempted > 0) == (0, True)


def test_every_class_is_documented():
    from lcpstar.classes import CLASSES

    text = (DOCS / "classes.md").read_text().replace("\\*", "*")
    for symbol in CLASSES:
        assert symbol.removeprefix("almost") in text
    assert next(iter(CLASSES)) == "PD"
    assert len(CLASSES) == 43
