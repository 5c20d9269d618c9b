//! Why a question about a line has no answer.

use linewright_solver::game::Limit;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Why something was not decided.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UndecidedReason {
    /// The reason, phrased to follow a colon.
    pub why: String,
    /// The limit that was reached, if that is the reason.
    pub limit: Option<Limit>,
}

impl UndecidedReason {
    /// Creates a reason that lies in the line itself, not in a limit.
    pub fn because(why: impl Into<String>) -> Self {
        Self {
            why: why.into(),
            limit: None,
        }
    }

    /// Whether the reason is a limit from `--timeout`, `--memory` or Ctrl-C. If it is not, a
    /// repetition gives the same answer.
    pub fn is_external(&self) -> bool {
        self.limit.is_some_and(Limit::is_external)
    }
}

impl From<Limit> for UndecidedReason {
    fn from(limit: Limit) -> Self {
        Self {
            why: limit.to_string(),
            limit: Some(limit),
        }
    }
}

impl fmt::Display for UndecidedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.why)
    }
}
