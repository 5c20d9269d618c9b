//! An independent closed composition: every state and every choice from outside, one by one. It
//! uses tables and formulas, and shares only the evaluation of expressions with the code it is
//! compared with.

use linewright::algebra::closed::ClosedComposition;

use linewright::contract::machine::{Machine, PlantSource};
use linewright::gr1::{Expr, FormulaKind, Owner, Specification, Timing, eval};
use linewright::mealy;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of states.
const MOST_STATES: usize = 60_000;

/// A state: all wires, positions of all tables and scripts, and the number of actions begun.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct State {
    pub wires: Vec<i64>,
    pub tables: Vec<usize>,
    scripts: Vec<usize>,
    begun: usize,
}

/// Result of the exploration.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Assumptions that are violated: component and name.
    pub open: BTreeSet<(usize, String)>,
    /// Rules of the machine that are violated.
    pub broken: BTreeSet<String>,
    /// Components without an answer.
    pub stuck: BTreeSet<usize>,
    /// Operations that cannot begin, do not run what they name, or never end.
    pub never: BTreeSet<usize>,
    pub order: BTreeSet<usize>,
    pub endless: BTreeSet<usize>,
    /// Whether all requests complete.
    pub completes: bool,
    /// Number of states.
    pub states: usize,
}

pub struct Brute<'a> {
    pub machine: &'a Machine,
    pub tables: &'a [&'a mealy::Machine],
    pub closed: &'a ClosedComposition<'a>,
}

/// Result of one choice from outside.
enum Step {
    /// Not allowed to the environment.
    Void,
    /// Something goes wrong.
    Wrong,
    /// Nothing goes wrong.
    Well(State),
}

impl Brute<'_> {
    pub fn explore(&self) -> Option<Found> {
        let mut found = Found::default();
        let mut numbers: BTreeMap<State, usize> = BTreeMap::new();
        let mut states: Vec<State> = Vec::new();
        let mut edges: Vec<Vec<usize>> = Vec::new();
        let mut begun = BTreeSet::new();
        let mut queue = vec![None];
        while let Some(from) = queue.pop() {
            let before: Option<State> = from.map(|f: usize| states[f].clone());
            for plant in self.choices(before.as_ref()) {
                let Step::Well(next) = self.step(before.as_ref(), plant, &mut found) else {
                    continue;
                };
                if self.begins(before.as_ref()) {
                    begun.extend(self.operation(&next));
                }
                let number = *numbers.entry(next.clone()).or_insert_with(|| {
                    states.push(next);
                    edges.push(Vec::new());
                    queue.push(Some(states.len() - 1));
                    states.len() - 1
                });
                if let Some(from) = from {
                    edges[from].push(number);
                }
                if states.len() > MOST_STATES {
                    return None;
                }
            }
        }
        found.states = states.len();
        self.conclude(&states, &edges, &begun, &mut found);
        Some(found)
    }

    fn is_done(&self, state: &State) -> bool {
        let done = self.machine.done.as_ref();
        done.is_some_and(|d| eval::holds(d, &state.wires, &[]))
    }

    fn begins(&self, before: Option<&State>) -> bool {
        before.is_none_or(|b| self.is_done(b))
    }

    /// The operation that runs.
    fn operation(&self, state: &State) -> Option<usize> {
        let mut plant = self.machine.plant.iter();
        let wire = plant.position(|p| matches!(p.source, PlantSource::Operation))?;
        let mut operations = self.machine.operations.iter();
        operations.position(|o| o.value == state.wires[wire])
    }

    /// All choices from outside, with the positions of scripts.
    fn choices(&self, before: Option<&State>) -> Vec<(Vec<i64>, Vec<usize>)> {
        let free = self.machine.done.is_none();
        let begins = self.begins(before);
        let mut all = vec![(Vec::new(), Vec::new())];
        for (wire, input) in self.machine.plant.iter().enumerate() {
            let every: Vec<i64> = (input.domain.low()..=input.domain.high()).collect();
            let held = before.map(|b| b.wires[wire]);
            let (values, place) = match &input.source {
                _ if free => (every, None),
                PlantSource::Signal { script } => {
                    let last = before.map_or(0, |b| b.scripts[wire]);
                    let place = if begins { 0 } else { (last + 1) % script.len() };
                    (vec![script[place]], Some(place))
                }
                PlantSource::Operation if begins => {
                    let operations = self.machine.operations.iter();
                    (operations.map(|o| o.value).collect(), None)
                }
                PlantSource::Property(_) if begins => (every, None),
                _ => (held.into_iter().collect(), None),
            };
            let mut more = Vec::new();
            for (wires, scripts) in &all {
                for value in &values {
                    let (mut wires, mut scripts): (Vec<i64>, Vec<usize>) =
                        (wires.clone(), scripts.clone());
                    wires.push(*value);
                    scripts.push(place.unwrap_or(0));
                    more.push((wires, scripts));
                }
            }
            all = more;
        }
        all
    }

    fn inputs(&self, component: usize, wires: &[i64]) -> Vec<i64> {
        let bindings = self.machine.components[component].bindings.iter();
        bindings.map(|b: &Expr| eval::eval(b, wires, &[])).collect()
    }

    /// The values of a component's own variables.
    fn own(&self, component: usize, wires: &[i64]) -> Vec<i64> {
        let specification: &Specification = &self.machine.components[component].specification;
        let mut inputs = self.inputs(component, wires).into_iter();
        let mut wire = self.machine.first_wire(component);
        let values = specification.variables.iter().map(|v| {
            if v.owner == Owner::Environment {
                inputs.next().expect("an input")
            } else {
                wire += 1;
                wires[wire - 1]
            }
        });
        values.collect()
    }

    /// The assumptions of a component that are violated in a step: those of the caller, and the
    /// others.
    fn broken(&self, component: usize, before: Option<&State>, wires: &[i64]) -> [Vec<String>; 2] {
        let side = &self.machine.components[component].specification.assumptions;
        let now = self.own(component, wires);
        let then = before.map(|b| self.own(component, &b.wires));
        let mut found = [Vec::new(), Vec::new()];
        for (kind, _, formula) in self.closed.system.components[component]
            .assumptions
            .formulas()
        {
            let own = [&side.initial, &side.invariants, &side.safety]
                .into_iter()
                .flatten()
                .find(|f| f.name == formula.name && f.span == formula.span);
            let Some(own) = own else { continue };
            let expr = &own.expr;
            let holds = match (side.initial.contains(own), side.safety.contains(own), &then) {
                (true, _, None) | (false, false, _) => eval::holds(expr, &now, &[]),
                (false, true, Some(then)) => eval::holds(expr, then, &now),
                _ => true,
            };
            if !holds {
                let outside = self.closed.is_exported(kind, formula)
                    && (self.machine.done.is_none() || self.begins(before));
                found[usize::from(!outside)].push(formula.name.clone());
            }
        }
        found
    }

    fn step(
        &self,
        before: Option<&State>,
        (plant, scripts): (Vec<i64>, Vec<usize>),
        found: &mut Found,
    ) -> Step {
        let count = self.tables.len();
        let mut wires = plant;
        wires.resize(self.machine.wire_count(), 0);
        let at = |c: usize| before.map(|b| b.tables[c]);
        let is_moore = |c: usize| self.tables[c].timing == Timing::Moore;
        for c in (0..count).filter(|c| is_moore(*c)) {
            let Some(row) = self.tables[c].transitions(at(c)).first() else {
                found.stuck.insert(c);
                return Step::Wrong;
            };
            let first = self.machine.first_wire(c);
            wires[first..first + row.output.len()].copy_from_slice(&row.output);
        }
        let mut tables = vec![0; count];
        let mut wrong: Vec<(usize, Option<String>)> = Vec::new();
        let order = (0..count).filter(|c| !is_moore(*c));
        for c in order.chain((0..count).filter(|c| is_moore(*c))) {
            let [outside, inside] = self.broken(c, before, &wires);
            if !outside.is_empty() {
                return Step::Void;
            }
            // The caller's are examined as far as possible even if something went wrong before.
            if !wrong.is_empty() {
                continue;
            }
            let inputs = self.inputs(c, &wires);
            let row = self.tables[c].step(at(c), &inputs);
            wrong.extend(inside.into_iter().map(|name| (c, Some(name))));
            let Some(row) = row else {
                if wrong.is_empty() {
                    wrong.push((c, None));
                }
                continue;
            };
            tables[c] = row.to;
            let first = self.machine.first_wire(c);
            wires[first..first + row.output.len()].copy_from_slice(&row.output);
        }
        for (c, name) in &wrong {
            match name {
                Some(name) => found.open.insert((*c, name.clone())),
                None => found.stuck.insert(*c),
            };
        }
        if !wrong.is_empty() {
            return Step::Wrong;
        }
        let active = self.active(&wires);
        let fresh = self.begins(before);
        let earlier = before.filter(|_| !fresh);
        let was = earlier.and_then(|b| self.active(&b.wires));
        let begun = earlier.map_or(0, |b| b.begun) + usize::from(active.is_some() && active != was);
        let longest = self.machine.operations.iter().map(|o| o.sequence.len());
        Step::Well(State {
            begun: begun.min(longest.max().map_or(0, |l| l + 1)),
            wires,
            tables,
            scripts,
        })
    }

    fn active(&self, wires: &[i64]) -> Option<usize> {
        let mut components = self.machine.components.iter();
        components.position(|c| {
            c.active
                .as_ref()
                .is_some_and(|a| eval::holds(a, wires, &[]))
        })
    }

    fn conclude(
        &self,
        states: &[State],
        edges: &[Vec<usize>],
        begun: &BTreeSet<usize>,
        found: &mut Found,
    ) {
        let starves = |goal: &dyn Fn(&State) -> bool| {
            let mut left: BTreeSet<usize> =
                (0..states.len()).filter(|s| !goal(&states[*s])).collect();
            loop {
                let stays = |s: &usize| edges[*s].iter().any(|t| left.contains(t));
                let fewer: BTreeSet<usize> = left.iter().copied().filter(|s| stays(s)).collect();
                if fewer.len() == left.len() {
                    return !left.is_empty();
                }
                left = fewer;
            }
        };
        found.completes = self.machine.done.is_none() || !starves(&|s| self.is_done(s));
        for (c, component) in self.machine.components.iter().enumerate() {
            let over_wires = &self.closed.system.components[c].assumptions.justice;
            let justice = &component.specification.assumptions.justice;
            for (formula, over_wires) in justice.iter().zip(over_wires) {
                // What the environment ensures is not examined.
                if self.closed.is_exported(FormulaKind::Justice, over_wires) {
                    continue;
                }
                if starves(&|s| eval::holds(&formula.expr, &self.own(c, &s.wires), &[])) {
                    found.open.insert((c, formula.name.clone()));
                }
            }
        }
        let side = &self.machine.guarantees.side;
        for rule in &side.invariants {
            if states
                .iter()
                .any(|s| !eval::holds(&rule.expr, &s.wires, &[]))
            {
                found.broken.insert(rule.name.clone());
            }
        }
        for rule in &side.safety {
            let mut steps = (0..states.len()).flat_map(|s| edges[s].iter().map(move |t| (s, *t)));
            if steps.any(|(s, t)| !eval::holds(&rule.expr, &states[s].wires, &states[t].wires)) {
                found.broken.insert(rule.name.clone());
            }
        }
        for (o, operation) in self.machine.operations.iter().enumerate() {
            let here = |s: &State| self.operation(s) == Some(o);
            let wrong = |s: &State| {
                let active = self.active(&s.wires);
                let named = s
                    .begun
                    .checked_sub(1)
                    .and_then(|b| operation.sequence.get(b));
                (active.is_some() && active != named.copied())
                    || (self.is_done(s) && s.begun != operation.sequence.len())
            };
            if !begun.contains(&o) {
                found.never.insert(o);
            } else if states.iter().any(|s| here(s) && wrong(s)) {
                found.order.insert(o);
            } else if starves(&|s| self.is_done(s) || !here(s)) {
                found.endless.insert(o);
            }
        }
    }
}
