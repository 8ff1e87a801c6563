//! Places in memory, one for each lane.

/// One place in memory for each of `L` lanes, all in the first `span` vectors.
#[derive(Clone, Copy, Debug)]
pub struct Places<const L: usize> {
    pub(super) numbers: [u32; L],
    pub(super) span: usize,
}

impl<const L: usize> Places<L> {
    /// Lane l of vector `stride * vectors[l]`.
    #[inline(always)]
    pub(super) fn new(vectors: [u32; L], limit: usize, stride: usize) -> Self {
        let mut numbers = vectors;
        for (l, number) in numbers.iter_mut().enumerate() {
            *number = *number * (L * stride) as u32 + l as u32;
        }
        Self { numbers, span: (limit - 1) * stride + 1 }
    }
}
