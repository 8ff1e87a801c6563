//! What a caller can get wrong. An LCP that cannot be solved is a [`Status`](crate::Status), never an error.

use std::fmt;

/// `Result` with [`LcpError`].
pub type Result<T> = std::result::Result<T, LcpError>;

/// A broken promise of the caller: names the argument, shows the number, says the rule.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LcpError {
    /// `name` must be a square matrix.
    NotSquare {
        /// Argument.
        name: &'static str,
        /// Rows found.
        rows: usize,
        /// Columns found.
        columns: usize,
    },
    /// `name` must have `expected` entries.
    WrongLength {
        /// Argument.
        name: &'static str,
        /// Entries it should have.
        expected: usize,
        /// Entries it has.
        found: usize,
    },
    /// An entry is NaN or infinite.
    NotFinite {
        /// Argument.
        name: &'static str,
        /// Row-major position, one index for a vector, two for a matrix.
        index: Vec<usize>,
        /// The entry.
        value: f64,
    },
    /// An entry must be strictly positive.
    NonPositive {
        /// Argument.
        name: &'static str,
        /// Position.
        index: usize,
        /// The entry.
        value: f64,
    },
    /// An entry must not be negative.
    Negative {
        /// Argument.
        name: &'static str,
        /// Position.
        index: usize,
        /// The entry.
        value: f64,
    },
    /// An index set holds an index that is out of range or repeated.
    BadIndex {
        /// Argument.
        name: &'static str,
        /// The index.
        index: i64,
        /// The order of the matrix.
        n: usize,
        /// Whether it was repeated rather than out of range.
        repeated: bool,
    },
    /// A scalar option is outside its range.
    OutOfRange {
        /// Option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The rule it breaks, e.g. `"in (0, 1)"`.
        rule: &'static str,
    },
    /// A named choice is unknown.
    UnknownName {
        /// Option.
        name: &'static str,
        /// What was given.
        value: String,
        /// What could be given.
        choices: &'static [&'static str],
    },
    /// The principal block `A[alpha, alpha]` of a pivot is singular.
    SingularBlock {
        /// The index set.
        alpha: Vec<usize>,
        /// Its rank as the elimination saw it.
        rank: usize,
    },
    /// The start is not strictly feasible: `name[index] = value` must be positive.
    NotStrictlyFeasible {
        /// `"z0"` or `"A z0 + q"`.
        name: &'static str,
        /// Position.
        index: usize,
        /// The entry.
        value: f64,
    },
    /// The matrix is larger than the method can take.
    TooLarge {
        /// The method or function.
        name: &'static str,
        /// The order of the matrix.
        n: usize,
        /// The largest order accepted.
        limit: usize,
    },
    /// An option that this function does not take.
    NotTaken {
        /// The option.
        name: &'static str,
        /// The function.
        by: &'static str,
    },
}

impl fmt::Display for LcpError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSquare { name, rows, columns } => {
                write!(f, "{name} must be square, got {rows} rows and {columns} columns")
            }
            Self::WrongLength { name, expected, found } => {
                write!(f, "{name} must have length {expected}, got {found}")
            }
            Self::NotFinite { name, index, value } => {
                let index: Vec<String> = index.iter().map(ToString::to_string).collect();
                write!(f, "{name} must be finite, got {name}[{}] = {value}", index.join(", "))
            }
            Self::NonPositive { name, index, value } => {
                write!(f, "{name} must be strictly positive, got {name}[{index}] = {value}")
            }
            Self::Negative { name, index, value } => {
                write!(f, "{name} must be nonnegative, got {name}[{index}] = {value}")
            }
            Self::BadIndex { name, index, n, repeated: false } => {
                write!(f, "{name} must hold indices in 0..{n}, got {index}")
            }
            Self::BadIndex { name, index, repeated: true, .. } => {
                write!(f, "{name} must not repeat an index, got {index} twice")
            }
            Self::OutOfRange { name, value, rule } => write!(f, "{name} must be {rule}, got {value}"),
            Self::UnknownName { name, value, choices } => {
                write!(f, "{name} must be one of {}, got {value:?}", choices.join(", "))
            }
            Self::SingularBlock { alpha, rank } => write!(
                f,
                "A[alpha, alpha] is singular for alpha = {alpha:?}: rank {rank} of {}, no principal pivot transform exists",
                alpha.len()
            ),
            Self::NotStrictlyFeasible { name, index, value } => {
                write!(f, "z0 must be strictly feasible (z0 > 0 and A z0 + q > 0), got ({name})[{index}] = {value}")
            }
            Self::TooLarge { name, n, limit } => write!(f, "{name} takes n <= {limit}, got n = {n}"),
            Self::NotTaken { name, by } => write!(f, "{by} takes no {name}"),
        }
    }
}

impl std::error::Error for LcpError {}
