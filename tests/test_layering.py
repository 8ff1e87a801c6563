"""No circle between files, crates point one way, and the bindings see the doors of lcpstar alone."""

from __future__ import annotations

import re

import imports
from imports import ROOT


def shown(circles):
    return [sorted(str(file.relative_to(ROOT)) for file in circle) for circle in circles]


def test_no_circle_between_rust_files():
    graph = imports.Rust().graph()
    assert sum(map(len, graph.values())) > len(graph) > 180
    assert shown(imports.circles(graph)) == []


def test_no_circle_between_python_files():
    graph = imports.Python(ROOT / "python" / "lcpstar").graph()
    assert sum(map(len, graph.values())) > len(graph) > 70
    assert shown(imports.circles(graph)) == []


def dependencies(toml):
    """The name of a crate and the crates that it needs."""
    text = toml.read_text(encoding="utf-8")
    section = re.search(r"^\[dependencies\]\n(.*?)(?:^\[|\Z)", text, re.DOTALL | re.MULTILINE)[1]
    return re.search(r'^name = "(.*)"', text, re.MULTILINE)[1], set(re.findall(r"^([\w-]+)", section, re.MULTILINE))


def test_crates_point_one_way():
    allowed = {
        "lcpstar-linalg": set(),
        "lcpstar-exact": set(),
        "lcpstar-kernels": set(),
        "lcpstar": {"lcpstar-linalg", "lcpstar-exact", "lcpstar-kernels"},
        "lcpstar-py": {"lcpstar"},
        "lcpstar-referee": {"lcpstar"},
        "lcpstar-stress": {"lcpstar", "lcpstar-referee"},
    }
    for toml in (ROOT / "rust").glob("*/Cargo.toml"):
        name, needed = dependencies(toml)
        assert {x for x in needed if x.startswith("lcpstar")} <= allowed[name], toml


def test_bindings_have_no_arithmetic_of_their_own():
    """Arrays in, arrays out: no linear algebra, no random numbers, no threads, no tolerance."""
    assert dependencies(ROOT / "rust/lcpstar-py/Cargo.toml")[1] == {"lcpstar", "num-bigint", "pyo3", "numpy"}
    for file in (ROOT / "rust/lcpstar-py/src").glob("*.rs"):
        text = imports.code(file.read_text(encoding="utf-8"))
        inner = ("linalg", "small", "pivoting::basis", "presolve", "judge", "verdict::", "residual::", "scaling")
        assert not [room for room in inner if f"lcpstar::{room}" in text], file
        assert not re.findall(r"\b\d+(?:\.\d+)?e-?\d+\b", text), file


def test_no_file_is_longer_than_450_lines():
    found = [file for folder in ("rust", "python", "fuzz", "tests", "benches") for file in (ROOT / folder).rglob("*.*")]
    own = [file for file in found if file.suffix in {".rs", ".py"} and "target" not in file.parts]
    long = {str(file.relative_to(ROOT)) for file in own if len(file.read_text(encoding="utf-8").splitlines()) > 450}
    assert len(own) > 300
    assert long == set()


def test_methods_import_no_other_method():
    graph, methods = imports.Rust().graph(), ROOT / "rust" / "lcpstar" / "src" / "methods"

    def method(file):
        return file.relative_to(methods).parts[0].removesuffix(".rs")

    inside = {file: [target for target in graph[file] if methods in target.parents] for file in graph}
    pairs = {(method(file), method(target)) for file in graph if methods in file.parents for target in inside[file]}
    assert {(a, b) for a, b in pairs if a != b} == set()
    for file in graph:
        text = imports.code(file.read_text(encoding="utf-8"))
        assert methods not in file.parents or not re.search(r"crate::(judge|verdict|driver)\b", text), file


def test_libraries_of_linear_algebra_are_named_in_one_room():
    for file in (ROOT / "rust").glob("*/src/**/*.rs"):
        if re.search(r"\b(faer|nalgebra)::", imports.code(file.read_text(encoding="utf-8"))):
            assert str(file.relative_to(ROOT / "rust")).startswith("lcpstar-linalg/src/backend")
