//! How far a question about orders is looked into: so many states, and no longer than until some time.

use std::time::Instant;

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
    #[error("the time limit was reached")]
    Late,
}

/// When to give up; never by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Until(Option<Instant>);

impl Until {
    /// At a time, if there is one.
    pub fn new(deadline: Option<Instant>) -> Self {
        Self(deadline)
    }

    /// Whether the time is over.
    ///
    /// # Errors
    /// When it is.
    pub fn check(self) -> Result<(), TooLarge> {
        match self.0 {
            Some(deadline) if Instant::now() >= deadline => Err(TooLarge::Late),
            _ => Ok(()),
        }
    }

    /// A bound of so many states, until this time.
    pub fn within(self, states: usize) -> Bound {
        Bound {
            states,
            until: self,
        }
    }
}

/// How many states are looked at, and until when. A number alone is a bound without a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bound {
    /// So many states at most.
    pub states: usize,
    /// And no longer than that.
    pub until: Until,
}

impl From<usize> for Bound {
    fn from(states: usize) -> Self {
        Self {
            states,
            until: Until::default(),
        }
    }
}
