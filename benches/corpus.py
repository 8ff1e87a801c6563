"""Every published problem of `LCPSTAR_CORPUS`: answer, method, pivots, time, proof, time of the proof: `make corpus`.

Writes `docs/corpus.md`. Times are processor time in one process, the median of several calls; a proof is
`certify="exact"`, its time what that adds."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import statistics
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import lcpstar
from harness import environment

#: A proof is expected up to this order, and tried beyond.
PROVED_UP_TO = 130
DOCUMENT = Path(__file__).parent.parent / "docs" / "corpus.md"


@dataclass
class Row:
    """One problem, or a batch of them: counts over the batch, worst residual, median times."""

    name: str
    n: int
    status: str
    count: int
    answers: dict[str, int]
    methods: dict[str, int]
    iterations: list[int]
    residual: float
    seconds: list[float]
    proofs: dict[str, int]
    proof_seconds: list[float]


def problems(folder: Path) -> Iterator[tuple[str, np.ndarray, np.ndarray, str]]:
    """Name, stack of matrices, stack of vectors, published status."""
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as data:
            A, q, status = data["A"], data["q"], str(np.atleast_1d(data["status"])[0])
        n = A.shape[-1]
        yield path.stem, A.reshape(-1, n, n), q.reshape(-1, n), status


def timed(call, repeats: int):
    """The last result and the median processor time."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        result = call()
        times.append(time.process_time() - start)
    return result, statistics.median(times)


def count(table: dict[str, int], key: str) -> None:
    table[key] = table.get(key, 0) + 1


def proof_of(sol) -> str:
    """What `certify="exact"` proved."""
    certificate = sol.certificate
    return certificate.kind if certificate is not None and certificate.exact else "none"


def measure(name: str, A, q, status: str) -> Row:
    row = Row(name, q.shape[1], status, len(q), {}, {}, [], 0.0, [], {}, [])
    for M, p in zip(A, q, strict=True):
        repeats = 5 if row.n <= PROVED_UP_TO else 1
        sol, seconds = timed(lambda M=M, p=p: lcpstar.solve(M, p), repeats)
        assert lcpstar.verify(M, p, sol) or not sol.success, f"{name}: a wrong answer"
        count(row.answers, str(sol.status))
        count(row.methods, sol.method)
        row.iterations.append(sol.iterations)
        row.residual = max(row.residual, sol.residual)
        row.seconds.append(seconds)
        prove = lambda M=M, p=p: lcpstar.solve(M, p, certify="exact", time_limit=60)  # noqa: E731
        exact, total = timed(prove, 3 if row.n <= PROVED_UP_TO else 1)
        proof = proof_of(exact)
        if proof != "none":
            assert lcpstar.verify(M, p, exact, exact=True), f"{name}: a wrong proof"
        count(row.proofs, proof)
        row.proof_seconds.append(max(0.0, total - seconds))
    return row


def listed(table: dict[str, int], total: int) -> str:
    if not table:
        return "-"
    return ", ".join(key if n == total else f"{key} {n}" for key, n in sorted(table.items(), key=lambda kv: -kv[1]))


def span(values, unit: float = 1.0) -> str:
    """The value, or `median (max)` of several."""
    if not values:
        return "-"
    shown = [f"{unit * x:.3g}" for x in (statistics.median(values), max(values))]
    return shown[0] if len(values) == 1 else f"{shown[0]} ({shown[1]})"


def table(rows: list[Row]) -> str:
    lines = [
        "| problem | n | answer | by | pivots | residual | ms | proof | ms more |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for r in rows:
        name = r.name if r.count == 1 else f"{r.name} ({r.count})"
        if r.status != "solvable" and r.status not in r.answers:
            name += " [published: " + r.status.split("(")[0] + "]"
        cells = [
            name, str(r.n), listed(r.answers, r.count), listed(r.methods, r.count), span(r.iterations),
            f"{r.residual:.0e}", span(r.seconds, 1e3), listed(r.proofs, r.count), span(r.proof_seconds, 1e3),
        ]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def summary(rows: list[Row]) -> str:
    total = sum(r.count for r in rows)
    solvable = [r for r in rows if r.status == "solvable"]
    solved = sum(r.answers.get("solved", 0) for r in solvable)
    asked = [r for r in solvable if r.n <= PROVED_UP_TO]
    proved = sum(n for r in asked for kind, n in r.proofs.items() if kind != "none")
    unproved = [r.name for r in asked if r.proofs.get("none")]
    slowest = max(asked, key=lambda r: max(r.proof_seconds))
    return (
        f"{total} problems in {len(rows)} files. Of {sum(r.count for r in solvable)} published as solvable "
        f"{solved} are solved. Of {sum(r.count for r in asked)} solvable ones with n <= {PROVED_UP_TO}, {proved} have "
        "an exact proof"
        f"{' (not: ' + ', '.join(unproved) + ')' if unproved else ''}; the slowest proof took "
        f"{1e3 * max(slowest.proof_seconds):.0f} ms ({slowest.name}, n = {slowest.n})."
    )


TEXT = """# The published problems

Made by `make corpus` (`benches/corpus.py`) from the problems in `LCPSTAR_CORPUS`; every answer is re-checked by
`lcpstar.verify`, every proof in rational arithmetic. Where a file holds several problems: their number in parentheses,
then median (maximum). "ms" is processor time of `lcpstar.solve` with defaults, "ms more" what `certify="exact"` adds.

{environment}

{summary}

{table}

Answers that are `solved` without proof are solved to rounding: the last bits of A and q decide whether an exact
solution exists, and none was found. An exact `infeasible` beside `solved` says that FEA(q, A) of the binary numbers is
empty by less than rounding.
"""


def main() -> None:
    folder = os.environ.get("LCPSTAR_CORPUS")
    if not folder:
        sys.exit("LCPSTAR_CORPUS is not set: published problems are read from there")
    rows = []
    for name, A, q, status in problems(Path(folder)):
        row = measure(name, A, q, status)
        rows.append(row)
        print(f"{name}: {listed(row.answers, row.count)}, proof {listed(row.proofs, row.count)}", flush=True)
    text = TEXT.format(environment=environment("make corpus"), summary=summary(rows), table=table(rows))
    DOCUMENT.write_text(text)
    print(summary(rows))


if __name__ == "__main__":
    main()
