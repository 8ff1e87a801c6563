//! Chandrasekaran's method for Z-matrices: every off-diagonal entry `<= 0`. [Cha70]
//!
//! While some `w_i` is negative, `z_i` enters, for ever: once positive it never falls. If its diagonal entry is no
//! longer positive then the whole row is nonpositive, and FEA(q, A) is empty. At most n pivots decide the problem, and
//! the solution is the least element of FEA(q, A). [CPS92, sec. 4.7]

use crate::control::Control;
use crate::pivoting::{Dictionary, basis};
use crate::problem::Lcp;
use crate::solution::Candidate;
use crate::status::Termination;

/// A diagonal entry is zero below this fraction of the row's entries at the start: what n subtractions leave of it.
const ZERO: f64 = 1e-13;
/// A slack is negative below `-SIGN max|q|`.
const SIGN: f64 = 1e-15;

/// The first off-diagonal entry above zero, row by row. O(n^2), or less when there is one.
#[must_use]
pub fn positive_off_diagonal(lcp: &Lcp) -> Option<(usize, usize)> {
    (0..lcp.n()).find_map(|i| {
        let (row, positive) = (lcp.row(i), |x: &f64| *x > 0.0);
        let before = row[..i].iter().position(positive);
        before.or_else(|| row[i + 1..].iter().position(positive).map(|j| i + 1 + j)).map(|j| (i, j))
    })
}

/// Solves LCP(q, A) for a Z-matrix A, or finds a Farkas vector. At most n pivots of O(n^2).
#[must_use]
pub fn chandrasekaran(lcp: &Lcp, control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    if let Some((row, column)) = positive_off_diagonal(lcp) {
        return Candidate::point(vec![0.0; n], Termination::NotZ { row, column }, 0);
    }
    // Basic row and nonbasic column of a pair keep their places: every pivot is on the diagonal.
    let mut dictionary = Dictionary::<f64>::new(lcp, &vec![0.0; n]);
    let mut in_alpha = vec![false; n];
    let noise = SIGN * crate::linalg::kernels::max_abs(lcp.q());
    let mut iterations = 0;
    let termination = loop {
        if let Some(reason) = control.stop(iterations, n + 1) {
            break reason;
        }
        let Some(i) = (0..n).find(|&i| !in_alpha[i] && dictionary.value(i) < -noise) else {
            break Termination::ComplementaryBasis;
        };
        if dictionary.coefficient(i, i) <= ZERO * lcp.row(i)[i].abs() {
            let farkas = basis::row_multiplier(lcp, &members(&in_alpha), i);
            let point = Candidate::point(vec![0.0; n], Termination::Infeasible, iterations);
            return Candidate { farkas, ..point };
        }
        dictionary.exchange(i, i);
        in_alpha[i] = true;
        iterations += 1;
    };
    let alpha = members(&in_alpha);
    let z = basis::basic_point(lcp, &alpha).unwrap_or_else(|| vec![0.0; n]);
    Candidate { alpha: Some(alpha), ..Candidate::point(z, termination, iterations) }
}

fn members(in_alpha: &[bool]) -> Vec<usize> {
    (0..in_alpha.len()).filter(|&i| in_alpha[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(a: &[f64], q: &[f64]) -> Candidate {
        let lcp = Lcp::new(q.len(), a.to_vec(), q.to_vec()).expect("valid");
        chandrasekaran(&lcp, &Control::default())
    }

    #[test]
    fn the_least_element_in_at_most_n_pivots() {
        let found = run(&[2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 2.0], &[-1.0, 1.0, -1.0]);
        assert_eq!(found.termination, Termination::ComplementaryBasis);
        assert_eq!((found.iterations, found.z.as_slice()), (2, &[0.5, 0.0, 0.5][..]));
    }

    #[test]
    fn an_empty_feasible_set_is_proved_by_a_row() {
        // A (1, 1) = 0: z_1 and z_2 chase each other.
        let found = run(&[1.0, -1.0, -1.0, 1.0], &[-1.0, -1.0]);
        assert_eq!(found.termination, Termination::Infeasible);
        assert_eq!(found.farkas.expect("a row"), [1.0, 1.0]);
    }

    #[test]
    fn the_offending_entry_is_named() {
        let found = run(&[1.0, -1.0, 0.5, 1.0], &[-1.0, -1.0]);
        assert_eq!(found.termination, Termination::NotZ { row: 1, column: 0 });
    }
}
