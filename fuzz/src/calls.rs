//! The public entry points, with fuzzed options.

use crate::input::{Bytes, Problem, Taste, problem, tamed};
use crate::options::{guess, method, potential, tolerance};
use crate::oracle::{self, Limits};
use crate::show::show;
use lcpstar::batch::{Alpha, Guess, Numbers, Output, Problems, Source, solve_batch};
use lcpstar::driver::{self, Certify, Method, Settings};
use lcpstar::{Certificate, Control, Lcp, LcpError, SparseLcp, Status};
use lcpstar_referee::Answer;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Exponential calls get this long; libFuzzer's own `-timeout` judges whether they keep it.
pub const LIMIT: Duration = Duration::from_secs(1);

fn lcp(problem: &Problem) -> Lcp {
    show(problem);
    Lcp::new(problem.n, problem.a.clone(), problem.q.clone()).expect("the input is finite")
}

/// `driver::solve` with every method and option.
pub fn solve(bytes: &mut Bytes<'_>) {
    let settings_first = bytes.byte();
    let problem = problem(bytes, 40);
    let n = problem.n;
    let settings = Settings {
        method: method(bytes, n),
        tol: tolerance(bytes),
        z0: guess(bytes, n),
        certify: if n <= 12 && settings_first & 3 == 3 { Certify::Exact } else { Certify::Float },
    };
    let max_iterations = (settings_first & 12 == 12).then(|| bytes.below(64));
    let patience = (settings_first & 48 == 48).then(|| bytes.below(40));
    let asked = AtomicUsize::new(0);
    let interrupt = || patience.is_some_and(|patience| asked.fetch_add(1, Relaxed) >= patience);
    let expired = settings_first & 192 == 192;
    let long = Instant::now() + 5 * LIMIT;
    let deadline = Some(if expired { Instant::now() } else { long });
    let control = Control { max_iterations, deadline, interrupted: Some(&interrupt) };
    let lcp = lcp(&problem);
    show(&(&settings, max_iterations, patience, expired));
    match driver::solve(&lcp, &settings, &control) {
        Ok(solution) => {
            show(&solution);
            let limits = Limits {
                max_iterations,
                may_run_out_of_time: expired || patience.is_some() || Instant::now() >= long,
                exact: settings.certify == Certify::Exact,
            };
            oracle::check(&problem, &solution, settings.tol, &limits);
        }
        Err(error) => justified(&error, n, &settings),
    }
}

/// An error must name something that was really wrong.
fn justified(error: &LcpError, n: usize, settings: &Settings) {
    let bad = |v: &Option<Vec<f64>>| {
        v.as_ref().is_some_and(|v| v.len() != n || v.iter().any(|x| !(*x >= 0.0 && x.is_finite())))
    };
    let right = match error {
        LcpError::OutOfRange { name: "tol", value, .. } => !(*value > 0.0 && *value < 1.0),
        LcpError::OutOfRange { value, .. } => match &settings.method {
            Method::PotentialReduction(options) => options.validate().is_err(),
            Method::Approximate(_) => !(*value > 0.0 && *value < 2.0),
            _ => false,
        },
        LcpError::WrongLength { name: "z0", .. }
        | LcpError::NotFinite { name: "z0", .. }
        | LcpError::Negative { name: "z0", .. } => bad(&settings.z0),
        LcpError::WrongLength { name: "d", .. }
        | LcpError::NotFinite { name: "d", .. }
        | LcpError::NonPositive { name: "d", .. } => true,
        LcpError::BadIndex { name: "label" | "alpha", index, .. } => *index >= n as i64,
        LcpError::TooLarge { n: order, limit, .. } => *order == n && n > *limit,
        LcpError::NotStrictlyFeasible { .. } => matches!(settings.method, Method::PotentialReduction(_)),
        _ => false,
    };
    assert!(right && !error.to_string().is_empty(), "unjustified: {error} at n = {n} with {settings:?}");
}

/// The same small problem by three methods with exact certificates: proofs must not contradict each other. The paper's
/// method runs on it, too.
pub fn prove(bytes: &mut Bytes<'_>) {
    let problem = problem(bytes, 6);
    let lcp = lcp(&problem);
    let limits = Limits { max_iterations: None, may_run_out_of_time: true, exact: true };
    let (mut solved, mut infeasible) = (false, false);
    for name in ["auto", "principal_pivoting", "enumerate"] {
        let control = Control { deadline: Some(Instant::now() + LIMIT), ..Control::default() };
        let settings = Settings {
            method: Method::from_name(name).expect("a listed name"),
            certify: Certify::Exact,
            ..Settings::default()
        };
        let solution = driver::solve(&lcp, &settings, &control).expect("nothing is wrong with the call");
        show(&(name, &solution));
        oracle::check(&problem, &solution, settings.tol, &limits);
        match solution.certificate() {
            Some(Certificate::Solution { exact: Some(_), .. }) => solved = true,
            Some(Certificate::Infeasible { .. }) => infeasible = true,
            _ => {}
        }
    }
    assert!(!(solved && infeasible), "one method proved a solution, another that there is none");
    let settings = potential(bytes);
    let z0 = guess(bytes, problem.n);
    let control = Control { max_iterations: Some(bytes.below(100)), ..Control::default() };
    show(&(&settings, &z0, control.max_iterations));
    let mut rows = 0;
    let run = driver::potential_reduction(&lcp, z0.as_deref(), &settings, &control, |record| {
        rows += 1;
        assert_eq!((record.z.len(), record.dz.len()), (problem.n, problem.n));
    });
    if let Ok(solution) = run {
        let limits = Limits { max_iterations: control.max_iterations, may_run_out_of_time: false, exact: false };
        oracle::check(&problem, &solution, 1e-2, &limits);
        assert!(rows <= solution.iterations());
    }
}

/// `solve_batch`: one thread against three, whole against one by one.
pub fn batch(bytes: &mut Bytes<'_>) {
    let first = problem(bytes, 24);
    let n = first.n;
    let count = bytes.below(20);
    let tol = tolerance(bytes);
    let (mut a, mut q) = (Vec::new(), Vec::new());
    for _ in 0..count {
        a.extend_from_slice(&first.a);
        q.extend_from_slice(&first.q);
        let changes = bytes.below(4);
        for _ in 0..changes {
            let (place, x) = (bytes.below(n * n + n + 1), tamed(bytes.number(Taste::Wild)));
            let (in_a, in_q) = (a.len() - n * n, q.len() - n);
            match place.checked_sub(n * n) {
                None => a[in_a + place] = x,
                Some(i) if i < n => q[in_q + i] = x,
                Some(_) => {}
            }
        }
    }
    if bytes.byte() == 255 && !q.is_empty() {
        q[0] = bytes.raw();
    }
    let masks: Vec<u64> = (0..count).map(|_| u64::from(bytes.byte()) * 0x0101_0101_0101_0101).collect();
    let points: Vec<f64> = (0..count * n).map(|k| f64::from((masks[k / n] >> (k % n) & 1) as u8)).collect();
    let flags: Vec<bool> = points.iter().map(|x| *x > 0.0).collect();
    let guess = match bytes.below(6) {
        0 => Guess::Masks(&masks),
        1 => Guess::Points(&points),
        2 => Guess::Flags(&flags),
        _ => Guess::None,
    };
    let method = if bytes.below(4) == 3 { method(bytes, n) } else { Method::Auto };
    let one_matrix = bytes.below(4) == 3 && count > 0;
    let reversed: Vec<usize> = (0..count).rev().collect();
    let one = |threads: usize, order: Option<&[usize]>, guess: Guess<'_>| {
        let place = |map| Source::Mapped(map);
        let problems = Problems {
            n,
            count,
            a: Numbers::Double(&a),
            a_source: if one_matrix { Source::One } else { order.map_or(Source::Each, place) },
            q: Numbers::Double(&q),
            q_source: order.map_or(Source::Each, place),
        };
        run_batch(&problems, &method, tol, threads, guess)
    };
    show(&(n, count, &a, &q, &method, tol, guess, one_matrix));
    let whole = one(1, None, guess);
    let others = one(3, None, guess);
    let same = match (&whole, &others) {
        (Ok(one), Ok(three)) => one.bits() == three.bits(),
        (Err(one), Err(three)) => one.to_string() == three.to_string(),
        _ => false,
    };
    assert!(same, "threads change the answer");
    let Ok(whole) = whole else { return };
    for k in 0..count {
        let matrix = if one_matrix { 0 } else { k };
        let problem =
            Problem { n, a: a[matrix * n * n..(matrix + 1) * n * n].to_vec(), q: q[k * n..(k + 1) * n].to_vec() };
        let status = Status::ALL[usize::from(whole.status[k])];
        // Certificates are no part of a batch: only a point can be scored.
        let is_point = !matches!(status, Status::Infeasible | Status::NearlyInfeasible);
        let answer = Answer {
            status: if is_point { status } else { Status::NumericalBreakdown },
            z: whole.z[k * n..(k + 1) * n].to_vec(),
            w: whole.w[k * n..(k + 1) * n].to_vec(),
            residual: whole.residual[k],
            natural_residual: whole.natural[k],
            certificate: None,
        };
        oracle::score(&problem, &answer, tol);
    }
    if matches!(guess, Guess::None)
        && let Ok(backwards) = one(1, Some(&reversed), guess)
    {
        for k in 0..count {
            let l = count - 1 - k;
            let same = whole.z[k * n..(k + 1) * n].iter().zip(&backwards.z[l * n..(l + 1) * n]).all(|(x, y)| x == y);
            assert!(same && whole.status[k] == backwards.status[l], "the order changes problem {k}");
        }
    }
}

#[derive(Clone)]
struct Batch {
    z: Vec<f64>,
    w: Vec<f64>,
    status: Vec<u8>,
    iterations: Vec<u32>,
    residual: Vec<f64>,
    natural: Vec<f64>,
}

impl Batch {
    fn bits(&self) -> (Vec<u64>, Vec<u8>, Vec<u32>) {
        (self.z.iter().chain(&self.w).map(|x| x.to_bits()).collect(), self.status.clone(), self.iterations.clone())
    }
}

fn run_batch(
    problems: &Problems<'_>,
    method: &Method,
    tol: f64,
    threads: usize,
    guess: Guess<'_>,
) -> Result<Batch, LcpError> {
    let (n, count) = (problems.n, problems.count);
    let mut out = Batch {
        z: vec![0.0; n * count],
        w: vec![0.0; n * count],
        status: vec![0; count],
        iterations: vec![0; count],
        residual: vec![0.0; count],
        natural: vec![0.0; count],
    };
    let (mut codes, mut alpha) = (vec![0; count], vec![0; count]);
    let finished = solve_batch(
        problems,
        &lcpstar::batch::Settings { method, tol, threads, guess, interrupted: None },
        Output {
            z: &mut out.z,
            w: &mut out.w,
            status: &mut out.status,
            method: &mut codes,
            iterations: &mut out.iterations,
            residual: &mut out.residual,
            natural_residual: &mut out.natural,
            alpha: Alpha::Masks(&mut alpha),
        },
    )?;
    assert!(finished, "nobody interrupted");
    Ok(out)
}

/// Sparse problems, and what `SparseLcp::new` must refuse.
pub fn sparse(bytes: &mut Bytes<'_>) {
    let problem = problem(bytes, 30);
    let n = problem.n;
    let (mut starts, mut columns, mut values) = (vec![0], vec![], vec![]);
    for i in 0..n {
        for j in 0..n {
            if problem.a[i * n + j] != 0.0 {
                columns.push(j);
                values.push(problem.a[i * n + j]);
            }
        }
        starts.push(columns.len());
    }
    let damaged = bytes.below(8) == 7;
    if damaged {
        let (place, x) = (bytes.below(64), bytes.below(64));
        match bytes.below(4) {
            0 if !starts.is_empty() => starts[place % (n + 1)] = x,
            1 if !columns.is_empty() => {
                let k = place % columns.len();
                columns[k] = x;
            }
            2 => columns.push(x),
            _ => starts.push(x),
        }
    }
    let lcp = match SparseLcp::new(starts, columns, values, problem.q.clone()) {
        Ok(lcp) => lcp,
        Err(error) => {
            assert!(damaged, "{error}");
            return;
        }
    };
    let dense = lcp.to_dense();
    let problem = Problem { n, a: dense.a().to_vec(), q: dense.q().to_vec() };
    let tol = tolerance(bytes);
    let certify = if n <= 8 && bytes.below(4) == 3 { Certify::Exact } else { Certify::Float };
    let settings = Settings { method: method(bytes, n), tol, z0: guess(bytes, n), certify };
    let control = Control { max_iterations: bytes.flag().then(|| bytes.below(40)), ..Control::default() };
    show(&(&problem, &settings, control.max_iterations));
    if let Ok(solution) = driver::solve_sparse(&lcp, &settings, &control) {
        let counted = control.max_iterations.filter(|_| certify == Certify::Float);
        assert!(counted.is_none_or(|limit| solution.iterations() <= limit), "max_iterations");
        oracle::score(&problem, &Answer::from(solution), tol);
    }
}

/// `solutions`: every vertex and ray exactly, and no contradiction to a solver with a proof.
pub fn solution_set(bytes: &mut Bytes<'_>) {
    let problem = problem(bytes, 6);
    let lcp = lcp(&problem);
    let control = Control { deadline: Some(Instant::now() + LIMIT), ..Control::default() };
    let Ok(faces) = lcpstar::solutions::solutions(&lcp, &control).expect("n is small") else { return };
    for face in &faces {
        assert!(!face.vertices.is_empty(), "a face without a vertex");
        assert!(face.vertices.iter().all(|v| oracle::solves_exactly(&problem, v)), "a vertex does not solve");
        assert!(face.rays.iter().all(|r| oracle::is_direction(&problem, r)), "a ray leaves the solution set");
    }
    let settings = Settings { certify: Certify::Exact, ..Settings::default() };
    let solution = driver::solve(&lcp, &settings, &control).expect("nothing is wrong with the call");
    match solution.certificate() {
        Some(Certificate::Solution { exact: Some(_), .. }) => {
            assert!(!faces.is_empty(), "a proved solution is missing")
        }
        Some(Certificate::Infeasible { .. }) => assert!(faces.is_empty(), "infeasible, with solutions"),
        _ => {}
    }
}

/// `ppt`: `w_alpha` and `z_alpha` trade places, checked by `[w_a; z_b] -> [z_a; w_b]` on the columns of the transform.
pub fn transform(bytes: &mut Bytes<'_>) {
    let problem = problem(bytes, 8);
    let n = problem.n;
    let alpha: Vec<usize> = (0..bytes.below(n + 1)).map(|_| bytes.below(n.max(1))).collect();
    let mut distinct = alpha.clone();
    distinct.sort_unstable();
    distinct.dedup();
    if distinct.len() != alpha.len() {
        return; // the bindings refuse it
    }
    match lcpstar::pivoting::transform::principal_pivot_transform(&lcp(&problem), &alpha, &Control::default()) {
        Ok(None) => panic!("nobody stopped it"),
        Ok(Some(m)) => assert!(!m.a().iter().chain(m.q()).any(|x| x.is_nan()), "NaN in a transform"),
        Err(LcpError::SingularBlock { rank, .. }) => assert!(rank < alpha.len()),
        Err(LcpError::NotFinite { name: "M" | "p", .. }) => {}
        Err(error) => panic!("{error}"),
    }
}
