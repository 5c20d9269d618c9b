//! When to give up by the clock: `--timeout`, made once a command and passed down. Nothing else below `cli` may let a clock decide.

use std::time::{Duration, Instant};

/// The time is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the time limit was reached")]
pub struct Late;

/// An instant after which work is given up; by default there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Deadline(Option<Instant>);

impl Deadline {
    /// Work is never given up.
    pub const NONE: Self = Self(None);

    /// This long after `began`. A time too far away for the clock is no deadline.
    pub fn after(began: Instant, patience: Duration) -> Self {
        Self(began.checked_add(patience))
    }

    /// This long from now.
    pub fn in_time(patience: Duration) -> Self {
        Self::after(Instant::now(), patience)
    }

    /// The same deadline, later by a grace period.
    #[must_use]
    pub fn extended(self, grace: Duration) -> Self {
        Self(self.0.and_then(|instant| instant.checked_add(grace)))
    }

    /// Whether it is past.
    pub fn is_past(self) -> bool {
        self.0.is_some_and(|instant| Instant::now() >= instant)
    }

    /// The time that is left, if there is a deadline at all.
    pub fn left(self) -> Option<Duration> {
        let left = |instant: Instant| instant.saturating_duration_since(Instant::now());
        self.0.map(left)
    }

    /// For loops that may take long.
    ///
    /// # Errors
    /// When the deadline is past.
    pub fn check(self) -> Result<(), Late> {
        if self.is_past() { Err(Late) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deadline_passes_and_none_never_does() {
        assert!(!Deadline::NONE.is_past());
        assert_eq!(Deadline::NONE.left(), None);
        let now = Deadline::in_time(Duration::ZERO);
        assert_eq!(now.check(), Err(Late));
        assert_eq!(now.left(), Some(Duration::ZERO));
        let later = now.extended(Duration::from_hours(1));
        assert_eq!(later.check(), Ok(()));
        assert!(
            later
                .left()
                .is_some_and(|left| left > Duration::from_mins(59))
        );
    }

    #[test]
    fn a_time_too_far_away_is_no_deadline() {
        assert_eq!(Deadline::in_time(Duration::MAX), Deadline::NONE);
    }
}
