//! `accuracy`: a point measured, dense or sparse.

use lcpstar::Control;
use lcpstar::accuracy::{Accuracy, accuracy as dense, accuracy_sparse as sparse};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays::{MatrixArray, VectorArray, numbers, to_lcp};
use crate::errors::{Signals, enter_core};
use crate::sparse::to_sparse_lcp;

/// The fields of `lcpstar.Accuracy`, in their order.
type Fields = (f64, f64, f64, Option<f64>, &'static str);

fn fields(found: Accuracy) -> Fields {
    (found.natural_residual, found.residual, found.backward_error, found.error_bound, found.bound_reason)
}

fn stoppable(
    py: Python<'_>,
    measure: impl FnOnce(&Control<'_>) -> lcpstar::Result<Accuracy> + Send,
) -> PyResult<Fields> {
    let signals = Signals::new();
    let found =
        enter_core(py, || measure(&Control { interrupted: Some(&|| signals.interrupted()), ..Control::default() }))?;
    signals.raise()?;
    Ok(fields(found))
}

/// Measures a point; arguments already coerced by `lcpstar.accuracy`.
#[pyfunction]
pub fn accuracy(py: Python<'_>, a: MatrixArray<'_>, q: VectorArray<'_>, z: VectorArray<'_>) -> PyResult<Fields> {
    let (lcp, z) = (to_lcp(py, &a, &q)?, numbers(&z));
    stoppable(py, |control| dense(&lcp, &z, control))
}

/// As `accuracy`, for compressed rows.
#[pyfunction]
pub fn accuracy_sparse(
    py: Python<'_>,
    starts: Bound<'_, PyArray1<i64>>,
    columns: Bound<'_, PyArray1<i64>>,
    values: VectorArray<'_>,
    q: VectorArray<'_>,
    z: VectorArray<'_>,
) -> PyResult<Fields> {
    let lcp = to_sparse_lcp(py, &starts, &columns, &values, &q)?;
    let z = numbers(&z);
    stoppable(py, |control| sparse(&lcp, &z, control))
}
