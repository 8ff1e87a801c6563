"""How far each method oversteps `time_limit`, beside the time of one factorisation: `python benches/limits.py`.

Each case would run for longer than its limit. Wall-clock times; the factorisation (LAPACK's, same order) is timed right
before and after, so that other load on the machine weighs on both. Writes `benches/record/limits.md`.
"""

from __future__ import annotations

import pathlib
import platform
import statistics
import subprocess
import time

import numpy as np
import scipy.linalg
import scipy.sparse

import lcpstar
from lcpstar import _core, problems

ROOT = pathlib.Path(__file__).parents[1]


def monotone(n, seed=0):
    rng = np.random.default_rng(seed)
    B, S = rng.standard_normal((n, n)), rng.standard_normal((n, n))
    return B @ B.T / n + 1e-6 * np.eye(n) + 0.3 * (S - S.T), rng.standard_normal(n)


def z_matrix(n, seed=0):
    rng = np.random.default_rng(seed)
    A = -rng.random((n, n))
    np.fill_diagonal(A, n)
    return A, -rng.random(n)


def bimatrix(n, seed=0):
    rng = np.random.default_rng(seed)
    A = np.zeros((n, n))
    A[: n // 2, n // 2 :], A[n // 2 :, : n // 2] = (
        rng.random((n // 2, n - n // 2)) + 1,
        rng.random((n - n // 2, n // 2)) + 1,
    )
    return A, -np.ones(n)


def general(n, seed=0):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((n, n)), rng.standard_normal(n)


def sparse(side):
    laplacian = scipy.sparse.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(side, side))
    eye = scipy.sparse.identity(side)
    A = scipy.sparse.kron(laplacian, eye) + scipy.sparse.kron(eye, laplacian)
    return A.tocsr(), np.random.default_rng(0).standard_normal(side * side)


def solve(method, **options):
    def call(A, q, limit):
        solution = lcpstar.solve(A, q, method=method, time_limit=limit, **options)
        return str(solution.status)

    return call


def solution_set(A, q, limit):
    try:
        return f"{len(lcpstar.solutions(A, q, time_limit=limit))} faces"
    except lcpstar.errors.TimeLimitError:
        return "TimeLimitError"


def classify(A, q, limit):
    verdict = lcpstar.classes.check(np.round(A * 10).astype(int), "Q0", time_limit=limit)
    return f"holds = {verdict.holds}"


CASES = [
    ("lemke, n = 1500", monotone(1500), solve("lemke")),
    ("principal_pivoting, n = 1500", monotone(1500), solve("principal_pivoting")),
    ("block_pivoting, n = 1500", monotone(1500), solve("block_pivoting")),
    ("interior_point, n = 1500", monotone(1500), solve("interior_point")),
    ("auto, n = 1500", monotone(1500), solve("auto")),
    ("chandrasekaran, n = 1500", z_matrix(1500), solve("chandrasekaran")),
    ("lemke_howson, n = 1500", bimatrix(1500), solve("lemke_howson")),
    ("bilinear, n = 1500", general(1500), solve("bilinear")),
    ("potential_reduction, n = 600", monotone(600), solve("potential_reduction")),
    ("potential_reduction qr, n = 400", monotone(400), solve(
        "potential_reduction", options=lcpstar.PotentialReductionOptions(direction="qr"))),
    ("enumerate, n = 24", (-np.eye(24) - 0.1, -np.ones(24)), solve("enumerate")),
    ("lemke, Murty n = 60", problems.murty(60), solve(
        "lemke", options=lcpstar.LemkeOptions(d=np.ones(60)), max_iterations=10**12)),
    ("sparse interior_point, n = 40000", sparse(200), solve("interior_point")),
    ("certify exact, monotone n = 300", monotone(300), solve("auto", certify="exact")),
    ("certify exact, general n = 150", general(150), solve("auto", certify="exact")),
    ("solutions, n = 40", general(40), solution_set),
    ("classes.check Q0, n = 10", general(10), classify),
]  # fmt: skip


def timed(call, *arguments, **options):
    start = time.perf_counter()
    call(*arguments, **options)
    return time.perf_counter() - start


def factorisation(name, A, q):
    """Seconds of the largest step between two looks at the clock: LAPACK's LU of that order, or the method's own."""
    if name.startswith("potential_reduction"):  # B'B and its Cholesky factor, or a stacked QR
        direction = "qr" if " qr" in name else "cholesky"
        options = lcpstar.PotentialReductionOptions(direction=direction)
        return timed(lcpstar.solve, A, q, method="potential_reduction", max_iterations=1, options=options)
    if name.startswith("certify exact, monotone"):  # modulo a prime, and the digits of one solution
        return timed(_core.prove_solution, A, q, list(lcpstar.solve(A, q).alpha))
    n = min(A.shape[0], 1500)
    matrix = np.random.default_rng(1).standard_normal((n, n))
    return timed(scipy.linalg.lu_factor, matrix)


def main():
    rows = []
    for name, (A, q), call in CASES:
        for limit in (0.2, 1.0):
            unit, over, status = [], [], ""
            for _ in range(3):
                unit.append(factorisation(name, A, q))
                start = time.perf_counter()
                status = call(A, q, limit)
                over.append(time.perf_counter() - start - limit)
            unit.append(factorisation(name, A, q))
            kept = statistics.median(over) <= max(0.1 * limit, max(unit))
            row = (name, limit, status, statistics.median(over), statistics.median(unit), kept)
            rows.append(row)
            print(*row, flush=True)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout
    text = [
        "# time_limit",
        "",
        f"`python benches/limits.py` at commit {commit.strip()}, {platform.processor() or platform.machine()}, "
        f"Python {platform.python_version()}; medians of three, wall clock on a loaded machine of two cores.",
        "Kept: over by at most 10 % of the limit or one factorisation (LAPACK's LU of the same order up to 1500; for",
        "`potential_reduction` one of its iterations, for the monotone exact proof one exact solve).",
        "",
        "| call | limit s | ended as | over by s | one factorisation s | kept |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for name, limit, status, over, unit, kept in rows:
        text.append(f"| {name} | {limit:g} | {status} | {over:.3f} | {unit:.3f} | {'yes' if kept else 'no'} |")
    (ROOT / "benches" / "record" / "limits.md").write_text("\n".join(text) + "\n")


if __name__ == "__main__":
    main()
