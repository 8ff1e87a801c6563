"""A loose tolerance beside the full one, and `auto` beside the best single method: `python benches/approximate.py`.

`LCPSTAR_CORPUS` adds the published contact problems. "proved" is `certify="exact"`. Times are processor seconds, the
least of several runs.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np

import lcpstar
from harness import write_record
from lcpstar import problems

METHODS = ["pgs", "pgs_sm", "nncg", "apgd", "admm", "newton", "block_pivoting"]
TOL = 1e-3


def cases():
    """Name of the family, name, problem."""
    for n in (60, 120, 240):
        yield "random_spd", f"n = {n}", problems.random_spd(n, 0)
        yield "random_pd", f"n = {n}", problems.random_pd(n, 0)
        yield "psd_half_rank", f"n = {n}", problems.psd_half_rank(n, 0)
        for ratio in (1.0, 1e4):
            yield f"box_stack {ratio:g}", f"n = {n}", problems.box_stack(n // 4, ratio, seed=0)
            yield f"sphere_pile {ratio:g}", f"n = {n}", problems.sphere_pile(n // 2, ratio, 0)
    folder = os.environ.get("LCPSTAR_CORPUS")
    for path in sorted(Path(folder).glob("*.npz")) if folder else []:
        if "normal" in path.name or "pyramid" in path.name:
            data = np.load(path)
            if data["A"].ndim == 2 and data["q"].ndim == 1 and len(data["q"]) >= 24:
                family = "corpus normal" if "normal" in path.name else "corpus pyramid"
                yield family, path.stem, (data["A"], data["q"])


def least_time(A, q, repeats=5, **arguments):
    """Processor seconds of the fastest run, and its solution."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        sol = lcpstar.solve(A, q, **arguments)
        times.append(time.process_time() - start)
        if sum(times) > 0.5:
            break
    return min(times), sol


def main() -> None:
    lines = [
        "| problem | n | proved | tol 1e-9 | auto, 1e-3 | proved / auto | 1e-9 / auto | best single | auto / best |",
        "| --- " * 9 + "|",
    ]
    data, ratios, speedups = [], {}, {}
    for family, name, (A, q) in cases():
        full, _ = least_time(A, q, tol=1e-9)
        proved, exact = least_time(A, q, repeats=1, certify="exact", time_limit=30.0)
        proved = proved if exact.certificate is not None and exact.certificate.exact else float("nan")
        auto, sol = least_time(A, q, tol=TOL)
        assert not sol.success or sol.residual <= TOL
        single = {}
        for method in METHODS:
            elapsed, found = least_time(A, q, tol=TOL, method=method, repeats=3)
            if found.success:
                single[method] = elapsed
        best = min(single, key=single.__getitem__) if single else None
        ratio = auto / single[best] if best else float("nan")
        if best:
            ratios.setdefault(family, []).append(ratio)
        speedups.setdefault(family, []).append((proved / auto, full / auto))
        shown = f"{best} {1e3 * single[best]:.2f} ms" if best else "none"
        lines.append(
            f"| {family}, {name} | {len(q)} | {1e3 * proved:.1f} ms | {1e3 * full:.2f} ms | {1e3 * auto:.2f} ms "
            f"({sol.method}) | {proved / auto:.0f} | {full / auto:.1f} | {shown} | {ratio:.2f} |"
        )
        data.append(
            {
                "family": family,
                "name": name,
                "n": len(q),
                "proved": proved,
                "full": full,
                "auto": auto,
                "single": single,
            }
        )
        print(lines[-1], flush=True)
    medians = {family: float(np.median(values)) for family, values in ratios.items()}
    lines += ["", "Median of auto / best single method by family:", ""]
    for family, value in medians.items():
        proved, full = np.nanmedian(speedups[family], axis=0)
        lines.append(f"* {family}: {value:.2f}; proved / auto {proved:.0f}, 1e-9 / auto {full:.1f}")
    lines += ["", f"Median over families: {np.median(list(medians.values())):.2f}."]
    print("\n".join(lines[-len(medians) - 2 :]))
    write_record("approximate", "A loose tolerance", "python benches/approximate.py", "\n".join(lines), data)


if __name__ == "__main__":
    main()
