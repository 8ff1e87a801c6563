//! The problem LCP(q, A), validated once; below it sizes and finiteness are trusted.

use crate::error::{LcpError, Result};
use lcpstar_exact::problem::Problem;
use lcpstar_linalg::square::Square;
use std::sync::{Arc, OnceLock};

/// LCP(q, A): find `z` with `w = A z + q >= 0`, `z >= 0`, `z'w = 0`.
///
/// Owns its numbers: `A` row-major, `n * n` entries, shared with problems that differ in q; `q`, `n` entries; all finite.
#[derive(Clone, Debug)]
pub struct Lcp {
    n: usize,
    a: Arc<Matrix>,
    q: Vec<f64>,
}

/// A, row-major, and what has been found out about it.
#[derive(Debug)]
struct Matrix {
    entries: Vec<f64>,
    symmetric: OnceLock<bool>,
}

impl Lcp {
    /// Takes ownership of `A` (row-major) and `q`. O(n^2).
    ///
    /// # Errors
    /// `WrongLength` unless `a.len() == n * n` and `q.len() == n`; `NotFinite` for NaN or infinity.
    pub fn new(n: usize, a: Vec<f64>, q: Vec<f64>) -> Result<Self> {
        if a.len() != n * n {
            return Err(LcpError::WrongLength { name: "A", expected: n * n, found: a.len() });
        }
        if q.len() != n {
            return Err(LcpError::WrongLength { name: "q", expected: n, found: q.len() });
        }
        check_finite_matrix("A", &a, n)?;
        check_finite("q", &q)?;
        Ok(Self::trusted(n, a, q))
    }

    /// A problem whose sizes are right and whose numbers come from a validated one.
    pub(crate) fn trusted(n: usize, a: Vec<f64>, q: Vec<f64>) -> Self {
        debug_assert!(a.len() == n * n && q.len() == n);
        Self { n, a: Arc::new(Matrix { entries: a, symmetric: OnceLock::new() }), q }
    }

    /// LCP(q, A) with the same A and another q, which is as trusted as [`Lcp::trusted`] says. O(n).
    pub(crate) fn with_q(&self, q: Vec<f64>) -> Self {
        debug_assert!(q.len() == self.n);
        Self { n: self.n, a: Arc::clone(&self.a), q }
    }

    /// Order of the problem.
    #[must_use]
    pub fn n(&self) -> usize {
        self.n
    }

    /// `A`, row-major.
    #[must_use]
    pub fn a(&self) -> &[f64] {
        &self.a.entries
    }

    /// Whether A is symmetric. O(n^2) the first time.
    #[must_use]
    pub fn is_symmetric(&self) -> bool {
        *self.a.symmetric.get_or_init(|| crate::linalg::kernels::is_symmetric(self.n, self.a()))
    }

    /// The numbers, as exact arithmetic reads them.
    #[must_use]
    pub fn view(&self) -> Problem<'_> {
        Problem::new(self.a(), &self.q)
    }

    /// A, as linear algebra reads it.
    #[must_use]
    pub fn square(&self) -> Square<'_> {
        Square { n: self.n, entries: self.a() }
    }

    /// Row `i` of `A`.
    #[must_use]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.a()[i * self.n..(i + 1) * self.n]
    }

    /// `q`.
    #[must_use]
    pub fn q(&self) -> &[f64] {
        &self.q
    }
}

/// # Errors
/// `NotFinite` names the first entry that is NaN or infinite.
pub fn check_finite(name: &'static str, v: &[f64]) -> Result<()> {
    match first_not_finite(v) {
        None => Ok(()),
        Some(i) => Err(LcpError::NotFinite { name, index: vec![i], value: v[i] }),
    }
}

/// As [`check_finite`], for a row-major matrix with `columns` columns.
///
/// # Errors
/// `NotFinite` with row and column.
pub fn check_finite_matrix(name: &'static str, a: &[f64], columns: usize) -> Result<()> {
    match first_not_finite(a) {
        None => Ok(()),
        Some(i) => Err(LcpError::NotFinite { name, index: vec![i / columns, i % columns], value: a[i] }),
    }
}

/// One vectorised pass, then the search.
fn first_not_finite(v: &[f64]) -> Option<usize> {
    if crate::linalg::kernels::all_finite(v) { None } else { v.iter().position(|x| !x.is_finite()) }
}
