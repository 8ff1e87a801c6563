"""The interior point method: time per iteration beside LAPACK, total time beside quadratic programming solvers, and the
work per `tol`: `python benches/interior_point.py`. Processor time of one thread."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import time
from collections.abc import Callable

import numpy as np

import lcpstar
from harness import residual, write_record
from lcpstar import problems

#: What every solver of the comparison must achieve, measured by the harness.
ACHIEVED = 1e-8
REPEATS = 7


def median_seconds(call: Callable[[], object], repeats: int = REPEATS) -> float:
    call()
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        call()
        times.append(time.thread_time() - start)
    return float(np.median(times))


def ours(A, q, tol=1e-9, **options):
    settings = lcpstar.InteriorPointOptions(**options)
    return lcpstar.solve(A, q, method="interior_point", tol=tol, options=settings)


def seconds_per_iteration(A, q) -> float:
    """From the difference between a long and a short run, so that what is done once cancels."""

    def run(k):
        settings = lcpstar.InteriorPointOptions(finish=False)
        return lcpstar.solve(A, q, method="interior_point", tol=1e-13, max_iterations=k, options=settings)

    short, long = 1, run(8).iterations
    differences = []
    run(long)
    for _ in range(REPEATS):
        start = time.thread_time()
        run(short)
        middle = time.thread_time()
        run(long)
        differences.append((time.thread_time() - middle) - (middle - start))
    return float(np.median(differences)) / (long - short)


def per_iteration() -> tuple[str, list[dict[str, float | int | str]]]:
    from scipy.linalg import cho_factor, lu_factor

    lines = ["| A | n | one iteration | LAPACK's factorisation | ratio |", "| --- | --- | --- | --- | --- |"]
    data = []
    cases = (
        ("symmetric", problems.random_spd, lambda M: cho_factor(M, lower=True, check_finite=False)),
        ("unsymmetric", problems.random_pd, lambda M: lu_factor(M, check_finite=False)),
    )
    for name, build, factor in cases:
        for n in (200, 500, 1000):
            A, q = build(n, 0)
            M = A + np.diag(np.random.default_rng(0).uniform(0.1, 10.0, n))
            one, lapack = seconds_per_iteration(A, q), median_seconds(lambda M=M, factor=factor: factor(M), 15)
            lines.append(f"| {name} | {n} | {1e3 * one:.2f} ms | {1e3 * lapack:.2f} ms | {one / lapack:.2f} |")
            data.append({"A": name, "n": n, "iteration": one, "lapack": lapack})
    return "\n".join(lines), data


def clarabel_peer(A, q, tol):
    import clarabel
    from scipy import sparse

    n = len(q)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tol
    P = sparse.triu(sparse.csc_matrix(A), format="csc")
    cones = [clarabel.NonnegativeConeT(n)]
    return np.array(
        clarabel.DefaultSolver(P, q, -sparse.identity(n, format="csc"), np.zeros(n), cones, settings).solve().x
    )


def piqp_peer(A, q, tol):
    import piqp

    n = len(q)
    solver = piqp.DenseSolver()
    solver.settings.verbose = False
    solver.settings.eps_abs = solver.settings.eps_rel = tol
    solver.settings.eps_duality_gap_abs = solver.settings.eps_duality_gap_rel = tol
    solver.setup(A, q, None, None, None, None, None, np.zeros(n), np.full(n, np.inf))
    solver.solve()
    return np.array(solver.result.x)


def proxqp_peer(A, q, tol):
    from proxsuite import proxqp

    n = len(q)
    solver = proxqp.dense.QP(n, 0, 0, True)
    solver.settings.eps_abs = tol
    solver.settings.eps_rel = 0.0
    solver.init(A, q, None, None, None, None, None, np.zeros(n), np.full(n, 1e20))
    solver.solve()
    return np.array(solver.results.x)


def osqp_peer(A, q, tol):
    import osqp
    from scipy import sparse

    n = len(q)
    solver = osqp.OSQP()
    P = sparse.triu(sparse.csc_matrix(A), format="csc")
    solver.setup(P, q, sparse.identity(n, format="csc"), np.zeros(n), np.full(n, np.inf), verbose=False,
                 eps_abs=tol, eps_rel=tol, max_iter=100000)  # fmt: skip
    return np.array(solver.solve(raise_error=False).x)


PEERS = {"Clarabel": clarabel_peer, "PIQP": piqp_peer, "ProxQP": proxqp_peer, "OSQP": osqp_peer}


def first_tolerance(peer, A, q) -> float | None:
    """The loosest tolerance at which the peer achieves what is asked."""
    for tol in (1e-6, 1e-8, 1e-10, 1e-12):
        try:
            z = peer(A, q, tol)
        except ImportError:
            return None
        if residual(A, q, z) <= ACHIEVED:
            return tol
    return None


def beside_peers() -> tuple[str, list[dict[str, object]]]:
    lines = [
        f"| family | n | lcpstar | achieved | {' | '.join(PEERS)} |",
        "| --- | --- | --- | --- | " + " | ".join("---" for _ in PEERS) + " |",
    ]
    data = []
    families = {
        "random_spd": (problems.random_spd, (20, 100, 200, 500)),
        "psd_half_rank": (problems.psd_half_rank, (20, 100, 200, 500)),
        "degenerate": (problems.degenerate, (20, 100, 200, 300)),
        "box_stack": (lambda k, seed: problems.box_stack(k, 1.0, seed=seed), (5, 25, 50, 75)),
    }
    for family, (build, sizes) in families.items():
        for size in sizes:
            A, q = build(size, 1)
            n = len(q)
            sol = ours(A, q)
            assert sol.success
            mine = median_seconds(lambda A=A, q=q: ours(A, q))
            row, cells = {}, []
            for name, peer in PEERS.items():
                tol = first_tolerance(peer, A, q)
                if tol is None:
                    cells.append("not reached")
                    continue
                row[name] = median_seconds(lambda peer=peer, A=A, q=q, tol=tol: peer(A, q, tol), 5)
                cells.append(f"{1e3 * row[name]:.2f} ms ({row[name] / mine:.1f}x)")
            achieved = residual(A, q, sol.z)
            lines.append(f"| {family} | {n} | {1e3 * mine:.2f} ms | {achieved:.0e} | {' | '.join(cells)} |")
            print(lines[-1], flush=True)
            data.append({"family": family, "n": n, "lcpstar": mine, **row})
    return "\n".join(lines), data


def per_tolerance() -> str:
    lines = [
        "| tol | iterations | time | achieved, without the finish | achieved, with it |",
        "| --- | --- | --- | --- | --- |",
    ]
    A, q = problems.random_spd(200, 2)
    for exponent in range(2, 15, 2):
        tol = 10.0**-exponent
        plain, finished = ours(A, q, tol, finish=False), ours(A, q, tol)
        seconds = median_seconds(lambda tol=tol: ours(A, q, tol, finish=False))
        reached = f"{plain.residual:.0e}" + ("" if plain.success else " (not reached)")
        lines.append(
            f"| 1e-{exponent} | {plain.iterations} | {1e3 * seconds:.2f} ms | {reached} | {finished.residual:.0e} |"
        )
    return "\n".join(lines)


def main() -> None:
    iteration, iteration_data = per_iteration()
    print(iteration, flush=True)
    peers, peer_data = beside_peers()
    body = (
        "## One iteration, one LAPACK factorisation of the same kind (SciPy), one thread\n\n"
        f"{iteration}\n\n"
        f"## Total time on symmetric PSD problems; every solver achieves a residual of {ACHIEVED:.0e}\n\n"
        "Each peer at the loosest of its tolerances 1e-6, 1e-8, 1e-10, 1e-12 that achieves it; in brackets, times "
        f"lcpstar's time. lcpstar at its default, finish included.\n\n{peers}\n\n"
        f"## The work per `tol` (random_spd, n = 200)\n\n{per_tolerance()}"
    )
    data = {"per_iteration": iteration_data, "peers": peer_data}
    write_record("interior_point", "Interior point method", "python benches/interior_point.py", body, data)


if __name__ == "__main__":
    main()
