//! Vertices and extreme rays of the complementary faces, by double description with a floating-point filter.
//!
//! A generator is a nonnegative vector `(z, t)`, kept in doubles with one bound on the relative error of its
//! entries. New generators are positive combinations of old ones, so no entry ever cancels and the bound grows
//! slowly; zeros are known from the construction. Only the sign of a row can cancel, and where the bound does not
//! decide it the generator is solved for exactly: its zeros determine it.

use crate::control::Control;
use crate::exact::dyadic::{RationalVec, Scaled, linear_form, ratio_to_f64};
use crate::exact::padic::{Block, independent_rows_and_columns};
use crate::problem::Lcp;
use crate::status::Termination;
use num_bigint::BigInt;
use num_traits::{One, Signed, Zero};
use std::cell::OnceCell;
use std::cmp::Ordering;

/// Entries less accurate than this are solved for anew.
const WORN: f64 = 1e-5;

/// An extreme ray of the cone of the rows seen so far.
#[derive(Clone, Debug)]
pub(super) struct Generator {
    /// `(z, t)`, largest entry near 1.
    entries: Vec<f64>,
    /// Bound of the relative error of every entry; infinite when only the exact vector may be used.
    relative_error: f64,
    /// Nonzero entries of `(z, t)`.
    pub(super) z_support: u128,
    /// Rows seen with `w_i > 0`.
    pub(super) w_support: u128,
    exact: OnceCell<RationalVec>,
}

/// A certified sign of a row at a generator, and the value with its relative error.
#[derive(Clone, Copy)]
struct RowValue {
    sign: Ordering,
    value: f64,
    relative_error: f64,
}

/// All generators of the complementary faces; `t` is entry n.
pub(super) fn complementary_generators(lcp: &Lcp, control: &Control<'_>) -> Result<Vec<Finished>, Termination> {
    let n = lcp.n();
    let mut cone = Cone { lcp, seen: Vec::new(), generators: (0..=n).map(|j| unit(n, j)).collect() };
    while let Some(row) = cone.cheapest_row() {
        cone.cut(row, control)?;
    }
    let Cone { lcp, seen, generators } = cone;
    let mut finished = Vec::with_capacity(generators.len());
    for g in generators {
        stopped(control)?;
        let exact = exact_vector(lcp, &seen, &g)?.clone();
        finished.push(Finished { exact, z_support: g.z_support, w_support: g.w_support });
    }
    Ok(finished)
}

/// A generator of the final cone in exact numbers.
pub(super) struct Finished {
    /// `(z, t)`.
    pub(super) exact: RationalVec,
    pub(super) z_support: u128,
    pub(super) w_support: u128,
}

fn stopped(control: &Control<'_>) -> Result<(), Termination> {
    control.expired().map_or(Ok(()), Err)
}

fn unit(n: usize, j: usize) -> Generator {
    let mut entries = vec![0.0; n + 1];
    entries[j] = 1.0;
    Generator { entries, relative_error: 0.0, z_support: 1 << j, w_support: 0, exact: OnceCell::new() }
}

struct Cone<'a> {
    lcp: &'a Lcp,
    seen: Vec<usize>,
    generators: Vec<Generator>,
}

impl Cone<'_> {
    /// The row with the fewest pairs of generators on its two sides, judged in doubles.
    fn cheapest_row(&self) -> Option<usize> {
        (0..self.lcp.n()).filter(|i| !self.seen.contains(i)).min_by_key(|&i| {
            let (mut above, mut below) = (0usize, 0usize);
            for g in &self.generators {
                let (sum, _) = float_row(self.lcp, i, &g.entries);
                above += usize::from(sum > 0.0);
                below += usize::from(sum < 0.0);
            }
            above * below
        })
    }

    /// Intersects with the half-space of `row` and drops what is not complementary in it.
    fn cut(&mut self, row: usize, control: &Control<'_>) -> Result<(), Termination> {
        let (mut above, mut below, mut on) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..self.generators.len() {
            if k % 64 == 0 {
                stopped(control)?;
            }
            let value = self.row_value(row, k)?;
            match value.sign {
                Ordering::Greater => above.push((k, value)),
                Ordering::Less => below.push((k, value)),
                Ordering::Equal => on.push(k),
            }
        }
        let mut born = Vec::new();
        let mut edges = Edges::new(&self.generators, self.pairs(), self.seen.len() + 2);
        for &(k, s) in &above {
            stopped(control)?;
            for &(l, r) in &below {
                if edges.contain(k, l) {
                    born.push(self.combine((k, s), (l, r)));
                }
            }
        }
        let bit = 1u128 << row;
        for &(k, _) in &above {
            self.generators[k].w_support |= bit;
        }
        let mut keep = vec![false; self.generators.len()];
        for k in on.into_iter().chain(above.into_iter().map(|(k, _)| k)) {
            keep[k] = self.generators[k].z_support & self.generators[k].w_support & self.pairs() == 0;
        }
        let mut keep = keep.into_iter();
        self.generators.retain(|_| keep.next().unwrap_or(false));
        self.generators.append(&mut born);
        self.seen.push(row);
        Ok(())
    }

    /// The bits of the pairs, without t.
    fn pairs(&self) -> u128 {
        (1u128 << self.lcp.n()) - 1
    }

    /// The generator on the hyperplane between one above and one below.
    fn combine(&self, (k, s): (usize, RowValue), (l, r): (usize, RowValue)) -> Generator {
        let (g, h) = (&self.generators[k], &self.generators[l]);
        let (up, down) = (-r.value, s.value);
        let mut entries: Vec<f64> = g.entries.iter().zip(&h.entries).map(|(x, y)| up * x + down * y).collect();
        let largest = entries.iter().fold(0.0, |m: f64, x| m.max(*x));
        for x in &mut entries {
            *x /= largest;
        }
        let z_support = g.z_support | h.z_support;
        let sound = (0..entries.len()).all(|j| z_support >> j & 1 == 0 || (entries[j] > 1e-200 && entries[j] <= 1.0));
        let worse = (g.relative_error + r.relative_error).max(h.relative_error + s.relative_error);
        let relative_error = if sound && largest.is_normal() { worse + 8.0 * f64::EPSILON } else { f64::INFINITY };
        let w_support = g.w_support | h.w_support;
        Generator { entries, relative_error, z_support, w_support, exact: OnceCell::new() }
    }

    fn row_value(&mut self, row: usize, k: usize) -> Result<RowValue, Termination> {
        let g = &mut self.generators[k];
        if g.relative_error > WORN && g.exact.get().is_none() {
            exact_vector(self.lcp, &self.seen, g)?;
            refresh(g);
        }
        if let Some(value) = certain(self.lcp, row, g) {
            return Ok(value);
        }
        exact_vector(self.lcp, &self.seen, g)?;
        refresh(g);
        Ok(exact_row(self.lcp, row, g))
    }
}

/// The supports of all generators, packed for the search of edges.
struct Edges {
    supports: Vec<(u128, u128)>,
    pairs: u128,
    largest_union: u32,
    /// The generator that refuted the last pair refutes the next one more often than any other.
    last: usize,
}

impl Edges {
    fn new(generators: &[Generator], pairs: u128, largest_union: usize) -> Self {
        let supports = generators.iter().map(|g| (g.z_support, g.w_support)).collect();
        Self { supports, pairs, largest_union: largest_union as u32, last: 0 }
    }

    /// Complementary to each other on the rows seen, and spanning an edge: no third generator is supported in the
    /// union of their supports.
    fn contain(&mut self, k: usize, l: usize) -> bool {
        let (g, h) = (self.supports[k], self.supports[l]);
        let (z, w) = (g.0 | h.0, g.1 | h.1);
        if z & w & self.pairs != 0 || z.count_ones() + w.count_ones() > self.largest_union {
            return false;
        }
        let within = |m: usize| {
            let (other_z, other_w) = self.supports[m];
            (other_z & !z) | (other_w & !w) == 0 && m != k && m != l
        };
        if within(self.last) {
            return false;
        }
        match (0..self.supports.len()).find(|&m| within(m)) {
            Some(m) => {
                self.last = m;
                false
            }
            None => true,
        }
    }
}

fn float_row(lcp: &Lcp, row: usize, entries: &[f64]) -> (f64, f64) {
    let n = lcp.n();
    let last = lcp.q()[row] * entries[n];
    let terms = lcp.row(row).iter().zip(entries).map(|(a, z)| a * z);
    terms.fold((last, last.abs()), |(sum, size), t| (sum + t, size + t.abs()))
}

/// The sign of the row when the error bound decides it.
fn certain(lcp: &Lcp, row: usize, g: &Generator) -> Option<RowValue> {
    let (value, size) = float_row(lcp, row, &g.entries);
    if row_vanishes(lcp, row, g.z_support) {
        return Some(RowValue { sign: Ordering::Equal, value: 0.0, relative_error: 0.0 });
    }
    // Products, n additions and the error of the entries, counted twice over.
    let rounding = (entries_of(lcp) + 4) as f64 * 2.0 * f64::EPSILON;
    let error = size * (1.5 * g.relative_error + rounding) + f64::MIN_POSITIVE * 1e3;
    // The value is used only when it is accurate itself.
    let usable = size.is_finite() && value.abs() > 1e-200 && error < 1e-3 * value.abs();
    usable.then(|| RowValue { sign: value.total_cmp(&0.0), value, relative_error: 1.01 * error / value.abs() })
}

fn entries_of(lcp: &Lcp) -> usize {
    lcp.n() + 1
}

/// Whether no coefficient of the row meets the support.
fn row_vanishes(lcp: &Lcp, row: usize, support: u128) -> bool {
    let n = lcp.n();
    (0..n).all(|j| support >> j & 1 == 0 || lcp.row(row)[j] == 0.0) && (support >> n & 1 == 0 || lcp.q()[row] == 0.0)
}

/// The sign in integers, the value rounded.
fn exact_row(lcp: &Lcp, row: usize, g: &Generator) -> RowValue {
    let Some(v) = g.exact.get() else {
        return RowValue { sign: Ordering::Equal, value: 0.0, relative_error: 0.0 };
    };
    let coefficients = lcp.row(row).iter().copied().chain(std::iter::once(lcp.q()[row]));
    let sum = linear_form(coefficients.zip(&v.numerators));
    let sign = sum.value.cmp(&BigInt::zero());
    let rounded = RationalVec::from_scaled(vec![sum], v.denominator.clone());
    let value = ratio_to_f64(&rounded.numerators[0], &rounded.denominator);
    // An exact value out of the range of doubles makes every combination exact as well.
    let relative_error = if value.is_normal() || sign == Ordering::Equal { 2.0 * f64::EPSILON } else { f64::INFINITY };
    RowValue { sign, value, relative_error }
}

/// Entries rounded from the exact vector.
fn refresh(g: &mut Generator) {
    let Some(v) = g.exact.get() else { return };
    g.entries = v.to_f64();
    let faithful = g.entries.iter().zip(&v.numerators).all(|(x, e)| e.is_zero() || *x > 1e-200);
    g.relative_error = if faithful { 2.0 * f64::EPSILON } else { f64::INFINITY };
}

/// The vector with the zeros of `g`, largest entry 1, found once: `A^[rows with w = 0, support]` has a kernel of
/// dimension one.
fn exact_vector<'g>(lcp: &Lcp, seen: &[usize], g: &'g Generator) -> Result<&'g RationalVec, Termination> {
    if let Some(v) = g.exact.get() {
        return Ok(v);
    }
    let n = lcp.n();
    let support: Vec<usize> = (0..=n).filter(|&j| g.z_support >> j & 1 == 1).collect();
    let rows: Vec<usize> = seen.iter().copied().filter(|&i| g.w_support >> i & 1 == 0).collect();
    let entry = |i: usize, j: usize| if j == n { lcp.q()[i] } else { lcp.row(i)[j] };
    let preference: Vec<usize> = (0..support.len()).collect();
    let (independent, basic) = independent_rows_and_columns(
        rows.len(),
        support.len(),
        |i, j| entry(rows[i], support[j]),
        &preference,
        &|| false,
    );
    let failed = Termination::Breakdown("a generator is not determined by its zeros modulo a prime");
    let free = preference.iter().copied().find(|j| !basic.contains(j)).ok_or(failed)?;
    if basic.len() + 1 != support.len() {
        return Err(failed);
    }
    let block = Block::new(basic.len(), |i, j| entry(rows[independent[i]], support[basic[j]]), &|| false)
        .map_err(|_| failed)?;
    let rhs: Vec<Scaled> = independent.iter().map(|&i| Scaled::from_f64(-entry(rows[i], support[free]))).collect();
    let solved = block.solve(&rhs, &|| false).map_err(|_| failed)?;
    let mut numerators = vec![BigInt::zero(); n + 1];
    numerators[support[free]] = solved.denominator;
    for (&j, x) in basic.iter().zip(solved.numerators) {
        numerators[support[j]] = x;
    }
    if numerators.iter().any(Signed::is_negative) {
        return Err(failed);
    }
    let denominator = numerators.iter().max().cloned().unwrap_or_else(BigInt::one);
    Ok(g.exact.get_or_init(|| RationalVec { numerators, denominator }))
}
