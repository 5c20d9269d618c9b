//! The plant: a line with its controllers, ready to run, and the event loop.
//!
//! Each event changes one node. The consequences at the same instant (a part moves up, and another
//! moves up behind it) are handled by a list of nodes to examine again, never by recursion. The
//! stack is therefore bounded for lines of any length and shape. The behavior of each kind of node
//! is in its own file here.

mod accounts;
mod batches;
mod belt;
mod blocked;
mod buffer;
mod chooser;
mod conveyor;
mod counters;
mod deadlock;
mod failures;
mod finish;
mod flow;
mod journal;
mod observe;
mod part;
mod progress;
mod queue;
mod shifts;
mod station;
mod supply;
mod waits;
mod warm_up;
mod ways;

use super::bottleneck::Deadlock;
use super::calendar::Calendar;
use super::log::Observer;
use super::metric::percentiles_of_wait;
use super::random::{Purpose, Stream};
use super::sampler::Sampler;
use super::trace::{End, Trace};
use super::{Monitor, Options, monitor, validate};
use batches::Cuts;
use belt::BeltState;
use buffer::Buffer;
use chooser::Chooser;
use conveyor::Conveyor;
use counters::Counters;
use flow::Outlet;
use journal::Journal;
use linewright_core::deadline::StopReason;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Limit, Line, NodeKind, declared_name};
use linewright_station::Controller;
use observe::Recorder;
use part::Parts;
use progress::{LATEST_SECONDS, Progress};
use queue::{Agenda, Requests};
use shifts::Shifts;
use station::Station;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use supply::{Source, Store};
use ways::Ways;

/// Number of events between checks of the wall clock.
const DEADLINE_CHECK_INTERVAL: u64 = 16;

/// A line that can be run repeatedly.
pub struct Plant {
    setup: Setup,
    controllers: Vec<Option<Box<dyn Controller>>>,
}

/// Everything that stays the same from run to run.
struct Setup {
    line: Arc<Line>,
    options: Options,
    /// Watches the runs; `None` if nobody does.
    monitor: Option<Arc<Monitor>>,
    /// Whether the monitor shows the runs. If not, it only counts them.
    is_shown: bool,
    /// Whether a pilot run has found the warm-up of the options.
    warm_up_found: bool,
    /// Number of end products after which the run ends; `None` if they do not end it.
    target: Option<u64>,
    /// Simulated seconds after which the run ends; `None` if time does not end it.
    horizon: Option<f64>,
    ways: Ways,
    /// The outlets of stores; see [`flow::store_outlets`].
    store_outlets: Vec<(usize, usize)>,
    /// Number of parts of type `b` in one part of type `a`, at index `a * types + b`; 1 if `a` is
    /// `b`.
    contents: Vec<u64>,
    /// By node: the number under which parts note that a station has worked on them, which is that
    /// of the first of parallel stations; `None` if no part comes twice.
    visits: Vec<Option<u32>>,
    /// The sources that stop while a number of parts is in the line.
    limited_sources: Vec<usize>,
    /// By node: whether it is a station that can be down.
    can_be_down: Vec<bool>,
    /// By node: for a station, the stations that can be down and from which its parts come.
    suppliers: Vec<Vec<u32>>,
}

/// An event in the calendar.
#[derive(Debug, Clone, Copy)]
enum Event {
    /// Setup or service ends, or the station breaks down; the event is outdated if its number
    /// differs from the station's.
    Station(u32, u32),
    /// A station breaks down by the calendar, in this of its failure modes.
    Failure(u32, u32),
    /// A station is repaired.
    Repair(u32),
    /// A source's next part is due.
    Due(u32),
    /// The first part on a conveyor reaches its end.
    Arrival(u32),
    /// A conveyor's first place is free again.
    Reopen(u32),
    /// A belt's controller is stepped.
    Tick(u32),
    /// A part has rested long enough in its buffer.
    Rested(u32),
    /// A part expires in its buffer.
    Expiry(u32),
    /// Some shifts begin or end, or breaks do.
    Shift,
    /// The warm-up ends.
    WarmUp,
    /// A batch ends.
    Batch,
}

impl Event {
    /// Whether the event can set something going in a line in which nothing moves: all except
    /// shifts, which are handled separately, failures, and the ends of the warm-up and of batches.
    #[inline]
    fn sets_going(self) -> bool {
        let others = matches!(self, Self::Shift | Self::Failure(..));
        !others && !matches!(self, Self::WarmUp | Self::Batch)
    }
}

/// Priorities of events at one instant: first stations, sources and conveyors; then the shift, so
/// that a service can end at the same instant as the shift; then the belts, which thus read the
/// result of all other events.
const WORK: u8 = 0;
const SHIFT: u8 = 1;
const BELT: u8 = 2;
/// The warm-up, and then a batch, ends after everything else that happens at its instant.
const WARM_UP: u8 = 3;
const BATCH: u8 = 4;

/// A node in a run. Everything that does not depend on its kind fits into one line of the
/// processor's cache.
#[repr(align(64))]
struct Node {
    place: Place,
    /// The parts that wait for it.
    requests: Requests,
    /// The part that would leave next; not used by stores, which have several outlets.
    outlet: Outlet,
    /// Whether it is on the list of nodes to examine again.
    is_listed: bool,
}

#[cfg(target_pointer_width = "64")]
const _: () = assert!(size_of::<Node>() == 64);

/// State of a node.
enum Place {
    Source(Box<Source>),
    Sink,
    Store(Box<Store>),
    Station(Box<Station>),
    Conveyor(Box<Conveyor>),
    Belt(Box<BeltState>),
    Buffer(Box<Buffer>),
}

/// One run.
struct Run<'a> {
    setup: &'a Setup,
    line: &'a Line,
    controllers: &'a mut [Option<Box<dyn Controller>>],
    seed: u64,
    now: f64,
    calendar: Calendar<Event>,
    /// Number of scheduled events that can set something going: see [`Event::sets_going`].
    pending: u64,
    events: u64,
    shifts: Shifts,
    /// Time at which the warm-up ended; `None` during it, and if there is none.
    counting_since: Option<f64>,
    parts: Parts,
    nodes: Vec<Node>,
    store_outlets: Vec<Outlet>,
    /// Last sequence number given to a request or a complete bill.
    requests: u64,
    choosers: Vec<Chooser>,
    agenda: Agenda,
    end: Option<End>,
    counters: Counters,
    journal: Journal,
    recorder: Recorder<'a>,
    progress: Progress,
    /// Whether nothing happens any more.
    rests: bool,
    /// Parts that wait for one another for ever.
    deadlock: Option<Deadlock>,
    /// The batches so far; `None` before counting begins, and if none are wanted.
    cuts: Option<Cuts>,
}

impl Plant {
    /// Prepares a line. `controllers` maps each station, and each conveyor with a contract, to its
    /// controller. The `options` determine when a run ends; if they do not, the line's `limit`
    /// does.
    ///
    /// Returns `LW404` if a run would have no end or an invalid one, and `LW401` for a line that
    /// the resolver should have rejected.
    pub fn new(
        line: Arc<Line>,
        controllers: BTreeMap<usize, Box<dyn Controller>>,
        options: Options,
    ) -> Result<Self, Vec<Diagnostic>> {
        let mut findings = validate::validate(&line, |node| controllers.contains_key(&node));
        let (target, horizon) = match (options.parts, options.until, line.limit) {
            (None, None, Some(Limit::Products(count))) => (Some(count), None),
            (None, None, Some(Limit::Seconds(seconds))) => (None, Some(seconds)),
            (target, horizon, _) => (target, horizon),
        };
        if target.is_none() && horizon.is_none() {
            findings.push(
                Diagnostic::error(
                    codes::LINE_LIMIT,
                    line.span,
                    format!("a run of {} has no end condition", line.name),
                )
                .with_help("Give --parts N or --until TIME, or a limit in the line's file."),
            );
        }
        if horizon.is_some_and(|seconds| !(0.0..=LATEST_SECONDS).contains(&seconds)) {
            findings.push(
                Diagnostic::error(
                    codes::LINE_LIMIT,
                    line.span,
                    format!(
                        "the run of {} has an invalid end time",
                        line.name
                    ),
                )
                .with_help(format!(
                    "Give a time such as 3600, 90m or 8h; the maximum is {LATEST_SECONDS} s, beyond which times are no longer exact."
                )),
            );
        }
        let warm_up = options.warm_up;
        let ends_first = horizon.is_some_and(|seconds| warm_up >= seconds);
        if warm_up > 0.0 && ends_first || !(0.0..=LATEST_SECONDS).contains(&warm_up) {
            findings.push(
                Diagnostic::error(
                    codes::LINE_LIMIT,
                    line.span,
                    match horizon {
                        Some(seconds) if warm_up <= LATEST_SECONDS => format!(
                            "the run of {} ends at {}, and its warm-up not before {}",
                            line.name,
                            super::trace::clock(seconds),
                            super::trace::clock(warm_up)
                        ),
                        _ => format!("the warm-up of {} is too long", line.name),
                    },
                )
                .with_help("Let it run longer than the warm-up: `--warm-up 2h --until 10h`."),
            );
        }
        if let Some(count) = options.batches {
            findings.extend(batches::refused(&line, count, target, horizon));
        }
        if !findings.is_empty() {
            return Err(findings);
        }
        let mut slots: Vec<_> = line.nodes.iter().map(|_| None).collect();
        for (node, controller) in controllers {
            if let Some(slot) = slots.get_mut(node) {
                *slot = Some(controller);
            }
        }
        let ways = Ways::new(&line);
        let store_outlets = flow::store_outlets(&line);
        let contents = part::contents(&line);
        let visits = visits(&line);
        let is_limited = |node: &usize| {
            let kind = &line.nodes[*node].kind;
            matches!(kind, NodeKind::Source { most: Some(_), .. })
        };
        let limited_sources = (0..line.nodes.len()).filter(is_limited).collect();
        let can_be_down = waits::can_be_down(&line);
        let suppliers = waits::suppliers(&line, &can_be_down);
        Ok(Self {
            setup: Setup {
                line,
                options,
                monitor: None,
                is_shown: false,
                warm_up_found: false,
                target,
                horizon,
                ways,
                store_outlets,
                contents,
                visits,
                limited_sources,
                can_be_down,
                suppliers,
            },
            controllers: slots,
        })
    }

    /// Lets a monitor watch the runs. `is_shown` states whether it shows them, or only counts them.
    #[must_use]
    pub fn watched(mut self, monitor: Option<Arc<Monitor>>, is_shown: bool) -> Self {
        self.setup.monitor = monitor;
        self.setup.is_shown = is_shown;
        self
    }

    /// The line.
    pub fn line(&self) -> &Line {
        &self.setup.line
    }

    /// The seed from the options.
    pub fn seed(&self) -> u64 {
        self.setup.options.seed
    }

    /// Runs the line from its start with the seed from the options.
    pub fn run(&mut self) -> Trace {
        self.run_seeded(self.setup.options.seed)
    }

    /// Runs the line from its start with this seed.
    pub fn run_seeded(&mut self, seed: u64) -> Trace {
        self.run_observed(seed, None)
    }

    /// Runs the line from its start with this seed, before the eyes of an observer. The trace is
    /// the same without it.
    pub fn run_observed(&mut self, seed: u64, observer: Option<&mut dyn Observer>) -> Trace {
        // Shortens the life of the reference to that of the run.
        let observer = observer.map(|observer| observer as &mut dyn Observer);
        let mut run = self.begin(seed, observer);
        let end = run.advance();
        run.finish(end)
    }

    /// Prepares a run from the start of the line with this seed.
    fn begin<'a>(&'a mut self, seed: u64, observer: Option<&'a mut dyn Observer>) -> Run<'a> {
        for controller in self.controllers.iter_mut().flatten() {
            controller.reset();
        }
        let mut run = Run::new(&self.setup, &mut self.controllers, seed);
        run.recorder.observer = observer;
        run
    }

    /// Counts a complete run for the monitor.
    pub(super) fn count_run(&self) {
        if let Some(monitor) = &self.setup.monitor {
            monitor.count_run();
        }
    }

    /// Why no further run begins; `None` if the wall-clock deadline has not passed.
    pub(super) fn late(&self) -> Option<StopReason> {
        self.setup.options.deadline.check().err()
    }
}

impl<'a> Run<'a> {
    fn new(
        setup: &'a Setup,
        controllers: &'a mut [Option<Box<dyn Controller>>],
        seed: u64,
    ) -> Self {
        let line: &Line = &setup.line;
        let shifts = Shifts::new(line);
        let places = line.nodes.iter().enumerate();
        let places = places.map(|(index, node)| match &node.kind {
            NodeKind::Source { part, supply, .. } => {
                let orders = setup.orders(*part);
                Place::Source(Box::new(Source::new(&node.name, supply, seed, orders)))
            }
            NodeKind::Sink { .. } => Place::Sink,
            NodeKind::Store { stock } => {
                let outlets = setup.outlets_of_store(index);
                Place::Store(Box::new(Store::new(stock, line.parts.len(), outlets)))
            }
            NodeKind::Station(declared) => Place::Station(Box::new(Station::new(
                line,
                index,
                declared,
                setup.visits[index],
                seed,
                shifts.is_on(index),
            ))),
            NodeKind::Conveyor {
                belt: Some(belt), ..
            } => Place::Belt(Box::new(BeltState::new(belt))),
            NodeKind::Conveyor {
                places,
                pitch,
                speed,
                ..
            } => Place::Conveyor(Box::new(Conveyor::new(*places as usize, pitch / speed))),
            NodeKind::Buffer {
                capacity,
                order,
                dwell,
                shelf_life,
            } => {
                let draws = || stream(seed, Purpose::Dwell, &node.name);
                let dwell = (!dwell.is_zero()).then(|| Sampler::new(dwell, draws()));
                let buffer = Buffer::new(*capacity, order)
                    .with_dwell(dwell)
                    .with_percentiles(percentiles_of_wait(line, index), seed)
                    .with_shelf_life(*shelf_life);
                Place::Buffer(Box::new(buffer))
            }
        });
        let nodes = places.map(|place| Node {
            place,
            requests: Requests::default(),
            outlet: Outlet::default(),
            is_listed: false,
        });
        let nodes = nodes.collect();
        Self {
            setup,
            line,
            controllers,
            seed,
            now: 0.0,
            calendar: Calendar::new(),
            pending: 0,
            events: 0,
            shifts,
            counting_since: None,
            parts: Parts::default(),
            nodes,
            store_outlets: vec![Outlet::default(); setup.store_outlets.len()],
            requests: 0,
            choosers: Chooser::all(line, seed),
            agenda: Agenda::default(),
            end: None,
            counters: Counters::new(line, seed),
            journal: Journal::default(),
            recorder: Recorder::default(),
            progress: Progress::default(),
            rests: false,
            deadlock: None,
            cuts: None,
        }
    }

    /// Runs to the end and returns the reason for ending.
    fn advance(&mut self) -> End {
        self.open_log();
        if self.setup.target == Some(0) {
            return End::Products;
        }
        self.schedule_shift();
        if !self.setup.has_warm_up() {
            self.begin_batches();
        } else if self.setup.options.warm_up > 0.0 {
            self.schedule(self.setup.options.warm_up, WARM_UP, Event::WarmUp);
        }
        for node in 0..self.nodes.len() {
            self.schedule_failures(node);
            self.schedule_arrival(node);
            self.look_at(node);
        }
        self.settle();
        self.guard();
        loop {
            if let Some(end) = self.end {
                return end;
            }
            // Off shift, the only event in the calendar might be the start of the next shift. The
            // line is not blocked then: it can continue in the morning.
            if self.rests_for_ever() {
                return self.end_blocked();
            }
            let Some((time, event)) = self.calendar.take() else {
                return self.end_blocked();
            };
            if let Some(horizon) = self.setup.horizon
                && time > horizon
            {
                self.now = horizon;
                return End::Time;
            }
            self.now = time;
            self.events += 1;
            self.fetch_next();
            self.happen(event);
            self.settle();
            self.guard();
            if self.events.is_multiple_of(DEADLINE_CHECK_INTERVAL) {
                self.check_deadline();
                if self.events.is_multiple_of(monitor::INTERVAL) {
                    self.show_progress();
                }
            }
        }
    }

    /// Reads what the next event will need, so that in a large line, the processor fetches it while
    /// it deals with this event.
    #[inline]
    fn fetch_next(&self) {
        if let Some(Event::Station(node, _)) = self.calendar.peek()
            && let Place::Station(station) = &self.nodes[node as usize].place
        {
            std::hint::black_box(station.part);
        }
    }

    #[inline]
    fn happen(&mut self, event: Event) {
        match event {
            Event::Station(node, number) => {
                self.pending -= 1;
                self.station_event(node as usize, number);
            }
            _ => self.happen_seldom(event),
        }
    }

    /// Lets an event happen that is not a station's.
    #[inline(never)]
    fn happen_seldom(&mut self, event: Event) {
        if event.sets_going() {
            self.pending -= 1;
        }
        match event {
            Event::Station(..) => {}
            Event::Failure(node, mode) => self.break_down(node as usize, mode as usize),
            Event::Repair(node) => self.repair(node as usize),
            Event::Due(node) => self.due(node as usize),
            Event::Arrival(node) => self.arrival(node as usize),
            Event::Reopen(node) => self.reopen(node as usize),
            Event::Tick(node) => self.tick(node as usize),
            Event::Rested(node) => self.rested(node as usize),
            Event::Expiry(node) => self.expire(node as usize),
            Event::Shift => self.change_shift(),
            Event::WarmUp => self.end_warm_up(),
            Event::Batch => {
                // It belongs to the accounts, not to the line.
                self.events -= 1;
                self.progress.skip_event();
                self.end_batch();
            }
        }
    }

    #[inline]
    fn schedule(&mut self, time: f64, priority: u8, event: Event) {
        if event.sets_going() {
            self.pending += 1;
        }
        self.calendar.schedule(time, priority, event);
    }

    /// The current time in readable form.
    fn moment(&self) -> String {
        super::trace::clock(self.now)
    }

    fn name(&self, node: usize) -> &'a str {
        &self.line.nodes[node].name
    }

    fn type_name(&self, part_type: usize) -> &'a str {
        &self.line.parts[part_type].name
    }
}

impl Setup {
    /// Whether the runs begin with a warm-up.
    fn has_warm_up(&self) -> bool {
        self.options.warm_up > 0.0 || self.options.warm_up_products > 0
    }

    /// Number of parts of a type that are ordered at the start of a run; `None` if there are orders
    /// without end: during the warm-up, and if the products may be of several types.
    fn orders(&self, part: usize) -> Option<u64> {
        let target = self.target.filter(|_| !self.has_warm_up())?;
        let product = self.line.only_product()?;
        Some(target.saturating_mul(self.content(product, part)))
    }

    /// The outlets of a store, of those of all stores.
    fn outlets_of_store(&self, store: usize) -> Range<usize> {
        let outlets = &self.store_outlets;
        let first = outlets.partition_point(|(other, _)| *other < store);
        first..outlets.partition_point(|(other, _)| *other <= store)
    }

    /// Whether a part of type `a` is of type `b`, or contains such a part.
    fn contains(&self, a: usize, b: usize) -> bool {
        self.contents[a * self.line.parts.len() + b] > 0
    }

    /// Number of parts of type `b` in one part of type `a`, but at least 1.
    fn content(&self, a: usize, b: usize) -> u64 {
        self.contents[a * self.line.parts.len() + b].max(1)
    }
}

/// For each node, the first one of the same declaration.
fn first_copies(line: &Line) -> Vec<u32> {
    let mut first = std::collections::BTreeMap::new();
    let nodes = line.nodes.iter().enumerate();
    nodes
        .map(|(index, node)| {
            *first
                .entry(declared_name(&node.name))
                .or_insert(index as u32)
        })
        .collect()
}

/// See [`Setup::visits`]. Nodes without predecessors are removed until there are none. What is left
/// lies on a cycle of routes or behind one; parts come to the other nodes at most once.
fn visits(line: &Line) -> Vec<Option<u32>> {
    let first = first_copies(line);
    let mut ways: Vec<Vec<u32>> = vec![Vec::new(); first.len()];
    let mut before = vec![0_usize; first.len()];
    for route in &line.routes {
        ways[first[route.from] as usize].push(first[route.to]);
        before[first[route.to] as usize] += 1;
    }
    let mut removed: Vec<usize> = (0..first.len()).filter(|node| before[*node] == 0).collect();
    let mut next = 0;
    while let Some(&node) = removed.get(next) {
        next += 1;
        for &to in &ways[node] {
            before[to as usize] -= 1;
            if before[to as usize] == 0 {
                removed.push(to as usize);
            }
        }
    }
    let number = |first: u32| (before[first as usize] > 0).then_some(first);
    first.iter().copied().map(number).collect()
}

/// The random stream of a run for a purpose and the name of a node.
fn stream(seed: u64, purpose: Purpose, name: &str) -> Stream {
    Stream::new(seed, purpose, name)
}
