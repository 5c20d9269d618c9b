//! The parts of a line and their values, from creation to exit.
//!
//! A vertex is a part type at a place with certain values. An edge is what happens to the part
//! next. If a vertex has several edges, either chance chooses ([`Choice::Chance`]), or the choice
//! is left open here ([`Choice::Open`]): it depends on the state of a station, on which part comes
//! first, or on what is joined with what.

use super::station::{Answer, Refusal, StationModel};
use super::unread::unread;
use super::{Bounds, Calls, Real, machine_of, ordered, plain};
use crate::undecided::UndecidedReason;
use linewright_language::contract::distribution::Distribution;
use linewright_language::contract::line::{
    Choice as RouteChoice, Defect, InitialValue, Line, NodeKind, Task,
};
use linewright_language::contract::machine::Machine;
use linewright_solver::game::Limits;
use linewright_station::interpret::Interpreter;
use std::collections::{BTreeMap, BTreeSet};

/// Stage of a part at a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Stage {
    /// The part arrives at the node.
    Comes,
    /// The part has been joined at the node and is about to be worked on.
    Joined,
    /// The station has finished work on the part; defects come next.
    Served,
    /// The part is about to leave the node.
    Leaves,
}

/// How the next edge is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choice {
    /// By chance, independent of the past.
    Chance,
    /// By something that is left open here.
    Open,
}

/// A part with certain values at a place.
#[derive(Debug)]
pub(super) struct Vertex {
    pub stage: Stage,
    pub node: usize,
    pub part: usize,
    pub values: Vec<Real>,
    /// The vertex from which this one was first reached; `None` where a part is made.
    pub before: Option<usize>,
    /// Possible next vertices.
    pub next: BTreeSet<usize>,
    pub choice: Choice,
    /// Index of the call that the part makes at its station, if any.
    pub call: Option<usize>,
    /// Whether the part is worked on at a station without a machine, and this work takes time with
    /// probability 1.
    pub takes_time: bool,
    /// Index of the route by which the part leaves, if any.
    pub route: Option<usize>,
}

/// A value outside the range of its property.
#[derive(Debug, Clone, Copy)]
pub(super) struct RangeViolation {
    /// The vertex of the part that receives the value.
    pub vertex: usize,
    /// Index of the property.
    pub property: usize,
    /// The value itself.
    pub value: f64,
    /// The defect that causes it; `None` if the station wrote it, or it came from a component.
    pub defect: Option<usize>,
}

/// All parts of a line with their values.
#[derive(Debug)]
pub(super) struct Walk<'a> {
    pub line: &'a Line,
    pub bounds: Bounds,
    pub vertices: Vec<Vertex>,
    known: BTreeMap<(Stage, usize, usize, Vec<Real>), usize>,
    open: Vec<usize>,
    /// By node: the model of its station; `None` if the node is no station or its controllers are
    /// unknown.
    pub stations: Vec<Option<StationModel>>,
    /// By node and call: the vertices that make the call.
    callers: BTreeMap<(usize, usize), Vec<usize>>,
    /// Vertices where parts are made.
    pub origins: Vec<usize>,
    /// Vertices at which a part has no way onward.
    pub stranded: Vec<usize>,
    /// Values outside their ranges.
    pub range_violations: Vec<RangeViolation>,
    /// Nodes that were not decided completely, with the reason.
    pub undecided: Vec<(usize, UndecidedReason)>,
    /// By part type and property: whether its values are omitted, since nothing depends on them.
    pub unread: Vec<Vec<bool>>,
    steps: u64,
}

impl<'a> Walk<'a> {
    pub fn new(
        line: &'a Line,
        interpreter: impl Fn(&Machine) -> Option<Interpreter>,
        bounds: &Bounds,
    ) -> Self {
        let mut undecided = Vec::new();
        let stations = (0..line.nodes.len()).map(|node| {
            let machine = machine_of(line, node)?;
            let known = interpreter(machine);
            if known.is_none() {
                let why = format!("there is no controller for `{}`", machine.name);
                undecided.push((node, UndecidedReason::because(why)));
            }
            known.map(StationModel::new)
        });
        let stations = stations.collect();
        Self {
            line,
            bounds: *bounds,
            vertices: Vec::new(),
            known: BTreeMap::new(),
            open: Vec::new(),
            stations,
            callers: BTreeMap::new(),
            origins: Vec::new(),
            stranded: Vec::new(),
            range_violations: Vec::new(),
            undecided,
            unread: unread(line),
            steps: 0,
        }
    }

    /// Whether everything was explored.
    pub fn is_complete(&self) -> bool {
        self.undecided.is_empty()
    }

    /// Explores everything that can be reached.
    pub fn explore(mut self, limits: &Limits) -> Self {
        self.begin();
        loop {
            while let Some(vertex) = self.open.pop() {
                self.follow(vertex);
                if let Err(limit) = limits.check_time() {
                    self.undecided
                        .push((self.vertices[vertex].node, limit.into()));
                    return self;
                }
            }
            if self.vertices.len() > self.bounds.values {
                let last = self.vertices.iter().rev();
                let at_station = |v: &&Vertex| self.stations[v.node].is_some();
                let node = last.clone().find(at_station).or(last.clone().next());
                self.give_up(node.map_or(0, |v| v.node), "parts can have");
                return self;
            }
            if !self.serve() {
                return self;
            }
            if let Some(node) = self.busiest().filter(|_| self.steps > self.bounds.steps) {
                let why = format!(
                    "exploring its calls takes more than {} steps",
                    self.bounds.steps
                );
                self.undecided.push((node, UndecidedReason::because(why)));
                return self;
            }
            if let Err(limit) = limits.check_time() {
                let node = self.busiest().unwrap_or(0);
                self.undecided.push((node, limit.into()));
                return self;
            }
        }
    }

    /// Records that there are too many combinations of values to follow. `what` begins the reason,
    /// such as `parts can have`.
    fn give_up(&mut self, node: usize, what: &str) {
        let most = self.bounds.values;
        let why = format!("{what} more than {most} combinations of values");
        let undecided = (node, UndecidedReason::because(why));
        if !self.undecided.contains(&undecided) {
            self.undecided.push(undecided);
        }
    }

    /// The station with the most states.
    fn busiest(&self) -> Option<usize> {
        let stations = self.stations.iter().enumerate();
        let states =
            stations.filter_map(|(node, station)| Some((station.as_ref()?.states(), node)));
        states.max().map(|(_, node)| node)
    }

    /// Adds the parts made by sources and those in stock.
    fn begin(&mut self) {
        for (node, declared) in self.line.nodes.iter().enumerate() {
            let made: Vec<usize> = match &declared.kind {
                NodeKind::Source { part, .. } => vec![*part],
                NodeKind::Store { stock } => {
                    let leaves = |part: &usize| self.has_routes(node, *part);
                    let parts = stock.iter().filter(|(_, count)| *count > 0);
                    parts.map(|(part, _)| *part).filter(leaves).collect()
                }
                _ => continue,
            };
            for part in made {
                let values = self.line.parts[part]
                    .properties
                    .iter()
                    .map(|p| match p.initial {
                        InitialValue::Number(value) => Real(value),
                        InitialValue::Component(..) => Real(0.0),
                    });
                let values = values.collect();
                let origin = self.reach(Stage::Leaves, node, part, values, None);
                self.origins.push(origin);
            }
        }
    }

    fn has_routes(&self, node: usize, part: usize) -> bool {
        let mut routes = self.line.routes.iter();
        routes.any(|r| r.from == node && r.part == part)
    }

    /// Returns the index of a vertex. A new vertex is added, to be explored later.
    fn reach(
        &mut self,
        stage: Stage,
        node: usize,
        part: usize,
        values: Vec<Real>,
        before: Option<usize>,
    ) -> usize {
        let values = values
            .into_iter()
            .zip(&self.unread[part])
            .map(|(value, left_out)| if *left_out { Real(0.0) } else { value });
        let key = (stage, node, part, values.collect());
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let index = self.vertices.len();
        self.vertices.push(Vertex {
            stage,
            node,
            part,
            values: key.3.clone(),
            before,
            next: BTreeSet::new(),
            choice: Choice::Open,
            call: None,
            takes_time: false,
            route: None,
        });
        self.known.insert(key, index);
        if self.vertices.len() <= self.bounds.values {
            self.open.push(index);
        }
        index
    }

    fn connect(&mut self, from: usize, stage: Stage, node: usize, part: usize, values: Vec<Real>) {
        let to = self.reach(stage, node, part, values, Some(from));
        self.vertices[from].next.insert(to);
    }

    fn follow(&mut self, at: usize) {
        let Vertex {
            stage, node, part, ..
        } = self.vertices[at];
        match stage {
            Stage::Leaves => self.leave(at),
            Stage::Served => self.defects(at),
            Stage::Joined => {
                let task = self.task(node, |task| task.part == part);
                if let Some(task) = task {
                    self.ask(at, task);
                }
            }
            Stage::Comes => match &self.line.nodes[node].kind {
                NodeKind::Source { .. } | NodeKind::Sink { .. } => {}
                NodeKind::Store { .. } if !self.has_routes(node, part) => {}
                NodeKind::Store { .. } | NodeKind::Buffer { .. } | NodeKind::Conveyor { .. } => {
                    let values = self.vertices[at].values.clone();
                    self.connect(at, Stage::Leaves, node, part, values);
                }
                NodeKind::Station(_) => self.come_to_station(at),
            },
        }
    }

    /// Lets a part leave by the first route whose condition holds, or by each route of a choice.
    fn leave(&mut self, at: usize) {
        let Vertex { node, part, .. } = self.vertices[at];
        let values = plain(&self.vertices[at].values);
        let Some(way) = self.line.way(node, part, &values) else {
            self.stranded.push(at);
            return;
        };
        self.vertices[at].route = Some(way.start);
        let choice = self.line.routes[way.start].choice;
        if choice.is_some_and(|c| matches!(self.line.choices[c], RouteChoice::Probability { .. })) {
            self.vertices[at].choice = Choice::Chance;
        }
        for route in &self.line.routes[way] {
            self.connect(at, Stage::Comes, route.to, part, ordered(&values));
        }
    }

    fn tasks(&self, node: usize) -> &'a [Task] {
        match &self.line.nodes[node].kind {
            NodeKind::Station(station) => &station.tasks,
            _ => &[],
        }
    }

    fn task(&self, node: usize, wanted: impl Fn(&Task) -> bool) -> Option<usize> {
        self.tasks(node).iter().position(wanted)
    }

    fn come_to_station(&mut self, at: usize) {
        let Vertex { node, part, .. } = self.vertices[at];
        // The same rules as in the runner (`plant/station/work.rs`).
        let comes = |kind: usize| {
            let mut routes = self.line.routes.iter();
            routes.any(|r| r.to == node && r.part == kind)
        };
        let bill = |task: &Task| &self.line.parts[task.part].bill;
        let all = self.tasks(node);
        let joins = |task: &Task| {
            !comes(task.part)
                || bill(task)
                    .iter()
                    .all(|(kind, _)| comes(*kind) && all.iter().all(|other| other.part != *kind))
        };
        let plain = self.task(node, |task| {
            task.part == part && (bill(task).is_empty() || comes(part))
        });
        let joining: Vec<usize> = all
            .iter()
            .enumerate()
            .filter(|(_, task)| joins(task) && bill(task).iter().any(|(kind, _)| *kind == part))
            .map(|(index, _)| index)
            .collect();
        if let Some(task) = plain {
            self.ask(at, task);
        }
        for task in joining {
            self.join(at, task);
        }
    }

    /// Handles the arrival of a component: adds every part that it can be joined into.
    fn join(&mut self, at: usize, task: usize) {
        let Vertex {
            node,
            part: component,
            ..
        } = self.vertices[at];
        let made = self.tasks(node)[task].part;
        let declared = &self.line.parts[made];
        // Only the first component of each type passes on its values, so one vertex per type is
        // chosen.
        let mut sites: Vec<(usize, Vec<usize>)> = Vec::new();
        for (kind, count) in &declared.bill {
            let there = self.vertices.iter().enumerate().filter(|(index, v)| {
                let is_own = *kind != component || *count > 1 || *index == at;
                v.stage == Stage::Comes && v.node == node && v.part == *kind && is_own
            });
            let there: Vec<usize> = there.map(|(index, _)| index).collect();
            if there.is_empty() {
                return;
            }
            sites.push((*kind, there));
        }
        let mut combinations: Vec<Vec<usize>> = vec![Vec::new()];
        for (_, there) in &sites {
            if combinations.len().saturating_mul(there.len()) > self.bounds.values {
                let kind = &declared.name;
                self.give_up(node, &format!("{kind} can be joined from"));
                return;
            }
            let longer = combinations.iter().flat_map(|chosen| {
                there.iter().map(move |one| {
                    let mut chosen = chosen.clone();
                    chosen.push(*one);
                    chosen
                })
            });
            combinations = longer.collect();
        }
        for chosen in combinations {
            let values = declared.properties.iter().map(|p| match p.initial {
                InitialValue::Number(value) => Real(value),
                InitialValue::Component(kind, number) => {
                    let place = sites.iter().position(|(k, _)| *k == kind);
                    place.map_or(Real(0.0), |p| self.vertices[chosen[p]].values[number])
                }
            });
            let values: Vec<Real> = values.collect();
            let joined = self.reach(Stage::Joined, node, made, values, Some(at));
            for from in chosen {
                self.vertices[from].next.insert(joined);
            }
            // If several components of its type are joined, the arriving one might not be the
            // chosen one.
            self.vertices[at].next.insert(joined);
        }
    }

    /// Lets a part call its station for a task.
    fn ask(&mut self, at: usize, task: usize) {
        let Vertex { node, part, .. } = self.vertices[at];
        let values = plain(&self.vertices[at].values);
        if let Some(property) = self.line.parts[part].first_out_of_range(&values) {
            self.range_violations.push(RangeViolation {
                vertex: at,
                property,
                value: values[property],
                defect: None,
            });
            return;
        }
        let Some(machine) = machine_of(self.line, node) else {
            // Without a machine, only the settings change the part.
            let work = &self.tasks(node)[task].time;
            self.vertices[at].takes_time = work.as_ref().is_some_and(Distribution::takes_time);
            self.finish_work(at, &ordered(&values));
            return;
        };
        let sources = machine
            .properties
            .iter()
            .zip(&self.tasks(node)[task].properties);
        let given: Vec<Real> = sources
            .map(|(p, source)| Real(source.map_or(p.default, |s| values[s])))
            .collect();
        let Some(station) = &mut self.stations[node] else {
            return;
        };
        let (call, _) = station.ask(task, given);
        self.vertices[at].call = Some(call);
        self.callers.entry((node, call)).or_default().push(at);
        let known: Vec<Answer> = station.calls[call]
            .answers
            .values()
            .filter_map(|a| a.as_ref().ok().cloned())
            .collect();
        for answer in known {
            self.served(at, &answer);
        }
    }

    /// Tries the open calls of all stations, until none is left or the bound on steps is exceeded.
    /// Returns whether there was a call to try.
    fn serve(&mut self) -> bool {
        let mut tried = false;
        for node in 0..self.stations.len() {
            let tasks = self.tasks(node);
            while let Some(station) = &mut self.stations[node] {
                let Some((state, call, steps)) = station.try_next(tasks) else {
                    break;
                };
                tried = true;
                self.steps += steps;
                if let Ok(answer) = station.calls[call].answers[&state].clone() {
                    let callers = self.callers.get(&(node, call));
                    for at in callers.cloned().unwrap_or_default() {
                        self.served(at, &answer);
                    }
                }
                if self.steps > self.bounds.steps {
                    return true;
                }
            }
        }
        tried
    }

    fn served(&mut self, at: usize, answer: &Answer) {
        let Vertex { node, call, .. } = self.vertices[at];
        let (Some(call), Some(station)) = (call, &self.stations[node]) else {
            return;
        };
        let task = &self.tasks(node)[station.calls[call].task];
        let mut values = self.vertices[at].values.clone();
        for (value, target) in answer.values.iter().zip(&task.properties) {
            if let Some(target) = target {
                values[*target] = *value;
            }
        }
        self.finish_work(at, &values);
    }

    /// Lets a part with these values have the values that its station sets.
    fn finish_work(&mut self, at: usize, values: &[Real]) {
        let Vertex { node, part, .. } = self.vertices[at];
        let NodeKind::Station(station) = &self.line.nodes[node].kind else {
            return;
        };
        let mut values = plain(values);
        station.set_values(part, &mut values);
        self.connect(at, Stage::Served, node, part, ordered(&values));
    }

    /// Applies the defects of a station to a part: each occurs or not, by chance.
    fn defects(&mut self, at: usize) {
        let Vertex { node, part, .. } = self.vertices[at];
        let NodeKind::Station(station) = &self.line.nodes[node].kind else {
            return;
        };
        let defects = &station.defects;
        let declared = &self.line.parts[part];
        let values = plain(&self.vertices[at].values);
        let mut outcomes: BTreeSet<Vec<Real>> = BTreeSet::from([ordered(&values)]);
        let mut wrong = Vec::new();
        if let Some(property) = declared.first_out_of_range(&values) {
            wrong.push((property, values[property], None));
            outcomes.clear();
        }
        // Between two defects, a value can be out of range. Only the values with which the part
        // leaves must be in range.
        for defect in defects.iter().filter(|d| d.part == part) {
            let mut then = BTreeSet::new();
            for values in &outcomes {
                then.extend(with_defect(defect, values));
                if then.len() > self.bounds.values {
                    self.give_up(node, "defects can lead to");
                    return;
                }
            }
            outcomes = then;
        }
        self.vertices[at].choice = Choice::Chance;
        for outcome in outcomes {
            let numbers = plain(&outcome);
            match declared.first_out_of_range(&numbers) {
                None => self.connect(at, Stage::Leaves, node, part, outcome),
                Some(property) => {
                    let by = defects
                        .iter()
                        .position(|d| d.part == part && d.properties.contains(&property));
                    wrong.push((property, numbers[property], by));
                }
            }
        }
        let wrong = wrong
            .into_iter()
            .map(|(property, value, defect)| RangeViolation {
                vertex: at,
                property,
                value,
                defect,
            });
        self.range_violations.extend(wrong);
    }

    /// Determines which routes are taken, and which are always taken.
    pub fn routes(&self, calls: &mut Calls) {
        let taken: BTreeSet<usize> = self.vertices.iter().filter_map(|v| v.route).collect();
        for (index, route) in self.line.routes.iter().enumerate() {
            let first = self.line.first_of_way(index);
            calls.taken[index] = taken.contains(&first);
            let later = |v: &Vertex| {
                v.stage == Stage::Leaves
                    && v.node == route.from
                    && v.part == route.part
                    && v.route.is_none_or(|taken| taken > first)
            };
            calls.always[index] = calls.taken[index] && !self.vertices.iter().any(later);
        }
    }

    /// The refused calls of a station: the call, the state in which it is refused, and the refusal.
    pub fn refusals(&self, node: usize) -> Vec<(usize, usize, &Refusal)> {
        let calls = self.stations[node]
            .iter()
            .flat_map(|d| &d.calls)
            .enumerate();
        let refused = calls.flat_map(|(call, c)| {
            let answers = c.answers.iter();
            answers.filter_map(move |(state, a)| Some((call, *state, a.as_ref().err()?)))
        });
        refused.collect()
    }

    /// Predecessors of each vertex.
    pub fn before(&self) -> Vec<Vec<usize>> {
        let mut before = vec![Vec::new(); self.vertices.len()];
        for (from, vertex) in self.vertices.iter().enumerate() {
            for to in &vertex.next {
                before[*to].push(from);
            }
        }
        before
    }

    /// The vertices that make a call.
    pub fn callers(&self, node: usize, call: usize) -> &[usize] {
        self.callers.get(&(node, call)).map_or(&[], Vec::as_slice)
    }
}

/// The combinations of values that a part can have after one defect.
fn with_defect(defect: &Defect, values: &[Real]) -> Vec<Vec<Real>> {
    let may_be_spared = defect.probability < 1.0 || defect.properties.is_empty();
    let mut outcomes = Vec::new();
    if may_be_spared {
        outcomes.push(values.to_vec());
    }
    if defect.probability > 0.0 {
        for property in &defect.properties {
            let mut known = plain(values);
            known.push(known[*property]);
            let mut values = values.to_vec();
            values[*property] = Real(defect.value.eval(&known, &[]));
            outcomes.push(values);
        }
    }
    outcomes
}
