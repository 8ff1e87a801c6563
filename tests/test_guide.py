"""docs/guide.md: every table in it is what the recorded rows say, and every figure it shows is there."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from lcpstar.bench.table import read_rows

ROOT = Path(__file__).parent.parent
GUIDE = (ROOT / "docs" / "guide.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def tradeoff():
    sys.path.insert(0, str(ROOT / "benches"))
    try:
        import tradeoff
    finally:
        sys.path.remove(str(ROOT / "benches"))
    return tradeoff


def test_tables_are_those_of_the_record(tradeoff):
    rows = read_rows(ROOT / "benches" / "record" / "tradeoff.csv")
    record = (ROOT / "benches" / "record" / "tradeoff.md").read_text(encoding="utf-8")
    shown = dict(re.findall(r"<!-- ([a-z ]+) -->\n(.*?)\n<!-- end -->", GUIDE, re.DOTALL))
    stack = shown.pop("stack")
    assert stack in record
    tables = tradeoff.blocks(rows, stack)
    assert set(shown) <= set(tables)
    for name, table in shown.items():
        assert table == tables[name], name


def test_the_record_has_what_the_plots_promise():
    rows = read_rows(ROOT / "benches" / "record" / "tradeoff.csv")
    assert len({row.family for row in rows}) >= 6
    assert len({row.method for row in rows}) >= 8
    assert {row.start for row in rows} == {"cold", "warm"}
    assert not [
        row for row in rows if row.solved == row.instances and row.residual > row.tol and "float32" not in row.method
    ]


def test_figures_exist():
    names = re.findall(r"\]\((figures/[^)]+)\)", GUIDE)
    assert len(names) >= 5
    for name in names:
        assert 3_000 < (ROOT / "docs" / name).stat().st_size < 120_000
