//! The Trace Event Format of Chrome, which Perfetto reads: a track for each station, and counters
//! for the parts in the line and in each buffer.
//!
//! From Google's document "Trace Event Format": an object with `traceEvents`, whose times `ts` and
//! `dur` are microseconds. Phases in use: `M` (metadata), `X` (complete event), `C` (counter), `i`
//! (instant event). Waiting without a part (starved, idle) is the gap between the events.

use crate::row::state_word;
use crate::{EventWriter, kind_word};
use linewright_language::contract::line::{Line, NodeKind};
use linewright_line::log::{Activity, EventKind, LogEntry, Moment};
use linewright_line::trace::{End, Violation};
use serde_json::{Value, json};
use std::io::{self, Write};

/// Writes a Chrome trace.
pub(crate) struct TraceEvents<'a, W> {
    file: W,
    line: &'a Line,
    is_first: bool,
    /// By node.
    tracks: Vec<Track>,
    wip: Counter,
    now: f64,
}

/// What a place does.
#[derive(Debug, Clone, Default)]
struct Track {
    state: Option<(Activity, f64)>,
    /// The part in work.
    part: Option<(u64, usize)>,
    /// Of a buffer.
    level: Counter,
}

/// A number that is written when time advances.
#[derive(Debug, Clone, Copy, Default)]
struct Counter {
    count: i64,
    written: Option<i64>,
}

impl<'a, W: Write> TraceEvents<'a, W> {
    pub(crate) fn new(mut file: W, line: &'a Line) -> io::Result<Self> {
        file.write_all(b"{\"displayTimeUnit\":\"ms\",\"traceEvents\":[")?;
        let mut trace = Self {
            file,
            line,
            is_first: true,
            tracks: vec![Track::default(); line.nodes.len()],
            wip: Counter::default(),
            now: 0.0,
        };
        trace.metadata("process_name", None, &json!({ "name": line.name }))?;
        for (node, declared) in line.nodes.iter().enumerate() {
            if matches!(declared.kind, NodeKind::Station(_)) || declared.machine().is_some() {
                let name = json!({ "name": declared.name });
                trace.metadata("thread_name", Some(node), &name)?;
                let order = json!({ "sort_index": node });
                trace.metadata("thread_sort_index", Some(node), &order)?;
            }
        }
        Ok(trace)
    }

    fn write(&mut self, event: &Value) -> io::Result<()> {
        let separator: &[u8] = if std::mem::take(&mut self.is_first) {
            b"\n"
        } else {
            b",\n"
        };
        self.file.write_all(separator)?;
        serde_json::to_writer(&mut self.file, event)?;
        Ok(())
    }

    fn metadata(&mut self, name: &str, node: Option<usize>, arguments: &Value) -> io::Result<()> {
        let thread = node.map_or(0, thread);
        self.write(&json!({ "ph": "M", "pid": 1, "tid": thread, "name": name, "args": arguments }))
    }

    /// Writes the counters that have changed, before time advances.
    fn advance(&mut self, time: f64) -> io::Result<()> {
        if time > self.now {
            self.write_counters()?;
            self.now = time;
        }
        Ok(())
    }

    fn write_counters(&mut self) -> io::Result<()> {
        if let Some(count) = self.wip.changed() {
            self.count("WIP", count)?;
        }
        for node in 0..self.tracks.len() {
            if let Some(count) = self.tracks[node].level.changed() {
                let line = self.line;
                self.count(&line.nodes[node].name, count)?;
            }
        }
        Ok(())
    }

    fn count(&mut self, name: &str, count: i64) -> io::Result<()> {
        let ts = ticks(self.now);
        self.write(
            &json!({ "ph": "C", "pid": 1, "ts": ts, "name": name, "args": { "parts": count } }),
        )
    }

    /// Ends the state of a station.
    fn close(&mut self, node: usize, now: f64) -> io::Result<()> {
        let Some((state, since)) = self.tracks[node].state.take() else {
            return Ok(());
        };
        if matches!(state, Activity::Starved | Activity::Idle) || now <= since {
            return Ok(());
        }
        let mut event = json!({
            "ph": "X",
            "pid": 1,
            "tid": thread(node),
            "ts": ticks(since),
            "dur": ticks(now) - ticks(since),
            "name": state_word(state),
            "cat": "state",
        });
        let works = matches!(state, Activity::Busy | Activity::Setup | Activity::Blocked);
        if let Some((number, kind)) = self.tracks[node].part.filter(|_| works) {
            event["args"] = json!({ "part": number, "type": self.line.parts[kind].name });
        }
        self.write(&event)
    }

    fn instant(&mut self, time: f64, node: Option<usize>, name: &str) -> io::Result<()> {
        self.write(&json!({
            "ph": "i",
            "pid": 1,
            "tid": node.map_or(0, thread),
            "ts": ticks(time),
            "name": name,
            "s": if node.is_some() { "t" } else { "g" },
        }))
    }
}

/// Microseconds, to the nanosecond.
fn ticks(seconds: f64) -> f64 {
    (seconds * 1e9).round() / 1e3
}

/// The number of a place's thread.
fn thread(node: usize) -> usize {
    node + 1
}

impl Counter {
    /// The count, if it has changed since it was written.
    fn changed(&mut self) -> Option<i64> {
        let changed = self.written.unwrap_or(0) != self.count;
        if changed {
            self.written = Some(self.count);
        }
        changed.then_some(self.count)
    }
}

impl<W: Write> EventWriter for TraceEvents<'_, W> {
    fn entry(&mut self, entry: &LogEntry) -> io::Result<()> {
        self.advance(entry.time)?;
        let node = entry.node;
        let is_buffer = kind_word(&self.line.nodes[node].kind) == "buffer";
        match entry.what {
            EventKind::Entered => self.wip.count += 1,
            EventKind::Finished | EventKind::Consumed => self.wip.count -= 1,
            EventKind::Rejected => {
                self.wip.count -= 1;
                self.tracks[node].level.count -= i64::from(is_buffer);
            }
            EventKind::Arrived => self.tracks[node].level.count += i64::from(is_buffer),
            EventKind::Left => self.tracks[node].level.count -= i64::from(is_buffer),
            EventKind::SetupStarted | EventKind::Started => self.tracks[node].part = entry.part,
            EventKind::State(state) => {
                let current = self.tracks[node].state;
                if current.is_none_or(|(current, _)| current != state) {
                    self.close(node, entry.time)?;
                    self.tracks[node].state = Some((state, entry.time));
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn violation(&mut self, violation: &Violation) -> io::Result<()> {
        self.advance(violation.time)?;
        let name = violation.rule.as_ref().unwrap_or(&violation.message);
        self.instant(violation.time, Some(violation.node), name)
    }

    fn counting(&mut self, moment: Moment) -> io::Result<()> {
        self.instant(moment.time, None, "warm-up ends")
    }

    fn end(&mut self, moment: Moment, _: End) -> io::Result<()> {
        self.advance(moment.time)?;
        self.write_counters()?;
        for node in 0..self.tracks.len() {
            self.close(node, moment.time)?;
        }
        self.file.write_all(b"\n]}\n")?;
        self.file.flush()
    }
}
