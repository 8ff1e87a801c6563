//! Proofs for Python: verdicts with exact integers over one denominator.

use crate::arrays;
use crate::errors::{enter_core, to_python};
use lcpstar::LcpError;
use lcpstar::exact::dyadic::RationalVec;
use lcpstar::exact::proof::{self, ProofOutcome};
use lcpstar::exact::repair::{self, Repaired};
use num_bigint::BigInt;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// Numerators and their common denominator.
pub type Exact = (Vec<BigInt>, BigInt);

fn split(v: RationalVec) -> Exact {
    (v.numerators, v.denominator)
}

/// `(verdict, index, z)`: `"proved"` with `z`; `"negative_z"`, `"negative_w"` with the index; `"singular"`.
#[pyfunction]
pub fn prove_solution(
    py: Python<'_>,
    a: PyReadonlyArray2<'_, f64>,
    q: PyReadonlyArray1<'_, f64>,
    alpha: Vec<usize>,
) -> PyResult<(&'static str, Option<usize>, Option<Exact>)> {
    let lcp = arrays::to_lcp(py, &a, &q)?;
    let n = lcp.n();
    for (k, &i) in alpha.iter().enumerate() {
        let repeated = alpha[..k].contains(&i);
        if i >= n || repeated {
            return Err(to_python(py, &LcpError::BadIndex { name: "alpha", index: i as i64, n, repeated }));
        }
    }
    let outcome = enter_core(py, || Ok(proof::prove_solution(&lcp, &alpha, &|| false)))?;
    Ok(match outcome {
        ProofOutcome::Proved(solution) => ("proved", None, Some(split(solution.z))),
        ProofOutcome::NegativeZ(i) => ("negative_z", Some(i), None),
        ProofOutcome::NegativeW(i) => ("negative_w", Some(i), None),
        ProofOutcome::Singular { rank } => ("singular", Some(rank), None),
        ProofOutcome::Interrupted => ("interrupted", None, None),
    })
}

/// Exact pivoting from `alpha`: `("solved", alpha, z, pivots)`, or `("ray", start, z, 0)` with the direction.
#[pyfunction]
pub fn repair_solution(
    py: Python<'_>,
    a: PyReadonlyArray2<'_, f64>,
    q: PyReadonlyArray1<'_, f64>,
    alpha: Vec<usize>,
) -> PyResult<(&'static str, Vec<usize>, Option<Exact>, usize)> {
    let lcp = arrays::to_lcp(py, &a, &q)?;
    let outcome = enter_core(py, || Ok(repair::repair(&lcp, &alpha, &|| false)))?;
    Ok(match outcome {
        Repaired::Solved(solution, pivots) => ("solved", solution.alpha, Some(split(solution.z)), pivots),
        Repaired::Ray(ray, start) => ("ray", start, Some(split(ray.z)), 0),
        Repaired::Interrupted => ("interrupted", vec![], None, 0),
    })
}
