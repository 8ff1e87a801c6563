//! The interior point methods: `potential_reduction` with its trace, and options.

use lcpstar::driver;
use lcpstar::methods::interior_point;
use lcpstar::methods::potential_reduction::{self as potential, DirectionSolver, Record, Settings, Stop};
use lcpstar::{Control, LcpError};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::time::Instant;

use crate::arrays::{MatrixArray, VectorArray, numbers, square, to_lcp};
use crate::errors::{Signals, enter_core, to_python};
use crate::solution::PySolution;

/// Attributes of `lcpstar.PotentialReductionOptions`; `None` means the core's default.
#[derive(FromPyObject)]
struct PotentialReductionOptions {
    beta: Option<f64>,
    gamma: Option<f64>,
    sigma: Option<f64>,
    kappa_factor: Option<f64>,
    min_halvings: Option<usize>,
    direction: Option<String>,
    long_step: Option<bool>,
}

/// Overwrites the settings that were given.
pub fn set_potential_options(py: Python<'_>, settings: &mut Settings, options: &Bound<'_, PyAny>) -> PyResult<()> {
    let given: PotentialReductionOptions = options.extract()?;
    let direction = given.direction.map(|name| direction_solver(py, &name)).transpose()?;
    *settings = Settings {
        beta: given.beta.unwrap_or(settings.beta),
        gamma: given.gamma.unwrap_or(settings.gamma),
        sigma: given.sigma.unwrap_or(settings.sigma),
        kappa_factor: given.kappa_factor.unwrap_or(settings.kappa_factor),
        min_halvings: given.min_halvings.unwrap_or(settings.min_halvings),
        direction: direction.unwrap_or(settings.direction),
        long_step: given.long_step.unwrap_or(settings.long_step),
        stop: settings.stop.clone(),
    };
    Ok(())
}

/// Attributes of `lcpstar.InteriorPointOptions`.
#[derive(FromPyObject)]
struct InteriorPointOptions {
    finish: Option<bool>,
}

/// Overwrites the settings that were given.
pub fn set_interior_options(settings: &mut interior_point::Settings, options: &Bound<'_, PyAny>) -> PyResult<()> {
    let given: InteriorPointOptions = options.extract()?;
    settings.finish = given.finish.unwrap_or(settings.finish);
    Ok(())
}

fn direction_solver(py: Python<'_>, name: &str) -> PyResult<DirectionSolver> {
    DirectionSolver::from_name(name).map_err(|e| to_python(py, &e))
}

/// The paper's method; arguments already coerced by `lcpstar.potential_reduction`. `trace` is a list to extend, or `None`.
#[pyfunction]
#[pyo3(signature = (a, q, z0, eps, max_iterations, options, trace))]
pub fn potential_reduction(
    py: Python<'_>,
    a: MatrixArray<'_>,
    q: VectorArray<'_>,
    z0: Option<VectorArray<'_>>,
    eps: f64,
    max_iterations: usize,
    options: &Bound<'_, PyAny>,
    trace: bool,
) -> PyResult<PySolution> {
    let start = Instant::now();
    let lcp = to_lcp(py, &a, &q)?;
    let z0 = z0.as_ref().map(numbers);
    let mut settings = Settings { stop: Stop::Gap(eps), ..Settings::default() };
    set_potential_options(py, &mut settings, options)?;
    let signals = Signals::new();
    let control =
        Control { max_iterations: Some(max_iterations), deadline: None, interrupted: Some(&|| signals.interrupted()) };
    let mut rows = Vec::new();
    let keep = |row: Record| {
        if trace {
            rows.push(row);
        }
    };
    let solution = enter_core(py, || driver::potential_reduction(&lcp, z0.as_deref(), &settings, &control, keep))?;
    signals.raise()?;
    let records = if trace { Some(records(py, rows)?) } else { None };
    Ok(PySolution::with_trace(solution, start.elapsed().as_secs_f64(), records))
}

/// The scaled direction `(u, v, solver)` with `d_z = Z u`, `d_w = W v`, before it is given its length.
#[pyfunction]
pub fn potential_direction<'py>(
    py: Python<'py>,
    a: MatrixArray<'py>,
    z: VectorArray<'py>,
    w: VectorArray<'py>,
    kappa: f64,
    direction: &str,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, &'static str)> {
    let (n, a) = square(py, "A", &a)?;
    let (z, w) = (numbers(&z), numbers(&w));
    for (name, v) in [("z", &z), ("w", &w)] {
        if v.len() != n {
            return Err(to_python(py, &LcpError::WrongLength { name, expected: n, found: v.len() }));
        }
    }
    let solver = direction_solver(py, direction)?;
    let found = enter_core(py, || Ok(potential::scaled_direction(&a, &z, &w, kappa, solver)))?;
    match found {
        Some(d) => Ok((PyArray1::from_vec(py, d.u), PyArray1::from_vec(py, d.v), d.solver.as_str())),
        None => Err(crate::errors::raise(py, "StartError", "the direction is not finite at this (z, w)")),
    }
}

/// The trace as a list of `lcpstar.interior.Record`.
fn records(py: Python<'_>, rows: Vec<Record>) -> PyResult<Py<PyAny>> {
    let class = py.import("lcpstar.interior")?.getattr("Record")?;
    let list = PyList::empty(py);
    for row in rows {
        let fields = PyDict::new(py);
        fields.set_item("k", row.k)?;
        for (name, values) in [("z", row.z), ("w", row.w), ("dz", row.dz), ("dw", row.dw)] {
            fields.set_item(name, PyArray1::from_vec(py, values))?;
        }
        fields.set_item("psi", row.psi)?;
        fields.set_item("kappa", row.kappa)?;
        fields.set_item("halvings", row.halvings)?;
        fields.set_item("solver", row.solver.as_str())?;
        list.append(class.call((), Some(&fields))?)?;
    }
    Ok(list.into_any().unbind())
}
