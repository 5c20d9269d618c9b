//! Merges several coordinators into one: their contracts side by side, and the product of their
//! machines.
//!
//! Coordinators set their outputs before they read the inputs of the step, so none waits for
//! another, and a joint step consists of one step of each. The wires of the merged machine are
//! those of the original machine, in the same order. The merged machine has a single coordinator,
//! so all checks of a machine's composition apply unchanged.
//!
//! A single coordinator derives the operation in progress from its own state. Each of several
//! coordinators tracks only its own jobs, so the plain product would reach states in which two jobs
//! run at once. The state of the product therefore includes the operation, which stays until it is
//! done.

use super::{Composition, Discharger};
use linewright_core::gr1::{
    Domain, Expr, Formula, FormulaKind, Owner, Side, Specification, Timing, VarId, Variable,
};
use linewright_language::contract::machine::{Component, Machine, PlantSource, Role};
use linewright_solver::mealy::{self, Cube, Guard, Test, Transition};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Maximum number of states of a product.
const MAX_STATES: usize = 20_000;

/// Separator between a coordinator's name and the name of its formula.
const SEPARATOR: &str = ": ";

/// A machine with one coordinator in place of several.
pub(super) struct MergedMachine {
    /// The merged machine.
    pub machine: Machine,
    /// The coordinator's machine.
    pub coordinator: mealy::Machine,
}

/// Whether a machine has more than one coordinator.
pub(super) fn has_several(machine: &Machine) -> bool {
    coordinators(machine) > 1
}

fn coordinators(machine: &Machine) -> usize {
    let roles = machine.components.iter();
    roles.take_while(|c| c.role == Role::Coordinator).count()
}

/// Merges the coordinators of a machine. `None` if the product has too many states, a coordinator's
/// controller does not have explicit states, or the machine has no plant inputs.
pub(super) fn merge(
    machine: &Machine,
    controllers: &[&mealy::Controller],
) -> Option<MergedMachine> {
    let count = coordinators(machine);
    let machines: Vec<&mealy::Machine> = controllers[..count]
        .iter()
        .map(|c| c.machine())
        .collect::<Option<_>>()?;
    let components = &machine.components[..count];
    let mut merged = machine.clone();
    merged.components.drain(..count);
    let wire = &machine.plant.first()?.domain;
    merged.components.insert(0, component(components, wire));
    for operation in &mut merged.operations {
        for action in &mut operation.sequence {
            *action -= count - 1;
        }
    }
    Some(MergedMachine {
        machine: merged,
        coordinator: product(machine, &machines)?,
    })
}

/// Joins the coordinators into one component, with their contracts side by side.
fn component(components: &[Component], domain: &Domain) -> Component {
    let mut specification = Specification {
        name: String::new(),
        timing: Timing::Moore,
        variables: Vec::new(),
        assumptions: Side::default(),
        guarantees: Side::default(),
    };
    for c in components {
        let first = specification.variables.len() as u32;
        let own = &c.specification;
        specification
            .variables
            .extend(own.variables.iter().cloned());
        let sides = [
            (&own.assumptions, &mut specification.assumptions),
            (&own.guarantees, &mut specification.guarantees),
        ];
        for (from, to) in sides {
            let moved = |formulas: &[Formula]| -> Vec<Formula> {
                let moved = formulas.iter().map(|f| Formula {
                    name: format!("{}{SEPARATOR}{}", c.name, f.name),
                    expr: f
                        .expr
                        .substitute(&mut |v, time| Expr::Var(VarId(v.0 + first), time)),
                    ..f.clone()
                });
                moved.collect()
            };
            for kind in FormulaKind::ALL {
                to.list_mut(kind).extend(moved(from.list(kind)));
            }
        }
    }
    // An additional input, bound to the wire of the running operation.
    specification.variables.push(Variable {
        name: "operation".to_owned(),
        owner: Owner::Environment,
        internal: false,
        domain: domain.clone(),
        unit: String::new(),
        span: components[0].span,
    });
    let names: Vec<&str> = components.iter().map(|c| c.name.as_str()).collect();
    let bindings = components
        .iter()
        .flat_map(|c| c.bindings.clone())
        .chain([Expr::now(VarId(0))]);
    Component {
        name: names.join(", "),
        specification: Arc::new(specification),
        bindings: bindings.collect(),
        ..components[0].clone()
    }
}

/// The machine whose state combines a state of each coordinator with the running operation.
struct Product<'a> {
    machines: &'a [&'a mealy::Machine],
    operations: Operations,
    numbers: BTreeMap<Place, usize>,
    open: Vec<Place>,
}

/// A state of each coordinator, and the operation in progress.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    states: Vec<usize>,
    running: Option<i64>,
}

/// The wire of the running operation.
struct Operations {
    /// Values of the wire; empty for a machine without operations.
    values: Vec<i64>,
    /// Values that stand for operations.
    requested: Vec<i64>,
    /// Condition over the wires under which the operation is done.
    done: Expr,
    /// First wire of the coordinators.
    first: usize,
    /// Index of the wire among the inputs.
    input: usize,
}

impl Operations {
    fn of(machine: &Machine, inputs: usize) -> Self {
        let wire = machine
            .plant
            .first()
            .filter(|p| matches!(p.source, PlantSource::Operation));
        Self {
            values: wire.map_or_else(Vec::new, |p| (p.domain.low()..=p.domain.high()).collect()),
            requested: machine.operations.iter().map(|o| o.value).collect(),
            done: machine.done.clone().unwrap_or(Expr::FALSE),
            first: machine.plant.len(),
            input: inputs,
        }
    }

    /// Returns the operation that is still in progress after a step in which the coordinators have
    /// these outputs. `None` if the operation is done, or if `operation` is not the value of an
    /// operation.
    fn after(&self, operation: i64, outputs: &[i64]) -> Option<i64> {
        let done = self.done.substitute(&mut |v, time| {
            let place = v.index().checked_sub(self.first);
            match place.and_then(|p| outputs.get(p)) {
                Some(value) => Expr::Const(*value),
                None => Expr::Var(v, time),
            }
        });
        let continues = done.simplify() == Expr::FALSE && self.requested.contains(&operation);
        continues.then_some(operation)
    }
}

/// A joint step of the coordinators that are combined so far.
struct Partial {
    guard: Vec<Cube>,
    output: Vec<i64>,
    states: Vec<usize>,
}

fn product(machine: &Machine, machines: &[&mealy::Machine]) -> Option<mealy::Machine> {
    let mut inputs: Vec<mealy::Port> = machines.iter().flat_map(|m| m.inputs.clone()).collect();
    let mut product = Product {
        machines,
        operations: Operations::of(machine, inputs.len()),
        numbers: BTreeMap::new(),
        open: Vec::new(),
    };
    if let Some(wire) = machine.plant.first() {
        inputs.push(mealy::Port {
            name: wire.name.clone(),
            domain: wire.domain.clone(),
            unit: String::new(),
            internal: false,
        });
    }
    let initial = product.steps(None);
    let mut states: Vec<Vec<Transition>> = Vec::new();
    while let Some(place) = product.open.get(states.len()).cloned() {
        if product.open.len() > MAX_STATES {
            return None;
        }
        states.push(product.steps(Some(&place)));
    }
    Some(mealy::Machine {
        name: String::new(),
        timing: Timing::Moore,
        inputs,
        outputs: machines.iter().flat_map(|m| m.outputs.clone()).collect(),
        initial,
        states,
        goals: Vec::new(),
    })
}

impl Product<'_> {
    /// Returns the transitions from a place; for `None`, the initial transitions. New places are
    /// numbered in order of discovery.
    fn steps(&mut self, from: Option<&Place>) -> Vec<Transition> {
        let values = match from.and_then(|f| f.running) {
            Some(value) => vec![Some(value)],
            None if self.operations.values.is_empty() => vec![None],
            None => self.operations.values.iter().copied().map(Some).collect(),
        };
        let mut transitions = Vec::new();
        for partial in self.together(from) {
            for value in &values {
                let mut guard = partial.guard.clone();
                if let Some(value) = value {
                    for cube in &mut guard {
                        cube.0.push(Test {
                            input: self.operations.input,
                            low: *value,
                            high: *value,
                        });
                    }
                }
                let running = value.and_then(|v| self.operations.after(v, &partial.output));
                transitions.push(Transition {
                    guard: Guard(guard),
                    output: partial.output.clone(),
                    to: self.number(Place {
                        states: partial.states.clone(),
                        running,
                    }),
                });
            }
        }
        transitions
    }

    fn number(&mut self, place: Place) -> usize {
        let next = self.numbers.len();
        *self.numbers.entry(place.clone()).or_insert_with(|| {
            self.open.push(place);
            next
        })
    }

    /// Returns all combinations of one step per coordinator.
    fn together(&self, from: Option<&Place>) -> Vec<Partial> {
        let mut partial = vec![Partial {
            guard: vec![Cube(Vec::new())],
            output: Vec::new(),
            states: Vec::new(),
        }];
        let mut first = 0;
        for (i, machine) in self.machines.iter().enumerate() {
            let mut longer = Vec::new();
            for before in &partial {
                for own in machine.transitions(from.map(|f| f.states[i])) {
                    let mut states = before.states.clone();
                    states.push(own.to);
                    longer.push(Partial {
                        guard: both(&before.guard, &own.guard.0, first),
                        output: before.output.iter().chain(&own.output).copied().collect(),
                        states,
                    });
                }
            }
            partial = longer;
            first += machine.inputs.len();
        }
        partial
    }
}

/// Returns the conjunction of two guards. The inputs of the second guard are offset by `first`.
fn both(a: &[Cube], b: &[Cube], first: usize) -> Vec<Cube> {
    let mut found = Vec::with_capacity(a.len() * b.len());
    for x in a {
        for y in b {
            let shifted = y.0.iter().map(|t| Test {
                input: t.input + first,
                ..t.clone()
            });
            found.push(Cube(x.0.iter().cloned().chain(shifted).collect()));
        }
    }
    found
}

/// Attributes results about the merged machine to the individual coordinators.
pub(super) fn attribute(result: &mut Composition, merged: &Machine) {
    let merged_name = &merged.components[0].name;
    for discharge in &mut result.discharges {
        if discharge.component == *merged_name
            && let Some((component, assumption)) = discharge.assumption.split_once(SEPARATOR)
        {
            discharge.component = component.to_owned();
            discharge.assumption = assumption.to_owned();
        }
        if let Discharger::Guarantee(names) = &mut discharge.by {
            *names = names.replace(&format!("{merged_name}{SEPARATOR}"), "");
        }
    }
}
