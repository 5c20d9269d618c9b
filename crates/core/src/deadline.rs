//! Deadlines and cancellation: `--timeout` and Ctrl-C. Each command creates one deadline and passes
//! it down. Elapsed time affects the result of a command only through its deadline.

use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Reason why work was stopped before it was complete.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
pub enum StopReason {
    /// The deadline has passed.
    #[error("the time limit was reached")]
    Time,
    /// The caller has requested a stop.
    #[error("it was interrupted")]
    Interrupt,
}

impl StopReason {
    /// Returns what the user can do to let the work finish.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Time => "give it more time with --timeout SECONDS",
            Self::Interrupt => "run it again",
        }
    }
}

/// A time limit and an interrupt flag, both optional: work stops when the time has passed or the
/// flag is set. The default has neither.
#[derive(Debug, Clone, Copy, Default)]
pub struct Deadline {
    instant: Option<Instant>,
    interrupt: Option<&'static AtomicBool>,
}

impl PartialEq for Deadline {
    fn eq(&self, other: &Self) -> bool {
        let flag = |deadline: &Self| deadline.interrupt.map(std::ptr::from_ref);
        self.instant == other.instant && flag(self) == flag(other)
    }
}

impl Eq for Deadline {}

impl Deadline {
    /// No deadline: work is never stopped.
    pub const NONE: Self = Self {
        instant: None,
        interrupt: None,
    };

    /// Creates a deadline `limit` after `start`; without a time limit if that instant is beyond the
    /// range of the clock.
    pub fn after(start: Instant, limit: Duration) -> Self {
        Self {
            instant: start.checked_add(limit),
            interrupt: None,
        }
    }

    /// Adds an interrupt flag: the deadline is also past once the flag is set.
    #[must_use]
    pub fn with_interrupt(self, interrupt: &'static AtomicBool) -> Self {
        Self {
            interrupt: Some(interrupt),
            ..self
        }
    }

    /// Creates a deadline `limit` from now.
    pub fn from_now(limit: Duration) -> Self {
        Self::after(Instant::now(), limit)
    }

    /// Returns this deadline, extended by a grace period.
    #[must_use]
    pub fn extended(self, grace: Duration) -> Self {
        let later = |instant: Instant| instant.checked_add(grace);
        Self {
            instant: self.instant.and_then(later),
            ..self
        }
    }

    /// Returns whether the deadline has passed or its flag is set.
    pub fn is_past(self) -> bool {
        self.check().is_err()
    }

    /// Returns the remaining time, zero once the time has passed; `None` without a time limit.
    pub fn remaining(self) -> Option<Duration> {
        let remaining = |instant: Instant| instant.saturating_duration_since(Instant::now());
        self.instant.map(remaining)
    }

    /// Checks the deadline; call this in loops that can take long.
    ///
    /// # Errors
    /// Returns the reason if the flag is set or the time has passed; the flag takes precedence.
    pub fn check(self) -> Result<(), StopReason> {
        if self
            .interrupt
            .is_some_and(|flag| flag.load(Ordering::Relaxed))
        {
            Err(StopReason::Interrupt)
        } else if self
            .instant
            .is_some_and(|instant| Instant::now() >= instant)
        {
            Err(StopReason::Time)
        } else {
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deadline_passes_and_none_never_does() {
        assert!(!Deadline::NONE.is_past());
        assert_eq!(Deadline::NONE.remaining(), None);
        let now = Deadline::from_now(Duration::ZERO);
        assert_eq!(now.check(), Err(StopReason::Time));
        assert_eq!(now.remaining(), Some(Duration::ZERO));
        let later = now.extended(Duration::from_hours(1));
        assert_eq!(later.check(), Ok(()));
        assert!(
            later
                .remaining()
                .is_some_and(|remaining| remaining > Duration::from_mins(59))
        );
    }

    #[test]
    fn a_time_too_far_away_is_no_deadline() {
        assert_eq!(Deadline::from_now(Duration::MAX), Deadline::NONE);
    }

    #[test]
    fn an_interrupt_comes_before_the_time() {
        static FLAG: AtomicBool = AtomicBool::new(false);
        let [never, now] =
            [Deadline::NONE, Deadline::from_now(Duration::ZERO)].map(|d| d.with_interrupt(&FLAG));
        assert_eq!(
            [never.check(), now.check()],
            [Ok(()), Err(StopReason::Time)]
        );
        FLAG.store(true, Ordering::Relaxed);
        let interrupted = Err(StopReason::Interrupt);
        assert_eq!([never.check(), now.check()], [interrupted; 2]);
        assert_eq!(never.extended(Duration::from_hours(1)).check(), interrupted);
    }
}
