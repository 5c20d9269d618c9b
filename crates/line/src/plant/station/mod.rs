//! Stations: what a station is, with its state, its accounts, and what it admits.
//!
//! What a run does with it is in `work.rs`.

mod work;

use super::failures::Failures;
use super::stream;
use super::waits::Waits;
use crate::plant::part::{Part, PartIndex};
use crate::random::{Purpose, Stream};
use crate::sampler::Sampler;
use crate::statistics::{Activity, Clock, Output};
use crate::trace::{Oee, WorkTime};
use linewright_language::contract::line::{self, Line};

/// State of a station.
///
/// In the order of declaration: what every part needs stands together, so that a line of many
/// stations stays in the processor's cache.
#[derive(Debug)]
#[repr(C)]
pub(super) struct Station {
    pub phase: Phase,
    /// Whether setup or service is in progress, not interrupted by a breakdown or the end of a
    /// shift.
    running: bool,
    on_shift: bool,
    /// Whether the station is off shift and finishes its part nevertheless.
    overtime: bool,
    /// Only the event with this number is valid.
    number: u32,
    /// The part in work, or the finished part that waits to leave.
    pub part: Option<PartIndex>,
    task: u32,
    pub clock: Clock,
    /// By task: its places for components; no places if the task joins nothing. Empty if no task
    /// joins anything.
    pub bills: Vec<Bill>,
    /// By part type: the first task that works on arriving parts of this type without joining.
    plain: Vec<Option<u32>>,
    /// By task: the duration of the work; `None` if a controller determines it.
    times: Vec<Option<Sampler>>,
    /// Seconds left in this phase, as of the time `resumed`.
    remaining: f64,
    resumed: f64,
    /// Time at which setup or service for the part began.
    begun_at: f64,
    /// Duration of this phase.
    phase_seconds: f64,
    service_joules: f64,
    /// Power during work whose duration no controller determines.
    watts: f64,
    // Time and energy accounts.
    pub joules: f64,
    pub processed: u64,
    pub work_seconds: f64,
    pub waits: Waits,
    /// Part type of the task that began last; another type needs setup.
    last_kind: Option<usize>,
    /// The number under which a part notes that it was here; `None` if no part comes twice.
    visit: Option<u32>,
    pub failures: Failures,
    /// The part of the service in which no action is active, in seconds.
    service_control: f64,
    /// Seconds of control in the services that ended, and their total duration without failures.
    pub control_seconds: f64,
    /// Part type of each task.
    kinds: Vec<usize>,
    setup: Sampler,
    defects: Stream,
    /// The part's properties after the current service, and the machine's properties during it.
    outcome: Vec<f64>,
    values: Vec<f64>,
    /// Seconds of work that was lost because it began again after a failure.
    pub lost_seconds: f64,
    /// Number of parts that were rejected because of this station; see `Run::charge_scrap`.
    pub scrapped: u64,
    /// Number of parts that a failure scrapped during the work; they are not `processed`.
    broken: u64,
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

impl Bill {
    /// Whether the missing components may still come, as `comes` states by type.
    fn may_be_complete(&self, comes: &impl Fn(usize) -> bool) -> bool {
        let mut lines = self.lines.iter();
        lines.all(|(kind, count, there)| there.len() >= *count || comes(*kind))
    }
}

impl Station {
    pub(super) fn new(
        line: &Line,
        node: usize,
        station: &line::Station,
        visit: Option<u32>,
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
            visit,
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

    /// Whether the station works on parts of this type without joining.
    pub(super) fn works_alone_on(&self, kind: usize) -> bool {
        self.plain[kind].is_some()
    }

    /// Whether the station is off shift and finishes its part nevertheless.
    pub(super) fn is_in_overtime(&self) -> bool {
        self.overtime
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

    /// Whether a task may join parts of this type some day. `comes` states whether a component of a
    /// type that is missing may still come.
    pub(super) fn may_use(&self, kind: usize, comes: impl Fn(usize) -> bool) -> bool {
        let uses = |bill: &&Bill| bill.lines.iter().any(|(wanted, ..)| *wanted == kind);
        let mut bills = self.bills.iter().filter(uses);
        bills.any(|bill| bill.may_be_complete(&comes))
    }

    /// The same for a task that makes parts of this type.
    pub(super) fn may_make(&self, kind: usize, comes: impl Fn(usize) -> bool) -> bool {
        let mut tasks = self.kinds.iter().zip(&self.bills);
        tasks.any(|(made, bill)| {
            *made == kind && !bill.lines.is_empty() && bill.may_be_complete(&comes)
        })
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
        if let Some(number) = self.visit {
            part.visit(number);
        }
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
        let outside = self.clock.at(now).outside_work();
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

    /// Overall equipment effectiveness, after the accounts have been closed.
    pub(super) fn oee(&self) -> Option<Oee> {
        self.output().oee(&self.clock)
    }

    /// What the station has made since counting began.
    pub(super) fn output(&self) -> Output {
        Output {
            processed: self.processed,
            broken: self.broken,
            scrapped: self.scrapped,
            lost_seconds: self.lost_seconds,
        }
    }
}
