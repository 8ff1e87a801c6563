//! Whether q shows beside a point: where it does not, z may solve LCP(0, A) to rounding, and LCP(q, A) not at all.
//!
//! Both questions are asked on the caller's numbers, of points that the judge has accepted, for n up to [`PROVED_UP_TO`]. O(n^2).

use crate::cutovers::PROVED_UP_TO;
use crate::problem::Lcp;
use crate::residual::{off_by, slack};
use crate::solution::Solution;
use crate::status::Status;

/// A smaller part of `(|A||z| + |q|)_i` hardly shows.
const HARDLY_SHOWS: f64 = 1e-6;
/// An error that is a larger part of `q_i` is not one of rounding.
const NOTICEABLE: f64 = 1e-6;

/// Whether some `q_i` hardly shows beside the terms of its row: asked of what the portfolio found.
pub(super) fn hides_q(lcp: &Lcp, solution: &Solution) -> bool {
    any_row(lcp, solution, |q, m, _| q.abs() < HARDLY_SHOWS * m)
}

/// Whether moreover row i misses such a `q_i` by a part of it that is more than rounding: asked of a basis that was tried at
/// once. A box under a load 10^6 times its weight hides q and does not miss it.
pub(crate) fn misses_q(lcp: &Lcp, solution: &Solution) -> bool {
    any_row(lcp, solution, |q, m, off| q.abs() < HARDLY_SHOWS * m && off > NOTICEABLE * q.abs())
}

/// Whether a solution may lie beyond the bound of a nearly infeasible problem, and a proof is cheap.
pub(super) fn is_undecided(solution: &Solution) -> bool {
    solution.status() == Status::NearlyInfeasible && solution.z.len() <= PROVED_UP_TO
}

/// Whether `question` holds of `q_i`, `(|A||z| + |q|)_i` and the error of row i, in some row of a solved problem with `q_i`
/// not 0.
fn any_row(lcp: &Lcp, solution: &Solution, question: impl Fn(f64, f64, f64) -> bool) -> bool {
    let (q, z) = (lcp.q(), &solution.z);
    if lcp.n() > PROVED_UP_TO || solution.status() != Status::Solved {
        return false;
    }
    let (w, magnitude) = slack(lcp, z);
    (0..lcp.n()).any(|i| q[i] != 0.0 && question(q[i], magnitude[i], off_by(z[i], w[i])))
}
