"""What a witness or a certificate must hold: each statement broken alone is refused, and no matrix is proved to be what
it is not."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace
from fractions import Fraction

import pytest

from lcpstar import classes
from lcpstar.classes import certificate as c
from lcpstar.classes import regions as r
from lcpstar.classes import witness as w
from lcpstar.classes.exact import read_matrix


def refutes(witness, A):
    """A vector of the wrong length is refused by an exception, which is as good."""
    return witness.refutes(read_matrix(A))


# (witness, a matrix that it refutes, what is wrong with the matrix or with the witness next to it)
VECTORS = [
    (w.Minor((0,), "> 0"), [[0]], [(w.Minor((0,), "> 0"), [[1]])]),
    (w.Minor((0,), ">= 0"), [[-1]], [(w.Minor((0,), ">= 0"), [[0]])]),
    (w.Minor((0,), "< 0"), [[0]], [(w.Minor((0,), "< 0"), [[-1]])]),
    (w.Minor((0,), "<= 0"), [[1]], [(w.Minor((0,), "<= 0"), [[0]])]),
    (w.Entry(0, 1), [[1, 2], [-1, 1]], [(w.Entry(0, 0), [[1, 2], [-1, 1]]), (w.Entry(1, 0), [[1, 2], [-1, 1]])]),
    (
        w.FormValue((1, -1)),
        [[0, 2], [0, 0]],
        [
            (w.FormValue((1, 1)), [[0, 2], [0, 0]]),
            (w.FormValue((1, 0)), [[0, 2], [0, 0]]),
            (w.FormValue((1, -1), orthant=True), [[0, 2], [0, 0]]),
        ],
    ),
    (w.FormValue((1, 0), strict=True), [[0, 2], [0, 0]], [(w.FormValue((0, 0), strict=True), [[0, 2], [0, 0]])]),
    (w.FormValue((1, 1), orthant=True), [[0, -2], [0, 0]], [(w.FormValue((-1, 1), orthant=True), [[0, 2], [0, 0]])]),
    (
        w.FormZero((1, 0)),
        [[0, 1], [0, 0]],
        [
            (w.FormZero((1, 1)), [[0, 1], [0, 0]]),  # x'Ax = 1
            (w.FormZero((-1, 0)), [[0, 1], [0, 0]]),
            (w.FormZero((1, 0)), [[0, 0], [0, 0]]),  # gradient 0
        ],
    ),
    (
        w.SignReversed((1, 0)),
        [[-1, 0], [0, 1]],
        [(w.SignReversed((1, 1)), [[-1, 0], [0, 1]]), (w.SignReversed((1, 0)), [[0, 0], [0, 1]])],
    ),
    (
        w.AllDecrease((1, 0)),
        [[-1, 0], [-1, 0]],
        [
            (w.AllDecrease((0, 1)), [[-1, 0], [-1, 0]]),  # Ax = 0
            (w.AllDecrease((1, 1)), [[-1, 0], [1, 1]]),
            (w.AllDecrease((1, -1)), [[-1, 0], [-1, 0]]),
            (w.AllDecrease((0, 0)), [[-1, 0], [-1, 0]]),
        ],
    ),
    (w.AllDecrease((0, 1), strict=True), [[-1, 0], [-1, 0]], [(w.AllDecrease((0, 1), strict=True), [[0, 0], [0, 1]])]),
    (
        w.ZeroSolution((1, 0)),
        [[0, 1], [1, 0]],
        [
            (w.ZeroSolution((0, 0)), [[0, 1], [1, 0]]),
            (w.ZeroSolution((1, 1)), [[0, 1], [1, 0]]),  # z'w = 2
            (w.ZeroSolution((1, 0)), [[0, 1], [-1, 0]]),  # w < 0
            (w.ZeroSolution((-1, 0)), [[0, 1], [-1, 0]]),
        ],
    ),
    (
        w.EquationSolution((1,), 1),
        [[-1]],
        [
            (w.EquationSolution((0,), 1), [[-1]]),
            (w.EquationSolution((1,), -1), [[1]]),
            (w.EquationSolution((1,), 1), [[1]]),
            (w.EquationSolution((1,), 1), [[-2]]),
        ],
    ),
    (
        w.NotStar((1, 0), 1),
        [[0, 1], [0, 0]],
        [
            (w.NotStar((1, 0), 0), [[0, 1], [0, 0]]),
            (w.NotStar((1, 0), 1), [[0, -1], [0, 0]]),
            (w.NotStar((1, 0), 1), [[1, 1], [0, 0]]),  # x solves nothing
        ],
    ),
    (
        w.NotStar((1, 0), 1, tilde=True),
        [[0, -1], [0, 0]],
        [
            (w.NotStar((1, 0), 1, tilde=True), [[0, -1], [1, 0]]),  # (Ax)_1 != 0
            (w.NotStar((1, 0), 0, tilde=True), [[0, -1], [0, 0]]),  # (A'x)_0 = 0
        ],
    ),
    (
        w.NoDiagonals((1, 0), (0, 1)),
        [[0, 1], [0, 0]],
        [
            (w.NoDiagonals((1, 0), (0, -1)), [[0, 1], [0, 0]]),
            (w.NoDiagonals((0, 0), (0, 1)), [[0, 1], [0, 0]]),
            (w.NoDiagonals((1, 0), (0, 1)), [[1, 1], [0, 0]]),  # x solves nothing
            (w.NoDiagonals((1, 0), (0, -1)), [[0, -1], [1, 0]]),  # u < 0 where w > 0
        ],
    ),
    (
        w.MixedGradient((1, 0)),
        [[-1, 1], [0, 0]],
        [
            (w.MixedGradient((1, 0)), [[1, -1], [0, 0]]),
            (w.MixedGradient((1, -1)), [[0, 1], [0, 0]]),
            (w.MixedGradient((1, 1)), [[0, -1], [0, 0]]),
        ],
    ),
    (
        w.NotMonotonePair((0,), (1,)),
        [[-1]],
        [
            (w.NotMonotonePair((1,), (0,)), [[-1]]),
            (w.NotMonotonePair((1,), (2,)), [[-1]]),
            (w.NotMonotonePair((-1,), (1,)), [[-1]]),
            (w.NotMonotonePair((0,), (-1,)), [[-1]]),
        ],
    ),
    (
        w.InSubmatrix((1,), w.Minor((0,), "< 0")),
        [[-1, 0], [0, 1]],
        [(w.InSubmatrix((0,), w.Minor((0,), "< 0")), [[-1, 0], [0, 1]])],
    ),
    (
        w.InTransform((0,), w.Minor((1,), "> 0")),
        [[1, 1], [1, 1]],
        [
            (w.InTransform((0,), w.Minor((1,), "> 0")), [[1, 1], [1, 2]]),
            (w.InTransform((0,), w.Minor((1,), "> 0")), [[0, 1], [1, 0]]),  # no transform
        ],
    ),
    (
        w.InTranspose(w.AllDecrease((1, 1))),
        [[-1, 1], [0, -2]],
        [(w.InTranspose(w.AllDecrease((1, 1))), [[-1, 0], [1, -1]])],
    ),
    (
        w.All((w.Minor((0,), "> 0"), w.Minor((1,), "> 0"))),
        [[0, 1], [1, 0]],
        [
            (w.All((w.Minor((0,), "> 0"), w.Minor((1,), "> 0"))), [[1, 1], [1, 0]]),
            (w.All((w.Minor((0,), "> 0"), w.Minor((1,), "> 0"))), [[0, 1], [1, 1]]),
        ],
    ),
    (
        r.Infeasible((-1, 0), (1, 0)),
        [[-1, 0], [0, 1]],
        [
            (r.Infeasible((0, -1), (0, 1)), [[-1, 0], [0, 1]]),  # A'y > 0
            (r.Infeasible((1, 0), (1, 0)), [[-1, 0], [0, 1]]),  # q'y > 0
            (r.Infeasible((0, 0), (1, 0)), [[-1, 0], [0, 1]]),
            (r.Infeasible((1, 0), (-1, 0)), [[1, 0], [0, 1]]),  # y < 0
        ],
    ),
    (
        r.IsolatedSolution((1,), (0,), (1,)),
        [[-1]],
        [
            (r.IsolatedSolution((1,), (0,), (0,)), [[-1]]),
            (r.IsolatedSolution((1,), (0,), (2,)), [[-1]]),
            (r.IsolatedSolution((1,), (2,), (1,)), [[-1]]),
            (r.IsolatedSolution((0,), (0,), (1,)), [[0]]),  # z + w = 0
            (r.IsolatedSolution((0,), (1,), (0,)), [[0]]),  # A[alpha, alpha] = 0
        ],
    ),
]


@pytest.mark.parametrize(("good", "A", "broken"), VECTORS, ids=lambda x: type(x).__name__)
def test_a_witness_with_one_statement_broken_is_refused(good, A, broken):
    assert refutes(good, A)
    for witness, B in broken:
        assert not refutes(witness, B), (witness, B)


def proves(certificate, A):
    return certificate.proves(read_matrix(A))


LDL = c.LDL((0, 1), ((1, 0), (1, 1)), (Fraction(2), Fraction(2)), definite=True)  # A + A' = [[2, 2], [2, 4]]
ROOT = c.LDL((0,), ((1,),), (Fraction(2),))
CERTIFICATES = [
    (
        LDL,
        [[1, 1], [1, 2]],
        [
            (LDL, [[1, 1], [2, 2]]),
            (replace(LDL, order=(1, 0)), [[1, 1], [1, 2]]),
            (replace(LDL, D=(Fraction(2), Fraction(0))), [[1, 1], [1, 1]]),  # semidefinite only
            (replace(LDL, D=(Fraction(2), Fraction(-2)), definite=False), [[1, 1], [1, 0]]),
            (replace(LDL, L=((2, 0), (2, 1)), D=(Fraction(1, 2), Fraction(2))), [[1, 1], [1, 2]]),  # L_11 = 2
            (c.LDL((0, 1), ((0, 1), (1, 0)), (Fraction(4), Fraction(2))), [[1, 0], [0, 2]]),  # L not triangular
        ],
    ),
    (replace(LDL, D=(Fraction(2), Fraction(0)), definite=False), [[1, 1], [1, 1]], []),
    (
        c.MinorSigns("> 0"),
        [[1, 2], [-3, 1]],
        [(c.MinorSigns("> 0"), [[1, 2], [3, 1]]), (c.MinorSigns("> 0"), [[0, 1], [-1, 1]])],
    ),
    (c.MinorSigns("> 0", proper=True), [[1, 2], [3, 1]], [(c.MinorSigns("> 0", proper=True), [[1, 2], [3, 0]])]),
    (
        c.PositiveVector((1, 1)),
        [[2, -1], [-1, 2]],
        [
            (c.PositiveVector((1, 1)), [[2, 1], [-1, 2]]),
            (c.PositiveVector((0, 0)), [[2, -1], [-1, 2]]),
            (c.PositiveVector((1, 1)), [[1, -1], [-1, 1]]),
            (c.PositiveVector((-1, -2)), [[-3, 0], [0, -1]]),
            (c.PositiveVector((1, 0)), [[1, -1], [0, 1]]),
        ],
    ),
    (
        c.Decomposition(((0, 4), (4, 0)), c.LDL((0, 1), ((1, 0), (0, 1)), (Fraction(2), Fraction(2)))),
        [[1, 3], [1, 1]],
        [
            (
                c.Decomposition(((0, 5), (3, 0)), c.LDL((0, 1), ((1, 0), (0, 1)), (Fraction(2), Fraction(2)))),
                [[1, 3], [1, 1]],
            ),
            (
                c.Decomposition(((0, 4), (4, 0)), c.LDL((0, 1), ((1, 0), (0, 1)), (Fraction(2), Fraction(2)))),
                [[1, 3], [1, 2]],
            ),
            (c.Decomposition(((-4,),), ROOT), [[-1]]),
        ],
    ),
    (
        c.MinkowskiFactor(((1, 0), (0, 1)), (1, 1)),
        [[1, -1], [-2, 1]],
        [
            (c.MinkowskiFactor(((1, 0), (0, 1)), (1, 1)), [[1, 1], [-2, 1]]),  # AX not in Z
            (c.MinkowskiFactor(((1, 0), (0, 1)), (1, 1)), [[1, -1], [2, 1]]),
            (c.MinkowskiFactor(((1, 0), (0, 1)), (1, 0)), [[1, -1], [-2, 1]]),
            (c.MinkowskiFactor(((0, 0), (0, 0)), (1, 1)), [[1, 2], [3, 1]]),  # v'X = 0
            (c.MinkowskiFactor(((1, 1), (0, 1)), (1, 1)), [[1, -1], [-2, 1]]),  # X not in Z
            (c.MinkowskiFactor(((-1, 0), (0, -1)), (-1, -1)), [[-1, 1], [2, -1]]),  # v < 0
        ],
    ),
]


@pytest.mark.parametrize(("good", "A", "broken"), CERTIFICATES, ids=lambda x: type(x).__name__)
def test_a_certificate_with_one_statement_broken_is_refused(good, A, broken):
    assert proves(good, A)
    for certificate, B in broken:
        assert not proves(certificate, B), (certificate, B)


def test_trees_of_orthants():
    A = [[1, 0], [0, -1]]  # Q0: infeasible where q_2 < 0
    good = classes.check(A, "Q0").certificate
    assert proves(good, A)
    assert good.infeasible
    assert not proves(replace(good, infeasible=((0, -1), *good.infeasible[1:])), A)
    assert not proves(replace(good, infeasible=((0, 0), *good.infeasible[1:])), A)
    assert not proves(replace(good, infeasible=((1, 0), *good.infeasible[1:])), A)
    assert not proves(good, [[1, 0], [0, 1]])
    for orthant, tree in good.trees.items():
        ((_, split),) = tree.steps  # each orthant lies in one cone
        assert split is None
        assert not proves(replace(good, trees={**good.trees, orthant: r.Tree(())}), A)
        up = [not orthant >> i & 1 for i in range(2)]
        for label in range(5):
            # cone 0: q >= 0; 1: q_1 <= 0 <= q_2; 2 and 3 as these, -A_2 = e_2; 4: q_2 <= 0
            inside = (up[0] != label & 1) and up[1] if label < 4 else not up[1]
            moved = {**good.trees, orthant: r.Tree(((label, None),))}
            assert proves(replace(good, trees=moved), A) == inside, (orthant, label)
    # Of two vectors the second is negative, but A'y <= 0 and y'q <= 0 on its orthant, q_1 >= 0 >= q_2.
    assert proves(replace(good, infeasible=((0, 1), (0, 1)), trees={**good.trees, 2: r.Tree(((5, None),))}), A)
    assert not proves(replace(good, infeasible=((0, 1), (-1, 1)), trees={**good.trees, 2: r.Tree(((5, None),))}), A)
    everywhere = classes.check([[2, -1], [-1, 2]], "Q").certificate
    assert everywhere.infeasible == ()


def test_a_member_is_one():
    """The check by 2^n eliminations in fractions against the kernel, on all matrices of order 2 and some of order 3."""
    rng = random.Random(3)
    matrices = [
        [list(a), list(b)]
        for a in itertools.product(range(-1, 2), repeat=2)
        for b in itertools.product(range(-1, 2), repeat=2)
    ]
    matrices += [[[rng.randint(-2, 2) for _ in range(3)] for _ in range(3)] for _ in range(150)]
    matrices += [[[1, -1, 0], [-1, 1, 0], [0, 0, 1]], [[0]], [[1, 1], [1, 1]], [[0, 0], [0, 0]]]
    for A in matrices:
        for symbol in ("E0", "E", "C0", "C"):
            assert refutes(w.Member(symbol), A) == classes.check(A, symbol).holds, (symbol, A)


def small_matrices(count, seed):
    rng = random.Random(seed)
    for k in range(count):
        n = 2 + k % 2
        A = [[rng.randint(-2, 2) for _ in range(n)] for _ in range(n)]
        if rng.random() < 0.6:
            for i in range(n):
                A[i][i] = abs(A[i][i])
        yield A


def test_no_witness_refutes_a_member_and_no_certificate_proves_another():
    """What `check` accepts for some matrix is true of every matrix for which it accepts it."""
    members, proofs, others = {}, {}, {}
    for A in small_matrices(60, seed=1):
        for symbol in (s for s in classes.CLASSES if s not in ("Ec", "cQ0")):
            verdict = classes.check(A, symbol)
            assert verdict.check() is not False
            if verdict:
                members.setdefault(symbol, []).append(verdict)
                if verdict.certificate is not None:
                    proofs.setdefault(symbol, []).append(verdict)
            else:
                assert verdict.check() is True
                others.setdefault(symbol, []).append(verdict)
    pairs = 0
    for symbol, found in others.items():
        for outsider, member in itertools.product(found[:12], members.get(symbol, ())[:12]):
            if len(outsider.matrix) == len(member.matrix):
                assert not outsider.witness.refutes(member.matrix), (symbol, outsider.witness, member.matrix)
                pairs += 1
        for member, outsider in itertools.product(proofs.get(symbol, ())[:12], found[:12]):
            if len(outsider.matrix) == len(member.matrix):
                assert not member.certificate.proves(outsider.matrix), (symbol, member.certificate, outsider.matrix)
                pairs += 1
    assert pairs > 1500


def test_a_verdict_on_another_matrix_or_of_the_other_kind_implies_nothing():
    A, B = read_matrix([[2, 1], [1, 2]]), read_matrix([[1, 2], [2, 1]])
    yes, no = classes.check(A, "PD"), classes.check(B, "PD")
    assert w.Implied((yes,), "PD is contained in P").proves(A)
    assert w.Implied((no,), "not in PSD").refutes(B)
    assert not w.Implied((yes,), "").proves(B)
    assert not w.Implied((no,), "").refutes(A)
    assert not w.Implied((yes,), "").refutes(A)
    assert not w.Implied((no,), "").proves(B)
    tampered = replace(yes, _certificate=c.LDL((0, 1), ((1, 0), (0, 1)), (Fraction(1), Fraction(1))))
    assert not w.Implied((yes, tampered), "").proves(A)
    assert not w.Implied((no, replace(no, witness=w.FormValue((1, 1)))), "").refutes(B)


@pytest.mark.parametrize("n", [1, 2, 9])
def test_a_certificate_of_k0_sees_the_positive_entry(n):
    """A singular Z-matrix with a PSD symmetric part, and its mirror image, which is P0 and not in Z."""
    laplacian = [
        [(min(1, n - 1) + (0 < i < n - 1)) if i == j else -(abs(i - j) == 1) for j in range(n)] for i in range(n)
    ]
    mirrored = [[x * (-1) ** (i + j) for j, x in enumerate(row)] for i, row in enumerate(laplacian)]
    proof = classes.check(laplacian, "K0").certificate
    assert proves(proof, laplacian)
    assert classes.check(mirrored, "P0")
    assert proves(proof, mirrored) == (n == 1)
    assert not proves(proof, [[-x for x in row] for row in laplacian]) or n == 1


def test_strategies_of_a_game_prove_its_value():
    good = classes.game([[0, 2], [1, 0]])
    assert good.check()
    half, third = Fraction(1, 2), Fraction(1, 3)
    assert not replace(good, value=good.value + third).check()
    assert not replace(good, value=good.value - third).check()
    assert not replace(good, x=(half, half)).check()
    assert not replace(good, y=(half, half)).check()
    assert not replace(good, x=tuple(2 * v for v in good.x)).check()
    assert not replace(good, y=tuple(v / 2 for v in good.y)).check()
    zero = classes.game([[0, 0], [0, 0]])
    assert not replace(zero, x=(2, -1)).check()
    assert not replace(zero, y=(-1, 2)).check()
