//! The arithmetic a dictionary is kept in: doubles for speed, double-doubles when doubles have lost the thread.

use crate::linalg::dd::Dd;
use crate::linalg::kernels;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A field with an order and a rounding error.
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

    /// Rounded to double.
    fn to_f64(self) -> f64;

    /// `y += f x`.
    fn axpy(f: Self, x: &[Self], y: &mut [Self]);
}

impl Real for f64 {
    const EPSILON: f64 = f64::EPSILON;

    fn to_f64(self) -> f64 {
        self
    }

    fn axpy(f: Self, x: &[Self], y: &mut [Self]) {
        kernels::axpy(f, x, y);
    }
}

impl Real for Dd {
    const EPSILON: f64 = Self::EPSILON;

    fn to_f64(self) -> f64 {
        self.hi
    }

    fn axpy(f: Self, x: &[Self], y: &mut [Self]) {
        for (y, &x) in y.iter_mut().zip(x) {
            *y = *y + f * x;
        }
    }
}
