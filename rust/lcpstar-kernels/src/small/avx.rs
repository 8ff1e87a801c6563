//! The lanes of [`lane`](super::lane) in registers of AVX-512 and AVX2, same bits as `F64x8<true>`.
//!
//! The compiler vectorises the portable lanes well in short kernels and poorly in long ones; naming the instructions
//! makes the speed predictable. Nothing here checks that the machine has them: `work` and `small` choose a type only
//! in functions compiled for, and entered on, machines that do.
#![allow(unsafe_code, reason = "instructions of the machine; see above for who may call them")]

use super::lane::Pair;

/// The operations of [`Lane`] that differ between registers by the instruction only.
macro_rules! operations {
    ($number:ident, $lanes:literal, $mask:ident, $compare:ident, $splat:ident, $fma:ident, $fnma:ident, $($name:ident = $instruction:ident),*) => {
        type Number = $number;
        type Mask = $mask;
        const LANES: usize = $lanes;
        const EPS: f64 = $number::EPSILON as f64;

        $(#[inline(always)]
        fn $name(self, x: Self) -> Self {
            Self(unsafe { $instruction(self.0, x.0) })
        })*
        #[inline(always)]
        fn splat(x: f64) -> Self {
            Self(unsafe { $splat(x as $number) })
        }
        #[inline(always)]
        fn add_product(self, a: Self, b: Self) -> Self {
            Self(unsafe { $fma(a.0, b.0, self.0) })
        }
        #[inline(always)]
        fn sub_product(self, a: Self, b: Self) -> Self {
            Self(unsafe { $fnma(a.0, b.0, self.0) })
        }
        #[inline(always)]
        fn neg(self) -> Self {
            Self::splat(-0.0).sub(self)
        }
        #[inline(always)]
        fn lt(self, x: Self) -> $mask {
            $mask(unsafe { $compare::<_CMP_LT_OQ>(self.0, x.0) })
        }
        #[inline(always)]
        fn le(self, x: Self) -> $mask {
            $mask(unsafe { $compare::<_CMP_LE_OQ>(self.0, x.0) })
        }
        #[inline(always)]
        fn eq(self, x: Self) -> $mask {
            $mask(unsafe { $compare::<_CMP_EQ_OQ>(self.0, x.0) })
        }
        #[inline(always)]
        fn get(&self, l: usize) -> f64 {
            f64::from(self.numbers()[l])
        }
        #[inline(always)]
        fn set(&mut self, l: usize, x: $number) {
            self.numbers_mut()[l] = x;
        }
        #[inline(always)]
        fn set_from(&mut self, l: usize, x: &Self) {
            self.numbers_mut()[l] = x.numbers()[l];
        }
    };
}

/// A register as numbers in memory.
macro_rules! numbers {
    ($register:ident, $number:ident, $lanes:literal) => {
        impl $register {
            #[inline(always)]
            fn numbers(&self) -> &[$number; $lanes] {
                // SAFETY: a register is its numbers in memory, in order.
                unsafe { &*std::ptr::from_ref(self).cast() }
            }

            #[inline(always)]
            fn numbers_mut(&mut self) -> &mut [$number; $lanes] {
                // SAFETY: as `numbers`.
                unsafe { &mut *std::ptr::from_mut(self).cast() }
            }
        }
    };
}

/// A bit per lane.
macro_rules! bits {
    ($mask:ident, $bits:ty, $lanes:literal) => {
        /// A bit per lane.
        #[derive(Clone, Copy, Debug)]
        pub struct $mask($bits);

        impl Mask for $mask {
            const LANES: usize = $lanes;
            const NONE: Self = Self(0);
            const ALL: Self = Self(<$bits>::MAX);

            #[inline(always)]
            fn get(&self, l: usize) -> bool {
                self.0 >> l & 1 == 1
            }
            #[inline(always)]
            fn set(&mut self, l: usize, yes: bool) {
                self.0 = self.0 & !(1 << l) | <$bits>::from(yes) << l;
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                Self(bits as $bits)
            }
            #[inline(always)]
            fn and(self, x: Self) -> Self {
                Self(self.0 & x.0)
            }
            #[inline(always)]
            fn or(self, x: Self) -> Self {
                Self(self.0 | x.0)
            }
            #[inline(always)]
            fn xor(self, x: Self) -> Self {
                Self(self.0 ^ x.0)
            }
            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
            #[inline(always)]
            fn choose(self, yes: Self, no: Self) -> Self {
                Self(self.0 & yes.0 | !self.0 & no.0)
            }
            #[inline(always)]
            fn any(self) -> bool {
                self.0 != 0
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                u32::from(self.0)
            }
        }
    };
}

/// One place in memory for each of `L` lanes, all in the first `span` vectors.
#[derive(Clone, Copy, Debug)]
pub struct Places<const L: usize> {
    numbers: [u32; L],
    span: usize,
}

impl<const L: usize> Places<L> {
    /// Lane l of vector `stride * vectors[l]`.
    #[inline(always)]
    fn new(vectors: [u32; L], limit: usize, stride: usize) -> Self {
        let mut numbers = vectors;
        for (l, number) in numbers.iter_mut().enumerate() {
            *number = *number * (L * stride) as u32 + l as u32;
        }
        Self { numbers, span: (limit - 1) * stride + 1 }
    }
}

/// Number after number: the machine's gather is slower where it is kept from leaking data.
macro_rules! pick {
    ($v:ident, $at:ident, $number:ty, $set:ident, $($l:literal)*) => {{
        assert!($v.len() >= $at.span);
        let first: *const $number = $v.as_ptr().cast();
        Self(unsafe { $set($(*first.add($at.numbers[$l] as usize)),*) })
    }};
}

/// All bits or none, lane by lane.
macro_rules! words {
    ($mask:ident, $register:ident, $word:ty, $lanes:literal, $and:ident, $or:ident, $xor:ident, $movemask:ident) => {
        /// All bits or none, lane by lane.
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub struct $mask($register);

        impl Mask for $mask {
            const LANES: usize = $lanes;
            // SAFETY: any bits are numbers.
            const NONE: Self = Self(unsafe { transmute::<[$word; $lanes], $register>([0; $lanes]) });
            const ALL: Self = Self(unsafe { transmute::<[$word; $lanes], $register>([<$word>::MAX; $lanes]) });

            #[inline(always)]
            fn get(&self, l: usize) -> bool {
                self.bits() >> l & 1 == 1
            }
            #[inline(always)]
            fn set(&mut self, l: usize, yes: bool) {
                // SAFETY: a register is its words in memory, in order.
                let words: &mut [$word; $lanes] = unsafe { &mut *std::ptr::from_mut(self).cast() };
                words[l] = if yes { <$word>::MAX } else { 0 };
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                let words: [$word; $lanes] = std::array::from_fn(|l| <$word>::from(bits >> l & 1).wrapping_neg());
                // SAFETY: as `NONE`.
                Self(unsafe { transmute::<[$word; $lanes], $register>(words) })
            }
            #[inline(always)]
            fn and(self, x: Self) -> Self {
                Self(unsafe { $and(self.0, x.0) })
            }
            #[inline(always)]
            fn or(self, x: Self) -> Self {
                Self(unsafe { $or(self.0, x.0) })
            }
            #[inline(always)]
            fn xor(self, x: Self) -> Self {
                Self(unsafe { $xor(self.0, x.0) })
            }
            #[inline(always)]
            fn not(self) -> Self {
                Self(unsafe { $xor(self.0, Self::ALL.0) })
            }
            #[inline(always)]
            fn any(self) -> bool {
                self.bits() != 0
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                unsafe { $movemask(self.0) as u32 }
            }
        }
    };
}

// After the macros, which they use.
mod single;
mod ymm;
mod zmm;
pub use single::{YmmS, ZmmS};
pub use ymm::Ymm;
pub use zmm::Zmm;

/// Eight doubles in two registers of AVX2.
pub type Ymm2 = Pair<Ymm>;
