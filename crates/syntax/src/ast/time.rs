//! Durations, distributions and failures in the syntax tree.

use super::{Expr, Name};
use linewright_core::source::Span;

/// A duration: one value, or a distribution of values.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeValue {
    /// `2 s`
    Value(Expr),
    /// `triangular(1 s, 2 s, 4 s)`
    Drawn {
        /// Name of the distribution.
        name: Name,
        /// Parameters of the distribution.
        outcomes: Vec<Outcome>,
        /// Place of the whole distribution.
        span: Span,
    },
    /// `empirical("times.csv" column duration in s)`
    Empirical {
        /// The observed durations.
        column: Column,
        /// Place of the whole distribution.
        span: Span,
    },
}

impl TimeValue {
    /// Place of the duration.
    pub fn span(&self) -> Span {
        match self {
            Self::Value(value) => value.span,
            Self::Drawn { span, .. } | Self::Empirical { span, .. } => *span,
        }
    }

    /// The expressions in the duration, in source order.
    pub fn expressions(&self) -> Vec<&Expr> {
        match self {
            Self::Value(value) => vec![value],
            Self::Drawn { outcomes, .. } => outcomes
                .iter()
                .flat_map(|outcome| std::iter::once(&outcome.value).chain(&outcome.weight))
                .collect(),
            Self::Empirical { .. } => Vec::new(),
        }
    }

    /// The column of a table that the duration is drawn from.
    pub fn column(&self) -> Option<&Column> {
        match self {
            Self::Empirical { column, .. } => Some(column),
            Self::Value(_) | Self::Drawn { .. } => None,
        }
    }
}

/// `"times.csv" column duration in s`: a column of a CSV file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Path relative to the file with the statement. Its span includes the quotes.
    pub path: Name,
    /// Header of the column. Its span includes the quotes.
    pub header: Name,
    /// Whether the header is written in quotes.
    pub quoted: bool,
    /// Unit of the numbers.
    pub unit: Name,
}

impl Column {
    /// Place of the whole column.
    pub fn span(&self) -> Span {
        self.path.span.to(self.unit.span)
    }
}

/// `2 s` or `2 s: 30 %` in the parentheses of a distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// A parameter, or a value that can be drawn.
    pub value: Expr,
    /// Probability of the value, in a discrete distribution.
    pub weight: Option<Expr>,
}

/// `failures jam: mtbf 8 h mttr 5 min by calendar restart`
#[derive(Debug, Clone, PartialEq)]
pub struct Failures {
    /// Name of the failure mode, if any.
    pub name: Option<Name>,
    /// When the failures occur.
    pub between: Between,
    /// Time to repair.
    pub mttr: TimeValue,
    /// Whether the time between failures runs by the calendar, not by working time.
    pub calendar: bool,
    /// What happens to the work that a failure interrupts.
    pub interrupted: InterruptedWork,
    /// Place of the whole statement.
    pub span: Span,
}

/// What happens to work that a failure interrupts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum InterruptedWork {
    /// It goes on after the repair.
    #[default]
    Resumes,
    /// `restart`: it begins again after the repair.
    Restarts,
    /// `scrap`: the part is scrap.
    ScrapsPart,
}

/// What lies between two failures.
#[derive(Debug, Clone, PartialEq)]
pub enum Between {
    /// `mtbf 8 h`: a time.
    Time(TimeValue),
    /// `every 500 parts`: a number of parts.
    Parts(u64),
    /// `every uniform(400, 600) parts`: a number of parts that is drawn from a distribution.
    DrawnParts(TimeValue),
}

impl Failures {
    /// The expressions in the statement, in source order.
    pub fn expressions(&self) -> Vec<&Expr> {
        let between = match &self.between {
            Between::Time(value) | Between::DrawnParts(value) => value.expressions(),
            Between::Parts(_) => Vec::new(),
        };
        between.into_iter().chain(self.mttr.expressions()).collect()
    }
}
