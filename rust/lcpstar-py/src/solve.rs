//! `solve` and `ppt`.

use lcpstar::cutovers::BRIEF_UP_TO;
use lcpstar::driver::{self, Certify, Method, Settings};
use lcpstar::methods::{bilinear, block_pivoting, lemke, lemke_howson};
use lcpstar::pivoting::transform::principal_pivot_transform;
use lcpstar::{Control, Lcp, LcpError};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use std::time::{Duration, Instant};

use crate::arrays::{MatrixArray, VectorArray, index_set, numbers, square, to_lcp_as_is};
use crate::errors::{Signals, enter_core, enter_core_briefly, raise, to_python};
use crate::solution::PySolution;

/// Attributes of `lcpstar.LemkeOptions`; `None` means the core's default.
#[derive(FromPyObject)]
struct LemkeOptions<'py> {
    d: Option<VectorArray<'py>>,
    restarts: Option<usize>,
    seed: Option<u64>,
}

/// Attributes of `lcpstar.LemkeHowsonOptions`.
#[derive(FromPyObject)]
struct LemkeHowsonOptions {
    label: Option<usize>,
}

/// Attributes of `lcpstar.BilinearOptions`.
#[derive(FromPyObject)]
struct BilinearOptions {
    starts: Option<usize>,
    seed: Option<u64>,
}

/// Attributes of `lcpstar.BlockPivotingOptions`.
#[derive(FromPyObject)]
struct BlockPivotingOptions {
    patience: Option<usize>,
    alpha: Option<Vec<i64>>,
}

/// The method of that name with the options that were set.
pub fn method(py: Python<'_>, name: &str, options: Option<&Bound<'_, PyAny>>, n: usize) -> PyResult<Method> {
    let mut method = Method::from_name(name).map_err(|e| to_python(py, &e))?;
    let Some(options) = options else { return Ok(method) };
    match &mut method {
        Method::Lemke { settings: lemke::Settings { d }, restarts, seed } => {
            let given: LemkeOptions<'_> = options.extract()?;
            *d = given.d.as_ref().map(numbers);
            *restarts = given.restarts.unwrap_or(*restarts);
            *seed = given.seed.unwrap_or(*seed);
        }
        Method::LemkeHowson(lemke_howson::Settings { label }) => {
            let given: LemkeHowsonOptions = options.extract()?;
            *label = given.label.unwrap_or(*label);
        }
        Method::Bilinear(bilinear::Settings { starts, seed }) => {
            let given: BilinearOptions = options.extract()?;
            *starts = given.starts.unwrap_or(*starts);
            *seed = given.seed.unwrap_or(*seed);
        }
        Method::BlockPivoting(block_pivoting::Settings { patience, alpha, .. }) => {
            let given: BlockPivotingOptions = options.extract()?;
            *patience = given.patience.unwrap_or(*patience);
            *alpha = given.alpha.map(|alpha| index_set(py, "alpha", &alpha, n)).transpose()?;
        }
        Method::InteriorPoint(settings) => crate::interior::set_interior_options(settings, options)?,
        Method::PotentialReduction(settings) => crate::interior::set_potential_options(py, settings, options)?,
        Method::Approximate(method) => crate::approximate::set_options(method, options)?,
        _ => {}
    }
    Ok(method)
}

/// Solves LCP(q, A). `None` when A and q are not arrays of doubles of the right shapes: `lcpstar.solve` then coerces them
/// and calls again.
#[pyfunction]
#[pyo3(signature = (a, q, method_name, tol, max_iterations, time_limit, z0, certify, options))]
pub fn solve(
    py: Python<'_>,
    a: &Bound<'_, PyAny>,
    q: &Bound<'_, PyAny>,
    method_name: &str,
    tol: f64,
    max_iterations: Option<usize>,
    time_limit: Option<f64>,
    z0: Option<VectorArray<'_>>,
    certify: &str,
    options: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<PySolution>> {
    let start = Instant::now();
    let Some(lcp) = to_lcp_as_is(py, a, q)? else { return Ok(None) };
    let method = method(py, method_name, options, lcp.n())?;
    let certify = Certify::from_name(certify).map_err(|e| to_python(py, &e))?;
    let settings = Settings { method, tol, z0: z0.as_ref().map(numbers), certify };
    let deadline = deadline(py, start, time_limit)?;
    let control = Control { max_iterations, deadline, interrupted: None };
    let brief = lcp.n() <= BRIEF_UP_TO;
    if brief && let Some(solution) = enter_core_briefly(py, || Ok(driver::solve_briefly(&lcp, &settings, &control)))? {
        return Ok(Some(PySolution::new(solution, start.elapsed().as_secs_f64())));
    }
    let signals = Signals::since(start);
    let control = Control { interrupted: Some(&|| signals.interrupted()), ..control };
    let rest = if brief { driver::solve_at_length } else { driver::solve };
    let solution = enter_core(py, || rest(&lcp, &settings, &control))?;
    signals.raise()?;
    Ok(Some(PySolution::new(solution, start.elapsed().as_secs_f64())))
}

/// That many seconds after `start`, `start` itself for none or less; no time where it is too long to express.
pub fn after(start: Instant, seconds: f64) -> Option<Instant> {
    let limit = Duration::try_from_secs_f64(seconds.max(0.0)).ok()?;
    start.checked_add(limit)
}

/// When to stop; a time limit too long to express is none.
pub fn deadline(py: Python<'_>, start: Instant, time_limit: Option<f64>) -> PyResult<Option<Instant>> {
    match time_limit {
        None => Ok(None),
        Some(value) if value > 0.0 => Ok(after(start, value)),
        Some(value) => Err(to_python(py, &LcpError::OutOfRange { name: "time_limit", value, rule: "positive" })),
    }
}

/// The principal pivot transform of (A, q).
#[pyfunction]
pub fn ppt<'py>(
    py: Python<'py>,
    a: MatrixArray<'py>,
    alpha: Vec<i64>,
    q: Option<VectorArray<'py>>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>)> {
    let (n, a) = square(py, "A", &a)?;
    let q = q.as_ref().map_or_else(|| vec![0.0; n], numbers);
    let alpha = index_set(py, "alpha", &alpha, n)?;
    let signals = Signals::new();
    let control = Control { interrupted: Some(&|| signals.interrupted()), ..Control::default() };
    let transformed = enter_core(py, || principal_pivot_transform(&Lcp::new(n, a, q)?, &alpha, &control))?;
    signals.raise()?;
    let Some(transformed) = transformed else { return Err(raise(py, "InternalError", "the transform was stopped")) };
    let m = PyArray1::from_slice(py, transformed.a()).reshape([n, n])?;
    Ok((m, PyArray1::from_slice(py, transformed.q())))
}
