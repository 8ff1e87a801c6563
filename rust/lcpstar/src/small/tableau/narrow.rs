//! A tableau while it is exchanged, its columns of so few vectors that the compiler is told how many.

use super::{Exchange, Pivot, Tableau, at, basic_row, is_number};
use crate::small::lane::Lane;

/// A tableau with columns of `W` vectors, all in the nearest cache; what every pivot reads is at hand.
///
/// Columns see a pivot when the next one comes. What they have to do then waits for nothing: the processor does it while the
/// search for the next row waits for one number after the other.
pub struct Narrow<'a, X, const W: usize> {
    columns: &'a mut [[X; W]],
    value: [X; W],
    driver: usize,
    driving: [X; W],
    /// The pivot that the columns have not seen, if any.
    late: Option<Pivot>,
    /// Its driving column.
    late_driving: [X; W],
    basic: &'a mut [usize],
    place: &'a mut [usize],
    home: Home<'a, X>,
}

/// The tableau's own places for what is at hand.
struct Home<'a, X> {
    value: &'a mut [X],
    driving: &'a mut [X],
    late: &'a mut Vec<Pivot>,
    seen: &'a mut [usize],
}

impl<X: Lane<Number = f64>> Tableau<X> {
    /// For pivots; no column may have missed one. `W` vectors per column.
    #[inline(always)]
    pub fn narrow<const W: usize>(&mut self) -> Narrow<'_, X, W> {
        let (n, mut value, mut driving) = (self.n, [X::splat(0.0); W], [X::splat(0.0); W]);
        value.copy_from_slice(&self.value);
        driving.copy_from_slice(&self.driving[..W]);
        Narrow {
            columns: &mut self.t.as_chunks_mut::<W>().0[..n + 1],
            value,
            driver: self.driver,
            driving,
            late: None,
            late_driving: driving,
            basic: &mut self.basic[..n],
            place: &mut self.place[..2 * n + 1],
            home: Home {
                value: &mut self.value,
                driving: &mut self.driving,
                late: &mut self.late,
                seen: &mut self.seen,
            },
        }
    }
}

impl<X: Lane<Number = f64>, const W: usize> Narrow<'_, X, W> {
    /// Back to the tableau.
    #[inline(always)]
    pub fn finish(self) {
        self.home.value.copy_from_slice(&self.value);
        if let Some(pivot) = self.late {
            self.home.driving[..W].copy_from_slice(&self.late_driving);
            self.home.late.push(pivot);
            self.home.seen[pivot.own] = 1;
        }
    }

    /// The late pivot reaches every column but that of the variable that left.
    #[inline(always)]
    fn catch_up(&mut self) {
        let Some(pivot) = self.late else {
            return;
        };
        let (c, own) = (self.late_driving, self.columns[pivot.own]);
        for t in &mut *self.columns {
            pivot.apply(&c, t);
        }
        self.columns[pivot.own] = own;
    }
}

impl<X: Lane<Number = f64>, const W: usize> Exchange<X> for Narrow<'_, X, W> {
    #[inline(always)]
    fn drive(&mut self, variable: usize) {
        let own = self.place[variable];
        let t = &self.columns[own];
        let mut column = *t;
        if let Some(pivot) = self.late
            && pivot.own != own
        {
            let (c, p) = (self.late_driving, X::splat(at(t, pivot.r) * pivot.factor));
            for b in 0..W {
                column[b] = p.or_else(is_number::<X>(pivot.r, b), t[b].add_product(c[b], p));
            }
        }
        (self.driver, self.driving) = (variable, column);
    }

    #[inline(always)]
    fn exchange(&mut self, r: usize) -> usize {
        let (own, leaving) = (self.place[self.driver], self.basic[r]);
        self.basic[r] = self.driver;
        self.place[self.driver] = r;
        self.place[leaving] = own;
        self.catch_up();
        let c = self.driving;
        let pivot = Pivot { r, own, factor: -1.0 / at(&self.driving, r) };
        pivot.apply_to_values(&c, &mut self.value);
        pivot.apply_to_own(&c, &mut self.columns[own]);
        (self.late, self.late_driving) = (Some(pivot), c);
        leaving
    }

    #[inline(always)]
    fn driving_column(&self) -> &[X] {
        &self.driving
    }

    #[inline(always)]
    fn values(&self) -> &[X] {
        &self.value
    }

    #[inline(always)]
    fn row_of(&self, variable: usize) -> Option<usize> {
        basic_row(self.basic, self.place, variable)
    }
}
