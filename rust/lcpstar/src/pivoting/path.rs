//! What a path of almost complementary bases needs of the tableau it runs in.

use super::Var;
use super::dictionary::Entering;
use crate::problem::Lcp;

/// The tableau `x_B = q_bar + T x_N` of a complementary pivoting method.
pub trait Tableau {
    /// `w = q + A z + d z_0`. O(n^2); the only place that allocates.
    fn of(lcp: &Lcp, d: &[f64]) -> Self;
    /// The column of a nonbasic variable.
    fn column_of(&self, var: Var) -> Option<usize>;
    /// The row that blocks column `s`, by the lexicographic order; `None`: a ray.
    fn blocking_row(&mut self, s: usize, entering: Entering) -> Option<usize>;
    /// Exchanges the basic variable of row `r` with the nonbasic variable of column `s`; returns the one that left.
    fn exchange(&mut self, r: usize, s: usize) -> Var;
    /// Indices `i` with `z_i` basic, increasing.
    fn basic_z(&self) -> Vec<usize>;
    /// `(z, z_0)` of the basic solution.
    fn point(&self) -> (Vec<f64>, f64);
    /// `(z, z_0)` of the direction in which column `s` increases.
    fn direction(&self, s: usize) -> (Vec<f64>, f64);
}
