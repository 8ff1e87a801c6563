//! Formulas about a matrix, evaluated lazily: `&` and `|` stop early and only the classes that are asked are decided.

use super::budget::{Budget, Search};
use super::class::{Class, Facts};
use super::game;
use super::transforms::legitimate;
use crate::elimination::{determinant, principal_pivot_transform, rank};
use crate::imatrix::{IMatrix, indices, of_size};
use crate::int::Int;
use std::cmp::Ordering;

/// A number that belongs to a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The sign-exact value of the game, compared with a rational.
    Value,
    /// Determinant.
    Determinant,
    /// Rank.
    Rank,
    /// Order.
    Order,
    /// Trace.
    Trace,
    /// Smallest entry.
    Least,
    /// Largest entry.
    Largest,
    /// Entry (i, j).
    Entry(usize, usize),
}

/// A matrix made from A.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Derived {
    /// The transpose.
    Transpose,
    /// `A + A'`.
    Symmetric,
    /// The inverse: the transform on all indices.
    Inverse,
    /// `-A`.
    Negative,
    /// The principal submatrix on a bit mask.
    Principal(u64),
    /// The principal pivot transform on a bit mask.
    Transform(u64),
}

/// Which matrices a quantifier runs over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// All legitimate principal pivot transforms, A included.
    Transforms,
    /// Principal submatrices of orders `from..=to`; `to` counts from the order n when negative or zero (`0` is n).
    Principals(usize, i64),
}

/// A statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Formula {
    /// Membership.
    In(Class),
    /// `quantity (<, <=, ==, ...) p / q`; the orderings that make it true.
    Compare(Quantity, Vec<Ordering>, Int, Int),
    /// Symmetric.
    IsSymmetric,
    /// Skew-symmetric.
    IsSkew,
    /// Bordered `[[A_aa, +], [-, 0]]` with strict signs.
    IsBordered,
    /// Negation.
    Not(Box<Self>),
    /// Conjunction, left to right.
    And(Vec<Self>),
    /// Disjunction, left to right.
    Or(Vec<Self>),
    /// The statement about a derived matrix; false when that does not exist.
    Of(Derived, Box<Self>),
    /// For all.
    Every(Range, Box<Self>),
    /// For some.
    Some(Range, Box<Self>),
}

impl Formula {
    /// Whether A satisfies it.
    ///
    /// # Errors
    /// `Stopped` by the budget.
    pub fn holds(&self, a: &Facts, b: &Budget<'_>) -> Search<bool> {
        let m = a.matrix();
        let n = m.rows();
        match self {
            Self::In(class) => a.holds(*class, b),
            Self::Compare(quantity, orderings, p, q) => Ok(orderings.contains(&compare(*quantity, m, p, q, b)?)),
            Self::IsSymmetric => Ok((0..n).all(|i| (0..i).all(|j| m.at(i, j) == m.at(j, i)))),
            Self::IsSkew => Ok((0..n).all(|i| (0..=i).all(|j| (m.at(i, j) + m.at(j, i)).is_zero()))),
            Self::IsBordered => {
                let last = n - 1;
                Ok(m.at(last, last).is_zero()
                    && (0..last).all(|i| m.at(i, last).sign() > 0 && m.at(last, i).sign() < 0))
            }
            Self::Not(inner) => Ok(!inner.holds(a, b)?),
            Self::And(parts) => Self::first(parts, a, b, false),
            Self::Or(parts) => Self::first(parts, a, b, true),
            Self::Of(derived, inner) => match derive(m, derived) {
                Some(m) => inner.holds(&Facts::new(m), b),
                None => Ok(false),
            },
            Self::Every(range, inner) => Ok(!Self::any(*range, inner, a, b, false)?),
            Self::Some(range, inner) => Self::any(*range, inner, a, b, true),
        }
    }

    /// Whether some part is `wanted`; the whole is `wanted` then, and its opposite otherwise.
    fn first(parts: &[Self], a: &Facts, b: &Budget<'_>, wanted: bool) -> Search<bool> {
        for part in parts {
            if part.holds(a, b)? == wanted {
                return Ok(wanted);
            }
        }
        Ok(!wanted)
    }

    /// Whether the statement is `wanted` for some matrix of the range.
    fn any(range: Range, inner: &Self, a: &Facts, b: &Budget<'_>, wanted: bool) -> Search<bool> {
        let m = a.matrix();
        match range {
            Range::Transforms => {
                if inner.holds(a, b)? == wanted {
                    return Ok(true);
                }
                for (_, m) in legitimate(m, b)?.into_iter().skip(1) {
                    if inner.holds(&Facts::new(m), b)? == wanted {
                        return Ok(true);
                    }
                }
            }
            Range::Principals(from, to) => {
                let n = m.rows();
                let to = if to > 0 { to as usize } else { n.saturating_sub(to.unsigned_abs() as usize) };
                for alpha in (from..=to.min(n)).flat_map(|size| of_size(n, size)) {
                    if inner.holds(&Facts::new(m.principal(&indices(alpha))), b)? == wanted {
                        return Ok(true);
                    }
                }
            }
        }
        Ok(false)
    }
}

fn compare(quantity: Quantity, m: &IMatrix, p: &Int, q: &Int, budget: &Budget<'_>) -> Search<Ordering> {
    let whole = |x: &Int| (x * q).cmp(p);
    Ok(match quantity {
        Quantity::Value => {
            let g = game::solve(m, budget)?;
            (&g.numerator * q).cmp(&(p * &g.denominator))
        }
        Quantity::Determinant => whole(&determinant(m)),
        Quantity::Rank => whole(&Int::from(rank(m) as i64)),
        Quantity::Order => whole(&Int::from(m.rows() as i64)),
        Quantity::Trace => whole(&(0..m.rows()).fold(Int::ZERO, |sum, i| &sum + m.at(i, i))),
        Quantity::Least => whole(&m.entries().iter().min().cloned().unwrap_or_default()),
        Quantity::Largest => whole(&m.entries().iter().max().cloned().unwrap_or_default()),
        Quantity::Entry(i, j) if i < m.rows() && j < m.rows() => whole(m.at(i, j)),
        Quantity::Entry(..) => whole(&Int::ZERO),
    })
}

fn derive(m: &IMatrix, derived: &Derived) -> Option<IMatrix> {
    let n = m.rows();
    let inside = |mask: u64| (64 - mask.leading_zeros()) as usize <= n;
    match derived {
        Derived::Transpose => Some(m.transpose()),
        Derived::Symmetric => Some(m.symmetric_part()),
        Derived::Inverse => Some(principal_pivot_transform(m, &(0..n).collect::<Vec<_>>())?.0),
        Derived::Negative => Some(IMatrix::from_fn(n, n, |i, j| -m.at(i, j))),
        Derived::Principal(mask) => (inside(*mask) && *mask != 0).then(|| m.principal(&indices(*mask))),
        Derived::Transform(mask) => {
            inside(*mask).then(|| principal_pivot_transform(m, &indices(*mask)))?.map(|(m, _)| m)
        }
    }
}
