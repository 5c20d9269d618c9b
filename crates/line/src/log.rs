//! The events of a run, as they happen: an [`Observer`] receives each one, and nothing is kept.
//!
//! From the events, every figure of a [`Trace`](super::Trace) can be computed again that does not
//! follow from the line alone:
//!
//! - A part is in the line from [`EventKind::Entered`] to `Finished`, `Rejected` or `Consumed`.
//! - The state of each station is given at the start, at each change, at the end of the warm-up and
//!   at the end of the run ([`EventKind::State`]). A state lasts until the next one of its station.
//! - Energy is given in shares: each entry has the joules that its place has used since the last
//!   entry of this place with joules. Their sum after the warm-up is the energy of the run.

use super::trace::{End, Violation};

/// Receives the events of a run, in order.
pub trait Observer {
    /// Something happened.
    fn record(&mut self, entry: &LogEntry);

    /// A controller returned an error.
    fn record_violation(&mut self, violation: &Violation) {
        let _ = violation;
    }

    /// The warm-up ended: the figures of the run count from here on.
    fn begin_counting(&mut self, moment: Moment) {
        let _ = moment;
    }

    /// The run ended.
    fn end(&mut self, moment: Moment, end: End) {
        let _ = (moment, end);
    }
}

/// Hands every event on to several observers, in order.
#[derive(Default)]
pub struct Observers<'a>(pub Vec<&'a mut dyn Observer>);

impl Observer for Observers<'_> {
    fn record(&mut self, entry: &LogEntry) {
        for observer in &mut self.0 {
            observer.record(entry);
        }
    }

    fn record_violation(&mut self, violation: &Violation) {
        for observer in &mut self.0 {
            observer.record_violation(violation);
        }
    }

    fn begin_counting(&mut self, moment: Moment) {
        for observer in &mut self.0 {
            observer.begin_counting(moment);
        }
    }

    fn end(&mut self, moment: Moment, end: End) {
        for observer in &mut self.0 {
            observer.end(moment, end);
        }
    }
}

/// A moment of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Time in simulated seconds.
    pub time: f64,
    /// Working time of the line up to then, in seconds; `None` if the line has no calendar.
    pub worked: Option<f64>,
}

/// An event at a part or node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogEntry {
    /// Time in simulated seconds.
    pub time: f64,
    /// Index of the node.
    pub node: usize,
    /// Number and type of the part; `None` for what happens to a node.
    pub part: Option<(u64, usize)>,
    /// What happened.
    pub what: EventKind,
    /// What else took part in it.
    pub other: Option<Other>,
    /// Seconds; see [`EventKind`].
    pub seconds: Option<f64>,
    /// Joules that the node has used since its last entry with joules.
    pub joules: Option<f64>,
    /// For [`EventKind::Ended`] at a station with a machine: the seconds of the work in which no
    /// action of the machine is active.
    pub control_seconds: Option<f64>,
}

/// What else takes part in an event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Other {
    /// A node.
    Node(usize),
    /// Number of a part.
    Part(u64),
    /// A property of the part's type, and its new value.
    Property(usize, f64),
}

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// The source made the part, which now waits there for room.
    Made,
    /// The part entered the line here.
    Entered,
    /// The part arrived at this node, from the other one.
    Arrived,
    /// The part became a component of the other one.
    Consumed,
    /// The station began setup for the part.
    SetupStarted,
    /// Service of the part began.
    Started,
    /// Service of the part ended, after these seconds of work without failures.
    Ended,
    /// A failure ended the service of the part for good; the part is rejected.
    Aborted,
    /// The work on the part gave the property a new value.
    Changed,
    /// A defect gave the property of the part a new value.
    Defect,
    /// The part left this node for the other one. For a conveyor, the seconds are those in which it
    /// has moved since the last part left.
    Left,
    /// The part was seen at this place of the belt.
    Place(u32),
    /// The part left the line as finished.
    Finished,
    /// The part left the line as scrap, because of the other node: a station, or the buffer in
    /// which it expired. Without one, no station had worked on it.
    Rejected,
    /// This many new parts were ordered from the other node, to replace the part.
    Reordered(u64),
    /// The station broke down. The seconds are those of work that has to be done again.
    Failed,
    /// The station was repaired.
    Repaired,
    /// The station is in this state from now on.
    State(Activity),
    /// The conveyor has moved for these seconds since its last entry with seconds: at the end of
    /// the warm-up, and of the run.
    Moved,
}

/// State of a station, under which its time is booked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Activity {
    /// In work on a part.
    Busy,
    /// Free, but no part to work on has come. For a station that no part ever reaches, the figures
    /// of a run count this as idle.
    Starved,
    /// Done with a part, for which the next place has no room.
    Blocked,
    /// Broken down or under repair, on shift.
    Failed,
    /// Off shift.
    Idle,
    /// In setup for another part type.
    Setup,
    /// Broken down or under repair, off shift.
    FailedOffShift,
}

/// Keeps all events; memory grows with the run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Log {
    /// The events in order.
    pub entries: Vec<LogEntry>,
    /// The violations in order.
    pub violations: Vec<Violation>,
    /// The end of the warm-up; `None` without one.
    pub counting: Option<Moment>,
    /// The end of the run, and why it ended.
    pub end: Option<(Moment, End)>,
}

impl Observer for Log {
    fn record(&mut self, entry: &LogEntry) {
        self.entries.push(*entry);
    }

    fn record_violation(&mut self, violation: &Violation) {
        self.violations.push(violation.clone());
    }

    fn begin_counting(&mut self, moment: Moment) {
        self.counting = Some(moment);
    }

    fn end(&mut self, moment: Moment, end: End) {
        self.end = Some((moment, end));
    }
}
