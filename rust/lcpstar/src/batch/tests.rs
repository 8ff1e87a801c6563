//! One wheel for every machine: whole batches on every kind of lane that this one has.

use super::alone::Alone;
use super::schedule::solve_batch;
use super::{Alpha, Guess, Numbers, Output, Problems, Settings, Source};
use crate::driver::Method;
use crate::small::lane::{F64x8, Lane, Pair};
use crate::status::Status;
use lcpstar_kernels::batch::task::{ENUMERATE, LEMKE, NEWTON};
use lcpstar_kernels::batch::work::{Chunk, run};
use std::collections::HashSet;
use std::sync::{Mutex, PoisonError};
use std::thread::ThreadId;

/// Everything that a batch writes.
#[derive(Clone, Debug, PartialEq)]
struct Results {
    z: Vec<f64>,
    w: Vec<f64>,
    status: Vec<u8>,
    method: Vec<u8>,
    iterations: Vec<u32>,
    residual: Vec<f64>,
    natural_residual: Vec<f64>,
    alpha: Vec<u64>,
}

impl Results {
    fn new(n: usize, count: usize) -> Self {
        Self {
            z: vec![f64::NAN; n * count],
            w: vec![f64::NAN; n * count],
            status: vec![u8::MAX; count],
            method: vec![u8::MAX; count],
            iterations: vec![u32::MAX; count],
            residual: vec![f64::NAN; count],
            natural_residual: vec![f64::NAN; count],
            alpha: vec![u64::MAX; count],
        }
    }

    fn output(&mut self) -> Output<'_> {
        Output {
            z: &mut self.z,
            w: &mut self.w,
            status: &mut self.status,
            method: &mut self.method,
            iterations: &mut self.iterations,
            residual: &mut self.residual,
            natural_residual: &mut self.natural_residual,
            alpha: Alpha::Masks(&mut self.alpha),
        }
    }
}

/// A batch of order n.
#[derive(Clone, Copy)]
struct Batch<'a> {
    n: usize,
    a: Numbers<'a>,
    q: Numbers<'a>,
    guess: Guess<'a>,
}

/// `B B'` of half or full rank, some plus a skew part, and a `q` for which the symmetric ones have a solution.
fn problems(n: usize, count: usize) -> (Vec<f64>, Vec<f64>) {
    let mut random = fastrand::Rng::with_seed(n as u64);
    let (mut a, mut q) = (Vec::new(), Vec::new());
    for k in 0..count {
        let rank = if k % 2 == 0 { n.div_ceil(2) } else { n };
        let b: Vec<f64> = (0..n * rank).map(|_| random.f64() - 0.5).collect();
        let x: Vec<f64> = (0..n).map(|_| random.f64() - 0.5).collect();
        let at = |i: usize, j: usize| {
            let skew = if k % 4 == 1 { (i as f64 - j as f64) / n as f64 } else { 0.0 };
            (0..rank).map(|l| b[i * rank + l] * b[j * rank + l]).sum::<f64>() + skew
        };
        q.extend((0..n).map(|i| (-x[i]).max(0.0) - (0..n).map(|j| at(i, j) * x[j].max(0.0)).sum::<f64>()));
        a.extend((0..n * n).map(|e| at(e / n, e % n)));
    }
    (a, q)
}

fn solved_by<X: Lane, const N: usize>(batch: Batch<'_>, count: usize) -> Results {
    let problems =
        Problems { n: batch.n, count, a: batch.a, a_source: Source::Each, q: batch.q, q_source: Source::Each };
    let settings = Settings { method: &Method::Auto, tol: 1e-9, threads: 1, guess: batch.guess, interrupted: None };
    let mut results = Results::new(batch.n, count);
    let chunk = Mutex::new(Some(Chunk { first: 0, output: results.output() }));
    let next = || chunk.lock().unwrap_or_else(PoisonError::into_inner).take();
    let mut alone = Alone::new(&problems, &settings);
    run::<X, N>(&problems, &settings.asked(), &next, &mut |chunk, waiting| {
        alone.solve(chunk, waiting).expect("finite numbers");
        true
    });
    results
}

/// What plain loops find is what every other kind of lane must find, bit by bit.
fn assert_same_on_every_kind(batch: Batch<'_>, count: usize, what: &str) -> Results {
    let expected = solved_by::<F64x8<true>, 0>(batch, count);
    let n = batch.n;
    assert!(expected == solved_by::<Pair<F64x8<true>>, 0>(batch, count), "{what}, n = {n}, pairs");
    #[cfg(target_arch = "x86_64")]
    {
        use crate::small::avx::{Ymm2, Zmm};
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            assert!(expected == solved_by::<Ymm2, 0>(batch, count), "{what}, n = {n}, AVX2");
        }
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            assert!(expected == solved_by::<Zmm, 0>(batch, count), "{what}, n = {n}, AVX-512");
            assert!(expected == solved_by::<Pair<Zmm>, 0>(batch, count), "{what}, n = {n}, pairs of AVX-512");
        }
    }
    expected
}

#[test]
fn every_kind_of_lane_finds_the_same_bits() {
    const COUNT: usize = 49;
    let mut methods = [0; 256];
    for n in (1..=17).chain([21, 24, 25, 32, 33]) {
        let (a, q) = problems(n, COUNT);
        let cold = Batch { n, a: Numbers::Double(&a), q: Numbers::Double(&q), guess: Guess::None };
        let found = assert_same_on_every_kind(cold, COUNT, "cold");
        found.method.iter().for_each(|&method| methods[usize::from(method)] += 1);
        for (k, (z, w)) in found.z.chunks(n).zip(found.w.chunks(n)).enumerate() {
            if found.status[k] != Status::Solved as u8 {
                continue;
            }
            let scale = 1.0 + z.iter().sum::<f64>();
            for i in 0..n {
                let row = &a[(k * n + i) * n..][..n];
                let exact = row.iter().zip(z).map(|(a, z)| a * z).sum::<f64>() + q[k * n + i];
                assert!(
                    (exact - w[i]).abs() <= 1e-13 * scale * n as f64,
                    "n = {n}, problem {k}, row {i}: {exact}, {}",
                    w[i]
                );
            }
        }
        let near: Vec<u64> = found.alpha.iter().enumerate().map(|(k, mask)| mask ^ u64::from(k % 5 == 0)).collect();
        assert_same_on_every_kind(Batch { guess: Guess::Masks(&near), ..cold }, COUNT, "masks");
        assert_same_on_every_kind(Batch { guess: Guess::Points(&found.z), ..cold }, COUNT, "points");
        let single: Vec<f32> = a.iter().map(|&x| x as f32).collect();
        let vector: Vec<f32> = q.iter().map(|&x| x as f32).collect();
        let narrow = Batch { a: Numbers::Single(&single), q: Numbers::Single(&vector), ..cold };
        let narrow = assert_same_on_every_kind(narrow, COUNT, "single precision");
        let (a, q): (Vec<f64>, Vec<f64>) =
            (single.iter().map(|&x| x.into()).collect(), vector.iter().map(|&x| x.into()).collect());
        let wide = Batch { a: Numbers::Double(&a), q: Numbers::Double(&q), ..cold };
        assert_eq!(narrow, solved_by::<F64x8<true>, 0>(wide, COUNT), "widened, n = {n}");
    }
    for method in [NEWTON, LEMKE, ENUMERATE] {
        assert!(methods[usize::from(method)] > 100, "{methods:?}");
    }
}

/// The threads on which a batch of so many problems of order 8 was solved, by as many as there are cores.
fn threads_of_a_batch(count: usize) -> HashSet<ThreadId> {
    let (a, q) = problems(8, count);
    let problems = Problems {
        n: 8,
        count,
        a: Numbers::Double(&a),
        a_source: Source::Each,
        q: Numbers::Double(&q),
        q_source: Source::Each,
    };
    let seen = Mutex::new(HashSet::new());
    let note = || {
        seen.lock().unwrap_or_else(PoisonError::into_inner).insert(std::thread::current().id());
        false
    };
    let settings =
        Settings { method: &Method::Auto, tol: 1e-9, threads: 0, guess: Guess::None, interrupted: Some(&note) };
    assert!(solve_batch(&problems, &settings, Results::new(8, count).output()).expect("finite numbers"));
    seen.into_inner().unwrap_or_else(PoisonError::into_inner)
}

#[test]
fn a_small_batch_stays_on_its_thread() {
    assert_eq!(threads_of_a_batch(200), HashSet::from([std::thread::current().id()]));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    assert_eq!(threads_of_a_batch(20_000).len() > 1, cores > 1);
}
