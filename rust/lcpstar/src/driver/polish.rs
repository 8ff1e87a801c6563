//! A point whose residual is near rounding while some row does not hold to its own numbers: an entry of the solution that
//! decays to nothing beside the others, and was cut off there. Sweeps find the entries that are missing, however small.

use crate::control::Control;
use crate::equilibrate::Equilibrated;
use crate::iterative::{Dense, Sweep};
use crate::judge::judge;
use crate::pivoting::basis::basic_point;
use crate::residual::slack;
use crate::solution::{Candidate, Solution};
use crate::status::{Status, Termination};

/// Sweeps at most, each followed by a solve: one or two carry a tail to its end.
const ROUNDS: usize = 4;

/// The solution next to `solution` in which every row holds, if a few sweeps, each with a solve on the support it leaves,
/// find one; `certify` judges it as any other point. O(n^3) a round.
pub(super) fn polished(
    problem: &Equilibrated<'_>,
    solution: &Solution,
    tol: f64,
    control: &Control<'_>,
) -> Option<Solution> {
    if !is_near(solution, tol) {
        return None;
    }
    let lcp = &problem.lcp;
    let matrix = Dense::new(lcp);
    let sweep = Sweep::new(&matrix, 1.0);
    let mut z = problem.scaling.z_from_caller(&solution.z);
    for round in 0..ROUNDS {
        let (before, mut w) = (z.clone(), slack(lcp, &z).0);
        sweep.run(&matrix, &mut z, &mut w, round % 2 == 1);
        if z == before || control.expired().is_some() {
            return None;
        }
        let alpha: Vec<usize> = (0..z.len()).filter(|&i| z[i] > 0.0).collect();
        z = basic_point(lcp, &alpha)?;
        z.iter_mut().for_each(|z| *z = z.max(0.0));
        let found = Candidate::point(z.clone(), Termination::ComplementaryBasis, solution.iterations);
        let found = judge(problem, Candidate { alpha: Some(alpha), ..found }, solution.method, tol);
        if found.status() == Status::Solved {
            return Some(found);
        }
    }
    None
}

/// A residual that a direct solve leaves, and no unfinished iteration.
const NEAR: f64 = 1e-10;

/// Whether only single rows stand between the point and a solution.
pub(super) fn is_near(solution: &Solution, tol: f64) -> bool {
    !solution.status().is_answer() && solution.residual <= tol.min(NEAR)
}
