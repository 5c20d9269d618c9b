//! A controller and its function block, played side by side on random steps.
//!
//! Inputs stay near the last accepted ones, so that most keep the assumptions; some are outside
//! their domains. A step must have the same outputs, or be refused for the same reason, and a
//! refused one must change nothing.

use crate::iec::interpreter::{Instance, Program, Variable};
use crate::iec::syntax::{Section, parse};
use crate::support::assumed::Assumed;
use linewright::gr1::{Domain, Specification};
use linewright::mealy::functions::{Functions, Refusal, State};
use linewright::mealy::{Controller, Port};

/// Its own generator (xorshift), so that a seed always means the same.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// A number from 0 to `n - 1`.
    pub fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % n
    }

    pub fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// Maximum number of letters tried for a step.
const TRIES: usize = 16;

/// Number of successive refused steps after which everything is reset.
const REFUSED_AT_MOST: usize = 40;

/// Statistics of a play.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    pub accepted: usize,
    pub outside: usize,
    /// Refused with the assumption's name.
    pub broken: usize,
    /// Of these, steps for which a machine has a transition.
    pub overruled: usize,
    pub resets: usize,
}

/// Reason for a controller's refusal.
#[derive(Debug, PartialEq, Eq)]
enum Refused {
    Outside(usize),
    Broken(String),
}

/// The outputs of a step, and the next state or the memory of functions.
type Answer = (Vec<i64>, Option<usize>, Option<State>);

/// The controller itself.
struct Reference<'a> {
    controller: &'a Controller,
    assumed: Assumed<'a>,
    state: Option<usize>,
    memory: Option<State>,
}

impl<'a> Reference<'a> {
    fn new(controller: &'a Controller, specification: &'a Specification) -> Self {
        Self {
            controller,
            assumed: Assumed::new(specification),
            state: None,
            memory: controller.functions().map(Functions::initial_state),
        }
    }

    fn reset(&mut self) {
        self.assumed.reset();
        self.state = None;
        self.memory = self.controller.functions().map(Functions::initial_state);
    }

    /// Computes the answer without changing anything.
    fn answer(&self, inputs: &[i64]) -> Result<Answer, Refused> {
        let ports = self.controller.inputs().iter().zip(inputs);
        let outside = ports.into_iter().position(|(p, v)| !p.domain.contains(*v));
        if let Some(place) = outside {
            return Err(Refused::Outside(place));
        }
        let broken = self.assumed.broken(inputs);
        match (self.controller, &self.memory) {
            (Controller::Functions(functions), Some(memory)) => {
                let mut memory = memory.clone();
                match functions.step(&mut memory, inputs) {
                    Ok(outputs) => {
                        assert_eq!(broken, None, "functions refuse what breaks it");
                        Ok((outputs, None, Some(memory)))
                    }
                    Err(Refusal::Domain(place)) => Err(Refused::Outside(place)),
                    Err(Refusal::Assumption(name)) => {
                        assert!(broken.is_some(), "{name} is broken");
                        Err(Refused::Broken(name))
                    }
                }
            }
            (Controller::Machine(machine), _) => {
                if let Some(name) = broken {
                    return Err(Refused::Broken(name.to_owned()));
                }
                let taken = machine.step(self.state, inputs);
                let taken = taken.expect("a transition wherever the assumptions are kept");
                Ok((taken.output.clone(), Some(taken.to), None))
            }
            _ => unreachable!("functions have a memory"),
        }
    }

    fn step(&mut self, inputs: &[i64]) -> Result<Vec<i64>, Refused> {
        let (outputs, state, memory) = self.answer(inputs)?;
        self.assumed.accepted(inputs, &outputs);
        self.state = state;
        self.memory = memory;
        Ok(outputs)
    }

    /// Whether the controller is a machine and has a transition for these inputs, which may violate
    /// assumptions.
    fn has_transition(&self, inputs: &[i64]) -> bool {
        let machine = self.controller.machine();
        machine.is_some_and(|m| m.step(self.state, inputs).is_some())
    }
}

/// The variables of the block, found by their order, which the interface guarantees.
pub struct Ports {
    enable: Variable,
    reset: Variable,
    stepped: Variable,
    error: Variable,
    error_id: Variable,
    inputs: Vec<Variable>,
    outputs: Vec<Variable>,
    errors: Vec<String>,
    /// Locations of all memory except for the status of the last call.
    kept: Vec<(usize, usize)>,
    beginning: Vec<i64>,
}

impl Ports {
    pub fn new(program: &Program) -> Self {
        let of = |section| {
            let all = program
                .order
                .iter()
                .map(|name| program.variables[name].clone());
            all.filter(move |v: &Variable| v.section == section)
                .collect::<Vec<_>>()
        };
        let (mut inputs, mut outputs) = (of(Section::Input), of(Section::Output));
        let own_inputs: Vec<Variable> = inputs.drain(..2).collect();
        let own_outputs: Vec<Variable> = outputs.drain(..3).collect();
        let errors = match own_outputs[2].kind {
            crate::iec::interpreter::Type::Enumeration(place) => {
                program.enumerations[place].1.clone()
            }
            other => panic!("errors are {other:?}"),
        };
        let kept = outputs.iter().cloned().chain(of(Section::Local));
        Self {
            enable: own_inputs[0].clone(),
            reset: own_inputs[1].clone(),
            stepped: own_outputs[0].clone(),
            error: own_outputs[1].clone(),
            error_id: own_outputs[2].clone(),
            kept: kept.map(|v| (v.slot, v.length)).collect(),
            inputs,
            outputs,
            errors,
            beginning: program.instance().snapshot(),
        }
    }

    fn kept(&self, row: &[i64]) -> Vec<i64> {
        let kept = self.kept.iter();
        kept.flat_map(|(slot, length)| &row[*slot..slot + length])
            .copied()
            .collect()
    }

    fn call(&self, instance: &mut Instance<'_>, enable: bool, reset: bool) -> Result<(), String> {
        instance.set(&self.enable, i64::from(enable));
        instance.set(&self.reset, i64::from(reset));
        instance.call().map_err(|fault| fault.0)
    }

    /// The label of the error, in capital letters; empty if there is none.
    fn error(&self, instance: &Instance<'_>) -> Result<String, String> {
        let (error, id) = (instance.get(&self.error), instance.get(&self.error_id));
        if (error == 0) != (id == 0) {
            return Err(format!("error is {error} and error_id {id}"));
        }
        Ok(if id == 0 {
            String::new()
        } else {
            self.errors[id as usize].clone()
        })
    }
}

/// Inputs near the last ones; rarely some outside their domains.
fn letter(last: &[i64], ports: &[Port], random: &mut Random) -> Vec<i64> {
    let mut inputs = last.to_vec();
    let all = random.chance(20);
    for (value, port) in inputs.iter_mut().zip(ports) {
        if all || random.below(ports.len() as u64) == 0 {
            *value = port.domain.low() + random.below(port.domain.size()) as i64;
        }
    }
    if !inputs.is_empty() && random.chance(3) {
        let place = random.below(inputs.len() as u64) as usize;
        match ports[place].domain {
            Domain::Bool => {}
            Domain::Range { low, .. } if random.chance(50) => inputs[place] = low - 1,
            _ => inputs[place] = ports[place].domain.high() + 1,
        }
    }
    inputs
}

/// Compiles the block.
pub fn compiled(text: &str) -> Result<Program, String> {
    Program::new(&parse(text)?)
}

/// Plays a number of steps: statistics, or the first difference.
pub fn compare(
    program: &Program,
    controller: &Controller,
    specification: &Specification,
    steps: usize,
    seed: u64,
) -> Result<Counts, String> {
    play(
        program,
        controller,
        specification,
        steps,
        seed,
        &|error, broken| error.ends_with(&ending(broken)),
    )
}

/// Like `compare`, where `names` decides whether an error matches this violated assumption.
pub fn play(
    program: &Program,
    controller: &Controller,
    specification: &Specification,
    steps: usize,
    seed: u64,
    names: &dyn Fn(&str, &str) -> bool,
) -> Result<Counts, String> {
    let ports = Ports::new(program);
    let mut instance = program.instance();
    let mut reference = Reference::new(controller, specification);
    let mut random = Random::new(seed);
    let mut counts = Counts::default();
    let given = controller.inputs();
    if ports.inputs.len() != given.len() {
        return Err(format!("{} inputs", ports.inputs.len()));
    }
    let visible: Vec<usize> = (0..controller.outputs().len())
        .filter(|o| !controller.outputs()[*o].internal)
        .collect();
    if ports.outputs.len() != visible.len() {
        return Err(format!("{} outputs", ports.outputs.len()));
    }
    let anywhere = |random: &mut Random| -> Vec<i64> {
        let domains = given.iter().map(|p| &p.domain);
        domains
            .map(|d| d.low() + random.below(d.size()) as i64)
            .collect()
    };
    let mut last = anywhere(&mut random);
    let mut refused = 0;
    for step in 0..steps {
        let place = |text: String| format!("{}, step {step}: {text}", controller.name());
        if refused == REFUSED_AT_MOST || random.below(150) == 0 {
            // A call with both requests only resets.
            ports
                .call(&mut instance, random.chance(50), true)
                .map_err(place)?;
            if ports.kept(&instance.snapshot()) != ports.kept(&ports.beginning)
                || instance.get(&ports.stepped) != 0
                || !ports.error(&instance)?.is_empty()
            {
                return Err(place("a reset does not lead to the beginning".to_owned()));
            }
            reference.reset();
            last = anywhere(&mut random);
            refused = 0;
            counts.resets += 1;
        }
        let tries = if random.chance(60) { 1 } else { TRIES };
        let mut inputs = Vec::new();
        for _ in 0..tries {
            inputs = letter(&last, given, &mut random);
            if reference.answer(&inputs).is_ok() {
                break;
            }
        }
        for (variable, value) in ports.inputs.iter().zip(&inputs) {
            instance.set(variable, *value);
        }
        let before = instance.snapshot();
        if random.below(50) == 0 {
            ports.call(&mut instance, false, false).map_err(place)?;
            if ports.kept(&instance.snapshot()) != ports.kept(&before)
                || instance.get(&ports.stepped) != 0
                || instance.get(&ports.error) != before[ports.error.slot]
            {
                return Err(place("a call without a step changes something".to_owned()));
            }
        }
        ports.call(&mut instance, true, false).map_err(place)?;
        let error = ports.error(&instance).map_err(place)?;
        let stepped = instance.get(&ports.stepped) != 0;
        if stepped != error.is_empty() {
            return Err(place(format!("stepped is {stepped}, the error {error}")));
        }
        match reference.step(&inputs) {
            Ok(outputs) => {
                let outputs: Vec<i64> = visible.iter().map(|o| outputs[*o]).collect();
                let found = ports.outputs.iter().map(|v| instance.get(v));
                let found: Vec<i64> = found.collect();
                if !stepped || found != outputs {
                    let text = format!("{inputs:?}: {outputs:?} expected, found {found:?} {error}");
                    return Err(place(text));
                }
                counts.accepted += 1;
                last = inputs;
                refused = 0;
            }
            Err(reason) => {
                let text = format!("{inputs:?}: {reason:?} expected, found {error}");
                if stepped || ports.kept(&instance.snapshot()) != ports.kept(&before) {
                    return Err(place(format!("{text}, changed")));
                }
                let right = match &reason {
                    Refused::Outside(input) => {
                        counts.outside += 1;
                        // Errors are numbered like the inputs that have any.
                        let checked = given[..*input].iter();
                        let checked = checked.filter(|p| p.domain != Domain::Bool);
                        error == ports.errors[1 + checked.count()]
                    }
                    Refused::Broken(name) => {
                        counts.broken += 1;
                        counts.overruled += usize::from(reference.has_transition(&inputs));
                        names(&error, name)
                    }
                };
                if !right {
                    return Err(place(text));
                }
                refused += 1;
            }
        }
    }
    Ok(counts)
}

/// The ending of the label for a violated assumption.
fn ending(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<&str> = words.filter(|w| !w.is_empty()).collect();
    format!("_BROKEN_{}", words.join("_").to_ascii_uppercase())
}

impl Counts {
    /// Adds two statistics.
    pub fn and(self, other: Self) -> Self {
        Self {
            accepted: self.accepted + other.accepted,
            outside: self.outside + other.outside,
            broken: self.broken + other.broken,
            overruled: self.overruled + other.overruled,
            resets: self.resets + other.resets,
        }
    }
}
