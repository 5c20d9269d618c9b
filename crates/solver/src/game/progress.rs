//! Progress of a solve, for a thread that waits for it.
//!
//! A single kernel operation cannot be interrupted and can take minutes. So a caller with a
//! deadline does not wait for the solver. When the deadline passes, it reads the progress here and
//! abandons the solver's thread.

use super::fixpoint::Iterations;
use super::statistics::Statistics;
use std::fmt;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Phase of a solver run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Phase {
    /// Not started.
    #[default]
    NotStarted,
    /// The formulas are being encoded as functions.
    Encoding,
    /// The solver searches for a variable order.
    Ordering,
    /// The winning region is being computed.
    Fixpoint,
    /// The verdict is known; the solver searches for a core.
    Core,
    /// Finished.
    Ended,
}

const PHASES: [Phase; 6] = [
    Phase::NotStarted,
    Phase::Encoding,
    Phase::Ordering,
    Phase::Fixpoint,
    Phase::Core,
    Phase::Ended,
];

/// Progress of one solver run.
#[derive(Debug, Default)]
pub struct Progress {
    phase: AtomicU8,
    iterations: Iterations,
    statistics: Mutex<Statistics>,
}

impl Progress {
    /// Returns the current phase.
    pub fn phase(&self) -> Phase {
        PHASES[usize::from(self.phase.load(Ordering::Relaxed)).min(PHASES.len() - 1)]
    }

    /// Returns the statistics so far.
    pub fn statistics(&self) -> Statistics {
        let mut statistics = self.locked().clone();
        self.iterations.write_to(&mut statistics);
        statistics
    }

    /// Returns the progress as text that follows "the time limit was reached": `in round 12, step
    /// 31 of its fixpoint, with 3 of 40 goals settled and 1.2 M nodes`.
    pub fn describe(&self) -> String {
        ProgressDisplay(self).to_string()
    }

    pub(super) fn set_phase(&self, phase: Phase) {
        self.phase.store(phase as u8, Ordering::Relaxed);
    }

    /// Resets the progress for a run on another kernel; `statistics` are its initial values.
    pub(super) fn restart(&self, statistics: Statistics) {
        self.iterations.reset();
        *self.locked() = statistics;
        self.set_phase(Phase::Encoding);
    }

    pub(super) fn update(&self, change: impl FnOnce(&mut Statistics)) {
        change(&mut self.locked());
    }

    pub(super) fn iterations(&self) -> &Iterations {
        &self.iterations
    }

    fn locked(&self) -> MutexGuard<'_, Statistics> {
        self.statistics
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

struct ProgressDisplay<'a>(&'a Progress);

impl fmt::Display for ProgressDisplay<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let progress = self.0;
        match progress.phase() {
            Phase::NotStarted => f.write_str("before solving started"),
            Phase::Encoding => f.write_str("while encoding its formulas"),
            Phase::Ordering => f.write_str("while searching for an order of its variables"),
            Phase::Fixpoint | Phase::Core | Phase::Ended => {
                let get = |n: &std::sync::atomic::AtomicU64| n.load(Ordering::Relaxed);
                let at = &progress.iterations;
                let (rounds, steps) = (get(&at.outer), get(&at.inner));
                let plural = |n: u64| if n == 1 { "" } else { "s" };
                write!(
                    f,
                    "in round {rounds}, step {steps} of its fixpoint, with {} of {} goal{} settled and {} nodes",
                    get(&at.settled),
                    get(&at.goals),
                    plural(get(&at.goals)),
                    rounded(get(&at.nodes)),
                )
            }
        }
    }
}

/// Formats a count with at most three significant digits above 9999: `950`, `12 k`, `1.2 M`.
fn rounded(n: u64) -> String {
    match n {
        0..10_000 => n.to_string(),
        10_000..1_000_000 => format!("{} k", n / 1000),
        _ => format!("{:.1} M", n as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_are_numbered() {
        for (number, phase) in PHASES.into_iter().enumerate() {
            assert_eq!(phase as usize, number);
        }
    }

    #[test]
    fn progress_is_described() {
        let progress = Progress::default();
        assert_eq!(progress.describe(), "before solving started");
        progress.set_phase(Phase::Fixpoint);
        let at = progress.iterations();
        at.outer.store(12, Ordering::Relaxed);
        at.inner.store(31, Ordering::Relaxed);
        at.settled.store(3, Ordering::Relaxed);
        at.goals.store(40, Ordering::Relaxed);
        at.nodes.store(1_234_567, Ordering::Relaxed);
        assert_eq!(
            progress.describe(),
            "in round 12, step 31 of its fixpoint, with 3 of 40 goals settled and 1.2 M nodes"
        );
    }

    #[test]
    fn numbers_are_rounded() {
        assert_eq!(rounded(9_999), "9999");
        assert_eq!(rounded(12_345), "12 k");
        assert_eq!(rounded(1_250_000), "1.2 M");
    }
}
