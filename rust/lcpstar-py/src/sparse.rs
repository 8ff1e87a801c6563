//! `solve` for a sparse A.

use lcpstar::driver::{self, Certify, SPARSE_METHODS, Settings};
use lcpstar::{Control, LcpError, SparseLcp};
use numpy::{PyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::time::Instant;

use crate::arrays::{VectorArray, numbers};
use crate::errors::{Signals, enter_core, to_python};
use crate::solution::PySolution;

/// Compressed rows as a problem; a negative index becomes one that is out of range, which the core names.
pub fn to_sparse_lcp(
    py: Python<'_>,
    starts: &Bound<'_, PyArray1<i64>>,
    columns: &Bound<'_, PyArray1<i64>>,
    values: &VectorArray<'_>,
    q: &VectorArray<'_>,
) -> PyResult<SparseLcp> {
    let indices = |v: &Bound<'_, PyArray1<i64>>| -> Vec<usize> {
        numbers(v).into_iter().map(|i| usize::try_from(i).unwrap_or(usize::MAX)).collect()
    };
    SparseLcp::new(indices(starts), indices(columns), numbers(values), numbers(q)).map_err(|e| to_python(py, &e))
}

/// Solves a sparse LCP given by compressed rows; arguments already coerced by `lcpstar.solve`.
#[pyfunction]
#[pyo3(signature = (starts, columns, values, q, method_name, tol, max_iterations, time_limit, z0, certify, options))]
pub fn solve_sparse(
    py: Python<'_>,
    starts: Bound<'_, PyArray1<i64>>,
    columns: Bound<'_, PyArray1<i64>>,
    values: VectorArray<'_>,
    q: VectorArray<'_>,
    method_name: &str,
    tol: f64,
    max_iterations: Option<usize>,
    time_limit: Option<f64>,
    z0: Option<VectorArray<'_>>,
    certify: &str,
    options: Option<&Bound<'_, PyAny>>,
) -> PyResult<PySolution> {
    let start = Instant::now();
    if !SPARSE_METHODS.contains(&method_name) {
        let value = method_name.to_owned();
        return Err(to_python(
            py,
            &LcpError::UnknownName { name: "method (for a sparse A)", value, choices: SPARSE_METHODS },
        ));
    }
    let certify = Certify::from_name(certify).map_err(|e| to_python(py, &e))?;
    let lcp = to_sparse_lcp(py, &starts, &columns, &values, &q)?;
    let method = crate::solve::method(py, method_name, options, q.len())?;
    let settings = Settings { method, tol, z0: z0.as_ref().map(numbers), certify };
    let signals = Signals::new();
    let control = Control {
        max_iterations,
        deadline: crate::solve::deadline(py, start, time_limit)?,
        interrupted: Some(&|| signals.interrupted()),
    };
    let solution = enter_core(py, || driver::solve_sparse(&lcp, &settings, &control))?;
    signals.raise()?;
    Ok(PySolution::new(solution, start.elapsed().as_secs_f64()))
}
