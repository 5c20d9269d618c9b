//! Stations: admission, joining, setup, service, breakdowns and shifts.

use super::failures::Failures;
use super::waits::Waits;
use super::{Event, Node, Place, Run, WORK, stream};
use crate::log::{EventKind, Other};
use crate::plant::part::{Part, PartIndex};
use crate::random::{Purpose, Stream};
use crate::sampler::Sampler;
use crate::statistics::{Activity, Clock};
use crate::trace::{Oee, WorkTime};
use linewright_language::contract::line::{self, Line, NodeKind};
use linewright_language::contract::machine::PropertyKind;
use linewright_station::{CallError, ErrorCode, Service};

/// State of a station.
#[derive(Debug)]
pub(super) struct Station {
    /// By task: its places for components; no places if the task joins nothing. Empty if no task
    /// joins anything.
    pub bills: Vec<Bill>,
    /// The first of the parallel stations that it belongs to, or the station itself.
    first_copy: u32,
    /// Part type of each task.
    kinds: Vec<usize>,
    /// By part type: the first task that works on arriving parts of this type without joining.
    plain: Vec<Option<u32>>,
    pub phase: Phase,
    /// The part in work, or the finished part that waits to leave.
    pub part: Option<PartIndex>,
    task: u32,
    /// Part type of the task that began last; another type needs setup.
    last_kind: Option<usize>,
    /// Seconds left in this phase, as of the time `resumed`.
    remaining: f64,
    resumed: f64,
    /// Whether setup or service is in progress, not interrupted by a breakdown or the end of a
    /// shift.
    running: bool,
    /// Time at which setup or service for the part began.
    begun_at: f64,
    on_shift: bool,
    /// Whether the station is off shift and finishes its part nevertheless.
    overtime: bool,
    /// Only the event with this number is valid.
    number: u32,
    pub failures: Failures,
    setup: Sampler,
    /// By task: the duration of the work; `None` if a controller determines it.
    times: Vec<Option<Sampler>>,
    defects: Stream,
    /// Power during work whose duration no controller determines.
    watts: f64,
    /// The part's properties after the current service, and the machine's properties during it.
    outcome: Vec<f64>,
    values: Vec<f64>,
    /// Duration of this phase.
    phase_seconds: f64,
    service_joules: f64,
    /// The part of the service in which no action is active, in seconds.
    service_control: f64,
    // Time and energy accounts.
    pub clock: Clock,
    pub joules: f64,
    pub processed: u64,
    /// Seconds of control in the services that ended, and their total duration without failures.
    pub control_seconds: f64,
    pub work_seconds: f64,
    /// Seconds of work that was lost because it began again after a failure.
    pub lost_seconds: f64,
    /// Number of parts that were rejected because of this station; see `Run::charge_scrap`.
    pub scrapped: u64,
    /// Number of parts that a failure scrapped during the work; they are not `processed`.
    broken: u64,
    pub waits: Waits,
}

/// Phase of a station's cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// No part.
    Free,
    /// Setup for the part.
    Setup,
    /// Work on the part.
    Service,
    /// The finished part waits to leave.
    Done,
}

/// The component places of a joining task.
#[derive(Debug, Default)]
pub(super) struct Bill {
    /// For each line of the bill: type, required number, and the parts present.
    pub lines: Vec<(usize, usize, Vec<PartIndex>)>,
    /// Sequence number of the arrival that completed the bill; `None` if a component is missing.
    complete: Option<u64>,
}

impl Station {
    pub(super) fn new(
        line: &Line,
        node: usize,
        station: &line::Station,
        first_copy: u32,
        seed: u64,
        on_shift: bool,
    ) -> Self {
        let name = &line.nodes[node].name;
        let tasks = &station.tasks;
        let times = tasks.iter().map(|task| {
            let of = format!("{name}.{}", line.parts[task.part].name);
            let draws = stream(seed, Purpose::Service, &of);
            task.time.as_ref().map(|time| Sampler::new(time, draws))
        });
        let bills = tasks.iter().map(|task| Bill {
            lines: line.parts[task.part]
                .bill
                .iter()
                .filter(|_| line.is_joined_at(node, task.part))
                .map(|&(kind, count)| (kind, count as usize, Vec::new()))
                .collect(),
            complete: None,
        });
        let mut bills: Vec<_> = bills.collect();
        if bills.iter().all(|bill| bill.lines.is_empty()) {
            bills.clear();
        }
        Self {
            bills,
            first_copy,
            plain: (0..line.parts.len())
                .map(|kind| {
                    let is_plain = line.parts[kind].bill.is_empty() || line.is_brought(node, kind);
                    let task = tasks.iter().position(|task| is_plain && task.part == kind);
                    task.map(|task| task as u32)
                })
                .collect(),
            kinds: tasks.iter().map(|task| task.part).collect(),
            phase: Phase::Free,
            part: None,
            task: 0,
            last_kind: None,
            remaining: 0.0,
            resumed: 0.0,
            running: false,
            begun_at: 0.0,
            on_shift,
            overtime: false,
            number: 0,
            failures: Failures::new(name, &station.failures, seed),
            setup: Sampler::new(&station.setup, stream(seed, Purpose::Setup, name)),
            times: times.collect(),
            defects: stream(seed, Purpose::Defects, name),
            watts: station.watts,
            outcome: Vec::new(),
            values: Vec::new(),
            phase_seconds: 0.0,
            service_joules: 0.0,
            service_control: 0.0,
            clock: Clock::new(if on_shift {
                Activity::Starved
            } else {
                Activity::Idle
            }),
            joules: 0.0,
            processed: 0,
            control_seconds: 0.0,
            work_seconds: 0.0,
            lost_seconds: 0.0,
            scrapped: 0,
            broken: 0,
            waits: Waits::default(),
        }
    }

    /// Whether the station takes a part of this type now.
    #[inline]
    pub(super) fn admits(&self, kind: usize) -> bool {
        self.takes_alone(kind) || self.joins_some() && self.lacks(kind)
    }

    /// Whether the station takes a part of this type now to work on it without joining.
    #[inline]
    pub(super) fn takes_alone(&self, kind: usize) -> bool {
        self.can_begin() && self.plain[kind].is_some()
    }

    /// Whether the station can begin to work on a part: it has none, is on shift, and works. Its
    /// time is booked as starved then, and only then.
    #[inline]
    fn can_begin(&self) -> bool {
        self.clock.activity() == Activity::Starved
    }

    /// Whether some task joins components.
    #[inline]
    pub(super) fn joins_some(&self) -> bool {
        !self.bills.is_empty()
    }

    /// Whether a part has ever come.
    pub(super) fn is_visited(&self) -> bool {
        self.waits.supplier.is_some()
    }

    /// Whether there is a free place for a component of this type.
    #[inline(never)]
    pub(super) fn lacks(&self, kind: usize) -> bool {
        self.component_place(kind).is_some()
    }

    /// Whether the components of a complete bill wait for the same work as a newcomer of this type.
    /// They arrived before it.
    #[inline(never)]
    pub(super) fn bill_first(&self, kind: usize) -> bool {
        let mut bills = self.bills.iter();
        bills.any(|bill| bill.complete.is_some()) && !self.lacks(kind)
    }

    /// The first free place for a component of this type, as task and line of its bill.
    fn component_place(&self, kind: usize) -> Option<(usize, usize)> {
        self.bills.iter().enumerate().find_map(|(task, bill)| {
            bill.lines
                .iter()
                .position(|(wanted, count, there)| *wanted == kind && there.len() < *count)
                .map(|line| (task, line))
        })
    }

    /// Whether the station makes parts of this type from others.
    pub(super) fn joins(&self, kind: usize) -> bool {
        self.kinds
            .iter()
            .zip(&self.bills)
            .any(|(made, bill)| *made == kind && !bill.lines.is_empty())
    }

    /// Part types that incomplete joining tasks wait for; tasks for which some part has already
    /// come are listed first.
    pub(super) fn missing(&self) -> Vec<usize> {
        let lacking = |bill: &Bill| -> Vec<usize> {
            bill.lines
                .iter()
                .filter(|(_, count, there)| there.len() < *count)
                .map(|(kind, ..)| *kind)
                .collect()
        };
        let begun = |bill: &&Bill| bill.lines.iter().any(|(.., there)| !there.is_empty());
        let (first, rest): (Vec<_>, Vec<_>) = self.bills.iter().partition(begun);
        first.into_iter().chain(rest).flat_map(lacking).collect()
    }

    /// The parts in the station, in work and waiting to be joined.
    pub(super) fn parts(&self) -> impl Iterator<Item = PartIndex> {
        self.components().chain(self.part)
    }

    /// The parts that wait in the station to be joined.
    pub(super) fn components(&self) -> impl Iterator<Item = PartIndex> {
        self.bills
            .iter()
            .flat_map(|bill| &bill.lines)
            .flat_map(|(.., there)| there)
            .copied()
    }

    /// Accepts a part for a task.
    #[inline]
    fn accept(&mut self, index: PartIndex, task: u32, part: &mut Part, now: f64) {
        part.visit(self.first_copy);
        self.part = Some(index);
        self.task = task;
        self.last_kind = Some(part.kind);
        self.begun_at = now;
    }

    /// Draws the time of the work on the part; `None` if a controller determines it.
    #[inline]
    fn draw_time(&mut self) -> Option<f64> {
        Some(self.times[self.task as usize].as_mut()?.draw())
    }

    /// Starts the service of the part, which needs this time and energy.
    #[inline]
    fn start(&mut self, seconds: f64, joules: f64, control_seconds: f64) {
        self.phase = Phase::Service;
        self.remaining = seconds;
        self.phase_seconds = seconds;
        self.service_joules = joules;
        self.service_control = control_seconds;
    }

    /// Starts or continues setup or service, unless the station is broken down or off shift.
    /// Returns the seconds until it ends or the station breaks down, and the number of this event.
    #[inline]
    fn resume(&mut self, now: f64) -> Option<(f64, u32)> {
        let works = self.on_shift || self.overtime;
        if self.failures.is_failed() || !works || self.running {
            self.book(now);
            return None;
        }
        Some(self.work(now))
    }

    /// Continues setup or service in a station that is neither broken down nor off shift. Returns
    /// the seconds until it ends or the station breaks down, and the number of this event.
    #[inline]
    fn work(&mut self, now: f64) -> (f64, u32) {
        let in_setup = self.phase == Phase::Setup;
        let activity = if in_setup {
            Activity::Setup
        } else {
            Activity::Busy
        };
        self.clock.switch(now, activity);
        self.running = true;
        self.resumed = now;
        self.number = self.number.wrapping_add(1);
        let until_failure = self.until_failure();
        let fails = until_failure < self.remaining;
        let seconds = if fails { until_failure } else { self.remaining };
        (seconds, self.number)
    }

    /// The activity of the interval that begins now, if one does; see [`Waits`].
    #[inline]
    pub(super) fn begins_wait(&self) -> Option<Activity> {
        let activity = self.clock.activity();
        let waits = matches!(activity, Activity::Blocked | Activity::Starved);
        (waits && !self.waits.is_waiting()).then_some(activity)
    }

    /// The part is gone.
    #[inline]
    pub(super) fn clear(&mut self, now: f64) {
        self.phase = Phase::Free;
        self.part = None;
        self.overtime = false;
        self.book(now);
    }

    /// Interrupts setup or service, and subtracts the work done.
    pub(super) fn pause(&mut self, now: f64) {
        if std::mem::take(&mut self.running) {
            let worked = (now - self.resumed).min(self.remaining);
            self.remaining -= worked;
            if self.phase == Phase::Service {
                self.failures.worked(worked);
            }
        }
    }

    /// Begins the interrupted setup or service again. The energy of the work that was lost is used
    /// nevertheless.
    pub(super) fn restart(&mut self) {
        self.joules += self.joules_so_far();
        if self.phase == Phase::Service {
            self.lost_seconds += self.phase_seconds - self.remaining;
        }
        self.remaining = self.phase_seconds;
    }

    /// Seconds of the interrupted service that are done.
    pub(super) fn work_done(&self) -> f64 {
        self.phase_seconds - self.remaining
    }

    /// Seconds of the service that has just ended, without failures, and of those the seconds of
    /// control if a controller determined them.
    pub(super) fn work_ended(&self) -> (f64, Option<f64>) {
        let is_controlled = self.times[self.task as usize].is_none();
        let control_seconds = is_controlled.then_some(self.service_control);
        (self.phase_seconds, control_seconds)
    }

    /// Energy that the service in progress has used, in joules.
    fn joules_so_far(&self) -> f64 {
        self.joules_used(self.remaining)
    }

    /// Energy that the service in progress has used when this many seconds are left, in joules.
    fn joules_used(&self, left: f64) -> f64 {
        if self.phase == Phase::Service && self.phase_seconds > 0.0 {
            self.service_joules * (1.0 - left / self.phase_seconds).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    /// Seconds of work until the next failure, of which there is none during setup.
    #[inline]
    fn until_failure(&self) -> f64 {
        if self.phase == Phase::Service {
            self.failures.seconds_left()
        } else {
            f64::INFINITY
        }
    }

    /// Books time from now on under the current activity.
    #[inline]
    pub(super) fn book(&mut self, now: f64) {
        let activity = self.activity(self.on_shift || self.overtime);
        self.clock.switch(now, activity);
    }

    /// The current activity. `works` states whether the station is on shift or in overtime.
    #[inline]
    pub(super) fn activity(&self, works: bool) -> Activity {
        match self.phase {
            _ if self.failures.is_failed() && works => Activity::Failed,
            _ if self.failures.is_failed() => Activity::FailedOffShift,
            _ if !works => Activity::Idle,
            Phase::Free => Activity::Starved,
            Phase::Setup => Activity::Setup,
            Phase::Service => Activity::Busy,
            Phase::Done => Activity::Blocked,
        }
    }

    /// Books the time from `now` to `until`, in which nothing changes and the given seconds are on
    /// shift.
    pub(super) fn wait(&mut self, now: f64, on_shift_seconds: f64, until: f64) {
        let on_shift = std::mem::replace(&mut self.on_shift, true);
        self.book(now);
        self.on_shift = on_shift;
        self.clock.switch(now + on_shift_seconds, Activity::Idle);
        self.clock.switch(until, Activity::Idle);
    }

    /// Seconds left in this phase at `now`.
    fn left(&self, now: f64) -> f64 {
        if self.running {
            (self.remaining - (now - self.resumed)).max(0.0)
        } else {
            self.remaining
        }
    }

    /// Energy in joules that the station has used up to `now`, with that of a service in progress
    /// and with the idle power outside work.
    pub(super) fn joules(&self, now: f64, idle_watts: f64) -> f64 {
        let clock = self.clock.at(now);
        let outside = (clock.total() - clock.seconds(Activity::Busy)).max(0.0);
        self.joules + self.joules_used(self.left(now)) + idle_watts * outside
    }

    /// Forgets what has been counted. Of a service in progress, only the energy from now on counts.
    pub(super) fn forget(&mut self, now: f64) {
        self.joules = -self.joules_used(self.left(now));
        self.clock.forget(now);
        self.processed = 0;
        self.control_seconds = 0.0;
        self.work_seconds = 0.0;
        self.lost_seconds = 0.0;
        self.scrapped = 0;
        self.broken = 0;
        self.waits.forget();
    }

    /// Closes the accounts at the end of a run: books the time since the last change, and the
    /// energy that a service in progress has used.
    pub(super) fn close(&mut self, now: f64, idle_watts: f64) {
        self.joules = self.joules(now, idle_watts);
        self.pause(now);
        self.book(now);
    }
}

impl Station {
    /// Mean time of the services that ended, without failures.
    pub(super) fn work_time(&self) -> Option<WorkTime> {
        let parts = self.processed as f64;
        (self.processed > 0).then(|| WorkTime {
            seconds: self.work_seconds / parts,
            control_seconds: self.control_seconds / parts,
        })
    }

    /// Overall equipment effectiveness, after the accounts have been closed. Planned time times
    /// quantity is the time in work without the work that was lost, which also holds for a part
    /// that is in work at the start or the end.
    pub(super) fn oee(&self) -> Option<Oee> {
        let (busy, planned) = (self.clock.seconds(Activity::Busy), self.clock.planned());
        (busy > 0.0 && planned > 0.0 && self.processed > 0).then(|| Oee {
            availability: (busy / planned).min(1.0),
            effectiveness: (1.0 - self.lost_seconds / busy).max(0.0),
            quality: (1.0 - self.scrapped as f64 / (self.processed + self.broken) as f64).max(0.0),
        })
    }
}

/// The properties that the work on a part has changed.
fn changes(before: &[f64], after: &[f64]) -> Vec<(EventKind, Other)> {
    let pairs = before.iter().zip(after).enumerate();
    pairs
        .filter(|(_, (before, after))| before.to_bits() != after.to_bits())
        .map(|(property, (_, after))| (EventKind::Changed, Other::Property(property, *after)))
        .collect()
}

#[inline]
fn station_of(nodes: &mut [Node], node: usize) -> &mut Station {
    match &mut nodes[node].place {
        Place::Station(station) => station,
        _ => unreachable!("node {node} is not a station; please report this"),
    }
}

impl Run<'_> {
    #[inline]
    pub(super) fn station(&mut self, node: usize) -> &mut Station {
        station_of(&mut self.nodes, node)
    }

    /// A part arrives at a station that admits it.
    #[inline]
    pub(super) fn station_arrival(&mut self, node: usize, part: PartIndex) {
        let arriving = &self.parts[part];
        let kind = arriving.kind;
        let station = station_of(&mut self.nodes, node);
        station.waits.supplier = arriving.came_from;
        if station.joins_some() {
            self.joining_arrival(node, part, kind);
        } else if let Some(task) = station.plain[kind] {
            self.begin(node, task, part);
        }
    }

    /// A part arrives at a station that joins: it is added to the first bill that lacks a component
    /// of its type or, if there is none, begins.
    #[inline(never)]
    fn joining_arrival(&mut self, node: usize, part: PartIndex, kind: usize) {
        let station = self.station(node);
        let Some((task, line)) = station.component_place(kind) else {
            if let Some(task) = station.plain[kind] {
                self.begin(node, task, part);
            }
            return;
        };
        let bill = &mut station.bills[task];
        bill.lines[line].2.push(part);
        let mut lines = bill.lines.iter();
        if lines.all(|(_, count, there)| there.len() == *count) {
            let order = self.next_number();
            self.station(node).bills[task].complete = Some(order);
            self.look_at(node);
        }
    }

    /// Lets a free station join the bill that has been complete longest, unless a part for another
    /// task has waited longer.
    #[inline(never)]
    pub(super) fn station_ready(&mut self, node: usize) {
        let Place::Station(station) = &self.nodes[node].place else {
            return;
        };
        if !station.can_begin() {
            return;
        }
        let complete = station
            .bills
            .iter()
            .enumerate()
            .filter_map(|(task, bill)| bill.complete.map(|order| (order, task)))
            .min();
        let Some((order, task)) = complete else {
            return;
        };
        let older = self.nodes[node].requests.iter().any(|request| {
            let kind = request.kind as usize;
            request.order < order && !station.lacks(kind) && station.plain[kind].is_some()
        });
        if !older {
            self.join(node, task);
        }
    }

    /// Joins the components of a complete bill into a new part, and begins work on it.
    fn join(&mut self, node: usize, task: usize) {
        let station = self.station(node);
        let kind = station.kinds[task];
        station.bills[task].complete = None;
        let lines: Vec<(usize, Vec<PartIndex>)> = station.bills[task]
            .lines
            .iter_mut()
            .map(|(component, _, there)| (*component, std::mem::take(there)))
            .collect();
        let components = || lines.iter().flat_map(|(_, parts)| parts).copied();
        let first = |wanted| {
            lines
                .iter()
                .find(|(component, _)| *component == wanted)
                .and_then(|(_, parts)| parts.first().copied())
        };
        let part = self.parts.create(self.line, kind, first);
        let entered_at = components()
            .map(|component| self.parts[component].entered_at)
            .fold(self.now, f64::min);
        let reworked = components().map(|component| {
            let component = &self.parts[component];
            component.reworked(self.setup.single_parts(component.kind))
        });
        let reworked = reworked.sum();
        let joined = Some(Other::Part(self.parts[part].number));
        for component in components() {
            self.record_with(node, Some(component), EventKind::Consumed, joined);
            self.leave_line(component);
            self.counters.consumed += 1;
        }
        self.parts[part].entered_at = entered_at;
        self.parts[part].entered = true;
        self.parts[part].reworked_inside = reworked;
        self.parts[part].since = self.now;
        self.counters.unit_enters(self.now);
        // The components are still counted as in the line, because the new part contains them.
        self.counters.in_line[kind] += 1;
        self.record(node, Some(part), EventKind::Entered);
        if !self.refuse_out_of_range(node, part) {
            self.begin(node, task as u32, part);
        }
        self.look_at(node);
    }

    /// Removes a part that has a value outside its range; returns whether it did.
    #[inline(never)]
    fn refuse_out_of_range(&mut self, node: usize, part: PartIndex) -> bool {
        let kind = &self.line.parts[self.parts[part].kind];
        let Some(property) = kind.first_out_of_range(&self.parts[part].properties) else {
            return false;
        };
        let value = self.parts[part].properties[property];
        let property = &kind.properties[property];
        let error = CallError {
            code: ErrorCode::Domain,
            rule: None,
            message: format!(
                "`{}` of {} is set to {value}, which is outside {}",
                property.name,
                kind.name,
                property.describe()
            ),
        };
        self.take_out(node, part, error);
        true
    }

    /// Removes a part whose service breaks a rule, and orders its replacement.
    fn take_out(&mut self, node: usize, part: PartIndex, error: CallError) {
        self.violate(node, Some(part), error);
        self.progress.limit_violations();
        self.station_left(node);
        let replacement = self.replacement(self.parts[part].kind);
        self.reject(node, part, replacement);
        self.look_at(node);
    }

    /// Removes the part in work as scrap, and orders its replacement. Its work has used energy
    /// nevertheless.
    pub(super) fn scrap_work(&mut self, node: usize) {
        let station = self.station(node);
        let (Phase::Service, Some(part)) = (station.phase, station.part) else {
            return;
        };
        station.joules += station.joules_so_far();
        station.scrapped += 1;
        station.broken += 1;
        self.record(node, Some(part), EventKind::Aborted);
        self.station_left(node);
        self.scrap(node, part);
    }

    /// Begins to process a part in a station that can begin, with setup first if the part type has
    /// changed.
    #[expect(
        clippy::inline_always,
        reason = "a call would cost a good part of the body"
    )]
    #[inline(always)]
    fn begin(&mut self, node: usize, task: u32, part: PartIndex) {
        let now = self.now;
        let station = station_of(&mut self.nodes, node);
        debug_assert!(station.can_begin());
        let begun = &mut self.parts[part];
        let changes = station.last_kind.is_some_and(|last| last != begun.kind);
        station.accept(part, task, begun, now);
        let seconds = if changes { None } else { station.draw_time() };
        let Some(seconds) = seconds else {
            return self.begin_otherwise(node, part, changes);
        };
        station.start(seconds, seconds * station.watts, 0.0);
        let (seconds, number) = station.work(now);
        // The wait ends at this instant, so it can be charged after the work has been booked.
        let was_starved = station.waits.is_starved();
        self.schedule_end(node, seconds, number);
        if was_starved {
            self.end_starving(node);
        }
        self.record_start(node, part);
    }

    /// Begins setup, or a service whose duration a controller determines.
    #[inline(never)]
    fn begin_otherwise(&mut self, node: usize, part: PartIndex, changes: bool) {
        if self.station(node).waits.is_starved() {
            self.end_starving(node);
        }
        if changes {
            self.begin_setup(node, part);
        } else {
            self.serve_part(node, part);
        }
    }

    /// Begins setup for a part that the station has accepted or, if this takes no time, its
    /// service.
    fn begin_setup(&mut self, node: usize, part: PartIndex) {
        let station = self.station(node);
        let seconds = station.setup.draw();
        if seconds <= 0.0 {
            self.serve_part(node, part);
            return;
        }
        station.phase = Phase::Setup;
        station.phase_seconds = seconds;
        station.remaining = seconds;
        self.record(node, Some(part), EventKind::SetupStarted);
        self.resume(node);
    }

    /// Begins the service of a part that the station has accepted. A controller, if there is one,
    /// is called for all operations of the task. The station is busy from now on.
    #[inline(never)]
    fn serve_part(&mut self, node: usize, part: PartIndex) {
        self.record(node, Some(part), EventKind::Started);
        let station = self.station(node);
        if let Some(seconds) = station.draw_time() {
            station.start(seconds, seconds * station.watts, 0.0);
            self.resume(node);
        } else {
            self.serve_with_controller(node, part);
        }
    }

    /// Schedules the end of setup or service, or the failure before it.
    #[inline]
    fn schedule_end(&mut self, node: usize, seconds: f64, number: u32) {
        let event = Event::Station(node as u32, number);
        self.schedule(self.now + seconds, WORK, event);
    }

    #[inline(never)]
    fn serve_with_controller(&mut self, node: usize, part: PartIndex) {
        match self.simulate(node, part) {
            Ok(Service {
                seconds,
                joules,
                control_seconds,
                ..
            }) => {
                self.station(node).start(seconds, joules, control_seconds);
                self.resume(node);
            }
            Err(error) => self.take_out(node, part, error),
        }
    }

    /// Simulates the task's operations at one instant. Returns their total cost. The part's new
    /// properties are stored in `outcome` until the end of the service.
    fn simulate(&mut self, node: usize, part: PartIndex) -> Result<Service, CallError> {
        let NodeKind::Station(declared) = &self.line.nodes[node].kind else {
            return Ok(Service::default());
        };
        let Place::Station(station) = &mut self.nodes[node].place else {
            return Ok(Service::default());
        };
        let carried = &self.parts[part].properties;
        station.outcome.clear();
        station.outcome.extend_from_slice(carried);
        let (Some(controller), Some(machine)) = (&mut self.controllers[node], &declared.machine)
        else {
            return Ok(Service::default());
        };
        let task = &declared.tasks[station.task as usize];
        let values = &mut station.values;
        values.clear();
        values.extend(
            machine
                .properties
                .iter()
                .zip(&task.properties)
                .map(|(property, source)| {
                    source.map_or(property.default, |source| carried[source])
                }),
        );
        let mut total = Service::default();
        for (operation, parameters) in &task.operations {
            for (value, property) in values.iter_mut().zip(&machine.properties) {
                if property.kind == PropertyKind::Parameter {
                    *value = property.default;
                }
            }
            for &(index, value) in parameters {
                values[index] = value;
            }
            let service = controller.simulate(*operation, values)?;
            total.seconds += service.seconds;
            total.joules += service.joules;
            total.control_seconds += service.control_seconds;
            total.steps += service.steps;
            if let Some(error) = CallError::check_measurable(total.seconds, total.joules) {
                return Err(error);
            }
        }
        for (value, target) in values.iter().zip(&task.properties) {
            if let Some(target) = target {
                station.outcome[*target] = *value;
            }
        }
        Ok(total)
    }

    /// Starts or continues setup or service, unless the station is broken down or off shift.
    #[inline(never)]
    fn resume(&mut self, node: usize) {
        let now = self.now;
        if let Some((seconds, number)) = self.station(node).resume(now) {
            self.schedule_end(node, seconds, number);
        }
        self.record_state(node);
    }

    /// Setup or service ends, or the station breaks down.
    pub(super) fn station_event(&mut self, node: usize, number: u32) {
        let station = self.station(node);
        if !station.running || station.number != number {
            self.progress.skip_event();
            return;
        }
        let until_failure = station.until_failure();
        let fails = until_failure < station.remaining;
        // The exact duration, not the difference of two times, because rounding must not leave a
        // remainder of the service.
        let worked = if fails {
            until_failure
        } else {
            station.remaining
        };
        station.running = false;
        station.remaining -= worked;
        if station.phase == Phase::Service {
            station.failures.worked(worked);
        }
        if fails {
            if let Some(mode) = station.failures.strike_at_work() {
                self.break_down(node, mode);
            }
        } else if let Some(part) = station.part {
            if station.phase == Phase::Setup {
                self.serve_part(node, part);
            } else {
                self.end_service(node, part);
            }
        }
    }

    /// Lets a repaired station continue or begin its work.
    pub(super) fn work_again(&mut self, node: usize) {
        let now = self.now;
        let station = self.station(node);
        if matches!(station.phase, Phase::Setup | Phase::Service) {
            self.resume(node);
        } else {
            station.book(now);
            self.record_state(node);
            self.begin_wait(node);
            self.look_at(node);
        }
    }

    /// Ends the service: the part receives its new properties and possibly random defects, and
    /// leaves when it can.
    fn end_service(&mut self, node: usize, part: PartIndex) {
        let now = self.now;
        let station = station_of(&mut self.nodes, node);
        station.processed += 1;
        station.joules += station.service_joules;
        station.control_seconds += station.service_control;
        station.work_seconds += station.phase_seconds;
        station.phase = Phase::Done;
        station.overtime = false;
        // A station that has failed does not end a service.
        let activity = if station.on_shift {
            Activity::Blocked
        } else {
            Activity::Idle
        };
        station.clock.switch(now, activity);
        let can_strike = station.failures.can_strike();
        let finished = &mut self.parts[part];
        finished.worked_at = Some(node as u32);
        let has_properties = !finished.properties.is_empty();
        if has_properties {
            self.change_properties(node, part);
        }
        self.record_end(node, part);
        if can_strike {
            self.strike_finished(node);
        }
        if has_properties && self.refuse_out_of_range(node, part) {
            return;
        }
        self.offer(node, node, part);
    }

    /// Lets the failures strike that come after a number of parts.
    #[inline(never)]
    fn strike_finished(&mut self, node: usize) {
        for mode in self.station(node).failures.part_finished() {
            self.break_down(node, mode);
        }
    }

    /// Gives a part the properties that follow from the work on it, and possibly random defects.
    #[inline(never)]
    fn change_properties(&mut self, node: usize, part: PartIndex) {
        let observed = self.is_observed();
        let NodeKind::Station(declared) = &self.line.nodes[node].kind else {
            return;
        };
        let defects = &declared.defects;
        let Place::Station(station) = &mut self.nodes[node].place else {
            return;
        };
        let finished = &mut self.parts[part];
        let before = observed.then(|| finished.properties.clone());
        if station.times[station.task as usize].is_none() {
            finished.properties.clone_from(&station.outcome);
        }
        declared.set_values(finished.kind, &mut finished.properties);
        let mut changes = before.map(|before| changes(&before, &finished.properties));
        for defect in defects.iter().filter(|d| d.part == finished.kind) {
            if defect.properties.is_empty() || !station.defects.chance(defect.probability) {
                continue;
            }
            let chosen = station.defects.below(defect.properties.len() as u64) as usize;
            let chosen = defect.properties[chosen];
            let count = finished.properties.len();
            finished.properties.push(finished.properties[chosen]);
            let value = defect.value.eval(&finished.properties, &[]);
            finished.properties.truncate(count);
            finished.properties[chosen] = value;
            finished.defect_at = Some(node as u32);
            if let Some(changes) = &mut changes {
                changes.push((EventKind::Defect, Other::Property(chosen, value)));
            }
        }
        for (what, property) in changes.into_iter().flatten() {
            self.record_with(node, Some(part), what, Some(property));
        }
    }

    /// Frees a station that no longer has a part in work.
    #[inline(never)]
    pub(super) fn station_left(&mut self, node: usize) {
        let now = self.now;
        self.station(node).clear(now);
        self.record_state(node);
    }

    /// A shift of the station begins or ends. If work that has begun is finished, the station goes
    /// on with its part.
    pub(super) fn station_shift(&mut self, node: usize, finishes_work: bool) {
        let (now, on_shift) = (self.now, self.shifts.is_on(node));
        self.end_wait(node);
        let station = self.station(node);
        station.on_shift = on_shift;
        // A part that comes at this very instant waits for the next shift.
        let has_begun =
            matches!(station.phase, Phase::Setup | Phase::Service) && station.begun_at < now;
        station.overtime = !on_shift && finishes_work && has_begun;
        if !on_shift && !station.overtime {
            station.pause(now);
        }
        self.work_again(node);
        self.look_at(node);
    }
}
