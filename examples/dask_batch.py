"""Ten million small problems on a Dask cluster of processes: streamed, with progress, in bounded memory.

    pip install "dask[distributed]"
    python examples/dask_batch.py --problems 10000000 --n 8

Each task makes one chunk of problems where it is solved (in an application: reads it), solves it with
`solve_gufunc`, reduces it to a few numbers and forgets it; only a few chunks per worker exist at any time.
"""

from __future__ import annotations

import argparse
import resource
import time
from typing import Any

import numpy as np

import lcpstar


def make(seed: int, count: int, n: int) -> tuple[np.ndarray, np.ndarray]:
    """`count` contact-like problems: `A = B B' + I / 10`, q normal."""
    rng = np.random.default_rng(seed)
    B = rng.standard_normal((count, n, n))
    return B @ B.swapaxes(1, 2) / n + 0.1 * np.eye(n), rng.standard_normal((count, n))


def solve_chunk(seed: int, count: int, n: int) -> dict[str, float]:
    """Solve one chunk and check it with NumPy; what is returned is small."""
    A, q = make(seed, count, n)
    z = lcpstar.solve_gufunc(A, q)
    w = (A @ z[..., None])[..., 0] + q
    return {
        "problems": count,
        "solved": int(np.isfinite(z).all(axis=1).sum()),
        "worst": float(np.nanmax(np.abs(np.minimum(z, w)))),
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def run(problems: int, n: int, chunk: int, workers: int, progress: bool = False) -> dict[str, Any]:
    """Stream the chunks through a local cluster and add up what comes back."""
    from dask.distributed import Client, LocalCluster, as_completed

    start = time.perf_counter()
    total: dict[str, Any] = {"problems": 0, "solved": 0, "worst": 0.0, "peak_mb": 0.0}
    with (
        LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        sizes = [min(chunk, problems - first) for first in range(0, problems, chunk)]
        tasks = iter(enumerate(sizes))
        # Two chunks per worker are in flight; a finished one makes room for the next.
        first = [client.submit(solve_chunk, k, size, n, pure=False) for k, size in _take(tasks, 2 * workers)]
        stream = as_completed(first, with_results=True)
        for future, part in stream:
            future.release()
            for k, size in _take(tasks, 1):
                stream.add(client.submit(solve_chunk, k, size, n, pure=False))
            for key in ("problems", "solved"):
                total[key] += part[key]
            for key in ("worst", "peak_mb"):
                total[key] = max(total[key], part[key])
            if progress:
                rate = total["problems"] / (time.perf_counter() - start)
                print(f"\r{total['problems']:>12,} of {problems:,}  {rate:,.0f} a second", end="", flush=True)
    if progress:
        print()
    return {**total, "seconds": time.perf_counter() - start}


def lazy(A: Any, q: Any) -> Any:
    """The same for Dask arrays that exist already: a lazy array of solutions, chunked as the input."""
    import dask.array as da

    return da.apply_gufunc(
        lcpstar.solve_gufunc, lcpstar.solve_gufunc.signature, A, q, output_dtypes=np.float64, vectorize=False
    )


def _take(iterator: Any, count: int) -> list[Any]:
    return [item for _, item in zip(range(count), iterator, strict=False)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--problems", type=int, default=10_000_000)
    parser.add_argument("--n", type=int, default=8)
    parser.add_argument("--chunk", type=int, default=50_000)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    summary = run(options.problems, options.n, options.chunk, options.workers, progress=True)
    print(
        f"{summary['solved']:,} of {summary['problems']:,} solved in {summary['seconds']:.1f} s, "
        f"worst residual {summary['worst']:.1e}, peak memory of a worker {summary['peak_mb']:.0f} MB"
    )


if __name__ == "__main__":
    main()
