//! `accuracy`: a point measured, dense or sparse.

use lcpstar::accuracy::{Accuracy, accuracy as dense, accuracy_sparse as sparse};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{to_lcp, vector};
use crate::errors::enter_core;
use crate::sparse::to_sparse_lcp;

/// The fields of `lcpstar.Accuracy`, in their order.
type Fields = (f64, f64, f64, Option<f64>, &'static str);

fn fields(found: Accuracy) -> Fields {
    (found.natural_residual, found.residual, found.backward_error, found.error_bound, found.bound_reason)
}

/// Measures a point; arguments already coerced by `lcpstar.accuracy`.
#[pyfunction]
pub fn accuracy(
    py: Python<'_>,
    a: PyReadonlyArray2<'_, f64>,
    q: PyReadonlyArray1<'_, f64>,
    z: PyReadonlyArray1<'_, f64>,
) -> PyResult<Fields> {
    let (lcp, z) = (to_lcp(py, &a, &q)?, vector(&z));
    enter_core(py, || dense(&lcp, &z)).map(fields)
}

/// As `accuracy`, for compressed rows.
#[pyfunction]
pub fn accuracy_sparse(
    py: Python<'_>,
    starts: PyReadonlyArray1<'_, i64>,
    columns: PyReadonlyArray1<'_, i64>,
    values: PyReadonlyArray1<'_, f64>,
    q: PyReadonlyArray1<'_, f64>,
    z: PyReadonlyArray1<'_, f64>,
) -> PyResult<Fields> {
    let lcp = to_sparse_lcp(py, &starts, &columns, &values, &q)?;
    let z = vector(&z);
    enter_core(py, || sparse(&lcp, &z)).map(fields)
}
