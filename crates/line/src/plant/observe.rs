//! Hands the events of a run to its observer.
//!
//! Without one, an event costs a comparison. Everything else is out of the way of the event loop.

use super::part::PartIndex;
use super::{Place, Run};
use crate::log::{Activity, EventKind, LogEntry, Moment, Observer, Other};
use crate::trace::End;
use linewright_language::contract::line::NodeKind;

/// The observer of a run, and what it knows.
#[derive(Default)]
pub(super) struct Recorder<'a> {
    pub observer: Option<&'a mut dyn Observer>,
    /// By node.
    known: Vec<Known>,
}

/// What the observer knows about a node.
#[derive(Debug, Clone, Copy, Default)]
struct Known {
    /// State of a station.
    state: Option<Activity>,
    /// Energy since counting began.
    joules: f64,
    /// Since counting began: moving time of a conveyor, or lost work of a station.
    seconds: f64,
}

impl Run<'_> {
    /// Records an event, if there is an observer.
    #[inline]
    pub(super) fn record(&mut self, node: usize, part: Option<PartIndex>, what: EventKind) {
        self.record_with(node, part, what, None);
    }

    /// Records an event in which something else takes part, if there is an observer.
    #[inline]
    pub(super) fn record_with(
        &mut self,
        node: usize,
        part: Option<PartIndex>,
        what: EventKind,
        other: Option<Other>,
    ) {
        if self.is_observed() {
            self.log(node, part, what, other);
        }
    }

    /// Records the state of a station, if it has changed and there is an observer.
    #[inline]
    pub(super) fn record_state(&mut self, node: usize) {
        if self.is_observed() {
            self.log_state(node);
        }
    }

    #[cold]
    #[inline(never)]
    fn log_state(&mut self, node: usize) {
        let state = self.station(node).clock.activity();
        if self.recorder.known[node].state != Some(state) {
            self.tell_state(node, state);
        }
    }

    /// Records that a part has moved from one node to another, if there is an observer. The state
    /// of a station may have changed when the part left it.
    #[inline]
    pub(super) fn record_movement(&mut self, from: usize, to: usize, part: PartIndex) {
        if self.is_observed() {
            self.log_movement(from, to, part);
        }
    }

    #[cold]
    #[inline(never)]
    fn log_movement(&mut self, from: usize, to: usize, part: PartIndex) {
        if let Place::Station(_) = self.nodes[from].place {
            self.log_state(from);
        }
        let (left, arrived) = (Some(Other::Node(to)), Some(Other::Node(from)));
        self.log(from, Some(part), EventKind::Left, left);
        self.log(to, Some(part), EventKind::Arrived, arrived);
    }

    /// Records that a station begins to work on a part, and its state, if there is an observer.
    #[inline]
    pub(super) fn record_start(&mut self, node: usize, part: PartIndex) {
        if self.is_observed() {
            self.log_start(node, part);
        }
    }

    #[cold]
    #[inline(never)]
    fn log_start(&mut self, node: usize, part: PartIndex) {
        self.log(node, Some(part), EventKind::Started, None);
        self.log_state(node);
    }

    /// Records that the work of a station on a part has ended, and its state, if there is an
    /// observer.
    #[inline]
    pub(super) fn record_end(&mut self, node: usize, part: PartIndex) {
        if self.is_observed() {
            self.log_end_of_work(node, part);
        }
    }

    #[cold]
    #[inline(never)]
    fn log_end_of_work(&mut self, node: usize, part: PartIndex) {
        self.log(node, Some(part), EventKind::Ended, None);
        self.log_state(node);
    }

    /// Whether there is an observer.
    #[inline]
    pub(super) fn is_observed(&self) -> bool {
        self.recorder.observer.is_some()
    }

    #[cold]
    #[inline(never)]
    fn log(&mut self, node: usize, part: Option<PartIndex>, what: EventKind, other: Option<Other>) {
        let mut entry = self.entry(node, what);
        entry.part = part.map(|part| (self.parts[part].number, self.parts[part].kind));
        entry.other = other;
        match what {
            EventKind::Left => self.tell_movement(&mut entry),
            EventKind::Ended => {
                let (seconds, control_seconds) = self.station(node).work_ended();
                entry.seconds = Some(seconds);
                entry.control_seconds = control_seconds;
            }
            EventKind::Aborted => entry.seconds = Some(self.station(node).work_done()),
            EventKind::Failed => {
                let lost = self.station(node).lost_seconds;
                let known = &mut self.recorder.known[node];
                entry.seconds = Some(lost - std::mem::replace(&mut known.seconds, lost));
            }
            _ => {}
        }
        self.tell(&entry);
    }

    fn entry(&self, node: usize, what: EventKind) -> LogEntry {
        LogEntry {
            time: self.now,
            node,
            part: None,
            what,
            other: None,
            seconds: None,
            joules: None,
            control_seconds: None,
        }
    }

    fn tell(&mut self, entry: &LogEntry) {
        if let Some(observer) = &mut self.recorder.observer {
            observer.record(entry);
        }
    }

    /// Tells the state that a station has from now on, and the energy that it has used so far.
    fn tell_state(&mut self, node: usize, state: Activity) {
        let idle_watts = self.idle_watts(node);
        let now = self.now;
        let joules = self.station(node).joules(now, idle_watts);
        let known = &mut self.recorder.known[node];
        known.state = Some(state);
        let used = joules - std::mem::replace(&mut known.joules, joules);
        let mut entry = self.entry(node, EventKind::State(state));
        entry.joules = Some(used);
        self.tell(&entry);
    }

    /// Adds to an entry the time for which a conveyor has moved, and its energy.
    fn tell_movement(&mut self, entry: &mut LogEntry) {
        if let Some((seconds, joules)) = self.movement(entry.node) {
            let known = &mut self.recorder.known[entry.node];
            entry.seconds = Some(seconds - std::mem::replace(&mut known.seconds, seconds));
            entry.joules = Some(joules - std::mem::replace(&mut known.joules, joules));
        }
    }

    /// Of a conveyor: seconds in which it has moved, and its energy, since counting began.
    fn movement(&self, node: usize) -> Option<(f64, f64)> {
        let NodeKind::Conveyor { watts, belt, .. } = &self.line.nodes[node].kind else {
            return None;
        };
        match (&self.nodes[node].place, belt) {
            (Place::Conveyor(conveyor), _) => {
                let seconds = conveyor.moving_seconds(self.now);
                Some((seconds, seconds * watts))
            }
            (Place::Belt(belt), Some(declared)) => {
                let counted = self.now - self.counting_start();
                let idle_watts = declared.machine.idle_watts;
                let (seconds, joules, _) = belt.moved(counted, *watts, idle_watts);
                Some((seconds, joules))
            }
            _ => None,
        }
    }

    fn idle_watts(&self, node: usize) -> f64 {
        match &self.line.nodes[node].kind {
            NodeKind::Station(station) => station.idle_watts,
            _ => 0.0,
        }
    }

    fn stations(&self) -> Vec<usize> {
        let nodes = 0..self.nodes.len();
        nodes
            .filter(|node| matches!(self.nodes[*node].place, Place::Station(_)))
            .collect()
    }

    /// Tells the states of all stations at the start of a run.
    pub(super) fn open_log(&mut self) {
        if self.is_observed() {
            self.recorder.known = vec![Known::default(); self.nodes.len()];
            for node in self.stations() {
                self.record_state(node);
            }
        }
    }

    /// Tells the energy that everything has used so far.
    pub(super) fn close_log(&mut self) {
        if !self.is_observed() {
            return;
        }
        for node in 0..self.nodes.len() {
            if let Some(state) = self.recorder.known[node].state {
                self.tell_state(node, state);
            } else if self.movement(node).is_some() {
                let mut entry = self.entry(node, EventKind::Moved);
                self.tell_movement(&mut entry);
                self.tell(&entry);
            }
        }
    }

    /// Tells that counting begins, after everything has been forgotten.
    pub(super) fn log_counting(&mut self) {
        let moment = self.log_moment();
        if let Some(observer) = &mut self.recorder.observer {
            observer.begin_counting(moment);
            for known in &mut self.recorder.known {
                (known.joules, known.seconds) = (0.0, 0.0);
            }
        }
    }

    /// Tells the end of the run.
    pub(super) fn log_end(&mut self, end: End) {
        self.close_log();
        let moment = self.log_moment();
        if let Some(observer) = &mut self.recorder.observer {
            observer.end(moment, end);
        }
    }

    fn log_moment(&self) -> Moment {
        let calendar = self.line.calendar.as_ref();
        Moment {
            time: self.now,
            worked: calendar.map(|calendar| calendar.worked_until(self.now)),
        }
    }

    /// Records the states of the stations until `horizon`, up to which only shifts begin and end.
    pub(super) fn record_rest(&mut self, horizon: f64) {
        if !self.is_observed() {
            return;
        }
        let mut changes = Vec::new();
        for node in self.stations() {
            let on_shift = self.station(node).activity(true);
            for (time, is_on) in self.shifts.until(node, self.now, horizon) {
                let state = if is_on { on_shift } else { Activity::Idle };
                changes.push((time, node, state));
            }
        }
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut since = vec![self.now; self.nodes.len()];
        for (time, node, state) in changes {
            if self.recorder.known[node].state == Some(state) {
                continue;
            }
            if time <= self.now {
                self.tell_state(node, state);
                continue;
            }
            let joules = self.idle_watts(node) * (time - since[node]);
            since[node] = time;
            let known = &mut self.recorder.known[node];
            known.state = Some(state);
            known.joules += joules;
            let mut entry = self.entry(node, EventKind::State(state));
            entry.time = time;
            entry.joules = Some(joules);
            self.tell(&entry);
        }
    }
}
