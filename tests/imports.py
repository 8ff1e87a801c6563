"""Which source file names something that which other file defines, in Rust and in Python.

Rust: `use` trees and paths in code (`crate::x::y`, `super::y`, `child::y`) lead to the file that defines what they
name; re-exports and a parent's own imports are followed. A `mod` line and a re-export that its file does not use itself
are no edges; neither are unit tests, and methods, which have no path. Python: imports anywhere in a file, inside
functions and under TYPE_CHECKING too, re-exports followed.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
Graph = dict[Path, set[Path]]

USE = re.compile(r"\b(?P<public>pub(?:\([^)]*\))?\s+)?use\s+(?P<tree>[^;]+);")
PATH = re.compile(r"(?<![\w:])[A-Za-z_]\w*(?:::[A-Za-z_]\w*)+")
ITEM = re.compile(r"\b(?:fn|struct|enum|trait|type|const|static|macro_rules!|union)\s+(\w+)")
NOT_CODE = re.compile(
    r"//[^\n]*|/\*.*?\*/|r(?P<hashes>#*)\".*?\"(?P=hashes)|b?\"(?:\\.|[^\"\\])*\"|b?'(?:\\[^']+|[^'\\])'", re.DOTALL
)
TEST = re.compile(r"#\[cfg\((?:all\()?test[^\]]*\]\s*(?:#\[[^\]]*\]\s*)*")


def code(text: str) -> str:
    """Rust without comments, literals and unit tests."""
    text = NOT_CODE.sub(" ", text)
    while found := TEST.search(text):
        end = found.end()
        depth = 0
        while end < len(text):
            depth += (text[end] == "{") - (text[end] == "}")
            end += 1
            if depth == 0 and text[end - 1] in "};":
                break
        text = text[: found.start()] + text[end:]
    return text


def leaves(tree: str) -> Iterator[tuple[list[str], str]]:
    """Paths of a `use` tree, each with the name that it gets here."""
    tree = tree.strip()
    if "{" in tree:
        head, inner = tree[: tree.index("{")], tree[tree.index("{") + 1 : tree.rindex("}")]
        depth, start = 0, 0
        for at, char in enumerate(f"{inner},"):
            depth += (char == "{") - (char == "}")
            if char == "," and depth == 0:
                if inner[start:at].strip():
                    yield from leaves(head + inner[start:at].strip())
                start = at + 1
        return
    path, _, alias = tree.partition(" as ")
    parts = [part.strip() for part in path.split("::") if part.strip()]
    if parts[-1] == "self":
        parts.pop()
    yield parts, alias.strip() or parts[-1]


class RustFile:
    def __init__(self, path: Path, parent: RustFile | None) -> None:
        self.path, self.parent, self.root = path, parent, parent.root if parent else self
        text = code(path.read_text(encoding="utf-8"))
        folder = path.parent if parent is None or path.stem == "mod" else path.parent / path.stem
        self.body = USE.sub(" ", text)
        self.items = set(ITEM.findall(self.body))
        self.uses = [(*leaf, bool(use["public"])) for use in USE.finditer(text) for leaf in leaves(use["tree"])]
        self.children = {
            name: RustFile(file, self)
            for name in re.findall(r"\bmod\s+(\w+)\s*;", text)
            for file in (folder / f"{name}.rs", folder / name / "mod.rs")
            if file.exists()
        }

    def all(self) -> Iterator[RustFile]:
        yield self
        for child in self.children.values():
            yield from child.all()


class Rust:
    """All crates."""

    def __init__(self) -> None:
        self.roots: list[RustFile] = []
        self.crates: dict[str, RustFile] = {}
        for toml in [*ROOT.glob("rust/*/Cargo.toml"), ROOT / "fuzz" / "Cargo.toml"]:
            name = toml.read_text(encoding="utf-8").split('name = "')[1].split('"')[0].replace("-", "_")
            library, binary = (toml.parent / "src" / file for file in ("lib.rs", "main.rs"))
            self.roots += [RustFile(root, None) for root in (binary, library) if root.exists()]
            self.crates[name] = self.roots[-1]

    def named(self, file: RustFile, path: list[str], seen: frozenset[int] = frozenset()) -> set[RustFile | Path]:
        """What a path may name: a module (RustFile), or the file of an item (Path)."""
        if not path:
            return {file}
        first, rest = path[0], path[1:]
        starts = {"crate": file.root, "self": file, "super": file.parent or file, **self.crates}
        if first in starts:
            return self.named(starts[first], rest, seen)
        found: set[RustFile | Path] = set()
        if first in file.children:
            found |= self.named(file.children[first], rest, seen)
        if first in file.items:
            found.add(file.path)
        for use in file.uses:
            target, alias, _ = use
            if alias in (first, "*") and id(use) not in seen:
                whole = [*target, *rest] if alias == first else [*target[:-1], *path]
                found |= self.named(file, whole, seen | {id(use)})
        return found

    def graph(self) -> Graph:
        graph: Graph = {}
        for crate in self.roots:
            for file in crate.all():
                words = set(re.findall(r"\w+", file.body))
                paths = [path for path, alias, public in file.uses if not public or alias in words]
                paths += [path.split("::") for path in PATH.findall(file.body)]
                graph[file.path] = {
                    found for path in paths for found in self.named(file, path) if isinstance(found, Path)
                } - {file.path}
        return graph


class Python:
    """All modules of a package."""

    def __init__(self, package: Path) -> None:
        self.base = package.parent
        self.trees = {file: ast.parse(file.read_text(encoding="utf-8")) for file in sorted(package.rglob("*.py"))}

    def file(self, module: str) -> Path | None:
        path = self.base.joinpath(*module.split("."))
        return next((file for file in (path.with_suffix(".py"), path / "__init__.py") if file in self.trees), None)

    @cache  # noqa: B019
    def imports(self, file: Path) -> list[tuple[str, str, str]]:
        """Module, name in it ("" for the module itself), name here."""
        parts = [*file.relative_to(self.base).parent.parts]
        found = []
        for node in ast.walk(self.trees[file]):
            if isinstance(node, ast.Import):
                found += [(name.name, "", name.asname or name.name.split(".")[0]) for name in node.names]
            elif isinstance(node, ast.ImportFrom):
                start = parts[: len(parts) - node.level + 1] if node.level else []
                module = ".".join([*start, *(node.module or "").split(".")]).strip(".")
                found += [(module, name.name, name.asname or name.name) for name in node.names]
        return found

    def defining(self, module: str, name: str) -> Path | None:
        """The file that defines what `from module import name` brings."""
        submodule = self.file(f"{module}.{name}") if name else self.file(module)
        file = self.file(module)
        if submodule or file is None or file.with_name(f"{name}.pyi").exists():
            return submodule
        for source, inner, alias in self.imports(file):
            if alias == name:
                return self.defining(source, inner) or file
        return file

    def graph(self) -> Graph:
        return {
            file: {found for module, name, _ in self.imports(file) if (found := self.defining(module, name))} - {file}
            for file in self.trees
        }


def circles(graph: Graph) -> list[set[Path]]:
    """Strongly connected components of more than one file."""

    @cache
    def reached(start: Path) -> frozenset[Path]:
        seen, stack = set(), [start]
        while stack:
            for target in graph.get(stack.pop(), ()):
                if target not in seen:
                    seen.add(target)
                    stack.append(target)
        return frozenset(seen)

    found = {frozenset(x for x in reached(file) if file in reached(x)) for file in graph if file in reached(file)}
    return [set(circle) for circle in found]
