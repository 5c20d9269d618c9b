//! A value that stands alone: text from outside of a file, which replaces the value of a statement.

use super::ast::{Between, Expr, TimeValue};
use super::parser::Rule;

/// The statement to which a value belongs, which determines the syntax of the value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueSyntax {
    /// An expression.
    Expression,
    /// A duration, or the distribution from which it is drawn.
    Time,
    /// A duration, optionally with `random` before it.
    Interval,
    /// The time of an action: an expression, optionally followed by `per step`.
    ActionTime,
    /// The bound of a requirement: an expression, optionally followed by `per hour`.
    Bound,
    /// The limit of a line: an expression, optionally followed by `products`.
    Limit,
    /// A whole number.
    Count,
    /// A number of parts, or the distribution from which it is drawn, optionally followed by
    /// `parts`.
    Parts,
}

impl ValueSyntax {
    /// The grammar's entry point.
    pub(super) fn rule(self) -> Rule {
        match self {
            Self::Expression => Rule::only_expression,
            Self::Time => Rule::only_duration,
            Self::Interval => Rule::only_interval,
            Self::ActionTime => Rule::only_time,
            Self::Bound => Rule::only_bound,
            Self::Limit => Rule::only_limit,
            Self::Count => Rule::only_count,
            Self::Parts => Rule::only_parts,
        }
    }
}

/// A parsed value. The flag says whether the statement's own words (`random`, `per step`,
/// `per hour`, `products`) were given.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// An expression.
    Expression(Expr, bool),
    /// A duration.
    Time(TimeValue, bool),
    /// A whole number.
    Count(u64),
    /// A number of parts.
    Parts(Between),
}
