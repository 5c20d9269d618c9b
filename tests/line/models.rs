//! Handmade lines, and controllers with the answers that a test needs.

use linewright::contract::calendar::WorkCalendar;
use linewright::contract::distribution::Distribution;
use linewright::contract::line::{
    Belt, BufferOrder, Choice, InitialValue, Limit, Line, Node, NodeKind, PartProperty, PartType,
    Requirement, Route, Station, Supply, Task,
};
use linewright::contract::load;
use linewright::contract::machine::{
    Between, Component, FailureMode, InterruptedWork, Machine, Operation, PlantInput, PlantSource,
    Property, PropertyKind, RealExpr, Role,
};
use linewright::gr1::{Domain, Owner, Side, Specification, Timing, Variable};
use linewright::line::log::{EventKind, Log, LogEntry};
use linewright::line::random::{Purpose, Stream};
use linewright::line::{Options, Plant, Trace};
use linewright::source::Span;
use linewright::station::{CallError, Controller, ErrorCode, Service};
use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::Arc;

/// A line under construction, with its controllers.
pub struct Builder {
    pub line: Line,
    pub controllers: BTreeMap<usize, Box<dyn Controller>>,
}

pub fn span() -> Span {
    Span::default()
}

impl Builder {
    /// A line of these part types, each without properties; the last one is the product.
    pub fn new(parts: &[&str]) -> Self {
        let parts: Vec<_> = parts
            .iter()
            .map(|name| PartType {
                name: (*name).to_owned(),
                properties: Vec::new(),
                bill: Vec::new(),
                span: span(),
            })
            .collect();
        Self {
            line: Line {
                name: "test".to_owned(),
                doc: String::new(),
                products: vec![parts.len() - 1],
                parts,
                nodes: Vec::new(),
                routes: Vec::new(),
                choices: Vec::new(),
                requirements: Vec::new(),
                limit: None,
                calendar: None,
                first_day: None,
                span: span(),
            },
            controllers: BTreeMap::new(),
        }
    }

    pub fn part(&self, name: &str) -> usize {
        self.line.parts.iter().position(|p| p.name == name).unwrap()
    }

    pub fn node(&self, name: &str) -> usize {
        self.line.nodes.iter().position(|n| n.name == name).unwrap()
    }

    pub fn property(&mut self, part: &str, name: &str, initial: InitialValue) -> &mut Self {
        let part = self.part(part);
        self.line.parts[part].properties.push(PartProperty {
            domain: None,
            name: name.to_owned(),
            unit: String::new(),
            initial,
        });
        self
    }

    pub fn bill(&mut self, part: &str, bill: &[(&str, u32)]) -> &mut Self {
        let bill = bill.iter().map(|(p, n)| (self.part(p), *n)).collect();
        let part = self.part(part);
        self.line.parts[part].bill = bill;
        self
    }

    fn add(&mut self, name: &str, kind: NodeKind) -> usize {
        self.line.nodes.push(Node {
            name: name.to_owned(),
            kind,
            span: span(),
        });
        self.line.nodes.len() - 1
    }

    pub fn source(&mut self, name: &str, part: &str, supply: Supply) -> &mut Self {
        let part = self.part(part);
        self.add(
            name,
            NodeKind::Source {
                part,
                supply,
                most: None,
            },
        );
        self
    }

    /// A source that always has a part.
    pub fn endless(&mut self, name: &str, part: &str) -> &mut Self {
        self.source(name, part, every(0.0, None))
    }

    pub fn sink(&mut self, name: &str) -> &mut Self {
        self.add(
            name,
            NodeKind::Sink {
                reject: false,
                reorder: None,
            },
        );
        self
    }

    pub fn scrap(&mut self, name: &str, reorder: Option<&str>) -> &mut Self {
        let reorder = reorder.map(|source| self.node(source));
        self.add(
            name,
            NodeKind::Sink {
                reject: true,
                reorder,
            },
        );
        self
    }

    pub fn store(&mut self, name: &str, stock: &[(&str, u64)]) -> &mut Self {
        let stock = stock.iter().map(|(p, n)| (self.part(p), *n)).collect();
        self.add(name, NodeKind::Store { stock });
        self
    }

    pub fn buffer(&mut self, name: &str, capacity: u32) -> &mut Self {
        self.add(
            name,
            NodeKind::Buffer {
                capacity,
                order: BufferOrder::FirstIn,
                dwell: Distribution::default(),
                shelf_life: None,
            },
        );
        self
    }

    /// An accumulating conveyor with a period in seconds per place.
    pub fn conveyor(&mut self, name: &str, places: u32, period: f64) -> &mut Self {
        self.add(
            name,
            NodeKind::Conveyor {
                places,
                pitch: period,
                speed: 1.0,
                belt: None,
                watts: 100.0,
            },
        );
        self
    }

    /// A conveyor moved by a controller, with a period of one second.
    pub fn belt(
        &mut self,
        name: &str,
        places: u32,
        controller: impl Controller + 'static,
    ) -> &mut Self {
        let machine = Arc::new(belt_machine(places));
        let node = self.add(
            name,
            NodeKind::Conveyor {
                places,
                pitch: 0.5,
                speed: 0.5,
                belt: Some(Belt {
                    machine,
                    load: 0,
                    unload_ready: 1,
                    places: (2..2 + places as usize).collect(),
                    ready: 2 + places as usize,
                }),
                watts: 100.0,
            },
        );
        self.controllers.insert(node, Box::new(controller));
        self
    }

    /// A station that works on these part types, with one operation each.
    pub fn station(
        &mut self,
        name: &str,
        parts: &[&str],
        controller: impl Controller + 'static,
    ) -> &mut Self {
        let machine = Arc::new(machine(&format!("{name}_machine"), &[]));
        let tasks = parts.iter().map(|part| self.task(part, &[])).collect();
        let node = self.add(
            name,
            NodeKind::Station(Box::new(Station {
                machine: Some(machine),
                tasks,
                ..Station::default()
            })),
        );
        self.controllers.insert(node, Box::new(controller));
        self
    }

    /// A task of one operation whose machine has these properties of the part.
    pub fn task(&self, part: &str, properties: &[Option<usize>]) -> Task {
        Task {
            part: self.part(part),
            operations: vec![(0, Vec::new())],
            properties: properties.to_vec(),
            time: None,
            span: span(),
        }
    }

    /// Changes a station's declaration.
    pub fn with_station(&mut self, name: &str, change: impl FnOnce(&mut Station)) -> &mut Self {
        let node = self.node(name);
        if let NodeKind::Station(station) = &mut self.line.nodes[node].kind {
            change(station);
        }
        self
    }

    /// Gives a station's machine properties of the part, each read and written by every task.
    pub fn machine_properties(&mut self, name: &str, properties: &[&str]) -> &mut Self {
        self.with_station(name, |station| {
            let name = station.machine.as_ref().map_or("", |machine| &machine.name);
            station.machine = Some(Arc::new(machine(name, properties)));
            for task in &mut station.tasks {
                task.properties = (0..properties.len()).map(Some).collect();
            }
        })
    }

    pub fn machine_watts(&mut self, name: &str, idle_watts: f64) -> &mut Self {
        self.with_station(name, |station| station.idle_watts = idle_watts)
    }

    /// Routes of one part type along these nodes.
    pub fn route(&mut self, part: &str, nodes: &[&str]) -> &mut Self {
        for pair in nodes.windows(2) {
            self.route_if(part, pair[0], pair[1], None);
        }
        self
    }

    pub fn route_if(
        &mut self,
        part: &str,
        from: &str,
        to: &str,
        condition: Option<RealExpr>,
    ) -> &mut Self {
        let route = Route {
            part: self.part(part),
            from: self.node(from),
            to: self.node(to),
            condition,
            condition_span: None,
            choice: None,
            span: span(),
        };
        self.line.routes.push(route);
        self
    }

    /// Routes of one part type from a node to several, of which each part takes one.
    pub fn route_choice(
        &mut self,
        part: &str,
        from: &str,
        to: &[&str],
        choice: Choice,
    ) -> &mut Self {
        let index = self.line.choices.len();
        self.line.choices.push(choice);
        for to in to {
            self.route_if(part, from, to, None);
            self.line.routes.last_mut().unwrap().choice = Some(index);
        }
        self
    }

    pub fn shift(&mut self, from: f64, to: f64) -> &mut Self {
        self.line.calendar = Some(WorkCalendar::daily(from, to));
        self
    }

    pub fn limit(&mut self, limit: Limit) -> &mut Self {
        self.line.limit = Some(limit);
        self
    }

    pub fn require(&mut self, requirement: Requirement) -> &mut Self {
        self.line.requirements.push(requirement);
        self
    }

    pub fn plant(&mut self, options: Options) -> Plant {
        Plant::new(
            Arc::new(self.line.clone()),
            std::mem::take(&mut self.controllers),
            options,
        )
        .unwrap_or_else(|findings| panic!("{findings:#?}"))
    }

    /// Runs until this many products are made, with a log.
    pub fn run(&mut self, parts: u64) -> Logged {
        self.plant(Options {
            parts: Some(parts),
            ..Options::default()
        })
        .run_logged()
    }

    /// Runs for this many seconds, with a log.
    pub fn run_until(&mut self, seconds: f64) -> Logged {
        self.plant(Options {
            until: Some(seconds),
            ..Options::default()
        })
        .run_logged()
    }
}

/// A trace with the events of its run.
#[derive(Debug)]
pub struct Logged {
    pub trace: Trace,
    pub log: Vec<LogEntry>,
}

impl Deref for Logged {
    type Target = Trace;

    fn deref(&self) -> &Trace {
        &self.trace
    }
}

impl Logged {
    /// The events of parts, and failures.
    pub fn movements(&self) -> impl Iterator<Item = &LogEntry> {
        self.log.iter().filter(|entry| {
            !matches!(
                entry.what,
                EventKind::Made
                    | EventKind::Aborted
                    | EventKind::Changed
                    | EventKind::Defect
                    | EventKind::Reordered(_)
                    | EventKind::State(_)
                    | EventKind::Moved
            )
        })
    }
}

pub trait RunLogged {
    /// Runs the line, and keeps its events.
    fn run_logged(&mut self) -> Logged;

    /// Runs the line with this seed, and keeps its events.
    fn run_logged_seeded(&mut self, seed: u64) -> Logged;
}

impl RunLogged for Plant {
    fn run_logged(&mut self) -> Logged {
        self.run_logged_seeded(self.seed())
    }

    fn run_logged_seeded(&mut self, seed: u64) -> Logged {
        let mut log = Log::default();
        let trace = self.run_observed(seed, Some(&mut log));
        Logged {
            trace,
            log: log.entries,
        }
    }
}

pub fn every(seconds: f64, limit: Option<u64>) -> Supply {
    Supply::Every {
        interval: Distribution::Constant(seconds),
        limit,
    }
}

/// One part at each of these instants.
pub fn at(instants: &[f64]) -> Supply {
    Supply::At {
        instants: instants.into(),
    }
}

/// A Poisson process with this mean time between parts.
pub fn at_random(mean: f64, limit: Option<u64>) -> Supply {
    Supply::Every {
        interval: Distribution::Exponential { mean },
        limit,
    }
}

/// Exponentially distributed failures and repairs with these means.
pub fn failing(mtbf: f64, mttr: f64) -> Vec<FailureMode> {
    vec![FailureMode {
        name: String::new(),
        between: Between::Working(Distribution::Exponential { mean: mtbf }),
        repair: Distribution::Exponential { mean: mttr },
        interrupted: InterruptedWork::Resumes,
    }]
}

/// The plant of a line that is given as text, whose stations have no machines.
pub fn plant_of(text: &str, options: Options) -> Plant {
    let files = [("line.lw".to_owned(), text.to_owned())];
    let (mut library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
    assert!(findings.is_empty(), "{text}: {findings:?}");
    let line = Arc::new(library.lines.remove(0));
    Plant::new(line, BTreeMap::new(), options).unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

/// A machine of one operation, without components.
fn machine(name: &str, properties: &[&str]) -> Machine {
    Machine {
        name: name.to_owned(),
        doc: String::new(),
        codes: Vec::new(),
        components: Vec::new(),
        plant: Vec::new(),
        properties: properties
            .iter()
            .map(|name| Property {
                domain: None,
                name: (*name).to_owned(),
                unit: String::new(),
                default: 0.0,
                kind: PropertyKind::Part,
                span: span(),
            })
            .collect(),
        operations: vec![Operation {
            name: "work".to_owned(),
            codes: Vec::new(),
            sequence: Vec::new(),
            value: 1,
            span: span(),
        }],
        writes: Vec::new(),
        done: None,
        step_seconds: 1.0,
        base_watts: 0.0,
        idle_watts: 0.0,
        step_limit: 1000,
        failures: Vec::new(),
        refines: Vec::new(),
        orders: Vec::new(),
        guarantees: linewright::contract::machine::Rules::default(),
        layers: linewright::contract::machine::Layers::default(),
        span: span(),
    }
}

/// Plant wires `load` and `unload_ready`, component wires `s[0]`, ..., `ready`.
fn belt_machine(places: u32) -> Machine {
    let plant = ["load", "unload_ready"].map(|name| PlantInput {
        name: name.to_owned(),
        unit: String::new(),
        domain: Domain::Bool,
        source: PlantSource::Signal { script: vec![0] },
        span: span(),
    });
    let variables = (0..places)
        .map(|i| format!("s[{i}]"))
        .chain(["ready".to_owned()])
        .map(|name| Variable {
            name,
            domain: Domain::Bool,
            owner: Owner::System,
            internal: false,
            unit: String::new(),
            span: span(),
        })
        .collect();
    Machine {
        plant: plant.into(),
        operations: Vec::new(),
        components: vec![Component {
            name: "belt".to_owned(),
            contract: "Conveyor".to_owned(),
            role: Role::Action,
            specification: Arc::new(Specification {
                name: "Conveyor".to_owned(),
                timing: Timing::Moore,
                variables,
                assumptions: Side::default(),
                guarantees: Side::default(),
            }),
            bindings: Vec::new(),
            active: None,
            time: None,
            watts: RealExpr::Number(0.0),
            span: span(),
        }],
        ..machine("belt_machine", &[])
    }
}

/// A controller that only answers operations, by a function of the call's number and the values.
pub struct Work<F>(pub F, pub u64);

impl<F: FnMut(u64, &mut [f64]) -> Result<Service, CallError>> Controller for Work<F> {
    fn simulate(&mut self, _: usize, values: &mut [f64]) -> Result<Service, CallError> {
        self.1 += 1;
        (self.0)(self.1, values)
    }

    fn step(&mut self, _: &[i64], _: &mut [i64]) -> Result<(), CallError> {
        Ok(())
    }

    fn reset(&mut self) {
        self.1 = 0;
    }
}

#[expect(clippy::unnecessary_wraps, reason = "what a controller answers")]
pub fn took(seconds: f64) -> Result<Service, CallError> {
    Ok(Service {
        seconds,
        joules: 10.0 * seconds,
        steps: 1,
        control_seconds: 0.0,
    })
}

/// Every service takes this many seconds, at 10 W.
pub fn constant(seconds: f64) -> impl Controller {
    Work(move |_, _: &mut [f64]| took(seconds), 0)
}

/// Every service sets the first value to a function of the call's number.
pub fn verdict(seconds: f64, outcome: impl Fn(u64) -> f64) -> impl Controller {
    Work(
        move |call, values: &mut [f64]| {
            values[0] = outcome(call);
            took(seconds)
        },
        0,
    )
}

/// The calls for which `refused` holds violate an assumption.
pub fn refusing(seconds: f64, refused: impl Fn(u64) -> bool) -> impl Controller {
    Work(
        move |call, _: &mut [f64]| {
            if refused(call) {
                Err(CallError {
                    code: ErrorCode::Assumption,
                    rule: Some("turn: gripped".to_owned()),
                    message: "turn: the assumption gripped does not hold in step 3".to_owned(),
                })
            } else {
                took(seconds)
            }
        },
        0,
    )
}

/// Exponential service times of mean 1, from their own stream; a reset does not rewind it.
pub struct Exponential(pub Stream);

impl Exponential {
    pub fn new(name: &str) -> Self {
        Self(Stream::new(99, Purpose::Sample, name))
    }
}

impl Controller for Exponential {
    fn simulate(&mut self, _: usize, _: &mut [f64]) -> Result<Service, CallError> {
        took(self.0.exponential(1.0))
    }

    fn step(&mut self, _: &[i64], _: &mut [i64]) -> Result<(), CallError> {
        Ok(())
    }

    fn reset(&mut self) {}
}

/// A belt that keeps its contract: parts close up toward the end, none is lost.
pub struct Shift1 {
    places: Vec<bool>,
    /// Loses its last part in this step.
    pub loses_at: Option<u64>,
    steps: u64,
}

impl Shift1 {
    pub fn new(places: usize) -> Self {
        Self {
            places: vec![false; places],
            loses_at: None,
            steps: 0,
        }
    }
}

impl Controller for Shift1 {
    fn simulate(&mut self, _: usize, _: &mut [f64]) -> Result<Service, CallError> {
        unreachable!("a belt has no operations")
    }

    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
        let (load, unload_ready) = (plant[0] != 0, plant[1] != 0);
        let count = self.places.len();
        for (output, place) in outputs.iter_mut().zip(&self.places) {
            *output = i64::from(*place);
        }
        let ready = !self.places[0];
        outputs[count] = i64::from(ready);
        if unload_ready {
            self.places[count - 1] = false;
        }
        for i in (1..count).rev() {
            if !self.places[i] && self.places[i - 1] {
                self.places.swap(i, i - 1);
            }
        }
        if load && ready {
            // Place 0 is free: it was before, and what was there cannot have come back.
            self.places[0] = true;
        }
        self.steps += 1;
        if Some(self.steps) == self.loses_at {
            self.places.fill(false);
        }
        Ok(())
    }

    fn reset(&mut self) {
        self.places.fill(false);
        self.steps = 0;
    }
}
