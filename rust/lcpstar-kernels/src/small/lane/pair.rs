//! Two vectors as one.

use super::{BLOCK, Lane, Mask};

/// Twice the lanes: two chains of operations for the processor to work on at once.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Pair<T>([T; 2]);

impl<X: Lane> Pair<X> {
    #[inline(always)]
    fn halves(v: &[Self]) -> &[X] {
        #[allow(unsafe_code, reason = "the layout of a transparent type")]
        // SAFETY: a pair is two vectors in memory, in order.
        let arrays: &[[X; 2]] = unsafe { std::slice::from_raw_parts(v.as_ptr().cast(), v.len()) };
        arrays.as_flattened()
    }
}

impl<X: Lane> Lane for Pair<X> {
    type Mask = Pair<X::Mask>;
    type Index = [X::Index; 2];
    const LANES: usize = 2 * X::LANES;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([X::splat(x); 2])
    }
    #[inline(always)]
    fn from_slice(x: &[f64]) -> Self {
        let (low, high) = x.split_at(x.len().min(X::LANES));
        Self([X::from_slice(low), X::from_slice(high)])
    }
    #[inline(always)]
    fn get(&self, l: usize) -> f64 {
        self.0[l / X::LANES].get(l % X::LANES)
    }
    #[inline(always)]
    fn set(&mut self, l: usize, x: f64) {
        self.0[l / X::LANES].set(l % X::LANES, x);
    }
    #[inline(always)]
    fn set_from(&mut self, l: usize, x: &Self) {
        self.0[l / X::LANES].set_from(l % X::LANES, &x.0[l / X::LANES]);
    }
    #[inline(always)]
    fn load_columns(rows: &[&[f64]], first: usize, out: &mut [Self]) {
        let mut columns = [X::splat(0.0); BLOCK];
        for h in 0..2 {
            let columns = &mut columns[..out.len()];
            X::load_columns(&rows[h * X::LANES..(h + 1) * X::LANES], first, columns);
            for (out, column) in out.iter_mut().zip(columns) {
                out.0[h] = *column;
            }
        }
    }
    #[inline(always)]
    fn store_columns(columns: &[Self], rows: &mut [f64], stride: usize) {
        let mut half = [X::splat(0.0); BLOCK];
        for h in 0..2 {
            for (half, column) in half.iter_mut().zip(columns) {
                *half = column.0[h];
            }
            X::store_columns(&half[..columns.len()], &mut rows[h * X::LANES * stride..], stride);
        }
    }
    #[inline(always)]
    fn index(self, limit: usize, stride: usize) -> Self::Index {
        [self.0[0].index(limit, 2 * stride), self.0[1].index(limit, 2 * stride)]
    }
    #[inline(always)]
    fn pick(v: &[Self], at: Self::Index) -> Self {
        let halves = Self::halves(v);
        Self([X::pick(halves, at[0]), X::pick(&halves[1..], at[1])])
    }
    #[inline(always)]
    fn sum(self) -> f64 {
        self.0[0].add(self.0[1]).sum()
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        self.0[0].max(self.0[1]).largest()
    }
    #[inline(always)]
    fn smallest(self) -> f64 {
        self.0[0].min(self.0[1]).smallest()
    }
    #[inline(always)]
    fn add(self, x: Self) -> Self {
        Self([self.0[0].add(x.0[0]), self.0[1].add(x.0[1])])
    }
    #[inline(always)]
    fn sub(self, x: Self) -> Self {
        Self([self.0[0].sub(x.0[0]), self.0[1].sub(x.0[1])])
    }
    #[inline(always)]
    fn mul(self, x: Self) -> Self {
        Self([self.0[0].mul(x.0[0]), self.0[1].mul(x.0[1])])
    }
    #[inline(always)]
    fn div(self, x: Self) -> Self {
        Self([self.0[0].div(x.0[0]), self.0[1].div(x.0[1])])
    }
    #[inline(always)]
    fn add_product(self, a: Self, b: Self) -> Self {
        Self([self.0[0].add_product(a.0[0], b.0[0]), self.0[1].add_product(a.0[1], b.0[1])])
    }
    #[inline(always)]
    fn sub_product(self, a: Self, b: Self) -> Self {
        Self([self.0[0].sub_product(a.0[0], b.0[0]), self.0[1].sub_product(a.0[1], b.0[1])])
    }
    #[inline(always)]
    fn exponent(self) -> Self {
        Self([self.0[0].exponent(), self.0[1].exponent()])
    }
    #[inline(always)]
    fn truncated(self) -> Self {
        Self([self.0[0].truncated(), self.0[1].truncated()])
    }
    #[inline(always)]
    fn two_to(self) -> Self {
        Self([self.0[0].two_to(), self.0[1].two_to()])
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self([self.0[0].abs(), self.0[1].abs()])
    }
    #[inline(always)]
    fn neg(self) -> Self {
        Self([self.0[0].neg(), self.0[1].neg()])
    }
    #[inline(always)]
    fn max(self, x: Self) -> Self {
        Self([self.0[0].max(x.0[0]), self.0[1].max(x.0[1])])
    }
    #[inline(always)]
    fn min(self, x: Self) -> Self {
        Self([self.0[0].min(x.0[0]), self.0[1].min(x.0[1])])
    }
    #[inline(always)]
    fn lt(self, x: Self) -> Self::Mask {
        Pair([self.0[0].lt(x.0[0]), self.0[1].lt(x.0[1])])
    }
    #[inline(always)]
    fn le(self, x: Self) -> Self::Mask {
        Pair([self.0[0].le(x.0[0]), self.0[1].le(x.0[1])])
    }
    #[inline(always)]
    fn eq(self, x: Self) -> Self::Mask {
        Pair([self.0[0].eq(x.0[0]), self.0[1].eq(x.0[1])])
    }
    #[inline(always)]
    fn only(self, mask: Self::Mask) -> Self {
        Self([self.0[0].only(mask.0[0]), self.0[1].only(mask.0[1])])
    }
    #[inline(always)]
    fn or_else(self, mask: Self::Mask, x: Self) -> Self {
        Self([self.0[0].or_else(mask.0[0], x.0[0]), self.0[1].or_else(mask.0[1], x.0[1])])
    }
}

impl<M: Mask> Mask for Pair<M> {
    const LANES: usize = 2 * M::LANES;
    const NONE: Self = Self([M::NONE; 2]);
    const ALL: Self = Self([M::ALL; 2]);

    #[inline(always)]
    fn get(&self, l: usize) -> bool {
        self.0[l / M::LANES].get(l % M::LANES)
    }
    #[inline(always)]
    fn set(&mut self, l: usize, yes: bool) {
        self.0[l / M::LANES].set(l % M::LANES, yes);
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self([M::from_bits(bits), M::from_bits(bits >> M::LANES)])
    }
    #[inline(always)]
    fn and(self, x: Self) -> Self {
        Self([self.0[0].and(x.0[0]), self.0[1].and(x.0[1])])
    }
    #[inline(always)]
    fn or(self, x: Self) -> Self {
        Self([self.0[0].or(x.0[0]), self.0[1].or(x.0[1])])
    }
    #[inline(always)]
    fn xor(self, x: Self) -> Self {
        Self([self.0[0].xor(x.0[0]), self.0[1].xor(x.0[1])])
    }
    #[inline(always)]
    fn not(self) -> Self {
        Self([self.0[0].not(), self.0[1].not()])
    }
    #[inline(always)]
    fn choose(self, yes: Self, no: Self) -> Self {
        Self([self.0[0].choose(yes.0[0], no.0[0]), self.0[1].choose(yes.0[1], no.0[1])])
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0[0].or(self.0[1]).any()
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0[0].bits() | self.0[1].bits() << M::LANES
    }
}
