//! The lanes of [`lane`](super::lane) in registers of AVX-512 and AVX2, same bits as `F64x8<true>`.
//!
//! The compiler vectorises the portable lanes well in short kernels and poorly in long ones; naming the instructions
//! makes the speed predictable. Nothing here checks that the machine has them: `work` and `small` choose a type only
//! in functions compiled for, and entered on, machines that do.
#![allow(unsafe_code, reason = "instructions of the machine; see above for who may call them")]

use super::lane::Pair;

/// The operations of [`Lane`] that differ between registers by the instruction only.
macro_rules! operations {
    ($lanes:literal, $mask:ident, $compare:ident, $splat:ident, $fma:ident, $fnma:ident, $($name:ident = $instruction:ident),*) => {
        type Mask = $mask;
        const LANES: usize = $lanes;

        $(#[inline(always)]
        fn $name(self, x: Self) -> Self {
            Self(unsafe { $instruction(self.0, x.0) })
        })*
        #[inline(always)]
        fn splat(x: f64) -> Self {
            Self(unsafe { $splat(x) })
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
            self.numbers()[l]
        }
        #[inline(always)]
        fn set(&mut self, l: usize, x: f64) {
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
    ($register:ident, $lanes:literal) => {
        impl $register {
            #[inline(always)]
            fn numbers(&self) -> &[f64; $lanes] {
                // SAFETY: a register is its numbers in memory, in order.
                unsafe { &*std::ptr::from_ref(self).cast() }
            }

            #[inline(always)]
            fn numbers_mut(&mut self) -> &mut [f64; $lanes] {
                // SAFETY: as `numbers`.
                unsafe { &mut *std::ptr::from_mut(self).cast() }
            }
        }
    };
}

/// Number after number: the machine's gather is slower where it is kept from leaking data.
macro_rules! pick {
    ($v:ident, $at:ident, $set:ident, $($l:literal)*) => {{
        assert!($v.len() >= $at.span);
        let first: *const f64 = $v.as_ptr().cast();
        Self(unsafe { $set($(*first.add($at.numbers[$l] as usize)),*) })
    }};
}

mod places;
// After the macros, which they use.
mod ymm;
mod zmm;
pub use ymm::Ymm;
pub use zmm::Zmm;

/// Eight doubles in two registers of AVX2.
pub type Ymm2 = Pair<Ymm>;
