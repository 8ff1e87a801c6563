//! The arithmetic a dictionary is kept in: doubles for speed, double-doubles when doubles have lost the thread.

use crate::linalg::dd::Dd;
use crate::linalg::kernels;
use crate::linalg::update::{self, Window};
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A field with an order and a rounding error. Vectors of a dictionary have lengths that are multiples of
/// [`LANES`](kernels::LANES), filled up with zeros.
pub trait Real:
    Copy
    + PartialOrd
    + Debug
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// Relative rounding error of one operation.
    const EPSILON: f64;

    /// Pivots between two updates of a dictionary that follows a path. More than one pays where the memory is slower than
    /// the arithmetic.
    const DELAY: usize;

    /// Rounded to double.
    fn to_f64(self) -> f64;

    /// `max |x_i|`.
    fn largest(x: &[Self]) -> f64 {
        x.iter().fold(0.0, |m, x| m.max(x.to_f64().abs()))
    }

    /// `y += sum_k f_k x_k`, the `x_k` of `y.len()` numbers each, one after the other.
    fn add_combination(y: &mut [Self], f: &[Self], x: &[Self]) {
        for (f, x) in f.iter().zip(x.chunks_exact(y.len().max(1))) {
            y.iter_mut().zip(x).for_each(|(y, x)| *y = *y + *f * *x);
        }
    }

    /// `c_ij += sum_k left_ki right_kj` for `i < height`, `j < width`, `k < count`.
    fn add_products(
        c: &mut [Self],
        stride: usize,
        (height, width, count): (usize, usize, usize),
        left: Window<'_, Self>,
        right: Window<'_, Self>,
    ) {
        for k in 0..count {
            let terms = &right.numbers[k * right.stride..][..width];
            for (row, f) in c.chunks_mut(stride).take(height).zip(&left.numbers[k * left.stride..]) {
                if f.to_f64() != 0.0 {
                    row.iter_mut().zip(terms).for_each(|(y, x)| *y = *y + *f * *x);
                }
            }
        }
    }

    /// The ratios `values_i / (sign column_i)` where that rate exceeds `tol`, infinity elsewhere; returns the least.
    fn ratios(values: &[Self], column: &[Self], sign: f64, tol: f64, ratios: &mut [Self]) -> Self {
        let mut least = Self::from(f64::INFINITY);
        for ((ratio, value), c) in ratios.iter_mut().zip(values).zip(column) {
            let rate = *c * Self::from(sign);
            *ratio = if rate.to_f64() > tol { *value / rate } else { Self::from(f64::INFINITY) };
            least = if *ratio < least { *ratio } else { least };
        }
        least
    }
}

impl Real for f64 {
    const EPSILON: f64 = f64::EPSILON;
    const DELAY: usize = 16;

    fn to_f64(self) -> f64 {
        self
    }

    fn largest(x: &[Self]) -> f64 {
        kernels::largest(x)
    }

    fn add_combination(y: &mut [Self], f: &[Self], x: &[Self]) {
        kernels::add_combination(y, f, x);
    }

    fn add_products(
        c: &mut [Self],
        stride: usize,
        size: (usize, usize, usize),
        left: Window<'_, Self>,
        right: Window<'_, Self>,
    ) {
        update::add_products(c, stride, size, left, right);
    }

    fn ratios(values: &[Self], column: &[Self], sign: f64, tol: f64, ratios: &mut [Self]) -> Self {
        kernels::ratios(values, column, sign, tol, ratios)
    }
}

impl Real for Dd {
    const EPSILON: f64 = Self::EPSILON;
    const DELAY: usize = 1;

    fn to_f64(self) -> f64 {
        self.hi
    }
}
