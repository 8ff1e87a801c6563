//! The exact class kernels on an integer matrix. Python scales rationals to integers: every class keeps its verdict.

use lcpstar::classes::budget::{Budget, Search, Stopped};
use lcpstar::classes::cover::Step;
use lcpstar::classes::minors::{Rule, first_violation};
use lcpstar::classes::pieces::Polyhedron;
use lcpstar::classes::solvable::{PlusPlus, Solvable};
use lcpstar::classes::zero_solutions::Star;
use lcpstar::classes::{
    connected, definite, game, pieces, semimonotone, solvable, subdefinite, sufficient, transforms, zero_solutions,
};
use lcpstar::exact::elimination;
use lcpstar::exact::imatrix::{IMatrix, indices};
use lcpstar::exact::int::Int;
use num_bigint::BigInt;
use pyo3::exceptions::{PyTimeoutError, PyValueError};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use crate::errors::{Signals, enter_core};
use crate::solve::after;

type Vector = Vec<BigInt>;

fn out(x: &[Int]) -> Vector {
    x.iter().map(Int::to_big).collect()
}

fn table(rows: &[Vec<Int>]) -> Vec<Vector> {
    rows.iter().map(|row| out(row)).collect()
}

/// Runs a search with the interpreter released. Python's `TimeoutError` carries (done, total); Ctrl-C comes through.
fn search<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    time_limit: Option<f64>,
    run: impl FnOnce(&Budget<'_>) -> Search<T> + Send,
) -> PyResult<T> {
    let deadline = time_limit.and_then(|limit| after(Instant::now(), limit));
    let signals = Signals::new();
    let (result, progress) = enter_core(py, || {
        let cancelled = || stop.load(Ordering::Relaxed) || signals.interrupted();
        let budget = Budget::new(deadline, Some(&cancelled));
        let result = run(&budget);
        Ok((result, budget.progress()))
    })?;
    signals.raise()?;
    result.map_err(|(Stopped::TimeLimit | Stopped::Cancelled)| PyTimeoutError::new_err(progress))
}

/// A square integer matrix, row-major.
#[pyclass(frozen, module = "lcpstar._core")]
pub struct IntegerMatrix {
    pub a: IMatrix,
    /// Shared with everything derived from it: `cancel` stops the searches of other threads.
    stop: Arc<AtomicBool>,
}

type Tree = Vec<(usize, Option<(usize, Vector)>)>;

/// `(label, None)` for a leaf, `(a, (b, ray))` for a split.
fn tree(steps: &[Step]) -> Tree {
    steps
        .iter()
        .map(|step| match step {
            Step::Inside(label) => (*label, None),
            Step::Split { a, b, ray } => (*a, Some((*b, out(ray)))),
        })
        .collect()
}

impl IntegerMatrix {
    fn derived(&self, a: IMatrix) -> Self {
        Self { a, stop: Arc::clone(&self.stop) }
    }

    pub fn search<T: Send>(
        &self,
        py: Python<'_>,
        time_limit: Option<f64>,
        run: impl FnOnce(&Budget<'_>) -> Search<T> + Send,
    ) -> PyResult<T> {
        search(py, &self.stop, time_limit, run)
    }
}

#[pymethods]
impl IntegerMatrix {
    #[new]
    fn new(n: usize, entries: Vec<BigInt>) -> PyResult<Self> {
        if entries.len() != n * n || n == 0 {
            return Err(PyValueError::new_err(format!("{} entries for order {n}", entries.len())));
        }
        let a = IMatrix::new(n, n, entries.into_iter().map(Int::from).collect());
        Ok(Self { a, stop: Arc::default() })
    }

    /// Stops every search on this matrix and on what was derived from it.
    fn cancel(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// An index set whose minor breaks the rule "P", "P0", "N" or "N0".
    #[pyo3(signature = (rule, proper=false, time_limit=None))]
    fn minor(&self, py: Python<'_>, rule: &str, proper: bool, time_limit: Option<f64>) -> PyResult<Option<Vec<usize>>> {
        let rule = match rule {
            "P" => Rule::Positive,
            "P0" => Rule::NonNegative,
            "N" => Rule::Negative,
            "N0" => Rule::NonPositive,
            other => return Err(PyValueError::new_err(other.to_owned())),
        };
        let alpha = self.search(py, time_limit, |budget| first_violation(&self.a, rule, proper, budget))?;
        Ok(alpha.map(indices))
    }

    /// x with x'Ax < 0 (<= 0 when strict), x != 0.
    #[pyo3(signature = (strict=false, time_limit=None))]
    fn negative_direction(&self, py: Python<'_>, strict: bool, time_limit: Option<f64>) -> PyResult<Option<Vector>> {
        self.search(py, time_limit, |budget| {
            Ok(definite::negative_direction(&self.a.symmetric_part(), strict, budget)?.map(|x| out(&x)))
        })
    }

    /// x >= 0 that refutes E0 (E when strict).
    #[pyo3(signature = (strict=false, time_limit=None))]
    fn semimonotone(&self, py: Python<'_>, strict: bool, time_limit: Option<f64>) -> PyResult<Option<Vector>> {
        self.search(py, time_limit, |budget| Ok(semimonotone::violation(&self.a, strict, budget)?.map(|x| out(&x))))
    }

    /// x >= 0 that refutes C0 (C when strict).
    #[pyo3(signature = (strict=false, time_limit=None))]
    fn copositive(&self, py: Python<'_>, strict: bool, time_limit: Option<f64>) -> PyResult<Option<Vector>> {
        self.search(py, time_limit, |budget| {
            Ok(semimonotone::copositive_violation(&self.a, strict, budget)?.map(|x| out(&x)))
        })
    }

    /// Support-minimal zeros of the form of a copositive matrix.
    #[pyo3(signature = (time_limit=None))]
    fn form_zeros(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Vec<Vector>> {
        self.search(py, time_limit, |budget| Ok(table(&semimonotone::zeros_of_copositive_form(&self.a, budget)?)))
    }

    /// A nonzero element of SOL(0, A).
    #[pyo3(signature = (time_limit=None))]
    fn nonzero_solution(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Option<Vector>> {
        self.search(py, time_limit, |budget| Ok(zero_solutions::nonzero_solution(&self.a, budget)?.map(|x| out(&x))))
    }

    /// (z, t), z != 0, with z in SOL(t e, A).
    #[pyo3(signature = (time_limit=None))]
    fn regularity(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Option<(Vector, BigInt)>> {
        self.search(py, time_limit, |budget| {
            Ok(zero_solutions::regularity_violation(&self.a, budget)?.map(|(z, t)| (out(&z), t.to_big())))
        })
    }

    /// (x, i): x in SOL(0, A) breaks the star (tilde) condition at i.
    #[pyo3(signature = (tilde=false, time_limit=None))]
    fn star(&self, py: Python<'_>, tilde: bool, time_limit: Option<f64>) -> PyResult<Option<(Vector, usize)>> {
        let star = if tilde { Star::Tilde } else { Star::Plain };
        self.search(py, time_limit, |budget| {
            Ok(zero_solutions::star_violation(&self.a, star, budget)?.map(|(x, i)| (out(&x), i)))
        })
    }

    /// (x, u) that refutes L2.
    #[pyo3(signature = (time_limit=None))]
    fn garcia(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Option<(Vector, Vector)>> {
        self.search(py, time_limit, |budget| {
            Ok(zero_solutions::garcia_violation(&self.a, budget)?.map(|(x, u)| (out(&x), out(&u))))
        })
    }

    /// x that refutes column sufficiency.
    #[pyo3(signature = (time_limit=None))]
    fn column_sufficient(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Option<Vector>> {
        self.search(py, time_limit, |budget| Ok(sufficient::violation(&self.a, budget)?.map(|x| out(&x))))
    }

    /// x that refutes PSBD.
    #[pyo3(signature = (time_limit=None))]
    fn subdefinite(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Option<Vector>> {
        self.search(py, time_limit, |budget| Ok(subdefinite::subdefinite_violation(&self.a, budget)?.map(|x| out(&x))))
    }

    /// (x, y) that refutes pseudomonotonicity on the orthant.
    #[pyo3(signature = (time_limit=None))]
    fn pseudomonotone(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Option<(Vector, Vector)>> {
        self.search(py, time_limit, |budget| {
            Ok(subdefinite::pseudomonotone_violation(&self.a, budget)?.map(|(x, y)| (out(&x), out(&y))))
        })
    }

    /// (alpha, |det| M) for every legitimate principal pivot transform M, as matrices scaled by a positive number.
    #[pyo3(signature = (time_limit=None))]
    fn transforms(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Vec<(Vec<usize>, Self)>> {
        let all = self.search(py, time_limit, |budget| transforms::legitimate(&self.a, budget))?;
        Ok(all.into_iter().map(|(mask, a)| (indices(mask), self.derived(a))).collect())
    }

    /// The principal submatrix on `alpha`.
    fn principal(&self, alpha: Vec<usize>) -> PyResult<Self> {
        if alpha.is_empty() || alpha.iter().any(|&i| i >= self.a.rows()) {
            return Err(PyValueError::new_err("alpha"));
        }
        Ok(self.derived(self.a.principal(&alpha)))
    }

    /// The transpose.
    fn transpose(&self) -> Self {
        self.derived(self.a.transpose())
    }

    /// Row-major entries.
    fn entries(&self) -> Vector {
        out(self.a.entries())
    }

    /// Generators of {y >= 0 : A'y <= 0}.
    #[pyo3(signature = (time_limit=None))]
    fn infeasibility_rays(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Vec<Vector>> {
        self.search(py, time_limit, |_| Ok(table(&solvable::infeasibility_rays(&self.a))))
    }

    /// (None, tree per orthant) if every feasible q is solvable, else (q, []).
    #[pyo3(signature = (time_limit=None))]
    fn solvable(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<(Option<Vector>, Vec<(u64, Tree)>)> {
        self.search(py, time_limit, |budget| {
            Ok(match solvable::solvable_when_feasible(&self.a, budget)? {
                Solvable::Everywhere(proof) => (None, proof.iter().map(|(o, steps)| (*o, tree(steps))).collect()),
                Solvable::Not(q) => (Some(out(&q)), Vec::new()),
            })
        })
    }

    /// One separating vector per complementary cone (by mask), or None if LCP(q, A) is solvable.
    #[pyo3(signature = (q, time_limit=None))]
    fn separate(&self, py: Python<'_>, q: Vector, time_limit: Option<f64>) -> PyResult<Option<Vec<Vector>>> {
        let q: Vec<Int> = q.into_iter().map(Int::from).collect();
        self.search(py, time_limit, |budget| Ok(solvable::separate(&self.a, &q, budget)?.map(|rows| table(&rows))))
    }

    /// ((v, X row-major), []) if (++) holds, else (None, tree).
    #[pyo3(signature = (time_limit=None))]
    fn plus_plus(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<(Option<(Vector, Vector)>, Tree)> {
        self.search(py, time_limit, |budget| {
            Ok(match solvable::plus_plus(&self.a, budget)? {
                PlusPlus::Holds(v, x) => (Some((out(&v), out(&x))), Vec::new()),
                PlusPlus::Fails(steps) => (None, tree(&steps)),
            })
        })
    }

    /// A q whose solution set is disconnected.
    #[pyo3(signature = (time_limit=None))]
    fn disconnected(&self, py: Python<'_>, time_limit: Option<f64>) -> PyResult<Option<Vector>> {
        self.search(py, time_limit, |budget| Ok(connected::disconnected(&self.a, budget)?.map(|q| out(&q))))
    }

    /// (z, t) with A z + t q >= 0, z >= 0, t > 0, or None.
    #[pyo3(signature = (q, time_limit=None))]
    fn feasible_point(&self, py: Python<'_>, q: Vector, time_limit: Option<f64>) -> PyResult<Option<(Vector, BigInt)>> {
        let q: Vec<Int> = q.into_iter().map(Int::from).collect();
        self.search(py, time_limit, |_| Ok(solvable::feasible_point(&self.a, &q).map(|(z, t)| (out(&z), t.to_big()))))
    }

    /// (pieces (alpha, component, z, t), separations (alpha, beta, y), number of components) of SOL(q, A).
    #[pyo3(signature = (q, time_limit=None))]
    #[allow(clippy::type_complexity)] // one tuple, unpacked at once in Python
    fn components(
        &self,
        py: Python<'_>,
        q: Vector,
        time_limit: Option<f64>,
    ) -> PyResult<(Vec<(u64, usize, Vector, BigInt)>, Vec<(u64, u64, Vector)>, usize)> {
        let q: Vec<Int> = q.into_iter().map(Int::from).collect();
        self.search(py, time_limit, |budget| {
            let found = connected::components(&self.a, &q, budget)?;
            let separations = found.separations.iter().map(|(i, j, y)| (*i, *j, out(y))).collect();
            let pieces = found.pieces.iter().map(|p| (p.alpha, p.component, out(&p.z), p.t.to_big())).collect();
            Ok((pieces, separations, found.count))
        })
    }

    /// (alpha, vertices (z, t), rays) of every nonempty piece of SOL(q, A).
    #[pyo3(signature = (q, time_limit=None))]
    #[allow(clippy::type_complexity)] // one tuple per piece, unpacked at once in Python
    fn pieces(
        &self,
        py: Python<'_>,
        q: Vector,
        time_limit: Option<f64>,
    ) -> PyResult<Vec<(u64, Vec<(Vector, BigInt)>, Vec<Vector>)>> {
        let q: Vec<Int> = q.into_iter().map(Int::from).collect();
        self.search(py, time_limit, |budget| {
            let pieces = pieces::pieces(&self.a, &q, budget)?;
            let vertices = |p: &Polyhedron| p.vertices.iter().map(|(z, t)| (out(z), t.to_big())).collect();
            Ok(pieces.iter().map(|p| (p.alpha, vertices(p), table(&p.rays))).collect())
        })
    }

    /// Whether a solution with the given index sets (masks of z_i > 0 and of z_i = w_i = 0) is isolated.
    #[pyo3(signature = (positive, degenerate, time_limit=None))]
    fn is_isolated(&self, py: Python<'_>, positive: u64, degenerate: u64, time_limit: Option<f64>) -> PyResult<bool> {
        self.search(py, time_limit, |budget| pieces::is_isolated(&self.a, positive, degenerate, budget))
    }

    /// (numerator, denominator, x, y) of the matrix game.
    fn game(&self, py: Python<'_>) -> PyResult<(BigInt, BigInt, Vector, Vector)> {
        self.search(py, None, |budget| {
            let g = game::solve(&self.a, budget)?;
            Ok((g.numerator.to_big(), g.denominator.to_big(), out(&g.x), out(&g.y)))
        })
    }

    /// The determinant.
    fn determinant(&self, py: Python<'_>) -> PyResult<BigInt> {
        self.search(py, None, |budget| Ok(elimination::determinant_unless(&self.a, || budget.poll())?.to_big()))
    }
}
