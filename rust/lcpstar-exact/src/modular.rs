//! Arithmetic and elimination modulo a prime just below 2^59, in machine words.

/// The prime `2^59 - c`.
#[derive(Clone, Copy, Debug)]
pub struct Prime {
    c: u64,
}

const BITS: u32 = 59;
const MASK: u64 = (1 << BITS) - 1;

/// The three largest primes below 2^59.
pub const PRIMES: [Prime; 3] = [Prime { c: 55 }, Prime { c: 99 }, Prime { c: 225 }];

impl Prime {
    /// The prime itself.
    #[must_use]
    pub fn value(self) -> u64 {
        (1 << BITS) - self.c
    }

    /// `x mod p`: two folds of `2^59 = c`.
    #[inline]
    #[must_use]
    pub fn reduce(self, x: u128) -> u64 {
        let folded = (x as u64 & MASK) as u128 + (x >> BITS) * u128::from(self.c);
        let r = (folded as u64 & MASK) + (folded >> BITS) as u64 * self.c;
        let p = self.value();
        let r = if r >= p { r - p } else { r };
        if r >= p { r - p } else { r }
    }

    /// `x mod p` in `0..p` for signed `x`.
    #[inline]
    #[must_use]
    pub fn reduce_signed(self, x: i128) -> u64 {
        let r = self.reduce(x.unsigned_abs());
        if x < 0 { self.negate(r) } else { r }
    }

    /// `-x`.
    #[inline]
    #[must_use]
    pub fn negate(self, x: u64) -> u64 {
        if x == 0 { 0 } else { self.value() - x }
    }

    /// `x y`.
    #[inline]
    #[must_use]
    pub fn mul(self, x: u64, y: u64) -> u64 {
        self.reduce(u128::from(x) * u128::from(y))
    }

    /// `x - y`.
    #[inline]
    #[must_use]
    pub fn sub(self, x: u64, y: u64) -> u64 {
        if x >= y { x - y } else { x + self.value() - y }
    }

    /// `base^exponent`.
    #[must_use]
    pub fn pow(self, mut base: u64, mut exponent: u64) -> u64 {
        let mut result = 1;
        while exponent > 0 {
            if exponent & 1 == 1 {
                result = self.mul(result, base);
            }
            base = self.mul(base, base);
            exponent >>= 1;
        }
        result
    }

    /// `1/x` for `x != 0` (Fermat).
    #[must_use]
    pub fn inverse(self, x: u64) -> u64 {
        self.pow(x, self.value() - 2)
    }

    /// `sum a_i b_i`, reduced once in 256 terms.
    #[inline]
    #[must_use]
    pub fn dot(self, a: &[u64], b: &[u64]) -> u64 {
        let mut carried = 0u64;
        for (a, b) in a.chunks(256).zip(b.chunks(256)) {
            let sum: u128 = a.iter().zip(b).map(|(&x, &y)| u128::from(x) * u128::from(y)).sum();
            carried = self.reduce(sum + u128::from(carried));
        }
        carried
    }
}

/// LU factors of a nonsingular matrix modulo `p`, rows permuted.
#[derive(Clone, Debug)]
pub struct ModularLu {
    prime: Prime,
    order: usize,
    lu: Vec<u64>,
    rows: Vec<usize>,
    inverse_diagonal: Vec<u64>,
}

impl ModularLu {
    /// Factors the row-major `a`; `None` when it is singular modulo `p`, or told to stop. k^3 / 3.
    #[must_use]
    pub fn new(prime: Prime, order: usize, mut a: Vec<u64>, stop: &dyn Fn() -> bool) -> Option<Self> {
        let mut rows: Vec<usize> = (0..order).collect();
        let mut inverse_diagonal = Vec::with_capacity(order);
        for k in 0..order {
            let pivot = (k..order).find(|&i| a[i * order + k] != 0).filter(|_| !stop())?;
            if pivot != k {
                rows.swap(k, pivot);
                let (upper, lower) = a.split_at_mut(pivot * order);
                upper[k * order..(k + 1) * order].swap_with_slice(&mut lower[..order]);
            }
            let inverse = prime.inverse(a[k * order + k]);
            inverse_diagonal.push(inverse);
            let (upper, lower) = a.split_at_mut((k + 1) * order);
            let pivot_row = &upper[k * order + k + 1..];
            for row in lower.chunks_exact_mut(order) {
                if row[k] != 0 {
                    let factor = prime.mul(row[k], inverse);
                    row[k] = factor;
                    subtract_multiple(prime, &mut row[k + 1..], factor, pivot_row);
                }
            }
        }
        Some(Self { prime, order, lu: a, rows, inverse_diagonal })
    }

    /// Solves for `b`, overwriting `x`. k^2.
    pub fn solve(&self, b: &[u64], x: &mut [u64]) {
        let (p, k) = (self.prime, self.order);
        for i in 0..k {
            let known = p.dot(&self.lu[i * k..i * k + i], &x[..i]);
            x[i] = p.sub(b[self.rows[i]], known);
        }
        for i in (0..k).rev() {
            let known = p.dot(&self.lu[i * k + i + 1..(i + 1) * k], &x[i + 1..]);
            x[i] = p.mul(p.sub(x[i], known), self.inverse_diagonal[i]);
        }
    }
}

fn subtract_multiple(prime: Prime, row: &mut [u64], factor: u64, pivot_row: &[u64]) {
    let minus = u128::from(prime.negate(factor));
    for (x, &y) in row.iter_mut().zip(pivot_row) {
        *x = prime.reduce(u128::from(*x) + minus * u128::from(y));
    }
}

/// Rows and columns of a nonsingular submatrix of full rank modulo `p` (row-major `a`).
///
/// Rows are taken in order, for each the first column of `preference` that still has a nonzero entry; those found so far when
/// `stop` says so.
#[must_use]
pub fn independent(
    prime: Prime,
    columns: usize,
    mut a: Vec<u64>,
    preference: &[usize],
    stop: &dyn Fn() -> bool,
) -> (Vec<usize>, Vec<usize>) {
    let m = a.len().checked_div(columns).unwrap_or(0);
    let (mut basis_rows, mut basis_columns) = (Vec::new(), Vec::new());
    for i in (0..m).take_while(|_| !stop()) {
        let Some(&column) = preference.iter().find(|&&j| a[i * columns + j] != 0) else {
            continue;
        };
        basis_rows.push(i);
        basis_columns.push(column);
        let (upper, lower) = a.split_at_mut((i + 1) * columns);
        let pivot_row = &upper[i * columns..];
        let inverse = prime.inverse(pivot_row[column]);
        for row in lower.chunks_exact_mut(columns) {
            if row[column] != 0 {
                let factor = prime.mul(row[column], inverse);
                subtract_multiple(prime, row, factor, pivot_row);
            }
        }
    }
    (basis_rows, basis_columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduction_agrees_with_division() {
        let mut x: u128 = 0x1234_5678_9abc_def0_1357_9bdf_0246_8ace;
        for prime in PRIMES {
            for _ in 0..1000 {
                x = x.wrapping_mul(0xda94_2042_e4dd_58b5_2545_f491_4f6c_dd1d).wrapping_add(99);
                assert_eq!(u128::from(prime.reduce(x >> 1)), (x >> 1) % u128::from(prime.value()));
            }
            assert_eq!(prime.reduce(u128::from(prime.value())), 0);
            assert_eq!(prime.mul(prime.inverse(12345), 12345), 1);
        }
    }

    #[test]
    fn a_dependent_row_and_a_dependent_column_are_left_out() {
        let a = vec![1, 2, 3, 2, 4, 6, 0, 1, 1];
        assert_eq!(independent(PRIMES[0], 3, a, &[2, 1, 0], &|| false), (vec![0, 2], vec![2, 1]));
    }
}
