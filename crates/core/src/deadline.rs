//! Deadlines and cancellation: `--timeout`, `--memory` and Ctrl-C. Each command creates one
//! deadline and passes it down. Elapsed time and the memory of the process affect the result of a
//! command only through its deadline.

use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
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
    /// The process takes more memory than it may.
    #[error("the memory limit was reached")]
    Memory,
}

impl StopReason {
    /// Returns what the user can do to let the work finish.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Time => "give it more time with --timeout SECONDS",
            Self::Interrupt => "run it again",
            Self::Memory => "allow more memory with --memory MIB",
        }
    }
}

/// Measures the memory of the process. Measuring takes microseconds, so that frequent checks use
/// the last value, and measure again only if it is above the limit.
#[derive(Debug)]
pub struct MemoryGauge {
    /// Returns the resident memory in bytes; `None` if the system does not tell.
    measure: fn() -> Option<u64>,
    /// The last value, in bytes.
    last: AtomicU64,
    /// Whether a check has failed since the program began.
    exceeded: AtomicBool,
}

impl MemoryGauge {
    /// Creates a gauge from a function that returns the resident memory of the process in bytes;
    /// `None` if the system does not tell.
    pub const fn new(measure: fn() -> Option<u64>) -> Self {
        Self {
            measure,
            last: AtomicU64::new(0),
            exceeded: AtomicBool::new(false),
        }
    }

    /// Measures the memory of the process and returns it in bytes; 0 if the system does not tell.
    pub fn sample(&self) -> u64 {
        let now = (self.measure)().unwrap_or(0);
        self.last.store(now, Ordering::Relaxed);
        now
    }
}

/// Limit on the memory of the process.
#[derive(Debug, Clone, Copy)]
struct MemoryLimit {
    gauge: &'static MemoryGauge,
    bytes: u64,
}

/// A time limit, a memory limit and an interrupt flag, all optional: work stops when the time has
/// passed, the process takes too much memory, or the flag is set. The default has none.
#[derive(Debug, Clone, Copy, Default)]
pub struct Deadline {
    instant: Option<Instant>,
    interrupt: Option<&'static AtomicBool>,
    memory: Option<MemoryLimit>,
}

impl PartialEq for Deadline {
    fn eq(&self, other: &Self) -> bool {
        let flag = |deadline: &Self| deadline.interrupt.map(std::ptr::from_ref);
        let memory = |deadline: &Self| deadline.memory.map(|limit| limit.bytes);
        self.instant == other.instant && flag(self) == flag(other) && memory(self) == memory(other)
    }
}

impl Eq for Deadline {}

impl Deadline {
    /// No deadline: work is never stopped.
    pub const NONE: Self = Self {
        instant: None,
        interrupt: None,
        memory: None,
    };

    /// Creates a deadline `limit` after `start`; without a time limit if that instant is beyond the
    /// range of the clock.
    pub fn after(start: Instant, limit: Duration) -> Self {
        Self {
            instant: start.checked_add(limit),
            ..Self::NONE
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

    /// Adds a limit on the memory of the process, in bytes. The gauge must be
    /// [sampled](Self::sample_memory) regularly.
    #[must_use]
    pub fn with_memory_limit(self, gauge: &'static MemoryGauge, bytes: u64) -> Self {
        Self {
            memory: Some(MemoryLimit { gauge, bytes }),
            ..self
        }
    }

    /// Measures the memory of the process if it is limited.
    pub fn sample_memory(self) {
        if let Some(limit) = self.memory {
            limit.gauge.sample();
        }
    }

    /// Returns how much more memory the process may take, in bytes, by the last measurement;
    /// `u64::MAX` without a limit.
    pub fn memory_left(self) -> u64 {
        self.memory.map_or(u64::MAX, |limit| {
            let last = limit.gauge.last.load(Ordering::Relaxed);
            limit.bytes.saturating_sub(last)
        })
    }

    /// Returns whether a check has ever found the memory limit exceeded.
    pub fn has_exceeded_memory(self) -> bool {
        self.memory
            .is_some_and(|limit| limit.gauge.exceeded.load(Ordering::Relaxed))
    }

    /// Creates a deadline `limit` from now.
    pub fn from_now(limit: Duration) -> Self {
        Self::after(Instant::now(), limit)
    }

    /// Returns this deadline, extended by a grace period and 1/16 of the memory.
    #[must_use]
    pub fn extended(self, grace: Duration) -> Self {
        let later = |instant: Instant| instant.checked_add(grace);
        let more = |limit: MemoryLimit| MemoryLimit {
            bytes: limit.bytes.saturating_add(limit.bytes / 16),
            ..limit
        };
        Self {
            instant: self.instant.and_then(later),
            memory: self.memory.map(more),
            ..self
        }
    }

    /// Returns whether work must stop.
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
    /// Returns the reason if the flag is set, the time has passed or the process takes too much
    /// memory, in this order of precedence.
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
        } else if self.memory.is_some_and(MemoryLimit::is_exceeded) {
            Err(StopReason::Memory)
        } else {
            Ok(())
        }
    }
}

impl MemoryLimit {
    /// Returns whether the process takes more memory. Measures it only if the last value was above
    /// the limit: work that was stopped may have freed its memory since.
    fn is_exceeded(self) -> bool {
        let is_exceeded = self.gauge.last.load(Ordering::Relaxed) > self.bytes
            && self.gauge.sample() > self.bytes;
        if is_exceeded {
            self.gauge.exceeded.store(true, Ordering::Relaxed);
        }
        is_exceeded
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

    #[test]
    fn memory_is_measured_again_before_work_is_stopped() {
        static MEMORY: AtomicU64 = AtomicU64::new(0);
        static GAUGE: MemoryGauge = MemoryGauge::new(|| Some(MEMORY.load(Ordering::Relaxed)));
        let limited = Deadline::NONE.with_memory_limit(&GAUGE, 100);
        assert_eq!((limited.check(), limited.memory_left()), (Ok(()), 100));
        MEMORY.store(105, Ordering::Relaxed);
        assert_eq!(limited.check(), Ok(()), "no measurement yet");
        limited.sample_memory();
        assert_eq!(limited.memory_left(), 0);
        assert_eq!(limited.check(), Err(StopReason::Memory));
        assert_eq!(limited.extended(Duration::ZERO).check(), Ok(()));
        MEMORY.store(40, Ordering::Relaxed);
        assert_eq!((limited.check(), limited.memory_left()), (Ok(()), 60));
        assert!(limited.has_exceeded_memory());
        assert_eq!(Deadline::NONE.memory_left(), u64::MAX);
    }

    #[test]
    fn a_system_that_does_not_tell_sets_no_limit() {
        static GAUGE: MemoryGauge = MemoryGauge::new(|| None);
        let limited = Deadline::NONE.with_memory_limit(&GAUGE, 0);
        limited.sample_memory();
        assert_eq!(limited.check(), Ok(()));
        assert!(!limited.has_exceeded_memory());
    }
}
