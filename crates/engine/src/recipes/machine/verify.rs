//! Verifies the machine of a recipe: executes it on the layout, for all outcomes of the tests.
//!
//! This module knows the texts and what the labels stand for. It shares no code with the search,
//! with the replay of controllers, or with the conversion. A machine does not say which part of the
//! recipe it performs. So everything that its vectors can mean is followed at once, as in the
//! subset construction: the machine is right if there is always a meaning, if it repeats what it
//! commands until that is done, and if no loop of it is without an operation.

use super::execution::{Cell, Execution, Progress};
use super::{DONE, Outcomes, RecipeMachine};
use linewright_recipe::model::{Action, Guard, Layout, Recipe};
use linewright_solver::mealy::Transition;
use std::cell::Cell as Slot;
use std::collections::{BTreeMap, BTreeSet};

/// What is wrong with a machine. A place is a state of the machine; `None` is step 0.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MachineFault {
    /// There is no transition for some inputs.
    #[error("there is no transition in {0:?} for {1:?}")]
    Incomplete(Option<usize>, Outcomes),
    /// The outputs change before the resources have finished, or after the end.
    #[error("the outputs of {0:?} change too early")]
    NotHeld(Option<usize>),
    /// The vector is impossible, or is no part of the recipe.
    #[error("the outputs of {0:?} for {1:?} do not carry the recipe out")]
    NotCarriedOut(Option<usize>, Outcomes),
    /// There is a loop without an operation of the recipe.
    #[error("there is a loop without an operation")]
    Endless,
}

/// A machine between two steps.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Node {
    state: Option<usize>,
    /// Outputs of the last step.
    outputs: Option<Vec<i64>>,
    /// All that its vectors can mean.
    meanings: BTreeSet<Progress>,
}

/// Inputs of which some are known. One that is asked for and not known is remembered.
pub(super) struct Inputs {
    pub known: Outcomes,
    pub asked: Slot<Option<usize>>,
}

/// An input that is not known matters.
pub(super) struct Unknown;

impl Inputs {
    pub fn new(known: Outcomes) -> Self {
        Self {
            known,
            asked: Slot::new(None),
        }
    }

    fn get(&self, input: usize) -> Option<bool> {
        let known = self.known.get(&input).copied();
        if known.is_none() {
            self.asked.set(Some(input));
        }
        known
    }
}

/// Computes something for all inputs with these values: where an input is not known that matters,
/// once for each of its values.
fn for_all<T>(
    given: Outcomes,
    compute: impl Fn(&Inputs) -> Option<Result<T, MachineFault>>,
) -> Result<Vec<T>, MachineFault> {
    let (mut open, mut found) = (vec![given], Vec::new());
    while let Some(known) = open.pop() {
        let inputs = Inputs::new(known);
        if let Some(result) = compute(&inputs) {
            found.push(result?);
            continue;
        }
        let Some(asked) = inputs.asked.get() else {
            continue;
        };
        for value in [false, true] {
            let mut known = inputs.known.clone();
            known.insert(asked, value);
            open.push(known);
        }
    }
    Ok(found)
}

/// Executes a machine for all outcomes of the tests, on a layout and a recipe without problems.
///
/// Takes time linear in the number of states, if few vectors can mean several things.
///
/// # Errors
/// The first fault that is found.
pub fn verify(layout: &Layout, recipe: &Recipe, of: &RecipeMachine) -> Result<(), MachineFault> {
    let execution = Execution { layout, recipe, of };
    let start = Node {
        state: None,
        outputs: None,
        meanings: BTreeSet::from([execution.start()]),
    };
    let mut nodes = vec![start.clone()];
    let mut numbers = BTreeMap::from([(start, 0)]);
    // Steps that perform no operation, from node to node.
    let mut idle: Vec<Vec<usize>> = Vec::new();
    while let Some(node) = nodes.get(idle.len()).cloned() {
        let mut own = Vec::new();
        for (next, performs) in execution.successors(&node)? {
            let number = *numbers.entry(next.clone()).or_insert_with(|| {
                nodes.push(next);
                nodes.len() - 1
            });
            if !performs {
                own.push(number);
            }
        }
        idle.push(own);
    }
    if has_loop(&idle) {
        return Err(MachineFault::Endless);
    }
    Ok(())
}

/// Whether a graph has a loop: nodes without a predecessor are taken away one after the other.
fn has_loop(successors: &[Vec<usize>]) -> bool {
    let mut entering = vec![0; successors.len()];
    successors
        .iter()
        .flatten()
        .for_each(|to| entering[*to] += 1);
    let mut free: Vec<usize> = (0..entering.len()).filter(|n| entering[*n] == 0).collect();
    let mut taken = 0;
    while let Some(node) = free.pop() {
        taken += 1;
        for to in &successors[node] {
            entering[*to] -= 1;
            if entering[*to] == 0 {
                free.push(*to);
            }
        }
    }
    taken < entering.len()
}

impl Execution<'_> {
    /// Returns the nodes after a step that begins a vector, and whether it performs an operation.
    fn successors(&self, node: &Node) -> Result<Vec<(Node, bool)>, MachineFault> {
        let Some(outputs) = &node.outputs else {
            return for_all(Outcomes::new(), |inputs| self.follow(node, inputs));
        };
        let held = |inputs: &Inputs| {
            let taken = match self.step(node.state, inputs)? {
                Ok(taken) => taken,
                Err(fault) => return Some(Err(fault)),
            };
            let is_held = taken.output == *outputs && Some(taken.to) == node.state;
            Some(
                is_held
                    .then_some(())
                    .ok_or(MachineFault::NotHeld(node.state)),
            )
        };
        if outputs.last() == Some(&1) {
            for_all(Outcomes::new(), held)?;
            return Ok(Vec::new());
        }
        for_all(Outcomes::from([(DONE, false)]), held)?;
        for_all(Outcomes::from([(DONE, true)]), |inputs| {
            self.follow(node, inputs)
        })
    }

    /// Returns the transition that the machine takes; `None` if it depends on another input.
    pub fn step(
        &self,
        state: Option<usize>,
        inputs: &Inputs,
    ) -> Option<Result<&Transition, MachineFault>> {
        for transition in self.of.machine.transitions(state) {
            for cube in &transition.guard.0 {
                let mut holds = true;
                for test in &cube.0 {
                    let value = i64::from(inputs.get(test.input)?);
                    if value < test.low || value > test.high {
                        holds = false;
                        break;
                    }
                }
                if holds {
                    return Some(Ok(transition));
                }
            }
        }
        Some(Err(MachineFault::Incomplete(state, inputs.known.clone())))
    }

    /// Returns the node after a step that begins a vector or ends the recipe, and whether the step
    /// performs an operation; `None` if that depends on another input.
    fn follow(&self, node: &Node, inputs: &Inputs) -> Option<Result<(Node, bool), MachineFault>> {
        let taken = match self.step(node.state, inputs)? {
            Ok(taken) => taken,
            Err(fault) => return Some(Err(fault)),
        };
        let (finished, labels) = taken.output.split_last()?;
        let mut meanings = BTreeSet::new();
        for one in &node.meanings {
            for begun in self.begin(one, inputs)? {
                if *finished == 0 {
                    meanings.extend(self.apply(&begun, labels).into_iter().map(|v| v.after));
                } else if self.is_end(&begun) && labels.iter().all(|label| *label == 0) {
                    meanings.insert(begun);
                }
            }
        }
        if meanings.is_empty() {
            let known = inputs.known.clone();
            return Some(Err(MachineFault::NotCarriedOut(node.state, known)));
        }
        let next = Node {
            state: Some(taken.to),
            outputs: Some(taken.output.clone()),
            meanings,
        };
        let performs = (labels.iter().enumerate()).any(|(at, label)| {
            let command = self.command(at, *label);
            command.is_some_and(|(_, action)| matches!(action, Action::Operation(_)))
        });
        Some(Ok((next, performs || *finished == 1)))
    }

    /// Returns the state of the recipe, if all steps before it were performed.
    pub fn reached(&self, progress: &Progress) -> Option<&str> {
        let Some(transition) = progress.transition else {
            return Some(&self.recipe.start);
        };
        let transition = &self.recipe.transitions[transition];
        (transition.steps.len() == progress.performed).then_some(&transition.to)
    }

    /// Returns what can be performed next: the rest of the transition, or one after it whose guard
    /// holds; `None` if that depends on another input.
    fn begin(&self, progress: &Progress, inputs: &Inputs) -> Option<Vec<Progress>> {
        let mut all = vec![progress.clone()];
        let mut at = 0;
        while let Some(one) = all.get(at).cloned() {
            at += 1;
            let Some(state) = self.reached(&one) else {
                continue;
            };
            if let Some(chosen) = self.choose(state, &one.cell, inputs).ok()? {
                all.push(Progress {
                    transition: Some(chosen),
                    performed: 0,
                    cell: one.cell,
                });
            }
        }
        Some(all)
    }

    /// Returns the transition of the recipe that is taken in a state, if it can be decided there:
    /// the first whose guard holds.
    ///
    /// # Errors
    /// It depends on another input.
    pub fn choose(
        &self,
        state: &str,
        cell: &Cell,
        inputs: &Inputs,
    ) -> Result<Option<usize>, Unknown> {
        let leaving = || {
            let all = self.recipe.transitions.iter().enumerate();
            all.filter(|(_, t)| t.from == state)
        };
        for (_, transition) in leaving() {
            let Guard::Test {
                inputs: parts, at, ..
            } = &transition.guard
            else {
                continue;
            };
            let holds = |name: &String| {
                let resource = self.layout.resource(name);
                resource.is_some_and(|r| self.without(cell, r, parts).is_some())
            };
            if !at.is_empty() && !at.iter().any(holds) {
                return Ok(None);
            }
        }
        let mut otherwise = None;
        for (number, transition) in leaving() {
            match &transition.guard {
                Guard::Always => return Ok(Some(number)),
                Guard::Otherwise => otherwise = Some(number),
                Guard::Test {
                    name,
                    inputs: parts,
                    ..
                } => {
                    let mut tests = self.of.tests.iter();
                    let test = tests.position(|t| t.name == *name && t.parts == *parts);
                    let outcome = inputs.get(DONE + 1 + test.unwrap_or_default());
                    if outcome.ok_or(Unknown)? {
                        return Ok(Some(number));
                    }
                }
            }
        }
        Ok(otherwise)
    }

    /// Whether the recipe can end here.
    pub fn is_end(&self, progress: &Progress) -> bool {
        let recipe = self.recipe;
        let may_remain = |name: &String| {
            let part = recipe.parts.iter().find(|p| p.name == *name);
            part.is_none_or(|p| {
                recipe.leftover.contains(&p.name) || recipe.leftover.contains(&p.kind)
            })
        };
        let state = self.reached(progress);
        state.is_some_and(|s| recipe.ends.iter().any(|e| e == s))
            && progress.cell.parts.iter().flatten().all(may_remain)
    }
}
