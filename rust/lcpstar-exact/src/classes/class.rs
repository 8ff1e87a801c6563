//! Yes or no for every class, composed of the kernels: what bulk scans ask.

use super::budget::{Budget, Search};
use super::minors::{Rule, first_violation};
use super::solvable::{PlusPlus, Solvable, infeasibility_rays, plus_plus, solvable_when_feasible};
use super::zero_solutions::{Star, garcia_violation, nonzero_solution, regularity_violation, star_violation};
use super::{connected, definite, semimonotone, subdefinite, sufficient, transforms};
use crate::elimination::determinant;
use crate::imatrix::{IMatrix, by_size, indices, of_size};
use std::cell::RefCell;

/// The classes, named by their symbols.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // the symbols are the names
pub enum Class {
    PD,
    PSD,
    CSU,
    RSU,
    SU,
    P,
    P0,
    N,
    N0,
    C0,
    C,
    C0Plus,
    C0Star,
    E0,
    E,
    L2,
    L,
    PM,
    PSBD,
    C0f,
    E0f,
    AlmostP0,
    AlmostP,
    AlmostN0,
    AlmostN,
    AlmostC0,
    AlmostE,
    AlmostC0f,
    ExactOrder(usize),
    ExactOrderFull(usize),
    Z,
    K0,
    Ec,
    R,
    R0,
    Qb,
    Q,
    Q0,
    CQ,
    CQ0,
    E0s,
    CE0s,
    TE0s,
    CTE0s,
    PlusPlus,
}

/// Symbols and classes, in the order of the documentation.
pub const SYMBOLS: [(&str, Class); 43] = [
    ("PD", Class::PD),
    ("PSD", Class::PSD),
    ("CSU", Class::CSU),
    ("RSU", Class::RSU),
    ("SU", Class::SU),
    ("P", Class::P),
    ("P0", Class::P0),
    ("N", Class::N),
    ("N0", Class::N0),
    ("C0", Class::C0),
    ("C", Class::C),
    ("C0+", Class::C0Plus),
    ("C0*", Class::C0Star),
    ("E0", Class::E0),
    ("E", Class::E),
    ("L2", Class::L2),
    ("L", Class::L),
    ("PM", Class::PM),
    ("PSBD", Class::PSBD),
    ("C0f", Class::C0f),
    ("E0f", Class::E0f),
    ("almost-P0", Class::AlmostP0),
    ("almost-P", Class::AlmostP),
    ("almost-N0", Class::AlmostN0),
    ("almost-N", Class::AlmostN),
    ("almost-C0", Class::AlmostC0),
    ("almost-E", Class::AlmostE),
    ("almost-C0f", Class::AlmostC0f),
    ("Z", Class::Z),
    ("K0", Class::K0),
    ("Ec", Class::Ec),
    ("R", Class::R),
    ("R0", Class::R0),
    ("Qb", Class::Qb),
    ("Q", Class::Q),
    ("Q0", Class::Q0),
    ("cQ", Class::CQ),
    ("cQ0", Class::CQ0),
    ("E0s", Class::E0s),
    ("cE0s", Class::CE0s),
    ("tE0s", Class::TE0s),
    ("ctE0s", Class::CTE0s),
    ("++", Class::PlusPlus),
];

impl Class {
    /// The class of a symbol; `C0(k)` and `C0f(k)` for exact order k.
    #[must_use]
    pub fn parse(symbol: &str) -> Option<Self> {
        if let Some(&(_, class)) = SYMBOLS.iter().find(|(s, _)| *s == symbol) {
            return Some(class);
        }
        let order = |prefix: &str| symbol.strip_prefix(prefix)?.strip_suffix(')')?.parse().ok();
        order("C0(").map(Self::ExactOrder).or_else(|| order("C0f(").map(Self::ExactOrderFull))
    }
}

/// A matrix that remembers which classes it is in.
pub struct Facts {
    a: IMatrix,
    known: RefCell<Vec<(Class, bool)>>,
}

impl Facts {
    /// Nothing is known yet.
    #[must_use]
    pub fn new(a: IMatrix) -> Self {
        Self { a, known: RefCell::new(Vec::new()) }
    }

    /// The matrix.
    #[must_use]
    pub fn matrix(&self) -> &IMatrix {
        &self.a
    }

    /// Whether A is in the class.
    ///
    /// # Errors
    /// `Stopped` by the budget.
    pub fn holds(&self, class: Class, budget: &Budget<'_>) -> Search<bool> {
        let known = self.known.borrow().iter().find(|(c, _)| *c == class).map(|&(_, answer)| answer);
        if let Some(answer) = known {
            return Ok(answer);
        }
        let answer = self.decide(class, budget)?;
        self.known.borrow_mut().push((class, answer));
        Ok(answer)
    }

    fn decide(&self, class: Class, b: &Budget<'_>) -> Search<bool> {
        let a = &self.a;
        let minors = |rule, proper| Ok(first_violation(a, rule, proper, b)?.is_none());
        let almost = |rule, sign| Ok(determinant(a).sign() == sign && first_violation(a, rule, true, b)?.is_none());
        match class {
            Class::PD => Ok(definite::negative_direction(&a.symmetric_part(), true, b)?.is_none()),
            Class::PSD => Ok(definite::negative_direction(&a.symmetric_part(), false, b)?.is_none()),
            Class::CSU => Ok(sufficient::violation(a, b)?.is_none()),
            Class::RSU => Ok(sufficient::violation(&a.transpose(), b)?.is_none()),
            Class::SU => self.all(&[Class::CSU, Class::RSU], b),
            Class::P => minors(Rule::Positive, false),
            Class::P0 => minors(Rule::NonNegative, false),
            Class::N => minors(Rule::Negative, false),
            Class::N0 => minors(Rule::NonPositive, false),
            Class::AlmostP => almost(Rule::Positive, -1),
            Class::AlmostP0 => almost(Rule::NonNegative, -1),
            Class::AlmostN => almost(Rule::Negative, 1),
            Class::AlmostN0 => almost(Rule::NonPositive, 1),
            Class::C0 => Ok(semimonotone::copositive_violation(a, false, b)?.is_none()),
            Class::C => Ok(semimonotone::copositive_violation(a, true, b)?.is_none()),
            Class::C0Plus => {
                let s = a.symmetric_part();
                let flat = |x: &Vec<_>| s.times(x).iter().all(crate::int::Int::is_zero);
                Ok(self.holds(Class::C0, b)? && semimonotone::zeros_of_copositive_form(a, b)?.iter().all(flat))
            }
            Class::C0Star => Ok(self.holds(Class::C0, b)? && star_violation(a, Star::Plain, b)?.is_none()),
            Class::E0 => Ok(semimonotone::violation(a, false, b)?.is_none()),
            Class::E | Class::CQ => Ok(semimonotone::violation(a, true, b)?.is_none()),
            Class::L2 => Ok(garcia_violation(a, b)?.is_none()),
            Class::L => self.all(&[Class::E0, Class::L2], b),
            Class::PSBD => Ok(subdefinite::subdefinite_violation(a, b)?.is_none()),
            Class::PM => Ok(subdefinite::pseudomonotone_violation(a, b)?.is_none()),
            Class::C0f => self.every_transform(&[Class::C0], b),
            Class::E0f => self.every_transform(&[Class::E0], b),
            Class::AlmostC0 => self.exact_order(1, b),
            Class::ExactOrder(k) => self.exact_order(k, b),
            Class::AlmostC0f => self.exact_transforms(1, Class::C0, b),
            Class::ExactOrderFull(k) => self.exact_transforms(k, Class::E0, b),
            Class::AlmostE => Ok(semimonotone::violation(a, true, b)?.is_some_and(|x| x.iter().all(|v| v.sign() > 0))),
            Class::Z => Ok((0..a.rows()).all(|i| (0..a.rows()).all(|j| i == j || a.at(i, j).sign() <= 0))),
            Class::K0 => self.all(&[Class::Z, Class::P0], b),
            Class::Ec => {
                Ok(self.holds(Class::CSU, b)?
                    || (self.holds(Class::E0f, b)? && connected::disconnected(a, b)?.is_none()))
            }
            Class::R => Ok(regularity_violation(a, b)?.is_none()),
            Class::R0 => Ok(nonzero_solution(a, b)?.is_none()),
            Class::Q => Ok(infeasibility_rays(a).is_empty() && self.holds(Class::Q0, b)?),
            Class::Qb => self.all(&[Class::R0, Class::Q], b),
            Class::Q0 => self.solvable(b),
            Class::CQ0 => {
                Ok(self.holds(Class::Z, b)? || self.holds(Class::E, b)? || self.every_principal(Class::Q0, b)?)
            }
            Class::E0s => Ok(self.holds(Class::E0, b)? && star_violation(a, Star::Plain, b)?.is_none()),
            Class::TE0s => Ok(self.holds(Class::E0, b)? && star_violation(a, Star::Tilde, b)?.is_none()),
            Class::CE0s => self.every_principal(Class::E0s, b),
            Class::CTE0s => self.every_principal(Class::TE0s, b),
            Class::PlusPlus => Ok(matches!(plus_plus(a, b)?, PlusPlus::Holds(..))),
        }
    }

    /// Q0, quickly where a theorem decides: Z [Cha70]; L [Eav71]; E0 & R0 gives Q, P0 & Q gives R0 [AC79].
    fn solvable(&self, b: &Budget<'_>) -> Search<bool> {
        if self.holds(Class::Z, b)? || self.holds(Class::L, b)? {
            return Ok(true);
        }
        Ok(matches!(solvable_when_feasible(&self.a, b)?, Solvable::Everywhere(_)))
    }

    fn all(&self, classes: &[Class], b: &Budget<'_>) -> Search<bool> {
        for &class in classes {
            if !self.holds(class, b)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn every_principal(&self, class: Class, b: &Budget<'_>) -> Search<bool> {
        for alpha in by_size(self.a.rows()) {
            if !Self::new(self.a.principal(&indices(alpha))).holds(class, b)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn every_transform(&self, classes: &[Class], b: &Budget<'_>) -> Search<bool> {
        if !self.all(classes, b)? {
            return Ok(false);
        }
        for (_, m) in transforms::legitimate(&self.a, b)?.into_iter().skip(1) {
            if !Self::new(m).all(classes, b)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// All principal submatrices of order n - k are copositive, none of order n - k + 1 is; C0 for k = 0.
    fn exact_order(&self, k: usize, b: &Budget<'_>) -> Search<bool> {
        let n = self.a.rows();
        if k == 0 {
            return self.holds(Class::C0, b);
        }
        if k > n {
            // The only candidate of order n - k + 1 = 0 is the empty matrix, which is copositive.
            return Ok(k > n + 1);
        }
        let copositive = |alpha: u64| Self::new(self.a.principal(&indices(alpha))).holds(Class::C0, b);
        for alpha in of_size(n, n - k) {
            if !copositive(alpha)? {
                return Ok(false);
            }
        }
        for alpha in of_size(n, n - k + 1) {
            if copositive(alpha)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn exact_transforms(&self, k: usize, other: Class, b: &Budget<'_>) -> Search<bool> {
        let mut exact = false;
        for (_, m) in transforms::legitimate(&self.a, b)? {
            let m = Self::new(m);
            if m.exact_order(k, b)? {
                exact = true;
            } else if !m.holds(other, b)? {
                return Ok(false);
            }
        }
        Ok(exact)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn classes(rows: &[[i64; 3]]) -> Vec<&'static str> {
        let facts = Facts::new(IMatrix::from_rows(rows));
        let b = Budget::unlimited();
        SYMBOLS.iter().filter(|(_, c)| facts.holds(*c, &b).expect("no limit")).map(|(s, _)| *s).collect()
    }

    /// [JDS], numerical example: tilde class, not P0, not connected.
    #[test]
    fn papers_numerical_example() {
        let found = classes(&[[0, 1, 1], [2, 0, 2], [-2, -5, 0]]);
        assert_eq!(found, ["E0", "L2", "L", "Q0", "E0s", "tE0s"]);
    }

    /// [JDS], example 10: a Q-matrix by regularity; example 9: P0 and E0s, not tE0s, Q0 without being L2.
    #[test]
    fn papers_examples_9_and_10() {
        let found = classes(&[[0, 2, 1], [1, 0, 1], [-2, -2, 1]]);
        assert_eq!(found, ["E0", "L2", "L", "R", "R0", "Qb", "Q", "Q0", "E0s", "tE0s"]);
        let found = classes(&[[1, -1, -2], [-1, 1, 0], [0, 0, 1]]);
        for (symbol, expected) in [("P0", true), ("E0s", true), ("Q0", true), ("tE0s", false), ("L2", false)] {
            assert_eq!(found.contains(&symbol), expected, "{symbol}");
        }
    }

    /// A positive definite matrix is in everything that contains P, PSD and C.
    #[test]
    fn identity() {
        let found = classes(&[[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
        let outside = SYMBOLS.iter().filter(|(s, _)| !found.contains(s)).map(|(s, _)| *s).collect::<Vec<_>>();
        assert_eq!(
            outside,
            ["N", "N0", "almost-P0", "almost-P", "almost-N0", "almost-N", "almost-C0", "almost-E", "almost-C0f"]
        );
    }

    /// A stopped search is an error, never a wrong answer.
    #[test]
    fn cancelled_search_says_so() {
        let n = 26;
        let a = IMatrix::from_fn(n, n, |i, j| crate::int::Int::from(if i == j { 1 } else { 7 * i64::from(j > i) }));
        let stop = || true;
        let budget = Budget::new(None, Some(&stop));
        let answer = Facts::new(a).holds(Class::E0, &budget);
        assert_eq!(answer, Err(crate::classes::budget::Stopped::Cancelled));
    }
}
