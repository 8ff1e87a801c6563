//! NumPy arrays in: each problem is copied once into memory of its own, and only the copy is trusted.

use lcpstar::{Lcp, LcpError};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::errors::to_python;

/// A row-major copy of a square matrix of any memory order.
pub fn square(py: Python<'_>, name: &'static str, a: &PyReadonlyArray2<'_, f64>) -> PyResult<(usize, Vec<f64>)> {
    let [rows, columns] = [a.shape()[0], a.shape()[1]];
    if rows != columns {
        return Err(to_python(py, &LcpError::NotSquare { name, rows, columns }));
    }
    // `as_slice` also takes Fortran order, in which the slice is the transpose.
    let copy = match a.as_slice() {
        Ok(slice) if a.is_c_contiguous() => slice.to_vec(),
        _ => a.as_array().iter().copied().collect(),
    };
    Ok((rows, copy))
}

/// A contiguous copy of a vector of any stride.
pub fn vector(v: &PyReadonlyArray1<'_, f64>) -> Vec<f64> {
    match v.as_slice() {
        Ok(slice) => slice.to_vec(),
        Err(_) => v.as_array().iter().copied().collect(),
    }
}

/// The validated problem.
pub fn to_lcp(py: Python<'_>, a: &PyReadonlyArray2<'_, f64>, q: &PyReadonlyArray1<'_, f64>) -> PyResult<Lcp> {
    let (n, a) = square(py, "A", a)?;
    Lcp::new(n, a, vector(q)).map_err(|e| to_python(py, &e))
}

/// An index set: Python's negative indices are not accepted, since they hide mistakes in mathematics.
pub fn index_set(py: Python<'_>, name: &'static str, alpha: &[i64], n: usize) -> PyResult<Vec<usize>> {
    let convert = |&i: &i64| match usize::try_from(i) {
        Ok(i) if i < n => Ok(i),
        _ => Err(to_python(py, &LcpError::BadIndex { name, index: i, n, repeated: false })),
    };
    alpha.iter().map(convert).collect()
}
