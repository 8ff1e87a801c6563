"""Classes by the quadratic form x'Ax: definite, copositive in all variants, subdefinite, pseudomonotone."""

from __future__ import annotations

import functools
from fractions import Fraction

from .certificate import Decomposition, ldl
from .exact import Rows
from .registry import check, predicate
from .subject import Subject
from .table import FAMILIES, MatrixClass
from .verdict import Finding, Verdict
from .witness import All, FormValue, FormZero, InSubmatrix, InTransform, Member, MixedGradient, NotMonotonePair, NotStar


@predicate("PD", "positive definite", limit=None)
def is_positive_definite(A: Subject) -> Finding:
    """x'Ax > 0 for all x != 0. Integer LDL' of A + A'. O(n^3)."""
    return _definite(A, strict=True)


@predicate("PSD", "positive semidefinite", limit=None)
def is_positive_semidefinite(A: Subject) -> Finding:
    """x'Ax >= 0 for all x. Integer LDL' of A + A' with diagonal pivots. O(n^3)."""
    return _definite(A, strict=False)


def _definite(A: Subject, strict: bool) -> Finding:
    x = A.ask("negative_direction", strict)
    if x is not None:
        witness = FormValue(tuple(x), strict)
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    sign = "> 0" if strict else ">= 0"
    return Finding(True, f"A + A' = L D L' with D {sign}", certificate=functools.partial(ldl, A.rows, strict))


@predicate("C0", "copositive", limit=30)
def is_copositive(A: Subject) -> Finding:
    """x'Ax >= 0 for all x >= 0.

    With S = A + A': C0 for symmetric S is E0, so no S[alpha, alpha] may be nonsingular with S[alpha, alpha]^-1 e < 0
    (see `is_semimonotone`; [Had83], [Val86]). 2^n eliminations.
    """
    return _copositive(A, strict=False)


@predicate("C", "strictly copositive", limit=30)
def is_strictly_copositive(A: Subject) -> Finding:
    """x'Ax > 0 for all 0 != x >= 0. As C0, with null vectors x > 0 of S[alpha, alpha] excluded too."""
    return _copositive(A, strict=True)


def _copositive(A: Subject, strict: bool) -> Finding:
    x = A.ask("copositive", strict)
    if x is not None:
        witness = FormValue(tuple(x), strict, orthant=True)
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    name = "x'Ax > 0" if strict else "x'Ax >= 0"
    reason = f"{name} on every face of the orthant: no A + A' restricted to an index set maps some x > 0 to -e"
    return Finding(True, reason, certificate=None if strict else functools.partial(_decomposition, A))


def _decomposition(A: Subject) -> Decomposition | None:
    """A + A' minus its positive entries off the diagonal, when that is PSD."""
    n, rows = A.n, A.rows
    S = [[rows[i][j] + rows[j][i] for j in range(n)] for i in range(n)]
    N: Rows = tuple(tuple(max(S[i][j], Fraction(0)) if i != j else Fraction(0) for j in range(n)) for i in range(n))
    rest = tuple(tuple(rows[i][j] - N[i][j] / 2 for j in range(n)) for i in range(n))
    if any(rest[i][i] < 0 for i in range(n)) or Subject(rest).ask("negative_direction", False) is not None:
        return None
    return Decomposition(N, ldl(rest, definite=False))


@predicate("C0+", "copositive plus", limit=30)
def is_copositive_plus(A: Subject) -> Finding:
    """C0, and x'Ax = 0, x >= 0 imply (A + A')x = 0.

    On the support of a zero the block of A + A' is PSD, so a zero is a sum of support-minimal ones, each the null
    vector of a block of nullity one. 2^n eliminations.
    """
    c0 = A.decided("C0")
    if not c0:
        return Finding(False, lambda: c0.reason, c0.witness)
    rows = A.rows
    for zero in A.ask("form_zeros"):
        witness = FormZero(tuple(zero))
        if witness.refutes(rows):
            return Finding(False, lambda w=witness: w.sentence(rows), witness)  # type: ignore[misc]
    return Finding(True, "copositive, and A + A' maps every zero x >= 0 of the form to 0")


@predicate("C0*", "copositive star", limit=30)
def is_copositive_star(A: Subject) -> Finding:
    """C0, and x'Ax = 0, Ax >= 0, x >= 0 imply A'x <= 0. The second is linear on the pieces of SOL(0, A): rays do."""
    c0 = A.decided("C0")
    if not c0:
        return Finding(False, lambda: c0.reason, c0.witness)
    return star(A, "copositive")


def star(A: Subject, first: str, tilde: bool = False) -> Finding:
    """A'x <= 0 on SOL(0, A); `tilde`: and (A'x)_i != 0 only where (Ax)_i != 0."""
    found = A.ask("star", tilde)
    if found is not None:
        witness = NotStar(tuple(found[0]), found[1], tilde)
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    more = ", zero wherever Ax is" if tilde else ""
    return Finding(True, f"{first}, and A'x <= 0{more} on every ray x of SOL(0, A)")


@predicate("PSBD", "positive subdefinite", limit=None)
def is_positive_subdefinite(A: Subject) -> Finding:
    """x'Ax < 0 implies A'x <= 0 or A'x >= 0.

    For each pair of columns the form must be nonnegative on the wedge a_i x >= 0 >= a_j x: PSD on its edge space, and
    a copositive 2 x 2 Schur complement. O(n^5).
    """
    x = A.ask("subdefinite")
    if x is not None:
        witness = MixedGradient(tuple(x))
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    return Finding(True, "x'Ax >= 0 wherever A'x has both signs")


@predicate("PM", "pseudomonotone on the nonnegative orthant", limit=20)
def is_pseudomonotone(A: Subject) -> Finding:
    """For x, y >= 0: (y - x)'Ax >= 0 implies (y - x)'Ay >= 0.

    With z = y - x, c = A'z: a pair exists iff c has both signs and z'Az < 0 (so A is not PSBD), or c <= 0, c_i = 0
    where z_i < 0, and z'Az < 0. The second is one cone per set of negative entries; the sum of its rays decides. 2^n.
    """
    pair = A.ask("pseudomonotone")
    if pair is not None:
        witness = NotMonotonePair(tuple(pair[0]), tuple(pair[1]))
        return Finding(False, lambda: witness.sentence(A.rows), witness)
    return Finding(True, "PSBD, and no z with A'z <= 0 vanishing where z < 0 has z'Az < 0")


@predicate("C0f", "fully copositive", limit=16)
def is_fully_copositive(A: Subject) -> Finding:
    """Every legitimate principal pivot transform, A included, is copositive. 4^n eliminations."""
    return every_transform(A, "C0")


def every_transform(A: Subject, symbol: str) -> Finding:
    """Every legitimate principal pivot transform is in the class."""
    transforms = A.transforms()
    for done, (alpha, M) in enumerate(transforms):
        A.poll(done, len(transforms))
        if not M.decided(symbol):
            return _in_transform(alpha, A.transform(alpha, M).decided(symbol))
    return Finding(True, f"all {len(transforms)} legitimate PPTs are in {symbol}")


def _in_transform(alpha: tuple[int, ...], verdict: Verdict) -> Finding:
    if not alpha:
        return Finding(False, lambda: verdict.reason, verdict.witness)
    return Finding(
        False,
        lambda: f"the PPT on {set(alpha)} (up to a factor): {verdict.reason}",
        InTransform(alpha, verdict.witness),
    )


@predicate("almost-C0", "almost copositive", limit=30)
def is_almost_copositive(A: Subject) -> Finding:
    """Every proper principal submatrix is copositive and A is not."""
    return exact_order(A, 1)


def exact_order(A: Subject, k: int) -> Finding:
    """Copositive of exact order k: the principal submatrices of order n - k are C0, none of order n - k + 1 is."""
    if k == 0:
        c0 = A.verdict("C0")
        return Finding(c0.holds, lambda: c0.reason, c0.witness, functools.partial(getattr, c0, "certificate"))
    for alpha, block in A.principals():
        size = len(alpha)
        if size > A.n - k + 1:
            break
        verdict = block.decided("C0")
        if size <= A.n - k and not verdict:
            return in_submatrix(A, alpha, verdict)
        if size == A.n - k + 1 and verdict:
            witness = Member("C0") if size == A.n else InSubmatrix(alpha, Member("C0"))
            return Finding(False, lambda w=witness: w.sentence(A.rows), witness)  # type: ignore[misc]
    if k > A.n:
        return (
            Finding(True, "there are no principal submatrices to ask")
            if k > A.n + 1
            else Finding(False, "the empty matrix is copositive", InSubmatrix((), Member("C0")))
        )
    return Finding(True, f"every principal submatrix of order {A.n - k} is copositive, none of order {A.n - k + 1}")


def in_submatrix(A: Subject, alpha: tuple[int, ...], verdict: Verdict) -> Finding:
    """A principal submatrix refutes membership."""
    if len(alpha) == A.n:
        return Finding(False, lambda: verdict.reason, verdict.witness)
    witness = InSubmatrix(alpha, verdict.witness)
    return Finding(False, lambda: witness.sentence(A.rows), witness)


@predicate("almost-C0f", "almost fully copositive", limit=14)
def is_almost_fully_copositive(A: Subject) -> Finding:
    """Every legitimate principal pivot transform is C0 or almost C0, and at least one is almost C0."""
    return _fully_exact(A, 1, "C0")


def _fully_exact(A: Subject, k: int, other: str) -> Finding:
    """Every transform is copositive of exact order k or in `other`, and one is of exact order k."""
    symbol = "almost-C0" if k == 1 else f"C0({k})"
    exact, neither = False, []
    transforms = A.transforms()
    for done, (alpha, M) in enumerate(transforms):
        A.poll(done, len(transforms))
        if M.decided(symbol):
            exact = True
            continue
        first = A.transform(alpha, M).decided(symbol)
        if not M.decided(other):
            second = A.transform(alpha, M).decided(other)
            both = All((first.witness, second.witness))
            return Finding(
                False,
                lambda a=alpha, f=first, s=second: f"the PPT on {set(a) or '{}'}: {f.reason}; {s.reason}",  # type: ignore[misc]
                InTransform(alpha, both) if alpha else both,
            )
        neither.append(InTransform(alpha, first.witness) if alpha else first.witness)
    if exact:
        return Finding(True, f"all {len(transforms)} legitimate PPTs are {symbol} or {other}, one is {symbol}")
    return Finding(False, f"no legitimate PPT is {symbol}", All(tuple(neither)))


@functools.cache
def exact_order_class(kind: str, k: int) -> MatrixClass:
    """The class C0(k), or C0f(k): transforms of exact order k or E0, one of exact order k."""
    symbol = f"{kind}({k})"
    full = kind == "C0f"

    def decide(A: Subject) -> Finding:
        return _fully_exact(A, k, "E0") if full else exact_order(A, k)

    def public(A: object, *, time_limit: float | None = None) -> Verdict:
        return check(A, symbol, time_limit=time_limit)

    name = f"exact order {k} fully copositive" if full else f"copositive of exact order {k}"
    return MatrixClass(symbol, name, decide, 14 if full else 24, public)


FAMILIES.update({kind: functools.partial(exact_order_class, kind) for kind in ("C0", "C0f")})
