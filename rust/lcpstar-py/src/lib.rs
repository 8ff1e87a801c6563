//! Python bindings of lcpstar: convert, leave the interpreter, wrap. No algorithm, no tolerance, no default.

use pyo3::prelude::*;
use pyo3::types::PyTuple;

mod accuracy;
mod approximate;
mod arrays;
mod batch;
mod classes;
mod errors;
mod exact;
mod explore;
mod interior;
mod solution;
mod solve;
mod sparse;

/// The compiled core of lcpstar; use the `lcpstar` package instead.
#[pymodule]
mod _core {
    use super::*;

    #[pymodule_export]
    use crate::accuracy::{accuracy, accuracy_sparse};
    #[pymodule_export]
    use crate::batch::{batch_methods, solve_batch};
    #[pymodule_export]
    use crate::classes::IntegerMatrix;
    #[pymodule_export]
    use crate::exact::{prove_solution, solutions};
    #[pymodule_export]
    use crate::explore::{satisfies, scan};
    #[pymodule_export]
    use crate::interior::{potential_direction, potential_reduction};
    #[pymodule_export]
    use crate::solution::PySolution;
    #[pymodule_export]
    use crate::solve::{ppt, solve};
    #[pymodule_export]
    use crate::sparse::solve_sparse;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let close = pyo3::wrap_pyfunction!(crate::errors::close, module)?;
        module.py().import("atexit")?.call_method1("register", (close,))?;
        module.add("METHODS", PyTuple::new(module.py(), lcpstar::driver::Method::NAMES)?)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
