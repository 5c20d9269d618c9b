//! Shifts: which stations work by which calendar, and when that changes.
//!
//! Stations with the same calendar share its state. One event stands for everything that changes at
//! an instant, so that stations do not depend on the order of the calendars.

use super::progress::LATEST_SECONDS;
use super::{Event, Place, Run, SHIFT};
use linewright_language::contract::calendar::{Change, WorkCalendar};
use linewright_language::contract::line::Line;

/// The calendars of a line's stations.
#[derive(Debug)]
pub(super) struct Shifts {
    calendars: Vec<CalendarState>,
    /// By node: the index of its state; `None` for a node that works around the clock.
    of_nodes: Vec<Option<usize>>,
    /// Whether some calendar's stations have been on shift since something last happened in the
    /// line, and could not work.
    any_fruitless: bool,
    /// Number of violations when `fruitless` was last set.
    violations: u64,
}

/// The state of a calendar that some stations have.
#[derive(Debug)]
struct CalendarState {
    calendar: WorkCalendar,
    is_on: bool,
    /// The next change; `None` if there is none until the latest end of a run.
    next: Option<Change>,
    /// Whether its stations have been on shift since something last happened in the line, and could
    /// not work.
    fruitless: bool,
}

impl Shifts {
    pub(super) fn new(line: &Line) -> Self {
        let mut calendars: Vec<CalendarState> = Vec::new();
        let of_nodes = (0..line.nodes.len()).map(|node| {
            let calendar = line.calendar_of(node)?;
            let known = calendars
                .iter()
                .position(|state| state.calendar == *calendar);
            Some(known.unwrap_or_else(|| {
                calendars.push(CalendarState {
                    calendar: calendar.clone(),
                    is_on: calendar.works_at(0.0),
                    next: change_after(calendar, 0.0),
                    fruitless: false,
                });
                calendars.len() - 1
            }))
        });
        Self {
            of_nodes: of_nodes.collect(),
            calendars,
            any_fruitless: false,
            violations: 0,
        }
    }

    /// Whether a node is on shift.
    pub(super) fn is_on(&self, node: usize) -> bool {
        self.of_nodes[node].is_none_or(|state| self.calendars[state].is_on)
    }

    /// Whether a node is off shift, and never on shift again.
    pub(super) fn is_off_for_ever(&self, node: usize) -> bool {
        self.of_nodes[node].is_some_and(|state| {
            let state = &self.calendars[state];
            !state.is_on && state.next.is_none()
        })
    }

    /// Whether a node is on shift from `now` on, and at each change before `end`.
    pub(super) fn until(&self, node: usize, now: f64, end: f64) -> Vec<(f64, bool)> {
        let Some(state) = self.of_nodes[node] else {
            return vec![(now, true)];
        };
        let calendar = &self.calendars[state].calendar;
        let mut changes = vec![(now, calendar.works_at(now))];
        let mut next = change_after(calendar, now);
        while let Some(change) = next.filter(|change| change.time < end) {
            changes.push((change.time, change.works));
            next = change_after(calendar, change.time);
        }
        changes
    }

    /// Something has happened in the line: all stations may be able to work again.
    #[inline(never)]
    fn forget_fruitless(&mut self) {
        self.any_fruitless = false;
        for state in &mut self.calendars {
            state.fruitless = false;
        }
    }

    /// Whether every station of a line in which nothing is going on is on shift, or was on shift
    /// since something last happened, or never will be. A violation counts as something.
    #[inline(never)]
    fn rest_for_ever(&mut self, violations: u64) -> bool {
        if std::mem::replace(&mut self.violations, violations) != violations {
            self.forget_fruitless();
        }
        let mut rests = true;
        for state in &mut self.calendars {
            state.fruitless |= state.is_on;
            self.any_fruitless |= state.fruitless;
            rests &= state.fruitless || state.next.is_none();
        }
        rests
    }

    /// Time of the next change in seconds.
    fn next_time(&self) -> Option<f64> {
        let changes = self.calendars.iter().filter_map(|state| state.next);
        changes.map(|change| change.time).reduce(f64::min)
    }

    /// Makes all changes that are due at `now`. Returns the change of each calendar.
    fn advance(&mut self, now: f64) -> Vec<Option<Change>> {
        let changes = self.calendars.iter_mut().map(|state| {
            let change = state.next.filter(|change| change.time <= now)?;
            state.is_on = change.works;
            state.next = change_after(&state.calendar, change.time);
            Some(change)
        });
        changes.collect()
    }
}

/// The next change of a calendar that a run can see.
fn change_after(calendar: &WorkCalendar, second: f64) -> Option<Change> {
    let next = calendar.next_change(second);
    next.filter(|change| change.time <= LATEST_SECONDS)
}

impl Run<'_> {
    /// Schedules the next change of a shift, if there is one.
    pub(super) fn schedule_shift(&mut self) {
        if let Some(time) = self.shifts.next_time() {
            self.schedule(time, SHIFT, Event::Shift);
        }
    }

    /// Shifts begin or end.
    pub(super) fn change_shift(&mut self) {
        let changes = self.shifts.advance(self.now);
        for node in 0..self.nodes.len() {
            let state = self.shifts.of_nodes[node];
            if matches!(self.nodes[node].place, Place::Station(_))
                && let Some(change) = state.and_then(|state| changes[state])
            {
                self.station_shift(node, change.finishes_work);
            }
        }
        self.schedule_shift();
    }

    /// Whether nothing can happen any more: nothing is going on, and every station is on shift, or
    /// was on shift since something last happened, or never will be.
    #[inline]
    pub(super) fn rests_for_ever(&mut self) -> bool {
        if self.pending > 0 {
            if self.shifts.any_fruitless {
                self.shifts.forget_fruitless();
            }
            return false;
        }
        self.shifts.rest_for_ever(self.journal.violation_count)
    }

    /// Working time of a node from `now` until `second`, in seconds.
    pub(super) fn working_seconds(&self, node: usize, second: f64) -> f64 {
        match self.shifts.of_nodes[node] {
            None => second - self.now,
            Some(state) => {
                let calendar = &self.shifts.calendars[state].calendar;
                calendar.worked_until(second) - calendar.worked_until(self.now)
            }
        }
    }
}
