"""The main job, end to end: `make demo`."""

from __future__ import annotations

import numpy as np

import lcpstar
from lcpstar import paper
from lcpstar.problems import box_stack


def heading(text: str) -> None:
    print(f"\n{text}\n{'-' * len(text)}")


def report(A, q, solution) -> None:
    print(f"  z = {np.round(solution.z, 6).tolist()}")
    print(f"  w = {np.round(solution.w, 6).tolist()}")
    print(f"  {solution.status} by {solution.method} after {solution.iterations} iterations")
    print(f"  residual {solution.residual:.1e} (equilibrated), max|min(z, w)| = {solution.natural_residual:.1e}")
    assert solution.success
    assert np.abs(np.minimum(solution.z, np.asarray(A) @ solution.z + q)).max() < 1e-4


def main() -> None:
    A, q = [[0, 1, 1], [2, 0, 2], [-2, -5, 0]], [-4, -7, 10]
    heading("The paper's example by Lemke's method, covering vector d = e")
    report(A, q, lcpstar.solve(A, q, method="lemke", options=lcpstar.LemkeOptions(d=[1, 1, 1])))

    heading("The same by the paper's interior point method, from z0 = (1, 1, 5)")
    report(A, q, lcpstar.potential_reduction(A, q, z0=[1, 1, 5]))

    heading("Table 1 of the paper, recomputed")
    paper.main()

    heading("A principal pivot transform: alpha = {0, 1}")
    M, p = lcpstar.ppt(A, [0, 1], q=q)
    print(f"  M =\n{M}\n  p = {p}")
    print(f"  pivoting back gives A again, to {np.abs(lcpstar.ppt(M, [0, 1]) - np.array(A)).max():.0e}")

    heading("A verdict that can be checked: no solution exists")
    A, q = [[1, -1], [-1, 1]], [-1, -1]
    verdict = lcpstar.solve(A, q)
    y = verdict.certificate.y
    print(f"  {verdict.status}: y = {y}, A'y = {np.transpose(A) @ y}, q'y = {np.dot(q, y)}")
    print(f"  best point found has residual {verdict.residual:.2g}")

    heading("A stack of 10 boxes, the top one 10^6 times heavier: 40 contacts, singular matrix")
    A, q = box_stack(10, mass_ratio=1e6)
    solution = lcpstar.solve(A, q)
    print(f"  rank {np.linalg.matrix_rank(A)} of {len(q)}, {solution.status} by {solution.method}")
    print(f"  largest impulse {solution.z.max():.4g} N s, smallest separation velocity {solution.w.min():.1e} m/s")
    error = np.abs(A @ solution.z + q - solution.w).max()
    print(f"  residual {solution.residual:.1e}, verified: w = A z + q to {error:.0e} m/s")
    assert solution.success


if __name__ == "__main__":
    main()
