"""Another build of lcpstar beside this one: `python benches/against.py FOLDER`, where FOLDER holds its package.

The two take turns, each in a process of its own; of each cell the shortest time of all turns counts. A ratio above 1:
this one is faster.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

TURNS = 3
CELLS = [(4, 20_000), (8, 8_000), (12, 4_000), (16, 2_500), (24, 1_000), (32, 600), (64, 60), (128, 12)]


def family(name, n, count, rng):
    B = rng.standard_normal((count, n, n))
    if name == "PD":
        A = B @ B.transpose(0, 2, 1) / n + 0.1 * np.eye(n) + 0.3 * (B - B.transpose(0, 2, 1))
        return A, rng.standard_normal((count, n))
    A = B[:, :, : n // 2] @ B[:, :, : n // 2].transpose(0, 2, 1)
    x = rng.standard_normal((count, n))
    return A, np.maximum(-x, 0) - np.einsum("kij,kj->ki", A, np.maximum(x, 0))


def shortest(job, repeats):
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        job()
        times.append(time.perf_counter() - start)
    return min(times)


def measure():
    import lcpstar

    rng, rows = np.random.default_rng(0), []
    for name in ("PD", "half rank"):
        for n, count in CELLS:
            A, q = family(name, n, count, rng)
            assert lcpstar.solve_batch(A, q).success.all()
            some = min(count, 300)
            batch = shortest(lambda A=A, q=q: lcpstar.solve_batch(A, q, threads=1), 7) / count
            alone = shortest(lambda A=A, q=q, k=some: [lcpstar.solve(A[i], q[i]) for i in range(k)], 5) / some
            rows.append((name, n, batch, alone))
    print(json.dumps(rows))


def main(other):
    own = str(Path(__file__).parents[1] / "python")
    found = {other: [], own: []}
    for _ in range(TURNS):
        for folder in (other, own):
            paths = [folder, str(Path(__file__).parent)]
            code = f"import sys; sys.path[:0] = {paths!r}; import against; against.measure()"
            out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
            found[folder].append(json.loads(out))
    print("| family | n | `solve_batch`, us | ratio | `solve`, us | ratio |\n| --- | --- | --- | --- | --- | --- |")
    ratios = []
    for cell in range(len(found[own][0])):
        name, n = found[own][0][cell][:2]
        (old_batch, old), (batch, alone) = (
            [min(turn[cell][k] for turn in found[folder]) * 1e6 for k in (2, 3)] for folder in (other, own)
        )
        ratios += [old_batch / batch, old / alone]
        print(f"| {name} | {n} | {batch:.3f} | {old_batch / batch:.2f} | {alone:.2f} | {old / alone:.2f} |")
    print(f"\nGeometric mean of all ratios: {np.exp(np.mean(np.log(ratios))):.2f}; least {min(ratios):.2f}.")


if __name__ == "__main__":
    main(sys.argv[1])
