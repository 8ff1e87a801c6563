//! Block principal pivoting. [JP94], [KP11]
//!
//! Guess `alpha`, solve `A[alpha, alpha] z_alpha = -q_alpha`, and exchange every index whose sign is wrong; when the
//! number of wrong signs stops falling, exchange only the largest such index (Murty's rule [Mur74], finite for P).
//! For a P-matrix it ends at the unique solution, typically after 2 to 8 factorisations, whatever n.

use crate::control::Control;
use crate::linalg::kernels;
use crate::pivoting::basis::Block;
use crate::problem::Lcp;
use crate::solution::Candidate;
use crate::status::Termination;

/// Options of block principal pivoting.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Block exchanges that may fail to reduce the number of wrong signs before Murty's rule takes over.
    pub patience: usize,
    /// First guess of the index set with `z_i > 0`; `None`: by Gauss-Seidel sweeps, or `{i : q_i < 0}`.
    pub alpha: Option<Vec<usize>>,
    /// Whether Murty's rule takes over; otherwise the method gives up there.
    pub murty: bool,
    /// Added to the diagonal of a symmetric A once a block of most indices is singular, 0 for never; for A of entries near 1.
    pub shift: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { patience: 5, alpha: None, murty: true, shift: 0.0 }
    }
}

/// Factorisations allowed when the caller gives no limit.
#[must_use]
pub fn default_limit(n: usize) -> usize {
    30 + n
}

/// Solves LCP(q, A) for a P-matrix A. O(|alpha|^3 + n^2) an iteration.
///
/// For symmetric A the first guess is the support after a few sweeps of the projected Gauss-Seidel method, O(n^2) each:
/// it saves most of the factorisations. Iterations run in plain doubles; the last basis is refined.
#[must_use]
pub fn block_pivoting(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    let mut search = Search::new(lcp, settings);
    let mut block = Block::default();
    let mut alpha = Vec::with_capacity(n);
    let mut iterations = 0;
    let termination = loop {
        if let Some(reason) = control.stop(iterations, default_limit(n)) {
            break reason;
        }
        alpha.clear();
        alpha.extend((0..n).filter(|&i| search.in_alpha[i]));
        if !search.factor(&mut block, &alpha) {
            break Termination::Breakdown("A[alpha, alpha] became singular: A is not a P-matrix");
        }
        iterations += 1;
        if search.point_is_complementary(&mut block) {
            break if search.shift == 0.0 { Termination::ComplementaryBasis } else { Termination::Converged };
        }
        if !search.exchange() {
            break Termination::Breakdown("block exchanges go round in circles");
        }
    };
    let mut z = search.z;
    let mut basis = None;
    if termination == Termination::ComplementaryBasis {
        block.refine(lcp, &mut z);
        basis = Some(alpha);
    }
    Candidate { alpha: basis, ..Candidate::point(z, termination, iterations) }
}

/// The index set, its point, and the memory of how well the exchanges do.
struct Search<'a> {
    lcp: &'a Lcp,
    settings: &'a Settings,
    symmetric: bool,
    in_alpha: Vec<bool>,
    /// What is added to the diagonal: zero until a block was singular.
    shift: f64,
    /// z of the last proximal step, and `q - shift center`.
    center: Vec<f64>,
    q: Vec<f64>,
    z: Vec<f64>,
    w: Vec<f64>,
    wrong: Vec<usize>,
    fewest: usize,
    patience: usize,
}

impl<'a> Search<'a> {
    fn new(lcp: &'a Lcp, settings: &'a Settings) -> Self {
        let n = lcp.n();
        let symmetric = lcp.is_symmetric();
        let (mut z, mut w) = (vec![0.0; n], lcp.q().to_vec());
        let mut in_alpha = vec![false; n];
        match &settings.alpha {
            Some(alpha) => alpha.iter().for_each(|&i| in_alpha[i] = true),
            None => {
                if symmetric && (0..n).all(|i| lcp.row(i)[i] > 0.0) {
                    sweep(lcp, &mut z, &mut w);
                }
                in_alpha.iter_mut().zip(z.iter().zip(&w)).for_each(|(a, (&z, &w))| *a = z > 0.0 || w < 0.0);
            }
        }
        Self {
            lcp,
            settings,
            symmetric,
            in_alpha,
            shift: 0.0,
            center: vec![0.0; n],
            q: lcp.q().to_vec(),
            z,
            w,
            wrong: Vec::with_capacity(n),
            fewest: n + 1,
            patience: settings.patience,
        }
    }

    /// Factors the block. Where A is symmetric and the block is not positive definite, it is shifted if the settings say
    /// so: a singular block of a PSD matrix then becomes one of a P-matrix nearby. Only where most indices are in the set, as in
    /// stacks: with smaller sets the exchanges rarely settle.
    fn factor(&mut self, block: &mut Block, alpha: &[usize]) -> bool {
        if !self.symmetric {
            return block.factor(self.lcp, alpha);
        }
        if block.factor_symmetric(self.lcp, alpha, self.shift) {
            return true;
        }
        let mostly = 4 * alpha.len() > 3 * self.lcp.n();
        if self.settings.shift == 0.0 || self.shift > 0.0 || !mostly {
            // Not P; the caller who asks for this method may mean it all the same.
            return self.settings.murty && block.factor(self.lcp, alpha);
        }
        self.shift = self.settings.shift;
        self.fewest = self.lcp.n() + 1;
        block.factor_symmetric(self.lcp, alpha, self.shift)
    }

    /// Solves for the point of the index set; `true` when no sign is wrong.
    ///
    /// With a shift, proximal steps `(A + shift I) z = -(q - shift z_last)` on the same factors lead from the solution of
    /// the shifted problem to one of the given problem, by the factor `shift / eigenvalue` each.
    fn point_is_complementary(&mut self, block: &mut Block) -> bool {
        for _ in 0..PROXIMAL_STEPS {
            block.point(&self.q, &mut self.z);
            kernels::affine(&self.q, self.lcp.a(), &self.z, &mut self.w);
            wrong_signs(&self.in_alpha, &self.z, &self.w, &mut self.wrong);
            if !self.wrong.is_empty() {
                return false;
            }
            if self.shift == 0.0 {
                return true;
            }
            let step = self.z.iter().zip(&self.center).map(|(z, center)| (z - center).abs()).fold(0.0, f64::max);
            self.center.copy_from_slice(&self.z);
            for ((q, &given), center) in self.q.iter_mut().zip(self.lcp.q()).zip(&self.center) {
                *q = given - self.shift * center;
            }
            if self.shift * step <= SETTLED * kernels::max_abs(&self.z).max(1.0) {
                return true;
            }
        }
        true
    }

    /// Exchanges the indices with wrong signs, or the last of them; `false` when that leads nowhere.
    fn exchange(&mut self) -> bool {
        if self.wrong.len() < self.fewest {
            self.fewest = self.wrong.len();
            self.patience = self.settings.patience;
        } else {
            self.patience = self.patience.saturating_sub(1);
        }
        if self.patience == 0 && !self.settings.murty {
            return false;
        }
        let from = if self.patience > 0 { 0 } else { self.wrong.len().saturating_sub(1) };
        for &i in &self.wrong[from..] {
            self.in_alpha[i] = !self.in_alpha[i];
        }
        true
    }
}

/// Proximal steps at most, the first solve counting as one.
const PROXIMAL_STEPS: usize = 6;
/// The slack that the last proximal step leaves on the support, relative to `max(1, max|z|)`.
const SETTLED: f64 = 1e-15;

/// Sweeps at most for the first guess.
const SWEEPS: usize = 10;

/// Sweeps until hardly any index enters or leaves the support.
fn sweep(lcp: &Lcp, z: &mut [f64], w: &mut [f64]) {
    let few = lcp.n() / 64;
    for _ in 0..SWEEPS {
        if kernels::gauss_seidel_sweep(lcp.a(), z, w) <= few {
            break;
        }
    }
}

/// Indices with `z_i < 0` in alpha or `w_i < 0` outside, beyond rounding.
fn wrong_signs(in_alpha: &[bool], z: &[f64], w: &[f64], wrong: &mut Vec<usize>) {
    let noise = SIGN * kernels::max_abs(z).max(1.0);
    wrong.clear();
    wrong.extend((0..z.len()).filter(|&i| if in_alpha[i] { z[i] < -noise } else { w[i] < -noise }));
}

/// A sign is wrong below `-SIGN max(1, max|z|)`: rounding must not exchange an index for ever.
const SIGN: f64 = 1e-13;

#[cfg(test)]
mod tests {
    use super::*;

    /// A reproducible symmetric positive definite problem with a planted solution.
    #[test]
    fn positive_definite_in_few_factorisations() {
        let n = 40;
        let b: Vec<f64> = (0..n * n).map(|k| ((k * 7919 % 101) as f64) / 50.0 - 1.0).collect();
        let dot = |i: usize, j: usize| (0..n).map(|k| b[i * n + k] * b[j * n + k]).sum::<f64>();
        let a: Vec<f64> = (0..n * n).map(|k| dot(k / n, k % n) + if k / n == k % n { 1.0 } else { 0.0 }).collect();
        let z: Vec<f64> = (0..n).map(|i| ((i * 37 % 11) as f64 - 5.0).max(0.0)).collect();
        let q = (0..n).map(|i| if z[i] > 0.0 { 0.0 } else { 1.0 } - (0..n).map(|j| a[i * n + j] * z[j]).sum::<f64>());
        let lcp = Lcp::new(n, a.clone(), q.collect()).expect("valid");
        let found = block_pivoting(&lcp, &Settings::default(), &Control::default());
        assert_eq!(found.termination, Termination::ComplementaryBasis);
        assert!(found.iterations <= 8, "{}", found.iterations);
        assert!(found.z.iter().zip(&z).all(|(x, y)| (x - y).abs() < 1e-9));
    }

    #[test]
    fn singular_block_is_a_breakdown_or_shifted() {
        let lcp = Lcp::new(2, vec![1.0, 1.0, 1.0, 1.0], vec![-1.0, -1.0]).expect("valid");
        let alpha = Some(vec![0, 1]);
        let settings = Settings { alpha, ..Settings::default() };
        let found = block_pivoting(&lcp, &settings, &Control::default());
        assert!(matches!(found.termination, Termination::Breakdown(_)));
        let found = block_pivoting(&lcp, &Settings { shift: 1e-10, ..settings }, &Control::default());
        assert_eq!((found.termination, found.alpha), (Termination::Converged, None));
        assert!((found.z[0] - 0.5).abs() < 1e-5 && (found.z[0] + found.z[1] - 1.0).abs() < 1e-15);
    }

    #[test]
    fn sweeps_find_the_support_of_a_symmetric_problem() {
        let n = 64;
        let entry = |i: usize, j: usize| if i == j { 4.0 } else { 1.0 / (1 + i.abs_diff(j)) as f64 };
        let a = (0..n * n).map(|k| entry(k / n, k % n)).collect();
        let q = (0..n).map(|i| ((i * 37 % 11) as f64) - 5.0).collect();
        let lcp = Lcp::new(n, a, q).expect("valid");
        let found = block_pivoting(&lcp, &Settings::default(), &Control::default());
        assert_eq!((found.termination, found.iterations), (Termination::ComplementaryBasis, 1));
    }
}
