//! The Lemke-Howson method for LCPs with the structure of a bimatrix game. [LH64], [CPS92, sec. 4.4]
//!
//! `A = [[0, C], [D, 0]]` with `C, D >= 0` and `q < 0` is the problem of finding an equilibrium of the game with costs
//! `C` and `D'`; every covering vector d > 0 sends Lemke's method to a ray there, so the game's own path is followed.

use crate::control::Control;
use crate::pivoting::path_limit;
use crate::pivoting::{Dictionary, Entering, Var, basis};
use crate::problem::Lcp;
use crate::solution::Candidate;
use crate::status::Termination;

/// Options of the Lemke-Howson method.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// The label dropped first, an index in `0..n`; different labels may find different equilibria.
    pub label: usize,
}

/// The number of rows of `C` when `A = [[0, C], [D, 0]]` with `C, D >= 0` and `q < 0`.
#[must_use]
pub fn bimatrix_split(lcp: &Lcp) -> Option<usize> {
    let n = lcp.n();
    if n < 2 || lcp.q().iter().any(|&q| q >= 0.0) || lcp.a().iter().any(|&a| a < 0.0) {
        return None;
    }
    let m = lcp.row(0).iter().position(|&a| a > 0.0)?;
    let zero_block = |i: usize| if i < m { 0..m } else { m..n };
    (m > 0 && (0..n).all(|i| lcp.row(i)[zero_block(i)].iter().all(|&a| a == 0.0))).then_some(m)
}

/// Follows the path that starts by dropping `settings.label`. O(n^2) a pivot.
///
/// With costs `c_ij = a_ij / -q_i` and a constant `K` above all of them, the payoffs `K - c_ij` are positive, and
/// `v = 1 - (K - c) u >= 0, u >= 0, u'v = 0` has the trivial solution `u = 0` from which the path leads to an
/// equilibrium; the support of `u` is that of a solution `z`. [CPS92, sec. 1.2, 4.4]
#[must_use]
pub fn lemke_howson(lcp: &Lcp, settings: &Settings, control: &Control<'_>) -> Candidate {
    let n = lcp.n();
    let Some(m) = bimatrix_split(lcp) else {
        return Candidate::point(
            vec![0.0; n],
            Termination::Breakdown("A is not [[0, C], [D, 0]] with C, D >= 0 and q < 0"),
            0,
        );
    };
    let mut players = payoff_form(lcp, m);
    let label = settings.label % n;
    let mut driving = Var::Z(label);
    let mut iterations = 0;
    let termination = loop {
        if let Some(reason) = control.stop(iterations, path_limit(n)) {
            break reason;
        }
        let column = |player: &Dictionary<f64>| player.column_of(driving);
        let Some((player, s)) = players.iter_mut().find_map(|player| column(player).map(|s| (player, s))) else {
            break Termination::Breakdown("the driving variable is not nonbasic");
        };
        let Some(row) = player.blocking_row(s, Entering::Increasing) else {
            break Termination::Breakdown("the path of a bimatrix game is unbounded");
        };
        let left = player.exchange(row, s);
        iterations += 1;
        if left == Var::W(label) || left == Var::Z(label) {
            break Termination::ComplementaryBasis;
        }
        driving = left.complement().unwrap_or(Var::Z0);
    };
    let mut alpha = [players[1].basic_z(), players[0].basic_z()].concat();
    alpha.sort_unstable();
    match basis::basic_point(lcp, &alpha) {
        Some(z) if termination == Termination::ComplementaryBasis => {
            Candidate { alpha: Some(alpha), ..Candidate::point(z, termination, iterations) }
        }
        _ => Candidate::point(vec![0.0; n], termination, iterations),
    }
}

/// `v = 1 - (K - c) u`, the game in payoffs: the rows of either player, who answers the strategies of the other. Nothing
/// else couples the two, so that a pivot concerns one of them.
fn payoff_form(lcp: &Lcp, m: usize) -> [Dictionary<f64>; 2] {
    let n = lcp.n();
    let cost = |i: usize, j: usize| lcp.row(i)[j] / -lcp.q()[i];
    let sides = [(0..m, m..n), (m..n, 0..m)];
    let largest = sides.iter().flat_map(|(own, others)| own.clone().map(move |i| (i, others.clone())));
    let largest = largest.map(|(i, others)| others.map(|j| cost(i, j)).fold(0.0, f64::max)).fold(0.0, f64::max);
    let constant = 1.25 * largest;
    sides.map(|(own, others)| {
        let basic = own.clone().map(|i| (Var::W(i), 1.0)).collect();
        let entry = |r: usize, c: usize| cost(own.start + r, others.start + c) / constant - 1.0;
        Dictionary::with_rows(n, basic, others.clone().map(Var::Z).collect(), entry)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::{natural_residual, slack};

    #[test]
    fn every_label_of_a_3x2_game_finds_an_equilibrium() {
        // Costs of a 3x2 game as an LCP with q = -e.
        let c = [[1.0, 5.0], [4.0, 2.0], [3.0, 3.0]];
        let d = [[2.0, 5.0, 1.0], [4.0, 1.0, 3.0]];
        let mut a = vec![0.0; 25];
        for i in 0..3 {
            for j in 0..2 {
                a[i * 5 + 3 + j] = c[i][j];
                a[(3 + j) * 5 + i] = d[j][i];
            }
        }
        let lcp = Lcp::new(5, a, vec![-1.0; 5]).expect("valid");
        assert_eq!(bimatrix_split(&lcp), Some(3));
        for label in 0..5 {
            let found = lemke_howson(&lcp, &Settings { label }, &Control::default());
            assert_eq!(found.termination, Termination::ComplementaryBasis);
            let (w, _) = slack(&lcp, &found.z);
            assert!(natural_residual(&found.z, &w) < 1e-14);
        }
    }
}
