//! Bulk scans: formulas come as nested tuples.

use lcpstar::Control;
use lcpstar::classes::budget::Stopped;
use lcpstar::classes::class::{Class, Facts};
use lcpstar::classes::formula::{Derived, Formula, Quantity, Range};
use lcpstar::classes::scan::Space;
use lcpstar::exact::int::Int;
use lcpstar::explore::explore;
use num_bigint::BigInt;
use pyo3::exceptions::{PyTimeoutError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::cmp::Ordering;
use std::time::Instant;

use crate::classes::IntegerMatrix;
use crate::errors::{Signals, enter_core};
use crate::solve::after;

fn bad(what: &str) -> PyErr {
    PyValueError::new_err(format!("formula: {what}"))
}

/// A formula from `(head, ...)`.
fn formula(tree: &Bound<'_, PyAny>) -> PyResult<Formula> {
    let tree = tree.cast::<PyTuple>()?;
    let head: String = tree.get_item(0)?.extract()?;
    let inner = |i: usize| -> PyResult<Box<Formula>> { Ok(Box::new(formula(&tree.get_item(i)?)?)) };
    let parts = || tree.iter().skip(1).map(|part| formula(&part)).collect::<PyResult<Vec<_>>>();
    Ok(match head.as_str() {
        "in" => {
            let symbol: String = tree.get_item(1)?.extract()?;
            Formula::In(Class::parse(&symbol).ok_or_else(|| bad(&symbol))?)
        }
        "symmetric" => Formula::IsSymmetric,
        "skew" => Formula::IsSkew,
        "bordered" => Formula::IsBordered,
        "not" => Formula::Not(inner(1)?),
        "and" => Formula::And(parts()?),
        "or" => Formula::Or(parts()?),
        "of" => Formula::Of(derived(&tree.get_item(1)?)?, inner(2)?),
        "every" => Formula::Every(range(&tree.get_item(1)?)?, inner(2)?),
        "some" => Formula::Some(range(&tree.get_item(1)?)?, inner(2)?),
        "compare" => {
            let relation: String = tree.get_item(2)?.extract()?;
            let orderings = match relation.as_str() {
                "<" => vec![Ordering::Less],
                "<=" => vec![Ordering::Less, Ordering::Equal],
                ">" => vec![Ordering::Greater],
                ">=" => vec![Ordering::Greater, Ordering::Equal],
                "==" => vec![Ordering::Equal],
                "!=" => vec![Ordering::Less, Ordering::Greater],
                other => return Err(bad(other)),
            };
            let number = |i: usize| -> PyResult<Int> { Ok(Int::from(tree.get_item(i)?.extract::<BigInt>()?)) };
            Formula::Compare(quantity(&tree.get_item(1)?)?, orderings, number(3)?, number(4)?)
        }
        other => return Err(bad(other)),
    })
}

fn quantity(tree: &Bound<'_, PyAny>) -> PyResult<Quantity> {
    let tree = tree.cast::<PyTuple>()?;
    let head: String = tree.get_item(0)?.extract()?;
    Ok(match head.as_str() {
        "v" => Quantity::Value,
        "det" => Quantity::Determinant,
        "rank" => Quantity::Rank,
        "n" => Quantity::Order,
        "trace" => Quantity::Trace,
        "min" => Quantity::Least,
        "max" => Quantity::Largest,
        "a" => Quantity::Entry(tree.get_item(1)?.extract()?, tree.get_item(2)?.extract()?),
        other => return Err(bad(other)),
    })
}

fn derived(tree: &Bound<'_, PyAny>) -> PyResult<Derived> {
    let tree = tree.cast::<PyTuple>()?;
    let head: String = tree.get_item(0)?.extract()?;
    let mask = || tree.get_item(1)?.extract::<u64>();
    Ok(match head.as_str() {
        "transpose" => Derived::Transpose,
        "symmetric" => Derived::Symmetric,
        "inverse" => Derived::Inverse,
        "negative" => Derived::Negative,
        "principal" => Derived::Principal(mask()?),
        "ppt" => Derived::Transform(mask()?),
        other => return Err(bad(other)),
    })
}

fn range(tree: &Bound<'_, PyAny>) -> PyResult<Range> {
    let tree = tree.cast::<PyTuple>()?;
    let head: String = tree.get_item(0)?.extract()?;
    match head.as_str() {
        "ppt" => Ok(Range::Transforms),
        "principal" => Ok(Range::Principals(tree.get_item(1)?.extract()?, tree.get_item(2)?.extract()?)),
        other => Err(bad(other)),
    }
}

/// Scans matrices `start..stop`: (scanned, hypothesis, failed, (number, entries) of the smallest failure or None).
#[pyfunction]
#[pyo3(signature = (n, entries, up_to_permutation, seed, hypothesis, conclusion, start, stop, threads, time_limit=None))]
#[allow(clippy::type_complexity)] // one tuple, unpacked at once in Python
pub fn scan(
    py: Python<'_>,
    n: usize,
    entries: Vec<i64>,
    up_to_permutation: bool,
    seed: Option<u64>,
    hypothesis: &Bound<'_, PyAny>,
    conclusion: &Bound<'_, PyAny>,
    start: u64,
    stop: u64,
    threads: usize,
    time_limit: Option<f64>,
) -> PyResult<(u64, u64, u64, Option<(u64, Vec<i64>)>)> {
    let (hypothesis, conclusion) = (formula(hypothesis)?, formula(conclusion)?);
    let space = Space { n, entries, up_to_permutation, seed };
    let deadline = time_limit.and_then(|limit| after(Instant::now(), limit));
    let signals = Signals::new();
    let control = Control { deadline, interrupted: Some(&|| signals.interrupted()), ..Control::default() };
    let tally = enter_core(py, || Ok(explore(&space, &hypothesis, &conclusion, start..stop, threads, &control)))?;
    signals.raise()?;
    let sum = tally.map_err(|(Stopped::TimeLimit | Stopped::Cancelled)| PyTimeoutError::new_err((0, 0)))?;
    Ok((sum.scanned, sum.hypothesis, sum.failed, sum.smallest))
}

/// Whether one matrix satisfies a formula.
#[pyfunction]
#[pyo3(signature = (matrix, statement, time_limit=None))]
pub fn satisfies(
    py: Python<'_>,
    matrix: &IntegerMatrix,
    statement: &Bound<'_, PyAny>,
    time_limit: Option<f64>,
) -> PyResult<bool> {
    let statement = formula(statement)?;
    matrix.search(py, time_limit, |budget| statement.holds(&Facts::new(matrix.a.clone()), budget))
}
