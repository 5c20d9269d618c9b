//! Logs as a table: one row an event, with the same columns in each format.

use crate::EventWriter;
use linewright_language::contract::line::Line;
use linewright_line::log::{Activity, EventKind, LogEntry, Moment, Other};
use linewright_line::trace::{End, Violation};
use std::io;

/// The columns of a table.
pub const COLUMNS: [&str; 10] = [
    "time",
    "node",
    "part_type",
    "part",
    "what",
    "other",
    "value",
    "seconds",
    "joules",
    "control_seconds",
];

/// A row of a table; see [`COLUMNS`].
#[derive(Debug, Clone, Default)]
pub(crate) struct Row<'a> {
    /// Time in simulated seconds.
    pub time: f64,
    pub node: Option<&'a str>,
    pub part_type: Option<&'a str>,
    /// Number of the part.
    pub part: Option<u64>,
    pub what: &'static str,
    /// Name of what else took part, or of the state of a station.
    pub other: Option<&'a str>,
    /// Number that belongs to `other`.
    pub value: Option<f64>,
    pub seconds: Option<f64>,
    pub joules: Option<f64>,
    pub control_seconds: Option<f64>,
}

/// Writes the rows of a table.
pub(crate) trait RowWriter {
    fn row(&mut self, row: &Row<'_>) -> io::Result<()>;

    /// Completes the file.
    fn finish(&mut self) -> io::Result<()>;
}

/// A log as a table.
pub(crate) struct Table<'a, W> {
    line: &'a Line,
    rows: W,
}

impl<'a, W: RowWriter> Table<'a, W> {
    pub(crate) fn new(line: &'a Line, rows: W) -> Self {
        Self { line, rows }
    }

    fn name(&self, node: usize) -> Option<&'a str> {
        self.line.nodes.get(node).map(|node| node.name.as_str())
    }

    fn type_name(&self, part: Option<(u64, usize)>) -> Option<&'a str> {
        let kind = self.line.parts.get(part?.1)?;
        Some(&kind.name)
    }
}

impl<W: RowWriter> EventWriter for Table<'_, W> {
    fn entry(&mut self, entry: &LogEntry) -> io::Result<()> {
        let (other, value) = match (entry.other, entry.what) {
            (_, EventKind::State(state)) => (Some(state_word(state)), None),
            (_, EventKind::Place(place)) => (None, Some(f64::from(place))),
            (Some(Other::Node(node)), EventKind::Reordered(count)) => {
                (self.name(node), Some(count as f64))
            }
            (Some(Other::Node(node)), _) => (self.name(node), None),
            (Some(Other::Part(number)), _) => (None, Some(number as f64)),
            (Some(Other::Property(property, value)), _) => {
                let kind = entry.part.and_then(|part| self.line.parts.get(part.1));
                let property = kind.and_then(|kind| kind.properties.get(property));
                (property.map(|property| property.name.as_str()), Some(value))
            }
            (None, _) => (None, None),
        };
        self.rows.row(&Row {
            time: entry.time,
            node: self.name(entry.node),
            part_type: self.type_name(entry.part),
            part: entry.part.map(|part| part.0),
            what: event_word(entry.what),
            other,
            value,
            seconds: entry.seconds,
            joules: entry.joules,
            control_seconds: entry.control_seconds,
        })
    }

    fn violation(&mut self, violation: &Violation) -> io::Result<()> {
        self.rows.row(&Row {
            time: violation.time,
            node: self.name(violation.node),
            part_type: self.type_name(violation.part),
            part: violation.part.map(|part| part.0),
            what: "violation",
            other: Some(violation.rule.as_ref().unwrap_or(&violation.message)),
            value: Some(f64::from(violation.code as i32)),
            ..Row::default()
        })
    }

    fn counting(&mut self, moment: Moment) -> io::Result<()> {
        self.rows.row(&Row {
            time: moment.time,
            what: "counting",
            seconds: moment.worked,
            ..Row::default()
        })
    }

    fn end(&mut self, moment: Moment, end: End) -> io::Result<()> {
        self.rows.row(&Row {
            time: moment.time,
            what: "run_ended",
            other: Some(end.word()),
            seconds: moment.worked,
            ..Row::default()
        })?;
        self.rows.finish()
    }
}

/// The word for an event.
pub(crate) fn event_word(what: EventKind) -> &'static str {
    match what {
        EventKind::Made => "made",
        EventKind::Entered => "entered",
        EventKind::Arrived => "arrived",
        EventKind::Consumed => "consumed",
        EventKind::SetupStarted => "setup_started",
        EventKind::Started => "started",
        EventKind::Ended => "ended",
        EventKind::Aborted => "aborted",
        EventKind::Changed => "changed",
        EventKind::Defect => "defect",
        EventKind::Left => "left",
        EventKind::Place(_) => "place",
        EventKind::Finished => "finished",
        EventKind::Rejected => "rejected",
        EventKind::Reordered(_) => "reordered",
        EventKind::Failed => "failed",
        EventKind::Repaired => "repaired",
        EventKind::State(_) => "state",
        EventKind::Moved => "moved",
    }
}

/// The word for a state of a station.
pub(crate) fn state_word(state: Activity) -> &'static str {
    match state {
        Activity::Busy => "busy",
        Activity::Starved => "starved",
        Activity::Blocked => "blocked",
        Activity::Failed => "failed",
        Activity::Idle => "idle",
        Activity::Setup => "setup",
        Activity::FailedOffShift => "failed_off_shift",
    }
}
