"""`solutions`: complete sets with known counts, degenerate sets, agreement with brute force."""

from __future__ import annotations

import copy
import itertools
import math
import pickle
import time
from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.sparse import csr_array

import lcpstar

# von Stengel, New maximal numbers of equilibria in bimatrix games, Discrete Comput. Geom. 21 (1999).
GAME_C = [
    [379, 262, 424, 172, 334, 208],
    [478, 226, 631, 1, 451, 28],
    [278, 301, 256, 331, 281, 328],
    [328, 281, 331, 256, 301, 278],
    [28, 451, 1, 631, 226, 478],
    [208, 334, 172, 424, 262, 379],
]
GAME_D = [
    [226, 478, 1, 631, 28, 451],
    [262, 379, 172, 424, 208, 334],
    [281, 328, 256, 331, 278, 301],
    [301, 278, 331, 256, 328, 281],
    [334, 208, 424, 172, 379, 262],
    [451, 28, 631, 1, 478, 226],
]


def exact_dot(row, z):
    return sum((Fraction(a) * x for a, x in zip(row, z, strict=True)), Fraction(0))


def assert_solves(A, q, z):
    w = [exact_dot(np.asarray(A, float)[i].tolist(), z) + Fraction(float(q[i])) for i in range(len(q))]
    assert all(x >= 0 for x in z)
    assert all(x >= 0 for x in w)
    assert all(x == 0 or y == 0 for x, y in zip(z, w, strict=True))


def assert_faces_solve(A, q, faces):
    for face in faces:
        assert len(face.vertices) >= 1
        for v in face.vertices:
            assert_solves(A, q, v)
        middle = [sum(c, Fraction(0)) / len(face.vertices) for c in zip(*face.vertices, strict=True)]
        far = [m + 3 * sum((r[j] for r in face.rays), Fraction(0)) for j, m in enumerate(middle)]
        assert_solves(A, q, far)
        assert [j for j, x in enumerate(far) if x > 0] == face.alpha


def basic_solutions(A, q):
    """Every nonsingular complementary basis, in fractions: the 2^n oracle."""
    n, found = len(q), set()
    for size in range(n + 1):
        for alpha in itertools.combinations(range(n), size):
            rows = [[Fraction(float(A[i][j])) for j in alpha] + [-Fraction(float(q[i]))] for i in alpha]
            part = gauss(rows)
            if part is None:
                continue
            z = [Fraction(0)] * n
            for i, x in zip(alpha, part, strict=True):
                z[i] = x
            w = [exact_dot([float(a) for a in A[i]], z) + Fraction(float(q[i])) for i in range(n)]
            if min(z + w, default=0) >= 0:
                found.add(tuple(z))
    return found


def gauss(rows):
    k = len(rows)
    for c in range(k):
        pivot = next((r for r in range(c, k) if rows[r][c] != 0), None)
        if pivot is None:
            return None
        rows[c], rows[pivot] = rows[pivot], rows[c]
        rows[c] = [x / rows[c][c] for x in rows[c]]
        for r in range(k):
            if r != c and rows[r][c] != 0:
                rows[r] = [x - rows[r][c] * y for x, y in zip(rows[r], rows[c], strict=True)]
    return [row[-1] for row in rows]


def test_von_stengels_game_has_75_solutions():
    zero = np.zeros((6, 6))
    A = np.block([[zero, np.array(GAME_C)], [np.array(GAME_D), zero]])
    q = -np.ones(12)
    start = time.perf_counter()
    faces = lcpstar.solutions(A, q, exact=True)
    elapsed = time.perf_counter() - start
    assert len(faces) == 75
    assert all(face.is_point for face in faces)
    assert_faces_solve(A, q, faces)
    assert elapsed < 2.0
    assert sum(len(f.alpha) == 12 for f in faces) == 1  # one completely mixed equilibrium


def test_the_paper_example_has_three_solutions():
    A, q = [[0, 1, 1], [2, 0, 2], [-2, -5, 0]], [-4, -7, 10]
    faces = lcpstar.solutions(A, q, exact=True)
    F = Fraction
    assert {tuple(f.vertices[0]) for f in faces} == {
        (F(0), F(2), F(7, 2)),
        (F(5), F(0), F(4)),
        (F(15, 14), F(11, 7), F(17, 7)),
    }
    assert_faces_solve(A, q, faces)


@pytest.mark.parametrize("n", [1, 3, 6])
def test_zero_matrix_and_zero_q_give_the_orthant(n):
    (face,) = lcpstar.solutions(np.zeros((n, n)), np.zeros(n))
    assert face.alpha == list(range(n))
    assert face.vertices.tolist() == [[0.0] * n]
    assert sorted(face.rays.tolist()) == sorted(np.eye(n).tolist())


def test_the_empty_problem_has_the_empty_solution():
    (face,) = lcpstar.solutions(np.zeros((0, 0)), [])
    assert face.vertices.shape == (1, 0)


def test_no_solution_no_face():
    assert lcpstar.solutions([[0.0, 0.0], [0.0, 1.0]], [-1.0, 1.0]) == []
    assert lcpstar.solutions([[-1.0]], [-1.0]) == []


def test_a_segment_and_a_point():
    # SOL of [[1, 1], [1, 1]] is the segment; with q = (-1, -2) only the stronger row holds with equality.
    (face,) = lcpstar.solutions([[1, 1], [1, 1]], [-1, -1])
    assert sorted(face.vertices.tolist()) == [[0.0, 1.0], [1.0, 0.0]]
    (face,) = lcpstar.solutions([[1, 1], [1, 1]], [-1, -2])
    assert face.vertices.tolist() == [[0.0, 2.0]]


@pytest.mark.parametrize("seed", range(12))
def test_random_dense_problems_agree_with_all_bases(seed):
    rng = np.random.default_rng(seed)
    n = 5 + seed % 3
    A, q = rng.standard_normal((n, n)), rng.standard_normal(n)
    faces = lcpstar.solutions(A, q, exact=True)
    assert {tuple(f.vertices[0]) for f in faces} == basic_solutions(A, q)
    assert all(f.is_point for f in faces)


@pytest.mark.parametrize("seed", range(20))
def test_degenerate_integer_problems_contain_all_bases(seed):
    rng = np.random.default_rng(100 + seed)
    n = 2 + seed % 4
    A, q = rng.integers(-1, 2, (n, n)), rng.integers(-1, 2, n)
    faces = lcpstar.solutions(A, q, exact=True)
    assert_faces_solve(A, q, faces)
    vertices = {tuple(v) for f in faces for v in f.vertices}
    assert basic_solutions(A, q) <= vertices
    # Maximal: no face inside another.
    sets = [({tuple(v) for v in f.vertices}, {tuple(r) for r in f.rays}) for f in faces]
    assert not any(a is not b and a[0] <= b[0] and a[1] <= b[1] for a in sets for b in sets)


def test_scaling_carries_the_solutions():
    rng = np.random.default_rng(3)
    n = 6
    A, q = rng.standard_normal((n, n)), -rng.random(n)
    r, c = 2.0 ** rng.integers(-60, 60, n), 2.0 ** rng.integers(-60, 60, n)
    plain = lcpstar.solutions(A, q, exact=True)
    scaled = lcpstar.solutions(r[:, None] * A * c, r * q, exact=True)
    assert [f.alpha for f in plain] == [f.alpha for f in scaled]
    for f, g in zip(plain, scaled, strict=True):
        back = [x * Fraction(float(s)) for x, s in zip(g.vertices[0], c, strict=True)]
        assert back == f.vertices[0]


def test_generic_problems_at_n_16_are_quick():
    times = []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        A, q = rng.standard_normal((16, 16)), rng.standard_normal(16)
        start = time.perf_counter()
        faces = lcpstar.solutions(A, q, exact=True)
        times.append(time.perf_counter() - start)
        assert_faces_solve(A, q, faces)
    assert max(times) < 10.0


def test_a_time_limit_is_an_exception_that_says_so():
    rng = np.random.default_rng(0)
    with pytest.raises(lcpstar.errors.TimeLimitError, match="time_limit"):
        lcpstar.solutions(rng.standard_normal((60, 60)), -np.ones(60), time_limit=0.05)
    with pytest.raises(lcpstar.errors.TooLargeError, match="127"):
        lcpstar.solutions(np.zeros((200, 200)), np.zeros(200))


def test_float_vertices_are_the_rounded_fractions():
    rng = np.random.default_rng(8)
    A, q = rng.standard_normal((7, 7)), -rng.random(7)
    exact = lcpstar.solutions(A @ A.T, q, exact=True)
    rounded = lcpstar.solutions(A @ A.T, q)
    assert len(exact) == 1
    for x, y in zip(exact[0].vertices[0], rounded[0].vertices[0], strict=True):
        assert math.isclose(float(x), y, rel_tol=1e-15, abs_tol=0.0)


def inside(face, z):
    """Whether z is a convex combination of the vertices plus a cone combination of the rays (one LP)."""
    m, k = len(face.vertices), len(face.rays)
    columns = np.vstack([face.vertices, face.rays]).T
    weights = np.concatenate([np.ones(m), np.zeros(k)])
    fit = linprog(np.zeros(m + k), A_eq=np.vstack([columns, weights]), b_eq=np.append(z, 1.0))
    return fit.status == 0


def test_every_point_of_every_degenerate_piece_is_in_some_face():
    points = 0
    for seed in range(25):
        rng = np.random.default_rng(500 + seed)
        n = 4
        A, q = rng.integers(-1, 2, (n, n)).astype(float), rng.integers(-1, 1, n).astype(float)
        faces = lcpstar.solutions(A, q)
        for mask in range(2**n):
            alpha = [i for i in range(n) if mask >> i & 1]
            rest = [i for i in range(n) if i not in alpha]
            bounds = [(0, 9.5) if i in alpha else (0, 0) for i in range(n)]
            for _ in range(2):
                found = linprog(
                    rng.standard_normal(n),
                    A_ub=-A[rest] if rest else None,
                    b_ub=q[rest] if rest else None,
                    A_eq=A[alpha] if alpha else None,
                    b_eq=-q[alpha] if alpha else None,
                    bounds=bounds,
                )
                if found.status == 0:
                    points += 1
                    assert any(inside(face, found.x) for face in faces), (seed, alpha, found.x)
                else:
                    assert found.status == 2  # the piece is empty
    assert points > 60


def test_the_two_doors_to_the_solution_set_list_the_same_maximal_faces():
    rng = np.random.default_rng(5)
    for _ in range(60):
        n = int(rng.integers(1, 5))
        A, q = rng.integers(-1, 2, (n, n)), rng.integers(-1, 2, n)
        one, other = lcpstar.solutions(A, q, exact=True), lcpstar.solution_set(A, q)
        one.sort(key=lambda face: sum(1 << i for i in face.alpha))
        key = [(tuple(f.alpha), {tuple(v) for v in f.vertices}, {tuple(r) for r in f.rays}) for f in one]
        largest = [tuple(tuple(Fraction(x, max(r)) for x in r) for r in f.rays) for f in other.faces]
        assert [(f.alpha, set(f.vertices), set(r)) for f, r in zip(other.faces, largest, strict=True)] == key


def test_the_solution_set_of_a_zero_matrix_is_one_face_at_every_order():
    for n in (8, 12):
        found = lcpstar.solution_set(np.zeros((n, n)), np.zeros(n))
        assert (len(found.faces), found.components, found.convex, found.bounded) == (1, 1, True, False)
        assert found.faces[0].alpha == tuple(range(n))


def test_rationals_and_integers_that_are_no_doubles_have_the_faces_of_their_multiples():
    """Row factors of 1/3 make doubles; 10^40 + 1 does not and takes the exact kernel, which must agree."""
    plain = lcpstar.solution_set([[1, 1, 0], [1, 1, 0], [0, 0, 0]], [-1, -1, 0])
    thirds = lcpstar.solution_set([["1/3", "1/3", 0], ["1/7", "1/7", 0], [0, 0, 0]], ["-1/3", "-1/7", 0])
    b = 10**40 + 1
    big = lcpstar.solution_set([[b, b + 1, 0], [b, b + 1, 0], [0, 0, 0]], [-b, -b, 0])
    assert thirds.faces == plain.faces
    assert [(f.alpha, len(f.vertices), f.rays) for f in big.faces] == [
        (f.alpha, len(f.vertices), f.rays) for f in plain.faces
    ]
    assert (big.components, big.convex) == (plain.components, plain.convex)
    assert set(big.faces[0].vertices) == {(0, Fraction(b, b + 1), 0), (1, 0, 0)}
    for z in big.faces[0].vertices:
        assert big.local(z).locally_unique is False


def test_a_solution_set_can_be_copied():
    found = lcpstar.solution_set([[-1]], [1])
    found.local([1])
    for twin in (copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert twin.faces == found.faces
        assert twin.components == 2
        assert twin.local([0]).locally_unique


def test_exact_input_is_taken_as_it_is():
    A, q = [["1/3", Fraction(1, 3)], [1, 2**70 + 1]], ["-1/3", -(2**70) - 1]
    for face in lcpstar.solutions(A, q, exact=True):
        for z in face.vertices:
            w = [
                sum(Fraction(a) * x for a, x in zip(row, z, strict=True)) + Fraction(c)
                for row, c in zip(A, q, strict=True)
            ]
            assert all(x >= 0 and y >= 0 and x * y == 0 for x, y in zip(z, w, strict=True))
    assert len(lcpstar.solutions(A, q)) == 1
    plain, thirds = [[1, 1], [1, 1]], [["1/3", "1/3"], ["1/3", "1/3"]]
    for one, other in zip(lcpstar.solutions(plain, [-1, -1]), lcpstar.solutions(thirds, ["-1/3", "-1/3"]), strict=True):
        assert (one.alpha, one.vertices.tolist()) == (other.alpha, other.vertices.tolist())
    sparse = lcpstar.solutions(csr_array(np.array([[-1.0]])), [1.0])
    assert [face.vertices.tolist() for face in sparse] == [[[0.0]], [[1.0]]]
    with pytest.raises(lcpstar.errors.NotFiniteError, match="exact=True"):
        lcpstar.solutions([["1e-400"]], [-1])


def test_a_time_limit_of_the_exact_kernel_says_so():
    A = [[10**40 + i + j for j in range(12)] for i in range(12)]
    with pytest.raises(lcpstar.errors.TimeLimitError):
        lcpstar.solution_set(A, [-1] * 12, time_limit=0.01)
