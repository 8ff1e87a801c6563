//! NumPy arrays in: each problem is copied once into memory of its own, and only the copy is trusted.

use lcpstar::{Lcp, LcpError};
use numpy::npyffi::_PyArray_GET_ITEM_DATA;
use numpy::npyffi::flags::NPY_ARRAY_WRITEABLE;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
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

/// The validated problem from arrays of doubles of the right shapes; `None`: Python has to coerce them first.
pub fn to_lcp_as_is(py: Python<'_>, a: &Bound<'_, PyAny>, q: &Bound<'_, PyAny>) -> PyResult<Option<Lcp>> {
    let (Ok(a), Ok(q)) = (a.cast::<PyArray2<f64>>(), q.cast::<PyArray1<f64>>()) else { return Ok(None) };
    let n = a.shape()[0];
    if a.shape()[1] != n {
        return Ok(None);
    }
    let copies = if a.is_c_contiguous() {
        // SAFETY: the slices live for the length of a copy, during which this thread holds the interpreter. The borrow
        // checks of `readonly` would cost more than a small problem.
        #[allow(unsafe_code, reason = "see above")]
        unsafe { a.as_slice().and_then(|a| q.as_slice().map(|q| (a.to_vec(), q.to_vec()))) }.ok()
    } else {
        None
    };
    let (a, q) = match copies {
        Some(copies) => copies,
        None => (square(py, "A", &a.readonly())?.1, vector(&q.readonly())),
    };
    Lcp::new(n, a, q).map(Some).map_err(|e| to_python(py, &e))
}

/// A read-only array: results are frozen, so their arrays are, too.
pub fn frozen_array(py: Python<'_>, values: &[f64]) -> Py<PyArray1<f64>> {
    let array = PyArray1::from_slice(py, values);
    // SAFETY: nobody else has seen the array yet.
    #[allow(unsafe_code, reason = "see above; the method of the array would cost more than the array")]
    unsafe {
        (*_PyArray_GET_ITEM_DATA(array.as_array_ptr())).flags &= !NPY_ARRAY_WRITEABLE;
    }
    array.unbind()
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
