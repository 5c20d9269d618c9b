//! The controller of a recipe as a machine, which synthesis writes like that of a contract.
//!
//! The outputs of a step are a vector: a command for each resource. Step 0 begins the first vector.
//! In every later step the machine reads `done`: whether all resources have carried out their
//! commands. If so, the step begins the next vector; if not, it repeats the outputs of the step
//! before.
//! In lockstep, `done` is always true and each step is a vector.
//!
//! A test of the recipe is an input. It is read in the step that begins the first vector after it,
//! when all that comes before it in the recipe has been done. Of several guards that hold, the
//! first in the text counts, and `otherwise` comes after all others. The step after the last vector
//! sets `finished` and commands all resources to wait; so do all later steps.
//!
//! There is a transition for all inputs, and about one state for each vector: the vector that the
//! resources perform.

mod commands;
mod events;
mod execution;
mod run;
mod verify;

pub use commands::Command;
pub use run::{Stopped, run};
pub use verify::{MachineFault, verify};

use super::words;
use crate::internal::Fault;
use linewright_core::gr1::{Domain, Owner, Side, Specification, Timing, Variable};
use linewright_core::source::Span;
use linewright_recipe::controller::Controller;
use linewright_recipe::model::{Guard, Layout, Recipe};
use linewright_solver::game::Limits;
use linewright_solver::mealy::{Cube, Machine, Port, Test, Transition, minimise};
use linewright_station::emit::Names;
use linewright_station::emit::controller::Origin;
use std::collections::{BTreeMap, BTreeSet};

/// Index of the input `done`; those of the tests follow.
const DONE: usize = 0;

/// A controller of a recipe as a machine, with the meaning of its ports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecipeMachine {
    /// The machine. Its inputs are `done` and the tests; its outputs are the commands of the
    /// resources, and `finished`.
    pub machine: Machine,
    /// For each resource, what its labels after `wait` stand for.
    pub commands: Vec<Vec<Command>>,
    /// Tests of the recipe, each once, in the order of the inputs.
    pub tests: Vec<RecipeTest>,
}

/// A test of a recipe.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecipeTest {
    /// Name of the test.
    pub name: String,
    /// Names of the tested parts.
    pub parts: Vec<String>,
}

/// Returns a controller as a verified machine with few states. It is named like
/// `Hinge_on_Pad`.
///
/// Takes time linear in the size of the controller, apart from the reduction of states.
///
/// # Errors
/// The verifier refuses the machine, which is an internal error.
pub fn build(
    layout: &Layout,
    recipe: &Recipe,
    controller: &Controller,
) -> Result<RecipeMachine, Fault> {
    let mut built = convert(layout, recipe, controller);
    if let Ok(smaller) = minimise::minimise(&built.machine, &Limits::default()) {
        built.machine = smaller;
    }
    verify(layout, recipe, &built).map_err(|fault| {
        let doing = format!(
            "making a machine for `{}` on `{}`",
            recipe.name, layout.name
        );
        Fault::detected(doing, format!("the verification failed: {fault}"))
    })?;
    Ok(built)
}

impl RecipeMachine {
    /// Returns what it controls, and how to use it, for the comments of its files.
    pub fn origin(&self, layout: &Layout, recipe: &Recipe) -> Origin {
        let done = &self.machine.inputs[DONE].name;
        let finished = self.machine.outputs.last();
        let finished = finished.map_or("", |port| port.name.as_str());
        let mut usage = vec![
            format!(
                "The output of a resource is its command: to wait, an operation, or to take or give a part. Step 0 begins the \
                 first vector. A later step begins the next vector if {done} is true: all resources have carried out their \
                 commands. Otherwise it repeats the outputs."
            ),
            format!("After the last vector, {finished} is true and stays so."),
        ];
        if !self.tests.is_empty() {
            usage.push(format!(
                "The other inputs are tests: {}. A test is read in the step that begins the first vector after it.",
                self.machine.inputs[DONE + 1..]
                    .iter()
                    .map(|p| p.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", ")
            ));
        }
        Origin {
            title: format!("the recipe {} on the layout {}", recipe.name, layout.name),
            usage,
        }
    }

    /// Returns a specification of the ports alone, without formulas.
    pub fn specification(&self) -> Specification {
        let machine = &self.machine;
        let of = |owner: Owner| {
            move |port: &Port| Variable {
                name: port.name.clone(),
                owner,
                internal: port.internal,
                domain: port.domain.clone(),
                unit: port.unit.clone(),
                span: Span::default(),
            }
        };
        let inputs = machine.inputs.iter().map(of(Owner::Environment));
        let outputs = machine.outputs.iter().map(of(Owner::System));
        Specification {
            name: machine.name.clone(),
            timing: machine.timing,
            variables: inputs.chain(outputs).collect(),
            assumptions: Side::default(),
            guarantees: Side::default(),
        }
    }
}

/// Values of tests, by the index of the input.
type Outcomes = BTreeMap<usize, bool>;

/// A vector: the command of each resource; `None` is to wait.
type Commands = Vec<Option<Command>>;

/// A controller on its way to a machine.
struct Conversion<'a> {
    recipe: &'a Recipe,
    controller: &'a Controller,
    tests: Vec<RecipeTest>,
    /// For each position and leg, the index of its first vector in `outputs`.
    first: Vec<Vec<usize>>,
    /// Outputs for each vector of all legs, and for the end. The state in which the resources
    /// perform a vector has the same index.
    outputs: Vec<Vec<i64>>,
}

/// Returns a controller as a machine.
fn convert(layout: &Layout, recipe: &Recipe, controller: &Controller) -> RecipeMachine {
    let (first, vectors) = flatten(layout, recipe, controller);
    let commands: Vec<Vec<Command>> = (0..layout.resources.len())
        .map(|at| {
            let all: BTreeSet<&Command> = vectors.iter().filter_map(|v| v[at].as_ref()).collect();
            all.into_iter().cloned().collect()
        })
        .collect();
    let value = |(at, command): (usize, &Option<Command>)| {
        let known = command.as_ref().map(|c| commands[at].binary_search(c));
        known.map_or(0, |found| found.unwrap_or_default() as i64 + 1)
    };
    let mut outputs: Vec<Vec<i64>> = (vectors.iter())
        .map(|v| v.iter().enumerate().map(value).chain([0]).collect())
        .collect();
    outputs.push([vec![0; layout.resources.len()], vec![1]].concat());
    let conversion = Conversion {
        recipe,
        controller,
        tests: tests(recipe),
        first,
        outputs,
    };
    let name = format!("{}_on_{}", recipe.name, layout.name);
    let (inputs, outputs) = ports(&name, layout, &commands, &conversion.tests);
    let machine = Machine {
        name,
        timing: Timing::Mealy,
        inputs,
        outputs,
        initial: conversion.begin(0, &Outcomes::new()),
        states: conversion.states(),
        goals: Vec::new(),
    };
    RecipeMachine {
        machine,
        commands,
        tests: conversion.tests,
    }
}

/// Returns the commands of the vectors of all legs, one after the other, and for
/// each leg the index of its first vector.
fn flatten(
    layout: &Layout,
    recipe: &Recipe,
    controller: &Controller,
) -> (Vec<Vec<usize>>, Vec<Commands>) {
    let (mut first, mut vectors) = (Vec::new(), Vec::new());
    for position in &controller.positions {
        let mut own = Vec::new();
        for leg in &position.legs {
            own.push(vectors.len());
            let steps = &recipe.transitions[leg.transition].steps;
            for (performed, vector) in words::numbered(leg) {
                let mut commands: Commands = vec![None; layout.resources.len()];
                for m in &vector.moves {
                    let command = Command::of(layout, recipe, m, steps.get(performed));
                    commands[m.resource] = Some(command);
                }
                vectors.push(commands);
            }
        }
        first.push(own);
    }
    (first, vectors)
}

/// Returns the tests of a recipe in the order of the text, each once.
fn tests(recipe: &Recipe) -> Vec<RecipeTest> {
    let mut found: Vec<RecipeTest> = Vec::new();
    for transition in &recipe.transitions {
        if let Guard::Test { name, inputs, .. } = &transition.guard {
            let test = RecipeTest {
                name: name.clone(),
                parts: inputs.clone(),
            };
            if !found.contains(&test) {
                found.push(test);
            }
        }
    }
    found
}

/// Returns the inputs and the outputs. All names are different; on a conflict, those of the
/// resources stay.
fn ports(
    machine: &str,
    layout: &Layout,
    commands: &[Vec<Command>],
    tests: &[RecipeTest],
) -> (Vec<Port>, Vec<Port>) {
    let mut names = Names::default();
    let mut port = |name: &str, domain| Port {
        name: names.unique(&word(name)),
        domain,
        unit: String::new(),
        internal: false,
    };
    let mut outputs: Vec<Port> = (layout.resources.iter().zip(commands))
        .map(|(resource, commands)| {
            let mut labels = Names::default();
            let wait = labels.unique("wait");
            let others = commands.iter();
            let others = others.map(|c| labels.unique(&word(&c.label(resource))));
            let labels = std::iter::once(wait).chain(others).collect();
            let name = Some(format!("{machine}_{}", word(&resource.name)));
            port(&resource.name, Domain::Enum { name, labels })
        })
        .collect();
    outputs.push(port("finished", Domain::Bool));
    let mut inputs = vec![port("done", Domain::Bool)];
    inputs.extend(tests.iter().map(|test| {
        let words: Vec<&str> = std::iter::once(&test.name)
            .chain(&test.parts)
            .map(String::as_str)
            .collect();
        port(&words.join("_"), Domain::Bool)
    }));
    (inputs, outputs)
}

/// Replaces the characters that names of the language do not have, such as `@` in labels of
/// duplicates.
fn word(name: &str) -> String {
    name.replace(|c: char| !c.is_alphanumeric() && c != '_', "_")
}

impl Conversion<'_> {
    /// Index of the state in which the recipe has ended.
    fn finished(&self) -> usize {
        self.outputs.len() - 1
    }

    /// Returns the transitions of all states.
    fn states(&self) -> Vec<Vec<Transition>> {
        let mut states = vec![Vec::new(); self.outputs.len()];
        for (position, first) in self.controller.positions.iter().zip(&self.first) {
            for (leg, first) in position.legs.iter().zip(first) {
                let end = first + leg.vectors.len();
                for (number, own) in states[*first..end].iter_mut().enumerate() {
                    let state = first + number;
                    let wait = self.transition(&Outcomes::from([(DONE, false)]), state);
                    let done = Outcomes::from([(DONE, true)]);
                    *own = if state + 1 < end {
                        vec![wait, self.transition(&done, state + 1)]
                    } else {
                        let mut transitions = self.begin(leg.to, &done);
                        transitions.insert(0, wait);
                        transitions
                    };
                }
            }
        }
        states[self.finished()] = vec![self.transition(&Outcomes::new(), self.finished())];
        states
    }

    /// Returns the transitions that begin the first vector after a position, for inputs with these
    /// values.
    fn begin(&self, position: usize, given: &Outcomes) -> Vec<Transition> {
        let legs = &self.controller.positions[position].legs;
        if legs.is_empty() {
            return vec![self.transition(given, self.finished())];
        }
        let take = |number: usize, outcomes: &Outcomes| {
            let leg = &legs[number];
            if leg.vectors.is_empty() {
                self.begin(leg.to, outcomes)
            } else {
                vec![self.transition(outcomes, self.first[position][number])]
            }
        };
        let mut found = Vec::new();
        let mut open = given.clone();
        let mut otherwise = None;
        for (number, leg) in legs.iter().enumerate() {
            let input = match &self.recipe.transitions[leg.transition].guard {
                Guard::Otherwise => {
                    otherwise = Some(number);
                    continue;
                }
                Guard::Always => None,
                Guard::Test { name, inputs, .. } => {
                    let mut tests = self.tests.iter();
                    let index = tests.position(|t| t.name == *name && t.parts == *inputs);
                    index.map(|i| DONE + 1 + i)
                }
            };
            // What is not open is decided: by an earlier guard of the step, or by `Always`.
            match input.map(|i| (i, open.get(&i).copied())) {
                None | Some((_, Some(true))) => {
                    found.extend(take(number, &open));
                    return found;
                }
                Some((_, Some(false))) => {}
                Some((input, None)) => {
                    let mut holds = open.clone();
                    holds.insert(input, true);
                    found.extend(take(number, &holds));
                    open.insert(input, false);
                }
            }
        }
        if let Some(number) = otherwise {
            found.extend(take(number, &open));
        }
        found
    }

    /// Returns the transition to a state, with its outputs.
    fn transition(&self, given: &Outcomes, to: usize) -> Transition {
        let tests = given.iter().map(|(input, value)| Test {
            input: *input,
            low: i64::from(*value),
            high: i64::from(*value),
        });
        Transition {
            guard: linewright_solver::mealy::Guard(vec![Cube(tests.collect())]),
            output: self.outputs[to].clone(),
            to,
        }
    }
}
