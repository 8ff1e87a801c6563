"""Line and branch coverage of the core by its own tests and by the Python tests: `make coverage`.

Writes `benches/record/coverage.md`. Lines of test modules are not counted. Needs the tools of LLVM that belong to the
compiler: `rustup component add llvm-tools`. Not named `coverage`, which numba would import instead of the package.
"""

from __future__ import annotations

import collections
import json
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).parents[1]
TARGET = ROOT / "target" / "coverage"
SOURCES = ROOT / "rust" / "lcpstar" / "src"


def run(*command, **environment):
    print("+", *command, flush=True)
    return subprocess.run(
        [str(c) for c in command],
        cwd=ROOT,
        env={**os.environ, **environment},
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    ).stdout


def tool(name):
    sysroot = pathlib.Path(run("rustc", "--print", "sysroot").strip())
    found = next(sysroot.glob(f"lib/rustlib/*/bin/{name}"), None)
    if found is None:
        sys.exit(f"{name} is missing: rustup component add llvm-tools")
    return found


def measure():
    """Build both test suites with counters, run them, and return the report in lcov's format."""
    profdata, cov = tool("llvm-profdata"), tool("llvm-cov")
    profiles = TARGET / "profiles"
    shutil.rmtree(profiles, ignore_errors=True)
    environment = {
        "RUSTC_WRAPPER": str(ROOT / "benches" / "coverage_rustc.sh"),
        "CARGO_TARGET_DIR": str(TARGET),
        "LLVM_PROFILE_FILE": str(profiles / "%p-%m.profraw"),
    }
    build = run("cargo", "test", "--release", "-p", "lcpstar", "--no-run", "--message-format=json", **environment)
    messages = [json.loads(line) for line in build.splitlines() if line.startswith("{")]
    tests = [m for m in messages if m.get("executable") and m["profile"]["test"]]
    # The counters' own start-up allocates, which `no_alloc` would count.
    binaries = [m["executable"] for m in tests if not m["target"]["name"].startswith("no_alloc")]
    for binary in binaries:
        run(binary, "--quiet", **environment)
    run("cargo", "build", "--release", "-p", "lcpstar-py", **environment)
    package = TARGET / "python" / "lcpstar"
    shutil.rmtree(package, ignore_errors=True)
    shutil.copytree(ROOT / "python" / "lcpstar", package, ignore=shutil.ignore_patterns("*.so", "__pycache__"))
    extension = package / "_core.abi3.so"
    shutil.copy(TARGET / "release" / "lib_core.so", extension)
    run(sys.executable, "-m", "pytest", "-q", *sys.argv[1:], **environment, PYTHONPATH=str(package.parent))
    merged = TARGET / "lcpstar.profdata"
    run(profdata, "merge", "--sparse", "--failure-mode=all", "-o", merged, *profiles.glob("*.profraw"))
    others = [argument for binary in binaries for argument in ("--object", binary)]
    return run(cov, "export", extension, "--format=lcov", "--instr-profile", merged, *others, "--sources", SOURCES)


def parse(report):
    """File to {line: count} and {(line, branch): count}."""
    lines, branches = collections.defaultdict(dict), collections.defaultdict(dict)
    name = None
    for row in report.splitlines():
        kind, _, rest = row.partition(":")
        if kind == "SF":
            name = pathlib.Path(rest).relative_to(SOURCES).as_posix()
        elif kind == "DA":
            line, count = map(int, rest.split(",")[:2])
            lines[name][line] = lines[name].get(line, 0) + count
        elif kind == "BRDA":
            line, block, branch, count = rest.split(",")
            key = int(line), int(block), int(branch)
            branches[name][key] = branches[name].get(key, 0) + (0 if count == "-" else int(count))
    return lines, branches


def end_of_code(name):
    """The line on which the test module begins."""
    text = (SOURCES / name).read_text().splitlines()
    return next((k for k, line in enumerate(text, 1) if line == "#[cfg(test)]"), len(text) + 1)


def ranges(numbers):
    spans = []
    for k in sorted(numbers):
        if spans and k == spans[-1][1] + 1:
            spans[-1][1] = k
        else:
            spans.append([k, k])
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in spans)


def write(lines, branches):
    rows, total = [], collections.Counter()
    for name in sorted(lines):
        end = end_of_code(name)
        counted = {k: c for k, c in lines[name].items() if k < end}
        taken = {k: c for k, c in branches[name].items() if k[0] < end}
        missed = [k for k, c in counted.items() if c == 0]
        numbers = {
            "lines": len(counted),
            "covered": len(counted) - len(missed),
            "branches": len(taken),
            "taken": sum(c > 0 for c in taken.values()),
        }
        total.update(numbers)
        rows.append((name, numbers, missed))
    percent = lambda part, whole: f"{100 * part / whole:.1f} %" if whole else "-"  # noqa: E731
    commit = run("git", "rev-parse", "--short", "HEAD").strip()
    compiler = run("rustc", "--version").strip()
    text = [
        "# Coverage of the core",
        "",
        f"Commit {commit}, {compiler}; `make coverage`: `cargo test -p lcpstar` and the Python tests together.",
        "Lines of test modules are not counted; a branch is one outcome of one condition.",
        "",
        f"**Lines {percent(total['covered'], total['lines'])}** ({total['covered']} of {total['lines']}), "
        f"branches {percent(total['taken'], total['branches'])} ({total['taken']} of {total['branches']}).",
        "",
        "| file | lines | covered | branches taken | lines not reached |",
        "| --- | --- | --- | --- | --- |",
    ]
    for name, n, missed in sorted(rows, key=lambda row: -len(row[2])):
        covered, taken = percent(n["covered"], n["lines"]), percent(n["taken"], n["branches"])
        text.append(f"| {name} | {n['lines']} | {covered} | {taken} | {ranges(missed)} |")
    (ROOT / "benches" / "record" / "coverage.md").write_text("\n".join(text) + "\n")
    print(text[5])


if __name__ == "__main__":
    write(*parse(measure()))
