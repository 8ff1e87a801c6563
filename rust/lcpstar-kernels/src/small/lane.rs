//! One number of each of several problems: the vectors that the lane kernels compute with.
//!
//! Plain arrays in plain loops. The kernels are inlined into functions compiled once per instruction set, where every
//! operation below becomes one or two vector instructions. Lanes never mix, so a problem's bits do not depend on its
//! neighbours; `FUSED` says whether `a b + c` is rounded once, so bits depend on the machine only through that.

mod array;
mod pair;

pub use array::F64x8;
pub use pair::Pair;

/// Columns that [`Lane::load_columns`] and [`Lane::store_columns`] move at a time.
pub const BLOCK: usize = 8;

/// Most lanes of any kind.
pub const MOST_LANES: usize = 16;

/// Lanes of doubles with the operations of the kernels.
pub trait Lane: Copy {
    /// One yes or no per lane.
    type Mask: Mask;
    /// One place in a slice per lane.
    type Index: Copy;
    /// Problems solved side by side.
    const LANES: usize;

    /// The same number in every lane.
    fn splat(x: f64) -> Self;
    /// The first numbers of `x`, then zeros.
    fn from_slice(x: &[f64]) -> Self;
    /// Lane `l`.
    fn get(&self, l: usize) -> f64;
    /// Sets lane `l`.
    fn set(&mut self, l: usize, x: f64);
    /// Sets lane `l` to that of `x`.
    fn set_from(&mut self, l: usize, x: &Self);
    /// Lane l of `out[k]` is `rows[l][first + k]`, for at most `BLOCK` columns k.
    fn load_columns(rows: &[&[f64]], first: usize, out: &mut [Self]);
    /// `rows[l stride + k]` is lane l of `columns[k]`, for at most `BLOCK` columns k; the rest of `BLOCK` numbers, from
    /// `l stride` on, is overwritten too, lane after lane.
    fn store_columns(columns: &[Self], rows: &mut [f64], stride: usize);
    /// `stride` times each lane's number, which is a place below `limit`; others are moved into that range.
    fn index(self, limit: usize, stride: usize) -> Self::Index;
    /// Lane l of `v[at_l]`.
    fn pick(v: &[Self], at: Self::Index) -> Self;
    /// The sum of the lanes: upper half added to lower half, again and again.
    fn sum(self) -> f64;
    /// The largest lane; no lane is NaN.
    fn largest(self) -> f64;
    /// The smallest lane; no lane is NaN.
    fn smallest(self) -> f64;
    /// `self + x`.
    fn add(self, x: Self) -> Self;
    /// `self - x`.
    fn sub(self, x: Self) -> Self;
    /// `self * x`.
    fn mul(self, x: Self) -> Self;
    /// `self / x`.
    fn div(self, x: Self) -> Self;
    /// `a b + self`.
    fn add_product(self, a: Self, b: Self) -> Self;
    /// `self - a b`.
    fn sub_product(self, a: Self, b: Self) -> Self;
    /// The e with `2^(e-1) <= |x| < 2^e`, for normal numbers.
    fn exponent(self) -> Self;
    /// Each number rounded towards zero.
    fn truncated(self) -> Self;
    /// `2^x` for integers of at most 1000 in size.
    fn two_to(self) -> Self;
    /// `|self|`.
    fn abs(self) -> Self;
    /// `-self`.
    fn neg(self) -> Self;
    /// The larger; `x` where `self` is NaN.
    fn max(self, x: Self) -> Self;
    /// The smaller; `x` where `self` is NaN.
    fn min(self, x: Self) -> Self;
    /// `self < x`; false where either is NaN.
    fn lt(self, x: Self) -> Self::Mask;
    /// `self <= x`; false where either is NaN.
    fn le(self, x: Self) -> Self::Mask;
    /// `self == x`.
    fn eq(self, x: Self) -> Self::Mask;
    /// `self` where the mask says yes, 0 elsewhere.
    fn only(self, mask: Self::Mask) -> Self;
    /// `self` where the mask says yes, `x` elsewhere.
    fn or_else(self, mask: Self::Mask, x: Self) -> Self;
}

/// One yes or no per lane.
pub trait Mask: Copy {
    /// How many.
    const LANES: usize;
    /// No in every lane.
    const NONE: Self;
    /// Yes in every lane.
    const ALL: Self;
    /// Lane `l`.
    fn get(&self, l: usize) -> bool;
    /// Sets lane `l`.
    fn set(&mut self, l: usize, yes: bool);
    /// Lane l is bit l.
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        let mut mask = Self::NONE;
        for l in 0..Self::LANES {
            mask.set(l, bits >> l & 1 == 1);
        }
        mask
    }
    /// Both.
    fn and(self, x: Self) -> Self;
    /// Either.
    fn or(self, x: Self) -> Self;
    /// Exactly one.
    fn xor(self, x: Self) -> Self;
    /// The opposite.
    fn not(self) -> Self;
    /// `yes` where `self`, `no` elsewhere.
    #[inline(always)]
    fn choose(self, yes: Self, no: Self) -> Self {
        self.and(yes).or(self.not().and(no))
    }
    /// Whether any lane says yes.
    fn any(self) -> bool;
    /// Bit l is lane l.
    fn bits(self) -> u32;
}
