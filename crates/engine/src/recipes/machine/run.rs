//! Runs that the machine of a recipe coordinates: it commands a vector, the resources carry it out,
//! and when all have ended, this is its input `done`.
//!
//! What labels mean is the matter of [`super::execution`], as in the verification. A test is
//! decided when the machine reads it: in the step that begins the first vector after it. If all
//! goes on in the same way, the machine does not read it; then it is decided as soon as it can be
//! made.

use super::execution::{Execution, Progress, Vector};
use super::verify::Inputs;
use super::{DONE, Outcomes, RecipeMachine};
use linewright_recipe::model::{Guard, Layout, Recipe};
use linewright_recipe::plan::{self, Entry};
use linewright_recipe::run::{Plant, Run, Vectors};

/// Why a run stops.
#[derive(Debug)]
pub enum Stopped<E> {
    /// An operation fails: the plant's error.
    Plant(E),
    /// The machine does not carry the recipe out, which [`super::verify`] excludes.
    Machine(String),
}

/// Lets a verified machine make the product once. A recipe that never ends stops when it has closed
/// this number of loops.
///
/// Takes time linear in the number of vectors, for a state with few transitions, and calls of the
/// plant.
///
/// # Errors
/// An operation fails, or the machine is not one that [`super::verify`] accepts.
pub fn run<P: Plant>(
    layout: &Layout,
    recipe: &Recipe,
    of: &RecipeMachine,
    plant: &mut P,
    how: plan::Execution,
    loops: usize,
) -> Result<Run, Stopped<P::Error>> {
    let execution = Execution { layout, recipe, of };
    let progress = execution.start();
    let vectors = Vectors::new(layout, plant, how, &progress.cell.states);
    let runner = Runner {
        execution,
        vectors,
        closes: recipe.closes_loop(),
        loops,
        state: None,
        progress,
        inputs: inputs(),
    };
    runner.run()
}

/// The inputs of a step, before a test is decided.
fn inputs() -> Inputs {
    Inputs::new(Outcomes::from([(DONE, true)]))
}

/// A run that goes on.
struct Runner<'a, P> {
    execution: Execution<'a>,
    vectors: Vectors<'a, P>,
    /// For each transition of the recipe, whether it closes a loop.
    closes: Vec<bool>,
    loops: usize,
    /// State of the machine.
    state: Option<usize>,
    progress: Progress,
    /// Inputs of the next step, as far as they are decided. They are kept until an operation.
    inputs: Inputs,
}

/// What follows in the recipe.
enum Next {
    /// A transition.
    Taken(usize),
    /// One of these transitions, each with the inputs that it needs.
    Tested(Vec<(usize, Outcomes)>),
    /// A step, or a test of a part that is not yet where it can be tested.
    Step,
}

/// What the machine commands.
enum Commanded {
    /// A vector, and the state of the machine that follows.
    Vector(usize, Vector, Vec<Vec<Entry>>),
    End,
}

impl<P: Plant> Runner<'_, P> {
    fn run(mut self) -> Result<Run, Stopped<P::Error>> {
        loop {
            match self.next(&self.progress) {
                Next::Taken(transition) => {
                    if self.is_last() {
                        return Ok(self.vectors.end(false));
                    }
                    let guard = &self.execution.recipe.transitions[transition].guard;
                    if *guard != Guard::Always {
                        self.vectors.test(&[transition]);
                    }
                    self.enter(transition);
                }
                Next::Tested(outcomes) if !self.reads_later() => {
                    if self.is_last() {
                        return Ok(self.vectors.end(false));
                    }
                    let transitions: Vec<usize> = outcomes.iter().map(|o| o.0).collect();
                    let taken = self.vectors.test(&transitions);
                    let known = outcomes.into_iter().find(|o| o.0 == taken);
                    self.inputs = Inputs::new(known.map(|o| o.1).unwrap_or_default());
                    self.enter(taken);
                }
                Next::Step | Next::Tested(_) => match self.step().map_err(Stopped::Machine)? {
                    Commanded::End => return Ok(self.vectors.end(true)),
                    Commanded::Vector(to, vector, events) => {
                        self.vectors.perform(&events).map_err(Stopped::Plant)?;
                        if !vector.calls.is_empty() {
                            self.inputs = inputs();
                        }
                        (self.state, self.progress) = (Some(to), vector.after);
                    }
                },
            }
        }
    }

    /// Notes if the product has closed a loop. Returns whether it was the last of the run.
    fn is_last(&mut self) -> bool {
        let closed = self.progress.transition.is_some_and(|t| self.closes[t]);
        closed && self.vectors.close_loop() >= self.loops
    }

    fn enter(&mut self, transition: usize) {
        self.progress.transition = Some(transition);
        self.progress.performed = 0;
    }

    fn next(&self, progress: &Progress) -> Next {
        let Some(state) = self.execution.reached(progress) else {
            return Next::Step;
        };
        match (self.execution).choose(state, &progress.cell, &self.inputs) {
            Ok(Some(transition)) => Next::Taken(transition),
            Ok(None) => Next::Step,
            Err(_) => Next::Tested(self.execution.outcomes(state, &self.inputs.known)),
        }
    }

    /// Whether the machine reads the test that can be made now only after some transfers.
    fn reads_later(&self) -> bool {
        let (mut state, mut progress) = (self.state, self.progress.clone());
        let mut is_later = false;
        while let Some(Ok(taken)) = self.execution.step(state, &self.inputs) {
            let Some((0, labels)) = taken.output.split_last() else {
                return false;
            };
            let vectors = self.execution.apply(&progress, labels).into_iter();
            let Some(vector) = vectors.take(1).find(|v| v.calls.is_empty()) else {
                return false;
            };
            (state, progress) = (Some(taken.to), vector.after);
            is_later = true;
        }
        is_later && matches!(self.next(&progress), Next::Tested(_))
    }

    /// Steps the machine. An input that is not decided is false.
    fn step(&self) -> Result<Commanded, String> {
        let mut inputs = Inputs::new(self.inputs.known.clone());
        let taken = loop {
            if let Some(taken) = self.execution.step(self.state, &inputs) {
                break taken.map_err(|fault| fault.to_string())?;
            }
            if let Some(asked) = inputs.asked.take() {
                inputs.known.insert(asked, false);
            }
        };
        let commanded = match taken.output.split_last() {
            Some((0, labels)) => {
                let mut vectors = self.execution.apply(&self.progress, labels).into_iter();
                vectors.next().and_then(|vector| {
                    let events = self.execution.events(&self.progress, labels, &vector)?;
                    Some(Commanded::Vector(taken.to, vector, events))
                })
            }
            _ => (self.execution.is_end(&self.progress)).then_some(Commanded::End),
        };
        commanded.ok_or_else(|| format!("no vector follows in {:?}", self.state))
    }
}

impl Execution<'_> {
    /// Returns the transitions that can follow a test in a state of the recipe, each with the
    /// inputs that it needs: its guard holds, and none before it.
    fn outcomes(&self, state: &str, known: &Outcomes) -> Vec<(usize, Outcomes)> {
        let (mut found, mut known) = (Vec::new(), known.clone());
        let mut otherwise = None;
        let all = self.recipe.transitions.iter().enumerate();
        for (number, transition) in all.filter(|(_, t)| t.from == state) {
            match &transition.guard {
                Guard::Otherwise => otherwise = Some(number),
                Guard::Always => {
                    found.push((number, known));
                    return found;
                }
                Guard::Test { name, inputs, .. } => {
                    let mut tests = self.of.tests.iter();
                    let test = tests.position(|t| t.name == *name && t.parts == *inputs);
                    let input = DONE + 1 + test.unwrap_or_default();
                    let is_open = !known.contains_key(&input);
                    if is_open || known[&input] {
                        let mut own = known.clone();
                        own.insert(input, true);
                        found.push((number, own));
                    }
                    known.entry(input).or_insert(false);
                }
            }
        }
        found.extend(otherwise.map(|number| (number, known)));
        found.sort_unstable_by_key(|o| o.0);
        found
    }
}
