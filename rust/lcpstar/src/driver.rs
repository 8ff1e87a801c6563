//! One problem in, one verified solution out: equilibrate, run a method or the portfolio, certify.

mod anytime;
mod approximate;
pub(crate) mod doubt;
mod pieces;
mod polish;
mod portfolio;
mod prove;
mod small;

use crate::control::Control;
use crate::equilibrate::{DENSE_UP_TO, Equilibrated, Rows};
use crate::error::{LcpError, Result};
use crate::judge::{judge, without_tails};
use crate::member::Member;
use crate::methods::{
    bilinear, block_pivoting, chandrasekaran, enumerate, interior_point, lemke, lemke_howson, potential_reduction,
};
use crate::pivoting::basis::basic_point;
use crate::problem::{Lcp, check_finite};
use crate::residual::slack;
use crate::scaling::{Scaling, exponent, times_power_of_two};
use crate::small::TINY_ORDER;
use crate::solution::{Candidate, Solution};
use crate::sparse::SparseLcp;
use crate::status::{Status, Termination};

pub use approximate::Approximate;

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

/// Solves LCP(q, A) and verifies the answer against the caller's numbers.
///
/// # Errors
/// Only for a broken promise of the caller: a wrong length, a number that is not finite, an option out of range.
pub fn solve(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Result<Solution> {
    match solve_briefly(lcp, settings, control) {
        Some(solution) => Ok(solution),
        None => solve_at_length(lcp, settings, control),
    }
}

/// The first step of [`solve`]: the kernel for small problems, microseconds up to order [`BRIEF_UP_TO`]. `None` says nothing
/// about the problem or the settings.
#[must_use]
pub fn solve_briefly(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Option<Solution> {
    small::solve(lcp, settings, control)
}

/// The first step of [`solve`] where a guess is given: what that and a few exchanges solve. `None` says nothing about the problem
/// or the settings.
pub(crate) fn solve_from_guess(lcp: &Lcp, settings: &Settings) -> Option<Solution> {
    small::from_guess(lcp, settings)
}

/// Order up to which [`solve_briefly`] takes microseconds: too short for a lock to be handed over.
pub const BRIEF_UP_TO: usize = 16;

/// What follows in [`solve`].
///
/// # Errors
/// As [`solve`].
pub fn solve_at_length(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Result<Solution> {
    check(lcp, settings)?;
    let problem = Equilibrated::new(lcp);
    let solution = match at_once(&problem, settings) {
        Some(solution) => solution,
        None => {
            let solution = by_method(&problem, settings, control)?;
            polish::polished(&problem, &solution, settings.tol, control).unwrap_or(solution)
        }
    };
    let is_auto = matches!(settings.method, Method::Auto);
    if is_auto && doubt::hides_q(lcp, &solution) {
        return Ok(prove::or_withdrawn(&problem, solution, settings, control));
    }
    if is_auto && doubt::is_undecided(&solution) {
        let decided = prove::prove(&problem, solution.clone(), settings, control);
        let is_answer = matches!(decided.status(), Status::Solved | Status::Infeasible);
        return Ok(if is_answer { decided } else { solution });
    }
    Ok(finished(&problem, solution, settings, control))
}

/// The end of the road: a proof where one is asked for, advice where a method by name gave no answer.
fn finished<P: Rows>(
    problem: &Equilibrated<'_, P>,
    mut solution: Solution,
    settings: &Settings,
    control: &Control<'_>,
) -> Solution {
    solution = without_tails(problem, solution, settings.tol);
    if settings.certify == Certify::Exact {
        solution = prove::prove(problem, solution, settings, control);
    }
    let has_answer = matches!(solution.status(), Status::Solved | Status::Infeasible);
    if !has_answer && !matches!(settings.method, Method::Auto) {
        solution.message.push_str("; method=\"auto\" tries others");
    }
    solution
}

fn by_method(problem: &Equilibrated<'_>, settings: &Settings, control: &Control<'_>) -> Result<Solution> {
    let lcp = problem.original;
    let scaled = &problem.lcp;
    Ok(match &settings.method {
        Method::Auto => anytime::auto(problem, settings, control),
        Method::PrincipalPivoting => portfolio::principal_pivoting(problem, settings.tol, control),
        Method::Chandrasekaran => {
            judge(problem, chandrasekaran::chandrasekaran(scaled, control), Member::Chandrasekaran, settings.tol)
        }
        Method::Enumerate => judge(problem, enumerate::enumerate(scaled, control), Member::Enumerate, settings.tol),
        Method::Lemke { settings: options, restarts, seed } => match &options.d {
            Some(d) => {
                let options = lemke::Settings { d: Some(covering_vector(problem, d)) };
                judge(problem, lemke::lemke::<f64>(scaled, &options, control), Member::Lemke, settings.tol)
            }
            None => portfolio::lemke(problem, *restarts, *seed, settings, control),
        },
        Method::LemkeHowson(options) => {
            judge(problem, lemke_howson::lemke_howson(scaled, options, control), Member::LemkeHowson, settings.tol)
        }
        Method::Bilinear(options) => {
            judge(problem, bilinear::bilinear(scaled, options, control), Member::Bilinear, settings.tol)
        }
        Method::BlockPivoting(options) => {
            let mut options = options.clone();
            options.alpha = options.alpha.or_else(|| settings.z0.as_deref().map(support));
            judge(
                problem,
                block_pivoting::block_pivoting(scaled, &options, control),
                Member::BlockPivoting,
                settings.tol,
            )
        }
        Method::InteriorPoint(options) => {
            let found = interior_point_candidate(problem, settings, options, control);
            let solution = judge(problem, found, Member::InteriorPoint, settings.tol);
            if options.finish { portfolio::finished_by_pivots(problem, solution, settings, control) } else { solution }
        }
        Method::PotentialReduction(options) => {
            let stop = potential_reduction::Stop::Residual(settings.tol);
            let options = potential_reduction::Settings { stop, ..options.clone() };
            let z0 = settings.z0.as_deref().filter(|z0| potential_reduction::is_strictly_feasible(lcp, z0));
            reduce_potential(problem, z0, &options, control, settings.tol, |_| ())?
        }
        Method::Approximate(method) => approximate::solve(problem, settings, method, control),
    })
}

/// Names of the methods that take a sparse A.
pub const SPARSE_METHODS: &[&str] = &["auto", "interior_point", "newton", "pgs", "pgs_sm", "nncg", "apgd", "admm"];

/// Solves a sparse LCP and verifies the answer. Up to order [`TINY_ORDER`] the matrix is made dense and every method of [`solve`] is at
/// hand; above, `"auto"` is the interior point method on `D A D`.
///
/// # Errors
/// `UnknownName` for a method that takes no sparse A of that order; `OutOfRange` for `tol` and options; `WrongLength`, `NotFinite` or
/// `Negative` for `z0`; `TooLarge` for an exact proof beyond [`DENSE_UP_TO`], because it is made on a dense copy.
pub fn solve_sparse(lcp: &SparseLcp, settings: &Settings, control: &Control<'_>) -> Result<Solution> {
    let takes_sparse = matches!(settings.method, Method::Auto | Method::InteriorPoint(_) | Method::Approximate(_));
    if !takes_sparse {
        let value = "one that needs a dense A".to_owned();
        return Err(LcpError::UnknownName { name: "method", value, choices: SPARSE_METHODS });
    }
    if lcp.n() <= TINY_ORDER {
        return solve(&lcp.to_dense(), settings, control);
    }
    check_common(lcp.n(), settings)?;
    if settings.certify == Certify::Exact && lcp.n() > DENSE_UP_TO {
        let name = "certify=\"exact\" with a sparse A, which is proved on a dense copy,";
        return Err(LcpError::TooLarge { name, n: lcp.n(), limit: DENSE_UP_TO });
    }
    let problem = Equilibrated::new(lcp);
    let solution = match (&settings.method, trivial(&problem, settings.tol)) {
        (_, Some(solution)) => solution,
        (Method::Approximate(method), None) => approximate::solve(&problem, settings, method, control),
        (method, None) => {
            let options = if let Method::InteriorPoint(options) = method { options } else { &Default::default() };
            sparse_interior_point(&problem, settings, options, control)
        }
    };
    Ok(finished(&problem, solution, settings, control))
}

/// The interior point method on `D A D`, then Newton's method from its point where single rows of that do not hold.
fn sparse_interior_point(
    problem: &Equilibrated<'_, SparseLcp>,
    settings: &Settings,
    options: &interior_point::Settings,
    control: &Control<'_>,
) -> Solution {
    let target = &problem.scaling;
    let scaling = target.congruent(problem.original.q());
    let z0 = settings.z0.as_deref().map(|z0| scaling.z_from_caller(z0));
    let options =
        interior_point::Settings { tol: congruent_tol(settings.tol, &scaling, target), z0, ..options.clone() };
    let found = interior_point::interior_point_sparse(&problem.original.scaled(&scaling), &options, control);
    let solution = judge(problem, carried(found, &scaling, target), Member::InteriorPoint, settings.tol);
    let solution = without_tails(problem, solution, settings.tol);
    if !polish::is_near(&solution, settings.tol) || control.max_iterations.is_some() {
        return solution;
    }
    let settings = Settings { z0: Some(solution.z.clone()), ..settings.clone() };
    let newton = Approximate::Newton(Default::default());
    let polished = approximate::solve(problem, &settings, &newton, control);
    if polished.is_solved() {
        Solution { method: solution.method, iterations: solution.iterations, ..polished }
    } else {
        solution
    }
}

/// The tolerance on one scaled problem that gives `tol` on another.
fn congruent_tol(tol: f64, scaling: &Scaling, target: &Scaling) -> f64 {
    (tol / scaling.distance(target).max(1.0)).max(f64::EPSILON)
}

/// What was found on the problem scaled one way, on that scaled another way.
fn carried(found: Candidate, from: &Scaling, target: &Scaling) -> Candidate {
    if from == target {
        return found;
    }
    let multipliers = |y: &Vec<f64>| target.multiplier_from_caller(&from.multiplier_to_caller(y));
    let farkas = found.farkas.as_ref().map(multipliers);
    Candidate { z: target.z_from_caller(&from.z_to_caller(&found.z)), farkas, ..found }
}

/// Runs the interior point method on `D A D`, because `D_r A D_c` with `D_r != D_c` need not be monotone when A is.
fn interior_point_candidate(
    problem: &Equilibrated<'_>,
    settings: &Settings,
    options: &interior_point::Settings,
    control: &Control<'_>,
) -> Candidate {
    let target = &problem.scaling;
    let scaling = target.congruent(problem.original.q());
    let z0 = settings.z0.as_deref().map(|z0| scaling.z_from_caller(z0));
    let options =
        interior_point::Settings { tol: congruent_tol(settings.tol, &scaling, target), z0, ..options.clone() };
    if scaling == *target {
        return interior_point::interior_point(&problem.lcp, &options, control);
    }
    let congruent = problem.original.scaled(&scaling);
    carried(interior_point::interior_point(&congruent, &options, control), &scaling, target)
}

/// The paper's potential reduction method with its own stopping rule; `trace` receives each row of its table.
///
/// The tolerance of the verdict follows from the rule: `z'w <= eps` bounds every `min(z_i, w_i)` by `sqrt(eps)`, and
/// that is what "solved" asks of the equilibrated residual (at most `1e-2`).
///
/// # Errors
/// `OutOfRange` for a parameter; `WrongLength`, `NotFinite` or `NotStrictlyFeasible` for `z0`.
pub fn potential_reduction(
    lcp: &Lcp,
    z0: Option<&[f64]>,
    settings: &potential_reduction::Settings,
    control: &Control<'_>,
    trace: impl FnMut(potential_reduction::Record),
) -> Result<Solution> {
    let tol = match settings.stop {
        potential_reduction::Stop::Gap(eps) => eps.sqrt().min(1e-2),
        potential_reduction::Stop::Residual(tol) => tol,
    };
    reduce_potential(&Equilibrated::new(lcp), z0, settings, control, tol, trace)
}

fn reduce_potential(
    problem: &Equilibrated<'_>,
    z0: Option<&[f64]>,
    settings: &potential_reduction::Settings,
    control: &Control<'_>,
    tol: f64,
    trace: impl FnMut(potential_reduction::Record),
) -> Result<Solution> {
    let found = potential_reduction::potential_reduction(problem.original, z0, settings, control, trace)?;
    let stopped = found.termination == Termination::Converged;
    let z = problem.scaling.z_from_caller(&found.z);
    // The stop bounds min(z_i, w_i) by the root of z'w, which is no small part of a row where both vanish at the solution. Where
    // the judge says so, the basis that the point tells of is tried.
    let w = slack(&problem.lcp, &z).0;
    let alpha: Vec<usize> = (0..z.len()).filter(|&i| z[i] >= w[i]).collect();
    let solution = judge(problem, Candidate { z, ..found }, Member::PotentialReduction, tol);
    if !stopped || solution.is_solved() {
        return Ok(solution);
    }
    let Some(z) = basic_point(&problem.lcp, &alpha) else { return Ok(solution) };
    let basic = Candidate::point(z, Termination::ComplementaryBasis, solution.iterations);
    let basic = judge(problem, Candidate { alpha: Some(alpha), ..basic }, Member::PotentialReduction, tol);
    Ok(if basic.is_solved() { basic } else { solution })
}

/// Sizes and ranges of everything beside the problem itself.
fn check(lcp: &Lcp, settings: &Settings) -> Result<()> {
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
fn check_common(n: usize, settings: &Settings) -> Result<()> {
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

/// The answers that cost no pivot.
fn at_once(problem: &Equilibrated<'_>, settings: &Settings) -> Option<Solution> {
    let from_values = matches!(settings.method, Method::Approximate(_));
    trivial(problem, settings.tol).or_else(|| if from_values { None } else { warm(problem, settings) })
}

/// `q >= 0`: z = 0 solves the problem, whatever A is.
fn trivial<P: Rows>(problem: &Equilibrated<'_, P>, tol: f64) -> Option<Solution> {
    problem.original.q().iter().all(|&q| q >= 0.0).then(|| {
        let z = vec![0.0; problem.original.n()];
        let candidate = Candidate { alpha: Some(vec![]), ..Candidate::point(z, Termination::ComplementaryBasis, 0) };
        judge(problem, candidate, Member::Trivial, tol)
    })
}

/// The support of `z0`, then `z0` itself, is tried as it is: right, it costs one factorisation and no pivot.
fn warm(problem: &Equilibrated<'_>, settings: &Settings) -> Option<Solution> {
    let z0 = settings.z0.as_deref()?;
    let alpha = support(z0);
    let basic = basic_point(&problem.lcp, &alpha).map(|z| (z, Some(alpha)));
    let given = Some((problem.scaling.z_from_caller(z0), None));
    [basic, given].into_iter().flatten().find_map(|(z, alpha)| {
        let candidate = Candidate { alpha, ..Candidate::point(z, Termination::ComplementaryBasis, 0) };
        let solution = judge(problem, candidate, Member::WarmStart, settings.tol);
        (solution.is_solved() && !doubt::misses_q(problem.original, &solution)).then_some(solution)
    })
}

/// The caller's covering vector on the equilibrated problem, scaled to a maximum near 1: a common factor only changes
/// the unit of `z_0`, which should be that of everything else.
fn covering_vector(problem: &Equilibrated<'_>, d: &[f64]) -> Vec<f64> {
    let scaled = |d: &f64, shift: i32| times_power_of_two(*d, shift);
    let shift = |d: &f64, r: &i32| exponent(*d) + r;
    let largest = d.iter().zip(&problem.scaling.rows).map(|(d, r)| shift(d, r)).max().unwrap_or(0);
    d.iter().zip(&problem.scaling.rows).map(|(d, r)| scaled(d, r - largest).max(f64::MIN_POSITIVE)).collect()
}

/// The same limits, and at most `limit` iterations.
fn with_limit<'a>(control: &Control<'a>, limit: usize) -> Control<'a> {
    control.with_max_iterations(Some(control.max_iterations.map_or(limit, |own| own.min(limit))))
}

/// Indices of the positive entries.
fn support(z: &[f64]) -> Vec<usize> {
    (0..z.len()).filter(|&i| z[i] > 0.0).collect()
}
