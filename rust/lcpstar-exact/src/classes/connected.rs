//! Connectedness of SOL(q, A) for one q, and for all q (the class E_c).
//!
//! SOL(q, A) is the union of the convex pieces `P_alpha = {z : z = 0 off alpha, w = 0 on alpha}`; pieces alpha and beta
//! meet exactly when q is in the cone of `e_i` (i in neither) and `-A_i` (i in both). All of this is constant on the
//! relatively open cells of a refinement of space by the facets of those cones. Space starts as the fan of orthants
//! and is split lazily: a cell with at most one candidate piece needs no further look.

use super::budget::{Budget, Search};
use super::solvable::{column, complementary_columns, complementary_facets};
use crate::cone::Cone;
use crate::elimination::reduce;
use crate::imatrix::IMatrix;
use crate::int::{Int, dot, make_primitive};
use crate::lp::{Feasibility, feasible};
use std::collections::HashMap;

/// The columns of the cone of q for which `P_alpha` and `P_beta` meet.
fn meeting_columns(a: &IMatrix, alpha: u64, beta: u64) -> Vec<Vec<Int>> {
    (0..a.rows()).filter(|&j| (alpha ^ beta) >> j & 1 == 0).map(|j| column(a, j, alpha >> j & 1 == 1)).collect()
}

/// A nonempty piece of SOL(q, A).
#[derive(Clone, Debug)]
pub struct Piece {
    /// z vanishes off alpha, w on alpha.
    pub alpha: u64,
    /// Its component.
    pub component: usize,
    /// A point is `z / t`.
    pub z: Vec<Int>,
    /// Positive.
    pub t: Int,
}

/// The pieces of SOL(q, A) by component, and the proof that nothing was missed.
#[derive(Clone, Debug)]
pub struct Components {
    /// Each nonempty piece, its component, and a point `z / t` of it.
    pub pieces: Vec<Piece>,
    /// `(alpha, alpha, y)`: y separates q from the cone of an empty piece; `(alpha, beta, y)`: two pieces that do not meet.
    pub separations: Vec<(u64, u64, Vec<Int>)>,
    /// Number of components.
    pub count: usize,
}

/// The components of SOL(q, A), exact. 4^n small linear programs.
///
/// # Errors
/// `Stopped` by the budget.
pub fn components(a: &IMatrix, q: &[Int], budget: &Budget<'_>) -> Search<Components> {
    let mut separations = Vec::new();
    let mut alive: Vec<u64> = Vec::new();
    let mut points = Vec::new();
    for alpha in 0..1u64 << a.rows() {
        budget.poll()?;
        match feasible(&complementary_columns(a, alpha), q) {
            Feasibility::Point(mut z, t) => {
                (0..a.rows()).filter(|&i| alpha >> i & 1 == 0).for_each(|i| z[i] = Int::ZERO);
                alive.push(alpha);
                points.push((z, t));
            }
            Feasibility::Farkas(y) => separations.push((alpha, alpha, y)),
        }
    }
    let mut component: Vec<usize> = (0..alive.len()).collect();
    let mut apart = Vec::new();
    for i in 0..alive.len() {
        for j in 0..i {
            budget.poll()?;
            match feasible(&meeting_columns(a, alive[i], alive[j]), q) {
                Feasibility::Point(..) => merge(&mut component, i, j),
                Feasibility::Farkas(y) => apart.push((i, j, y)),
            }
        }
    }
    for (i, j, y) in apart {
        if component[i] != component[j] {
            separations.push((alive[i], alive[j], y));
        }
    }
    let mut names: Vec<usize> = component.clone();
    names.sort_unstable();
    names.dedup();
    let name = |c: usize| names.iter().position(|&x| x == c).unwrap_or_default();
    let pieces = alive
        .iter()
        .zip(&component)
        .zip(points)
        .map(|((&alpha, &c), (z, t))| Piece { alpha, component: name(c), z, t })
        .collect();
    Ok(Components { pieces, separations, count: names.len() })
}

fn merge(component: &mut [usize], i: usize, j: usize) {
    let (from, to) = (component[i], component[j]);
    component.iter_mut().filter(|c| **c == from).for_each(|c| *c = to);
}

/// A cone `{q : f q >= 0 for all f}`, with a pair of opposite rows for each equation.
type Rows = Vec<usize>;

/// A q with SOL(q, A) disconnected; `None` if A is in E_c.
///
/// # Errors
/// `Stopped` by the budget.
pub fn disconnected(a: &IMatrix, budget: &Budget<'_>) -> Search<Option<Vec<Int>>> {
    Arrangement::new(a, budget)?.search(budget)
}

/// A generator of a cell and its sign at each functional met so far.
#[derive(Clone)]
struct Generator {
    x: Vec<Int>,
    signs: Vec<i32>,
}

struct Arrangement<'a> {
    a: &'a IMatrix,
    /// Distinct functionals.
    functionals: Vec<Vec<Int>>,
    /// For each alpha: its cone, and whether it is full-dimensional (then row i is coordinate i).
    pieces: Vec<(Rows, bool)>,
    /// For pairs of degenerate pieces: the cone where they meet.
    meetings: HashMap<(u64, u64), Rows>,
}

/// What a cell says about a cone.
#[derive(PartialEq, Eq, Clone, Copy)]
enum Where {
    Inside,
    Outside,
    Cut(usize),
}

impl<'a> Arrangement<'a> {
    fn new(a: &'a IMatrix, budget: &Budget<'_>) -> Search<Self> {
        let n = a.rows();
        let mut known: HashMap<Vec<Int>, usize> = HashMap::new();
        let mut functionals: Vec<Vec<Int>> = Vec::new();
        let mut register = |rows: Vec<Vec<Int>>| -> Rows {
            rows.into_iter()
                .map(|mut f| {
                    make_primitive(&mut f);
                    *known.entry(f.clone()).or_insert_with(|| {
                        functionals.push(f);
                        functionals.len() - 1
                    })
                })
                .collect()
        };
        let mut pieces = Vec::new();
        for alpha in 0..1u64 << n {
            budget.poll()?;
            pieces.push(match complementary_facets(a, alpha) {
                Some(facets) => (register(facets), true),
                None => (register(half_spaces(&complementary_columns(a, alpha), n)), false),
            });
        }
        let mut meetings = HashMap::new();
        let degenerate: Vec<u64> = (0..1u64 << n).filter(|&alpha| !pieces[alpha as usize].1).collect();
        for (i, &alpha) in degenerate.iter().enumerate() {
            for &beta in &degenerate[..i] {
                budget.poll()?;
                meetings.insert((beta, alpha), register(half_spaces(&meeting_columns(a, alpha, beta), n)));
            }
        }
        Ok(Self { a, functionals, pieces, meetings })
    }

    fn search(&self, budget: &Budget<'_>) -> Search<Option<Vec<Int>>> {
        let n = self.a.rows();
        let mut stack = Vec::new();
        for signs in 1..3u64.pow(n as u32) {
            let generators: Vec<Generator> = (0..n)
                .filter_map(|i| match signs / 3u64.pow(i as u32) % 3 {
                    0 => None,
                    s => Some((0..n).map(|j| Int::from(if i == j { 3 - 2 * s as i64 } else { 0 })).collect()),
                })
                .map(|x| self.generator(x))
                .collect();
            stack.push((generators, None));
        }
        budget.begin(stack.len() as u64);
        let mut roots = stack.len();
        while let Some((cell, pending)) = stack.pop() {
            budget.poll()?;
            if stack.len() < roots {
                roots = stack.len();
                budget.step()?;
            }
            // A functional is worked off before another one is chosen, so that the refinement ends.
            let look = match pending.filter(|&f| Self::edge(&cell, f).is_some()) {
                Some(f) => Look::Split(f),
                None => self.look(&cell),
            };
            match look {
                Look::Connected => {}
                Look::Split(f) => stack.extend(self.split(&cell, f).into_iter().map(|part| (part, Some(f)))),
                Look::Disconnected => {
                    let mut q = vec![Int::ZERO; n];
                    for g in &cell {
                        q.iter_mut().zip(&g.x).for_each(|(sum, v)| *sum = &*sum + v);
                    }
                    return Ok(Some(q));
                }
            }
        }
        Ok(None)
    }

    fn generator(&self, x: Vec<Int>) -> Generator {
        let signs = self.functionals.iter().map(|f| dot(f, &x).sign()).collect();
        Generator { x, signs }
    }

    /// Where the relatively open cell lies with respect to a cone.
    fn place(cell: &[Generator], rows: &Rows) -> Where {
        let mut cut = None;
        for &f in rows {
            let above = cell.iter().any(|g| g.signs[f] > 0);
            let below = cell.iter().any(|g| g.signs[f] < 0);
            match (above, below) {
                (false, true) => return Where::Outside,
                (true, true) => cut = Some(f),
                _ => {}
            }
        }
        cut.map_or(Where::Inside, Where::Cut)
    }

    fn look(&self, cell: &[Generator]) -> Look {
        let mut candidates: Vec<(u64, Where)> = Vec::new();
        for (alpha, (rows, _)) in self.pieces.iter().enumerate() {
            let place = Self::place(cell, rows);
            if place != Where::Outside {
                candidates.push((alpha as u64, place));
            }
        }
        if candidates.len() <= 1 {
            return Look::Connected;
        }
        if let Some(f) =
            candidates.iter().find_map(|&(_, place)| if let Where::Cut(f) = place { Some(f) } else { None })
        {
            return Look::Split(f);
        }
        let mut component: Vec<usize> = (0..candidates.len()).collect();
        let mut undecided = None;
        for i in 0..candidates.len() {
            for j in 0..i {
                match self.meet(cell, candidates[j].0, candidates[i].0) {
                    Where::Inside => merge(&mut component, i, j),
                    Where::Cut(f) => undecided = Some(f),
                    Where::Outside => {}
                }
            }
        }
        if component.iter().all(|&c| c == component[0]) {
            Look::Connected
        } else {
            undecided.map_or(Look::Disconnected, Look::Split)
        }
    }

    /// Whether two pieces meet for the q of a cell that lies inside both cones; `alpha < beta`.
    fn meet(&self, cell: &[Generator], alpha: u64, beta: u64) -> Where {
        let n = self.a.rows();
        for known in [alpha, beta] {
            let (rows, nondegenerate) = &self.pieces[known as usize];
            if *nondegenerate {
                // One point: it is in the other piece when the coordinates that differ vanish.
                let vanish = (0..n)
                    .filter(|&i| (alpha ^ beta) >> i & 1 == 1)
                    .all(|i| cell.iter().all(|g| g.signs[rows[i]] == 0));
                return if vanish { Where::Inside } else { Where::Outside };
            }
        }
        Self::place(cell, &self.meetings[&(alpha, beta)])
    }

    /// A generator above and one below functional `f`.
    fn edge(cell: &[Generator], f: usize) -> Option<(usize, usize)> {
        let at = |s: i32| cell.iter().position(|g| g.signs[f] == s);
        at(1).zip(at(-1))
    }

    /// The two parts and the wall between them, by bisecting an edge that functional `f` cuts.
    fn split(&self, cell: &[Generator], f: usize) -> Vec<Vec<Generator>> {
        let Some((a, b)) = Self::edge(cell, f) else {
            return Vec::new();
        };
        let functional = &self.functionals[f];
        let (above, below) = (dot(functional, &cell[a].x), dot(functional, &cell[b].x));
        let mut x: Vec<Int> =
            cell[a].x.iter().zip(&cell[b].x).map(|(p, q)| Int::cross(&above, q, &below, p, &Int::ONE)).collect();
        make_primitive(&mut x);
        let middle = self.generator(x);
        let without = |gone: &[usize]| {
            let mut part: Vec<Generator> =
                cell.iter().enumerate().filter(|(i, _)| !gone.contains(i)).map(|(_, g)| g.clone()).collect();
            part.push(middle.clone());
            part
        };
        vec![without(&[a]), without(&[b]), without(&[a, b])]
    }
}

enum Look {
    Connected,
    Disconnected,
    Split(usize),
}

/// The cone of `generators` as half spaces; an equation becomes two.
fn half_spaces(generators: &[Vec<Int>], n: usize) -> Vec<Vec<Int>> {
    let rows = IMatrix::new(generators.len(), n, generators.concat());
    let orthogonal = reduce(rows, n).null_space(n);
    let mut dual = Cone::new(n);
    orthogonal.iter().for_each(|f| dual.zero(f.clone()));
    generators.iter().for_each(|g| dual.nonnegative(g.clone()));
    let mut facets = dual.rays();
    for f in orthogonal {
        facets.push(f.iter().map(|v| -v).collect());
        facets.push(f);
    }
    facets
}
