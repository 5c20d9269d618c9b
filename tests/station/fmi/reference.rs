//! A reference unit: the interpreter, stepped as `ffi/fmi.c` defines.
//!
//! Costs of an operation are summed up here independently. If the signals were those of the
//! machine's own script throughout an operation, the sums, the properties and the machine's final
//! state are compared with those of `simulate`.

use super::hosts::communication_step;
use linewright::contract::machine::{ActionTime, Machine, PlantSource};
use linewright::gr1::eval;
use linewright::mealy;
use linewright::station::fmi::variables::{Kind, Variable, group};
use linewright::station::interpret::Interpreter;
use linewright::station::{CallError, Controller, ErrorCode, Service};
use std::sync::Arc;

/// Result of a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// 0 OK, 3 Error.
    pub status: i32,
    /// Message for the host; `None` if it is not known here (the step limit names what was waited
    /// for).
    pub message: Option<String>,
}

/// A value read by a host, in the host's own numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Read {
    Real(f64),
    Whole(i64),
}

/// An operation in progress.
#[derive(Clone)]
struct Job {
    operation: usize,
    held: Vec<f64>,
    plant: Vec<i64>,
    wires_at_start: Vec<i64>,
    running: Vec<bool>,
    service: Service,
    /// The machine at the start of the operation, as long as the signals follow the script.
    shadow: Option<Interpreter>,
}

/// A unit.
#[derive(Clone)]
pub struct Reference {
    machine: Arc<Machine>,
    interpreter: Interpreter,
    started: bool,
    wires: Vec<i64>,
    pub enabled: bool,
    pub operation: usize,
    pub signals: Vec<i64>,
    pub given: Vec<f64>,
    job: Option<Job>,
    total: Service,
    last: Service,
    completed: i64,
    verdict: i32,
    results: Vec<f64>,
    /// Number of operations compared with `simulate`.
    pub compared: usize,
}

impl Reference {
    /// A unit after its initialization, with the operation in its description.
    pub fn new(
        machine: &Arc<Machine>,
        controllers: &Arc<Vec<mealy::Controller>>,
        operation: usize,
    ) -> Self {
        let script = |source: &PlantSource| match source {
            PlantSource::Signal { script } => script[0],
            _ => 0,
        };
        let defaults: Vec<f64> = machine.properties.iter().map(|p| p.default).collect();
        Self {
            interpreter: Interpreter::new(Arc::clone(machine), Arc::clone(controllers)),
            started: false,
            wires: vec![0; machine.wire_count()],
            enabled: true,
            operation,
            signals: machine.plant.iter().map(|p| script(&p.source)).collect(),
            given: defaults.clone(),
            job: None,
            total: Service::default(),
            last: Service::default(),
            completed: 0,
            verdict: 0,
            results: defaults,
            compared: 0,
            machine: Arc::clone(machine),
        }
    }

    /// Whether an operation is in progress.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// A communication step of `ticks` machine steps: all or none.
    pub fn step(&mut self, ticks: u64) -> Answer {
        let mut after = self.clone();
        for _ in 0..ticks {
            if let Err(error) = after.tick() {
                self.verdict = error.code as i32;
                if error.code == ErrorCode::Limit {
                    self.interpreter.reset();
                    self.started = false;
                    self.wires.fill(0);
                    self.job = None;
                    return Answer {
                        status: 3,
                        message: None,
                    };
                }
                return Answer {
                    status: 3,
                    message: Some(error.message),
                };
            }
        }
        *self = after;
        Answer {
            status: 0,
            message: Some(String::new()),
        }
    }

    fn tick(&mut self) -> Result<(), CallError> {
        let machine = Arc::clone(&self.machine);
        let step = communication_step(&machine);
        if !self.enabled {
            self.total.seconds += step;
            self.total.joules += step * machine.idle_watts;
            return Ok(());
        }
        let has_operations = !machine.operations.is_empty();
        let mut job = match self.job.take() {
            Some(job) if has_operations => job,
            before => self.begin(before)?,
        };
        for (wire, input) in machine.plant.iter().enumerate() {
            if let PlantSource::Signal { script } = &input.source {
                job.plant[wire] = self.signals[wire];
                let scripted = script[(job.service.steps % script.len() as u64) as usize];
                if scripted != self.signals[wire] {
                    job.shadow = None;
                }
            }
        }
        let mut outputs = vec![0; machine.wire_count() - machine.plant.len()];
        self.interpreter.step(&job.plant, &mut outputs)?;
        self.started = true;
        self.wires.clone_from(&job.plant);
        self.wires.extend(outputs);
        self.charge(&mut job);
        if !has_operations {
            self.job = Some(job);
        } else if self.is_done() {
            self.finish(job);
        } else if job.service.steps >= machine.step_limit {
            return Err(CallError {
                code: ErrorCode::Limit,
                rule: None,
                message: String::new(),
            });
        } else {
            self.job = Some(job);
        }
        Ok(())
    }

    /// The property abstraction, and the start of an operation. A machine without operations keeps
    /// its sums.
    fn begin(&self, before: Option<Job>) -> Result<Job, CallError> {
        let machine = &*self.machine;
        let mut plant = vec![0; machine.plant.len()];
        for (wire, input) in machine.plant.iter().enumerate() {
            match &input.source {
                PlantSource::Operation => plant[wire] = machine.operations[self.operation].value,
                PlantSource::Signal { .. } => {}
                PlantSource::Property(expr) => {
                    let value = expr.eval(&self.given, &self.wires);
                    let near = value.round();
                    let fits = (value - near).abs() <= 1e-9
                        && near >= input.domain.low() as f64
                        && near <= input.domain.high() as f64;
                    if !fits {
                        // The message is that of `simulate`, which fails in the same way and
                        // changes nothing.
                        let mut shadow = self.interpreter.clone();
                        let answer = shadow.simulate(self.operation, &mut self.given.clone());
                        return Err(
                            answer.expect_err("the abstraction fails in `simulate` as well")
                        );
                    }
                    plant[wire] = near as i64;
                }
            }
        }
        let (running, service) = before.map_or_else(
            || (vec![false; machine.components.len()], Service::default()),
            |job| (job.running, job.service),
        );
        Ok(Job {
            operation: self.operation,
            held: self.given.clone(),
            plant,
            wires_at_start: self.wires.clone(),
            running,
            service,
            shadow: Some(self.interpreter.clone()),
        })
    }

    fn charge(&self, job: &mut Job) {
        let machine = &*self.machine;
        let mut watts = machine.base_watts;
        let mut longest: Option<f64> = None;
        job.service.steps += 1;
        for (c, component) in machine.components.iter().enumerate() {
            let active = component.active.as_ref();
            let active = active.is_some_and(|e| eval::eval(e, &self.wires, &[]) != 0);
            if active {
                watts += component.watts.eval(&job.held, &job.wires_at_start);
                let takes = match &component.time {
                    None => machine.step_seconds,
                    Some(ActionTime::PerExecution(_)) if job.running[c] => 0.0,
                    Some(ActionTime::PerStep(e) | ActionTime::PerExecution(e)) => {
                        e.eval(&job.held, &job.wires_at_start)
                    }
                };
                longest = Some(longest.unwrap_or(0.0).max(takes));
            }
            job.running[c] = active;
        }
        let seconds = longest.unwrap_or(machine.step_seconds);
        job.service.seconds += seconds;
        job.service.joules += seconds * watts;
    }

    fn finish(&mut self, job: Job) {
        let machine = Arc::clone(&self.machine);
        self.results.clone_from(&job.held);
        for (property, expr) in &machine.writes {
            self.results[*property] = expr.eval(&job.held, &self.wires);
        }
        if let Some(mut shadow) = job.shadow {
            let mut values = job.held.clone();
            let service = shadow
                .simulate(job.operation, &mut values)
                .expect("what was stepped to its end can be simulated");
            let bits = |s: &Service| (s.steps, s.seconds.to_bits(), s.joules.to_bits());
            assert_eq!(bits(&service), bits(&job.service), "{}", machine.name);
            let all = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(all(&values), all(&self.results), "{}", machine.name);
            assert_eq!(
                shadow.peek(&job.plant),
                self.interpreter.peek(&job.plant),
                "{}",
                machine.name
            );
            self.compared += 1;
        }
        self.total.seconds += job.service.seconds;
        self.total.joules += job.service.joules;
        self.total.steps += job.service.steps;
        self.last = job.service;
        self.completed += 1;
    }

    fn is_done(&self) -> bool {
        let done = self.machine.done.as_ref();
        self.started && done.is_some_and(|d| eval::eval(d, &self.wires, &[]) != 0)
    }

    /// The value that a host reads from a variable.
    pub fn read(&self, variable: &Variable) -> Read {
        let index = (variable.reference % 0x10_0000) as usize;
        let nothing = Service::default();
        let now = self.job.as_ref().map_or(&nothing, |j| &j.service);
        match variable.reference / 0x10_0000 {
            group::UNIT => match variable.name.as_str() {
                "enabled" => Read::Whole(self.enabled.into()),
                "total.seconds" => Read::Real(self.total.seconds + now.seconds),
                "total.joules" => Read::Real(self.total.joules + now.joules),
                "total.steps" => Read::Whole((self.total.steps + now.steps) as i64),
                "verdict" => Read::Whole(self.verdict.into()),
                "operation" => Read::Whole(self.operation as i64 + 1),
                "done" => Read::Whole(self.is_done().into()),
                "completed" => Read::Whole(self.completed),
                "last.seconds" => Read::Real(self.last.seconds),
                "last.joules" => Read::Real(self.last.joules),
                "last.steps" => Read::Whole(self.last.steps as i64),
                name => panic!("{name} is new"),
            },
            group::SIGNALS => Read::Whole(Self::shown(variable, self.signals[index])),
            group::GIVEN => Read::Real(self.given[index]),
            group::RESULTS => Read::Real(self.results[index]),
            group::WIRES => {
                let (low, high) = self.limits(index);
                let value = if self.started {
                    self.wires[index]
                } else {
                    0.clamp(low, high)
                };
                Read::Whole(Self::shown(variable, value))
            }
            _ => panic!("{} has no group", variable.name),
        }
    }

    /// Labels count from 1.
    fn shown(variable: &Variable, value: i64) -> i64 {
        value + i64::from(matches!(variable.kind, Kind::Enumeration(_)))
    }

    fn limits(&self, wire: usize) -> (i64, i64) {
        let machine = &*self.machine;
        if let Some(input) = machine.plant.get(wire) {
            return (input.domain.low(), input.domain.high());
        }
        let mut outputs = machine.components.iter().flat_map(|c| {
            let ids = c.specification.outputs();
            ids.map(|id| &c.specification.variable(id).domain)
        });
        let domain = outputs.nth(wire - machine.plant.len());
        domain.map_or((0, 0), |d| (d.low(), d.high()))
    }
}
