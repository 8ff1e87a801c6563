//! The functions that a Rust program calls: slices in, answers that own their numbers out.

use crate::batch::{self, Alpha, Guess, Numbers, Output, Problems, Source};
use crate::control::Control;
use crate::driver::{self, Certify};
use crate::error::{LcpError, Result};
use crate::exact::classes::budget::Budget;
use crate::exact::classes::class::{Class, Facts, SYMBOLS};
use crate::exact::dyadic::RationalVec;
use crate::exact::imatrix::IMatrix;
use crate::exact::int::Int;
use crate::member::Member;
use crate::options::{Options, deadline};
use crate::pivoting::transform::principal_pivot_transform;
use crate::problem::{Lcp, check_finite_matrix};
use crate::solution::Solution;
use crate::sparse::SparseLcp;
use crate::status::Status;
use std::time::Duration;

/// Solves LCP(q, A), `a` row-major, and verifies the answer against these numbers.
///
/// ```
/// # fn main() -> lcpstar::Result<()> {
/// let solution = lcpstar::solve(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0], &Default::default())?;
/// assert!(solution.is_solved() && solution.residual() <= 1e-9);
/// assert!((solution.z()[0] - 4.0 / 3.0).abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Only for a broken promise of the caller: a wrong length, a number that is not finite, an option out of range.
pub fn solve(a: &[f64], q: &[f64], options: &Options) -> Result<Solution> {
    let lcp = Lcp::new(q.len(), a.to_vec(), q.to_vec())?;
    driver::solve(&lcp, &options.settings, &options.control())
}

/// Solves an LCP with a sparse A and verifies the answer.
///
/// ```
/// # fn main() -> lcpstar::Result<()> {
/// // [[2, -1], [-1, 2]] by rows: where each row starts, its columns, its values.
/// let lcp = lcpstar::SparseLcp::new(vec![0, 2, 4], vec![0, 1, 0, 1], vec![2.0, -1.0, -1.0, 2.0], vec![-1.0, 1.0])?;
/// let solution = lcpstar::solve_sparse(&lcp, &Default::default())?;
/// assert_eq!(solution.z(), [0.5, 0.0]);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// As [`solve`]; `UnknownName` for a method that takes no sparse A of that order, `TooLarge` for an exact proof of an order above 2000.
pub fn solve_sparse(lcp: &SparseLcp, options: &Options) -> Result<Solution> {
    driver::solve_sparse(lcp, &options.settings, &options.control())
}

/// Solves `q.len() / n` problems of order `n`, with a matrix for each in `a`, or one for all. The bits of an answer do not depend on
/// the number of threads.
///
/// ```
/// # fn main() -> lcpstar::Result<()> {
/// let batch = lcpstar::solve_batch(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0, 1.0, -4.0], 2, &Default::default())?;
/// assert!(batch.all_solved());
/// assert_eq!((batch.len(), batch.z(1)), (2, &[0.0, 2.0][..]));
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// As [`solve`]; `NotTaken` for `certify`, `max_iterations` and `time_limit`.
pub fn solve_batch(a: &[f64], q: &[f64], n: usize, options: &Options) -> Result<Batch> {
    let exact = options.settings.certify == Certify::Exact;
    let (limited, timed) = (options.max_iterations.is_some(), options.time_limit.is_some());
    if let Some(&(name, _)) =
        [("certify", exact), ("max_iterations", limited), ("time_limit", timed)].iter().find(|(_, given)| *given)
    {
        return Err(LcpError::NotTaken { name, by: "solve_batch" });
    }
    let count = q.len().checked_div(n).unwrap_or(0);
    let one = a.len() == n * n;
    let length = |name, expected, found| {
        if expected == found { Ok(()) } else { Err(LcpError::WrongLength { name, expected, found }) }
    };
    length("q", count * n, q.len())?;
    length("A", if one { n * n } else { count * n * n }, a.len())?;
    if let Some(z0) = &options.settings.z0 {
        length("z0", count * n, z0.len())?;
    }
    let problems = Problems {
        n,
        count,
        a: Numbers::Double(a),
        a_source: if one { Source::One } else { Source::Each },
        q: Numbers::Double(q),
        q_source: Source::Each,
    };
    let settings = batch::Settings {
        method: &options.settings.method,
        tol: options.settings.tol,
        threads: options.threads,
        guess: options.settings.z0.as_deref().map_or(Guess::None, Guess::Points),
        interrupted: None,
    };
    let mut found = Batch {
        n,
        z: vec![0.0; count * n],
        w: vec![0.0; count * n],
        status: vec![0; count],
        method: vec![0; count],
        iterations: vec![0; count],
        residual: vec![0.0; count],
        natural_residual: vec![0.0; count],
        alpha: vec![false; count * n],
    };
    let output = Output {
        z: &mut found.z,
        w: &mut found.w,
        status: &mut found.status,
        method: &mut found.method,
        iterations: &mut found.iterations,
        residual: &mut found.residual,
        natural_residual: &mut found.natural_residual,
        alpha: Alpha::Flags(&mut found.alpha),
    };
    batch::solve_batch(&problems, &settings, output)?;
    Ok(found)
}

/// The verified answers to a batch; `k` counts the problems from 0.
#[derive(Clone, Debug)]
pub struct Batch {
    n: usize,
    z: Vec<f64>,
    w: Vec<f64>,
    status: Vec<u8>,
    method: Vec<u8>,
    iterations: Vec<u32>,
    residual: Vec<f64>,
    natural_residual: Vec<f64>,
    alpha: Vec<bool>,
}

impl Batch {
    /// Problems.
    #[must_use]
    pub fn len(&self) -> usize {
        self.status.len()
    }

    /// Whether there was none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.status.is_empty()
    }

    /// Whether every problem is solved.
    #[must_use]
    pub fn all_solved(&self) -> bool {
        (0..self.len()).all(|k| self.status(k) == Status::Solved)
    }

    /// The point of problem `k`.
    #[must_use]
    pub fn z(&self, k: usize) -> &[f64] {
        &self.z[k * self.n..(k + 1) * self.n]
    }

    /// `A z + q` of problem `k`.
    #[must_use]
    pub fn w(&self, k: usize) -> &[f64] {
        &self.w[k * self.n..(k + 1) * self.n]
    }

    /// What is claimed of problem `k`. [`solve`] gives the certificate.
    #[must_use]
    pub fn status(&self, k: usize) -> Status {
        Status::ALL[usize::from(self.status[k])]
    }

    /// Who answered problem `k`.
    #[must_use]
    pub fn method(&self, k: usize) -> Member {
        Member::ALL[usize::from(self.method[k])]
    }

    /// Factorisations, pivots or iterations of problem `k`.
    #[must_use]
    pub fn iterations(&self, k: usize) -> u32 {
        self.iterations[k]
    }

    /// As [`Solution::residual`].
    #[must_use]
    pub fn residual(&self, k: usize) -> f64 {
        self.residual[k]
    }

    /// As [`Solution::natural_residual`].
    #[must_use]
    pub fn natural_residual(&self, k: usize) -> f64 {
        self.natural_residual[k]
    }

    /// The indices of the complementary basis or support of problem `k`.
    pub fn alpha(&self, k: usize) -> impl Iterator<Item = usize> {
        (0..self.n).filter(move |i| self.alpha[k * self.n + i])
    }
}

/// The principal pivot transform (M, p) of (A, q) on `alpha`, in which `w_alpha` and `z_alpha` trade places.
///
/// ```
/// # fn main() -> lcpstar::Result<()> {
/// let transformed = lcpstar::ppt(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0], &[0])?;
/// assert_eq!((transformed.a(), transformed.q()), (&[0.5, -0.5, 0.5, 1.5][..], &[2.5, -3.5][..]));
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// `SingularBlock` where `A[alpha, alpha]` is singular, `BadIndex`, `WrongLength`, `NotFinite`.
pub fn ppt(a: &[f64], q: &[f64], alpha: &[usize]) -> Result<Lcp> {
    let lcp = Lcp::new(q.len(), a.to_vec(), q.to_vec())?;
    Ok(principal_pivot_transform(&lcp, alpha, &Control::default())?.expect("nobody asks it to stop"))
}

/// Largest order of [`is_in_class`] and [`classify`]: index sets are kept in words of 64 bits.
const CLASSES_UP_TO: usize = 60;

/// Whether A, row-major of order `n`, is in the class of that symbol ("P", "E0", "CSU", ...); `None` when `time_limit` ended the
/// search. Decided in exact arithmetic on these numbers; exponential in `n` for most classes.
///
/// ```
/// # fn main() -> lcpstar::Result<()> {
/// assert_eq!(lcpstar::is_in_class(&[2.0, 1.0, 1.0, 2.0], 2, "P", None)?, Some(true));
/// assert_eq!(lcpstar::is_in_class(&[1.0, 2.0, 2.0, 1.0], 2, "P", None)?, Some(false));
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// `UnknownName` for the symbol; `WrongLength`, `NotFinite`; `OutOfRange` for order 0 and `TooLarge` beyond 60.
pub fn is_in_class(a: &[f64], n: usize, symbol: &str, time_limit: Option<Duration>) -> Result<Option<bool>> {
    let class = Class::parse(symbol).ok_or_else(|| LcpError::UnknownName {
        name: "class",
        value: symbol.to_owned(),
        choices: &SYMBOLS_ONLY,
    })?;
    let facts = facts(a, n)?;
    Ok(facts.holds(class, &Budget::new(deadline(time_limit), None)).ok())
}

/// Each class, by its symbol, and whether A is in it; `None` for what `time_limit` left open.
///
/// ```
/// # fn main() -> lcpstar::Result<()> {
/// let report = lcpstar::classify(&[0.0, 1.0, 1.0, 2.0, 0.0, 2.0, -2.0, -5.0, 0.0], 3, None)?;
/// let holds: Vec<&str> = report.iter().filter(|(_, holds)| *holds == Some(true)).map(|(symbol, _)| *symbol).collect();
/// assert_eq!(holds, ["E0", "L2", "L", "Q0", "E0s", "tE0s"]);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// As [`is_in_class`].
pub fn classify(a: &[f64], n: usize, time_limit: Option<Duration>) -> Result<Vec<(&'static str, Option<bool>)>> {
    let facts = facts(a, n)?;
    let budget = Budget::new(deadline(time_limit), None);
    Ok(SYMBOLS.iter().map(|&(symbol, class)| (symbol, facts.holds(class, &budget).ok())).collect())
}

/// The symbols of the classes.
const SYMBOLS_ONLY: [&str; SYMBOLS.len()] = {
    let mut symbols = [""; SYMBOLS.len()];
    let mut i = 0;
    while i < symbols.len() {
        symbols[i] = SYMBOLS[i].0;
        i += 1;
    }
    symbols
};

/// A times a positive number that makes its entries integers: every class keeps its verdict.
fn facts(a: &[f64], n: usize) -> Result<Facts> {
    if n == 0 {
        return Err(LcpError::OutOfRange { name: "n", value: 0.0, rule: "at least 1" });
    }
    if n > CLASSES_UP_TO {
        return Err(LcpError::TooLarge { name: "a class", n, limit: CLASSES_UP_TO });
    }
    if a.len() != n * n {
        return Err(LcpError::WrongLength { name: "A", expected: n * n, found: a.len() });
    }
    check_finite_matrix("A", a, n)?;
    let integers = RationalVec::from_f64(a).numerators;
    Ok(Facts::new(IMatrix::new(n, n, integers.into_iter().map(Int::from).collect())))
}

/// All solutions of LCP(q, A), as the maximal faces of the solution set in exact numbers; `None` when `time_limit` ended the search.
///
/// ```
/// # fn main() -> lcpstar::Result<()> {
/// let faces = lcpstar::all_solutions(&[0.0, 1.0, 1.0, 0.0], &[-1.0, -1.0], None)?.expect("no limit");
/// assert_eq!(faces.len(), 1);
/// assert_eq!(faces[0].vertices[0].to_f64(), [1.0, 1.0]);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// As [`solve`]; `TooLarge` beyond order 127.
#[cfg(feature = "exact")]
pub fn all_solutions(
    a: &[f64],
    q: &[f64],
    time_limit: Option<Duration>,
) -> Result<Option<Vec<crate::solutions::Face>>> {
    let lcp = Lcp::new(q.len(), a.to_vec(), q.to_vec())?;
    let control = Control { deadline: deadline(time_limit), ..Control::default() };
    Ok(crate::solutions::solutions(&lcp, &control)?.ok())
}
