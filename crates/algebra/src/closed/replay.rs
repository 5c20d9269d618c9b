//! Evaluator of runs of a closed composition: steps the controllers themselves and evaluates
//! formulas on plain values. It relies on no rule of `rules.rs` and on no decision diagram.

use super::{Closed, FailureKind, OperationFailure, StuckComponent};
use crate::proof::{Exports, Open, Refutation};
use crate::replay::{formula, holds_at, keeps_formula};
use crate::system::{FormulaRef, formulas, list};
use linewright_core::gr1::{Formula, Timing, eval};
use linewright_language::contract::machine::PlantSource;
use linewright_solver::game::{Lasso, RuleKind};
use linewright_solver::mealy::{Controller, functions};

/// Maximum number of repetitions of a cycle until functions return to an earlier state.
const MOST_ROUNDS: usize = 1_000;

/// State of a controller.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Place {
    Table(Option<usize>),
    Functions(functions::State),
}

/// Controllers stepped side by side.
struct Playing<'a> {
    closed: &'a Closed<'a>,
    places: Vec<Place>,
}

/// How far a step is played.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Until {
    /// All components answer.
    End,
    /// Only the components before this one answer.
    Before(usize),
}

impl<'a> Playing<'a> {
    fn new(closed: &'a Closed<'a>) -> Self {
        let places = closed.controllers.iter().map(|c| match c {
            Controller::Machine(_) => Place::Table(None),
            Controller::Functions(functions) => Place::Functions(functions.start()),
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

    /// Returns the wires of a component.
    fn outputs<'v>(&self, component: usize, values: &'v [i64]) -> &'v [i64] {
        let first = self.closed.taking[component].first;
        &values[first..first + self.closed.controllers[component].outputs().len()]
    }

    /// Returns the outputs of a component that answers first; `None` if it has none.
    fn spoken(&self, component: usize) -> Option<Vec<i64>> {
        match (self.closed.controllers[component], &self.places[component]) {
            (Controller::Machine(table), Place::Table(at)) => {
                let rows = table.transitions(*at);
                rows.first().map(|row| row.output.clone())
            }
            (Controller::Functions(functions), Place::Functions(state)) => {
                Some(functions.moore_output(state))
            }
            _ => None,
        }
    }

    /// Returns a component's answer and advances it; `None` if it has none.
    fn answer(&mut self, component: usize, inputs: &[i64]) -> Option<Vec<i64>> {
        match (
            self.closed.controllers[component],
            &mut self.places[component],
        ) {
            (Controller::Machine(table), Place::Table(at)) => {
                let row = table.step(*at, inputs)?;
                *at = Some(row.to);
                Some(row.output.clone())
            }
            (Controller::Functions(functions), Place::Functions(state)) => {
                functions.step(state, inputs).ok()
            }
            _ => None,
        }
    }

    /// Plays a step with these values.
    fn step(&mut self, values: &[i64], until: Until) -> Result<(), String> {
        let name = |c: usize| &self.closed.machine.components[c].name;
        let order = self.closed.order();
        let timing = |c: usize| self.closed.controllers[c].timing();
        for component in order.iter().filter(|c| timing(**c) == Timing::Moore) {
            let spoken = self
                .spoken(*component)
                .ok_or_else(|| format!("{} has no answer", name(*component)))?;
            if spoken != self.outputs(*component, values) {
                return Err(format!("{} answers first otherwise", name(*component)));
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
                return Err(format!("{name} answers otherwise"));
            }
            let taking = &self.closed.taking[component];
            if let (Some(state), Some(states), Place::Table(Some(at))) =
                (taking.state, &taking.states, &self.places[component])
            {
                let number = states.number(self.outputs(component, values), *at);
                if number.map(|n| n as i64) != Some(values[state.index()]) {
                    return Err(format!("the table of {name} is in another state"));
                }
            }
        }
        Ok(())
    }
}

impl Closed<'_> {
    /// Checks that the environment keeps its part in a step, and that the values of monitors and
    /// watches are correct.
    fn surroundings(&self, steps: &[Vec<i64>], at: usize) -> Result<(), String> {
        let values = self.system.variables.iter().zip(&steps[at]);
        if let Some((v, value)) = values.into_iter().find(|(v, x)| !v.domain.contains(**x)) {
            return Err(format!("{value} is not a value of {}", v.name));
        }
        let beside = &self.system.parts[self.taking.len()..];
        let sides = beside.iter().map(|p| &p.definitions);
        for side in sides.chain([&self.claim.given]) {
            for (kind, _, formula) in formulas(side) {
                if !holds_at(kind, formula, steps, at) {
                    return Err(format!("step {at} breaks {}", formula.name));
                }
            }
        }
        self.remembered(steps, at)
    }

    /// Recounts the actions and compares with the watch.
    fn remembered(&self, steps: &[Vec<i64>], at: usize) -> Result<(), String> {
        let Some(watch) = &self.watch else {
            return Ok(());
        };
        let (_, begun) = self.counted(steps, at);
        let longest = self.machine.operations.iter().map(|o| o.sequence.len());
        let begun = begun.min(longest.max().unwrap_or(0) + 1);
        if steps[at][watch.begun.index()] == begun as i64 {
            Ok(())
        } else {
            Err(format!("in step {at} another number of actions has begun"))
        }
    }

    fn is_done(&self, values: &[i64]) -> bool {
        let done = self.machine.done.as_ref();
        done.is_some_and(|d| eval::holds(d, values, &[]))
    }

    /// Returns the active component in a step, and how many actions have begun in the call so far.
    fn counted(&self, steps: &[Vec<i64>], at: usize) -> (Option<usize>, usize) {
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
    fn handed_on(&self, steps: &[Vec<i64>], at: usize) -> Result<(), String> {
        for component in 0..self.taking.len() {
            for (what, formula) in self.assumed(component) {
                if self.is_exported(what.kind, formula)
                    && self.is_outside(steps, at)
                    && !holds_at(what.kind, formula, steps, at)
                {
                    return Err(format!(
                        "step {at} breaks {}, which is handed on",
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
    fn assumptions(&self, of: &[usize], steps: &[Vec<i64>], at: usize) -> Result<(), String> {
        for component in of {
            for (what, formula) in self.assumed(*component) {
                if !holds_at(what.kind, formula, steps, at) {
                    return Err(format!("step {at} breaks {}", formula.name));
                }
            }
        }
        Ok(())
    }

    /// Steps the controllers along a run. It must be free of errors, in the last step as far as
    /// `until`, whose own assumptions are not checked.
    fn play(&self, steps: &[Vec<i64>], until: Until) -> Result<Playing<'_>, String> {
        let mut playing = Playing::new(self);
        let Some(last) = steps.len().checked_sub(1) else {
            return Err("it has no step".to_owned());
        };
        let order = self.order();
        for (at, values) in steps.iter().enumerate() {
            self.surroundings(steps, at)?;
            let (asked, until) = match until {
                Until::Before(component) if at == last => {
                    self.handed_on(steps, at)?;
                    let place = order.iter().position(|c| *c == component);
                    (&order[..place.unwrap_or(0)], until)
                }
                _ => (&order[..], Until::End),
            };
            self.assumptions(asked, steps, at)?;
            playing
                .step(values, until)
                .map_err(|e| format!("step {at}: {e}"))?;
        }
        Ok(playing)
    }

    /// Steps the controllers along an infinite run.
    fn play_for_ever(&self, run: &Lasso) -> Result<(), String> {
        if run.cycle.is_empty() {
            return Err("it has no cycle".to_owned());
        }
        let mut steps: Vec<Vec<i64>> = run.prefix.iter().chain(&run.cycle).cloned().collect();
        let mut playing = self.play(&steps, Until::End)?;
        // Enter the cycle once more: monitors and assumptions must fit there as well.
        steps.push(run.cycle[0].clone());
        self.surroundings(&steps, steps.len() - 1)?;
        self.assumptions(&self.order(), &steps, steps.len() - 1)?;
        let mut seen = Vec::new();
        for _ in 0..MOST_ROUNDS {
            if seen.contains(&playing.places) {
                let mut justice = self.claim.given.justice.iter();
                return match justice.find(|f| !keeps_formula(RuleKind::Justice, f, run)) {
                    Some(starved) => Err(format!("it starves {}", starved.name)),
                    None => self.justice_handed_on(run),
                };
            }
            seen.push(playing.places.clone());
            for values in &run.cycle {
                playing.step(values, Until::End)?;
            }
        }
        Err("the controllers do not come back to where they were".to_owned())
    }

    fn justice_handed_on(&self, run: &Lasso) -> Result<(), String> {
        for component in 0..self.taking.len() {
            for formula in list(&self.part(component).assumptions, RuleKind::Justice) {
                if self.is_exported(RuleKind::Justice, formula)
                    && !keeps_formula(RuleKind::Justice, formula, run)
                {
                    return Err(format!("it starves {}", formula.name));
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
/// the step.
///
/// # Errors
/// What is wrong with the run, as text.
pub fn stuck(closed: &Closed<'_>, found: &StuckComponent) -> Result<(), String> {
    let steps = &found.trace;
    let component = found.component;
    let last = steps.len().saturating_sub(1);
    let silent = |playing: &Playing<'_>| {
        closed.controllers[component].timing() == Timing::Moore
            && playing.spoken(component).is_none()
    };
    if found.silent {
        let playing = match last {
            0 => Playing::new(closed),
            _ => closed.play(&steps[..last], Until::End)?,
        };
        return if silent(&playing) {
            Ok(())
        } else {
            Err("it has outputs".to_owned())
        };
    }
    let mut playing = closed.play(steps, Until::Before(component))?;
    closed.assumptions(&[component], steps, last)?;
    let inputs = playing.inputs(component, &steps[last]);
    match playing.answer(component, &inputs) {
        None => Ok(()),
        Some(_) => Err("it has an answer".to_owned()),
    }
}

/// Checks that a run shows an obligation not to be met.
///
/// # Errors
/// What is wrong with the run, as text.
pub fn open(closed: &Closed<'_>, found: &Open) -> Result<(), String> {
    let what = closed.formula(found.what);
    match &found.why {
        Refutation::Trace(steps) => {
            let until = found.what.part.map_or(Until::End, Until::Before);
            closed.play(steps, until)?;
            let last = steps.len() - 1;
            if holds_at(found.what.kind, what, steps, last) {
                return Err(format!("the last step keeps {}", what.name));
            }
            let exported = found.what.part.is_some() && closed.is_exported(found.what.kind, what);
            if exported && closed.is_outside(steps, last) {
                return Err("it is the caller's own choice".to_owned());
            }
            Ok(())
        }
        Refutation::Lasso(run) => {
            closed.play_for_ever(run)?;
            if keeps_formula(found.what.kind, what, run) {
                return Err(format!("it keeps {}", what.name));
            }
            Ok(())
        }
    }
}

/// Checks that a run shows an operation not to run as declared. No run can show that an operation
/// never begins.
///
/// # Errors
/// What is wrong with the run, as text.
pub fn misrun(closed: &Closed<'_>, found: &OperationFailure) -> Result<(), String> {
    let operation = &closed.machine.operations[found.operation];
    let mut plant = closed.machine.plant.iter();
    let wire = plant.position(|p| matches!(p.source, PlantSource::Operation));
    let runs = |values: &[i64]| wire.is_none_or(|w| values[w] == operation.value);
    match &found.why {
        FailureKind::NeverBegins(_) => Ok(()),
        FailureKind::Order(steps) => {
            closed.play(steps, Until::End)?;
            let last = steps.len() - 1;
            let (active, begun) = closed.counted(steps, last);
            let named = begun.checked_sub(1).and_then(|b| operation.sequence.get(b));
            let right = active.is_none() || active == named.copied();
            let ends = closed.is_done(&steps[last]) && begun != operation.sequence.len();
            if runs(&steps[last]) && (!right || ends) {
                Ok(())
            } else {
                Err("the last step is as the operation says".to_owned())
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
