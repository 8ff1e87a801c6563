//! Classes of small integer matrices.

use crate::calls::LIMIT;
use crate::input::Bytes;
use crate::show::show;
use lcpstar::classes::budget::Budget;
use lcpstar::classes::class::{Class, Facts, SYMBOLS};
use lcpstar::exact::imatrix::IMatrix;
use lcpstar::exact::int::Int;
use std::time::Instant;

/// Class memberships of a small integer matrix: inclusions, transposition, permutation.
pub fn classes(bytes: &mut Bytes<'_>) {
    let n = 1 + bytes.below(4);
    let wide = bytes.below(4) == 3;
    let entries: Vec<i64> = (0..n * n)
        .map(|_| {
            i64::from(bytes.byte() as i8) * if wide { 1_000_000_007_000_003 } else { 1 } / if wide { 1 } else { 32 }
        })
        .collect();
    let matrix = |at: &dyn Fn(usize, usize) -> (usize, usize)| {
        IMatrix::from_fn(n, n, |i, j| {
            let (i, j) = at(i, j);
            Int::from(entries[i * n + j])
        })
    };
    show(&entries);
    let stop = Instant::now() + LIMIT;
    let budget = Budget::new(Some(stop), None);
    let plain = Facts::new(matrix(&|i, j| (i, j)));
    let flipped = Facts::new(matrix(&|i, j| (n - 1 - i, n - 1 - j)));
    let transposed = Facts::new(matrix(&|i, j| (j, i)));
    let chosen: Vec<Class> = (0..6).map(|_| SYMBOLS[bytes.below(SYMBOLS.len())].1).collect();
    let holds = |facts: &Facts, class| facts.holds(class, &budget);
    for class in chosen {
        let (Ok(here), Ok(there)) = (holds(&plain, class), holds(&flipped, class)) else { return };
        assert_eq!(here, there, "{class:?} changes under a permutation: {entries:?}");
        if matches!(
            class,
            Class::P | Class::P0 | Class::PSD | Class::PD | Class::C0 | Class::C | Class::N | Class::SU | Class::E
        ) {
            let Ok(there) = holds(&transposed, class) else { return };
            assert_eq!(here, there, "{class:?} changes under transposition: {entries:?}");
        }
        if here {
            for &(small, large) in INCLUSIONS.iter().filter(|(small, _)| *small == class) {
                let Ok(large_holds) = holds(&plain, large) else { return };
                assert!(large_holds, "{small:?} without {large:?}: {entries:?}");
            }
        }
    }
    two_by_two(n, &entries, &plain, &budget);
}

/// Inclusions of the literature [CPS92].
const INCLUSIONS: [(Class, Class); 27] = [
    (Class::PD, Class::PSD),
    (Class::PD, Class::P),
    (Class::PD, Class::C),
    (Class::PSD, Class::SU),
    (Class::PSD, Class::C0Plus),
    (Class::PSD, Class::P0),
    (Class::SU, Class::P0),
    (Class::SU, Class::Q0),
    (Class::RSU, Class::Q0),
    (Class::CSU, Class::P0),
    (Class::P, Class::P0),
    (Class::P, Class::SU),
    (Class::P, Class::E),
    (Class::P, Class::Q),
    (Class::P, Class::R0),
    (Class::P0, Class::E0),
    (Class::C, Class::C0),
    (Class::C, Class::E),
    (Class::C0, Class::E0),
    (Class::C0Plus, Class::C0),
    (Class::C0Plus, Class::L),
    (Class::E, Class::E0),
    (Class::E, Class::Q),
    (Class::L, Class::Q0),
    (Class::Q, Class::Q0),
    (Class::Z, Class::Q0),
    (Class::TE0s, Class::E0),
];

/// P and P0 of order 2 by hand, in 128 bits.
fn two_by_two(n: usize, entries: &[i64], facts: &Facts, budget: &Budget<'_>) {
    if n != 2 {
        return;
    }
    let x: Vec<i128> = entries.iter().map(|&x| x.into()).collect();
    let least = x[0].min(x[3]).min(x[0] * x[3] - x[1] * x[2]);
    assert_eq!(facts.holds(Class::P, budget), Ok(least > 0));
    assert_eq!(facts.holds(Class::P0, budget), Ok(least >= 0));
}
