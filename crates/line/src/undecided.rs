//! Why a question about a line has no answer.

use linewright_solver::game::Limit;
use std::fmt;

/// Why something was not decided.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Undecided {
    /// The reason, to be read after a colon.
    pub why: String,
    /// The limit that was reached, if that is the reason.
    pub limit: Option<Limit>,
}

impl Undecided {
    /// A reason that lies in the line.
    pub fn because(why: impl Into<String>) -> Self {
        Self {
            why: why.into(),
            limit: None,
        }
    }

    /// Whether the command came to a limit that it was given; otherwise the answer is the same
    /// wherever the question is asked.
    pub fn is_of_command(&self) -> bool {
        self.limit.is_some_and(Limit::is_of_command)
    }
}

impl From<Limit> for Undecided {
    fn from(limit: Limit) -> Self {
        Self {
            why: limit.to_string(),
            limit: Some(limit),
        }
    }
}

impl fmt::Display for Undecided {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.why)
    }
}
