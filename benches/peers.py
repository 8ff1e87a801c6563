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


def quantecon_lemke_howson() -> Peer:
    """For `A = [[0, C], [D, 0]]`, `q = -e`: an equilibrium of the game with costs C and D. The game is built once."""
    from quantecon.game_theory import NormalFormGame, Player, lemke_howson

    games: dict[int, tuple[object, NormalFormGame]] = {}  # with A, so that no other array gets its id

    def solve(A, q):
        m = len(q) // 2
        if len(q) % 2 or np.any(q != -1) or np.any(A[:m, :m]) or np.any(A[m:, m:]) or np.any(A < 0):
            return None
        if id(A) not in games:
            games[id(A)] = A, NormalFormGame((Player(-A[:m, m:]), Player(-A[m:, :m])))
        x, y = lemke_howson(games[id(A)][1])
        return np.concatenate([x / (A[m:, :m] @ x).min(), y / (A[:m, m:] @ y).min()])

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


def osqp() -> Peer:
    """Operator splitting for symmetric PSD A, polished, at the accuracy asked here."""
    import osqp as module
    from scipy import sparse

    def solve(A, q):
        n = len(q)
        model = module.OSQP()
        model.setup(
            P=sparse.triu(sparse.csc_matrix(A), format="csc"),
            q=q,
            A=sparse.identity(n, format="csc"),
            l=np.zeros(n),
            u=np.full(n, np.inf),
            verbose=False,
            eps_abs=1e-7,
            eps_rel=1e-7,
            polishing=True,
        )
        result = model.solve()
        return np.maximum(result.x, 0.0) if result.info.status_val in (1, 2) else None

    return solve


def clarabel() -> Peer:
    """Interior point for symmetric PSD A."""
    import clarabel as module
    from scipy import sparse

    def solve(A, q):
        n = len(q)
        settings = module.DefaultSettings()
        settings.verbose = False
        P, G = sparse.triu(sparse.csc_matrix(A), format="csc"), -sparse.identity(n, format="csc")
        solution = module.DefaultSolver(P, q, G, np.zeros(n), [module.NonnegativeConeT(n)], settings).solve()
        return np.maximum(solution.x, 0.0)

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
    "quantecon-lh": (quantecon_lemke_howson, False),
    "mju_boxQP": (mujoco_box_qp, True),
    "daqp": (daqp, True),
    "osqp": (osqp, True),
    "clarabel": (clarabel, True),
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
