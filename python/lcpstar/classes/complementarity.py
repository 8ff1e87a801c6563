"""Classes by what complementarity does: semimonotone and star classes, R0, R, L2, sufficient, Q, Q0, (++), E_c."""

from __future__ import annotations

from fractions import Fraction
from functools import partial
from typing import Any

from .certificate import MinkowskiFactor, OrthantTrees
from .exact import pivot_transform, times
from .quadratic import every_transform, in_submatrix, star
from .regions import AllShadowed, Disconnected, Infeasible, IsolatedSolution, Tree, Unsolvable
from .registry import predicate
from .subject import Subject
from .verdict import Finding, Verdict
from .witness import (
    AllDecrease,
    EquationSolution,
    InSubmatrix,
    InTransform,
    InTranspose,
    Member,
    NoDiagonals,
    SignReversed,
    ZeroSolution,
    origin,
)


def _same(verdict: Verdict) -> Finding:
    return Finding(verdict.holds, lambda: verdict.reason, verdict.witness, partial(getattr, verdict, "certificate"))


def _both(A: Subject, first: str, second: str) -> Finding:
    """The intersection of two classes: one that fails decides, whether or not the other is decided."""
    verdicts = [A.verdict(first)]
    if verdicts[0].holds is not False:
        verdicts.append(A.verdict(second))
    for answer in (False, None):
        for verdict in verdicts:
            if verdict.holds is answer:
                return _same(verdict)
    return Finding(True, lambda: f"in {first} ({A.verdict(first).reason}) and in {second} ({A.verdict(second).reason})")


def _every_principal(A: Subject, symbol: str) -> Finding:
    """Every principal submatrix is in the class."""
    for alpha, block in A.principals():
        verdict = block.decided(symbol)
        if not verdict:
            return in_submatrix(A, alpha, verdict)
    return Finding(True, f"all {2**A.n - 1} principal submatrices are in {symbol}")


@predicate("E0", "semimonotone", limit=30)
def is_semimonotone(A: Subject) -> Finding:
    """Every 0 != x >= 0 has an i with x_i > 0 and (Ax)_i >= 0.

    Let A[alpha, alpha] be a smallest block outside E0. The convex cone Bx < 0, B the block, is nonempty and misses the
    boundary of the orthant (smaller blocks are in E0), so it lies inside; then it holds no line, B is nonsingular and
    B^-1 <= 0. Hence A is in E0 iff no block has a solution x > 0 of Bx = -e. 2^n eliminations.
    """
    return _semimonotone(A, strict=False)


@predicate("E", "strictly semimonotone", limit=30)
def is_strictly_semimonotone(A: Subject) -> Finding:
    """Every 0 != x >= 0 has an i with x_i > 0 and (Ax)_i > 0. As E0, with Bx = 0, x > 0 excluded too."""
    return _semimonotone(A, strict=True)


def _semimonotone(A: Subject, strict: bool) -> Finding:
    x = A.ask("semimonotone", strict)
    if x is not None:
        witness = AllDecrease(tuple(x), strict)
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    return Finding(True, "no principal submatrix B has x > 0 with " + ("Bx <= 0" if strict else "Bx < 0"))


@predicate("almost-E", "almost strictly semimonotone", limit=30)
def is_almost_strictly_semimonotone(A: Subject) -> Finding:
    """Every proper principal submatrix is in E and A is not: the support-minimal witness against E is positive."""
    x = A.ask("semimonotone", True)
    if x is None:
        return Finding(False, "A itself is in E", Member("E"))
    support = tuple(i for i, v in enumerate(x) if v)
    if len(support) == A.n:
        sentence = AllDecrease(tuple(x), True).sentence(A.rows)
        return Finding(True, f"{sentence}, and no x with smaller support does that")
    witness = InSubmatrix(support, AllDecrease(tuple(x[i] for i in support), True))
    return Finding(False, lambda: witness.sentence(A.rows), witness)


@predicate("E0f", "fully semimonotone", limit=16)
def is_fully_semimonotone(A: Subject) -> Finding:
    """Every legitimate principal pivot transform, A included, is in E0. 4^n eliminations."""
    return every_transform(A, "E0")


@predicate("E0s", "semimonotone star", limit=24)
def is_semimonotone_star(A: Subject) -> Finding:
    """E0, and x'Ax = 0, Ax >= 0, x >= 0 imply A'x <= 0. The second is linear on the pieces of SOL(0, A): rays do."""
    e0 = A.decided("E0")
    return star(A, "semimonotone") if e0 else _same(e0)


@predicate("tE0s", "semimonotone star, tilde", limit=24)
def is_tilde_semimonotone_star(A: Subject) -> Finding:
    """E0s, and on SOL(0, A): (A'x)_i != 0 implies (Ax)_i != 0. For a sum of rays the signs agree: rays suffice."""
    e0 = A.decided("E0")
    return star(A, "semimonotone", tilde=True) if e0 else _same(e0)


@predicate("cE0s", "completely semimonotone star", limit=16)
def is_completely_semimonotone_star(A: Subject) -> Finding:
    """Every principal submatrix is in E0s."""
    return _every_principal(A, "E0s")


@predicate("ctE0s", "completely semimonotone star, tilde", limit=16)
def is_completely_tilde_semimonotone_star(A: Subject) -> Finding:
    """Every principal submatrix is in tE0s (used but not defined in the paper)."""
    return _every_principal(A, "tE0s")


@predicate("R0", "R0-matrix", limit=30)
def is_r0(A: Subject) -> Finding:
    """LCP(0, A) has the zero solution only: no piece of SOL(0, A) has a ray. 2^n null spaces."""
    x = A.ask("nonzero_solution")
    if x is not None:
        witness = ZeroSolution(tuple(x))
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    return Finding(True, "SOL(0, A) = {0}")


@predicate("R", "regular (Karamardian, d = e)", limit=30)
def is_regular(A: Subject) -> Finding:
    """LCP(t e, A) has the zero solution only, for all t >= 0 (the paper forgets z != 0). 2^n cones in (z, t)."""
    found = A.ask("regularity")
    if found is not None:
        witness = EquationSolution(_rescale(A, found[0], 1), found[1])
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    return Finding(True, "SOL(t e, A) = {0} for all t >= 0")


@predicate("L2", "L2 (Eaves; E1 of Garcia)", limit=20)
def is_l2(A: Subject) -> Finding:
    """Every 0 != x in SOL(0, A) has diagonal D1, D2 >= 0 with D2 x != 0 and (D1 A + A'D2)x = 0.

    With y = D2 x: some 0 != y >= 0 on the support of x has A'y <= 0, zero where Ax is. A linear program for each ray of
    SOL(0, A); the y of a ray serves every sum that contains the ray.
    """
    found = A.ask("garcia")
    if found is not None:
        witness = NoDiagonals(tuple(found[0]), tuple(found[1]))
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    return Finding(True, "every ray x of SOL(0, A) has D1, D2 >= 0 with D2 x != 0, (D1 A + A'D2)x = 0")


@predicate("L", "L-matrix (Eaves)", limit=20)
def is_l(A: Subject) -> Finding:
    """E0 and L2."""
    return _both(A, "E0", "L2")


@predicate("CSU", "column sufficient", limit=16)
def is_column_sufficient(A: Subject) -> Finding:
    """x_i (Ax)_i <= 0 for all i implies x_i (Ax)_i = 0 for all i.

    By increasing support; once smaller supports pass, a block with positive determinant cannot fail, so only
    det <= 0 needs its sign patterns S and the cone {y >= 0, (SAS)y <= 0}. Up to 3^n double descriptions.
    """
    x = A.ask("column_sufficient")
    if x is not None:
        witness = SignReversed(tuple(x))
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    return Finding(True, "no x has all x_i (Ax)_i <= 0 and one < 0")


@predicate("RSU", "row sufficient", limit=16)
def is_row_sufficient(A: Subject) -> Finding:
    """A' is column sufficient."""
    verdict = A.transposed.decided("CSU")
    if verdict:
        return Finding(True, "A' is column sufficient")
    witness = InTranspose(verdict.witness)
    return Finding(False, lambda: f"for A': {verdict.reason}", witness)


@predicate("SU", "sufficient", limit=16)
def is_sufficient(A: Subject) -> Finding:
    """Column and row sufficient."""
    return _both(A, "CSU", "RSU")


@predicate("Q0", "Q0-matrix", limit=10)
def is_q0(A: Subject) -> Finding:
    """LCP(q, A) is solvable whenever it is feasible: K(A) = pos(I, -A).

    Space, orthant by orthant, is split into simplicial cones until each lies in one complementary cone or in one half
    space of infeasible q, or its centre is a feasible q outside all of them. Cones without interior cannot matter:
    K(A) and pos(I, -A) are closed. The trees are the certificate. Exponential in n twice over: meant for n <= 6.
    """
    q, trees = A.ask("solvable")
    if q is None:
        infeasible = tuple(map(tuple, A.ask("infeasibility_rays")))
        leaves = sum(split is None for _, tree in trees for _, split in tree)
        return Finding(
            True,
            f"{leaves} simplicial cones cover space, each inside a complementary cone or infeasible",
            certificate=OrthantTrees({o: Tree.from_kernel(tree) for o, tree in trees}, infeasible),
        )
    witness = _unsolvable(A, q)
    return Finding(False, lambda: witness.sentence(A.rows), witness)


def _unsolvable(A: Subject, q: list[int]) -> Unsolvable:
    separations = A.ask("separate", tuple(q))
    z, t = A.ask("feasible_point", tuple(q))
    return Unsolvable(tuple(map(Fraction, q)), _rescale(A, z, t), tuple(map(tuple, separations)))


def _rescale(A: Subject, z: list[int], t: int) -> tuple[Fraction, ...]:
    """The kernel's matrix is `scale` A, so its z / t is z of A divided by the scale."""
    return tuple(Fraction(v * A.scale, t) for v in z)


@predicate("Q", "Q-matrix", limit=10)
def is_q(A: Subject) -> Finding:
    """LCP(q, A) is solvable for every q: Q0, and no 0 != y >= 0 has A'y <= 0 (else q = -y is infeasible)."""
    witness = _infeasible(A)
    if witness is not None:
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    return _same(A.verdict("Q0"))


def _infeasible(A: Subject) -> Infeasible | None:
    rays = A.ask("infeasibility_rays")
    return Infeasible(tuple(-v for v in rays[0]), tuple(rays[0])) if rays else None


@predicate("Qb", "Qb-matrix", limit=10)
def is_qb(A: Subject) -> Finding:
    """SOL(q, A) is nonempty and compact for every q: Q and R0 [FL05]."""
    return _both(A, "R0", "Q")


@predicate("cQ", "completely Q", limit=30)
def is_completely_q(A: Subject) -> Finding:
    """Every principal submatrix is in Q, which is E [Cot80]; a smallest block outside E has an infeasible q."""
    x = A.ask("semimonotone", True)
    if x is None:
        return Finding(True, "strictly semimonotone, which is completely Q")
    support = tuple(i for i, v in enumerate(x) if v)
    inner = _infeasible(A.principal(support))
    assert inner is not None
    witness = inner if len(support) == A.n else InSubmatrix(support, inner)
    return Finding(False, lambda: witness.sentence(A.rows), witness)


@predicate("cQ0", "completely Q0", limit=8)
def is_completely_q0(A: Subject) -> Finding:
    """Every principal submatrix is in Q0. Z-matrices [Cha70] and strictly semimonotone ones [Cot80] are."""
    for symbol in ("Z", "E"):
        if A.verdict(symbol).holds:
            return Finding(True, f"in {symbol}, which is contained in completely Q0")
    return _every_principal(A, "Q0")


@predicate("++", "(++)-property", limit=10)
def is_plus_plus(A: Subject) -> Finding:
    """AX is in Z for some nonsingular M-matrix X (as printed, X = 0 would do for every A).

    Column j of X needs x_i <= 0, (Ax)_i <= 0 off j and v'x > 0 for a common v > 0; by Farkas it exists iff v is outside
    pos{e_i, A_i. : i != j}. So the question is whether these n cones cover the orthant: as Q0.
    """
    found, tree = A.ask("plus_plus")
    if found is None:
        witness = AllShadowed(Tree.from_kernel(tree))
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    v, x = found
    X = tuple(tuple(Fraction(x[i * A.n + j]) for j in range(A.n)) for i in range(A.n))
    return Finding(True, "X in K with AX in Z exists: see the certificate", certificate=MinkowskiFactor(X, tuple(v)))


@predicate("Ec", "connected", limit=5)
def is_connected(A: Subject) -> Finding:
    """SOL(q, A) is connected for every q (the empty set counts as connected).

    Column sufficient matrices are (SOL is convex) [CPV89]; matrices outside E0f are not [JG98]: x and 0 solve one
    LCP of the transform, and 0 is isolated. Otherwise one q per cell of the refinement of space by the facets of all
    complementary cones and of their intersections; the pieces of SOL(q, A) and which of them meet are constant there.
    n = 3: milliseconds, n = 4: seconds.
    """
    if A.verdict("CSU").holds:
        return Finding(True, "column sufficient, so SOL(q, A) is convex for every q")
    e0f = A.decided("E0f")
    witness: IsolatedSolution | Disconnected
    if not e0f:
        witness = _isolated(A, origin(e0f))
    else:
        q = A.ask("disconnected")
        if q is None:
            return Finding(True, "SOL(q, A) is connected for one q in every cell of space cut by the cones")
        witness = _disconnected(A, q)
    return Finding(False, lambda: witness.sentence(A.rows), witness)


def _isolated(A: Subject, found: InTransform | AllDecrease) -> IsolatedSolution:
    """From x >= 0 with (Mx)_i < 0 where x_i > 0: an LCP(q', M), q' > 0, with the isolated solution 0 and also x."""
    alpha = found.alpha if isinstance(found, InTransform) else ()
    inner: Any = found.inner if isinstance(found, InTransform) else found
    M = pivot_transform(A.rows, alpha)
    assert M is not None
    # The kernel's x belongs to a positive multiple of M: its support and signs carry over.
    x = tuple(Fraction(v) for v in inner.x)
    image = times(M, x)
    p = [-v if c else 1 + abs(v) for v, c in zip(image, x, strict=True)]
    other = [v + c for v, c in zip(image, p, strict=True)]
    z = tuple(p[i] if i in alpha else Fraction(0) for i in range(A.n))
    w = [Fraction(0) if i in alpha else p[i] for i in range(A.n)]
    q = tuple(a - b for a, b in zip(w, times(A.rows, z), strict=True))
    return IsolatedSolution(q, z, tuple(other[i] if i in alpha else x[i] for i in range(A.n)))


def _disconnected(A: Subject, q: list[int]) -> Disconnected:
    pieces, separations, _ = A.ask("components", tuple(q))
    return Disconnected(
        tuple(map(Fraction, q)),
        {alpha: _rescale(A, z, t) for alpha, _, z, t in pieces},
        {alpha: component for alpha, component, _, _ in pieces},
        tuple((alpha, beta, tuple(y)) for alpha, beta, y in separations),
    )
