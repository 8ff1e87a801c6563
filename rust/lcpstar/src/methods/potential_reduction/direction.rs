//! The search direction: a least-squares problem, solved to working precision at degenerate points too.
//!
//! With `p = kappa (z o w)/(z'w) - 1` and `B = W^-1 A Z` the paper's direction is, up to its length,
//! `u = argmin || [I; B] u + [p; p] ||`, `d_z = Z u`, `d_w = W v`, `v = B u`.

use crate::error::{LcpError, Result};
use crate::linalg::backend::{GramCholesky, StackedQr};
use crate::linalg::dd::two_sum;
use crate::linalg::kernels::{axpy, dot_compensated, max_abs};

/// How the least-squares problem is factored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectionSolver {
    /// Cholesky of `I + B'B`; switches to [`Qr`](Self::Qr) when the error estimate says that digits would be lost.
    Cholesky,
    /// QR of `[I; B]`, rows sorted by size, columns pivoted.
    Qr,
}

impl DirectionSolver {
    /// Names accepted by [`DirectionSolver::from_name`].
    pub const NAMES: &'static [&'static str] = &["cholesky", "qr"];

    /// # Errors
    /// `UnknownName`.
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "cholesky" => Ok(Self::Cholesky),
            "qr" => Ok(Self::Qr),
            _ => Err(LcpError::UnknownName { name: "direction", value: name.to_owned(), choices: Self::NAMES }),
        }
    }

    /// The name used in Python.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Cholesky => "cholesky",
            Self::Qr => "qr",
        }
    }
}

/// The direction in the scaled variables, before it is given its length.
#[derive(Clone, Debug)]
pub struct Direction {
    /// `Z^-1 d_z`.
    pub u: Vec<f64>,
    /// `W^-1 d_w`.
    pub v: Vec<f64>,
    /// `p`.
    p: Vec<f64>,
    /// The factorisation that gave it.
    pub solver: DirectionSolver,
}

/// Corrections at most; each gains as many digits as the factorisation has.
const CORRECTIONS: usize = 6;
/// A first Cholesky correction above this fraction of the direction: switch to QR.
const DIGITS_LOST: f64 = 1e-6;
/// Corrections stop below this fraction.
const CONVERGED: f64 = 1e-15;

/// The direction at the strictly positive pair `(z, w)`. O(n^3). `None` when it is not finite.
#[must_use]
pub fn scaled_direction(a: &[f64], z: &[f64], w: &[f64], kappa: f64, solver: DirectionSolver) -> Option<Direction> {
    let n = z.len();
    let mut b = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..n {
            b[i * n + j] = a[i * n + j] * z[j] / w[i];
        }
    }
    let gap: f64 = z.iter().zip(w).map(|(z, w)| z * w).sum();
    let p: Vec<f64> = z.iter().zip(w).map(|(z, w)| kappa * z * w / gap - 1.0).collect();
    let problem = Stacked { n, b: &b, p: &p };
    let found = match solver {
        DirectionSolver::Cholesky => problem.by_cholesky().map(|uv| (uv, DirectionSolver::Cholesky)),
        DirectionSolver::Qr => None,
    };
    let ((u, v), solver) = found.or_else(|| Some((problem.by_qr()?, DirectionSolver::Qr)))?;
    Some(Direction { u, v, p, solver })
}

/// `min || [I; B] u + [p; p] ||`.
struct Stacked<'a> {
    n: usize,
    b: &'a [f64],
    p: &'a [f64],
}

impl Stacked<'_> {
    fn by_cholesky(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let factor = GramCholesky::new(self.n, self.b)?;
        let mut gradient = self.p.to_vec();
        for i in 0..self.n {
            axpy(self.p[i], &self.b[i * self.n..(i + 1) * self.n], &mut gradient);
        }
        let start = factor.solve(&gradient);
        self.corrected(start, |g| factor.solve(g), DIGITS_LOST)
    }

    fn by_qr(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let factor = StackedQr::new(self.n, self.b);
        let stacked: Vec<f64> = self.p.iter().chain(self.p).copied().collect();
        let start = factor.least_squares(&stacked);
        self.corrected(start, |g| factor.solve(g), f64::INFINITY)
    }

    /// Newton corrections of the start (given with its sign reversed) on gradients in twice the working precision; `u`
    /// is carried as `hi + lo`, because the large rows of B cancel in `B u`. The corrections are the error estimate:
    /// `None` when the first exceeds `limit` or the result is not finite.
    fn corrected(
        &self,
        start: Vec<f64>,
        solve: impl Fn(&[f64]) -> Vec<f64>,
        limit: f64,
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut hi: Vec<f64> = start.iter().map(|x| -x).collect();
        let mut lo = vec![0.0; self.n];
        let mut r = self.residual(&hi, &lo);
        let mut last = f64::INFINITY;
        for correction in 0..CORRECTIONS {
            let step = solve(&self.gradient(&hi, &lo, &r));
            for i in 0..self.n {
                let (s, e) = two_sum(hi[i], -step[i]);
                (hi[i], lo[i]) = two_sum(s, e + lo[i]);
            }
            let corrected = self.residual(&hi, &lo);
            let moved = r.iter().zip(&corrected).map(|(r, c)| (r - c).abs()).fold(max_abs(&step), f64::max);
            let size = corrected.iter().zip(self.p).map(|(r, p)| (r - p).abs()).fold(max_abs(&hi), f64::max);
            r = corrected;
            let change = moved / size;
            if change.is_nan() || (correction == 0 && change > limit) {
                return None;
            }
            if change <= CONVERGED || change > 0.5 * last {
                break;
            }
            last = change;
        }
        let v: Vec<f64> = r.iter().zip(self.p).map(|(r, p)| r - p).collect();
        hi.iter().chain(&v).all(|x| x.is_finite()).then_some((hi, v))
    }

    /// `B u + p`.
    fn residual(&self, hi: &[f64], lo: &[f64]) -> Vec<f64> {
        let row = |i: usize| &self.b[i * self.n..(i + 1) * self.n];
        (0..self.n).map(|i| dot_compensated(dot_compensated(self.p[i], row(i), lo).0, row(i), hi).0).collect()
    }

    /// `u + p + B'(B u + p)`, column sums in twice the working precision.
    fn gradient(&self, hi: &[f64], lo: &[f64], r: &[f64]) -> Vec<f64> {
        let mut column = vec![0.0; self.n];
        (0..self.n)
            .map(|j| {
                for (i, c) in column.iter_mut().enumerate() {
                    *c = self.b[i * self.n + j];
                }
                let (start, e) = two_sum(self.p[j], hi[j]);
                dot_compensated(start, &column, r).0 + (e + lo[j])
            })
            .collect()
    }
}

impl Direction {
    /// `|| [u; v] ||_2`.
    #[must_use]
    pub fn norm(&self) -> f64 {
        self.u.iter().chain(&self.v).map(|x| x * x).sum::<f64>().sqrt()
    }

    /// The derivative of the potential along the direction, `p'(u + v)`.
    #[must_use]
    pub fn slope(&self) -> f64 {
        self.p.iter().zip(self.u.iter().zip(&self.v)).map(|(p, (u, v))| p * (u + v)).sum()
    }

    /// The step at which the first of z, w reaches zero.
    #[must_use]
    pub fn to_boundary(&self) -> f64 {
        -1.0 / self.u.iter().chain(&self.v).copied().fold(0.0, f64::min)
    }

    /// `psi` after a step `t` minus `psi` before, from relative changes, so that it is accurate near zero.
    #[must_use]
    pub fn potential_change(&self, z: &[f64], w: &[f64], kappa: f64, t: f64) -> f64 {
        let (mut gap, mut gap_change, mut barrier) = (0.0, 0.0, 0.0);
        for i in 0..z.len() {
            let (u, v, product) = (t * self.u[i], t * self.v[i], z[i] * w[i]);
            gap += product;
            gap_change += product * (u + v + u * v);
            barrier += u.ln_1p() + v.ln_1p();
        }
        kappa * (gap_change / gap).ln_1p() - barrier
    }
}
