//! One number of each of several problems: the vectors that the lane kernels compute with.
//!
//! Plain arrays in plain loops. The kernels are inlined into functions compiled once per instruction set, where every
//! operation below becomes one or two vector instructions. Lanes never mix, so a problem's bits do not depend on its
//! neighbours; `FUSED` says whether `a b + c` is rounded once, so bits depend on the machine only through that.

/// Columns that [`Lane::load_columns`] and [`Lane::store_columns`] move at a time.
pub const BLOCK: usize = 8;

/// Most lanes of any kind.
pub const MOST_LANES: usize = 16;

/// Lanes of one floating-point type with the operations of the kernels.
pub trait Lane: Copy {
    /// The number in each lane.
    type Number: Copy;
    /// One yes or no per lane.
    type Mask: Mask;
    /// One place in a slice per lane.
    type Index: Copy;
    /// Problems solved side by side.
    const LANES: usize;
    /// Spacing of numbers at 1.
    const EPS: f64;

    /// The same number in every lane.
    fn splat(x: f64) -> Self;
    /// The first numbers of `x`, then zeros.
    fn from_slice(x: &[Self::Number]) -> Self;
    /// Lane `l`, as a double.
    fn get(&self, l: usize) -> f64;
    /// Sets lane `l`.
    fn set(&mut self, l: usize, x: Self::Number);
    /// Sets lane `l` to that of `x`.
    fn set_from(&mut self, l: usize, x: &Self);
    /// Lane l of `out[k]` is `rows[l][first + k]`, for at most `BLOCK` columns k.
    fn load_columns(rows: &[&[Self::Number]], first: usize, out: &mut [Self]);
    /// `rows[l stride + k]` is lane l of `columns[k]`, for at most `BLOCK` columns k; the rest of `BLOCK` numbers, from
    /// `l stride` on, is overwritten too, lane after lane.
    fn store_columns(columns: &[Self], rows: &mut [Self::Number], stride: usize);
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

macro_rules! lanes {
    ($(#[$doc:meta])* $lane:ident, $mask:ident, $number:ty, $bits:ty, $lanes:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        #[repr(C, align(64))]
        pub struct $lane<const FUSED: bool>([$number; $lanes]);

        /// All bits or none, lane by lane.
        #[derive(Clone, Copy, Debug)]
        #[repr(C, align(64))]
        pub struct $mask([$bits; $lanes]);

        impl<const FUSED: bool> $lane<FUSED> {
            #[inline(always)]
            fn each(self, x: Self, f: impl Fn($number, $number) -> $number) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    out.0[l] = f(self.0[l], x.0[l]);
                }
                out
            }

            #[inline(always)]
            fn fold(self, f: impl Fn(f64, f64) -> f64) -> f64 {
                let (mut x, mut count) = (self.0.map(f64::from), $lanes);
                while count > 1 {
                    count /= 2;
                    for l in 0..count {
                        x[l] = f(x[l], x[l + count]);
                    }
                }
                x[0]
            }

            #[inline(always)]
            fn test(self, x: Self, f: impl Fn($number, $number) -> bool) -> $mask {
                let mut out = $mask::NONE;
                for l in 0..$lanes {
                    out.0[l] = if f(self.0[l], x.0[l]) { <$bits>::MAX } else { 0 };
                }
                out
            }
        }

        impl<const FUSED: bool> Lane for $lane<FUSED> {
            type Number = $number;
            type Mask = $mask;
            type Index = [usize; $lanes];
            const LANES: usize = $lanes;
            const EPS: f64 = <$number>::EPSILON as f64;

            #[inline(always)]
            fn splat(x: f64) -> Self {
                Self([x as $number; $lanes])
            }
            #[inline(always)]
            fn from_slice(x: &[$number]) -> Self {
                let mut out = Self([0.0; $lanes]);
                for (out, x) in out.0.iter_mut().zip(x) {
                    *out = *x;
                }
                out
            }
            #[inline(always)]
            fn get(&self, l: usize) -> f64 {
                f64::from(self.0[l])
            }
            #[inline(always)]
            fn set(&mut self, l: usize, x: $number) {
                self.0[l] = x;
            }
            #[inline(always)]
            fn set_from(&mut self, l: usize, x: &Self) {
                self.0[l] = x.0[l];
            }
            #[inline(always)]
            fn load_columns(rows: &[&[$number]], first: usize, out: &mut [Self]) {
                for (l, row) in rows.iter().enumerate() {
                    for (out, x) in out.iter_mut().zip(&row[first..]) {
                        out.0[l] = *x;
                    }
                }
            }
            #[inline(always)]
            fn store_columns(columns: &[Self], rows: &mut [$number], stride: usize) {
                for l in 0..$lanes {
                    for (x, column) in rows[l * stride..].iter_mut().zip(columns) {
                        *x = column.0[l];
                    }
                }
            }
            #[inline(always)]
            fn index(self, limit: usize, stride: usize) -> [usize; $lanes] {
                self.0.map(|x| (x.max(0.0) as usize).min(limit - 1) * stride)
            }
            #[inline(always)]
            fn pick(v: &[Self], at: [usize; $lanes]) -> Self {
                let mut out = Self([0.0; $lanes]);
                for l in 0..$lanes {
                    out.0[l] = v[at[l]].0[l];
                }
                out
            }
            #[inline(always)]
            fn sum(self) -> f64 {
                self.fold(|a, b| a + b)
            }
            #[inline(always)]
            fn largest(self) -> f64 {
                self.fold(f64::max)
            }
            #[inline(always)]
            fn smallest(self) -> f64 {
                self.fold(f64::min)
            }
            #[inline(always)]
            fn add(self, x: Self) -> Self {
                self.each(x, |a, b| a + b)
            }
            #[inline(always)]
            fn sub(self, x: Self) -> Self {
                self.each(x, |a, b| a - b)
            }
            #[inline(always)]
            fn mul(self, x: Self) -> Self {
                self.each(x, |a, b| a * b)
            }
            #[inline(always)]
            fn div(self, x: Self) -> Self {
                self.each(x, |a, b| a / b)
            }
            #[inline(always)]
            fn add_product(self, a: Self, b: Self) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    out.0[l] = if FUSED { a.0[l].mul_add(b.0[l], self.0[l]) } else { self.0[l] + a.0[l] * b.0[l] };
                }
                out
            }
            #[inline(always)]
            fn sub_product(self, a: Self, b: Self) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    out.0[l] = if FUSED { (-a.0[l]).mul_add(b.0[l], self.0[l]) } else { self.0[l] - a.0[l] * b.0[l] };
                }
                out
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.each(self, |a, _| a.abs())
            }
            #[inline(always)]
            fn neg(self) -> Self {
                self.each(self, |a, _| -a)
            }
            #[inline(always)]
            fn max(self, x: Self) -> Self {
                self.each(x, |a, b| if a > b { a } else { b })
            }
            #[inline(always)]
            fn min(self, x: Self) -> Self {
                self.each(x, |a, b| if a < b { a } else { b })
            }
            #[inline(always)]
            fn lt(self, x: Self) -> $mask {
                self.test(x, |a, b| a < b)
            }
            #[inline(always)]
            fn le(self, x: Self) -> $mask {
                self.test(x, |a, b| a <= b)
            }
            #[inline(always)]
            fn eq(self, x: Self) -> $mask {
                self.test(x, |a, b| a == b)
            }
            #[inline(always)]
            fn only(self, mask: $mask) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    out.0[l] = <$number>::from_bits(self.0[l].to_bits() & mask.0[l]);
                }
                out
            }
            #[inline(always)]
            fn or_else(self, mask: $mask, x: Self) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    let (a, b, m) = (self.0[l].to_bits(), x.0[l].to_bits(), mask.0[l]);
                    out.0[l] = <$number>::from_bits((a & m) | (b & !m));
                }
                out
            }
        }

        impl $mask {
            #[inline(always)]
            fn each(self, x: Self, f: impl Fn($bits, $bits) -> $bits) -> Self {
                let mut out = self;
                for l in 0..$lanes {
                    out.0[l] = f(self.0[l], x.0[l]);
                }
                out
            }
        }

        impl Mask for $mask {
            const LANES: usize = $lanes;
            const NONE: Self = Self([0; $lanes]);
            const ALL: Self = Self([<$bits>::MAX; $lanes]);

            #[inline(always)]
            fn get(&self, l: usize) -> bool {
                self.0[l] != 0
            }
            #[inline(always)]
            fn set(&mut self, l: usize, yes: bool) {
                self.0[l] = if yes { <$bits>::MAX } else { 0 };
            }
            #[inline(always)]
            fn and(self, x: Self) -> Self {
                self.each(x, |a, b| a & b)
            }
            #[inline(always)]
            fn or(self, x: Self) -> Self {
                self.each(x, |a, b| a | b)
            }
            #[inline(always)]
            fn xor(self, x: Self) -> Self {
                self.each(x, |a, b| a ^ b)
            }
            #[inline(always)]
            fn not(self) -> Self {
                self.each(self, |a, _| !a)
            }
            #[inline(always)]
            fn any(self) -> bool {
                self.0.iter().fold(0, |any, m| any | m) != 0
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                (0..$lanes).fold(0, |bits, l| bits | u32::from(self.0[l] != 0) << l)
            }
        }
    };
}

lanes!(
    /// Eight doubles: one AVX-512 register, two of AVX2.
    F64x8, M64x8, f64, u64, 8
);

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
    type Number = X::Number;
    type Mask = Pair<X::Mask>;
    type Index = [X::Index; 2];
    const LANES: usize = 2 * X::LANES;
    const EPS: f64 = X::EPS;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([X::splat(x); 2])
    }
    #[inline(always)]
    fn from_slice(x: &[X::Number]) -> Self {
        let (low, high) = x.split_at(x.len().min(X::LANES));
        Self([X::from_slice(low), X::from_slice(high)])
    }
    #[inline(always)]
    fn get(&self, l: usize) -> f64 {
        self.0[l / X::LANES].get(l % X::LANES)
    }
    #[inline(always)]
    fn set(&mut self, l: usize, x: X::Number) {
        self.0[l / X::LANES].set(l % X::LANES, x);
    }
    #[inline(always)]
    fn set_from(&mut self, l: usize, x: &Self) {
        self.0[l / X::LANES].set_from(l % X::LANES, &x.0[l / X::LANES]);
    }
    #[inline(always)]
    fn load_columns(rows: &[&[X::Number]], first: usize, out: &mut [Self]) {
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
    fn store_columns(columns: &[Self], rows: &mut [X::Number], stride: usize) {
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

lanes!(
    /// Eight floats: one register of AVX2.
    F32x8, M32x8, f32, u32, 8
);
