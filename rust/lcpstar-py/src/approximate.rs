//! Options of the approximate methods.

use lcpstar::driver::Approximate;
use lcpstar::methods::{admm, newton, pgs, pgs_sm};
use pyo3::prelude::*;

/// Attributes of `lcpstar.PgsOptions`; `None` means the core's default.
#[derive(FromPyObject)]
struct PgsOptions {
    relaxation: Option<f64>,
    symmetric: Option<bool>,
}

/// Attributes of `lcpstar.PgsSmOptions`.
#[derive(FromPyObject)]
struct PgsSmOptions {
    sweeps: Option<usize>,
    solves: Option<usize>,
    relaxation: Option<f64>,
}

/// Attributes of `lcpstar.AdmmOptions`.
#[derive(FromPyObject)]
struct AdmmOptions {
    rho: Option<f64>,
    relaxation: Option<f64>,
    polish: Option<bool>,
}

/// Attributes of `lcpstar.NewtonOptions`.
#[derive(FromPyObject)]
struct NewtonOptions {
    patience: Option<usize>,
}

/// Overwrites the settings that were given.
pub fn set_options(method: &mut Approximate, options: &Bound<'_, PyAny>) -> PyResult<()> {
    match method {
        Approximate::Pgs(pgs::Settings { relaxation, symmetric }) => {
            let given: PgsOptions = options.extract()?;
            *relaxation = given.relaxation.unwrap_or(*relaxation);
            *symmetric = given.symmetric.unwrap_or(*symmetric);
        }
        Approximate::PgsSm(pgs_sm::Settings { sweeps, solves, relaxation }) => {
            let given: PgsSmOptions = options.extract()?;
            *sweeps = given.sweeps.unwrap_or(*sweeps);
            *solves = given.solves.unwrap_or(*solves);
            *relaxation = given.relaxation.unwrap_or(*relaxation);
        }
        Approximate::Admm(admm::Settings { rho, relaxation, polish }) => {
            let given: AdmmOptions = options.extract()?;
            *rho = given.rho.unwrap_or(*rho);
            *relaxation = given.relaxation.unwrap_or(*relaxation);
            *polish = given.polish.unwrap_or(*polish);
        }
        Approximate::Newton(newton::Settings { patience }) => {
            let given: NewtonOptions = options.extract()?;
            *patience = given.patience.unwrap_or(*patience);
        }
        Approximate::Nncg | Approximate::Apgd => {}
    }
    Ok(())
}
