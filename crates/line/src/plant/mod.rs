//! The plant: a line with its controllers, ready to run, and the loop that takes one event after the other.
//!
//! One event changes one node; what follows from it at the same instant (a part moves up, so that another one moves up behind
//! it) is done from a list of nodes to look at again, never by recursion, so that a line of any length and shape runs in
//! a bounded stack. How each kind of node behaves stands in its own file here.

mod belt;
mod blocked;
mod conveyor;
mod finish;
mod flow;
mod part;
mod station;
mod supply;

use super::calendar::Calendar;
use super::random::Stream;
use super::statistics::LeadTimes;
use super::trace::{End, LogEntry, MAX_VIOLATIONS, Trace, Violation, What};
use super::{Options, validate};
use belt::BeltState;
use conveyor::Conveyor;
use flow::{Outlet, Request, Ways};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Limit, Line, NodeKind, Shift};
use linewright_station::{CallError, Controller, ErrorCode};
use part::{PartIndex, Parts};
use station::Station;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use supply::{Source, Store};

/// More than so many movements and events at one instant, and time is taken to stand still for good.
const MAX_AT_ONE_INSTANT: u64 = 1_000_000;
/// More than so many violations at one instant, likewise; each may cost a whole operation.
const MAX_VIOLATIONS_AT_ONE_INSTANT: u64 = 10_000;
/// More than so many events since the last end product, and a run that waits for products is taken to make none any more.
const MAX_EVENTS_WITHOUT_PRODUCT: u64 = 5_000_000;
/// More than so many violations since the last end product, likewise.
const MAX_VIOLATIONS_WITHOUT_PRODUCT: u64 = 500;
/// The real clock is looked at every so many events.
const EVENTS_A_LOOK: u64 = 16;

/// A line that can be run, again and again.
pub struct Plant {
    setup: Setup,
    controllers: Vec<Option<Box<dyn Controller>>>,
}

/// All that stays the same from run to run.
struct Setup {
    line: Arc<Line>,
    options: Options,
    /// End products that are wanted.
    target: Option<u64>,
    /// Seconds after which it is over.
    horizon: Option<f64>,
    ways: Ways,
    /// The outlets, without their parts, and each node's first one.
    outlets: Vec<Outlet>,
    first_outlet: Vec<usize>,
    /// How many of part type `b` are in one of part type `a`, at `a * types + b`; 1 on the diagonal.
    contents: Vec<u64>,
}

/// What the calendar holds.
#[derive(Debug, Clone, Copy)]
enum Event {
    /// Setup or service ends, or the station breaks down; outdated where the number is no longer the station's.
    Station(u32, u32),
    /// A station is repaired.
    Repair(u32),
    /// A source's next part is due.
    Due(u32),
    /// The first part on a conveyor has come to its end.
    Arrival(u32),
    /// A conveyor's first place is free again.
    Reopen(u32),
    /// A belt's controller is stepped.
    Tick(u32),
    /// Work begins or ends for the day.
    Shift,
}

/// What stations, sources and conveyors do comes first, then the shift (a service that ends with it has ended), then the belts,
/// which see all of it.
const WORK: u8 = 0;
const SHIFT: u8 = 1;
const BELT: u8 = 2;

/// What a node holds.
enum Place {
    Source(Source),
    Sink,
    Store(Store),
    Station(Box<Station>),
    Conveyor(Box<Conveyor>),
    Belt(Box<BeltState>),
    Buffer(VecDeque<PartIndex>),
}

/// One run.
struct Run<'a> {
    setup: &'a Setup,
    line: &'a Line,
    controllers: &'a mut [Option<Box<dyn Controller>>],
    seed: u64,
    now: f64,
    calendar: Calendar<Event>,
    /// How many events that can change something are entered: all but those of the shift.
    pending: u64,
    events: u64,
    on_shift: bool,
    parts: Parts,
    places: Vec<Place>,
    outlets: Vec<Outlet>,
    /// Who waits for each node.
    waiting: Vec<VecDeque<Request>>,
    /// The nodes to look at again, each at most once.
    work: VecDeque<u32>,
    in_work: Vec<bool>,
    /// Numbers requests and complete bills in their order.
    order: u64,
    end: Option<End>,
    // Counters.
    products: u64,
    stored: u64,
    makespan: f64,
    lead_times: LeadTimes,
    entered: u64,
    finished: u64,
    consumed: u64,
    /// By type: how many have been made or given out and have not left the line, by themselves or joined to others.
    in_line: Vec<u64>,
    rejects: Vec<(u64, u64)>,
    violations: Vec<Violation>,
    violation_count: u64,
    /// The number of violations by node, rule and code, for one finding each.
    violation_kinds: BTreeMap<(usize, Option<String>, i32), (usize, u64)>,
    log: Vec<LogEntry>,
    findings: Vec<Diagnostic>,
    /// Nodes and types for which there was no way onward.
    wayless: Vec<(usize, usize)>,
    // Guards against standing still.
    instant: f64,
    at_instant: u64,
    violations_at_instant: u64,
    events_at_product: u64,
    violations_at_product: u64,
}

impl Plant {
    /// A line with a controller for each of its stations and contracted belts, by node. `options` say when a run ends;
    /// where they do not, the line itself does.
    ///
    /// The findings are `LW404` where a run would have no end, and `LW401` for a line that the resolver should have refused.
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
                    format!("nothing says when a run of {} ends", line.name),
                )
                .with_help("Give --parts N or --until TIME, or a limit in the line's file."),
            );
        }
        if horizon.is_some_and(|seconds| !(seconds.is_finite() && seconds >= 0.0)) {
            findings.push(
                Diagnostic::error(
                    codes::LINE_LIMIT,
                    line.span,
                    format!(
                        "the time after which a run of {} ends is no time",
                        line.name
                    ),
                )
                .with_help("Give a time such as 3600, 90m or 8h."),
            );
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
        let (outlets, first_outlet) = flow::outlets(&line);
        let contents = part::contents(&line);
        Ok(Self {
            setup: Setup {
                line,
                options,
                target,
                horizon,
                ways,
                outlets,
                first_outlet,
                contents,
            },
            controllers: slots,
        })
    }

    /// The line.
    pub fn line(&self) -> &Line {
        &self.setup.line
    }

    /// The seed of the options.
    pub fn seed(&self) -> u64 {
        self.setup.options.seed
    }

    /// Runs the line from its start, with the seed of the options.
    pub fn run(&mut self) -> Trace {
        self.run_seeded(self.setup.options.seed)
    }

    /// Runs the line from its start, with this seed.
    pub fn run_seeded(&mut self, seed: u64) -> Trace {
        for controller in self.controllers.iter_mut().flatten() {
            controller.reset();
        }
        let mut run = Run::new(&self.setup, &mut self.controllers, seed);
        let end = run.advance();
        run.finish(end)
    }

    /// Whether the deadline of the real clock is past.
    pub(super) fn is_late(&self) -> bool {
        self.setup.options.deadline.is_past()
    }
}

impl<'a> Run<'a> {
    fn new(
        setup: &'a Setup,
        controllers: &'a mut [Option<Box<dyn Controller>>],
        seed: u64,
    ) -> Self {
        let line: &Line = &setup.line;
        let on_shift = line.shift.is_none_or(|shift| shift.from <= 0.0);
        let places = line
            .nodes
            .iter()
            .enumerate()
            .map(|(index, node)| match &node.kind {
                NodeKind::Source { part, supply, .. } => Place::Source(Source::new(
                    &node.name,
                    supply,
                    seed,
                    setup
                        .target
                        .map(|count| count.saturating_mul(setup.content(line.product, *part))),
                )),
                NodeKind::Sink { .. } => Place::Sink,
                NodeKind::Store { stock } => Place::Store(Store::new(stock, line.parts.len())),
                NodeKind::Station { tasks, .. } => {
                    Place::Station(Box::new(Station::new(line, index, tasks, seed, on_shift)))
                }
                NodeKind::Conveyor {
                    belt: Some(belt), ..
                } => Place::Belt(Box::new(BeltState::new(belt))),
                NodeKind::Conveyor { .. } => Place::Conveyor(Box::default()),
                NodeKind::Buffer { .. } => Place::Buffer(VecDeque::new()),
            })
            .collect();
        Self {
            setup,
            line,
            controllers,
            seed,
            now: 0.0,
            calendar: Calendar::new(),
            pending: 0,
            events: 0,
            on_shift,
            parts: Parts::default(),
            places,
            outlets: setup.outlets.clone(),
            waiting: line.nodes.iter().map(|_| VecDeque::new()).collect(),
            work: VecDeque::new(),
            in_work: vec![false; line.nodes.len()],
            order: 0,
            end: None,
            products: 0,
            stored: 0,
            makespan: 0.0,
            lead_times: LeadTimes::new(seed),
            entered: 0,
            finished: 0,
            consumed: 0,
            in_line: vec![0; line.parts.len()],
            rejects: vec![(0, 0); line.parts.len()],
            violations: Vec::new(),
            violation_count: 0,
            violation_kinds: BTreeMap::new(),
            log: Vec::new(),
            findings: Vec::new(),
            wayless: Vec::new(),
            instant: 0.0,
            at_instant: 0,
            violations_at_instant: 0,
            events_at_product: 0,
            violations_at_product: 0,
        }
    }

    /// Runs to the end and says why it is one.
    fn advance(&mut self) -> End {
        if self.setup.target == Some(0) {
            return End::Products;
        }
        self.schedule_shift();
        for node in 0..self.places.len() {
            self.look_at(node);
        }
        self.settle();
        self.guard();
        loop {
            if let Some(end) = self.end {
                return end;
            }
            // Off shift, the calendar may hold nothing but the shift, and the line still go on in the morning.
            if self.pending == 0 && self.on_shift {
                return self.stand_still();
            }
            let Some(time) = self.calendar.next_time() else {
                return self.stand_still();
            };
            if let Some(horizon) = self.setup.horizon
                && time > horizon
            {
                self.now = horizon;
                return End::Time;
            }
            if let Some((time, event)) = self.calendar.take() {
                self.now = time;
                self.events += 1;
                self.happen(event);
                self.settle();
                self.guard();
                if self.events.is_multiple_of(EVENTS_A_LOOK) {
                    self.look_at_clock();
                }
            }
        }
    }

    fn happen(&mut self, event: Event) {
        if !matches!(event, Event::Shift) {
            self.pending -= 1;
        }
        match event {
            Event::Station(node, number) => self.station_event(node as usize, number),
            Event::Repair(node) => self.repair(node as usize),
            Event::Due(node) => self.due(node as usize),
            Event::Arrival(node) => self.arrival(node as usize),
            Event::Reopen(node) => self.reopen(node as usize),
            Event::Tick(node) => self.tick(node as usize),
            Event::Shift => self.change_shift(),
        }
    }

    fn schedule(&mut self, time: f64, priority: u8, event: Event) {
        if !matches!(event, Event::Shift) {
            self.pending += 1;
        }
        self.calendar.schedule(time, priority, event);
    }

    /// Enters the next change of shift; a shift without an end has none.
    fn schedule_shift(&mut self) {
        const DAY: f64 = Shift::DAY;
        let Some(shift) = self.line.shift else { return };
        if shift.from <= 0.0 && shift.to >= DAY {
            return;
        }
        let day = (self.now / DAY).floor() * DAY;
        let next = if self.on_shift {
            day + shift.to
        } else if day + shift.from > self.now {
            day + shift.from
        } else {
            day + DAY + shift.from
        };
        self.schedule(next, SHIFT, Event::Shift);
    }

    fn change_shift(&mut self) {
        self.on_shift = !self.on_shift;
        for node in 0..self.places.len() {
            if matches!(self.places[node], Place::Station(_)) {
                self.station_shift(node);
            }
        }
        self.schedule_shift();
    }

    /// Notices when the run no longer gets anywhere.
    fn guard(&mut self) {
        if self.now > self.instant {
            self.instant = self.now;
            self.at_instant = 0;
            self.violations_at_instant = 0;
        } else {
            self.at_instant += 1;
        }
        if self.end.is_some() {
            return;
        }
        if self.stands_still() {
            self.end = Some(End::Blocked);
            let message = format!(
                "the line makes no progress: at {} parts move on and on, and no time passes",
                self.moment()
            );
            self.findings.push(
                Diagnostic::error(codes::LINE_BLOCKED, self.line.span, message).with_help(
                    "Look for a source without a time, a circle of routes without a station, or a station whose \
                     every part breaks a rule and is ordered again.",
                ),
            );
        } else if self.setup.horizon.is_none() && self.is_barren() {
            self.end = Some(End::Blocked);
            let refused = self.violation_count - self.violations_at_product;
            let since = if refused > MAX_VIOLATIONS_WITHOUT_PRODUCT {
                format!("while rules were broken {refused} times")
            } else {
                format!("in the last {MAX_EVENTS_WITHOUT_PRODUCT} events")
            };
            let message = format!(
                "the line makes no progress: it has made {} of {} products, and none {since}",
                self.products,
                self.setup.target.unwrap_or(0),
            );
            self.findings.push(
                Diagnostic::error(codes::LINE_BLOCKED, self.line.span, message).with_help(
                    "See which rule refuses the parts, or why every part is rejected; --until ends a run at a time.",
                ),
            );
        }
    }

    /// Whether a run that waits for products has stopped making any.
    fn is_barren(&self) -> bool {
        self.events - self.events_at_product > MAX_EVENTS_WITHOUT_PRODUCT
            || self.violation_count - self.violations_at_product > MAX_VIOLATIONS_WITHOUT_PRODUCT
    }

    /// Gives up when the deadline of the real clock is reached.
    fn look_at_clock(&mut self) {
        if self.end.is_some() || !self.setup.options.deadline.is_past() {
            return;
        }
        self.end = Some(End::GaveUp);
        let message = format!(
            "the run was not over when the time limit was reached: it has come to {}, with {} products",
            self.moment(),
            self.products
        );
        self.findings.push(
            Diagnostic::error(codes::GAVE_UP, self.line.span, message)
                .with_help("give it more time with --timeout SECONDS, or end it earlier with --parts or --until"),
        );
    }

    /// Whether too much has happened since the clock last moved.
    fn stands_still(&self) -> bool {
        self.at_instant > MAX_AT_ONE_INSTANT
            || self.violations_at_instant > MAX_VIOLATIONS_AT_ONE_INSTANT
    }

    /// The time as a person reads it.
    fn moment(&self) -> String {
        super::trace::clock(self.now)
    }

    fn name(&self, node: usize) -> &'a str {
        &self.line.nodes[node].name
    }

    fn type_name(&self, part_type: usize) -> &'a str {
        &self.line.parts[part_type].name
    }

    fn record(&mut self, node: usize, part: Option<PartIndex>, what: What) {
        if self.setup.options.log {
            self.log.push(LogEntry {
                time: self.now,
                node,
                part: part.map(|part| (self.parts[part].number, self.parts[part].kind)),
                what,
            });
        }
    }

    /// A controller answered with an error.
    fn violate(&mut self, node: usize, part: Option<PartIndex>, error: CallError) {
        self.violation_count += 1;
        self.violations_at_instant += 1;
        let part = part.map(|part| (self.parts[part].number, self.parts[part].kind));
        let kind = (node, error.rule.clone(), error.code as i32);
        if let Some((_, count)) = self.violation_kinds.get_mut(&kind) {
            *count += 1;
        } else {
            let code = match error.code {
                ErrorCode::Assumption
                | ErrorCode::Guarantee
                | ErrorCode::Limit
                | ErrorCode::Order
                | ErrorCode::Domain => codes::LINE_VIOLATION,
                _ => codes::LIBRARY_CALL,
            };
            let rule = match (&error.rule, error.code) {
                (Some(rule), ErrorCode::Assumption) => {
                    format!("the assumption \"{rule}\" was broken")
                }
                (Some(rule), ErrorCode::Guarantee) => {
                    format!("the guarantee \"{rule}\" was broken")
                }
                (Some(rule), _) => format!("\"{rule}\" was broken"),
                (None, ErrorCode::Assumption) => "no inputs keep its assumptions".to_owned(),
                (None, ErrorCode::Limit) => "the operation did not end".to_owned(),
                (None, ErrorCode::Domain) => "a value is outside its domain".to_owned(),
                (None, _) => "the controller refused a call".to_owned(),
            };
            let work = part.map_or(String::new(), |(number, kind)| {
                format!(", at work on {} {number}", self.type_name(kind))
            });
            let message = format!(
                "{}: {rule} at {}{work}: {}",
                self.name(node),
                self.moment(),
                error.message
            );
            self.violation_kinds.insert(kind, (self.findings.len(), 1));
            self.findings.push(
                Diagnostic::error(code, self.line.nodes[node].span, message).with_help(
                    if error.code == ErrorCode::Order {
                        "Let the station's operations come in an order that the rule allows, or mend what calls the skills: `linewright order complete` says what may come next."
                    } else {
                        "Compare what the rule asks for with the part's properties and the machine's bindings."
                    },
                ),
            );
        }
        if self.violations.len() < MAX_VIOLATIONS {
            self.violations.push(Violation {
                time: self.now,
                node,
                part,
                code: error.code,
                rule: error.rule,
                message: error.message,
            });
        }
    }
}

impl Setup {
    /// How many of part type `b` are in one of `a`, and at least one.
    fn content(&self, a: usize, b: usize) -> u64 {
        self.contents[a * self.line.parts.len() + b].max(1)
    }
}

/// A stream of this run for a node.
fn stream(seed: u64, purpose: super::random::Purpose, name: &str) -> Stream {
    Stream::new(seed, purpose, name)
}
