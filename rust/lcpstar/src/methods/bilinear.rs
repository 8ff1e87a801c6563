//! Any matrix: the LCP as a concave programme, minimised by successive linear programmes. [Man95]
//!
//! `sum_i v_i min(z_i, w_i)` with weights `v > 0` is concave, nonnegative on FEA(q, A), and zero exactly at the solutions. From a
//! choice of one member of each pair, minimise the weighted sum of the chosen ones over FEA by the simplex method, choose
//! the smaller member of each pair at that vertex, and repeat while the sum falls. It ends at a vertex after finitely
//! many steps; when that is no solution, other weights and another first choice are drawn. No class of matrices is
//! needed and none guarantees success: it is the portfolio's answer to problems on which every path ends on a ray.

use crate::control::Control;
use crate::pivoting::{Dictionary, Entering, Var, basis};
use crate::problem::Lcp;
use crate::residual::{equilibrated_residual, slack};
use crate::solution::Candidate;
use crate::status::Termination;

/// Options of the bilinear method.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Random starts after the first, which has weights 1 and chooses every `w_i`.
    pub starts: usize,
    /// Seed of the starts.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { starts: 100, seed: 0 }
    }
}

/// Pivots allowed when the caller gives no limit.
#[must_use]
pub fn default_limit(n: usize) -> usize {
    2000 + 500 * n
}

/// A point ends the search when its residual is below this; `certify` decides later.
const COMPLEMENTARY: f64 = 1e-9;
/// Added to q at random: no ties, so no tiny pivots among ties. The basis found is solved again with the true q.
const PERTURBATION: f64 = 1e-7;
/// Complementary to perturbation level.
const NEAR: f64 = 100.0 * PERTURBATION;
/// A linear programme is optimal when no reduced cost is below minus this.
const TOL_COST: f64 = 1e-9;

/// Searches the vertices of FEA(q, A) for a solution. O(n^2) a pivot.
#[must_use]
pub fn bilinear(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    let mut random = fastrand::Rng::with_seed(settings.seed);
    let q = lcp.q().iter().map(|q| q + PERTURBATION * (0.5 + random.f64())).collect();
    let perturbed = lcp.with_q(q);
    let mut search = Search { original: lcp, lcp: &perturbed, control, pivots: 0, best: (f64::INFINITY, vec![0.0; n]) };
    let mut termination = Termination::Breakdown("no start led to a complementary vertex");
    for start in 0..=settings.starts {
        let weights: Vec<f64> = (0..n).map(|_| if start == 0 { 1.0 } else { 0.5 + random.f64() }).collect();
        let chosen: Vec<bool> = (0..n).map(|_| start > 0 && random.bool()).collect();
        match search.descend(&weights, chosen) {
            Ok(Some((alpha, z))) => {
                let point = Candidate::point(z, Termination::ComplementaryBasis, search.pivots);
                return Candidate { alpha: Some(alpha), ..point };
            }
            Ok(None) => {}
            Err(reason) => {
                termination = reason;
                break;
            }
        }
    }
    Candidate::point(search.best.1, termination, search.pivots)
}

/// Support and point.
type Solved = (Vec<usize>, Vec<f64>);

struct Search<'a> {
    original: &'a Lcp,
    /// With the perturbed q.
    lcp: &'a Lcp,
    control: &'a Control<'a>,
    pivots: usize,
    /// Smallest `max min(z_i, w_i)` so far, and its `z`.
    best: (f64, Vec<f64>),
}

impl Search<'_> {
    /// Linear programmes from one start; the support of a solution and its point, or `None` at a local minimum.
    fn descend(&mut self, weights: &[f64], mut chosen: Vec<bool>) -> Result<Option<Solved>, Termination> {
        let n = self.lcp.n();
        let mut dictionary = Dictionary::<f64>::new(self.lcp, &vec![1.0; n]);
        self.make_feasible(&mut dictionary)?;
        let mut last = f64::INFINITY;
        loop {
            self.minimise(&mut dictionary, |var| match var {
                Var::Z(i) if chosen[i] => weights[i],
                Var::W(i) if !chosen[i] => weights[i],
                _ => 0.0,
            })?;
            let (z, w) = (dictionary.point().0, dictionary.slacks());
            let gap = z.iter().zip(&w).map(|(z, w)| z.min(*w)).fold(0.0, f64::max);
            if gap < self.best.0 {
                self.best = (gap, z.clone());
            }
            if gap <= NEAR {
                let solved = self.solution_near(&z, &w);
                if solved.is_some() {
                    return Ok(solved);
                }
            }
            let sum: f64 = (0..n).map(|i| weights[i] * z[i].min(w[i])).sum();
            // Rounding may make the sum negative.
            let falls = last == f64::INFINITY || sum < last - 1e-12 * last.abs();
            if !falls {
                return Ok(None);
            }
            last = sum;
            chosen = (0..n).map(|i| z[i] < w[i]).collect();
        }
    }

    /// A basic point of the true problem near a vertex of the perturbed one that is complementary to perturbation level:
    /// the larger member of each pair is basic, or, where both are of the size of the perturbation, `w_i` is. A singular
    /// block is completed by the other rows that are tight.
    fn solution_near(&self, z: &[f64], w: &[f64]) -> Option<Solved> {
        let solves = |z: &Vec<f64>| equilibrated_residual(z, &slack(self.original, z).0) <= COMPLEMENTARY;
        let tight: Vec<usize> = (0..z.len()).filter(|&i| w[i] <= NEAR).collect();
        [0.0, NEAR].into_iter().find_map(|threshold| {
            let alpha: Vec<usize> = (0..z.len()).filter(|&i| z[i] > w[i].max(threshold)).collect();
            let basic = basis::basic_point(self.original, &alpha).filter(solves);
            let point = basic.or_else(|| basis::tight_point(self.original, &alpha, &tight).filter(solves))?;
            Some((alpha, point))
        })
    }

    /// Phase one: `z_0` enters as in Lemke's method and is minimised until it leaves.
    fn make_feasible(&mut self, dictionary: &mut Dictionary<f64>) -> Result<(), Termination> {
        if self.lcp.q().iter().all(|&q| q >= 0.0) {
            return Ok(());
        }
        let s = self.lcp.n();
        if let Some(r) = dictionary.blocking_row(s, Entering::Descending) {
            dictionary.exchange(r, s);
        }
        self.minimise(dictionary, |var| if var == Var::Z0 { 1.0 } else { 0.0 })?;
        match dictionary.column_of(Var::Z0) {
            Some(_) => Ok(()),
            None => Err(Termination::Breakdown("phase one found no z >= 0 with A z + q >= 0")),
        }
    }

    /// The primal simplex method: the most negative reduced cost enters, the lexicographic ratio test decides who leaves.
    fn minimise(&mut self, dictionary: &mut Dictionary<f64>, cost: impl Fn(Var) -> f64) -> Result<(), Termination> {
        let n = self.lcp.n();
        let mut reduced = vec![0.0; n + 1];
        loop {
            if let Some(reason) = self.control.stop(self.pivots, default_limit(n)) {
                return Err(reason);
            }
            dictionary.reduced_costs(&cost, &mut reduced);
            let entering = (0..=n).filter(|&s| dictionary.nonbasic(s) != Var::Z0);
            let Some(s) = entering.min_by(|&s, &t| reduced[s].total_cmp(&reduced[t])) else { return Ok(()) };
            if reduced[s] >= -TOL_COST {
                return Ok(());
            }
            let Some(r) = dictionary.blocking_row(s, Entering::Increasing) else {
                return Err(Termination::Breakdown("a linear programme with nonnegative costs came out unbounded"));
            };
            dictionary.exchange(r, s);
            self.pivots += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::natural_residual;

    /// Every d > 0 ends on a ray here: a bimatrix game.
    #[test]
    fn solves_where_lemke_ends_on_a_ray() {
        let a = vec![0.0, 0.0, 10.0, 20.0, 0.0, 0.0, 30.0, 15.0, 10.0, 20.0, 0.0, 0.0, 30.0, 15.0, 0.0, 0.0];
        let lcp = Lcp::new(4, a, vec![-1.0; 4]).expect("valid");
        let found = bilinear(&lcp, &Settings::default(), &Control::default());
        assert_eq!(found.termination, Termination::ComplementaryBasis);
        let (w, _) = slack(&lcp, &found.z);
        assert!(natural_residual(&found.z, &w) < 1e-14);
    }

    #[test]
    fn infeasible_is_not_solved() {
        let lcp = Lcp::new(1, vec![-1.0], vec![-1.0]).expect("valid");
        let found = bilinear(&lcp, &Settings::default(), &Control::default());
        assert!(matches!(found.termination, Termination::Breakdown(_)));
    }
}
