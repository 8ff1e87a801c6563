//! Phase one: a strictly feasible start, `z > 0` and `A z + q > 0`, or the news that none was found.

use crate::control::Control;
use crate::equilibrate::Equilibrated;
use crate::linalg::backend::{GramCholesky, StackedQr};
use crate::linalg::kernels::{axpy, dot};
use crate::problem::Lcp;
use crate::residual::slack;
use crate::solution::Candidate;
use crate::status::Termination;

/// Newton steps at most.
const MAX_STEPS: usize = 200;
/// Slack asked for, in units of the equilibrated problem, where `max|q|` is about 1.
const ENOUGH: f64 = 0.5;
/// The search is over when this many steps ...
const WINDOW: usize = 12;
/// ... bring the violation down by less than this fraction of its distance to -1.
const PROGRESS: f64 = 1e-4;

/// Reduces `2 n log(t + 1) - sum log z_i - sum log w_i` over `z > 0`, `w = A z + q + t e > 0` on the equilibrated
/// problem until `t <= -1/2`, or until `t < 0` and `t` stops falling. O(n^3) a step.
///
/// # Errors
/// The last point, when `t >= 0` stops falling: then no `z > 0` with `A z + q > 0` was found, and for exact
/// arithmetic none exists (the problem in (z, t) is convex).
pub fn strictly_feasible(lcp: &Lcp, control: &Control<'_>) -> Result<Vec<f64>, Box<Candidate>> {
    let problem = Equilibrated::new(lcp);
    let mut search = Search::new(&problem.lcp);
    let mut window_start = f64::INFINITY;
    let mut reason = Termination::Breakdown(
        "phase one found no strictly feasible point (z > 0 and A z + q > 0), which the method needs; \
         interior_point and lemke need none",
    );
    for step in 0..MAX_STEPS {
        if let Some(stop) = control.expired() {
            reason = stop;
            break;
        }
        if search.t <= -ENOUGH {
            break;
        }
        if step % WINDOW == 0 {
            if window_start - search.t < PROGRESS * (search.t + 1.0) {
                break;
            }
            window_start = search.t;
        }
        if search.newton_step().is_none() {
            break;
        }
    }
    let z = problem.scaling.z_to_caller(&search.z);
    let strict = z.iter().chain(&slack(lcp, &z).0).all(|&x| x > 0.0 && x.is_finite());
    if strict { Ok(z) } else { Err(Box::new(Candidate::point(z, reason, 0))) }
}

struct Search<'a> {
    lcp: &'a Lcp,
    z: Vec<f64>,
    w: Vec<f64>,
    t: f64,
}

impl<'a> Search<'a> {
    fn new(lcp: &'a Lcp) -> Self {
        let z = vec![1.0; lcp.n()];
        let w = slack(lcp, &z).0;
        let t = w.iter().fold(0.0, |t: f64, &w| t.max(1.0 - w));
        let w = w.iter().map(|w| w + t).collect();
        Self { lcp, z, w, t }
    }

    /// One damped Newton step on the potential; `None` when it cannot be computed.
    fn newton_step(&mut self) -> Option<()> {
        let n = self.z.len();
        let mut b = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                b[i * n + j] = self.lcp.a()[i * n + j] * self.z[j] / self.w[i];
            }
        }
        let c: Vec<f64> = self.w.iter().map(|w| 1.0 / w).collect();
        let solve = solver(n, &b);
        let transposed_times = |x: &[f64], mut y: Vec<f64>| {
            for i in 0..n {
                axpy(x[i], &b[i * n..(i + 1) * n], &mut y);
            }
            y
        };
        // [I + B'B, B'c; c'B, c'c] [u; dt] = [1 + B'1; c'1 - 2n/(t + 1)]
        let coupling = transposed_times(&c, vec![0.0; n]);
        let (x, y) = (solve(&transposed_times(&vec![1.0; n], vec![1.0; n])), solve(&coupling));
        let schur = dot(&c, &c) - dot(&coupling, &y);
        let theta = 4.0 * n as f64 / (self.t + 1.0);
        let dt = (c.iter().sum::<f64>() - theta - dot(&coupling, &x)) / schur;
        let u: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x - dt * y).collect();
        let v: Vec<f64> = (0..n).map(|i| dot(&b[i * n..(i + 1) * n], &u) + dt * c[i]).collect();
        let fastest = u.iter().chain(&v).map(|x| -x).chain([-dt / (self.t + 1.0)]).fold(0.0, f64::max);
        let step = (0.9 / fastest).min(1.0);
        if !(step * dt).is_finite() || u.iter().any(|x| !x.is_finite()) {
            return None;
        }
        for i in 0..n {
            self.z[i] *= 1.0 + step * u[i];
        }
        self.t += step * dt;
        let w = slack(self.lcp, &self.z).0;
        let lowest = w.iter().fold(f64::INFINITY, |m, &w| m.min(w));
        if lowest + self.t <= 0.0 {
            self.t = 1e-12 - lowest; // rounding took w to the boundary
        }
        self.w = w.iter().map(|w| w + self.t).collect();
        Some(())
    }
}

type LinearMap = Box<dyn Fn(&[f64]) -> Vec<f64>>;

/// `g -> (I + B'B)^-1 g`.
fn solver(n: usize, b: &[f64]) -> LinearMap {
    match GramCholesky::new(n, b) {
        Some(factor) => Box::new(move |g| factor.solve(g)),
        None => {
            let factor = StackedQr::new(n, b);
            Box::new(move |g| factor.solve(g))
        }
    }
}
