//! A controller and its function block, played side by side on random steps.
//!
//! Inputs stay near the last ones that were accepted, so that most keep the assumptions; some are outside their domains. A step
//! must have the same outputs, or be refused for the same reason, and a refused one must change nothing.

use crate::interpreter::{Instance, Program, Variable};
use crate::syntax::{Section, parse};
use linewright::gr1::{Domain, Formula, Specification, eval};
use linewright::mealy::functions::{Functions, Refusal, State};
use linewright::mealy::{Controller, Port};

/// A generator of its own (xorshift), so that a seed means the same for ever.
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

/// So many letters are tried for a step.
const TRIES: usize = 16;

/// After so many refused steps in a row all begins anew.
const REFUSED_AT_MOST: usize = 40;

/// What was played.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    pub accepted: usize,
    pub outside: usize,
    /// Refused with the assumption's name.
    pub named: usize,
    /// Refused without, although no assumption was broken before.
    pub unnamed: usize,
    /// Refused without, after a step that broke one and was accepted.
    pub late: usize,
    pub resets: usize,
}

/// Why a controller refuses.
#[derive(Debug, PartialEq, Eq)]
enum Refused {
    Outside(usize),
    /// Functions know which assumption.
    Broken(Option<String>),
}

/// The outputs of a step, and where it leads to: a state, or what functions keep.
type Answer = (Vec<i64>, Option<usize>, Option<State>);

/// The controller itself.
struct Reference<'a> {
    controller: &'a Controller,
    specification: &'a Specification,
    state: Option<usize>,
    memory: Option<State>,
    /// The values of all variables in the step before.
    before: Option<Vec<i64>>,
}

impl<'a> Reference<'a> {
    fn new(controller: &'a Controller, specification: &'a Specification) -> Self {
        Self {
            controller,
            specification,
            state: None,
            memory: controller.functions().map(Functions::start),
            before: None,
        }
    }

    fn reset(&mut self) {
        *self = Self::new(self.controller, self.specification);
    }

    /// What the answer is, and nothing is changed by asking.
    fn answer(&self, inputs: &[i64]) -> Result<Answer, Refused> {
        let ports = self.controller.inputs().iter().zip(inputs);
        let outside = ports.into_iter().position(|(p, v)| !p.domain.contains(*v));
        if let Some(place) = outside {
            return Err(Refused::Outside(place));
        }
        match (self.controller, &self.memory) {
            (Controller::Functions(functions), Some(memory)) => {
                let mut memory = memory.clone();
                match functions.step(&mut memory, inputs) {
                    Ok(outputs) => Ok((outputs, None, Some(memory))),
                    Err(Refusal::Domain(place)) => Err(Refused::Outside(place)),
                    Err(Refusal::Assumption(name)) => Err(Refused::Broken(Some(name))),
                }
            }
            (Controller::Machine(machine), _) => match machine.step(self.state, inputs) {
                Some(taken) => Ok((taken.output.clone(), Some(taken.to), None)),
                None => Err(Refused::Broken(None)),
            },
            _ => unreachable!("functions have a memory"),
        }
    }

    /// The values of all variables, outputs being 0.
    fn valuation(&self, inputs: &[i64], outputs: &[i64]) -> Vec<i64> {
        let mut values = vec![0; self.specification.variables.len()];
        for (id, value) in self.specification.inputs().zip(inputs) {
            values[id.index()] = *value;
        }
        for (id, value) in self.specification.outputs().zip(outputs) {
            values[id.index()] = *value;
        }
        values
    }

    fn step(&mut self, inputs: &[i64]) -> Result<Vec<i64>, Refused> {
        let (outputs, state, memory) = self.answer(inputs)?;
        self.before = Some(self.valuation(inputs, &outputs));
        self.state = state;
        self.memory = memory;
        Ok(outputs)
    }

    /// The names of the assumptions that these inputs break, by the meaning of formulas alone.
    fn broken(&self, inputs: &[i64]) -> Vec<&str> {
        let now = self.valuation(inputs, &[]);
        let side = &self.specification.assumptions;
        let holds = |f: &&Formula| match &self.before {
            // Of the step before and of this one.
            Some(before) if side.safety.iter().any(|s| std::ptr::eq(s, *f)) => {
                eval::holds(&f.expr, before, &now)
            }
            _ => eval::holds(&f.expr, &now, &now),
        };
        let once = if self.before.is_none() {
            &side.initial
        } else {
            &side.safety
        };
        let formulas = side.invariants.iter().chain(once);
        formulas
            .filter(|f| !holds(f))
            .map(|f| f.name.as_str())
            .collect()
    }
}

/// The variables of the block, found by their order as the interface promises it.
pub struct Ports {
    enable: Variable,
    reset: Variable,
    stepped: Variable,
    error: Variable,
    error_id: Variable,
    inputs: Vec<Variable>,
    outputs: Vec<Variable>,
    errors: Vec<String>,
    /// Where all that is kept lies, but for what says how the last call went.
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
            crate::interpreter::Type::Enumeration(place) => program.enumerations[place].1.clone(),
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

    /// The label of the error, in capital letters; empty where there is none.
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

/// Inputs near the last ones; rarely some outside of their domains.
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

/// Plays so many steps: what was played, or where the two differ.
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
        &|error, broken| broken.iter().any(|name| error.ends_with(&ending(name))),
    )
}

/// The same, where `names` decides whether an error may stand for one of these broken assumptions.
pub fn play(
    program: &Program,
    controller: &Controller,
    specification: &Specification,
    steps: usize,
    seed: u64,
    names: &dyn Fn(&str, &[String]) -> bool,
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
    // Whether all assumptions were kept since the beginning: a machine may accept a step that breaks one.
    let mut kept = true;
    for step in 0..steps {
        let place = |text: String| format!("{}, step {step}: {text}", controller.name());
        if refused == REFUSED_AT_MOST || random.below(150) == 0 {
            // A call that is to do both only resets.
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
            kept = true;
            counts.resets += 1;
        }
        let tries = if random.chance(25) { 1 } else { TRIES };
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
        let broken = reference.broken(&inputs).into_iter().map(str::to_owned);
        let broken: Vec<String> = broken.collect();
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
                kept &= broken.is_empty();
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
                        if error.ends_with("_BROKEN_ASSUMPTION") {
                            counts.unnamed += usize::from(kept);
                            counts.late += usize::from(!kept);
                        } else {
                            counts.named += 1;
                        }
                        match name {
                            Some(name) => names(&error, std::slice::from_ref(name)),
                            None => error.ends_with("_BROKEN_ASSUMPTION") || names(&error, &broken),
                        }
                    }
                };
                if !right {
                    return Err(place(format!("{text}; broken is {broken:?}")));
                }
                refused += 1;
            }
        }
    }
    Ok(counts)
}

/// How the label of a broken assumption ends.
fn ending(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<&str> = words.filter(|w| !w.is_empty()).collect();
    format!("_BROKEN_{}", words.join("_").to_ascii_uppercase())
}

impl Counts {
    /// Both together.
    pub fn and(self, other: Self) -> Self {
        Self {
            accepted: self.accepted + other.accepted,
            outside: self.outside + other.outside,
            named: self.named + other.named,
            unnamed: self.unnamed + other.unnamed,
            late: self.late + other.late,
            resets: self.resets + other.resets,
        }
    }
}
