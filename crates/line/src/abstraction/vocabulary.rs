//! Variables of the abstraction, and expressions over them.
//!
//! A step has an arbitrary duration. In each step, every place can progress by itself (a service
//! ends, a part reaches the end of its belt), and every place can begin to take a part offered to
//! it; that part moves in the next step. So no place depends on another's decision in the same
//! step, and the components of the system are Moore machines. Properties, which decide a part's
//! route, are not known here: an environment variable determines which way the next part will go.
//!
//! Irrelevant detail is left out without loss: a queue that can hold only one part type is a count,
//! because all its parts have the same future.

use super::shape::{PlaceKind, Shape};
use super::words::{all, any, is};
use crate::undecided::UndecidedReason;
use linewright_core::gr1::{BinaryOp, Domain, Expr, Owner, VarId, Variable};
use linewright_language::contract::line::Line;
use std::collections::BTreeMap;

/// Maximum number of slots for parts of different types.
const MAX_SLOTS: usize = 64;
/// Maximum number of places whose parts wait for the same place: the order of their turns needs a
/// formula for every three of them.
const MAX_WAITING: usize = 48;
/// Maximum length of a queue of parts of one type.
const MAX_COUNTED: u32 = 4_096;

/// The variables of a place.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Vars {
    /// Which part the place takes: 0 if none, then one value for each place in
    /// [`super::shape::Place::from`], then one for each bill that the place itself joins.
    pub takes: Option<VarId>,
    /// For a station: 0 if it is free, then one value for each entry of `phases`.
    pub phase: Option<VarId>,
    /// Phases of a station.
    pub phases: Vec<Phase>,
    /// For a station, by task and bill line: the number of components present, and the number
    /// required.
    pub bills: Vec<Vec<(VarId, u32)>>,
    /// Contents of a queue.
    pub queue: Option<Queue>,
    /// For a queue or a supply: which part is offered to which place. 0 if none is, then one value
    /// for each entry of `offers`.
    pub end: Option<VarId>,
    /// For a conveyor without a machine: whether its first place is free again after the last
    /// arrival.
    pub open: Option<VarId>,
    /// Pairs of a type and the place it is offered to.
    pub offers: Vec<(usize, usize)>,
    /// For a supply with a limit: the number of parts of its type in the line, and the limit.
    pub in_line: Option<(VarId, u32)>,
    /// For a place at which parts take turns: two values of `takes`, and whether the first of them
    /// has waited longer than the second.
    pub earlier: Vec<(usize, usize, VarId)>,
    /// Pairs of a value of `takes` and the task whose bill is then joined.
    pub joins: Vec<(usize, usize)>,
}

/// Phase of a station.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// In work; a part of this type will leave.
    Work(usize),
    /// A part of this type (first) waits to go to that place (second).
    Done(usize, usize),
}

/// The parts of a queue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Queue {
    /// Parts of one type: their number, and the capacity.
    Count(VarId, u32),
    /// The contents of each slot, the first to leave in front: 0 if it is empty, then one value for
    /// each type, in this order.
    Slots(Vec<VarId>, Vec<usize>),
}

/// Variables of all places and of the environment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Vocabulary {
    /// All variables.
    pub variables: Vec<Variable>,
    /// Variables by place.
    pub places: Vec<Vars>,
    /// By place and type: which of several ways the next part will go, as an index into the ways of
    /// the type. One further value means that no more parts of the type will be sent from the
    /// place.
    pub decisions: BTreeMap<(usize, usize), VarId>,
}

impl Vocabulary {
    /// Creates the variables of the places.
    ///
    /// # Errors
    /// Returns the reason if there would be too many variables.
    pub fn of(line: &Line, shape: &Shape) -> Result<Self, UndecidedReason> {
        let mut new = Self {
            variables: Vec::new(),
            places: Vec::new(),
            decisions: BTreeMap::new(),
        };
        let mut slots = 0;
        for place in 0..shape.places.len() {
            let vars = new.place(line, shape, place)?;
            if let Some(Queue::Slots(own, _)) = &vars.queue {
                slots += own.len();
            }
            new.places.push(vars);
        }
        if slots > MAX_SLOTS {
            return Err(UndecidedReason::because(format!(
                "its queues have {slots} places for parts of different types, and at most {MAX_SLOTS} are distinguished"
            )));
        }
        for (place, declared) in shape.places.iter().enumerate() {
            for ways in declared.ways.iter().filter(|w| w.to.len() > 1) {
                let name = format!("{}.next_{}", declared.name, shape.types[ways.part]);
                let labels = ways.to.iter().map(|to| shape.places[*to].name.clone());
                let span = line.nodes[declared.node].span;
                let domain = labels_of(labels.chain(["no_more".to_owned()]).collect());
                let decision = new.add(name, domain, Owner::Environment, span);
                new.decisions.insert((place, ways.part), decision);
            }
        }
        Ok(new)
    }

    fn add(
        &mut self,
        name: String,
        domain: Domain,
        owner: Owner,
        span: linewright_core::source::Span,
    ) -> VarId {
        self.variables.push(Variable {
            name,
            owner,
            internal: false,
            domain,
            unit: String::new(),
            span,
        });
        VarId(self.variables.len() as u32 - 1)
    }

    fn place(&mut self, line: &Line, shape: &Shape, place: usize) -> Result<Vars, UndecidedReason> {
        let declared = &shape.places[place];
        let span = line.nodes[declared.node].span;
        let mut vars = Vars::default();
        let mut add = |what: &str, domain| {
            self.add(
                format!("{}.{what}", declared.name),
                domain,
                Owner::System,
                span,
            )
        };
        let named =
            |part: usize, to: usize| format!("{}_to_{}", shape.types[part], shape.places[to].name);
        let offers = || {
            let ways = declared.ways.iter();
            ways.flat_map(|w| w.to.iter().map(|to| (w.part, *to)))
        };
        let mut takers: Vec<String> = vec!["none".to_owned()];
        takers.extend(
            declared
                .from
                .iter()
                .map(|from| shape.places[*from].name.clone()),
        );
        match &declared.kind {
            PlaceKind::Supply { most, .. } => {
                if let Some(most) = most {
                    let domain = Domain::Range {
                        low: 0,
                        high: i64::from(*most),
                    };
                    vars.in_line = Some((add("in_line", domain), *most));
                }
            }
            PlaceKind::End { .. } => {}
            PlaceKind::Station { tasks } => {
                let mut labels = vec!["free".to_owned()];
                for ways in &declared.ways {
                    vars.phases.push(Phase::Work(ways.part));
                    labels.push(format!("work_{}", shape.types[ways.part]));
                }
                for (part, to) in offers() {
                    vars.phases.push(Phase::Done(part, to));
                    labels.push(format!("done_{}", named(part, to)));
                }
                vars.phase = Some(add("phase", labels_of(labels)));
                for (index, task) in tasks.iter().enumerate() {
                    let mut bill = Vec::new();
                    for (part, count) in &task.bill {
                        let name = format!("{}_for_{}", shape.types[*part], shape.types[task.part]);
                        let domain = Domain::Range {
                            low: 0,
                            high: i64::from(*count),
                        };
                        bill.push((add(&name, domain), *count));
                    }
                    if !task.bill.is_empty() && declared.ways.iter().any(|w| w.part == task.part) {
                        vars.joins.push((takers.len(), index));
                        takers.push(format!("join_{}", shape.types[task.part]));
                    }
                    vars.bills.push(bill);
                }
            }
            PlaceKind::Conveyor {
                places: capacity, ..
            }
            | PlaceKind::Room { capacity, .. } => {
                if matches!(declared.kind, PlaceKind::Conveyor { machine: false, .. }) {
                    vars.open = Some(add("open", Domain::Bool));
                }
                if *capacity > MAX_COUNTED {
                    return Err(UndecidedReason::because(format!(
                        "{} has room for {capacity} parts, and at most {MAX_COUNTED} are counted",
                        declared.name
                    )));
                }
                let types: Vec<usize> = declared.ways.iter().map(|w| w.part).collect();
                vars.queue = Some(if types.len() <= 1 {
                    let domain = Domain::Range {
                        low: 0,
                        high: i64::from(*capacity),
                    };
                    Queue::Count(add("holds", domain), *capacity)
                } else {
                    let mut labels = vec!["none".to_owned()];
                    labels.extend(types.iter().map(|t| shape.types[*t].clone()));
                    if *capacity as usize > MAX_SLOTS {
                        return Err(UndecidedReason::because(format!(
                            "{} has {capacity} places for parts of different types, and at most {MAX_SLOTS} are distinguished",
                            declared.name
                        )));
                    }
                    let slot = |i| add(&format!("slot{i}"), labels_of(labels.clone()));
                    Queue::Slots((0..*capacity).map(slot).collect(), types)
                });
            }
        }
        vars.offers = offers().collect();
        if vars.phase.is_none() && !vars.offers.is_empty() {
            let mut labels = vec!["none".to_owned()];
            labels.extend(vars.offers.iter().map(|(part, to)| named(*part, *to)));
            vars.end = Some(add("end", labels_of(labels)));
        }
        if takers.len() > 1 {
            let turns = !matches!(declared.kind, PlaceKind::End { .. });
            let waiting = takers.len() - 1;
            if turns && waiting > MAX_WAITING {
                return Err(UndecidedReason::because(format!(
                    "parts come to {} from {waiting} places, and the turns of at most {MAX_WAITING} are distinguished",
                    declared.name
                )));
            }
            let pairs = (1..takers.len()).flat_map(|a| (a + 1..takers.len()).map(move |b| (a, b)));
            let compete =
                |(a, b): (usize, usize)| turns && compete(shape, place, &vars.joins, a, b);
            // With four or more takers, an order of only some pairs could contain a cycle.
            let of_all = takers.len() > 4 && pairs.clone().any(compete);
            for (a, b) in pairs {
                {
                    if of_all || compete((a, b)) {
                        let earlier =
                            add(&format!("{}_before_{}", takers[a], takers[b]), Domain::Bool);
                        vars.earlier.push((a, b, earlier));
                    }
                }
            }
            vars.takes = Some(add("takes", labels_of(takers)));
        }
        Ok(vars)
    }
}

/// Whether two takers of a place, given as values of `takes`, can compete for the same room.
fn compete(shape: &Shape, place: usize, joins: &[(usize, usize)], a: usize, b: usize) -> bool {
    let declared = &shape.places[place];
    let PlaceKind::Station { tasks } = &declared.kind else {
        return true;
    };
    let bill = |taker: usize| joins.iter().any(|(value, _)| *value == taker);
    let types =
        |taker: usize| -> Vec<usize> { shape.between(declared.from[taker - 1], place).collect() };
    let plain = |part: &usize| tasks.iter().any(|t| t.plain && t.part == *part);
    let serves = |taker: usize| bill(taker) || types(taker).iter().any(plain);
    let alike = || !bill(a) && !bill(b) && types(a).iter().any(|t| types(b).contains(t));
    serves(a) && serves(b) || alike()
}

fn labels_of(labels: Vec<String>) -> Domain {
    Domain::Enum { name: None, labels }
}

/// Places together with their variables. The methods build expressions about the line.
#[derive(Debug, Clone, Copy)]
pub struct Model<'a> {
    /// The places.
    pub shape: &'a Shape,
    /// The variables of the places and of the environment.
    pub vocabulary: &'a Vocabulary,
}

impl<'a> Model<'a> {
    /// The variables of a place.
    pub fn vars(&self, place: usize) -> &'a Vars {
        &self.vocabulary.places[place]
    }

    /// A part of this type at `from` waits to go to `to`.
    pub fn offers(&self, from: usize, part: usize, to: usize) -> Expr {
        let vars = self.vars(from);
        if let Some(phase) = vars.phase {
            let done = vars.phases.iter().position(|p| *p == Phase::Done(part, to));
            return done.map_or(Expr::FALSE, |value| is(phase, value + 1));
        }
        let Some(value) = vars.offers.iter().position(|o| *o == (part, to)) else {
            return Expr::FALSE;
        };
        vars.end.map_or(Expr::FALSE, |end| is(end, value + 1))
    }

    /// A part of any type at `from` waits to go to `to`.
    pub fn offers_any(&self, from: usize, to: usize) -> Expr {
        let types = self.shape.between(from, to);
        any(types.map(|part| self.offers(from, part, to)))
    }

    /// `to` takes the part offered at `from` in this step.
    pub fn taken(&self, from: usize, to: usize) -> Expr {
        let place = self.shape.places[to].from.iter().position(|f| *f == from);
        match (self.vars(to).takes, place) {
            (Some(takes), Some(place)) => is(takes, place + 1),
            _ => Expr::FALSE,
        }
    }

    /// Some place takes the part offered at `from`.
    pub fn leaves(&self, from: usize) -> Expr {
        any(self
            .shape
            .after(from)
            .into_iter()
            .map(|to| self.taken(from, to)))
    }

    /// A part of this type comes to a place in this step.
    pub fn arrives(&self, place: usize, part: usize) -> Expr {
        let from = self.shape.places[place].from.iter();
        any(from.map(|from| {
            self.taken(*from, place)
                .and(self.offers(*from, part, place))
        }))
    }

    /// Any part comes to a place in this step.
    pub fn arrives_any(&self, place: usize) -> Expr {
        let from = self.shape.places[place].from.iter();
        any(from.map(|from| self.taken(*from, place)))
    }

    /// The first part of a queue is of this type.
    pub fn first_is(&self, place: usize, part: usize) -> Expr {
        match &self.vars(place).queue {
            Some(Queue::Count(count, _)) => is(*count, 0).not(),
            Some(Queue::Slots(slots, types)) => {
                let label = types.iter().position(|t| *t == part);
                label.map_or(Expr::FALSE, |label| is(slots[0], label + 1))
            }
            None => Expr::FALSE,
        }
    }

    /// A queue holds nothing.
    pub fn empty(&self, place: usize) -> Expr {
        match &self.vars(place).queue {
            Some(Queue::Count(count, _)) => is(*count, 0),
            Some(Queue::Slots(slots, _)) => is(slots[0], 0),
            None => Expr::TRUE,
        }
    }

    /// A component place for this type is free in this line of the task's bill, but in no earlier
    /// line.
    pub fn component_place(&self, place: usize, part: usize, task: usize, line: usize) -> Expr {
        let PlaceKind::Station { tasks } = &self.shape.places[place].kind else {
            return Expr::FALSE;
        };
        let vars = self.vars(place);
        let of = |t: usize, l: usize| {
            let (there, count) = vars.bills[t][l];
            is(there, count as usize).not()
        };
        let mut full = Vec::new();
        for (t, work) in tasks.iter().enumerate() {
            for (l, (component, _)) in work.bill.iter().enumerate() {
                if *component != part {
                    continue;
                }
                if (t, l) == (task, line) {
                    return all(full.into_iter().chain([of(t, l)]));
                }
                full.push(of(t, l).not());
            }
        }
        Expr::FALSE
    }

    /// A station has a free component place for this type.
    pub fn lacks(&self, place: usize, part: usize) -> Expr {
        let PlaceKind::Station { tasks } = &self.shape.places[place].kind else {
            return Expr::FALSE;
        };
        let vars = self.vars(place);
        let lines = tasks.iter().enumerate().flat_map(|(t, work)| {
            let of = work
                .bill
                .iter()
                .enumerate()
                .filter(|(_, (c, _))| *c == part);
            of.map(move |(l, _)| (t, l))
        });
        any(lines.map(|(t, l)| {
            let (there, count) = vars.bills[t][l];
            is(there, count as usize).not()
        }))
    }

    /// A place has room for a part of this type.
    pub fn room(&self, place: usize, part: usize) -> Expr {
        let vars = self.vars(place);
        match &self.shape.places[place].kind {
            PlaceKind::Supply { .. } => Expr::FALSE,
            PlaceKind::End { .. } => Expr::TRUE,
            PlaceKind::Station { tasks } => {
                let plain = tasks.iter().any(|t| t.plain && t.part == part);
                let free = if plain { self.free(place) } else { Expr::FALSE };
                self.lacks(place, part).or(free).simplify()
            }
            PlaceKind::Conveyor { .. } | PlaceKind::Room { .. } => {
                let room = match &vars.queue {
                    Some(Queue::Count(count, capacity)) => is(*count, *capacity as usize).not(),
                    Some(Queue::Slots(slots, _)) => {
                        slots.last().map_or(Expr::FALSE, |last| is(*last, 0))
                    }
                    None => Expr::FALSE,
                };
                all(vars.open.map(Expr::now).into_iter().chain([room]))
            }
        }
    }

    /// A station has no part in work and none that waits to leave.
    pub fn free(&self, place: usize) -> Expr {
        self.vars(place)
            .phase
            .map_or(Expr::FALSE, |phase| is(phase, 0))
    }

    /// All components for a task of a station are present.
    pub fn complete(&self, place: usize, task: usize) -> Expr {
        let bill = self.vars(place).bills[task].iter();
        all(bill.map(|(there, count)| is(*there, *count as usize)))
    }

    /// The part or bill that this value of `takes` denotes waits, and there is room for it.
    pub fn may_take(&self, place: usize, taker: usize) -> Expr {
        let vars = self.vars(place);
        if let Some((_, task)) = vars.joins.iter().find(|(value, _)| *value == taker) {
            return self.free(place).and(self.complete(place, *task));
        }
        let from = self.shape.places[place].from[taker - 1];
        let types = self.shape.between(from, place);
        any(types.map(|part| {
            self.offers(from, part, place)
                .and(self.room(place, part))
                .simplify()
        }))
    }

    /// Some waiting part could be taken.
    pub fn may_take_any(&self, place: usize) -> Expr {
        any(self.takers(place).map(|taker| self.may_take(place, taker)))
    }

    /// Some waiting part must eventually be taken if nothing changes.
    pub fn owes(&self, place: usize) -> Expr {
        let vars = self.vars(place);
        let waits = self.may_take_any(place);
        let (PlaceKind::Conveyor { places, sure, .. }, Some(end)) =
            (&self.shape.places[place].kind, vars.end)
        else {
            return waits;
        };
        if sure >= places {
            return waits;
        }
        let few = match &vars.queue {
            Some(Queue::Count(count, _)) => Expr::binary(
                BinaryOp::Lt,
                Expr::now(*count),
                Expr::Const(i64::from(*sure)),
            ),
            Some(Queue::Slots(slots, _)) => is(slots[*sure as usize - 1], 0),
            None => Expr::FALSE,
        };
        waits.and(is(end, 0).or(few))
    }

    /// The place offers no part, but could offer one.
    pub fn may_offer(&self, place: usize) -> Expr {
        let vars = self.vars(place);
        let Some(end) = vars.end else {
            return Expr::FALSE;
        };
        let there = match (&vars.queue, vars.in_line) {
            (Some(_), _) => self.empty(place).not(),
            (None, Some((in_line, most))) => Expr::binary(
                BinaryOp::Lt,
                Expr::now(in_line),
                Expr::Const(i64::from(most)),
            ),
            (None, None) => Expr::TRUE,
        };
        is(end, 0).and(there).simplify()
    }

    /// Whether the next event at a place takes time, instead of following at once from events
    /// elsewhere.
    pub fn takes_time(&self, place: usize) -> bool {
        match self.shape.places[place].kind {
            PlaceKind::Supply { always, .. } => !always,
            PlaceKind::Station { .. } | PlaceKind::Conveyor { .. } => true,
            PlaceKind::Room { dwells, .. } => dwells,
            PlaceKind::End { .. } => false,
        }
    }

    /// Nothing moves, and nothing could move before another event that takes time. What only belts
    /// with a machine could move does not count, because they move parts in their own steps.
    pub fn settled(&self) -> Expr {
        let belt = |place: usize| self.has_machine(place);
        let mut rules = Vec::new();
        for (place, declared) in self.shape.places.iter().enumerate() {
            if !self.takes_time(place) {
                rules.push(self.may_offer(place).not());
            }
            let Some(takes) = self.vars(place).takes else {
                continue;
            };
            rules.push(is(takes, 0));
            if !belt(place) && !declared.pauses {
                let by_belt =
                    |taker: &usize| declared.from.get(taker - 1).is_some_and(|from| belt(*from));
                let takers = self.takers(place).filter(|taker| !by_belt(taker));
                rules.extend(takers.map(|taker| self.may_take(place, taker).not()));
            }
        }
        for (place, declared) in self.shape.places.iter().enumerate() {
            for ways in declared.ways.iter().filter(|_| !belt(place)) {
                rules.extend(ways.open().map(|(to, exit)| {
                    let at_once = |to| self.takes_at_once(to);
                    self.waits_in_vain(place, ways.part, to, &exit.to, at_once)
                        .not()
                }));
            }
        }
        all(rules).simplify()
    }

    /// A part at `place` waits to go to `to`, which is full, while another place of the same exit
    /// has room for it. Only those other places count that `counts`.
    pub fn waits_in_vain(
        &self,
        place: usize,
        part: usize,
        to: usize,
        exit: &[usize],
        counts: impl Fn(usize) -> bool,
    ) -> Expr {
        let others = exit.iter().filter(|other| **other != to && counts(**other));
        let room = any(others.map(|other| self.room(*other, part)));
        let full = self.room(to, part).not();
        self.offers(place, part, to).and(full).and(room).simplify()
    }

    /// Whether a place takes a part at once whenever it has room for it.
    pub fn takes_at_once(&self, place: usize) -> bool {
        let declared = &self.shape.places[place];
        match &declared.kind {
            PlaceKind::Station { tasks } => {
                !declared.pauses && tasks.iter().all(|task| task.bill.is_empty())
            }
            PlaceKind::Conveyor { machine, .. } => !machine,
            PlaceKind::Room { .. } | PlaceKind::End { .. } => true,
            PlaceKind::Supply { .. } => false,
        }
    }

    /// Whether a place is a conveyor that a machine moves in its own steps.
    pub fn has_machine(&self, place: usize) -> bool {
        matches!(
            self.shape.places[place].kind,
            PlaceKind::Conveyor { machine: true, .. }
        )
    }

    /// The values of `takes` at a place, except 0 (none).
    pub fn takers(&self, place: usize) -> std::ops::RangeInclusive<usize> {
        1..=self.shape.places[place].from.len() + self.vars(place).joins.len()
    }
}
