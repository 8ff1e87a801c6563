//! Problems, and the numbers that they are drawn from.

use fastrand::Rng;

/// LCP(q, A), A row-major.
#[derive(Clone, Debug)]
pub struct Problem {
    pub n: usize,
    pub a: Vec<f64>,
    pub q: Vec<f64>,
}

impl Problem {
    pub fn row(&self, i: usize) -> &[f64] {
        &self.a[i * self.n..(i + 1) * self.n]
    }
}

pub(crate) fn normal(rng: &mut Rng) -> f64 {
    (-2.0 * (1.0 - rng.f64()).ln()).sqrt() * (std::f64::consts::TAU * rng.f64()).cos()
}

pub(crate) fn normals(rng: &mut Rng, count: usize) -> Vec<f64> {
    (0..count).map(|_| normal(rng)).collect()
}

pub(crate) fn uniform(rng: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.f64()
}

pub(crate) fn power_of_ten(rng: &mut Rng, low: f64, high: f64) -> f64 {
    10f64.powf(uniform(rng, low, high))
}

/// `B D B'` for the n x k matrix B, exactly symmetric.
pub(crate) fn gram(n: usize, k: usize, b: &[f64], d: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut a = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let x = (0..k).map(|l| b[i * k + l] * d(l) * b[j * k + l]).sum();
            a[i * n + j] = x;
            a[j * n + i] = x;
        }
    }
    a
}

/// q from a complementary pair, a share of whose entries is zero on both sides, or just random numbers.
pub(crate) fn with_q(rng: &mut Rng, n: usize, a: Vec<f64>) -> Problem {
    let q = if rng.bool() { planted(rng, n, &a, 0.1) } else { normals(rng, n) };
    Problem { n, a, q }
}

pub(crate) fn planted(rng: &mut Rng, n: usize, a: &[f64], both_zero: f64) -> Vec<f64> {
    let pair: Vec<(f64, f64)> = (0..n)
        .map(|_| match (rng.f64() < both_zero, rng.bool()) {
            (true, _) => (0.0, 0.0),
            (_, true) => (rng.f64(), 0.0),
            (_, false) => (0.0, rng.f64()),
        })
        .collect();
    (0..n).map(|i| pair[i].1 - (0..n).map(|j| a[i * n + j] * pair[j].0).sum::<f64>()).collect()
}

/// Rows and columns of the problem times the given factors; q with the rows.
pub(crate) fn scaled(mut p: Problem, mut factor: impl FnMut() -> f64) -> Problem {
    let (rows, columns): (Vec<f64>, Vec<f64>) = (0..p.n).map(|_| (factor(), factor())).unzip();
    for i in 0..p.n {
        for j in 0..p.n {
            p.a[i * p.n + j] = finite(p.a[i * p.n + j] * rows[i] * columns[j]);
        }
        p.q[i] = finite(p.q[i] * rows[i]);
    }
    p
}

pub(crate) fn finite(x: f64) -> f64 {
    x.clamp(-f64::MAX, f64::MAX)
}

/// An orthogonal matrix: Gram-Schmidt on Gaussian rows, twice.
pub(crate) fn orthogonal(rng: &mut Rng, n: usize) -> Vec<f64> {
    let mut u = normals(rng, n * n);
    for i in 0..n {
        for _ in 0..2 {
            for j in 0..i {
                let dot: f64 = (0..n).map(|k| u[i * n + k] * u[j * n + k]).sum();
                for k in 0..n {
                    u[i * n + k] -= dot * u[j * n + k];
                }
            }
        }
        let size = (0..n).map(|k| u[i * n + k].powi(2)).sum::<f64>().sqrt();
        for k in 0..n {
            u[i * n + k] /= size;
        }
    }
    u
}
