//! Shows on a terminal how far a simulation is: one line, which is gone at the end.

use crate::line::monitor::Snapshot;
use crate::line::trace::clock;
use crate::line::{Count, Monitor};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::{self, Write as _};
use std::sync::Arc;
use std::time::Duration;

/// Time between two updates of the line.
const PERIOD: Duration = Duration::from_millis(200);

/// The line of a simulation. There is none if standard error is not a terminal.
pub struct RunProgress {
    shown: Option<(ProgressBar, Arc<Monitor>)>,
}

impl RunProgress {
    /// Shows the line until it is cleared.
    pub fn new(count: Count) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        if bar.is_hidden() {
            return Self { shown: None };
        }
        let monitor = Arc::new(Monitor::default());
        let watched = Arc::clone(&monitor);
        let text = move |_: &ProgressState, out: &mut dyn fmt::Write| {
            let text = line(watched.snapshot(), watched.runs(), count);
            let _ = out.write_str(&text);
        };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {run}") {
            bar.set_style(style.with_key("run", text));
        }
        bar.enable_steady_tick(PERIOD);
        Self {
            shown: Some((bar, monitor)),
        }
    }

    /// The monitor of the simulation.
    pub fn monitor(&self) -> Option<Arc<Monitor>> {
        self.shown.as_ref().map(|(_, monitor)| Arc::clone(monitor))
    }

    /// Removes the line.
    pub fn clear(self) {
        if let Some((bar, _)) = self.shown {
            bar.finish_and_clear();
        }
    }
}

/// The text of the line: `running: 3 of 10 replications, 2:46:40 (12 %), WIP 14, 3571 an hour`.
fn line(snapshot: Option<Snapshot>, runs: u64, count: Count) -> String {
    let mut text = "running".to_owned();
    let _ = match count {
        Count::Fixed(1) => Ok(()),
        Count::Fixed(wanted) => write!(text, ": {runs} of {wanted} replications"),
        Count::Until { most, .. } => write!(text, ": {runs} of at most {most} replications"),
    };
    if let Some(snapshot) = snapshot {
        let separator = if count == Count::Fixed(1) { ": " } else { ", " };
        let _ = write!(
            text,
            "{separator}{} ({:.0} %), WIP {}, {:.1} an hour",
            clock(snapshot.now),
            snapshot.share * 100.0,
            snapshot.wip,
            snapshot.throughput_per_hour
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_says_how_far_the_run_is() {
        let snapshot = Snapshot {
            now: 10_000.0,
            share: 0.125,
            wip: 14,
            throughput_per_hour: 3571.25,
        };
        let single = line(Some(snapshot), 0, Count::Fixed(1));
        assert_eq!(single, "running: 2:46:40 (12 %), WIP 14, 3571.2 an hour");
        let tenth = line(Some(snapshot), 3, Count::Fixed(10));
        assert_eq!(
            tenth,
            "running: 3 of 10 replications, 2:46:40 (12 %), WIP 14, 3571.2 an hour"
        );
        assert_eq!(line(None, 0, Count::Fixed(1)), "running");
        let until = Count::Until {
            precision: 0.01,
            most: 1000,
        };
        let text = line(None, 20, until);
        assert_eq!(text, "running: 20 of at most 1000 replications");
    }
}
