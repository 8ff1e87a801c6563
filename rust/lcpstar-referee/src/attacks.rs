//! The attacks: one generator of problems per way to mislead a solver, reproducible by its seed.

use crate::problems::{
    Problem, badly_scaled, bimatrix, blocks, condition, degenerate, duplicates, ends, exponential, friction, graded,
    hilbert, integers, integers_tens, integers_twos, large, mass_ratio, near_infeasible, normal, power_of_ten, q_ends,
    random, special, tiny_angles, uniform, vandermonde, z_matrix,
};
use fastrand::Rng;

/// A name, what it does, a share of the campaign, its orders and its generator.
#[derive(Clone, Copy)]
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
    attack("embedded", "one of the others, n <= 5, among 130 to 160 dominant sparse rows", 2, sparse, embedded),
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

fn sparse(rng: &mut Rng) -> usize {
    rng.usize(130..=160)
}

fn thousand(_: &mut Rng) -> usize {
    1000
}

/// A small problem of another attack whose rows decide alone, at a random place in a band matrix with dominant rows, some of
/// which refer to it.
fn embedded(rng: &mut Rng, n: usize) -> Problem {
    let size = rng.usize(1..=5);
    // This one and the last one do not come small.
    let attack = ATTACKS[rng.usize(0..ATTACKS.len() - 2)];
    let mut inner = (attack.problem)(rng, size);
    if inner.n > 5 {
        inner = integers_twos(rng, size);
    }
    let mut order: Vec<usize> = (0..n).collect();
    if rng.bool() {
        rng.shuffle(&mut order);
    }
    let (core, rest) = order.split_at(inner.n);
    let mut p = Problem { n, a: vec![0.0; n * n], q: vec![0.0; n] };
    for (r, &i) in core.iter().enumerate() {
        p.q[i] = inner.q[r];
        core.iter().zip(inner.row(r)).for_each(|(&j, &a)| p.a[i * n + j] = a);
    }
    let decades = if rng.bool() { 0.0 } else { uniform(rng, 0.0, 8.0) };
    let (excess, share) = (power_of_ten(rng, -6.0, 0.0), rng.f64());
    for (r, &i) in rest.iter().enumerate() {
        let factor = power_of_ten(rng, -decades, decades);
        for j in [r.wrapping_sub(1), r + 1].into_iter().filter_map(|k| rest.get(k)) {
            p.a[i * n + j] = -factor;
        }
        if !core.is_empty() && rng.u32(0..8) == 0 {
            p.a[i * n + core[rng.usize(0..core.len())]] = factor * excess * 0.5;
        }
        p.a[i * n + i] = factor * (2.0 + excess);
        p.q[i] = if rng.f64() < share { factor * normal(rng) } else { 0.0 };
    }
    p
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
