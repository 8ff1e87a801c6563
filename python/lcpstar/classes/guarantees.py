"""What follows from class membership, in words and with the theorem."""

from __future__ import annotations

# (classes that must all hold, sentence). More special sentences come first; a sentence is shown once.
_GUARANTEES: tuple[tuple[tuple[str, ...], str], ...] = (
    (("P",), "LCP(q, A) has exactly one solution for every q [CPS92, 3.3.7]; any method, block pivoting is fastest"),
    (
        ("PSD",),
        "LCP(q, A) is solvable whenever it is feasible and SOL(q, A) is convex [CPS92, 3.1]; "
        "interior points are polynomial",
    ),
    (("CSU",), "SOL(q, A) is convex for every q [CPV89]"),
    (("RSU",), "every KKT point of min z'(Az + q) over FEA(q, A) solves LCP(q, A) [CPV89]"),
    (("SU",), "interior point methods solve every feasible LCP(q, A) (sufficient = P*(kappa)) [Val96]"),
    (("P0", "Q0"), "Lemke's method solves LCP(q, A) or proves it infeasible [AC87]"),
    (("Ec", "Q0"), "Lemke's method solves LCP(q, A) or proves it infeasible [CF96]"),
    (("L",), "Lemke's method solves LCP(q, A) or proves it infeasible, for every q [Eav71]"),
    (("C0+",), "Lemke's method solves LCP(q, A) or proves it infeasible, for every q [CPS92, 4.4]"),
    (("E",), "Lemke's method solves LCP(q, A) for every q, and so it is for every principal submatrix [Cot80]"),
    (("Z",), "a feasible LCP(q, A) has a least element solution; Chandrasekaran's method finds it in n pivots [Cha70]"),
    (("Q",), "LCP(q, A) is solvable for every q"),
    (("Q0",), "LCP(q, A) is solvable for every q for which it is feasible"),
    (("R0",), "SOL(q, A) is bounded for every q [CPS92, 3.9.23]"),
    (("Qb",), "SOL(q, A) is nonempty and compact for every q [FL05]"),
    (("R",), "LCP(q, A) has solutions for every q, also after small changes of A: A is in the interior of Q [GP92]"),
    (("Ec",), "SOL(q, A) is connected for every q"),
    (("E0",), "z = 0 is the only solution for every q > 0 [CPS92, 3.9.3]"),
    (("tE0s", "P0"), "the paper's potential reduction may be used; its convergence proof needs P0, see the docs"),
    (("tE0s",), "SOL(q, A) is bounded for every q in the interior of pos(I, -A), and Lemke's method decides every q"),
)


def guarantees(known: dict[str, bool]) -> tuple[str, ...]:
    """The sentences whose classes all hold; their theorems are cited by key of REFERENCES.md."""
    found: list[str] = []
    for symbols, sentence in _GUARANTEES:
        if all(known.get(s) for s in symbols) and not any(line.endswith(sentence) for line in found):
            found.append(f"{' and '.join(symbols)}: {sentence}")
    if known.get("tE0s") and known.get("P0") is False:
        found.append(
            "tE0s, not P0: the paper's theorem is false without P0; its method may converge, Lemke's decides every q"
        )
    if known.get("Q0") is False:
        found.append("not Q0: some feasible q has no solution; the witness shows one")
    if known.get("E0") is False:
        found.append("not E0: some q > 0 has a solution besides 0")
    return tuple(found)
