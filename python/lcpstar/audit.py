"""The paper's claims about matrix classes, recomputed: each becomes a formula, and `explore` looks for a counterexample.

Nothing here knows the outcome beforehand: `expected` is what an earlier, independent recomputation found, and the table
says where the two disagree.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .classes.exact import Rows, pivot_transform, principal, read_matrix, times, transpose
from .classes.registry import check
from .classes.solution_set import solution_set
from .explore import Exploration, explore

HOLDS, FALSE = "no counterexample", "false"


@dataclass(frozen=True)
class Claim:
    """A statement of the paper and where to look for a counterexample."""

    place: str
    text: str
    formula: str
    expected: str
    n: tuple[int, ...] = (1, 2, 3)
    entries: tuple[int, ...] = (0, 1, -1)
    samples: int | None = None
    remark: str = ""


@dataclass(frozen=True)
class Outcome:
    """One line of the audit table."""

    place: str
    text: str
    verdict: str
    detail: str
    agrees: bool
    seconds: float
    exploration: Exploration | None = None
    remark: str = ""

    @property
    def counterexample(self) -> Rows | None:
        """The smallest matrix found, exact, if the claim is false."""
        return self.exploration.counterexample if self.exploration else None


_TWO = (0, 1, -1, 2, -2)

CLAIMS: tuple[Claim, ...] = (
    Claim("Sec. 3, Thm 1", "E0s is invariant under principal rearrangement; A in E0 iff A' in E0",
          "(E0 & A' in E0) | (!E0 & !A' in E0)", HOLDS),
    Claim("Sec. 3, Thm 3", "pseudomonotone and A' in R0 give A' in E0s", "PM & A' in R0 => A' in E0s", HOLDS,
          remark="only 'no 0 != x >= 0 with A'x = 0' is used"),
    Claim("Sec. 3, Cor. (i)", "pseudomonotone and invertible give A' in E0s", "PM & det != 0 => A' in E0s", HOLDS),
    Claim("Sec. 3", "C0* is contained in E0s", "C0* => E0s", HOLDS, remark="even in tE0s"),
    Claim("Sec. 3, Ex. 3", "A in E0s need not have A + A' in E0s", "E0s => A + A' in E0s", FALSE),
    Claim("Sec. 3, Ex. 4", "a PPT of an E0s-matrix need not be E0s", "E0s => every PPT in E0s", FALSE),
    Claim("Sec. 3, Ex. 5", "A in E0s need not have A' in E0s", "E0s => A' in E0s", FALSE),
    Claim("Sec. 3, Ex. 6", "E0s is not complete", "E0s => cE0s", FALSE, n=(2, 3), entries=_TWO),
    Claim("Sec. 3, Thm psbd res", "PSBD, E0, rank >= 2, not skew give E0s", "PSBD & E0 & rank >= 2 & !skew => E0s", HOLDS,
          remark="'not skew' is not needed"),
    Claim("Sec. 4, Remark", "C0+ is contained in tE0s", "C0+ => tE0s", HOLDS, remark="even C0* is"),
    Claim("Sec. 4, Ex. 9", "not every E0s-matrix is tE0s", "E0s => tE0s", FALSE),
    Claim("Sec. 4, Thm L_2", "tE0s with every PPT almost E or completely tE0s is P0",
          "tE0s & every PPT in (almost-E | ctE0s) => P0", HOLDS),
    Claim("Sec. 4, Thm L_2, proof", "tE0s is contained in L2 and so in Q0", "tE0s => L2 & L & Q0", HOLDS),
    Claim("Abstract (F3)", "tE0s is contained in E0f", "tE0s => E0f", FALSE),
    Claim("Abstract (F3)", "tE0s is contained in P0", "tE0s => P0", FALSE),
    Claim("Sec. 6 (F3)", "tE0s contains the P0-matrices", "P0 => tE0s", FALSE),
    Claim("Sec. 4, Thm exact order k", "tE0s, C0f(1), every PPT C0(1) or E0 with a positive diagonal entry: P0",
          "tE0s & C0f(1) & every PPT in (almost-C0 | E0 & some principal of order 1 in PD) => P0", HOLDS, n=(3,)),
    Claim("Sec. 4 (F6)", "E0 with the (++)-property is P0 (quoted from Chu), X in K", "E0 & ++ => P0", HOLDS),
    Claim("Sec. 4 (F6)", "the same as printed, X in K0: X = 0 always serves", "E0 => P0", FALSE,
          remark="as printed every matrix has (++), with X = 0, so the claim says E0 => P0"),
    Claim("Sec. 4, last Thm (F7)", "E0, (++), every PPT almost C0, or ctE0s with full-rank 2 x 2 blocks: sufficient",
          "E0 & ++ & every PPT in (almost-C0 | ctE0s & every principal of order 2 in (det != 0)) => SU", FALSE,
          n=(2, 3), remark="false for n = 2 only"),
    Claim("Sec. 4, last Thm, n = 3", "the same for n = 3",
          "E0 & ++ & every PPT in (almost-C0 | ctE0s & every principal of order 2 in (det != 0)) => SU", HOLDS, n=(3,)),
    Claim("Sec. 5, Thm structure", "[[P0, +], [-, 0]] is tE0s", "bordered & A[0,1] in P0 => tE0s", HOLDS, n=(3,),
          entries=_TWO),
    Claim("Sec. 5, Remark connected (F1)", "[[P0 & Q, +], [-, 0]] is connected",
          "bordered & A[0,1] in (P0 & Q) => Ec", FALSE, n=(3,), entries=_TWO),
    Claim("Sec. 5, Thm (F1)", "[[P0 & Q, +], [-, 0]] is P0", "bordered & A[0,1] in (P0 & Q) => P0", FALSE, n=(3,),
          entries=_TWO),
    Claim("Sec. 5, n = 2", "the same for n = 2", "bordered & A[0] in (P0 & Q) => P0", HOLDS, n=(2,), entries=_TWO),
    Claim("Sec. 5, Thm R_0", "tE0s with v(A) > 0 is R0, so SOL(q, A) is compact", "tE0s & v > 0 => R0 & Qb", HOLDS,
          entries=_TWO),
    Claim("Sec. 8 (F4)", "SOL(q, A) is bounded for tE0s & P0", "tE0s & P0 => R0", FALSE,
          remark="R0 is boundedness for every q; bounded for q in the interior of pos(I, -A), or for all q when v(A) > 0"),
    Claim("Sec. 8", "nonnegative, zero diagonal, some entry > 0: not tE0s",
          "min >= 0 & max > 0 & trace == 0 => !tE0s", HOLDS, entries=(0, 1, 2)),
    Claim("Sec. 8", "tE0s & P0 is processed by Lemke (in L)", "tE0s & P0 => L", HOLDS, remark="P0 is not needed"),
    Claim("Thm das", "almost C0 is PSD of order n - 1", "almost-C0 => every proper principal in PSD", HOLDS, entries=_TWO),
    Claim("Thm psbd", "PSBD of rank >= 2 is PSD, or A + A' <= 0, or C0*; A' is PSBD",
          "PSBD & rank >= 2 => A' in PSBD & (PSD | A + A' in (max <= 0) | C0*)", HOLDS),
    Claim("Thm SS", "PSBD, rank >= 2, A + A' <= 0, not skew: A <= 0",
          "PSBD & rank >= 2 & A + A' in (max <= 0) & !skew => max <= 0", HOLDS),
    Claim("Thm pangresult", "R => Q & R0 => R0, and R0 => R on E0", "(!R | Q & R0) & (!E0 | !R0 | R)", HOLDS),
    Claim("Thm gowdatheorem", "pseudomonotone is P0", "PM => P0", HOLDS),
    Claim("Thm fullysemi", "connected is E0f", "Ec => E0f", HOLDS),
    Claim("Thm valiaho", "2 x 2 P0 with positive diagonal is sufficient",
          "P0 & every principal of order 1 in PD => SU", HOLDS, n=(2,), entries=(0, 1, -1, 2, -2, 3, -3)),
    Claim("Thm guu", "sufficient iff A and all PPTs are sufficient of order 2",
          "(SU & every PPT in (every principal of order 2 in SU)) | (!SU & some PPT in (some principal of order 2 in !SU))"
          .replace("in !SU", "in (!SU)"), HOLDS, n=(2, 3)),
    Claim("Thm L, Qmatrix, lopez", "L is Q0; E0 & R0 is Q; Qb = Q & R0", "(!L | Q0) & (!(E0 & R0) | Q)", HOLDS),
    Claim("Stone's conjecture", "E0f & Q0 is contained in P0", "E0f & Q0 => P0", HOLDS, remark="open"),
    Claim("Gowda and Jones", "P0 & Q0 = Ec & Q0", "Q0 => (P0 & Ec) | (!P0 & !Ec)", HOLDS, remark="open; settled for n = 2"),
)


def recompute(claim: Claim, threads: int | None = None) -> Outcome:
    """Scan the claim's space and compare with what was expected."""
    found = explore(claim.formula, claim.n, claim.entries, samples=claim.samples, threads=threads)
    verdict = HOLDS if found.counterexample is None else FALSE
    detail = f"{found.satisfied} of {found.scanned} satisfy the hypothesis"
    if found.counterexample is not None:
        detail = f"{_show(found.counterexample)}; {found.failures} of {found.satisfied} fail"
    return Outcome(claim.place, claim.text, verdict, detail, verdict == claim.expected, found.seconds, found, claim.remark)


def _show(A: Rows) -> str:
    return str([[int(x) if x.denominator == 1 else str(x) for x in row] for row in A])


def _classes(A: Any, yes: str, no: str = "") -> bool:
    return all(check(A, s).holds for s in yes.split()) and all(check(A, s).holds is False for s in no.split())


_EX3 = read_matrix([[0, 1, 1], [2, 0, 1], [-1, -1, 0]])
_EX6 = read_matrix([[0, 1, 1], [2, 0, 1], [-4, -5, 0]])
_EX11 = read_matrix([[0, 1, 1], [2, 0, 2], [-2, -5, 0]])


def _solutions_of_the_numerical_example() -> bool:
    found = solution_set(_EX11, [-4, -7, 10])
    vertices = {z for face in found.faces for z in face.vertices}
    expected = {(Fraction(15, 14), Fraction(11, 7), Fraction(17, 7)), (5, 0, 4), (0, 2, Fraction(7, 2))}
    return found.finite and vertices == expected


# (place, what the paper says, recomputation)
EXAMPLES: tuple[tuple[str, str, Callable[[], bool]], ...] = (
    ("Ex. 1", "[[0,-5],[2,0]] is E0s", lambda: _classes([[0, -5], [2, 0]], "E0s")),
    ("Ex. 2", "A and PAP' are E0s", lambda: _classes([[0, 1, 1], [2, 0, 2], [-4, -5, 0]], "E0s")
     and _classes([[0, -4, -5], [1, 0, 1], [2, 2, 0]], "E0s")),
    ("Ex. 3", "A is E0s, A + A' is not", lambda: _classes(_EX3, "E0s")
     and _classes([[a + b for a, b in zip(r, c, strict=True)] for r, c in zip(_EX3, transpose(_EX3), strict=True)], "", "E0s")),
    ("Ex. 4", "A^-1 is not E0s, and is as printed", lambda: _classes(pivot_transform(_EX3, (0, 1, 2)), "", "E0s")
     and pivot_transform(_EX3, (0, 1, 2)) == read_matrix([["-1/3", "1/3", "-1/3"], ["1/3", "-1/3", "-2/3"],
                                                          ["2/3", "1/3", "2/3"]])),
    ("Ex. 5", "A' is not E0s", lambda: _classes(transpose(_EX3), "", "E0s")),
    ("Ex. 6", "A is E0s, A[1,2] is not", lambda: _classes(_EX6, "E0s") and _classes(principal(_EX6, (0, 1)), "", "E0s")),
    ("Ex. 7", "[[0,3],[-1,0]] is PSBD and E0s", lambda: _classes([[0, 3], [-1, 0]], "PSBD E0s")),
    ("Ex. 8", "A is tE0s, not C0*", lambda: _classes([[0, 1, 1], [2, 0, 2], [-2, -4, 0]], "tE0s", "C0*")),
    ("Ex. 9", "A is P0 and E0s, not tE0s", lambda: _classes([[1, -1, -2], [-1, 1, 0], [0, 0, 1]], "P0 E0s", "tE0s")),
    ("Ex. 10", "A is R0, tE0s, Q", lambda: _classes([[0, 2, 1], [1, 0, 1], [-2, -2, 1]], "R0 tE0s Q")),
    ("Ex. 11", "A is tE0s; the printed z* solves LCP(q, A)", lambda: _classes(_EX11, "tE0s") and times(
        _EX11, (Fraction(15, 14), Fraction(11, 7), Fraction(17, 7))) == (4, 7, -10)),
    ("Ex. 11", "the LCP has exactly three solutions (not one)", _solutions_of_the_numerical_example),
)


def audit(
    claims: Iterable[Claim] = CLAIMS, *, threads: int | None = None, progress: Callable[[Outcome], None] | None = None
) -> list[Outcome]:
    """Recompute the examples and look for counterexamples to the claims.

    Parameters
    ----------
    claims : iterable of Claim
    threads : int, optional
        As for `explore`.
    progress : callable, optional
        Gets each Outcome as it is found.

    Returns
    -------
    list of Outcome
        `agrees` is False where the recomputation differs from the recorded finding.

    Notes
    -----
    About a minute on two cores. A claim without counterexample in the scanned space is not thereby proved.
    """
    outcomes = []
    for place, text, recomputed in EXAMPLES:
        start = time.perf_counter()
        right = recomputed()
        verdict = "correct" if right else "wrong"
        outcomes.append(Outcome(place, text, verdict, "", right, time.perf_counter() - start))
        if progress:
            progress(outcomes[-1])
    for claim in claims:
        outcomes.append(recompute(claim, threads))
        if progress:
            progress(outcomes[-1])
    return outcomes


def table(outcomes: Iterable[Outcome]) -> str:
    """The audit as text: place, claim, verdict, counterexample or count."""
    lines = []
    for outcome in outcomes:
        lines.append(f"{outcome.place:<30} {outcome.verdict:<18} {outcome.text}")
        for more in (outcome.detail, outcome.remark, "" if outcome.agrees else "DIFFERS from the recorded finding"):
            if more:
                lines.append(f"{'':<30} {'':<18}   {more}")
    return "\n".join(lines)
