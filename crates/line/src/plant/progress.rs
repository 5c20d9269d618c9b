//! Detects that a run makes no progress: either a livelock, or work that leads to no product.

use super::Run;
use crate::monitor::Snapshot;
use crate::trace::End;
use linewright_core::diagnostics::{Diagnostic, codes};

/// Latest time of a run, in seconds. Beyond it, the clock does not resolve a microsecond.
pub(super) const LATEST_SECONDS: f64 = 4e9;
/// Maximum number of movements and events at one instant, beyond which the run counts as a
/// livelock.
const MAX_AT_ONE_INSTANT: u64 = 1_000_000;
/// Maximum number of violations at one instant, beyond which the run counts as a livelock. This
/// limit is lower, because each violation can take as long to simulate as a whole operation.
const MAX_VIOLATIONS_AT_ONE_INSTANT: u64 = 10_000;
/// Maximum number of events since the last end product, beyond which a run that waits for products
/// counts as making none.
const MAX_EVENTS_WITHOUT_PRODUCT: u64 = 5_000_000;
/// Number of events since the last end product after which such a run is examined for a deadlock.
const EVENTS_BEFORE_EXAMINATION: u64 = 100_000;
/// Maximum number of violations since the last end product, with the same meaning.
const MAX_VIOLATIONS_WITHOUT_PRODUCT: u64 = 500;

/// Stands for the number of movements and events at an instant at which nothing must move any more.
const STOPPED: u64 = u64::MAX / 2;

/// Activity since time last advanced, and since the last end product.
#[derive(Debug)]
pub(super) struct Progress {
    /// Time of the current instant, in seconds.
    instant: f64,
    /// Number of movements and events at this instant, or [`STOPPED`] and above.
    at_instant: u64,
    /// Number of violations at this instant.
    pub violations_at_instant: u64,
    /// Number of violations up to the last end product.
    violations_at_product: u64,
    /// Numbers of events and of violations up to which a run that waits for products has to make
    /// the next one.
    last_event: u64,
    last_violation: u64,
    /// Whether the run has been examined for a deadlock since the last end product.
    is_examined: bool,
}

impl Default for Progress {
    fn default() -> Self {
        Self {
            instant: 0.0,
            at_instant: 0,
            violations_at_instant: 0,
            violations_at_product: 0,
            last_event: EVENTS_BEFORE_EXAMINATION,
            is_examined: false,
            last_violation: MAX_VIOLATIONS_WITHOUT_PRODUCT,
        }
    }
}

impl Progress {
    /// Counts an event handled at `now`. Returns whether the run counts as a livelock, or has come
    /// to its latest time.
    #[inline]
    fn advance(&mut self, now: f64) -> bool {
        if now > self.instant {
            self.instant = now;
            self.at_instant = 0;
            self.violations_at_instant = 0;
            now > LATEST_SECONDS
        } else {
            self.at_instant += 1;
            self.is_stuck_at_instant()
        }
    }

    /// Does not count the current event, because it is outdated.
    pub(super) fn skip_event(&mut self) {
        self.at_instant = self.at_instant.saturating_sub(1);
    }

    /// Counts a movement of a part.
    pub(super) fn count_movement(&mut self) {
        self.at_instant += 1;
    }

    /// Counts an end product completed after this many events and violations.
    pub(super) fn count_product(&mut self, events: u64, violations: u64) {
        self.violations_at_product = violations;
        self.last_event = events + EVENTS_BEFORE_EXAMINATION;
        self.is_examined = false;
        self.last_violation = violations + MAX_VIOLATIONS_WITHOUT_PRODUCT;
    }

    /// Counts the run as a livelock after too many violations at this instant.
    pub(super) fn limit_violations(&mut self) {
        if self.violations_at_instant > MAX_VIOLATIONS_AT_ONE_INSTANT {
            self.stop();
        }
    }

    /// Lets nothing move any more at this instant, because the run ends.
    fn stop(&mut self) {
        self.at_instant = STOPPED;
    }

    /// Whether nothing must move any more at this instant: the run ends, or it counts as a livelock
    /// because of the number of movements, events or violations since time last advanced.
    #[inline]
    pub(super) fn is_stuck_at_instant(&self) -> bool {
        self.at_instant > MAX_AT_ONE_INSTANT
    }

    /// Whether a run that waits for products is to be examined for a deadlock: once after each
    /// product, long before it counts as making none.
    fn examines(&mut self, events: u64) -> bool {
        let is_due = events > self.last_event && !self.is_examined;
        if is_due {
            self.is_examined = true;
            self.last_event += MAX_EVENTS_WITHOUT_PRODUCT - EVENTS_BEFORE_EXAMINATION;
        }
        is_due
    }

    /// Whether a run that waits for products has stopped making any.
    fn makes_no_products(&self, events: u64, violations: u64) -> bool {
        events > self.last_event || violations > self.last_violation
    }
}

impl Run<'_> {
    /// Ends the run while something happens: nothing moves any more at this instant.
    pub(super) fn stop(&mut self, end: End) {
        self.end = Some(end);
        self.progress.stop();
    }

    /// Looks whether the run still makes progress; if not, ends it.
    #[inline]
    pub(super) fn guard(&mut self) {
        let violations = self.journal.violation_count;
        if self.progress.advance(self.now)
            || self.progress.makes_no_products(self.events, violations)
        {
            self.give_up();
        }
    }

    /// Ends a run if it no longer makes progress.
    #[cold]
    fn give_up(&mut self) {
        if self.end.is_some() {
            return;
        }
        if self.now > LATEST_SECONDS {
            self.end = Some(End::GaveUp);
            let message = format!(
                "the run had not ended at {LATEST_SECONDS:e} s, beyond which times are no longer exact; it made {} products",
                self.counters.products
            );
            self.journal.findings.push(
                Diagnostic::error(codes::GAVE_UP, self.line.span, message)
                    .with_help("End it earlier with --parts or --until."),
            );
        } else if self.progress.is_stuck_at_instant() {
            self.end = Some(End::NoProgress);
            let message = format!(
                "the line makes no progress (livelock): at {}, parts keep moving without any time passing",
                self.moment()
            );
            self.journal.findings.push(
                Diagnostic::error(codes::LINE_BLOCKED, self.line.span, message).with_help(
                    "Look for a source without an interval, a cycle of routes without a station, or a station that \
                     refuses every part and has it reordered.",
                ),
            );
        } else if self.progress.examines(self.events) {
            if self.setup.horizon.is_none() {
                self.end_if_deadlocked();
            }
        } else if self.setup.horizon.is_none()
            && self
                .progress
                .makes_no_products(self.events, self.journal.violation_count)
        {
            self.end = Some(End::NoProgress);
            let refused = self.journal.violation_count - self.progress.violations_at_product;
            let meanwhile = if refused > MAX_VIOLATIONS_WITHOUT_PRODUCT {
                format!("while {refused} parts were refused")
            } else {
                format!("in {MAX_EVENTS_WITHOUT_PRODUCT} events")
            };
            let made = match self.counters.products {
                0 => "no product".to_owned(),
                1 => "1 product, and no other".to_owned(),
                products => format!("{products} products, and no other"),
            };
            let wanted = match self.setup.target.unwrap_or(0) {
                1 => "1 was asked for".to_owned(),
                target => format!("{target} were asked for"),
            };
            let message =
                format!("the line makes no progress: it made {made} {meanwhile}; {wanted}");
            self.journal.findings.push(
                Diagnostic::error(codes::LINE_BLOCKED, self.line.span, message).with_help(
                    "Find the rule that refuses the parts, or the reason why all are rejected; --until ends a run at a given time.",
                ),
            );
        }
    }

    /// Shows how far the run is, if somebody watches.
    pub(super) fn show_progress(&self) {
        let setup = self.setup;
        let Some(monitor) = setup.monitor.as_ref().filter(|_| setup.is_shown) else {
            return;
        };
        let products = self.counters.products as f64;
        let counted = self.now - self.counting_start();
        let of_time = setup.horizon.map_or(0.0, |horizon| self.now / horizon);
        let target = setup.target.filter(|_| self.is_counting());
        let of_products = target.map_or(0.0, |target| products / target as f64);
        monitor.write(Snapshot {
            now: self.now,
            share: of_time.max(of_products).min(1.0),
            wip: u64::from(self.counters.units.level()),
            throughput_per_hour: if counted > 0.0 {
                products * 3600.0 / counted
            } else {
                0.0
            },
        });
    }

    /// Gives up at the wall-clock deadline.
    pub(super) fn check_deadline(&mut self) {
        if self.end.is_some() {
            return;
        }
        let Err(late) = self.setup.options.deadline.check() else {
            return;
        };
        self.end = Some(End::GaveUp);
        let message = format!(
            "the run had not ended when {late}: it reached {}, with {} products",
            self.moment(),
            self.counters.products
        );
        self.journal.findings.push(
            Diagnostic::error(codes::GAVE_UP, self.line.span, message).with_help(format!(
                "{}, or end it earlier with --parts or --until",
                late.remedy()
            )),
        );
    }
}
