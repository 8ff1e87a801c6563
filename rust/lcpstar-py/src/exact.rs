//! Proofs and solution sets for Python: exact integers over one denominator.

use crate::arrays::{MatrixArray, VectorArray, index_set, to_lcp};
use crate::errors::{Signals, enter_core, raise};
use crate::solve::deadline;
use lcpstar::Control;
use lcpstar::Termination;
use lcpstar::exact::dyadic::RationalVec;
use lcpstar::exact::repair::{self, Repaired};
use num_bigint::BigInt;
use pyo3::prelude::*;
use std::time::Instant;

/// Numerators and their common denominator.
type Exact = (Vec<BigInt>, BigInt);

/// `alpha`, vertices, rays; the doubles nearest to them when `exact` is false.
type ExactFace = (Vec<usize>, Vec<Exact>, Vec<Exact>);
type FloatFace = (Vec<usize>, Vec<Vec<f64>>, Vec<Vec<f64>>);

fn split(v: RationalVec) -> Exact {
    (v.numerators, v.denominator)
}

/// Proves that `alpha` is a complementary basis of a solution, or pivots exactly from it to one.
///
/// `("proved", alpha, z, pivots)`, or `("ray" | "interrupted", [], None, 0)`.
#[pyfunction]
pub fn prove_solution(
    py: Python<'_>,
    a: MatrixArray<'_>,
    q: VectorArray<'_>,
    alpha: Vec<i64>,
) -> PyResult<(&'static str, Vec<usize>, Option<Exact>, usize)> {
    let lcp = to_lcp(py, &a, &q)?;
    let alpha = index_set(py, "alpha", &alpha, lcp.n())?;
    let signals = Signals::new();
    let outcome = enter_core(py, || Ok(repair::prove(lcp.view(), &alpha, &|| signals.interrupted())))?;
    signals.raise()?;
    Ok(match outcome {
        Repaired::Solved(solution, pivots) => ("proved", solution.alpha, Some(split(solution.z)), pivots),
        Repaired::Ray(..) => ("ray", vec![], None, 0),
        Repaired::Interrupted => ("interrupted", vec![], None, 0),
    })
}

/// All maximal faces of SOL(q, A): exact integers, or doubles.
#[pyfunction]
pub fn solutions(
    py: Python<'_>,
    a: MatrixArray<'_>,
    q: VectorArray<'_>,
    time_limit: Option<f64>,
    exact: bool,
) -> PyResult<Py<PyAny>> {
    let start = Instant::now();
    let lcp = to_lcp(py, &a, &q)?;
    let signals = Signals::new();
    let control = Control {
        deadline: deadline(py, start, time_limit)?,
        interrupted: Some(&|| signals.interrupted()),
        ..Control::default()
    };
    let outcome = enter_core(py, || lcpstar::solutions::solutions(&lcp, &control))?;
    signals.raise()?;
    let faces = outcome.map_err(|termination| match termination {
        Termination::Breakdown(reason) => raise(py, "InternalError", reason),
        _ => raise(py, "TimeLimitError", "the solution set was not complete when time_limit had passed"),
    })?;
    if exact {
        let faces: Vec<ExactFace> = faces
            .into_iter()
            .map(|f| (f.alpha, f.vertices.into_iter().map(split).collect(), f.rays.into_iter().map(split).collect()))
            .collect();
        Ok(faces.into_pyobject(py)?.into_any().unbind())
    } else {
        let rounded = |v: &[RationalVec]| v.iter().map(RationalVec::to_f64).collect();
        let faces: Vec<FloatFace> =
            faces.into_iter().map(|f| (f.alpha, rounded(&f.vertices), rounded(&f.rays))).collect();
        Ok(faces.into_pyobject(py)?.into_any().unbind())
    }
}
