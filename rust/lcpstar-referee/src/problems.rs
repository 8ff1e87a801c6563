//! The generators behind the attacks.

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

fn normals(rng: &mut Rng, count: usize) -> Vec<f64> {
    (0..count).map(|_| normal(rng)).collect()
}

pub(crate) fn uniform(rng: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.f64()
}

pub(crate) fn power_of_ten(rng: &mut Rng, low: f64, high: f64) -> f64 {
    10f64.powf(uniform(rng, low, high))
}

/// `B D B'` for the n x k matrix B, exactly symmetric.
fn gram(n: usize, k: usize, b: &[f64], d: impl Fn(usize) -> f64) -> Vec<f64> {
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
fn with_q(rng: &mut Rng, n: usize, a: Vec<f64>) -> Problem {
    let q = if rng.bool() { planted(rng, n, &a, 0.1) } else { normals(rng, n) };
    Problem { n, a, q }
}

fn planted(rng: &mut Rng, n: usize, a: &[f64], both_zero: f64) -> Vec<f64> {
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
fn scaled(mut p: Problem, mut factor: impl FnMut() -> f64) -> Problem {
    let (rows, columns): (Vec<f64>, Vec<f64>) = (0..p.n).map(|_| (factor(), factor())).unzip();
    for i in 0..p.n {
        for j in 0..p.n {
            p.a[i * p.n + j] = finite(p.a[i * p.n + j] * rows[i] * columns[j]);
        }
        p.q[i] = finite(p.q[i] * rows[i]);
    }
    p
}

fn finite(x: f64) -> f64 {
    x.clamp(-f64::MAX, f64::MAX)
}

/// An orthogonal matrix: Gram-Schmidt on Gaussian rows, twice.
fn orthogonal(rng: &mut Rng, n: usize) -> Vec<f64> {
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

pub(crate) fn condition(rng: &mut Rng, n: usize) -> Problem {
    let decades = uniform(rng, 0.0, 16.0);
    let spectrum: Vec<f64> = (0..n).map(|k| 10f64.powf(-decades * k as f64 / (n.max(2) - 1) as f64)).collect();
    let (u, v) = (orthogonal(rng, n), orthogonal(rng, n));
    let a = if rng.bool() {
        // Columns of U': the Gram matrix of its rows.
        let ut: Vec<f64> = (0..n * n).map(|k| u[(k % n) * n + k / n]).collect();
        gram(n, n, &ut, |l| spectrum[l])
    } else {
        (0..n * n).map(|k| (0..n).map(|l| u[l * n + k / n] * spectrum[l] * v[l * n + k % n]).sum()).collect()
    };
    with_q(rng, n, a)
}

pub(crate) fn hilbert(rng: &mut Rng, n: usize) -> Problem {
    let mut order: Vec<usize> = (0..n).collect();
    rng.shuffle(&mut order);
    let sign = if rng.u32(0..4) == 0 { -1.0 } else { 1.0 };
    let a = (0..n * n).map(|k| sign / (order[k / n] + order[k % n] + 1) as f64).collect();
    with_q(rng, n, a)
}

pub(crate) fn vandermonde(rng: &mut Rng, n: usize) -> Problem {
    let x: Vec<f64> = (0..n).map(|_| uniform(rng, -1.0, 2.0)).collect();
    let v: Vec<f64> = (0..n * n).map(|k| x[k / n].powi((k % n) as i32)).collect();
    let a = if rng.bool() { gram(n, n, &v, |_| 1.0) } else { v };
    with_q(rng, n, a)
}

pub(crate) fn graded(rng: &mut Rng, n: usize) -> Problem {
    let base = if rng.bool() { integers(rng, n) } else { positive_definite(rng, n) };
    let mut own = rng.fork();
    scaled(base, move || power_of_ten(&mut own, -150.0, 150.0))
}

pub(crate) fn ends(rng: &mut Rng, n: usize) -> Problem {
    let sizes = [5e-324, 3e-310, 2.3e-308, 1e-200, 1e-154, 1.0, 3.0, 1e154, 1e200, 1e307, f64::MAX];
    let few: Vec<f64> = (0..rng.usize(1..=3)).map(|_| sizes[rng.usize(0..sizes.len())]).collect();
    let mut entry = || match rng.u32(0..5) {
        0 => 0.0,
        1 => -few[rng.usize(0..few.len())],
        _ => few[rng.usize(0..few.len())],
    };
    let a = (0..n * n).map(|_| entry()).collect();
    let q = (0..n).map(|_| -entry()).collect();
    Problem { n, a, q }
}

pub(crate) fn q_ends(rng: &mut Rng, n: usize) -> Problem {
    let mut p = if rng.bool() { positive_definite(rng, n) } else { degenerate(rng, n) };
    let factor = if rng.bool() { 1e-300 } else { 1e300 };
    for q in &mut p.q {
        *q = finite(*q * factor);
    }
    p
}

/// `J M^-1 J'` for contacts with random normals between a few bodies, three velocities each.
fn contacts(rng: &mut Rng, n: usize, decades: f64) -> Problem {
    let bodies = n / 2 + 1;
    let mut j = vec![0.0; n * 3 * bodies];
    for k in 0..n {
        let mut normal = normals(rng, 3);
        normal[2] = normal[2].abs() + 0.5;
        let (one, other) = (rng.usize(0..bodies), rng.usize(0..=bodies));
        for c in 0..3 {
            j[k * 3 * bodies + 3 * one + c] = normal[c];
            if other != one && other < bodies {
                j[k * 3 * bodies + 3 * other + c] = -normal[c];
            }
        }
    }
    let mass: Vec<f64> = (0..bodies).map(|_| power_of_ten(rng, 0.0, decades)).collect();
    let a = gram(n, 3 * bodies, &j, |l| 1.0 / mass[l / 3]);
    let v: Vec<f64> = (0..3 * bodies).map(|c| 0.02 * normal(rng) - if c % 3 == 2 { 0.0981 } else { 0.0 }).collect();
    let q = (0..n).map(|k| (0..3 * bodies).map(|c| j[k * 3 * bodies + c] * v[c]).sum()).collect();
    Problem { n, a, q }
}

pub(crate) fn mass_ratio(rng: &mut Rng, n: usize) -> Problem {
    let decades = uniform(rng, 0.0, 12.0);
    contacts(rng, n, decades)
}

pub(crate) fn degenerate(rng: &mut Rng, n: usize) -> Problem {
    let rank = rng.usize(1..=n);
    let half: Vec<f64> = (0..n.div_ceil(2) * rank).map(|_| f64::from(rng.i32(-2..=2))).collect();
    let b: Vec<f64> = (0..n * rank).map(|k| half[k % half.len()]).collect();
    let a = gram(n, rank, &b, |_| 1.0);
    let both_zero = rng.f64();
    let pair: Vec<(f64, f64)> = (0..n)
        .map(|_| {
            if rng.f64() < both_zero {
                (0.0, 0.0)
            } else if rng.bool() {
                (1.0, 0.0)
            } else {
                (0.0, 1.0)
            }
        })
        .collect();
    let q = (0..n).map(|i| pair[i].1 - (0..n).map(|j| a[i * n + j] * pair[j].0).sum::<f64>()).collect();
    Problem { n, a, q }
}

pub(crate) fn near_infeasible(rng: &mut Rng, n: usize) -> Problem {
    let rank = rng.usize(1..=n);
    let mut b: Vec<f64> =
        if rng.bool() { normals(rng, n * rank) } else { (0..n * rank).map(|_| f64::from(rng.i32(-3..=3))).collect() };
    let (i, j) = (rng.usize(0..n), rng.usize(0..n));
    for l in 0..rank {
        b[i * rank + l] = if i == j { 0.0 } else { -b[j * rank + l] };
    }
    let a = gram(n, rank, &b, |_| 1.0);
    let mut q = planted(rng, n, &a, 0.1);
    let step = power_of_ten(rng, -17.0, 0.0);
    q[i] = (if i == j { 0.0 } else { -q[j] }) + if rng.bool() { step } else { -step };
    Problem { n, a, q }
}

pub(crate) fn tiny_angles(rng: &mut Rng, n: usize) -> Problem {
    let angle = power_of_ten(rng, -15.0, 0.0);
    let mut rows = Vec::with_capacity(3 * n);
    for _ in 0..n {
        let (x, y) = (angle * normal(rng), angle * normal(rng));
        let size = (1.0 + x * x + y * y).sqrt();
        rows.extend([x / size, y / size, 1.0 / size]);
    }
    let a = gram(n, 3, &rows, |_| 1.0);
    let v = [0.1 * normal(rng), 0.1 * normal(rng), -1.0];
    let q = (0..n).map(|i| (0..3).map(|c| rows[3 * i + c] * v[c]).sum()).collect();
    Problem { n, a, q }
}

pub(crate) fn duplicates(rng: &mut Rng, n: usize) -> Problem {
    let base = contacts(rng, n, 2.0);
    let of: Vec<usize> = (0..n).map(|i| rng.usize(0..=i)).collect();
    let noise = if rng.bool() { 0.0 } else { power_of_ten(rng, -17.0, -10.0) };
    let mut shaken = |x: f64| x * (1.0 + noise * normal(rng));
    let a = (0..n * n).map(|k| shaken(base.a[of[k / n] * n + of[k % n]])).collect();
    let q = of.iter().map(|&i| shaken(base.q[i])).collect();
    Problem { n, a, q }
}

pub(crate) fn integers(rng: &mut Rng, n: usize) -> Problem {
    let m = rng.i32(1..=3);
    let density = uniform(rng, 0.3, 1.0);
    let a = (0..n * n).map(|_| if rng.f64() < density { f64::from(rng.i32(-m..=m)) } else { 0.0 }).collect();
    let q = (0..n).map(|_| f64::from(rng.i32(-3..=3))).collect();
    Problem { n, a, q }
}

pub(crate) fn integers_twos(rng: &mut Rng, n: usize) -> Problem {
    let mut base = integers(rng, n);
    let factor = 2f64.powi(rng.i32(-30..=30));
    base.q.iter_mut().for_each(|q| *q *= factor);
    let mut own = rng.fork();
    scaled(base, move || 2f64.powi(own.i32(-40..=40)))
}

pub(crate) fn integers_tens(rng: &mut Rng, n: usize) -> Problem {
    let base = integers(rng, n);
    let mut own = rng.fork();
    scaled(base, move || power_of_ten(&mut own, -8.0, 8.0))
}

/// `B B'/n + 0.1 I` plus a skew part: a P-matrix.
fn positive_definite(rng: &mut Rng, n: usize) -> Problem {
    let b = normals(rng, n * n);
    let mut a = gram(n, n, &b, |_| 1.0 / n as f64);
    for i in 0..n {
        a[i * n + i] += 0.1;
        for j in 0..i {
            let s = normal(rng) / (n as f64).sqrt();
            a[i * n + j] += s;
            a[j * n + i] -= s;
        }
    }
    let q = normals(rng, n);
    Problem { n, a, q }
}

pub(crate) fn badly_scaled(rng: &mut Rng, n: usize) -> Problem {
    let base = positive_definite(rng, n);
    let mut own = rng.fork();
    scaled(base, move || power_of_ten(&mut own, -8.0, 8.0))
}

pub(crate) fn special(rng: &mut Rng, n: usize) -> Problem {
    const VALUES: [f64; 15] =
        [0.0, -0.0, 1.0, -1.0, 2.0, -0.5, 5e-324, -5e-324, 1e308, -1e308, 1e-160, -1e160, 3.0, 0.1, -1e-16];
    let mut entry = || VALUES[rng.usize(0..VALUES.len())];
    let a = (0..n * n).map(|_| entry()).collect();
    let q = (0..n).map(|_| entry()).collect();
    Problem { n, a, q }
}

pub(crate) fn random(rng: &mut Rng, n: usize) -> Problem {
    let a = normals(rng, n * n);
    with_q(rng, n, a)
}

pub(crate) fn bimatrix(rng: &mut Rng, n: usize) -> Problem {
    let m = n / 2;
    let whole = rng.bool();
    let mut a = vec![0.0; n * n];
    for i in 0..m {
        for j in 0..m {
            let mut cost = || if whole { f64::from(rng.i32(1..=4)) } else { 0.1 + rng.f64() };
            a[i * n + m + j] = cost();
            a[(m + i) * n + j] = cost();
        }
    }
    Problem { n, a, q: vec![-1.0; n] }
}

/// Contacts with four friction directions: `[[J J', E], [mu, -E', 0]]`, cut to order n.
pub(crate) fn friction(rng: &mut Rng, n: usize) -> Problem {
    let k = (n / 6).max(1);
    let order = 6 * k;
    let rank = order.min(6);
    let rows = normals(rng, 5 * k * rank);
    let g = gram(5 * k, rank, &rows, |_| 1.0);
    let mut a = vec![0.0; order * order];
    for i in 0..5 * k {
        a[i * order..i * order + 5 * k].copy_from_slice(&g[i * 5 * k..(i + 1) * 5 * k]);
    }
    for c in 0..k {
        let speed = 5 * k + c;
        a[speed * order + c] = 0.5;
        for f in 0..4 {
            let direction = k + 4 * c + f;
            a[direction * order + speed] = 1.0;
            a[speed * order + direction] = -1.0;
        }
    }
    let q = (0..order).map(|i| if i < 5 * k { 0.3 * normal(rng) } else { 0.0 }).collect();
    Problem { n: order, a, q }
}

pub(crate) fn z_matrix(rng: &mut Rng, n: usize) -> Problem {
    let a = (0..n * n)
        .map(|k| if k / n == k % n { f64::from(rng.i32(-1..=6)) } else { f64::from(-rng.i32(0..=2)) })
        .collect();
    let q = (0..n).map(|_| f64::from(rng.i32(-3..=3))).collect();
    let base = Problem { n, a, q };
    let mut own = rng.fork();
    match rng.u32(0..3) {
        0 => base,
        1 => scaled(base, move || 2f64.powi(own.i32(-20..=20))),
        _ => scaled(base, move || power_of_ten(&mut own, -6.0, 6.0)),
    }
}

pub(crate) fn exponential(rng: &mut Rng, n: usize) -> Problem {
    let n = n.min(40);
    let mut m = vec![0.0; n * n];
    for i in 0..n {
        m[i * n + i] = 1.0;
        m[i * n..i * n + i].fill(2.0);
    }
    let q = (0..n).map(|i| -(0..=i).map(|k| 2f64.powi((n - 1 - k) as i32)).sum::<f64>()).collect();
    let a = if rng.bool() { gram(n, n, &m, |_| 1.0) } else { m };
    Problem { n, a, q }
}

pub(crate) fn blocks(rng: &mut Rng, n: usize) -> Problem {
    let mut p = Problem { n, a: vec![0.0; n * n], q: vec![0.0; n] };
    let coupled = rng.bool();
    let mut at = 0;
    while at < n {
        let size = rng.usize(1..=6).min(n - at);
        let part = match rng.u32(0..3) {
            0 => integers(rng, size),
            1 => positive_definite(rng, size),
            _ => degenerate(rng, size),
        };
        for i in 0..size {
            p.q[at + i] = part.q[i];
            p.a[(at + i) * n + at..(at + i) * n + at + size].copy_from_slice(part.row(i));
            if coupled && at > 0 {
                p.a[(at + i) * n + rng.usize(0..at)] = normal(rng);
            }
        }
        at += size;
    }
    if rng.bool() {
        let mut own = rng.fork();
        p = scaled(p, move || 2f64.powi(own.i32(-20..=20)));
    }
    p
}

pub(crate) fn large(rng: &mut Rng, n: usize) -> Problem {
    match rng.u32(0..3) {
        0 => badly_scaled(rng, n),
        1 => {
            let b = normals(rng, n * n / 2);
            let a = gram(n, n / 2, &b, |_| 1.0 / n as f64);
            let q = planted(rng, n, &a, 0.1);
            Problem { n, a, q }
        }
        _ => {
            let rank = n / 3;
            let half: Vec<f64> = (0..n / 2 * rank).map(|_| f64::from(rng.i32(-2..=2))).collect();
            let b: Vec<f64> = (0..n * rank).map(|k| half[k % half.len()]).collect();
            let a = gram(n, rank, &b, |_| 1.0);
            let q = planted(rng, n, &a, 0.5);
            Problem { n, a, q }
        }
    }
}
