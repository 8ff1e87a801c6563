//! A dictionary moved to another complementary basis, which then is where a path starts.

use super::{Dictionary, Place};
use crate::control::Control;
use crate::pivoting::Var;
use crate::pivoting::real::Real;
use crate::status::Termination;

/// A pivot of a principal block below this is left for the path to decide: on an equilibrated problem the block is
/// singular there to within what its data are worth.
const SINGULAR: f64 = 1e-9;
/// A diagonal pivot is taken while it is at least this fraction of the best block of order two. [BunP71]
const DIAGONAL: f64 = 0.6;
/// A diagonal pivot of this size is taken without looking for anything better.
const LARGE: f64 = 0.1;

impl<T: Real> Dictionary<T> {
    /// Makes `z_alpha` basic by principal pivots of order one and two, largest first, as far as `A[alpha, alpha]` is
    /// nonsingular; the indices made basic. O(n^2) for each. Only on a dictionary that has not been pivoted.
    ///
    /// # Errors
    ///
    /// The clock or the caller stopped it (`control`, whose iteration limit does not count here).
    pub fn pivot_to(&mut self, alpha: &[usize], control: &Control<'_>) -> Result<Vec<usize>, Termination> {
        let mut left = alpha.to_vec();
        let mut done = Vec::with_capacity(alpha.len());
        while let Some((i, j)) = self.principal_pivot(&left) {
            if let Some(reason) = control.expired() {
                return Err(reason);
            }
            // Column j still belongs to pair j, row i to pair i: what was exchanged is not in `left`.
            self.exchange(i, j);
            if i != j {
                self.exchange(j, i);
            }
            left.retain(|&k| k != i && k != j);
            done.push(i);
            if i != j {
                done.push(j);
            }
        }
        done.sort_unstable();
        Ok(done)
    }

    /// `(i, i)`, or `(i, j)` for a block of order two; `None` when all are singular.
    fn principal_pivot(&self, left: &[usize]) -> Option<(usize, usize)> {
        let at = |i: usize, j: usize| self.coefficient(i, j);
        let size = |&i: &usize| at(i, i).to_f64().abs();
        let best = left.iter().copied().max_by(|i, j| size(i).total_cmp(&size(j)))?;
        let largest = size(&best);
        if largest >= LARGE {
            return Some((best, best));
        }
        let mut pair = None;
        let mut largest_block = (largest / DIAGONAL).max(SINGULAR);
        for (k, &i) in left.iter().enumerate() {
            for &j in &left[..k] {
                let determinant = at(i, i) * at(j, j) - at(i, j) * at(j, i);
                let size = determinant.to_f64().abs().sqrt().min(at(i, j).to_f64().abs());
                if size > largest_block {
                    (pair, largest_block) = (Some((i, j)), size);
                }
            }
        }
        pair.or((largest >= SINGULAR).then_some((best, best)))
    }

    /// Calls the current basis the start: LCP(p, M) for the principal transform M, in which basic variables are called w
    /// and the others z, with the covering vector d in the column of `z_0`. Basic values that are rounding become zero.
    ///
    /// The order of ties is then that of a dictionary built from M and p. Only before `z_0` was exchanged.
    pub fn restart(&mut self, d: impl Fn(f64) -> f64) {
        let pair = |var: Var| match var {
            Var::W(i) | Var::Z(i) => i,
            Var::Z0 => usize::MAX,
        };
        let largest = T::largest(&self.values);
        let n = self.basic.len();
        for r in 0..n {
            let i = pair(self.basic[r]);
            self.basic[r] = Var::W(i);
            self.places[0][i] = Place::Row(r);
            let value = self.value(r);
            if value.to_f64().abs() <= ZERO * T::EPSILON * largest {
                self.values[r] = T::from(0.0);
            }
            self.base[r * self.width + n] = T::from(d(value.to_f64()));
        }
        for s in 0..n {
            let i = pair(self.nonbasic[s]);
            self.nonbasic[s] = Var::Z(i);
            self.places[1][i] = Place::Column(s);
        }
    }
}

/// Basic values below `ZERO EPS max|p|` are zeros.
const ZERO: f64 = 256.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dd::Dd;
    use crate::pivoting::transform::principal_pivot_transform;
    use crate::problem::Lcp;

    /// Diagonal zeros force a block of order two.
    #[test]
    fn it_is_the_principal_transform() {
        let a = vec![0.0, 1.0, 1.0, 2.0, 0.0, 1.0, -1.0, -1.0, 0.0];
        let lcp = Lcp::new(3, a, vec![1.0, 2.0, 3.0]).expect("valid");
        for alpha in [vec![], vec![0, 1], vec![1, 2], vec![0, 1, 2]] {
            let transform = principal_pivot_transform(&lcp, &alpha, &Control::default());
            let transform = transform.expect("nonsingular").expect("not stopped");
            let mut dictionary = Dictionary::<Dd>::new(&lcp, &[0.0; 3]);
            assert_eq!(dictionary.pivot_to(&alpha, &Control::default()), Ok(alpha.clone()));
            dictionary.restart(|_| 1.0);
            for r in 0..3 {
                let Var::W(i) = dictionary.basic(r) else { unreachable!("all are called w") };
                assert!((dictionary.value(r).to_f64() - transform.q()[i]).abs() < 1e-15);
                for s in 0..3 {
                    let Var::Z(j) = dictionary.nonbasic(s) else { unreachable!("all are called z") };
                    assert!((dictionary.coefficient(r, s).to_f64() - transform.row(i)[j]).abs() < 1e-15);
                }
                assert_eq!(dictionary.coefficient(r, 3).to_f64(), 1.0);
            }
        }
    }

    #[test]
    fn it_asks_whether_to_stop() {
        let lcp = Lcp::new(2, vec![2.0, 1.0, 1.0, 2.0], vec![-1.0, -1.0]).expect("valid");
        let mut dictionary = Dictionary::<f64>::new(&lcp, &[0.0; 2]);
        let stopped = Control { interrupted: Some(&|| true), ..Control::default() };
        assert_eq!(dictionary.pivot_to(&[0, 1], &stopped), Err(Termination::Interrupted));
    }

    #[test]
    fn a_singular_block_is_taken_in_part() {
        let lcp = Lcp::new(2, vec![1.0; 4], vec![-1.0, -1.0]).expect("valid");
        let mut dictionary = Dictionary::<f64>::new(&lcp, &[0.0; 2]);
        assert_eq!(dictionary.pivot_to(&[0, 1], &Control::default()).map(|done| done.len()), Ok(1));
    }
}
