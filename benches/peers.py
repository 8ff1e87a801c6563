"""Peers, each as `z = peer(A, q)` or `None` where it declines. Optional: those not installed are left out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Peer = Callable[[np.ndarray, np.ndarray], "np.ndarray | None"]


def quantecon() -> Peer:
    from quantecon.optimize import lcp_lemke

    def solve(A, q):
        result = lcp_lemke(A, q)
        return result.z if result.success else None

    return solve


def mujoco_box_qp() -> Peer:
    """Projected Newton for symmetric positive definite A: min z'Az/2 + q'z, z >= 0."""
    import mujoco

    def solve(A, q):
        n = len(q)
        z, R, index = np.zeros(n), np.zeros(n * (n + 7)), np.zeros(n, np.int32)
        rank = mujoco.mju_boxQP(z, R, index, A, q, np.zeros(n), np.full(n, 1e10))
        return z if rank >= 0 else None

    return solve


def daqp() -> Peer:
    """Dual active set for symmetric PSD A."""
    import daqp as module

    def solve(A, q):
        n = len(q)
        lower, upper = np.zeros(n), np.full(n, 1e30)
        sense = np.zeros(n, np.int32)
        z, _, exit_flag, _ = module.solve(A, q, np.zeros((0, n)), upper, lower, sense)
        return z if exit_flag > 0 else None

    return solve


def drake_moby() -> Peer:
    return _drake("MobyLcpSolver")


def drake_unrevised() -> Peer:
    return _drake("UnrevisedLemkeSolver")


def _drake(name: str) -> Peer:
    from pydrake import solvers

    solver = getattr(solvers, name)()

    def solve(A, q):
        program = solvers.MathematicalProgram()
        x = program.NewContinuousVariables(len(q))
        program.AddLinearComplementarityConstraint(A, q, x)
        result = solver.Solve(program, np.zeros(len(q)), None)
        return result.GetSolution(x) if result.is_success() else None

    return solve


#: name -> (factory, needs a symmetric positive semidefinite A)
PEERS: dict[str, tuple[Callable[[], Peer], bool]] = {
    "quantecon": (quantecon, False),
    "mju_boxQP": (mujoco_box_qp, True),
    "daqp": (daqp, True),
    "drake-moby": (drake_moby, False),
    "drake-unrevised": (drake_unrevised, False),
}


def available(names=None) -> dict[str, tuple[Peer, bool]]:
    """The peers that can be imported here."""
    found = {}
    for name, (factory, symmetric) in PEERS.items():
        if names is None or name in names:
            try:
                found[name] = (factory(), symmetric)
            except (ImportError, AttributeError, OSError) as error:
                print(f"{name} is not here: {error}")
    return found
