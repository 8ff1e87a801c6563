//! The problem that is proved, on the caller's numbers.

/// LCP(q, A): find `z` with `w = A z + q >= 0`, `z >= 0`, `z'w = 0`. Borrows `A`, row-major, and `q`; all numbers are finite.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    a: &'a [f64],
    q: &'a [f64],
}

impl<'a> Problem<'a> {
    /// The problem with row-major `A` of the order of `q`.
    #[must_use]
    pub fn new(a: &'a [f64], q: &'a [f64]) -> Self {
        debug_assert!(a.len() == q.len() * q.len());
        Self { a, q }
    }

    /// Order of the problem.
    #[must_use]
    pub fn n(&self) -> usize {
        self.q.len()
    }

    /// Row `i` of `A`.
    #[must_use]
    pub fn row(&self, i: usize) -> &'a [f64] {
        &self.a[i * self.q.len()..(i + 1) * self.q.len()]
    }

    /// `q`.
    #[must_use]
    pub fn q(&self) -> &'a [f64] {
        self.q
    }
}
