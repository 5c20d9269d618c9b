//! Independent check of runs of a closed composition: steps the controllers themselves and
//! evaluates formulas on plain values, without the rules of `rules.rs` and without decision
//! diagrams.

use super::{ClosedComposition, FailureKind, OperationFailure, StuckComponent};
use crate::proof::{Exports, Open, Refutation};
use crate::replay::{formula, holds_at, keeps_formula};
use crate::system::FormulaRef;
use linewright_core::gr1::{Formula, FormulaKind, Timing, eval};
use linewright_language::contract::machine::PlantSource;
use linewright_solver::game::Lasso;
use linewright_solver::mealy::{Controller, functions};

/// Maximum number of repetitions of a cycle until the controllers return to an earlier state.
const MAX_ROUNDS: usize = 1_000;

/// State of a controller.
#[derive(Debug, Clone, PartialEq, Eq)]
enum ControllerState {
    Table(Option<usize>),
    Functions(functions::State),
}

/// Controllers stepped side by side.
struct Replay<'a> {
    closed: &'a ClosedComposition<'a>,
    places: Vec<ControllerState>,
}

/// How far a step is replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Until {
    /// All components answer.
    End,
    /// Only the components before this one answer.
    Before(usize),
}

impl<'a> Replay<'a> {
    fn new(closed: &'a ClosedComposition<'a>) -> Self {
        let places = closed.controllers.iter().map(|c| match c {
            Controller::Machine(_) => ControllerState::Table(None),
            Controller::Functions(functions) => {
                ControllerState::Functions(functions.initial_state())
            }
        });
        Self {
            closed,
            places: places.collect(),
        }
    }

    /// Returns the inputs of a component.
    fn inputs(&self, component: usize, values: &[i64]) -> Vec<i64> {
        let bindings = self.closed.machine.components[component].bindings.iter();
        bindings.map(|b| eval::eval(b, values, &[])).collect()
    }

    /// Returns the values of a component's output wires.
    fn outputs<'v>(&self, component: usize, values: &'v [i64]) -> &'v [i64] {
        let first = self.closed.participants[component].first;
        &values[first..first + self.closed.controllers[component].outputs().len()]
    }

    /// Returns the outputs of a component that answers first; `None` if its state has none.
    fn fixed_outputs(&self, component: usize) -> Option<Vec<i64>> {
        match (self.closed.controllers[component], &self.places[component]) {
            (Controller::Machine(table), ControllerState::Table(at)) => {
                let rows = table.transitions(*at);
                rows.first().map(|row| row.output.clone())
            }
            (Controller::Functions(functions), ControllerState::Functions(state)) => {
                Some(functions.moore_output(state))
            }
            _ => None,
        }
    }

    /// Advances a component and returns its outputs; `None` if it has none for these inputs.
    fn answer(&mut self, component: usize, inputs: &[i64]) -> Option<Vec<i64>> {
        match (
            self.closed.controllers[component],
            &mut self.places[component],
        ) {
            (Controller::Machine(table), ControllerState::Table(at)) => {
                let row = table.step(*at, inputs)?;
                *at = Some(row.to);
                Some(row.output.clone())
            }
            (Controller::Functions(functions), ControllerState::Functions(state)) => {
                functions.step(state, inputs).ok()
            }
            _ => None,
        }
    }

    /// Advances the controllers by a step with these values, and checks their outputs.
    fn step(&mut self, values: &[i64], until: Until) -> Result<(), String> {
        let name = |c: usize| &self.closed.machine.components[c].name;
        let order = self.closed.order();
        let timing = |c: usize| self.closed.controllers[c].timing();
        for component in order.iter().filter(|c| timing(**c) == Timing::Moore) {
            let fixed = self
                .fixed_outputs(*component)
                .ok_or_else(|| format!("{} has no answer", name(*component)))?;
            if fixed != self.outputs(*component, values) {
                return Err(format!("{} has other outputs", name(*component)));
            }
        }
        for component in order {
            if until == Until::Before(component) {
                return Ok(());
            }
            let inputs = self.inputs(component, values);
            let answer = self.answer(component, &inputs);
            let name = &self.closed.machine.components[component].name;
            let answer = answer.ok_or_else(|| format!("{name} has no answer"))?;
            let first = timing(component) == Timing::Moore;
            if !first && answer != self.outputs(component, values) {
                return Err(format!("{name} has other outputs"));
            }
            let participant = &self.closed.participants[component];
            if let (Some(state), Some(states), ControllerState::Table(Some(at))) = (
                participant.state,
                &participant.states,
                &self.places[component],
            ) {
                let number = states.number(self.outputs(component, values), *at);
                if number.map(|n| n as i64) != Some(values[state.index()]) {
                    return Err(format!("the table of {name} is in another state"));
                }
            }
        }
        Ok(())
    }
}

impl ClosedComposition<'_> {
    /// Checks that a step keeps the givens, and that the values of monitors and of the operation
    /// watch are correct.
    fn check_environment(&self, steps: &[Vec<i64>], at: usize) -> Result<(), String> {
        let values = self.system.variables.iter().zip(&steps[at]);
        if let Some((v, value)) = values.into_iter().find(|(v, x)| !v.domain.contains(**x)) {
            return Err(format!("{value} is not a value of {}", v.name));
        }
        let beside = &self.system.components[self.participants.len()..];
        let sides = beside.iter().map(|p| &p.definitions);
        for side in sides.chain([&self.claim.given]) {
            for (kind, _, formula) in side.formulas() {
                if !holds_at(kind, formula, steps, at) {
                    return Err(format!("step {at} breaks {}", formula.name));
                }
            }
        }
        self.check_watch(steps, at)
    }

    /// Counts the actions again and compares the number with the watch.
    fn check_watch(&self, steps: &[Vec<i64>], at: usize) -> Result<(), String> {
        let Some(watch) = &self.watch else {
            return Ok(());
        };
        let (_, begun) = self.count_actions(steps, at);
        let longest = self.machine.operations.iter().map(|o| o.sequence.len());
        let begun = begun.min(longest.max().unwrap_or(0) + 1);
        if steps[at][watch.begun.index()] == begun as i64 {
            Ok(())
        } else {
            Err(format!("the number of actions begun is wrong in step {at}"))
        }
    }

    fn is_done(&self, values: &[i64]) -> bool {
        let done = self.machine.done.as_ref();
        done.is_some_and(|d| eval::holds(d, values, &[]))
    }

    /// Returns the component that is active in a step, and the number of actions that have begun in
    /// the call so far.
    fn count_actions(&self, steps: &[Vec<i64>], at: usize) -> (Option<usize>, usize) {
        let first = (1..=at).rev().find(|i| self.is_done(&steps[i - 1]));
        let (mut before, mut begun) = (None, 0);
        for values in &steps[first.unwrap_or(0)..=at] {
            let mut components = self.machine.components.iter();
            let now = components.position(|c| {
                let active = c.active.as_ref();
                active.is_some_and(|a| eval::holds(a, values, &[]))
            });
            begun += usize::from(now.is_some() && now != before);
            before = now;
        }
        (before, begun)
    }

    /// Checks that the exported assumptions are kept in a step.
    fn check_exported(&self, steps: &[Vec<i64>], at: usize) -> Result<(), String> {
        for component in 0..self.participants.len() {
            for (what, formula) in self.assumed(component) {
                if self.is_exported(what.kind, formula)
                    && self.is_outside(steps, at)
                    && !holds_at(what.kind, formula, steps, at)
                {
                    return Err(format!(
                        "step {at} breaks {}, which is exported",
                        formula.name
                    ));
                }
            }
        }
        Ok(())
    }

    /// Returns whether the caller is responsible for the exported assumptions in a step.
    fn is_outside(&self, steps: &[Vec<i64>], at: usize) -> bool {
        match &self.claim.exports {
            Exports::Never => false,
            Exports::Always => true,
            Exports::After(done) => at == 0 || eval::holds(done, &steps[at - 1], &[]),
        }
    }

    /// Checks that these components' assumptions are kept in a step.
    fn check_assumptions(&self, of: &[usize], steps: &[Vec<i64>], at: usize) -> Result<(), String> {
        for component in of {
            for (what, formula) in self.assumed(*component) {
                if !holds_at(what.kind, formula, steps, at) {
                    return Err(format!("step {at} breaks {}", formula.name));
                }
            }
        }
        Ok(())
    }

    /// Replays a run, which must have no errors. The last step is replayed only as far as `until`;
    /// the assumptions of the component that `until` names are not checked.
    fn play(&self, steps: &[Vec<i64>], until: Until) -> Result<Replay<'_>, String> {
        let mut replay = Replay::new(self);
        let Some(last) = steps.len().checked_sub(1) else {
            return Err("the run has no steps".to_owned());
        };
        let order = self.order();
        for (at, values) in steps.iter().enumerate() {
            self.check_environment(steps, at)?;
            let (asked, until) = match until {
                Until::Before(component) if at == last => {
                    self.check_exported(steps, at)?;
                    let place = order.iter().position(|c| *c == component);
                    (&order[..place.unwrap_or(0)], until)
                }
                _ => (&order[..], Until::End),
            };
            self.check_assumptions(asked, steps, at)?;
            replay
                .step(values, until)
                .map_err(|e| format!("step {at}: {e}"))?;
        }
        Ok(replay)
    }

    /// Replays an infinite run: its cycle is repeated until the controllers return to an earlier
    /// state.
    fn play_for_ever(&self, run: &Lasso) -> Result<(), String> {
        if run.cycle.is_empty() {
            return Err("the run has no cycle".to_owned());
        }
        let mut steps: Vec<Vec<i64>> = run.prefix.iter().chain(&run.cycle).cloned().collect();
        let mut replay = self.play(&steps, Until::End)?;
        // Enter the cycle once more: monitors and assumptions must also be correct there.
        steps.push(run.cycle[0].clone());
        self.check_environment(&steps, steps.len() - 1)?;
        self.check_assumptions(&self.order(), &steps, steps.len() - 1)?;
        let mut seen = Vec::new();
        for _ in 0..MAX_ROUNDS {
            if seen.contains(&replay.places) {
                let mut justice = self.claim.given.justice.iter();
                return match justice.find(|f| !keeps_formula(FormulaKind::Justice, f, run)) {
                    Some(starved) => Err(format!("the run starves {}", starved.name)),
                    None => self.check_exported_justice(run),
                };
            }
            seen.push(replay.places.clone());
            for values in &run.cycle {
                replay.step(values, Until::End)?;
            }
        }
        Err("the controllers do not return to an earlier state".to_owned())
    }

    fn check_exported_justice(&self, run: &Lasso) -> Result<(), String> {
        for component in 0..self.participants.len() {
            for formula in self
                .component(component)
                .assumptions
                .list(FormulaKind::Justice)
            {
                if self.is_exported(FormulaKind::Justice, formula)
                    && !keeps_formula(FormulaKind::Justice, formula, run)
                {
                    return Err(format!("the run starves {}", formula.name));
                }
            }
        }
        Ok(())
    }

    fn formula(&self, at: FormulaRef) -> &Formula {
        formula(&self.system, &self.claim, at)
    }
}

/// Checks that a component has no answer at the end of a run, and that this is the first error of
/// the last step.
///
/// # Errors
/// If the run does not prove this; the text states what is wrong with it.
pub fn check_stuck(closed: &ClosedComposition<'_>, found: &StuckComponent) -> Result<(), String> {
    let steps = &found.trace;
    let component = found.component;
    let last = steps.len().saturating_sub(1);
    let silent = |replay: &Replay<'_>| {
        closed.controllers[component].timing() == Timing::Moore
            && replay.fixed_outputs(component).is_none()
    };
    if found.silent {
        let replay = match last {
            0 => Replay::new(closed),
            _ => closed.play(&steps[..last], Until::End)?,
        };
        return if silent(&replay) {
            Ok(())
        } else {
            Err("the component has outputs".to_owned())
        };
    }
    let mut replay = closed.play(steps, Until::Before(component))?;
    closed.check_assumptions(&[component], steps, last)?;
    let inputs = replay.inputs(component, &steps[last]);
    match replay.answer(component, &inputs) {
        None => Ok(()),
        Some(_) => Err("the component has an answer".to_owned()),
    }
}

/// Checks that a run proves that an obligation is not met.
///
/// # Errors
/// If the run does not prove this; the text states what is wrong with it.
pub fn check_open(closed: &ClosedComposition<'_>, found: &Open) -> Result<(), String> {
    let what = closed.formula(found.what);
    match &found.why {
        Refutation::Trace(steps) => {
            let until = found.what.component.map_or(Until::End, Until::Before);
            closed.play(steps, until)?;
            let last = steps.len() - 1;
            if holds_at(found.what.kind, what, steps, last) {
                return Err(format!("the last step keeps {}", what.name));
            }
            let exported =
                found.what.component.is_some() && closed.is_exported(found.what.kind, what);
            if exported && closed.is_outside(steps, last) {
                return Err(
                    "the caller is responsible for the assumption in the last step".to_owned(),
                );
            }
            Ok(())
        }
        Refutation::Lasso(run) => {
            closed.play_for_ever(run)?;
            if keeps_formula(found.what.kind, what, run) {
                return Err(format!("the run keeps {}", what.name));
            }
            Ok(())
        }
    }
}

/// Checks that a run proves that an operation does not run as declared. For an operation that never
/// begins there is no run, and nothing is checked.
///
/// # Errors
/// If the run does not prove this; the text states what is wrong with it.
pub fn check_operation_failure(
    closed: &ClosedComposition<'_>,
    found: &OperationFailure,
) -> Result<(), String> {
    let operation = &closed.machine.operations[found.operation];
    let mut plant = closed.machine.plant.iter();
    let wire = plant.position(|p| matches!(p.source, PlantSource::Operation));
    let runs = |values: &[i64]| wire.is_none_or(|w| values[w] == operation.value);
    match &found.why {
        FailureKind::NeverBegins(_) => Ok(()),
        FailureKind::Order(steps) => {
            closed.play(steps, Until::End)?;
            let last = steps.len() - 1;
            let (active, begun) = closed.count_actions(steps, last);
            let named = begun.checked_sub(1).and_then(|b| operation.sequence.get(b));
            let right = active.is_none() || active == named.copied();
            let ends = closed.is_done(&steps[last]) && begun != operation.sequence.len();
            if runs(&steps[last]) && (!right || ends) {
                Ok(())
            } else {
                Err("the last step is as the operation declares".to_owned())
            }
        }
        FailureKind::Endless(run) => {
            closed.play_for_ever(run)?;
            if run.cycle.iter().all(|v| runs(v) && !closed.is_done(v)) {
                Ok(())
            } else {
                Err("the operation ends, or another one runs".to_owned())
            }
        }
    }
}
