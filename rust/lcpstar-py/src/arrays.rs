//! NumPy arrays in: each problem is copied once into memory of its own, and only the copy is trusted.

use lcpstar::{Lcp, LcpError};
use numpy::npyffi::_PyArray_GET_ITEM_DATA;
use numpy::npyffi::flags::NPY_ARRAY_WRITEABLE;
use numpy::{Element, PyArray, PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::errors::to_python;

/// A matrix and a vector as they come from Python.
pub type MatrixArray<'py> = Bound<'py, PyArray2<f64>>;
pub type VectorArray<'py> = Bound<'py, PyArray1<f64>>;

/// The numbers of an array of any strides and alignment, row by row: the one way in.
///
/// The views of rust-numpy count strides in items and round, so that a field of a packed record is read wrongly; its slices
/// and borrows refuse other arrays. A copy needs neither: this thread holds the interpreter.
pub fn numbers<T: Element + Copy, D>(array: &Bound<'_, PyArray<T, D>>) -> Vec<T> {
    let mut copy: Vec<T> = Vec::with_capacity(array.len());
    // SAFETY: NumPy vouches for shape and strides, in bytes; nothing is asked of the alignment. `Element` and `Copy` are
    // together only plain numbers and flags.
    #[allow(unsafe_code, reason = "see above")]
    unsafe {
        let data: *const u8 = array.data().cast();
        if array.is_c_contiguous() {
            std::ptr::copy_nonoverlapping(data, copy.as_mut_ptr().cast(), array.len() * size_of::<T>());
            copy.set_len(array.len());
        } else {
            gather(data, array.shape(), array.strides(), &mut copy);
        }
    }
    copy
}

/// Appends the numbers of an array, the last axis fastest.
///
/// # Safety
/// `shape` and `strides` (in bytes) lead from `data` to readable memory that holds a `T`, aligned or not.
#[allow(unsafe_code, reason = "strides of NumPy are in bytes")]
unsafe fn gather<T: Copy>(data: *const u8, shape: &[usize], strides: &[isize], copy: &mut Vec<T>) {
    let (Some((&length, inner)), Some((&stride, inner_strides))) = (shape.split_first(), strides.split_first()) else {
        // SAFETY: no axis is left, so `data` is at an entry.
        copy.push(unsafe { data.cast::<T>().read_unaligned() });
        return;
    };
    let places = (0..length as isize).map(|i| data.wrapping_offset(i * stride));
    if inner.is_empty() {
        // SAFETY: each place is an entry.
        copy.extend(places.map(|place| unsafe { place.cast::<T>().read_unaligned() }));
    } else {
        // SAFETY: each place begins an array with one axis less.
        places.for_each(|place| unsafe { gather(place, inner, inner_strides, copy) });
    }
}

/// A row-major copy of a square matrix.
pub fn square(py: Python<'_>, name: &'static str, a: &MatrixArray<'_>) -> PyResult<(usize, Vec<f64>)> {
    let [rows, columns] = [a.shape()[0], a.shape()[1]];
    if rows != columns {
        return Err(to_python(py, &LcpError::NotSquare { name, rows, columns }));
    }
    Ok((rows, numbers(a)))
}

/// The validated problem from arrays of doubles of the right shapes; `None`: Python has to coerce them first.
pub fn to_lcp_as_is(py: Python<'_>, a: &Bound<'_, PyAny>, q: &Bound<'_, PyAny>) -> PyResult<Option<Lcp>> {
    let (Ok(a), Ok(q)) = (a.cast::<PyArray2<f64>>(), q.cast::<PyArray1<f64>>()) else { return Ok(None) };
    if a.shape()[0] == a.shape()[1] { to_lcp(py, a, q).map(Some) } else { Ok(None) }
}

/// The validated problem.
pub fn to_lcp(py: Python<'_>, a: &MatrixArray<'_>, q: &VectorArray<'_>) -> PyResult<Lcp> {
    let (n, a) = square(py, "A", a)?;
    Lcp::new(n, a, numbers(q)).map_err(|e| to_python(py, &e))
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

/// An index set: Python's negative indices are not accepted, since they hide mistakes in mathematics.
pub fn index_set(py: Python<'_>, name: &'static str, alpha: &[i64], n: usize) -> PyResult<Vec<usize>> {
    let convert = |&i: &i64| match usize::try_from(i) {
        Ok(i) if i < n => Ok(i),
        _ => Err(to_python(py, &LcpError::BadIndex { name, index: i, n, repeated: false })),
    };
    alpha.iter().map(convert).collect()
}
