"""docs/methods.md lists all cut-overs, as the sources have them, each with a record that is there."""

from __future__ import annotations

import re

import imports
from imports import ROOT

LINE = re.compile(r"/// (.+) (Record: `(\w+\.md)`|Not recorded)\.\npub const (\w+): usize = ([\d_]+);")
NAME = re.compile(r"\bconst (\w*(?:UP_TO|_FROM|_ABOVE|_ORDER)|CUT_OVER): usize")


def cutovers():
    for crate in ("lcpstar", "lcpstar-kernels", "lcpstar-linalg", "lcpstar-exact"):
        text = (ROOT / "rust" / crate / "src" / "cutovers.rs").read_text(encoding="utf-8")
        found = LINE.findall(text)
        assert len(found) == text.count("pub const")
        yield from found


def test_the_documented_table_is_that_of_the_sources():
    rows = [f"| `{name}` | {value} | {doc} | {record or 'none'} |" for doc, _, record, name, value in cutovers()]
    shown = re.search(
        r"<!-- cut-overs -->\n(.*?)\n<!-- end -->", (ROOT / "docs/methods.md").read_text("utf-8"), re.DOTALL
    )
    assert shown[1].splitlines()[2:] == rows


def test_records_name_a_file_that_is_there():
    assert all((ROOT / "benches" / "record" / record).exists() for _, _, record, _, _ in cutovers() if record)


def test_no_cut_over_stands_elsewhere():
    limits = {"MAX_ORDER", "CLASSES_UP_TO", "SMALL_ORDER"}  # what is refused, and the order of minors that come first
    for file in (ROOT / "rust").glob("*/src/**/*.rs"):
        if file.name != "cutovers.rs" and "stress" not in file.parts:
            names = set(NAME.findall(imports.code(file.read_text(encoding="utf-8"))))
            assert names <= limits, file
