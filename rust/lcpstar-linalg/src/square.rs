//! A borrowed square matrix.

/// `A`, row-major, of order `n`.
#[derive(Clone, Copy, Debug)]
pub struct Square<'a> {
    /// Order.
    pub n: usize,
    /// `n * n` entries.
    pub entries: &'a [f64],
}

impl<'a> Square<'a> {
    /// Row `i`.
    #[must_use]
    pub fn row(&self, i: usize) -> &'a [f64] {
        &self.entries[i * self.n..(i + 1) * self.n]
    }
}
