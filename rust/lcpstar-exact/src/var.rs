//! The variables of a complementary pivoting method.

/// `w_i`, `z_i`, or the artificial variable `z_0`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Var {
    /// A slack.
    W(usize),
    /// A variable.
    Z(usize),
    /// The artificial variable of Lemke's method.
    Z0,
}

impl Var {
    /// The other member of the pair `(w_i, z_i)`; `None` for `z_0`, which has no partner.
    #[must_use]
    pub fn complement(self) -> Option<Self> {
        match self {
            Self::W(i) => Some(Self::Z(i)),
            Self::Z(i) => Some(Self::W(i)),
            Self::Z0 => None,
        }
    }
}
