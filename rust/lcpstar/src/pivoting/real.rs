//! The arithmetic a dictionary is kept in: doubles for speed, double-doubles when doubles have lost the thread.

use super::delayed::DelayedDictionary;
use super::dictionary::Dictionary;
use super::path::Tableau;
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

    /// The tableau in which a path is followed.
    type Path: Tableau;

    /// Rounded to double.
    fn to_f64(self) -> f64;

    /// One pivot of a dictionary, see [`kernels::pivot`].
    fn pivot(rows: &mut [Self], stride: usize, r: usize, c: usize, pivot_row: &[Self]);
}

impl Real for f64 {
    const EPSILON: f64 = f64::EPSILON;

    type Path = DelayedDictionary;

    fn to_f64(self) -> f64 {
        self
    }

    fn pivot(rows: &mut [Self], stride: usize, r: usize, c: usize, pivot_row: &[Self]) {
        kernels::pivot(rows, stride, r, c, pivot_row);
    }
}

impl Real for Dd {
    const EPSILON: f64 = Self::EPSILON;

    type Path = Dictionary<Self>;

    fn to_f64(self) -> f64 {
        self.hi
    }

    fn pivot(rows: &mut [Self], stride: usize, r: usize, c: usize, pivot_row: &[Self]) {
        for (i, row) in rows.chunks_exact_mut(stride).enumerate() {
            let f = std::mem::replace(&mut row[c], Self::ZERO);
            if i == r {
                row.copy_from_slice(pivot_row);
            } else if f != Self::ZERO {
                for (y, &x) in row.iter_mut().zip(pivot_row) {
                    *y = *y + f * x;
                }
            }
        }
    }
}
