//! Shows how far a run is, while it goes on.
//!
//! The event loop writes a snapshot every `INTERVAL` events, and only if nobody is reading the
//! last one, so that runs neither wait nor depend on who reads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Number of events between two snapshots.
pub(super) const INTERVAL: u64 = 1024;

/// How far a run is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Snapshot {
    /// Simulated seconds.
    pub now: f64,
    /// How much of the run is done, from 0 to 1.
    pub share: f64,
    /// Number of parts in the line.
    pub wip: u64,
    /// End products per hour since counting began.
    pub throughput_per_hour: f64,
}

/// Watches the runs of a line.
#[derive(Debug, Default)]
pub struct Monitor {
    snapshot: Mutex<Option<Snapshot>>,
    runs: AtomicU64,
}

impl Monitor {
    /// The last snapshot of the run that is shown; `None` before the first one.
    pub fn snapshot(&self) -> Option<Snapshot> {
        self.snapshot.lock().map_or(None, |snapshot| *snapshot)
    }

    /// Number of complete runs.
    pub fn runs(&self) -> u64 {
        self.runs.load(Ordering::Relaxed)
    }

    pub(super) fn write(&self, snapshot: Snapshot) {
        if let Ok(mut last) = self.snapshot.try_lock() {
            *last = Some(snapshot);
        }
    }

    pub(super) fn count_run(&self) {
        self.runs.fetch_add(1, Ordering::Relaxed);
    }
}
