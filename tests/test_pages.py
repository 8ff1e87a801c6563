"""The Python code on the pages runs, and where it shows results they are what comes out."""

from __future__ import annotations

import doctest
import re
from importlib.util import find_spec

import pytest

from imports import ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)

# What a reader of the page has at hand.
GIVEN = {
    "batch.md": """
import numpy as np, lcpstar
rng = np.random.default_rng(1)
A = rng.normal(size=(6, 4, 4)); A = A @ A.swapaxes(1, 2) + np.eye(4)
q, q_next = rng.normal(size=(2, 6, 4))
A1, q1, A2, q2 = np.eye(2), -np.ones(2), np.eye(3), -np.ones(3)
offsets, A_flat = np.array([0, 2, 5]), np.concatenate([A1.ravel(), A2.ravel()])
q_flat = np.concatenate([q1, q2])
"""
}


def is_installed(block):
    optional = {"dask.array": "dask", "xarray.": "xarray"}
    return all(find_spec(module) for text, module in optional.items() if text in block)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_code_on_the_page(page):
    names = {"__name__": page.stem}
    exec(GIVEN.get(page.name, ""), names)
    for block in BLOCK.findall(page.read_text(encoding="utf-8")):
        if ">>>" in block:
            test = doctest.DocTestParser().get_doctest(block, names, page.name, str(page), 0)
            runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
            runner.run(test, clear_globs=False)
            names |= test.globs
            assert runner.failures == 0, page.name
        elif is_installed(block):
            exec(compile(block, page.name, "exec"), names)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_and_tests_that_are_named_exist(page):
    text = page.read_text(encoding="utf-8")
    named = re.findall(r"`((?:tests|benches|examples|docs|rust|python)/[\w./-]+)`", text)
    assert not [name for name in named if not (ROOT / name).exists()]
    tests = "".join(file.read_text(encoding="utf-8") for file in (ROOT / "tests").glob("test_*.py"))
    assert not [name for name in re.findall(r"`(test_\w+)`", text) if f"def {name}(" not in tests]
