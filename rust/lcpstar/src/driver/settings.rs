//! What is asked of the driver: the method and its options, the tolerance, a guess, a proof; and whether they may be.

use crate::error::{LcpError, Result};
use crate::member::Member;
use crate::methods::{
    admm, bilinear, block_pivoting, enumerate, interior_point, lemke, lemke_howson, newton, pgs, pgs_sm,
    potential_reduction,
};
use crate::problem::{Lcp, check_finite};

/// The method and its options. Vectors (`d`) are in the caller's units.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Method {
    /// The documented portfolio: see [`portfolio`].
    Auto,
    /// Lemke's method; without a covering vector of the caller's, restarted with others after a failure.
    Lemke {
        /// The covering vector, or the default of ones on the equilibrated problem.
        settings: lemke::Settings,
        /// Restarts with other covering vectors (only when none was given).
        restarts: usize,
        /// Seed of the random covering vectors.
        seed: u64,
    },
    /// The Lemke-Howson method for bimatrix structure.
    LemkeHowson(lemke_howson::Settings),
    /// Successive linear programmes on the concave formulation, for any matrix.
    Bilinear(bilinear::Settings),
    /// Block principal pivoting for P-matrices.
    BlockPivoting(block_pivoting::Settings),
    /// Homogeneous predictor-corrector; its `tol` and `z0` are those of the call.
    InteriorPoint(interior_point::Settings),
    /// The criss-cross method for sufficient matrices, with a proof where A is not sufficient.
    PrincipalPivoting,
    /// Chandrasekaran's method for Z-matrices.
    Chandrasekaran,
    /// Every index set, for n up to [`enumerate::MAX_ORDER`].
    Enumerate,
    /// The paper's method; its stopping rule is replaced by one that gives `residual <= tol`.
    PotentialReduction(potential_reduction::Settings),
    /// A method that starts from the values of `z0` and stops at `tol`.
    Approximate(Approximate),
}

/// Restarts of Lemke's method with random covering vectors, unless the caller says otherwise.
pub const DEFAULT_RESTARTS: usize = 6;

impl Method {
    /// Names accepted by [`Method::from_name`].
    pub const NAMES: &'static [&'static str] = &[
        "auto",
        "lemke",
        "lemke_howson",
        "principal_pivoting",
        "block_pivoting",
        "chandrasekaran",
        "enumerate",
        "bilinear",
        "interior_point",
        "potential_reduction",
        "newton",
        "pgs",
        "pgs_sm",
        "nncg",
        "apgd",
        "admm",
    ];

    /// The method of that name with its default options.
    ///
    /// # Errors
    /// `UnknownName`.
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "auto" => Ok(Self::Auto),
            "lemke" => Ok(Self::Lemke { settings: lemke::Settings::default(), restarts: DEFAULT_RESTARTS, seed: 0 }),
            "lemke_howson" => Ok(Self::LemkeHowson(lemke_howson::Settings::default())),
            "bilinear" => Ok(Self::Bilinear(bilinear::Settings::default())),
            "block_pivoting" => Ok(Self::BlockPivoting(block_pivoting::Settings::default())),
            "interior_point" => Ok(Self::InteriorPoint(interior_point::Settings::default())),
            "principal_pivoting" => Ok(Self::PrincipalPivoting),
            "chandrasekaran" => Ok(Self::Chandrasekaran),
            "enumerate" => Ok(Self::Enumerate),
            "potential_reduction" => Ok(Self::PotentialReduction(potential_reduction::Settings::default())),
            _ => Approximate::from_name(name).map(Self::Approximate).ok_or_else(|| LcpError::UnknownName {
                name: "method",
                value: name.to_owned(),
                choices: Self::NAMES,
            }),
        }
    }
}

/// What `solve` needs to know beside the problem.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// Bound on the equilibrated residual of a solved problem, in `(0, 1)`.
    pub tol: f64,
    /// A guess: pivoting methods use its support, approximate methods and the interior point method its values.
    pub z0: Option<Vec<f64>>,
    /// Whether the answer is to be proved.
    pub certify: Certify,
}

/// How an answer is certified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Certify {
    /// Recomputed in twice the working precision on the caller's numbers.
    #[default]
    Float,
    /// Proved in rational arithmetic on the caller's binary numbers.
    Exact,
}

impl Certify {
    /// `"float"` or `"exact"`.
    ///
    /// # Errors
    /// `UnknownName`.
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "float" => Ok(Self::Float),
            "exact" => Ok(Self::Exact),
            _ => Err(LcpError::UnknownName { name: "certify", value: name.to_owned(), choices: &["float", "exact"] }),
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self { method: Method::Auto, tol: 1e-9, z0: None, certify: Certify::Float }
    }
}

/// A method that improves a point from iteration to iteration, and its options.
#[derive(Clone, Debug)]
pub enum Approximate {
    /// Projected Gauss-Seidel.
    Pgs(pgs::Settings),
    /// Projected Gauss-Seidel with subspace minimisation.
    PgsSm(pgs_sm::Settings),
    /// Nonsmooth nonlinear conjugate gradients.
    Nncg,
    /// Accelerated projected gradients.
    Apgd,
    /// ADMM.
    Admm(admm::Settings),
    /// Newton's method on the minimum map.
    Newton(newton::Settings),
}

impl Approximate {
    /// The method of that name with its default options.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "pgs" => Some(Self::Pgs(pgs::Settings::default())),
            "pgs_sm" => Some(Self::PgsSm(pgs_sm::Settings::default())),
            "nncg" => Some(Self::Nncg),
            "apgd" => Some(Self::Apgd),
            "admm" => Some(Self::Admm(admm::Settings::default())),
            "newton" => Some(Self::Newton(newton::Settings::default())),
            _ => None,
        }
    }

    /// Its name in results.
    #[must_use]
    pub fn member(&self) -> Member {
        match self {
            Self::Pgs(_) => Member::Pgs,
            Self::PgsSm(_) => Member::PgsSm,
            Self::Nncg => Member::Nncg,
            Self::Apgd => Member::Apgd,
            Self::Admm(_) => Member::Admm,
            Self::Newton(_) => Member::Newton,
        }
    }

    /// Ranges of the options.
    pub(super) fn check(&self) -> Result<()> {
        let within = |name, value: f64, holds: bool, rule| {
            if holds { Ok(()) } else { Err(LcpError::OutOfRange { name, value, rule }) }
        };
        let relaxation = |x: f64| within("relaxation", x, x > 0.0 && x < 2.0, "in (0, 2)");
        let positive = |name, count: usize| within(name, count as f64, count > 0, "at least 1");
        match self {
            Self::Pgs(options) => relaxation(options.relaxation),
            Self::PgsSm(options) => {
                relaxation(options.relaxation)?;
                positive("sweeps", options.sweeps)?;
                positive("solves", options.solves)
            }
            Self::Admm(options) => {
                relaxation(options.relaxation)?;
                within("rho", options.rho, options.rho > 0.0 && options.rho.is_finite(), "positive and finite")
            }
            Self::Newton(options) => positive("patience", options.patience),
            Self::Nncg | Self::Apgd => Ok(()),
        }
    }
}

/// Sizes and ranges of everything beside the problem itself.
pub(super) fn check(lcp: &Lcp, settings: &Settings) -> Result<()> {
    let n = lcp.n();
    check_common(n, settings)?;
    match &settings.method {
        Method::Lemke { settings: lemke::Settings { d: Some(d) }, .. } => {
            check_vector("d", d, n)?;
            match d.iter().position(|&x| x <= 0.0) {
                Some(index) => Err(LcpError::NonPositive { name: "d", index, value: d[index] }),
                None => Ok(()),
            }
        }
        Method::LemkeHowson(options) if options.label >= n && n > 0 => {
            let index = i64::try_from(options.label).unwrap_or(i64::MAX);
            Err(LcpError::BadIndex { name: "label", index, n, repeated: false })
        }
        Method::BlockPivoting(block_pivoting::Settings { alpha: Some(alpha), .. }) => {
            match alpha.iter().find(|&&i| i >= n) {
                Some(&i) => {
                    let index = i64::try_from(i).unwrap_or(i64::MAX);
                    Err(LcpError::BadIndex { name: "alpha", index, n, repeated: false })
                }
                None => Ok(()),
            }
        }
        Method::Enumerate if n > enumerate::MAX_ORDER => {
            Err(LcpError::TooLarge { name: "method=\"enumerate\"", n, limit: enumerate::MAX_ORDER })
        }
        _ => Ok(()),
    }
}

/// What does not depend on whether A is dense.
pub(super) fn check_common(n: usize, settings: &Settings) -> Result<()> {
    if !(settings.tol > 0.0 && settings.tol < 1.0) {
        return Err(LcpError::OutOfRange { name: "tol", value: settings.tol, rule: "in (0, 1)" });
    }
    if let Method::Approximate(method) = &settings.method {
        method.check()?;
    }
    let Some(z0) = &settings.z0 else { return Ok(()) };
    check_vector("z0", z0, n)?;
    match z0.iter().position(|&x| x < 0.0) {
        Some(index) => Err(LcpError::Negative { name: "z0", index, value: z0[index] }),
        None => Ok(()),
    }
}

fn check_vector(name: &'static str, v: &[f64], n: usize) -> Result<()> {
    if v.len() != n {
        return Err(LcpError::WrongLength { name, expected: n, found: v.len() });
    }
    check_finite(name, v)
}
