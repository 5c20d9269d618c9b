//! Tapes: random calls on several instances of a unit, and the values that a host must read after
//! each step.
//!
//! A tape is text, one call per line, that every host can read:
//!
//! ```text
//! watch REFERENCE TYPE     print this variable after each step; the types are r, i, l, b and e new
//! N                    make instance N and initialize it; further calls apply to it use N set
//! REFERENCE TYPE VALUE a real number as its 64 bits in hexadecimal step TICKS               a
//! communication step of TICKS steps of the machine reset                    reset and initialize
//! again save S, load S           the state into place S, and back; `load` may be on another
//! instance bytes S                  the state in place S becomes bytes, and a new state made of
//! them takes its place
//! ```

use super::reference::{Answer, Read, Reference};
use crate::differential::Random;
use linewright::contract::machine::{Machine, PlantSource, PropertyKind};
use linewright::mealy;
use linewright::station::fmi::Unit;
use linewright::station::fmi::variables::{Causality, Kind, Start, Variable, group};
use std::fmt::Write as _;
use std::sync::Arc;

/// Number of instances at the same time.
pub const INSTANCES: usize = 4;
const PLACES: usize = 3;

/// A tape with the expected output of every step.
pub struct Tape {
    pub text: String,
    pub expected: Vec<(Answer, Vec<Read>)>,
    pub watched: Vec<Variable>,
    /// Number of operations compared with `simulate`.
    pub compared: usize,
    pub completed: usize,
    pub refused: usize,
}

/// A variable's type, as written on tapes.
pub fn letter(kind: Kind) -> char {
    match kind {
        Kind::Real => 'r',
        Kind::Integer => 'i',
        Kind::Long => 'l',
        Kind::Boolean => 'b',
        Kind::Enumeration(_) => 'e',
    }
}

struct Recorder<'a> {
    machine: &'a Machine,
    unit: &'a Unit,
    tape: Tape,
    random: Random,
    units: Vec<Reference>,
    saved: Vec<Option<Reference>>,
}

/// A tape of `sequences` sequences for a machine's unit, each with the given number of steps.
pub fn record(
    machine: &Arc<Machine>,
    controllers: &Arc<Vec<mealy::Controller>>,
    unit: &Unit,
    sequences: usize,
    steps: usize,
    seed: u64,
) -> Tape {
    let read = [Causality::Output, Causality::Local, Causality::Input];
    let watched: Vec<Variable> = unit
        .interface
        .variables
        .iter()
        .filter(|v| read.contains(&v.causality))
        .cloned()
        .collect();
    let mut text = String::new();
    for v in &watched {
        let _ = writeln!(text, "watch {} {}", v.reference, letter(v.kind));
    }
    let mut recorder = Recorder {
        machine,
        unit,
        tape: Tape {
            text,
            expected: Vec::new(),
            watched,
            compared: 0,
            completed: 0,
            refused: 0,
        },
        random: Random(seed),
        units: Vec::new(),
        saved: vec![None; PLACES],
    };
    let first = unit.interface.find("operation").and_then(|v| v.start);
    let first = match first {
        Some(Start::Whole(index)) => index as usize,
        _ => 0,
    };
    let fresh = Reference::new(machine, controllers, first);
    for sequence in 0..sequences {
        let instance = sequence % INSTANCES;
        if instance == recorder.units.len() {
            recorder.say(&format!("new {instance}"));
            recorder.units.push(fresh.clone());
        } else {
            recorder.say(&format!("use {instance}"));
            recorder.say("reset");
            recorder.units[instance] = fresh.clone();
        }
        recorder.sequence(instance, steps);
    }
    recorder.tape
}

impl Recorder<'_> {
    fn say(&mut self, line: &str) {
        self.tape.text.push_str(line);
        self.tape.text.push('\n');
    }

    /// A random walk on one instance; occasionally the others are stepped in between.
    fn sequence(&mut self, instance: usize, steps: usize) {
        for _ in 0..steps {
            let (busy, refused) = (
                self.units[instance].is_busy(),
                self.tape.expected.last().is_some_and(|e| e.0.status != 0),
            );
            if !busy || refused || self.random.below(20) == 0 {
                self.choose(instance, refused);
            }
            match self.random.below(40) {
                0 => self.step(instance, 0),
                1 => {
                    let place = self.random.below(PLACES as u64) as usize;
                    self.say(&format!("save {place}"));
                    self.saved[place] = Some(self.units[instance].clone());
                    if self.random.below(2) == 0 {
                        self.say(&format!("bytes {place}"));
                    }
                }
                2 => {
                    let place = self.random.below(PLACES as u64) as usize;
                    if let Some(saved) = self.saved[place].clone() {
                        self.say(&format!("load {place}"));
                        self.units[instance] = saved;
                    }
                }
                3 => {
                    let other = self.random.below(self.units.len() as u64) as usize;
                    self.say(&format!("use {other}"));
                    self.step(other, 1);
                    self.say(&format!("use {instance}"));
                }
                4..=7 => {
                    let ticks = 2 + self.random.below(9);
                    self.step(instance, ticks);
                }
                _ => self.step(instance, 1),
            }
        }
    }

    /// One communication step and its output. A step without ticks is refused.
    fn step(&mut self, instance: usize, ticks: u64) {
        self.say(&format!("step {ticks}"));
        let unit = &mut self.units[instance];
        let answer = if ticks == 0 {
            Answer {
                status: 3,
                message: None,
            }
        } else {
            let (compared, completed) = (unit.compared, self.tape.completed);
            let before = unit.clone();
            let answer = unit.step(ticks);
            self.tape.compared += unit.compared - compared;
            self.tape.completed = completed + usize::from(before.is_busy() && !unit.is_busy());
            self.tape.refused += usize::from(answer.status != 0);
            answer
        };
        let values = self.tape.watched.iter().map(|v| unit.read(v)).collect();
        self.tape.expected.push((answer, values));
    }

    /// Sets some inputs and parameters. After a refusal the signals are usually reset to their
    /// initial values.
    fn choose(&mut self, instance: usize, refused: bool) {
        let unit = self.unit;
        let calm = refused && self.random.below(4) != 0;
        for variable in &unit.interface.variables {
            let index = (variable.reference % 0x10_0000) as usize;
            let chance = if calm { 1 } else { 3 };
            if variable.start.is_none() || self.random.below(chance) != 0 {
                continue;
            }
            match variable.reference / 0x10_0000 {
                group::UNIT if variable.name == "enabled" => {
                    let on = calm || self.random.below(8) != 0;
                    self.units[instance].enabled = on;
                    self.set(variable, &i32::from(on).to_string());
                }
                group::UNIT => {
                    let operation = self.random.below(self.machine.operations.len() as u64);
                    self.units[instance].operation = operation as usize;
                    self.set(variable, &(operation + 1).to_string());
                }
                group::SIGNALS => {
                    let value = self.signal(index, calm);
                    self.units[instance].signals[index] = value;
                    let labels = matches!(variable.kind, Kind::Enumeration(_));
                    self.set(variable, &(value + i64::from(labels)).to_string());
                }
                _ => {
                    let value = self.property(index, calm);
                    self.units[instance].given[index] = value;
                    self.set(variable, &format!("{:016x}", value.to_bits()));
                }
            }
        }
    }

    fn set(&mut self, variable: &Variable, value: &str) {
        let line = format!(
            "set {} {} {value}",
            variable.reference,
            letter(variable.kind)
        );
        self.say(&line);
    }

    fn signal(&mut self, wire: usize, calm: bool) -> i64 {
        let input = &self.machine.plant[wire];
        match &input.source {
            PlantSource::Signal { script } if calm || self.random.below(3) != 0 => script[0],
            _ => input.domain.low() + self.random.below(input.domain.size()) as i64,
        }
    }

    /// A value of a property: from its domain, or else a round number near its default, and
    /// occasionally a fraction.
    fn property(&mut self, index: usize, calm: bool) -> f64 {
        let property = &self.machine.properties[index];
        let calm = calm || property.kind == PropertyKind::Part && self.random.below(2) == 0;
        match &property.domain {
            Some(domain) => (domain.low() + self.random.below(domain.size()) as i64) as f64,
            None if calm => property.default,
            None => {
                let whole = self.random.below(25) as f64 * 45.0 - 360.0;
                let fraction = if self.random.below(10) == 0 { 0.3 } else { 0.0 };
                whole + fraction
            }
        }
    }
}

/// Compares a host's output with the tape; returns a description of the difference.
pub fn compare(tape: &Tape, printed: &str, with_texts: bool) -> Result<(), String> {
    let mut lines = printed.lines().filter(|l| !l.trim().is_empty()).peekable();
    for (number, (answer, values)) in tape.expected.iter().enumerate() {
        let mut said = String::new();
        while let Some(text) = lines.peek().and_then(|l| l.strip_prefix("! ")) {
            text.clone_into(&mut said);
            lines.next();
        }
        let line = lines.next().unwrap_or("nothing");
        let mut words = line.split(' ');
        let status = words.next().unwrap_or_default();
        if status != format!("={}", answer.status) {
            return Err(format!(
                "step {number}: status {status} ({said}) instead of {answer:?}"
            ));
        }
        if let Some(message) = answer.message.as_ref().filter(|_| with_texts)
            && *message != said
        {
            return Err(format!("step {number}: `{said}` instead of `{message}`"));
        }
        for (variable, value) in tape.watched.iter().zip(values) {
            let wanted = match value {
                Read::Real(x) => format!("{:016x}", x.to_bits()),
                Read::Whole(i) => i.to_string(),
            };
            let word = words.next().unwrap_or("nothing");
            if word != wanted {
                return Err(format!(
                    "step {number}: {} is {word} instead of {wanted} ({value:?})",
                    variable.name
                ));
            }
        }
        if words.next().is_some() {
            return Err(format!("step {number}: more values than asked for"));
        }
    }
    match lines.next() {
        Some("HOST PASSED") => Ok(()),
        other => Err(format!("the host ended with {other:?}")),
    }
}
