//! What the approximate methods share: products with A by rows and columns, the goal and the best iterate, the sweep of
//! Gauss-Seidel, factorisations on a support.

pub mod factors;
pub mod goal;
pub mod matrix;
pub mod support;
pub mod sweep;

pub use factors::Factors;
pub use goal::{Goal, Incumbent};
pub use matrix::{Dense, Matrix, Sparse};
pub use support::Support;
pub use sweep::Sweep;

/// `max(0, z0)` or 0, and its `w`.
#[must_use]
pub fn start(matrix: &impl Matrix, z0: Option<&[f64]>) -> (Vec<f64>, Vec<f64>) {
    let n = matrix.n();
    let z: Vec<f64> = z0.map_or_else(|| vec![0.0; n], |z0| z0.iter().map(|z| z.max(0.0)).collect());
    let mut w = vec![0.0; n];
    matrix.affine(&z, &mut w);
    (z, w)
}
