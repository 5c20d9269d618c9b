//! Limits on exploring an automaton: a number of states and a deadline.

use linewright_core::deadline::{Deadline, StopReason};

/// Default maximum number of states of an automaton.
pub const MOST_STATES: usize = 1 << 16;

/// Error for a result or a computation beyond its limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum BoundExceeded {
    /// A count would exceed its limit.
    #[error("there would be more than {limit} {what}")]
    Count {
        /// What is counted: `states`.
        what: &'static str,
        /// Maximum count.
        limit: usize,
    },
    /// The deadline has passed.
    #[error(transparent)]
    Late(#[from] StopReason),
}

/// Limits on exploring an automaton. Made from a number alone, it has no deadline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExplorationBound {
    /// Maximum number of states.
    pub states: usize,
    /// Deadline.
    pub until: Deadline,
}

impl ExplorationBound {
    /// Creates a bound of `states` states and a deadline.
    pub fn new(states: usize, until: Deadline) -> Self {
        Self { states, until }
    }
}

impl From<usize> for ExplorationBound {
    fn from(states: usize) -> Self {
        Self {
            states,
            until: Deadline::NONE,
        }
    }
}
