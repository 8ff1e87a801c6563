//! `solve_batch`: borrow the arrays, leave the interpreter, write the results.

use lcpstar::Member;
use lcpstar::batch::{self, Alpha, Guess, Numbers, Output, Problems, Settings, Source};
use lcpstar::driver::Method;
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadonlyArray1, PyReadonlyArrayDyn, PyReadwriteArrayDyn};
use pyo3::prelude::*;

use crate::errors::{Signals, enter_core, raise, to_python};

/// A guess of the supports, in one of three forms.
#[derive(FromPyObject)]
pub enum GuessArray<'py> {
    Masks(PyReadonlyArrayDyn<'py, u64>),
    Flags(PyReadonlyArrayDyn<'py, bool>),
    Points(PyReadonlyArrayDyn<'py, f64>),
}

/// A block per problem, row-major, in one of two precisions.
#[derive(FromPyObject)]
pub enum Blocks<'py> {
    Double(PyReadonlyArrayDyn<'py, f64>),
    Single(PyReadonlyArrayDyn<'py, f32>),
}

impl Blocks<'_> {
    fn numbers(&self) -> PyResult<Numbers<'_>> {
        Ok(match self {
            Self::Double(x) => Numbers::Double(x.as_slice()?),
            Self::Single(x) => Numbers::Single(x.as_slice()?),
        })
    }

    /// Which block of `length` numbers belongs to problem k.
    fn source<'a>(&self, length: usize, map: Option<&'a PyReadonlyArray1<'_, usize>>) -> PyResult<Source<'a>> {
        let numbers = match self {
            Self::Double(x) => x.as_slice()?.len(),
            Self::Single(x) => x.as_slice()?.len(),
        };
        Ok(match map {
            Some(map) => Source::Mapped(map.as_slice()?),
            None if numbers == length => Source::One,
            None => Source::Each,
        })
    }
}

/// Supports as masks (n <= 64) or flags.
#[derive(FromPyObject)]
pub enum SupportArray<'py> {
    Masks(Bound<'py, PyArrayDyn<u64>>),
    Flags(Bound<'py, PyArrayDyn<bool>>),
}

/// The arrays of [`Output`], in its order, C-contiguous.
type Results<'py> = (
    Bound<'py, PyArrayDyn<f64>>,
    Bound<'py, PyArrayDyn<f64>>,
    Bound<'py, PyArrayDyn<u8>>,
    Bound<'py, PyArrayDyn<u8>>,
    Bound<'py, PyArrayDyn<u32>>,
    Bound<'py, PyArrayDyn<f64>>,
    Bound<'py, PyArrayDyn<f64>>,
    SupportArray<'py>,
);

/// The same while they are written.
enum Supports<'py> {
    Masks(PyReadwriteArrayDyn<'py, u64>),
    Flags(PyReadwriteArrayDyn<'py, bool>),
}

impl<'py> SupportArray<'py> {
    fn own(&self) -> PyResult<Supports<'py>> {
        Ok(match self {
            Self::Masks(masks) => Supports::Masks(own(masks)?),
            Self::Flags(flags) => Supports::Flags(own(flags)?),
        })
    }
}

impl Supports<'_> {
    fn alpha(&mut self) -> PyResult<Alpha<'_>> {
        Ok(match self {
            Self::Masks(masks) => Alpha::Masks(masks.as_slice_mut()?),
            Self::Flags(flags) => Alpha::Flags(flags.as_slice_mut()?),
        })
    }
}

/// An array to read while the interpreter is released: it may not be one that another batch writes to.
fn borrowed<'py, T: FromPyObjectOwned<'py>>(array: &Bound<'py, PyAny>) -> PyResult<T> {
    array
        .extract()
        .map_err(|_| raise(array.py(), "OptionError", "A, q and the guess must not be in the out of a batch under way"))
}

/// An array to write to that nobody else reads or writes.
fn own<'py, T: Element>(array: &Bound<'py, PyArrayDyn<T>>) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    array.try_readwrite().map_err(|_| {
        let message = "out must hold writable arrays that share no memory with A, q or a batch under way";
        raise(array.py(), "OptionError", message)
    })
}

/// Solves `count` problems of order `n`. All arrays are C-contiguous and have any shape: `a` and `q` hold blocks of `n * n` and `n`
/// numbers, one for each problem, one for all, or as the maps say. Every number of `results` is written, unless an exception is
/// raised.
#[pyfunction]
#[pyo3(signature = (n, a, q, count, a_map, q_map, method, tol, threads, guess, results))]
pub fn solve_batch<'py>(
    py: Python<'py>,
    n: usize,
    a: &Bound<'py, PyAny>,
    q: &Bound<'py, PyAny>,
    count: usize,
    a_map: Option<PyReadonlyArray1<'py, usize>>,
    q_map: Option<PyReadonlyArray1<'py, usize>>,
    method: &str,
    tol: f64,
    threads: usize,
    guess: Option<&Bound<'py, PyAny>>,
    results: Results<'py>,
) -> PyResult<()> {
    let (a, q): (Blocks<'_>, Blocks<'_>) = (borrowed(a)?, borrowed(q)?);
    let guess: Option<GuessArray<'_>> = guess.map(borrowed).transpose()?;
    let problems = Problems {
        n,
        count,
        a: a.numbers()?,
        a_source: a.source(n * n, a_map.as_ref())?,
        q: q.numbers()?,
        q_source: q.source(n, q_map.as_ref())?,
    };
    let guess = match &guess {
        None => Guess::None,
        Some(GuessArray::Masks(v)) => Guess::Masks(v.as_slice()?),
        Some(GuessArray::Flags(v)) => Guess::Flags(v.as_slice()?),
        Some(GuessArray::Points(v)) => Guess::Points(v.as_slice()?),
    };
    let (z, w, status, method_code, iterations, residual, natural, alpha) = &results;
    let (mut z, mut w, mut status, mut method_code) = (own(z)?, own(w)?, own(status)?, own(method_code)?);
    let (mut iterations, mut residual, mut natural) = (own(iterations)?, own(residual)?, own(natural)?);
    let mut supports = alpha.own()?;
    let output = Output {
        z: z.as_slice_mut()?,
        w: w.as_slice_mut()?,
        status: status.as_slice_mut()?,
        method: method_code.as_slice_mut()?,
        iterations: iterations.as_slice_mut()?,
        residual: residual.as_slice_mut()?,
        natural_residual: natural.as_slice_mut()?,
        alpha: supports.alpha()?,
    };
    let signals = Signals::new();
    let interrupted = || signals.interrupted();
    let general = Method::from_name(method).map_err(|e| to_python(py, &e))?;
    let settings = Settings { method: &general, tol, threads, guess, interrupted: Some(&interrupted) };
    enter_core(py, || batch::solve_batch(&problems, &settings, output))?;
    signals.raise()
}

/// Names of the method codes.
#[pyfunction]
pub fn batch_methods() -> Vec<&'static str> {
    Member::NAMES.to_vec()
}
