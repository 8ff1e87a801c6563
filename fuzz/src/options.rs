//! Fuzzed options.

use crate::input::{Bytes, Taste};
use lcpstar::driver::{Approximate, Method};
use lcpstar::methods::potential_reduction::{DirectionSolver, Stop};
use lcpstar::methods::{
    admm, bilinear, block_pivoting, interior_point, lemke, lemke_howson, newton, pgs, pgs_sm, potential_reduction,
};

/// In range, or any double.
pub fn tolerance(bytes: &mut Bytes<'_>) -> f64 {
    match bytes.byte() {
        b @ 0..=127 => [1e-9, 1e-6, 1e-3, 1e-12, 0.5, 1e-15, 1e-2, 1e-20][usize::from(b) % 8],
        128..=191 => bytes.raw().abs(),
        _ => bytes.raw(),
    }
}

/// Nothing, a plausible guess, or anything.
pub fn guess(bytes: &mut Bytes<'_>, n: usize) -> Option<Vec<f64>> {
    match bytes.below(6) {
        0..=2 => None,
        3 => Some((0..n).map(|_| bytes.number(Taste::Integers).max(0.0)).collect()),
        4 => Some((0..n).map(|_| bytes.number(Taste::Wild).abs()).collect()),
        _ => Some((0..bytes.below(8)).map(|_| bytes.raw()).collect()),
    }
}

/// With its default options, or with others.
pub fn method(bytes: &mut Bytes<'_>, n: usize) -> Method {
    let name = Method::NAMES[bytes.below(Method::NAMES.len())];
    let method = Method::from_name(name).expect("a listed name");
    if !bytes.flag() {
        return method;
    }
    match method {
        Method::Lemke { .. } => {
            let d = bytes.flag().then(|| (0..n).map(|_| bytes.number(Taste::Wild).abs()).collect());
            Method::Lemke { settings: lemke::Settings { d }, restarts: bytes.below(9), seed: u64::from(bytes.byte()) }
        }
        Method::LemkeHowson(_) => Method::LemkeHowson(lemke_howson::Settings { label: bytes.below(42) }),
        Method::Bilinear(_) => {
            Method::Bilinear(bilinear::Settings { starts: bytes.below(9), seed: u64::from(bytes.byte()) })
        }
        Method::BlockPivoting(_) => {
            let alpha = bytes.flag().then(|| (0..bytes.below(8)).map(|_| bytes.below(42)).collect());
            let patience = bytes.below(9);
            let shift = if bytes.flag() { 1e-10 } else { 0.0 };
            Method::BlockPivoting(block_pivoting::Settings { patience, alpha, murty: bytes.flag(), shift })
        }
        Method::InteriorPoint(_) => Method::InteriorPoint(interior_point::Settings {
            finish: bytes.flag(),
            ..interior_point::Settings::default()
        }),
        Method::PotentialReduction(_) => Method::PotentialReduction(potential(bytes)),
        Method::Approximate(method) => Method::Approximate(approximate(bytes, method)),
        other => other,
    }
}

/// Relaxation factors in and out of range, counts from 0.
fn approximate(bytes: &mut Bytes<'_>, method: Approximate) -> Approximate {
    let relaxation = match bytes.byte() {
        b @ 0..=250 => f64::from(b) / 120.0,
        _ => bytes.raw(),
    };
    match method {
        Approximate::Pgs(_) => Approximate::Pgs(pgs::Settings { relaxation, symmetric: bytes.flag() }),
        Approximate::PgsSm(_) => {
            Approximate::PgsSm(pgs_sm::Settings { sweeps: bytes.below(9), solves: bytes.below(6), relaxation })
        }
        Approximate::Admm(_) => {
            let rho = if bytes.flag() { bytes.raw() } else { 2f64.powi(i32::from(bytes.byte() as i8) / 8) };
            Approximate::Admm(admm::Settings { rho, relaxation, polish: bytes.flag() })
        }
        Approximate::Newton(_) => Approximate::Newton(newton::Settings { patience: bytes.below(6) }),
        other => other,
    }
}

/// The paper's parameters: sensible ones or any double.
pub fn potential(bytes: &mut Bytes<'_>) -> potential_reduction::Settings {
    let mut unit = |usual: f64| match bytes.byte() {
        0..=127 => usual,
        b @ 128..=250 => f64::from(b) / 256.0 - 0.4,
        _ => bytes.raw(),
    };
    let (beta, gamma, sigma, kappa_factor) = (unit(0.5), unit(0.5), unit(0.2), unit(0.01) + 1.0);
    potential_reduction::Settings {
        beta,
        gamma,
        sigma,
        kappa_factor,
        min_halvings: bytes.below(70),
        direction: if bytes.flag() { DirectionSolver::Qr } else { DirectionSolver::Cholesky },
        long_step: bytes.flag(),
        stop: Stop::Gap(1e-5),
    }
}
