"""Witnesses about regions of space: cones, trees of cones, pieces of a solution set."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace
from fractions import Fraction

from lcpstar import classes
from lcpstar.classes import regions as r
from lcpstar.classes.exact import read_matrix, solve, transpose


def refutes(witness, A):
    return witness.refutes(read_matrix(A))


UNSOLVABLE = [[-1, 1], [-1, 2]]  # q = (-1, -1) is feasible and has no solution


def test_a_q_without_solution_is_separated_from_every_complementary_cone():
    good = classes.check(UNSOLVABLE, "Q0").witness
    assert isinstance(good, r.Unsolvable)
    assert refutes(good, UNSOLVABLE)
    assert not refutes(replace(good, separations=good.separations[:3]), UNSOLVABLE)
    assert not refutes(replace(good, z=tuple(-1 - v for v in good.z)), UNSOLVABLE)
    assert not refutes(replace(good, z=(0, 0)), UNSOLVABLE)
    for k in range(4):
        for y in ((0, 0), tuple(-v for v in good.q)):  # y'q = 0; y'q < 0, which not every cone allows
            separations = (*good.separations[:k], y, *good.separations[k + 1 :])
            columns = r.cone_columns(read_matrix(UNSOLVABLE), k)
            separates = any(y) and all(sum(a * b for a, b in zip(y, column, strict=True)) >= 0 for column in columns)
            assert refutes(replace(good, separations=separations), UNSOLVABLE) == separates
    # A feasible point must be nonnegative and feasible, each for itself.
    A = [[1, 0], [0, 1]]
    none = r.Unsolvable((-1, -1), (-1, -1), ((1, 1),) * 4)
    assert not refutes(none, A)


def test_a_negative_point_is_not_feasible():
    """w = A z + q >= 0 for z = -1, and q has no solution because it is infeasible."""
    assert not refutes(r.Unsolvable((-1,), (-1,), ((1,), (1,))), [[-1]])
    assert refutes(r.Unsolvable((-1,), (0,), ((1,), (1,))), [[-1]]) is False


def test_groups_of_solutions_that_do_not_meet():
    """z in {0} and {1} for A = -1, q = 1; the whole of [0, oo) for A = 0, q = 0."""
    good = r.Disconnected((1,), {0: (0,), 1: (1,)}, {0: 0, 1: 1}, ((0, 1, (-1,)), (0, 1, (-1,))))
    assert refutes(good, [[-1]]) == bool(classes.check([[-1]], "Ec").holds is False)
    assert not refutes(replace(good, separations=()), [[-1]])
    assert not refutes(replace(good, component={0: 0, 1: 0}), [[-1]])
    assert not refutes(replace(good, points={0: (1,), 1: (1,)}), [[-1]])  # in another piece
    assert not refutes(replace(good, points={0: (0,), 1: (2,)}), [[-1]])  # no solution
    assert not refutes(replace(good, points={0: (0,)}), [[-1]])  # piece 1 is not shown to be empty
    assert not refutes(r.Disconnected((0,), {0: (0,), 1: (1,)}, {0: 0, 1: 1}, ((0, 1, (-1,)),)), [[0]])
    assert not refutes(r.Disconnected((0,), {0: (0,), 1: (1,)}, {0: 0, 1: 1}, ((0, 1, (0,)),)), [[0]])


def test_every_piece_and_every_separation_counts():
    # A = -I, q = e: the four corners of a square.
    A, left, down = [[-1, 0], [0, -1]], (-1, 0), (0, -1)
    corners = {0: (0, 0), 1: (1, 0), 2: (0, 1), 3: (1, 1)}
    pairs = ((0, 1, left), (0, 2, down), (1, 2, left), (0, 3, left), (1, 3, down), (2, 3, left))
    good = r.Disconnected((1, 1), corners, {k: k for k in corners}, pairs)
    assert refutes(good, A)
    three = {k: corners[k] for k in range(3)}  # the fourth piece might join them
    assert not refutes(replace(good, points=three, component={k: k for k in three}), A)
    # A = 0, q = (0, 1): the half line of all (z_1, 0), in two pieces; the others are empty.
    empty = ((2, 2, down), (3, 3, down))
    line = r.Disconnected((0, 1), {0: (0, 0), 1: (1, 0)}, {0: 0, 1: 1}, (*empty, (0, 1, down)))
    assert not refutes(line, [[0, 0], [0, 0]])


def test_a_ray_between_two():
    p, q = (1, 0, 0), (0, 1, 0)
    assert r._between(p, q, (2, 3, 0))
    for ray in ((1, 0, 0), (0, 1, 0), (2, -1, 0), (-1, 2, 0), (1, 1, 1), (-1, -1, 0), (0, 0, 0)):
        assert not r._between(p, q, ray), ray
    assert not r._between(p, (2, 0, 0), (3, 0, 0))


def test_a_nonnegative_combination():
    assert r.in_cone([(1, 0), (1, 1)], (2, 1))
    assert r.in_cone([(1, 0), (1, 1)], (0, 0))
    for x in ((0, 1), (-1, 0), (1, 2)):
        assert not r.in_cone([(1, 0), (1, 1)], x), x


def test_a_nonnegative_combination_is_found_where_a_choice_of_generators_finds_one():
    rng = random.Random(4)
    for _ in range(500):
        n = rng.randint(1, 3)
        generators = [tuple(int(i == j) for j in range(n)) for i in range(n)]
        generators += [tuple(rng.randint(-2, 2) for _ in range(n)) for _ in range(rng.randint(0, 3))]
        x = tuple(rng.randint(-2, 2) for _ in range(n))
        weights = [solve(transpose(choice), x) for choice in itertools.combinations(generators, n)]
        expected = any(found is not None and min(found) >= 0 for found in weights)
        assert r.in_cone(generators, x) == expected, (generators, x)


def test_a_tree_covers_what_it_says():
    cone = [(Fraction(1), Fraction(0)), (Fraction(0), Fraction(1))]
    whole, halves = r.Tree(((7, None),)), r.Tree(((0, (1, (1, 1))), (5, None), (6, None)))
    assert whole.leaves(cone) == [(cone, 7)]
    assert sorted(halves.leaves(cone), key=lambda leaf: leaf[1]) == [
        ([(1, 1), (0, 1)], 5),
        ([(1, 0), (1, 1)], 6),
    ]
    assert r.Tree(halves.steps[:2]).leaves(cone) is None  # a part left over
    assert r.Tree((*whole.steps, *whole.steps)).leaves(cone) is None  # a leaf too many
    assert r.Tree(()).leaves(cone) is None
    assert r.Tree(((0, (1, (1, -1))), (5, None), (6, None))).leaves(cone) is None


def test_shadows_cover_the_orthant():
    A = [[1, 5], [5, 1]]
    good = classes.check(A, "++").witness
    assert isinstance(good, r.AllShadowed)
    assert refutes(good, A)
    steps = good.tree.steps
    assert not refutes(r.AllShadowed(r.Tree(steps[:-1])), A)
    # Neither pos{e_2, A_2} nor pos{e_1, A_1} is the whole orthant.
    for label in (0, 1):
        assert not refutes(r.AllShadowed(r.Tree(((label, None),))), A)
