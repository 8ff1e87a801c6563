//! Q, Q0: for which q does LCP(q, A) have a solution; and (++).

use super::budget::{Budget, Search};
use super::cover::{Covering, Family, Member, Step};
use crate::cone::Cone;
use crate::elimination::principal_pivot_transform;
use crate::imatrix::{IMatrix, indices};
use crate::int::Int;
use crate::lp::{Feasibility, feasible};

/// Whether LCP(q, A) is solvable for every q with a feasible point.
#[derive(Clone, Debug)]
pub enum Solvable {
    /// Orthant by orthant (bit i set: `q_i <= 0`), a tree that covers it. Labels below `2^n` are complementary index
    /// sets; `2^n + k` is the half space `y_k q <= 0` of infeasible q.
    Everywhere(Vec<(u64, Vec<Step>)>),
    /// A feasible q without solution.
    Not(Vec<Int>),
}

/// The columns of the complementary cone of `alpha`: `-A_j` for j in alpha, `e_j` otherwise.
#[must_use]
pub fn complementary_columns(a: &IMatrix, alpha: u64) -> Vec<Vec<Int>> {
    (0..a.rows()).map(|j| column(a, j, alpha >> j & 1 == 1)).collect()
}

/// `-A_j`, or `e_j`.
#[must_use]
pub fn column(a: &IMatrix, j: usize, pivoted: bool) -> Vec<Int> {
    (0..a.rows()).map(|i| if pivoted { -a.at(i, j) } else { Int::from(i64::from(i == j)) }).collect()
}

/// The facets of a full-dimensional complementary cone: `q -> z_i` for i in alpha, `q -> w_i` otherwise.
#[must_use]
pub fn complementary_facets(a: &IMatrix, alpha: u64) -> Option<Vec<Vec<Int>>> {
    let n = a.rows();
    let (m, t) = principal_pivot_transform(a, &indices(alpha))?;
    let facet = |i: usize| {
        (0..n)
            .map(|j| match (alpha >> j & 1 == 1, i == j) {
                (true, _) => -m.at(i, j),
                (false, true) => t.clone(),
                (false, false) => Int::ZERO,
            })
            .collect()
    };
    Some((0..n).map(facet).collect())
}

/// The generators of `{y >= 0 : A'y <= 0}`; `y q < 0` proves that LCP(q, A) is infeasible.
#[must_use]
pub fn infeasibility_rays(a: &IMatrix) -> Vec<Vec<Int>> {
    let n = a.rows();
    let mut cone = Cone::orthant(n);
    for j in 0..n {
        cone.nonnegative((0..n).map(|i| -a.at(i, j)).collect());
    }
    cone.rays()
}

/// For each of the `2^n` index sets a vector that separates q from its complementary cone; `None` if one contains q.
///
/// # Errors
/// `Stopped` by the budget.
pub fn separate(a: &IMatrix, q: &[Int], budget: &Budget<'_>) -> Search<Option<Vec<Vec<Int>>>> {
    let mut separating = Vec::new();
    for alpha in 0..1u64 << a.rows() {
        budget.poll_each()?;
        match feasible(&complementary_columns(a, alpha), q) {
            Feasibility::Point(..) => return Ok(None),
            Feasibility::Farkas(y) => separating.push(y),
        }
    }
    Ok(Some(separating))
}

/// `(z, t)` with `z >= 0, A z + t q >= 0, t > 0`, if FEA(q, A) is not empty.
#[must_use]
pub fn feasible_point(a: &IMatrix, q: &[Int]) -> Option<(Vec<Int>, Int)> {
    let n = a.rows();
    let columns: Vec<Vec<Int>> =
        [true, false].iter().flat_map(|&pivoted| (0..n).map(move |j| column(a, j, pivoted))).collect();
    match feasible(&columns, q) {
        Feasibility::Point(mut x, t) => {
            x.truncate(n);
            Some((x, t))
        }
        Feasibility::Farkas(_) => None,
    }
}

/// Decides Q0 by covering space with the full-dimensional complementary cones and the infeasible half spaces.
///
/// The others have no interior, and both K(A) and pos(I, -A) are closed, so they cannot matter.
///
/// # Errors
/// `Stopped` by the budget.
pub fn solvable_when_feasible(a: &IMatrix, budget: &Budget<'_>) -> Search<Solvable> {
    let n = a.rows();
    let mut members: Vec<Member> = Vec::new();
    let mut degenerate: Vec<u64> = Vec::new();
    for alpha in 0..1u64 << n {
        budget.poll()?;
        match complementary_facets(a, alpha) {
            Some(facets) => members.push(Member { label: alpha as usize, facets }),
            None => degenerate.push(alpha),
        }
    }
    for (k, y) in infeasibility_rays(a).iter().enumerate() {
        members.push(Member { label: (1 << n) + k, facets: vec![y.iter().map(|v| -v).collect()] });
    }
    let is_hole = |q: &[Int]| {
        degenerate.iter().all(|&alpha| matches!(feasible(&complementary_columns(a, alpha), q), Feasibility::Farkas(_)))
    };
    let family = Family::new(&members, &is_hole);
    let mut proof = Vec::new();
    budget.begin(1 << n);
    for orthant in 0..1u64 << n {
        budget.step()?;
        let sign = |i: usize| if orthant >> i & 1 == 1 { -1 } else { 1 };
        let corner = (0..n).map(|i| (0..n).map(|j| Int::from(if i == j { sign(i) } else { 0 })).collect()).collect();
        match family.cover(corner, budget)? {
            Covering::Covered(steps) => proof.push((orthant, steps)),
            Covering::Hole(q) => return Ok(Solvable::Not(q)),
        }
    }
    Ok(Solvable::Everywhere(proof))
}

/// The (++)-property: some nonsingular M-matrix X has AX in Z.
#[derive(Clone, Debug)]
pub enum PlusPlus {
    /// `v > 0` and X (row-major) with X and AX in Z and `v'X > 0`.
    Holds(Vec<Int>, Vec<Int>),
    /// A tree covering the orthant by the cones `pos{e_i, A_i. : i != j}`, labelled j; no `v > 0` is outside all of them.
    Fails(Vec<Step>),
}

/// Decides (++). Column j of X needs `x_i <= 0, (Ax)_i <= 0` for `i != j` and `v x > 0`, which by Farkas exists exactly
/// when v is outside `pos{e_i, A_i. : i != j}`.
///
/// # Errors
/// `Stopped` by the budget.
pub fn plus_plus(a: &IMatrix, budget: &Budget<'_>) -> Search<PlusPlus> {
    let n = a.rows();
    let unit = |i: usize| (0..n).map(|j| Int::from(i64::from(i == j))).collect::<Vec<_>>();
    let generators =
        |j: usize| (0..n).filter(|&i| i != j).flat_map(|i| [unit(i), a.row(i).to_vec()]).collect::<Vec<_>>();
    let mut members = Vec::new();
    // If column j of A is zero off the diagonal, the cone of j lies in v_j = 0 and contains no v > 0.
    for j in (0..n).filter(|&j| (0..n).any(|i| i != j && !a.at(i, j).is_zero())) {
        let mut dual = Cone::new(n);
        generators(j).into_iter().for_each(|g| dual.nonnegative(g));
        members.push(Member { label: j, facets: dual.rays_unless(|| budget.poll())? });
    }
    match Family::new(&members, &|_| true).cover((0..n).map(unit).collect(), budget)? {
        Covering::Covered(steps) => Ok(PlusPlus::Fails(steps)),
        Covering::Hole(v) => {
            let mut x = vec![Int::ZERO; n * n];
            for j in 0..n {
                if let Feasibility::Farkas(y) = feasible(&generators(j), &v) {
                    for i in 0..n {
                        x[i * n + j] = -&y[i];
                    }
                }
            }
            Ok(PlusPlus::Holds(v, x))
        }
    }
}
