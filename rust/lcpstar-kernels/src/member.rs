//! Who answered: the methods that a user may name, and what the portfolio adds to them.

macro_rules! members {
    ($($(#[$doc:meta])* $name:ident = $text:literal,)*) => {
        /// Who found an answer. Its number is its code in a batch.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        #[non_exhaustive]
        pub enum Member {
            $($(#[$doc])* $name,)*
        }

        impl Member {
            /// All of them, in the order of their codes.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];
            /// Their names, in the same order.
            pub const NAMES: &'static [&'static str] = &[$($text,)*];
        }
    };
}

members! {
    /// The whole portfolio: what a batch says of a method that has no other name.
    Auto = "auto",
    /// Lemke's method with `d = e` or the caller's.
    Lemke = "lemke",
    /// Lemke-Howson on bimatrix structure.
    LemkeHowson = "lemke_howson",
    /// Criss-cross pivoting.
    PrincipalPivoting = "principal_pivoting",
    /// Block principal pivoting.
    BlockPivoting = "block_pivoting",
    /// Chandrasekaran's method for Z-matrices.
    Chandrasekaran = "chandrasekaran",
    /// Every index set.
    Enumerate = "enumerate",
    /// Successive linear programmes.
    Bilinear = "bilinear",
    /// The homogeneous predictor-corrector method.
    InteriorPoint = "interior_point",
    /// The paper's method.
    PotentialReduction = "potential_reduction",
    /// Newton's method on the minimum map.
    Newton = "newton",
    /// Projected Gauss-Seidel.
    Pgs = "pgs",
    /// Projected Gauss-Seidel with subspace minimisation.
    PgsSm = "pgs_sm",
    /// Nonsmooth nonlinear conjugate gradients.
    Nncg = "nncg",
    /// Accelerated projected gradients.
    Apgd = "apgd",
    /// ADMM.
    Admm = "admm",
    /// `q >= 0`: z = 0.
    Trivial = "trivial",
    /// The caller's guess as it stood, or a few exchanges from it.
    WarmStart = "warm_start",
    /// Several parts of the problem, each by a member of its own.
    Pieces = "pieces",
    /// Lemke's method in the kernel for small problems.
    LemkeSmall = "lemke_small",
    /// Lemke's method from the support of the guess.
    LemkeWarm = "lemke_warm",
    /// Lemke's method with a random covering vector.
    LemkeRandomD = "lemke_random_d",
    /// Lemke's method in double-double arithmetic.
    LemkeDoubleDouble = "lemke_double_double",
    /// Criss-cross pivoting in double-double arithmetic.
    PrincipalPivotingDoubleDouble = "principal_pivoting_double_double",
    /// The linear programme that decides whether FEA(q, A) is empty.
    Feasibility = "feasibility",
    /// Lemke's method in exact arithmetic.
    ExactLemke = "exact_lemke",
}

impl Member {
    /// Its name in results.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        Self::NAMES[usize::from(self.code())]
    }

    /// Its number in results of a batch: the place in [`Member::ALL`].
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }
}
