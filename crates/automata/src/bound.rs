//! How far an automaton is looked into: so many states, and no longer than until some time.

use linewright_core::deadline::{Deadline, Late};

/// An automaton may have so many states where nothing else is said.
pub const MOST_STATES: usize = 1 << 16;

/// It would take too much.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TooLarge {
    /// Something would have more of something than is sensible.
    #[error("there would be more than {limit} {what}")]
    Count {
        /// What there would be too much of: `states`.
        what: &'static str,
        /// How many there may be.
        limit: usize,
    },
    /// It takes longer than it may.
    #[error(transparent)]
    Late(#[from] Late),
}

/// How many states are looked at, and until when. A number alone is a bound without a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bound {
    /// So many states at most.
    pub states: usize,
    /// And no longer than that.
    pub until: Deadline,
}

impl Bound {
    /// So many states, until this time.
    pub fn new(states: usize, until: Deadline) -> Self {
        Self { states, until }
    }
}

impl From<usize> for Bound {
    fn from(states: usize) -> Self {
        Self {
            states,
            until: Deadline::NONE,
        }
    }
}
