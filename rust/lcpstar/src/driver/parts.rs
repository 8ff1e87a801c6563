//! A part of a problem as a problem of its own, and the name of what solved all parts.

use crate::linalg::kernels::dot_compensated;
use crate::member::Member;
use crate::presolve::{self, Part};
use crate::problem::Lcp;
use crate::solution::Piece;

/// One part on the caller's numbers, where the parts before it have the solution `z`. `None` if its q is beyond the doubles.
pub(super) fn subproblem(lcp: &Lcp, part: &Part, z: &[f64]) -> Option<Lcp> {
    let q = |i: usize| if part.follows { dot_compensated(lcp.q()[i], lcp.row(i), z).0 } else { lcp.q()[i] };
    let q: Vec<f64> = part.indices.iter().map(|&i| q(i)).collect();
    q.iter().all(|q| q.is_finite()).then(|| presolve::subproblem(lcp, &part.indices, q))
}

/// The method that answered every part, but for those with `q >= 0`; [`Member::Pieces`] when there are several.
pub(super) fn name(pieces: &[Piece]) -> Member {
    let mut methods = pieces.iter().map(|(_, method)| *method).filter(|method| *method != Member::Trivial);
    match methods.next() {
        None => Member::Trivial,
        Some(first) if methods.all(|method| method == first) => first,
        Some(_) => Member::Pieces,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_whose_q_overflows_has_no_answer() {
        let lcp = Lcp::new(2, vec![1e-200, 0.0, 1e200, 1.0], vec![-1e100, 0.0]).expect("valid");
        let part = Part { indices: vec![1], follows: true };
        assert!(subproblem(&lcp, &part, &[1e100, 0.0]).is_some());
        assert!(subproblem(&lcp, &part, &[1e300, 0.0]).is_none());
    }
}
