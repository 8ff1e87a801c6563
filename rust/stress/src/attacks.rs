//! The attacks: one generator per way to mislead a solver, reproducible by its seed.

use crate::problem::{
    Problem, finite, gram, normal, normals, orthogonal, planted, power_of_ten, scaled, uniform, with_q,
};
use fastrand::Rng;

/// A name, what it does, a share of the campaign, its orders and its generator.
pub struct Attack {
    pub name: &'static str,
    pub about: &'static str,
    pub weight: usize,
    pub order: fn(&mut Rng) -> usize,
    pub problem: fn(&mut Rng, usize) -> Problem,
}

/// Every attack of the campaign.
pub const ATTACKS: &[Attack] = &[
    attack("condition", "symmetric or not, condition number 1 to 1e16", 6, mixed, condition),
    attack("hilbert", "Hilbert matrices, permuted, of either sign", 3, mixed, hilbert),
    attack("vandermonde", "Vandermonde V and V V'", 3, mixed, vandermonde),
    attack("graded", "rows and columns times 10^U(-150, 150)", 6, mixed, graded),
    attack("ends", "subnormals and numbers near overflow side by side", 5, small, ends),
    attack("q at the ends", "q times 1e-300 or 1e300", 4, mixed, q_ends),
    attack("mass ratio", "contacts between bodies, masses 1 to 1e12", 6, mixed, mass_ratio),
    attack("degenerate", "integer PSD, repeated rows, 0 to 100 % of pairs both zero", 6, mixed, degenerate),
    attack("near infeasible", "y >= 0 with A'y = 0 and q'y = +-10^-U(0, 17)", 6, mixed, near_infeasible),
    attack("tiny angles", "contact normals 10^-U(0, 15) apart", 5, mixed, tiny_angles),
    attack("duplicates", "contacts repeated, exactly or to rounding", 5, mixed, duplicates),
    attack("integers", "{-3..3} with zeros: singular blocks, ties", 10, small, integers),
    attack("integers 2^40", "the same, rows and columns times 2^U(-40, 40)", 10, small, integers_twos),
    attack("integers 10^8", "the same, rows and columns times 10^U(-8, 8)", 8, small, integers_tens),
    attack("badly scaled", "P-matrices, rows and columns times 10^U(-8, 8)", 5, mixed, badly_scaled),
    attack("orders 0 to 2", "every combination of 0, +-1, +-5e-324, +-1e308, ...", 4, tiny, special),
    attack("random", "Gaussian, no structure", 4, mixed, random),
    attack("bimatrix", "games, integer and real", 3, even, bimatrix),
    attack("friction", "copositive: contacts with polyhedral friction cones", 3, mixed, friction),
    attack("Z", "Z-matrices, integer and scaled", 3, mixed, z_matrix),
    attack("exponential", "Murty's and Fathi's matrices, n to 40", 1, mixed, exponential),
    attack("blocks", "islands and triangular blocks of integers, n 17 to 40", 2, middle, blocks),
    attack("n = 1000", "scaled P, PSD of half rank, degenerate", 0, thousand, large),
];

const fn attack(
    name: &'static str,
    about: &'static str,
    weight: usize,
    order: fn(&mut Rng) -> usize,
    problem: fn(&mut Rng, usize) -> Problem,
) -> Attack {
    Attack { name, about, weight, order, problem }
}

fn mixed(rng: &mut Rng) -> usize {
    match rng.u32(0..1000) {
        0..600 => rng.usize(1..=5),
        600..850 => rng.usize(6..=8),
        850..970 => rng.usize(9..=16),
        970..995 => rng.usize(17..=33),
        _ => rng.usize(34..=64),
    }
}

fn small(rng: &mut Rng) -> usize {
    if rng.u32(0..10) < 8 { rng.usize(1..=5) } else { rng.usize(6..=8) }
}

fn tiny(rng: &mut Rng) -> usize {
    rng.usize(0..=2)
}

fn even(rng: &mut Rng) -> usize {
    2 * rng.usize(1..=8)
}

fn middle(rng: &mut Rng) -> usize {
    rng.usize(17..=40)
}

fn thousand(_: &mut Rng) -> usize {
    1000
}

fn condition(rng: &mut Rng, n: usize) -> Problem {
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

fn hilbert(rng: &mut Rng, n: usize) -> Problem {
    let mut order: Vec<usize> = (0..n).collect();
    rng.shuffle(&mut order);
    let sign = if rng.u32(0..4) == 0 { -1.0 } else { 1.0 };
    let a = (0..n * n).map(|k| sign / (order[k / n] + order[k % n] + 1) as f64).collect();
    with_q(rng, n, a)
}

fn vandermonde(rng: &mut Rng, n: usize) -> Problem {
    let x: Vec<f64> = (0..n).map(|_| uniform(rng, -1.0, 2.0)).collect();
    let v: Vec<f64> = (0..n * n).map(|k| x[k / n].powi((k % n) as i32)).collect();
    let a = if rng.bool() { gram(n, n, &v, |_| 1.0) } else { v };
    with_q(rng, n, a)
}

fn graded(rng: &mut Rng, n: usize) -> Problem {
    let base = if rng.bool() { integers(rng, n) } else { positive_definite(rng, n) };
    let mut own = rng.fork();
    scaled(base, move || power_of_ten(&mut own, -150.0, 150.0))
}

fn ends(rng: &mut Rng, n: usize) -> Problem {
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

fn q_ends(rng: &mut Rng, n: usize) -> Problem {
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

fn mass_ratio(rng: &mut Rng, n: usize) -> Problem {
    let decades = uniform(rng, 0.0, 12.0);
    contacts(rng, n, decades)
}

fn degenerate(rng: &mut Rng, n: usize) -> Problem {
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

fn near_infeasible(rng: &mut Rng, n: usize) -> Problem {
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

fn tiny_angles(rng: &mut Rng, n: usize) -> Problem {
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

fn duplicates(rng: &mut Rng, n: usize) -> Problem {
    let base = contacts(rng, n, 2.0);
    let of: Vec<usize> = (0..n).map(|i| rng.usize(0..=i)).collect();
    let noise = if rng.bool() { 0.0 } else { power_of_ten(rng, -17.0, -10.0) };
    let mut shaken = |x: f64| x * (1.0 + noise * normal(rng));
    let a = (0..n * n).map(|k| shaken(base.a[of[k / n] * n + of[k % n]])).collect();
    let q = of.iter().map(|&i| shaken(base.q[i])).collect();
    Problem { n, a, q }
}

fn integers(rng: &mut Rng, n: usize) -> Problem {
    let m = rng.i32(1..=3);
    let density = uniform(rng, 0.3, 1.0);
    let a = (0..n * n).map(|_| if rng.f64() < density { f64::from(rng.i32(-m..=m)) } else { 0.0 }).collect();
    let q = (0..n).map(|_| f64::from(rng.i32(-3..=3))).collect();
    Problem { n, a, q }
}

fn integers_twos(rng: &mut Rng, n: usize) -> Problem {
    let mut base = integers(rng, n);
    let factor = 2f64.powi(rng.i32(-30..=30));
    base.q.iter_mut().for_each(|q| *q *= factor);
    let mut own = rng.fork();
    scaled(base, move || 2f64.powi(own.i32(-40..=40)))
}

fn integers_tens(rng: &mut Rng, n: usize) -> Problem {
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

fn badly_scaled(rng: &mut Rng, n: usize) -> Problem {
    let base = positive_definite(rng, n);
    let mut own = rng.fork();
    scaled(base, move || power_of_ten(&mut own, -8.0, 8.0))
}

fn special(rng: &mut Rng, n: usize) -> Problem {
    const VALUES: [f64; 15] =
        [0.0, -0.0, 1.0, -1.0, 2.0, -0.5, 5e-324, -5e-324, 1e308, -1e308, 1e-160, -1e160, 3.0, 0.1, -1e-16];
    let mut entry = || VALUES[rng.usize(0..VALUES.len())];
    let a = (0..n * n).map(|_| entry()).collect();
    let q = (0..n).map(|_| entry()).collect();
    Problem { n, a, q }
}

fn random(rng: &mut Rng, n: usize) -> Problem {
    let a = normals(rng, n * n);
    with_q(rng, n, a)
}

fn bimatrix(rng: &mut Rng, n: usize) -> Problem {
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
fn friction(rng: &mut Rng, n: usize) -> Problem {
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

fn z_matrix(rng: &mut Rng, n: usize) -> Problem {
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

fn exponential(rng: &mut Rng, n: usize) -> Problem {
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

fn blocks(rng: &mut Rng, n: usize) -> Problem {
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

fn large(rng: &mut Rng, n: usize) -> Problem {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_attack_gives_finite_problems_of_every_order() {
        for attack in ATTACKS {
            let mut rng = Rng::with_seed(1);
            for _ in 0..if attack.weight == 0 { 0 } else { 40 } {
                let n = (attack.order)(&mut rng);
                let p = (attack.problem)(&mut rng, n);
                assert_eq!((p.a.len(), p.q.len()), (p.n * p.n, p.n), "{}", attack.name);
                assert!(p.a.iter().chain(&p.q).all(|x| x.is_finite()), "{}", attack.name);
            }
        }
    }
}
