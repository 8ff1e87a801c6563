//! `lcpstar.Solution`: frozen, arrays built on first use so that a call of `solve` costs no array nobody reads.

use lcpstar::exact::dyadic::RationalVec;
use lcpstar::{Certificate, Ray, Solution, Status};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;

use crate::arrays::frozen_array;
use crate::errors::raise;

/// The verified result of one solve; see the stub file for the fields.
#[pyclass(name = "Solution", module = "lcpstar", frozen, weakref)]
pub struct PySolution {
    origin: Origin,
    time: f64,
    trace: Option<Py<PyAny>>,
    z: PyOnceLock<Py<PyArray1<f64>>>,
    w: PyOnceLock<Py<PyArray1<f64>>>,
    certificate: PyOnceLock<Py<PyAny>>,
    ray: PyOnceLock<Py<PyAny>>,
}

/// Who says what the fields say.
enum Origin {
    /// The judge of the core.
    Core(Solution),
    /// A pickle or a copy: as good as where it comes from; `lcpstar.verify` recomputes it.
    Record(Record),
}

/// Attributes of the record that `lcpstar.result` makes of a pickle.
#[derive(FromPyObject)]
struct Record {
    z: Vec<f64>,
    w: Vec<f64>,
    status: String,
    method: String,
    iterations: usize,
    residual: f64,
    natural_residual: f64,
    alpha: Vec<usize>,
    certificate: Option<Py<PyAny>>,
    ray: Option<Py<PyAny>>,
    pieces: Vec<(Vec<usize>, String)>,
    message: String,
    time: f64,
    trace: Option<Py<PyAny>>,
}

/// The plain fields of either origin.
struct Fields<'a> {
    z: &'a [f64],
    w: &'a [f64],
    status: &'a str,
    method: &'a str,
    iterations: usize,
    residual: f64,
    natural_residual: f64,
    alpha: &'a [usize],
    message: &'a str,
}

impl PySolution {
    /// Wraps a core solution; `time` in seconds.
    pub fn new(inner: Solution, time: f64) -> Self {
        Self::with_trace(inner, time, None)
    }

    /// As [`PySolution::new`], with a list of iteration records.
    pub fn with_trace(inner: Solution, time: f64, trace: Option<Py<PyAny>>) -> Self {
        Self::from_origin(Origin::Core(inner), time, trace)
    }

    fn from_origin(origin: Origin, time: f64, trace: Option<Py<PyAny>>) -> Self {
        Self {
            origin,
            time,
            trace,
            z: PyOnceLock::new(),
            w: PyOnceLock::new(),
            certificate: PyOnceLock::new(),
            ray: PyOnceLock::new(),
        }
    }

    fn fields(&self) -> Fields<'_> {
        match &self.origin {
            Origin::Core(s) => Fields {
                z: s.z(),
                w: s.w(),
                status: s.status().as_str(),
                method: s.method().as_str(),
                iterations: s.iterations(),
                residual: s.residual(),
                natural_residual: s.natural_residual(),
                alpha: s.alpha(),
                message: s.message(),
            },
            Origin::Record(r) => Fields {
                z: &r.z,
                w: &r.w,
                status: &r.status,
                method: &r.method,
                iterations: r.iterations,
                residual: r.residual,
                natural_residual: r.natural_residual,
                alpha: &r.alpha,
                message: &r.message,
            },
        }
    }
}

/// A class of `lcpstar.result` called with keyword arguments.
fn result_class<'py>(py: Python<'py>, name: &str, fields: &Bound<'py, PyDict>) -> PyResult<Py<PyAny>> {
    Ok(py.import("lcpstar.result")?.getattr(name)?.call((), Some(fields))?.unbind())
}

fn certificate_object(py: Python<'_>, certificate: &Certificate) -> PyResult<Py<PyAny>> {
    let fields = PyDict::new(py);
    match certificate {
        Certificate::Solution { alpha, exact } => {
            fields.set_item("kind", "solution")?;
            fields.set_item("alpha", alpha.clone())?;
            if let Some(z) = exact {
                fields.set_item("exact", true)?;
                fields.set_item("z", fractions(py, z)?)?;
            }
        }
        Certificate::Infeasible { y } => {
            fields.set_item("kind", "infeasible")?;
            fields.set_item("exact", true)?;
            fields.set_item("y", fractions(py, y)?)?;
        }
        Certificate::NearlyInfeasible { y, bound } => {
            fields.set_item("kind", "nearly_infeasible")?;
            fields.set_item("y", frozen_array(py, y))?;
            fields.set_item("bound", bound)?;
        }
        Certificate::Ray { z_hat } => {
            fields.set_item("kind", "ray")?;
            fields.set_item("exact", true)?;
            fields.set_item("z", fractions(py, z_hat)?)?;
        }
        Certificate::NotSufficient(found) => {
            fields.set_item("kind", "not_sufficient")?;
            fields.set_item("exact", true)?;
            fields.set_item(if found.transposed { "y" } else { "z" }, fractions(py, &found.x)?)?;
        }
        _ => return Err(raise(py, "InternalError", "a certificate of an unknown kind")),
    }
    result_class(py, "Certificate", &fields)
}

/// A list of `fractions.Fraction`.
fn fractions<'py>(py: Python<'py>, v: &RationalVec) -> PyResult<Bound<'py, PyAny>> {
    py.import("lcpstar.result")?.call_method1("_fractions", (v.numerators.clone(), v.denominator.clone()))
}

fn ray_object(py: Python<'_>, ray: &Ray) -> PyResult<Py<PyAny>> {
    let fields = PyDict::new(py);
    for (name, vector) in [("z", &ray.z), ("z_hat", &ray.z_hat), ("w_hat", &ray.w_hat), ("d", &ray.d)] {
        fields.set_item(name, frozen_array(py, vector))?;
    }
    fields.set_item("z0", ray.z0)?;
    fields.set_item("z0_hat", ray.z0_hat)?;
    result_class(py, "Ray", &fields)
}

#[pymethods]
impl PySolution {
    #[getter]
    fn z(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.z.get_or_init(py, || frozen_array(py, self.fields().z)).clone_ref(py)
    }

    #[getter]
    fn w(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.w.get_or_init(py, || frozen_array(py, self.fields().w)).clone_ref(py)
    }

    #[getter]
    fn status(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        static STATUS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let class =
            STATUS.get_or_try_init(py, || PyResult::Ok(py.import("lcpstar.result")?.getattr("Status")?.unbind()))?;
        class.call1(py, (self.fields().status,))
    }

    #[getter]
    fn success(&self) -> bool {
        self.fields().status == Status::Solved.as_str()
    }

    #[getter]
    fn method(&self) -> &str {
        self.fields().method
    }

    #[getter]
    fn iterations(&self) -> usize {
        self.fields().iterations
    }

    #[getter]
    fn residual(&self) -> f64 {
        self.fields().residual
    }

    #[getter]
    fn natural_residual(&self) -> f64 {
        self.fields().natural_residual
    }

    #[getter]
    fn alpha(&self) -> Vec<usize> {
        self.fields().alpha.to_vec()
    }

    #[getter]
    fn certificate(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let inner = match &self.origin {
            Origin::Core(inner) => inner,
            Origin::Record(record) => return Ok(record.certificate.as_ref().map(|object| object.clone_ref(py))),
        };
        let Some(certificate) = inner.certificate() else { return Ok(None) };
        let object = self.certificate.get_or_try_init(py, || certificate_object(py, certificate))?;
        Ok(Some(object.clone_ref(py)))
    }

    #[getter]
    fn ray(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let inner = match &self.origin {
            Origin::Core(inner) => inner,
            Origin::Record(record) => return Ok(record.ray.as_ref().map(|object| object.clone_ref(py))),
        };
        let Some(ray) = inner.ray() else { return Ok(None) };
        Ok(Some(self.ray.get_or_try_init(py, || ray_object(py, ray))?.clone_ref(py)))
    }

    #[getter]
    fn pieces(&self) -> Vec<(Vec<usize>, &str)> {
        match &self.origin {
            Origin::Core(inner) => inner.pieces().iter().map(|(i, method)| (i.clone(), method.as_str())).collect(),
            Origin::Record(record) => record.pieces.iter().map(|(i, method)| (i.clone(), method.as_str())).collect(),
        }
    }

    #[getter]
    fn message(&self) -> &str {
        self.fields().message
    }

    #[getter]
    fn time(&self) -> f64 {
        self.time
    }

    #[getter]
    fn trace(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.trace.as_ref().map(|trace| trace.clone_ref(py))
    }

    fn __repr__(&self) -> String {
        let fields = self.fields();
        format!(
            "Solution({}, method={:?}, n={}, iterations={}, residual={:.2e}, natural_residual={:.2e})",
            fields.status,
            fields.method,
            fields.z.len(),
            fields.iterations,
            fields.residual,
            fields.natural_residual
        )
    }

    /// Whether the problem is solved.
    fn __bool__(&self) -> bool {
        self.success()
    }

    /// Pickled field by field; `_restore` reads them again.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("lcpstar.result")?.call_method1("_reduce", (slf,))
    }

    /// A solution from the record of a pickle.
    #[staticmethod]
    fn _restore(mut record: Record) -> Self {
        let trace = record.trace.take();
        let time = record.time;
        Self::from_origin(Origin::Record(record), time, trace)
    }
}
