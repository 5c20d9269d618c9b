//! Limits on exploring an automaton: a number of states and a deadline.

use linewright_core::deadline::{Deadline, StopReason};

/// Default maximum number of states of an automaton.
pub const MAX_DFA_STATES: usize = 1 << 16;

/// Error for a computation that exceeded its limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum BoundExceeded {
    /// A count would exceed its limit.
    #[error("there would be more than {limit} {what}")]
    Count {
        /// Counted objects in the plural, such as `states`.
        what: &'static str,
        /// Maximum count.
        limit: usize,
    },
    /// The deadline has passed, or the user interrupted the command.
    #[error(transparent)]
    Stopped(#[from] StopReason),
}

/// Limits on exploring an automaton. A bound that is converted from a number of states has no
/// deadline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExplorationBound {
    /// Maximum number of states.
    pub max_states: usize,
    /// Deadline.
    pub deadline: Deadline,
}

impl ExplorationBound {
    /// Creates a bound of `max_states` states and a deadline.
    pub fn new(max_states: usize, deadline: Deadline) -> Self {
        Self {
            max_states,
            deadline,
        }
    }
}

impl From<usize> for ExplorationBound {
    fn from(max_states: usize) -> Self {
        Self {
            max_states,
            deadline: Deadline::NONE,
        }
    }
}
