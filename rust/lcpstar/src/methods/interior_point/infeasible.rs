//! From an iterate with `tau -> 0` to a Farkas vector `y >= 0`, `A'y <= 0`, `q'y < 0` that holds to rounding.

use crate::linalg::backend::RowSpace;
use crate::linalg::kernels::{axpy, dot_compensated, max_abs};
use crate::problem::Lcp;

/// Rounds of dropping rows whose multiplier turned negative.
const ROUNDS: usize = 6;
/// Columns with `(A'y)_j` above `-BINDING` are made zero exactly.
const BINDING: [f64; 3] = [1e-5, 1e-3, 1e-7];

/// The limit of z is a Farkas vector when A is PSD: z'A z = 0 makes (A + A')z = 0, so `A'z = -A z = -w <= 0`. [AndY99]
///
/// Its support is where `z_i > w_i`; the columns with `(A'y)_j` near zero are projected to zero. A claim, for `certify`.
#[must_use]
pub fn farkas_vector(lcp: &Lcp, z: &[f64], w: &[f64]) -> Option<Vec<f64>> {
    let n = lcp.n();
    let size = max_abs(z);
    BINDING.iter().find_map(|&binding| {
        let mut support: Vec<usize> = (0..n).filter(|&i| z[i] > w[i] && z[i] > 1e-9 * size).collect();
        for _ in 0..ROUNDS {
            let mut y = vec![0.0; n];
            support.iter().for_each(|&i| y[i] = z[i] / size);
            project(lcp, &mut y, &support, binding);
            if holds(lcp, &y) {
                return Some(y);
            }
            let before = support.len();
            support.retain(|&i| y[i] > 0.0);
            if support.len() == before {
                return None;
            }
        }
        None
    })
}

/// Moves `y` on its support to the nearest vector whose binding columns vanish.
fn project(lcp: &Lcp, y: &mut [f64], support: &[usize], binding: f64) {
    let products = transposed_times(lcp, y);
    let columns: Vec<usize> = (0..y.len()).filter(|&j| products[j] > -binding).collect();
    let rows: Vec<f64> = columns.iter().flat_map(|&j| support.iter().map(move |&i| lcp.row(i)[j])).collect();
    let space = RowSpace::new(columns.len(), support.len(), &rows, 1e-10);
    for _ in 0..2 {
        let products = transposed_times(lcp, y);
        let negated: Vec<f64> = columns.iter().map(|&j| -products[j]).collect();
        for (&i, d) in support.iter().zip(space.shortest_solution(&negated)) {
            y[i] += d;
        }
    }
}

/// Stricter than what `certify` will ask, so that a claim made here stands.
fn holds(lcp: &Lcp, y: &[f64]) -> bool {
    let magnitude: Vec<f64> = {
        let mut sums = vec![0.0; y.len()];
        for (i, &y) in y.iter().enumerate() {
            for (sum, a) in sums.iter_mut().zip(lcp.row(i)) {
                *sum += (a * y).abs();
            }
        }
        sums
    };
    let products = transposed_times(lcp, y);
    let rounding = products.iter().zip(&magnitude).all(|(&x, m)| x <= 16.0 * f64::EPSILON * m);
    let worst = products.iter().fold(0.0, |m: f64, &x| m.max(x));
    let qy = dot_compensated(0.0, lcp.q(), y).0;
    rounding && y.iter().all(|&y| y >= 0.0) && qy < -1e-12 && worst * 1e11 <= -qy
}

fn transposed_times(lcp: &Lcp, y: &[f64]) -> Vec<f64> {
    let mut products = vec![0.0; y.len()];
    for (i, &y) in y.iter().enumerate() {
        axpy(y, lcp.row(i), &mut products);
    }
    products
}
