//! `solve_batch`: borrow the arrays, leave the interpreter, hand back arrays.

use lcpstar::batch::{self, Alpha, Guess, METHODS, Numbers, Output, Problems, Settings, Source};
use lcpstar::driver::Method;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::errors::{Signals, enter_core, return_within, to_python};

/// A guess of the supports, in one of three forms.
#[derive(FromPyObject)]
pub enum GuessArray<'py> {
    Masks(PyReadonlyArray1<'py, u64>),
    Flags(PyReadonlyArray2<'py, bool>),
    Points(PyReadonlyArray2<'py, f64>),
}

/// A block per problem, row-major, in one of two precisions.
#[derive(FromPyObject)]
pub enum Blocks<'py> {
    Double(PyReadonlyArray2<'py, f64>),
    Single(PyReadonlyArray2<'py, f32>),
}

impl Blocks<'_> {
    fn numbers(&self) -> PyResult<Numbers<'_>> {
        Ok(match self {
            Self::Double(x) => Numbers::Double(x.as_slice()?),
            Self::Single(x) => Numbers::Single(x.as_slice()?),
        })
    }

    fn count(&self) -> usize {
        match self {
            Self::Double(x) => x.shape()[0],
            Self::Single(x) => x.shape()[0],
        }
    }
}

/// Which block of an array belongs to problem k.
fn source<'a>(map: Option<&'a PyReadonlyArray1<'_, usize>>, blocks: usize, count: usize) -> PyResult<Source<'a>> {
    Ok(match map {
        Some(map) => Source::Mapped(map.as_slice()?),
        None if blocks == 1 && count != 1 => Source::One,
        None => Source::Each,
    })
}

/// The arrays of [`Output`], in its order, with alpha as masks (n <= 64) or flags.
type Results<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<u8>>,
    Bound<'py, PyArray1<u8>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyAny>,
);

/// Solves `count` problems of order `n`; `a` and `q` hold one block per row, `n * n` and `n` numbers, C-contiguous.
#[pyfunction]
#[pyo3(signature = (n, a, q, count, a_map, q_map, method, tol, threads, guess, polish))]
pub fn solve_batch<'py>(
    py: Python<'py>,
    n: usize,
    a: Blocks<'py>,
    q: Blocks<'py>,
    count: usize,
    a_map: Option<PyReadonlyArray1<'py, usize>>,
    q_map: Option<PyReadonlyArray1<'py, usize>>,
    method: &str,
    tol: f64,
    threads: usize,
    guess: Option<GuessArray<'py>>,
    polish: bool,
) -> PyResult<Results<'py>> {
    let problems = Problems {
        n,
        count,
        a: a.numbers()?,
        a_source: source(a_map.as_ref(), a.count(), count)?,
        q: q.numbers()?,
        q_source: source(q_map.as_ref(), q.count(), count)?,
    };
    let guess = match &guess {
        None => Guess::None,
        Some(GuessArray::Masks(v)) => Guess::Masks(v.as_slice()?),
        Some(GuessArray::Flags(v)) => Guess::Flags(v.as_slice()?),
        Some(GuessArray::Points(v)) => Guess::Points(v.as_slice()?),
    };
    let points = || (PyArray2::zeros(py, [count, n], false), PyArray2::zeros(py, [count, n], false));
    let codes = || (PyArray1::zeros(py, count, false), PyArray1::zeros(py, count, false));
    let residuals = || (PyArray1::zeros(py, count, false), PyArray1::zeros(py, count, false));
    let supports = || {
        let masks = PyArray1::<u64>::zeros(py, if n <= 64 { count } else { 0 }, false);
        (masks, PyArray2::<bool>::zeros(py, if n <= 64 { [0, n] } else { [count, n] }, false))
    };
    let allocate = || (points(), codes(), PyArray1::zeros(py, count, false), residuals(), supports());
    let ((z, w), (status, method_code), iterations, (residual, natural), (masks, flags)) = return_within(py, allocate);
    let signals = Signals::new();
    {
        let (mut z, mut w) = (z.try_readwrite()?, w.try_readwrite()?);
        let (mut status, mut method_code, mut iterations) =
            (status.try_readwrite()?, method_code.try_readwrite()?, iterations.try_readwrite()?);
        let (mut residual, mut natural) = (residual.try_readwrite()?, natural.try_readwrite()?);
        let (mut masks, mut flags) = (masks.try_readwrite()?, flags.try_readwrite()?);
        let output = Output {
            z: z.as_slice_mut()?,
            w: w.as_slice_mut()?,
            status: status.as_slice_mut()?,
            method: method_code.as_slice_mut()?,
            iterations: iterations.as_slice_mut()?,
            residual: residual.as_slice_mut()?,
            natural_residual: natural.as_slice_mut()?,
            alpha: if n <= 64 { Alpha::Masks(masks.as_slice_mut()?) } else { Alpha::Flags(flags.as_slice_mut()?) },
        };
        let interrupted = || signals.interrupted();
        let general = Method::from_name(method).map_err(|e| to_python(py, &e))?;
        let settings = Settings { method: &general, tol, threads, guess, polish, interrupted: Some(&interrupted) };
        enter_core(py, || batch::solve_batch(&problems, &settings, output))?;
    }
    signals.raise()?;
    let alpha = if n <= 64 { masks.into_any() } else { flags.into_any() };
    Ok((z, w, status, method_code, iterations, residual, natural, alpha))
}

/// Names of the method codes.
#[pyfunction]
pub fn batch_methods() -> Vec<&'static str> {
    METHODS.to_vec()
}
