//! A recipe on a layout as a GR(1) specification.
//!
//! The machine chooses one *event* in each step: a transfer, an internal operation, or the
//! operations of a step of the recipe. The environment chooses the outcome of tests. The play is at
//! a *place* while the recipe is in one of its states, and in a *task* while a transition of the
//! recipe is carried out; the goal is to be at a place again and again. An end is a place that the
//! play never leaves. So loops of the recipe may be repeated for ever, but each transition takes
//! finitely many events.

use linewright_core::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright_core::source::Span;
use linewright_recipe::controller::{Move, Subject};
use linewright_recipe::realize::cell::{Call, Cell, Taken};

/// Maximum number of events of an encoding.
const MAX_EVENTS: usize = 20_000;

/// What happens in a step.
pub(super) struct Event {
    /// When it is possible, over current values and the next outcome.
    pub enabled: Expr,
    /// Variables that it changes, and their next values.
    pub changes: Vec<(VarId, Expr)>,
    /// What the resources do; empty where the recipe goes on without them.
    pub moves: Vec<Move>,
}

/// Where the parts of a resource are counted.
enum Contents {
    /// It has room for one: 0, or 1 more than its kind.
    One(VarId),
    /// The number of parts of each kind.
    Counts(Vec<VarId>),
}

/// A specification, and what its variables and values mean.
pub(super) struct Encoding<'c> {
    pub cell: &'c Cell,
    pub specification: Specification,
    /// The outcome of the tests: the number of the transition that leaves the state of the recipe.
    pub outcome: VarId,
    /// The event of a step.
    pub event: VarId,
    pub events: Vec<Event>,
    /// The values of all variables at the start.
    pub start: Vec<i64>,
    /// The task or place after a step.
    progress: VarId,
    states: Vec<VarId>,
    contents: Vec<Contents>,
    /// For each transition of the recipe, the number of its first task.
    first_task: Vec<i64>,
    first_place: i64,
}

fn is(variable: VarId, value: i64) -> Expr {
    Expr::now(variable).equals(Expr::Const(value))
}

fn all(exprs: impl IntoIterator<Item = Expr>) -> Expr {
    exprs.into_iter().reduce(Expr::and).unwrap_or(Expr::TRUE)
}

fn any(exprs: impl IntoIterator<Item = Expr>) -> Expr {
    exprs.into_iter().reduce(Expr::or).unwrap_or(Expr::FALSE)
}

fn formula(name: &str, expr: &Expr) -> Formula {
    Formula {
        name: name.to_owned(),
        requirement: None,
        expr: expr.simplify(),
        span: Span::default(),
        text: name.to_owned(),
        defines: false,
    }
}

/// Variables while they are collected.
#[derive(Default)]
struct Variables(Vec<Variable>);

impl Variables {
    fn add(&mut self, name: String, owner: Owner, high: i64) -> VarId {
        self.0.push(Variable {
            name,
            owner,
            internal: false,
            domain: Domain::Range { low: 0, high },
            unit: String::new(),
            span: Span::default(),
        });
        VarId(self.0.len() as u32 - 1)
    }
}

impl<'c> Encoding<'c> {
    /// Encodes a cell in which every resource may wait in every state, so that events can happen
    /// one at a time; `None` for one that may not, or with too many events.
    pub fn new(cell: &'c Cell) -> Option<Self> {
        if !cell.all_may_wait() {
            return None;
        }
        let mut variables = Variables::default();
        let most = cell.recipe_states.iter().map(|state| state.leaving.len());
        let most = most.max().unwrap_or(1).max(1) as i64;
        let outcome = variables.add("outcome".to_owned(), Owner::Environment, most - 1);
        let mut first_task = Vec::new();
        let mut tasks = 0;
        for work in &cell.works {
            first_task.push(tasks);
            tasks += work.steps.len() as i64 + 1;
        }
        let places = cell.recipe_states.len() as i64;
        let progress = variables.add("progress".to_owned(), Owner::System, tasks + places - 1);
        let states = (cell.states.iter().enumerate())
            .map(|(at, states)| {
                variables.add(
                    format!("state_{at}"),
                    Owner::System,
                    states.len() as i64 - 1,
                )
            })
            .collect();
        let kinds = cell.kinds.len();
        let contents = (cell.capacity.iter().enumerate())
            .map(|(at, capacity)| match capacity {
                0 | 1 => Contents::One(variables.add(
                    format!("part_{at}"),
                    Owner::System,
                    kinds as i64 * *capacity as i64,
                )),
                _ => Contents::Counts(
                    (0..kinds)
                        .map(|kind| {
                            let name = format!("parts_{at}_{kind}");
                            variables.add(name, Owner::System, *capacity as i64)
                        })
                        .collect(),
                ),
            })
            .collect();
        let mut encoding = Self {
            cell,
            specification: Specification {
                name: "recipe".to_owned(),
                timing: Timing::Mealy,
                variables: Vec::new(),
                assumptions: Side::default(),
                guarantees: Side::default(),
            },
            outcome,
            event: VarId(0),
            events: Vec::new(),
            start: Vec::new(),
            progress,
            states,
            contents,
            first_task,
            first_place: tasks,
        };
        encoding.add_recipe();
        encoding.add_transfers()?;
        encoding.add_operations()?;
        encoding.event = variables.add(
            "event".to_owned(),
            Owner::System,
            encoding.events.len() as i64 - 1,
        );
        encoding.specification.variables = variables.0;
        encoding.add_formulas();
        Some(encoding)
    }

    /// The number of the task in which some steps of a transition have been performed.
    fn task(&self, work: u16, steps: usize) -> i64 {
        self.first_task[work as usize] + steps as i64
    }

    /// The state of the recipe, if a state of the play is a place.
    pub fn place(&self, state: &[i64]) -> Option<usize> {
        usize::try_from(state[self.progress.index()] - self.first_place).ok()
    }

    fn place_of(&self, state: usize) -> i64 {
        self.first_place + state as i64
    }

    /// The states of the resources and their parts in a state of the play.
    pub fn configuration(&self, state: &[i64]) -> (Vec<usize>, Vec<Vec<String>>) {
        let value = |variable: VarId| state[variable.index()];
        let states = self.states.iter().map(|state| value(*state) as usize);
        let parts = self.contents.iter().map(|contents| {
            let mut parts: Vec<String> = match contents {
                Contents::One(part) => {
                    let kind = usize::try_from(value(*part) - 1).ok();
                    kind.map(|kind| self.cell.kinds[kind].clone())
                        .into_iter()
                        .collect()
                }
                Contents::Counts(counts) => counts
                    .iter()
                    .zip(&self.cell.kinds)
                    .flat_map(|(count, kind)| vec![kind.clone(); value(*count) as usize])
                    .collect(),
            };
            parts.sort_unstable();
            parts
        });
        (states.collect(), parts.collect())
    }

    /// At least `count` parts of a kind are at a resource.
    fn has(&self, resource: u16, kind: u16, count: usize) -> Expr {
        match &self.contents[resource as usize] {
            Contents::One(part) if count == 1 => is(*part, i64::from(kind) + 1),
            Contents::One(_) => Expr::FALSE,
            Contents::Counts(counts) => Expr::binary(
                BinaryOp::Ge,
                Expr::now(counts[kind as usize]),
                Expr::Const(count as i64),
            ),
        }
    }

    /// A part of a kind is anywhere in the cell.
    fn exists(&self, kind: u16) -> Expr {
        let resources = 0..self.cell.resources() as u16;
        any(resources.map(|resource| self.has(resource, kind, 1)))
    }

    /// A resource has room for `more` parts in addition to those that are there.
    fn has_room(&self, resource: u16, more: i64) -> Expr {
        let capacity = self.cell.capacity[resource as usize] as i64;
        match &self.contents[resource as usize] {
            _ if more <= 0 => Expr::TRUE,
            Contents::One(part) if more <= capacity => is(*part, 0),
            Contents::One(_) => Expr::FALSE,
            Contents::Counts(counts) => {
                let sum = counts.iter().map(|count| Expr::now(*count));
                let sum = sum.reduce(|a, b| Expr::binary(BinaryOp::Add, a, b));
                let sum = sum.unwrap_or(Expr::Const(0));
                Expr::binary(BinaryOp::Le, sum, Expr::Const(capacity - more))
            }
        }
    }

    /// The parts of these kinds are at a resource.
    fn holds(&self, resource: u16, kinds: &[u16]) -> Expr {
        let needed = |kind: u16| kinds.iter().filter(|other| **other == kind).count();
        let kinds = kinds.iter();
        all(kinds.map(|kind| self.has(resource, *kind, needed(*kind))))
    }

    /// Adds what changes if a resource loses and gains parts of these kinds.
    fn exchange(
        &self,
        resource: u16,
        lost: &[u16],
        gained: &[u16],
        changes: &mut Vec<(VarId, Expr)>,
    ) {
        match &self.contents[resource as usize] {
            Contents::One(part) => {
                if lost != gained {
                    let kind = gained.first().map_or(0, |kind| i64::from(*kind) + 1);
                    changes.push((*part, Expr::Const(kind)));
                }
            }
            Contents::Counts(counts) => {
                for (kind, count) in counts.iter().enumerate() {
                    let number = |of: &[u16]| of.iter().filter(|k| **k as usize == kind).count();
                    let more = number(gained) as i64 - number(lost) as i64;
                    if more != 0 {
                        let next =
                            Expr::binary(BinaryOp::Add, Expr::now(*count), Expr::Const(more));
                        changes.push((*count, next));
                    }
                }
            }
        }
    }

    /// The kinds that can stand for parts of the recipe, each with its condition: a part itself if
    /// there is one, or else stock of its type.
    fn resolutions(&self, parts: &[u16]) -> Vec<(Vec<u16>, Expr)> {
        let mut found = vec![(parts.to_vec(), Expr::TRUE)];
        let mut distinct: Vec<u16> = parts.to_vec();
        distinct.sort_unstable();
        distinct.dedup();
        for part in distinct {
            let Some(stock) = self.cell.stock[part as usize] else {
                continue;
            };
            let with_stock: Vec<(Vec<u16>, Expr)> = found
                .iter()
                .map(|(kinds, condition)| {
                    let replace = |kind: &u16| if *kind == part { stock } else { *kind };
                    let kinds = kinds.iter().map(replace).collect();
                    let none = self.exists(part).not();
                    (kinds, condition.clone().and(none))
                })
                .collect();
            found.extend(with_stock);
        }
        found
    }

    fn leaves(&self, taken: Taken, from: u16) -> Expr {
        is(self.states[taken.resource as usize], i64::from(from))
    }

    fn enters(&self, taken: Taken) -> (VarId, Expr) {
        let state = self.states[taken.resource as usize];
        (state, Expr::Const(i64::from(taken.to)))
    }

    /// Adds how the recipe goes on by itself: from a place to a task, and from the end of a task to
    /// a place. At an end nothing happens any more.
    fn add_recipe(&mut self) {
        let go = |from: Expr, to: i64| Event {
            enabled: from,
            changes: vec![(self.progress, Expr::Const(to))],
            moves: Vec::new(),
        };
        let mut events = Vec::new();
        for (state, about) in self.cell.recipe_states.iter().enumerate() {
            let here = is(self.progress, self.place_of(state));
            if about.is_end {
                events.push(go(here, self.place_of(state)));
                continue;
            }
            let outcomes = about.leaving.iter().enumerate();
            let chosen = outcomes.map(|(number, work)| {
                let tested = Expr::next(self.outcome).equals(Expr::Const(number as i64));
                go(here.clone().and(tested), self.task(*work, 0))
            });
            events.extend(chosen);
        }
        for (number, work) in self.cell.works.iter().enumerate() {
            let done = is(self.progress, self.task(number as u16, work.steps.len()));
            let state = work.to as usize;
            let may_be_there = self.may_be_at(state);
            events.push(go(done.and(may_be_there), self.place_of(state)));
        }
        self.events.extend(events);
    }

    /// Tests of a state of the recipe can be performed, and only parts that may remain are left at
    /// an end.
    fn may_be_at(&self, state: usize) -> Expr {
        let about = &self.cell.recipe_states[state];
        let tests = about.tests.iter().map(|(inputs, resources)| {
            let at = |resource: &u16| {
                let resolved = self.resolutions(inputs).into_iter();
                any(resolved.map(|(kinds, condition)| self.holds(*resource, &kinds).and(condition)))
            };
            any(resources.iter().map(at))
        });
        let tests = all(tests);
        if !about.is_end {
            return tests;
        }
        let kinds = 0..self.cell.kinds.len();
        let gone = kinds.filter(|kind| !self.cell.may_remain[*kind]);
        tests.and(all(gone.map(|kind| self.exists(kind as u16).not())))
    }

    /// The recipe is carried out, so that resources may move.
    fn in_task(&self) -> Expr {
        Expr::binary(
            BinaryOp::Lt,
            Expr::now(self.progress),
            Expr::Const(self.first_place),
        )
    }

    fn is_small(&self) -> Option<()> {
        (self.events.len() <= MAX_EVENTS).then_some(())
    }

    /// Adds internal operations, and transfers under each label.
    fn add_transfers(&mut self) -> Option<()> {
        let cell = self.cell;
        let mut takers: Vec<Vec<(u16, Taken)>> = vec![Vec::new(); cell.receivers.len()];
        for states in &cell.states {
            for (from, table) in states.iter().enumerate() {
                for (label, taken) in &table.takes {
                    takers[*label as usize].push((from as u16, *taken));
                }
            }
        }
        for states in &cell.states {
            for (from, table) in states.iter().enumerate() {
                for taken in &table.internal {
                    let enabled = self.in_task().and(self.leaves(*taken, from as u16));
                    let event = Event {
                        enabled,
                        changes: vec![self.enters(*taken)],
                        moves: vec![moved(*taken, Subject::Internal)],
                    };
                    self.events.push(event);
                }
                for (label, giver) in &table.gives {
                    for (ready, taker) in &takers[*label as usize] {
                        if taker.resource != giver.resource {
                            self.add_transfer(*giver, from as u16, *taker, *ready);
                        }
                    }
                    self.is_small()?;
                }
            }
        }
        Some(())
    }

    fn add_transfer(&mut self, giver: Taken, from: u16, taker: Taken, ready: u16) {
        let can = all([
            self.in_task(),
            self.leaves(giver, from),
            self.leaves(taker, ready),
            self.has_room(taker.resource, 1),
        ]);
        for kind in 0..self.cell.kinds.len() as u16 {
            let mut changes = vec![self.enters(giver), self.enters(taker)];
            self.exchange(giver.resource, &[kind], &[], &mut changes);
            self.exchange(taker.resource, &[], &[kind], &mut changes);
            let part = Subject::Part(self.cell.kinds[kind as usize].clone());
            self.events.push(Event {
                enabled: can.clone().and(self.has(giver.resource, kind, 1)),
                changes,
                moves: vec![moved(giver, part.clone()), moved(taker, part)],
            });
        }
    }

    /// Adds the operations of each step, for each choice of the resources that perform them.
    fn add_operations(&mut self) -> Option<()> {
        let cell = self.cell;
        for (number, work) in cell.works.iter().enumerate() {
            for (index, step) in work.steps.iter().enumerate() {
                let (now, then) = (
                    self.task(number as u16, index),
                    self.task(number as u16, index + 1),
                );
                let begun = Event {
                    enabled: is(self.progress, now),
                    changes: vec![(self.progress, Expr::Const(then))],
                    moves: Vec::new(),
                };
                let mut partial = vec![begun];
                for (call, operation) in step.iter().enumerate() {
                    partial = self.with_operation(partial, call, operation);
                    (partial.len() <= MAX_EVENTS).then_some(())?;
                }
                self.events.extend(partial);
                self.is_small()?;
            }
        }
        Some(())
    }

    /// Adds an operation to events that have the operations before it.
    fn with_operation(&self, partial: Vec<Event>, call: usize, operation: &Call) -> Vec<Event> {
        let more = operation.outputs.len() as i64 - operation.inputs.len() as i64;
        let resolved = self.resolutions(&operation.inputs);
        let mut found = Vec::new();
        for event in partial {
            for (from, taken) in &operation.performers {
                let resource = taken.resource;
                if event.moves.iter().any(|m| m.resource == resource as usize) {
                    continue;
                }
                for (kinds, condition) in &resolved {
                    let mut changes = event.changes.clone();
                    changes.push(self.enters(*taken));
                    self.exchange(resource, kinds, &operation.outputs, &mut changes);
                    let mut moves = event.moves.clone();
                    moves.push(moved(*taken, Subject::Operation(call)));
                    found.push(Event {
                        enabled: all([
                            event.enabled.clone(),
                            self.leaves(*taken, *from),
                            self.holds(resource, kinds),
                            condition.clone(),
                            self.has_room(resource, more),
                        ]),
                        changes,
                        moves,
                    });
                }
            }
        }
        found
    }

    fn add_formulas(&mut self) {
        let cell = self.cell;
        let mut guarantees = Side::default();
        let start = cell.start as usize;
        let (states, held) = cell.configuration.split_at(cell.resources());
        let mut values = vec![0; self.specification.variables.len()];
        values[self.progress.index()] = self.place_of(start);
        for (state, value) in self.states.iter().zip(states) {
            values[state.index()] = i64::from(*value);
        }
        for pair in held.chunks_exact(2) {
            match &self.contents[pair[0] as usize] {
                Contents::One(part) => values[part.index()] = i64::from(pair[1]) + 1,
                Contents::Counts(counts) => values[counts[pair[1] as usize].index()] += 1,
            }
        }
        let outputs = self.specification.outputs();
        let initial = all(outputs.map(|variable| is(variable, values[variable.index()])));
        let initial = initial.and(self.may_be_at(start));
        guarantees.initial.push(formula("starts", &initial));
        self.start = values;
        for (number, event) in self.events.iter().enumerate() {
            let happens = Expr::next(self.event).equals(Expr::Const(number as i64));
            let rule = happens.implies(event.enabled.clone());
            guarantees.safety.push(formula("is_possible", &rule));
        }
        let configuration = self.states.iter().copied();
        let configuration =
            configuration.chain(self.contents.iter().flat_map(|contents| match contents {
                Contents::One(part) => vec![*part],
                Contents::Counts(counts) => counts.clone(),
            }));
        for variable in configuration.chain([self.progress]) {
            let mut next = Expr::Var(variable, Time::Now);
            for (number, event) in self.events.iter().enumerate() {
                let change = event.changes.iter().find(|(of, _)| *of == variable);
                if let Some((_, value)) = change {
                    let happens = Expr::next(self.event).equals(Expr::Const(number as i64));
                    next = Expr::If(Box::new(happens), Box::new(value.clone()), Box::new(next));
                }
            }
            let rule = Expr::next(variable).equals(next);
            guarantees.safety.push(formula("follows", &rule));
        }
        let at_place = self.in_task().not();
        guarantees.justice.push(formula("goes_on", &at_place));
        self.specification.guarantees = guarantees;
        let mut possible = Vec::new();
        for (state, about) in cell.recipe_states.iter().enumerate() {
            if about.leaving.is_empty() {
                continue;
            }
            let here = is(self.progress, self.place_of(state));
            let last = about.leaving.len() as i64 - 1;
            let there_is = Expr::binary(BinaryOp::Le, Expr::next(self.outcome), Expr::Const(last));
            possible.push(here.implies(there_is));
        }
        let assumptions = &mut self.specification.assumptions.safety;
        assumptions.push(formula("is_an_outcome", &all(possible)));
    }
}

fn moved(taken: Taken, subject: Subject) -> Move {
    Move {
        resource: taken.resource as usize,
        transition: taken.transition as usize,
        subject,
    }
}
