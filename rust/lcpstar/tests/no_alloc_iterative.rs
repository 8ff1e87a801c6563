//! The loops of the approximate methods do not allocate: more iterations, the same number of allocations.

mod counting;

use counting::ALLOCATIONS;
use lcpstar::iterative::{Dense, Goal};
use lcpstar::methods::{admm, apgd, nncg, pgs};
use lcpstar::{Candidate, Control, Lcp, Termination};
use std::sync::atomic::Ordering;

/// A chain of 60, or the same with a skew part: hundreds of iterations for every method.
fn chain(skew: f64) -> Lcp {
    let n = 60;
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 1.0,
        1 => {
            if i < j {
                skew - 0.5
            } else {
                -skew - 0.5
            }
        }
        _ => 0.0,
    };
    let q = (0..n).map(|i| if i % 7 == 0 { -0.5 } else { 0.05 }).collect();
    Lcp::new(n, (0..n * n).map(|k| entry(k / n, k % n)).collect(), q).expect("valid")
}

#[test]
fn iterations_scale_and_allocations_do_not() {
    type Run = fn(&Dense<'_>, &Goal, &Control<'_>) -> Candidate;
    let methods: [(&str, Run); 4] = [
        ("pgs", |m, g, c| pgs::pgs(m, g, &pgs::Settings::default(), None, c)),
        ("nncg", |m, g, c| nncg::nncg(m, g, None, c)),
        ("apgd", |m, g, c| apgd::apgd(m, g, None, c)),
        ("admm", |m, g, c| admm::admm(m, g, &admm::Settings { polish: false, ..Default::default() }, None, c)),
    ];
    for skew in [0.0, 0.3] {
        let lcp = chain(skew);
        let (matrix, goal) = (Dense::new(&lcp), Goal::plain(1e-15, lcp.q()));
        for (name, method) in methods {
            let run = |limit| {
                let control = Control { max_iterations: Some(limit), ..Control::default() };
                let before = ALLOCATIONS.load(Ordering::Relaxed);
                let found = method(&matrix, &goal, &control);
                (found.iterations, ALLOCATIONS.load(Ordering::Relaxed) - before, found.termination)
            };
            let (few, many) = (run(1), run(30));
            assert_eq!(many.2, Termination::IterationLimit, "{name} {skew}");
            assert_eq!((few.0, many.0), (1, 30), "{name} {skew}");
            assert!(few.1 > 0, "the counter counts");
            assert!(many.1 <= few.1 + 2, "{name} {skew}: {} allocations for 1 iteration, {} for 30", few.1, many.1);
        }
    }
}
