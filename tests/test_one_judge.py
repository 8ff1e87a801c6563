"""Nobody but the judge says "solved", "infeasible" or "nearly infeasible"; where a status is made, and who may."""

from __future__ import annotations

import re

import pytest

import imports
from imports import ROOT

CLAIM = r"(?:Status|Self)::(?:Solved|Infeasible|NearlyInfeasible)\b"
# A pattern leads to its arrow by itself, by alternatives, or out of a tuple.
ARM = re.compile(rf"{CLAIM}(?=(?:[^(){{}};,=]*|[^(){{}};=]*\))\s*(?:if\b[^{{}};]*?)?=>)")
COMPARED = re.compile(rf"[=!]=\s*{CLAIM}|{CLAIM}\s*[=!]=|\bmatches!\([^;{{}}]*?\)(?=\s*(?:[;{{}}&|)]|$))")


def sources(*crates):
    for crate in crates:
        for file in sorted((ROOT / "rust" / crate / "src").rglob("*.rs")):
            if file.name != "tests.rs":
                yield str(file.relative_to(ROOT / "rust")), imports.code(file.read_text(encoding="utf-8"))


def made(text):
    """Statuses in the place of a value: neither a pattern nor one side of a comparison."""
    return re.findall(CLAIM, ARM.sub("", COMPARED.sub("", text)))


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("let status = Status::Solved;", 1),
        ("Solution { status: Status::Infeasible, ..found }", 1),
        ("match x { Found => Status::NearlyInfeasible, _ => y }", 1),
        ("match s { Status::Solved => {} Status::Infeasible | Status::NearlyInfeasible => return, _ => y }", 0),
        ("match (s, c) { (Status::Solved, _) => a, (Status::Infeasible, _) => b }", 0),
        ("if s == Status::Solved && matches!(t, Status::Infeasible | Status::NearlyInfeasible) { Status::Solved }", 1),
    ],
)
def test_values_are_told_from_patterns(text, count):
    assert len(made(text)) == count


def test_only_the_verdict_makes_a_claim():
    places = {name: len(made(text)) for name, text in sources("lcpstar", "lcpstar-py") if made(text)}
    assert places == {"lcpstar/src/verdict.rs": 3, "lcpstar/src/status.rs": 3}  # `Status::ALL` lists all there are


def test_only_one_function_makes_a_verdict():
    making = re.compile(r"(?<!struct )(?<!for )\b(?:Verdict|Self)\s*\{\s*status\b")
    places = {name: len(making.findall(text)) for name, text in sources("lcpstar", "lcpstar-py") if making.search(text)}
    assert places == {"lcpstar/src/verdict.rs": 1}


def test_kernels_accept_in_one_file():
    """A token is made where a point is measured, and the code for "solved" is written where a token is shown."""
    token = re.compile(r"(?<!struct )(?<!impl )(?<!> )\bAccepted\s*\{")
    code = re.compile(r"=\s*SOLVED\b")
    crates = ("lcpstar", "lcpstar-kernels", "lcpstar-py")
    texts = [(name, text) for name, text in sources(*crates) if name != "lcpstar/src/iterative/support.rs"]
    assert {name for name, text in texts if token.search(text)} == {"lcpstar-kernels/src/small/verify.rs"}
    assert {name for name, text in texts if code.search(text)} == {"lcpstar-kernels/src/batch/io.rs"}
    writer = dict(texts)["lcpstar-kernels/src/batch/io.rs"]
    assert re.search(r"fn accept\([^)]*accepted: &Accepted\)\s*\{\s*self\.status\[k\] = SOLVED;", writer)


def test_tokens_have_private_fields():
    texts = dict(sources("lcpstar", "lcpstar-kernels"))
    tokens = {"lcpstar/src/verdict.rs": ["Verdict"], "lcpstar/src/residual.rs": ["Passed"]}
    tokens |= {"lcpstar/src/refute.rs": ["Farkas", "Nearly"], "lcpstar-kernels/src/small/verify.rs": ["Accepted"]}
    for file, names in tokens.items():
        for token in names:
            fields = re.search(rf"\bstruct {token}\b\s*([{{(].*?[}})])", texts[file], re.DOTALL)[1]
            assert not re.search(r"\bpub\b", fields), token
    proof = dict(sources("lcpstar-exact"))["lcpstar-exact/src/proof.rs"]
    assert re.search(r"#\[non_exhaustive\]\s*pub struct ExactSolution\b", proof)
