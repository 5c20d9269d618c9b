//! Deadlines and cancellation: `--timeout` and Ctrl-C. Made once per command and passed down.
//! Outside of `cli`, nothing else may depend on a clock.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Reason for giving up work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StopReason {
    /// The deadline has passed.
    #[error("the time limit was reached")]
    Time,
    /// The caller has asked to stop.
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

/// An instant after which work is given up, and a flag that ends it at once. By default there is
/// neither.
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
    /// No deadline: work is never given up.
    pub const NONE: Self = Self {
        instant: None,
        interrupt: None,
    };

    /// Creates a deadline `patience` after `began`. A time too far away for the clock is no
    /// deadline.
    pub fn after(began: Instant, patience: Duration) -> Self {
        Self {
            instant: began.checked_add(patience),
            interrupt: None,
        }
    }

    /// Adds a flag: the deadline also counts as past as soon as the flag is set.
    #[must_use]
    pub fn or_when(self, interrupt: &'static AtomicBool) -> Self {
        Self {
            interrupt: Some(interrupt),
            ..self
        }
    }

    /// Creates a deadline `patience` from now.
    pub fn in_time(patience: Duration) -> Self {
        Self::after(Instant::now(), patience)
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

    /// Returns the remaining time; `None` if there is no deadline.
    pub fn left(self) -> Option<Duration> {
        let left = |instant: Instant| instant.saturating_duration_since(Instant::now());
        self.instant.map(left)
    }

    /// Checks the deadline; call it in loops that may take long.
    ///
    /// # Errors
    /// When the deadline is past.
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
        assert_eq!(Deadline::NONE.left(), None);
        let now = Deadline::in_time(Duration::ZERO);
        assert_eq!(now.check(), Err(StopReason::Time));
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

    #[test]
    fn an_interrupt_comes_before_the_time() {
        static FLAG: AtomicBool = AtomicBool::new(false);
        let [never, now] =
            [Deadline::NONE, Deadline::in_time(Duration::ZERO)].map(|d| d.or_when(&FLAG));
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
